/* A Runge-Kutta step as one piece of machine code against the same stages by the interpreter, bit for bit: random
 * fields, tableaux, places of the vectors and points, extreme ones too. */
#include "check.h"

#include <math.h>
#include <string.h>

#include "exec.h"
#include "random_expr.h"
#include "stages.h"
#include "table.h"
#include "tape.h"

enum { MOST_VARIABLES = 14, RESTS = 3, POOL = 60, STAGES = SGA_STAGES_MOST };

static struct random_source rng;
static long compiled, with_time, with_functions, finite_steps, odd, wide;

static bool same(double a, double b)
{
    return memcmp(&a, &b, sizeof a) == 0 || (isnan(a) && isnan(b));
}

/* Each row has the stage before as its last term. */
static void random_rows(struct sga_row *row, double *c, int stages)
{
    for (int s = 1; s < stages; s++) {
        row[s].count = 0;
        c[s] = s > 1 && random_below(&rng, 3) == 0 ? c[s - 1] : random_unit(&rng);
        for (int k = 0; k < s; k++)
            if (k == s - 1 || random_below(&rng, 2)) {
                row[s].stage[row[s].count] = k;
                row[s].a[row[s].count++] = random_unit(&rng);
            }
    }
}

static double coordinate(bool tame)
{
    static const double extreme[] = { 0, -0.0, INFINITY, NAN, 1e308, -1e308, 5e-324, 1e-160 };
    return !tame && random_below(&rng, 4) == 0 ? extreme[random_below(&rng, 8)] : random_unit(&rng);
}

/* The contract of base/stages.h, by the letter. */
static void by_stages(struct num_tape *t, int n, const struct sga_stages *p, double time, double h, double *block, double *rest, int rests)
{
    double y[MOST_VARIABLES], *out = calloc((size_t)(n + rests), sizeof *out);
    for (int s = 1; s < p->count; s++) {
        const struct sga_row *r = p->row + s;
        int last = r->count - 1;
        for (int j = 0; j < n; j++) {
            double from = block[p->x + (size_t)j], add = 0;
            for (int m = 0; m < last; m++) {
                double term = r->a[m] * block[(size_t)r->stage[m] * p->stride + (size_t)j];
                add = m ? add + term : term;
            }
            if (last > 0)
                from += h * add;
            y[j] = from + (h * r->a[last]) * block[(size_t)r->stage[last] * p->stride + (size_t)j];
            if (s >= p->keep)
                block[p->y + (size_t)(s - p->keep) * p->stride + (size_t)j] = y[j];
        }
        double in[MOST_VARIABLES + 1];
        memcpy(in, y, (size_t)n * sizeof *in);
        in[n] = time + p->c[s] * h;
        num_tape_eval(t, in, out);
        for (int j = 0; p->aside && j < n; j++)
            out[j] *= j % 2 ? 1 - 0x1p-52 : 1 + 0x1p-52;
        memcpy(block + (size_t)s * p->stride, out, (size_t)n * sizeof *out);
        memcpy(rest + (s - 1) * rests, out + n, (size_t)rests * sizeof *out);
    }
    free(out);
}

static void compare(struct num_tape *plain, struct num_tape *fast, int n, int rests, const struct sga_stages *p, const struct sga_stage_code *code)
{
    size_t size = (STAGES + 4) * p->stride;
    double *a = calloc(size, sizeof *a), *b = calloc(size, sizeof *b), rest[2][STAGES * RESTS], h = random_unit(&rng), time = random_unit(&rng);
    bool tame = random_below(&rng, 3) > 0, finite = true;
    int bad = -1;
    for (int j = 0; j < n; j++) {
        a[p->x + (size_t)j] = coordinate(tame);
        a[j] = coordinate(tame);
    }
    memcpy(b, a, size * sizeof *a);
    by_stages(plain, n, p, time, h, a, rest[0], rests);
    for (int s = 1; s < p->count && code->needs_time; s++)
        code->time[s] = time + p->c[s] * h;
    code->run(code->slots, b, rest[1], code->place, h);
    for (size_t i = 0; i < size; i++) {
        bad = same(a[i], b[i]) ? bad : (int)i;
        finite = finite && isfinite(a[i]);
    }
    CHECK(bad < 0, "n %d, place %d of stride %zu: %a, %a", n, bad, p->stride, a[bad < 0 ? 0 : bad], b[bad < 0 ? 0 : bad]);
    bad = -1;
    for (int i = 0; i < rests * (p->count - 1); i++)
        bad = same(rest[0][i], rest[1][i]) ? bad : i;
    CHECK(bad < 0, "rest %d of %d a stage: %a, %a", bad, rests, rest[0][bad < 0 ? 0 : bad], rest[1][bad < 0 ? 0 : bad]);
    finite_steps += finite;
    /* the tape itself is as it was, at times that come again too */
    for (int turn = 0; turn < 6; turn++) {
        static const double times[] = { 0.0, -0.0, 0.7, NAN, INFINITY };
        double in[MOST_VARIABLES + 1], u[MOST_VARIABLES + RESTS], v[MOST_VARIABLES + RESTS];
        for (int j = 0; j < n; j++)
            in[j] = coordinate(false);
        in[n] = turn == 0 ? time + p->c[p->count - 1] * h : turn < 3 ? times[random_below(&rng, 5)] : random_below(&rng, 2) ? 0.0 : -0.0;
        num_tape_eval(plain, in, u);
        if (random_below(&rng, 3))
            num_tape_eval_field(fast, in, in[n], n, v, v + n);
        else
            num_tape_eval(fast, in, v);
        for (int r = 0; r < n + rests; r++)
            CHECK(same(u[r], v[r]), "root %d, turn %d", r, turn);
    }
    free(a);
    free(b);
}

static void random_step(struct sga_exec *memory)
{
    int n = 1 + random_below(&rng, random_below(&rng, 4) ? 5 : MOST_VARIABLES), rests = random_below(&rng, RESTS + 1), inputs[MOST_VARIABLES + 1];
    int functions = random_below(&rng, 2), nodes = 0, most = n + 2 + random_below(&rng, POOL - n - 2);
    struct expr_store st;
    expr_id pool[POOL], root[MOST_VARIABLES + RESTS];
    expr_store_init(&st);
    for (; nodes <= n; nodes++) {
        char name[16];
        sprintf(name, "x%d", nodes);
        pool[nodes] = expr_symbol_add(&st, name, nodes < n ? EXPR_VARIABLE : EXPR_TIME);
        inputs[nodes] = nodes;
    }
    pool[nodes++] = expr_rational(&st, 1, 3);
    while (nodes < most) {
        static const enum expr_op some[] = { EXPR_SIN, EXPR_COS, EXPR_EXP, EXPR_SQRT, EXPR_ABS };
        expr_id e = functions && random_below(&rng, 4) == 0 ? expr_fun(&st, some[random_below(&rng, 5)], pool[random_below(&rng, nodes)])
                                                            : random_rational(&rng, &st, pool, nodes);
        pool[nodes] = e == EXPR_UNDEF ? pool[nodes - 1] : e;
        nodes++;
    }
    for (int r = 0; r < n + rests; r++)
        root[r] = pool[random_below(&rng, 2) ? nodes - 1 - random_below(&rng, nodes / 2) : random_below(&rng, nodes)];
    struct num_tape *plain = num_tape_new(&st, root, n + rests, inputs, n + 1, NULL), *fast = num_tape_new(&st, root, n + rests, inputs, n + 1, NULL);
    num_tape_compile(fast, memory);
    double c[STAGES] = { 0 }, out[MOST_VARIABLES + RESTS], in[MOST_VARIABLES + 1] = { 0 };
    struct sga_row row[STAGES];
    struct sga_stages p = { .count = 2 + random_below(&rng, STAGES - 1), .c = c, .row = row, .stride = ((size_t)n + 1) / 2 * 2 + 2 * (size_t)random_below(&rng, 3) };
    random_rows(row, c, p.count);
    p.keep = p.count - 1 - random_below(&rng, 2);
    p.x = STAGES * p.stride;
    p.y = p.x + p.stride;
    struct sga_stage_code code;
    for (int i = 0; i < 20000 && !num_tape_stages(fast, n, &p, &code); i++)
        num_tape_eval_field(fast, in, 0, n, out, out + n);
    bool there = num_tape_stages(fast, n, &p, &code);
    CHECK(there, "n %d, %d instructions", n, num_tape_length(fast));
    compiled += there;
    with_time += there && code.needs_time;
    with_functions += there && functions;
    odd += there && n % 2;
    wide += there && n > 8;
    for (int point = 0; there && point < 24; point++) {
        if (point == 12) {        /* beside the code that is there */
            p.aside = true;
            for (int i = 0; i < 20000 && !num_tape_stages(fast, n, &p, &code); i++)
                ;
            CHECK(num_tape_stages(fast, n, &p, &code));
        } else if (random_below(&rng, 2)) {
            p.aside = !p.aside && point > 12;
            num_tape_stages(fast, n, &p, &code);
        }
        compare(plain, fast, n, rests, &p, &code);
    }
    struct sga_stages other = p;
    other.stride += 2;
    CHECK(!num_tape_stages(fast, n, &other, &code), "other places need other code");
    num_tape_free(plain);
    num_tape_free(fast);
    expr_store_clear(&st);
}

int main(void)
{
    struct sga_exec *memory = sga_exec_new(1 << 20);
    rng.state = check_seed(20268);
    int n = check_scale(400);
    for (int i = 0; memory && i < n; i++)
        random_step(memory);
    /* counts of kinds are asked of full runs only */
    CHECK(!memory || n < 400 || (compiled == n && with_time > n / 4 && with_functions > n / 4 && odd > n / 4 && wide > n / 20 && finite_steps > n),
          "%d: %ld compiled, %ld with time, %ld with functions, %ld odd, %ld wide, %ld finite steps", n, compiled, with_time, with_functions,
          odd, wide, finite_steps);
    sga_exec_free(memory);
    flint_cleanup();
    return CHECK_END();
}
