/* Quadratic Hamiltonians and Lagrangians with random integers: the rows against the
 * matrices; tangent vectors against the differentials they shall annihilate. */
#include <stdlib.h>

#include "check.h"
#include "cofactors.h"
#include "derive.h"
#include "form.h"
#include "probe.h"

enum { K = 3, N = 2 * K };

static long next(unsigned long *seed, long n)
{
    *seed = *seed * 6364136223846793005ul + 1442695040888963407ul;
    return (long)((*seed >> 33) % (unsigned long)(2 * n + 1)) - n;
}

static expr_id entry_of(const struct sys_system *s, int row, int col)
{
    const struct sys_row *r = s->row + row;
    for (int k = 0; k < r->entries; k++)
        if (r->entry[k].col == col)
            return r->entry[k].value;
    return expr_int(s->store, 0);
}

static void names(struct expr_store *st, char letter, int n, int *symbol)
{
    for (int i = 0; i < n; i++) {
        char name[] = { letter, (char)('0' + i), 0 };
        symbol[i] = st->node[expr_symbol_add(st, name, EXPR_VARIABLE)].a;
    }
}

/* sum h_ij x_i x_j */
static expr_id quadratic(struct expr_store *st, unsigned long *seed, const int *x, const int *y)
{
    expr_id sum = expr_int(st, 0);
    for (int i = 0; i < K; i++)
        for (int j = 0; j < K; j++)
            sum = expr_add(st, sum, expr_mul(st, expr_int(st, next(seed, 3)),
                                             expr_mul(st, st->symbol[x[i]].node, st->symbol[y[j]].node)));
    return sum;
}

static bool equal(struct expr_store *st, expr_id a, expr_id b)
{
    struct form_probe p;
    form_probe_init(&p);
    bool zero = form_probe_zero(&p, st, expr_sub(st, a, b));
    form_probe_clear(&p);
    return zero;
}

/* A row w^T (Omega^T x' - grad H) tells w: its entry at p_i is -w_i, at q_i it is w_{k+i}. */
static void hamiltonian(unsigned long *seed, int restrictions)
{
    struct expr_store st;
    struct sys_system s;
    int x[N];
    long R[N][N];
    expr_id restriction[N], zero;
    expr_store_init(&st);
    sys_init(&s, &st);
    zero = expr_int(&st, 0);
    names(&st, 'x', N, x);
    expr_id H = expr_add(&st, quadratic(&st, seed, x, x), expr_add(&st, quadratic(&st, seed, x, x + K),
                                                                  quadratic(&st, seed, x + K, x + K)));
    for (int a = 0; a < restrictions; a++) {
        restriction[a] = zero;
        for (int j = 0; j < N; j++) {
            R[a][j] = j == a ? 1 : j < a ? 0 : next(seed, 2);
            restriction[a] = expr_add(&st, restriction[a],
                                      expr_mul(&st, expr_int(&st, R[a][j]), st.symbol[x[j]].node));
        }
    }
    struct form_hamiltonian in = { .variable = x, .variables = N, .hamiltonian = H, .restriction = restriction,
                                   .restrictions = restrictions };
    form_hamiltonian_space(&s, &in);
    form_hamiltonian_rows(&s, &in, NULL);
    CHECK(s.rows == N - restrictions && s.restrictions == restrictions && s.square == !restrictions, "sizes");
    for (int i = 0; i < s.rows; i++) {
        expr_id w[N], alpha = zero;
        bool nonzero = false, tangent = true;
        for (int j = 0; j < K; j++) {
            w[j] = expr_neg(&st, entry_of(&s, i, K + j));
            w[K + j] = entry_of(&s, i, j);
        }
        for (int j = 0; j < N; j++) {
            nonzero = nonzero || !expr_is_zero(&st, w[j]);
            alpha = expr_add(&st, alpha, expr_mul(&st, w[j], expr_diff(&st, H, x[j])));
        }
        for (int a = 0; a < restrictions; a++) {
            expr_id sum = zero;
            for (int j = 0; j < N; j++)
                sum = expr_add(&st, sum, expr_mul(&st, expr_int(&st, R[a][j]), w[j]));
            tangent = tangent && expr_is_zero(&st, sum);
        }
        CHECK(nonzero && tangent && equal(&st, alpha, s.row[i].alpha), "row %d with %d restrictions", i, restrictions);
    }
    sys_clear(&s);
    expr_store_clear(&st);
}

/* L = v M v/2 + v P q + q Q q: every row is known from second derivatives of L. */
static void lagrangian(unsigned long *seed, bool second_order)
{
    struct expr_store st;
    struct sys_system s;
    int q[K], v[K], t;
    expr_store_init(&st);
    sys_init(&s, &st);
    names(&st, 'q', K, q);
    names(&st, 'v', K, v);
    s.time = t = st.node[expr_symbol_add(&st, "t", EXPR_TIME)].a;
    expr_id L = expr_add(&st, quadratic(&st, seed, v, v), expr_add(&st, quadratic(&st, seed, v, q), quadratic(&st, seed, q, q)));
    expr_id force[K];
    L = expr_add(&st, L, expr_mul(&st, st.symbol[t].node, st.symbol[v[0]].node));
    for (int i = 0; i < K; i++)
        force[i] = expr_mul(&st, expr_int(&st, 7), st.symbol[v[i]].node);
    struct form_lagrangian in = { .coordinate = q, .velocity = v, .coordinates = K, .lagrangian = L,
                                  .second_order = second_order, .force = force };
    form_lagrangian(&s, &in);
    CHECK(s.rows == 2 * K && s.variables == 2 * K && s.square, "sizes");
    int good = 0;
    for (int i = 0; i < K; i++) {
        expr_id p = expr_diff(&st, L, v[i]);
        expr_id right = expr_add(&st, force[i], expr_sub(&st, expr_diff(&st, L, q[i]), expr_diff(&st, p, t)));
        expr_id second = second_order ? st.symbol[v[i]].node : expr_int(&st, 0);
        for (int j = 0; j < K; j++) {
            expr_id W = expr_diff(&st, p, v[j]), P = expr_diff(&st, p, q[j]);
            expr_id PT = expr_diff(&st, expr_diff(&st, L, v[j]), q[i]), vj = st.symbol[v[j]].node;
            expr_id zero = expr_int(&st, 0);
            good += equal(&st, entry_of(&s, i, K + j), W);
            good += equal(&st, entry_of(&s, i, j), second_order ? zero : expr_sub(&st, P, PT));
            good += equal(&st, entry_of(&s, K + i, j), second_order ? expr_int(&st, i == j) : W);
            good += equal(&st, entry_of(&s, K + i, K + j), zero);
            right = expr_sub(&st, right, expr_mul(&st, second_order ? P : PT, vj));
            second = second_order ? second : expr_add(&st, second, expr_mul(&st, W, vj));
        }
        good += equal(&st, s.row[i].alpha, right) + equal(&st, s.row[K + i].alpha, second);
    }
    CHECK(good == K * (4 * K + 2), "%d of %d, second order %d", good, K * (4 * K + 2), second_order);
    sys_clear(&s);
    expr_store_clear(&st);
}

/* Rows of polynomials, one of them a combination of the others. */
static void kernel(unsigned long *seed)
{
    struct expr_store st;
    struct form_probe probe;
    int x[N], count;
    expr_id J[3 * N], copy[3 * N];
    expr_store_init(&st);
    form_probe_init(&probe);
    names(&st, 'x', N, x);
    for (int j = 0; j < N; j++) {
        for (int i = 0; i < 2; i++)
            J[i * N + j] = expr_add(&st, expr_int(&st, next(seed, 1)),
                                    expr_mul(&st, expr_int(&st, next(seed, 1)), st.symbol[x[labs(next(seed, 5))]].node));
        J[2 * N + j] = expr_add(&st, expr_mul(&st, st.symbol[x[0]].node, J[j]), J[N + j]);
    }
    J[0] = expr_add(&st, J[0], expr_fun(&st, EXPR_EXP, st.symbol[x[1]].node));
    J[2 * N] = expr_add(&st, expr_mul(&st, st.symbol[x[0]].node, J[0]), J[N]);
    J[N + 1] = expr_add(&st, J[N + 1], expr_powi(&st, st.symbol[x[2]].node, 3));
    J[2 * N + 1] = expr_add(&st, expr_mul(&st, st.symbol[x[0]].node, J[1]), J[N + 1]);
    for (int k = 0; k < 3 * N; k++)
        copy[k] = J[k];
    expr_id *basis = form_kernel(&st, copy, 3, N, NULL, &count);
    CHECK(count == N - 2, "%d vectors", count);
    for (int k = 0; k < count; k++) {
        bool zero = true, empty = true;
        for (int i = 0; i < 3; i++) {
            expr_id sum = expr_int(&st, 0);
            for (int j = 0; j < N; j++) {
                sum = expr_add(&st, sum, expr_mul(&st, J[i * N + j], basis[k * N + j]));
                empty = empty && form_probe_zero(&probe, &st, basis[k * N + j]);
            }
            zero = zero && form_probe_zero(&probe, &st, sum);
        }
        CHECK(zero && !empty, "vector %d", k);
    }
    free(basis);
    form_probe_clear(&probe);
    expr_store_clear(&st);
}

/* Rows that share no constant: cofactors. They are annihilated, and at a point where the first entries
 * vanish they still span the kernel, by the rank of their values there. */
static void cofactors(unsigned long *seed)
{
    struct expr_store st;
    struct form_probe probe;
    int x[N], count;
    expr_id J[2 * N], copy[2 * N];
    expr_store_init(&st);
    form_probe_init(&probe);
    names(&st, 'x', N, x);
    for (int k = 0; k < 2 * N; k++)
        J[k] = copy[k] = k % N < 4 ? expr_mul(&st, expr_int(&st, 1 + labs(next(seed, 3))), st.symbol[x[(k * 5 + k / N) % N]].node)
                                   : expr_int(&st, 0);
    expr_id *v = form_kernel(&st, copy, 2, N, NULL, &count);
    CHECK(count == 4 + 2, "3 of 4 columns, and 2 alone: %d", count);
    for (int k = 0; k < count; k++) {
        bool zero = true;
        for (int i = 0; i < 2; i++) {
            expr_id sum = expr_int(&st, 0);
            for (int j = 0; j < N; j++)
                sum = expr_add(&st, sum, expr_mul(&st, J[i * N + j], v[k * N + j]));
            zero = zero && form_probe_zero(&probe, &st, sum);
        }
        CHECK(zero, "vector %d", k);
    }
    free(v);
    form_probe_clear(&probe);
    expr_store_clear(&st);
}

static bool everything(void *ctx, expr_id e)
{
    (void)ctx, (void)e;
    return true;
}

/* Entries that vanish where it matters are no pivots: then the rows are dependent there. */
static void vanishing(void)
{
    struct expr_store st;
    struct form_zero zero = { everything, NULL };
    int x[2], count;
    expr_store_init(&st);
    names(&st, 'x', 2, x);
    expr_id row[2] = { st.symbol[x[0]].node, st.symbol[x[1]].node };
    free(form_kernel(&st, row, 1, 2, &zero, &count));
    CHECK(count == 2, "%d vectors of a row that vanishes", count);
    expr_store_clear(&st);
}

/* d(f dx dy) = f_z dx dy dz, in the order of the variables; and b with div b = 0. */
static void cycles(void)
{
    struct expr_store st;
    int x[3], n;
    struct form_cycle *c;
    expr_store_init(&st);
    names(&st, 'x', 3, x);
    expr_id a = st.symbol[x[0]].node, b = st.symbol[x[1]].node, z = st.symbol[x[2]].node, square = expr_mul(&st, z, z);
    struct form_entry one[] = { { 0, 1, square }, { 1, 0, expr_neg(&st, square) } };
    struct form_matrix m = { .rows = 3, .cols = 3, .entry = one, .entries = 2 };
    CHECK(form_cycles(&st, x, 3, &m, 10, &c, &n) && n == 1 && c->i == 0 && c->j == 1 && c->k == 2
              && equal(&st, c->sum, expr_mul(&st, expr_int(&st, 2), z)), "2 z");
    free(c);
    struct form_entry two[] = { { 1, 2, a }, { 2, 1, expr_neg(&st, a) }, { 2, 0, b }, { 0, 2, expr_neg(&st, b) },
                                { 0, 1, expr_mul(&st, expr_int(&st, -2), z) }, { 1, 0, expr_mul(&st, expr_int(&st, 2), z) } };
    m.entry = two;
    m.entries = 6;
    CHECK(form_cycles(&st, x, 3, &m, 10, &c, &n) && n == 1 && equal(&st, c->sum, expr_int(&st, 0)), "1 + 1 - 2");
    free(c);
    m.entries = 4;
    CHECK(form_cycles(&st, x, 3, &m, 10, &c, &n) && n == 1 && equal(&st, c->sum, expr_int(&st, 2)), "1 + 1");
    free(c);
    expr_store_clear(&st);
}

/* A matrix that is antisymmetric only after expansion, and one that is not. */
static void antisymmetric(void)
{
    struct expr_store st;
    int x[1];
    expr_store_init(&st);
    names(&st, 'x', 1, x);
    expr_id e = st.symbol[x[0]].node, one = expr_int(&st, 1);
    expr_id a = expr_mul(&st, e, expr_sub(&st, one, e)), b = expr_sub(&st, expr_powi(&st, e, 2), e);
    struct form_entry entry[] = { { 0, 1, a }, { 1, 0, b }, { 1, 2, e }, { 2, 1, expr_neg(&st, e) } };
    struct form_matrix m = { .rows = 3, .cols = 3, .entry = entry, .entries = 4 };
    CHECK(form_not_antisymmetric(&st, &m) == 4, "antisymmetric");
    entry[3].value = e;
    CHECK(form_not_antisymmetric(&st, &m) == 2, "not");
    entry[2] = (struct form_entry){ 2, 2, one };
    entry[3] = (struct form_entry){ 0, 0, expr_int(&st, 0) };
    CHECK(form_not_antisymmetric(&st, &m) == 2, "a diagonal");
    expr_store_clear(&st);
}

int main(void)
{
    unsigned long seed = check_seed(77);
    for (int i = 0; i < check_scale(40); i++) {
        hamiltonian(&seed, i % 5);
        lagrangian(&seed, i % 2);
        kernel(&seed);
        cofactors(&seed);
    }
    vanishing();
    cycles();
    antisymmetric();
    return CHECK_END();
}
