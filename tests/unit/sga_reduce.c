/* The reduction of systems whose answers are known: dimensions by generation, A X = alpha and A G = 0 on the final set, constraints
 * and their tangency, and the same in every order of variables and rows. */
#include "derive.h"
#include "error.h"
#include "model.h"
#include "oracle.h"
#include "points.h"
#include "system.h"

enum { END = -1 };

struct known {
    const char *name;
    struct model_text text;
    enum sga_verdict verdict;
    int dimension[4];          /* by generation, END after the last */
    int gauges;
    const char *vanish[3];     /* functions that are 0 on the final set */
};

static const struct known all[] = {
    { "a pendulum", { "x y l u v", "g", { { "x:1", "u" }, { "y:1", "v" }, { "u:1", "-l*x" }, { "v:1", "-l*y - g" }, { "", "x^2 + y^2 - 1" } }, { 0 } },
      SGA_UNIQUE, { 4, 3, 2, END }, 0, { "x*u + y*v", "u^2 + v^2 - g*y - l" } },
    { "a circuit of index 2", { "q i e", "C", { { "q:1", "i" }, { "", "q - C*e" }, { "", "e - sin(t)" } }, { 0 } }, SGA_UNIQUE, { 1, 0, END }, 0, { "i - C*cos(t)" } },
    { "a free function", { "x y z", "", { { "x:1; y:1", "z" }, { "", "z - x*y" } }, { 0 } }, SGA_UNDERDETERMINED, { 2, END }, 1, { "z - x*y" } },
    { "a rank that depends on values", { "x y", "", { { "x:1", "1" }, { "y:x*y", "x" } }, { 0 } }, SGA_UNIQUE, { END }, 0, { NULL } },
    { "a contradiction", { "x y", "", { { "x:1", "1" }, { "", "x - y" }, { "y:1", "2" } }, { 0 } }, SGA_INCONSISTENT, { 1, END }, 0, { NULL } },
    { "a restriction", { "x y z", "", { { "x:1", "y" }, { "y:1", "-x + z" } }, { "x^2 + y^2 - 1" } }, SGA_UNIQUE, { 2, 1, END }, 0, { "y*z" } },
    { "a part on which the last constraint holds by itself",
      { "x y l k u", "", { { "x:1", "u*(10*y - x)" }, { "y:1", "u*(x - 10*y) - (1 - u)*y" }, { "l:1", "u*(l - k)" }, { "k:1", "-10*u*(l - k) + (1 - u)*k" },
                           { "", "l*(10*y - x) + k*(x - 9*y)" } }, { 0 } }, SGA_UNDERDETERMINED, { 4, 3, END }, 1, { NULL } },
};

static const struct known *const pendulum = all;

static void dimensions(const struct known *k, const struct model *m)
{
    int n = 0;
    while (k->dimension[n] != END)
        n++;
    CHECK(m->sol.generations == n || k->verdict == SGA_INCONSISTENT, "%s: %d generations", k->name, m->sol.generations);
    for (int i = 0; i < n && i < m->sol.generations; i++)
        CHECK(m->sol.dimension[i] == k->dimension[i], "%s: dimension %d is %d", k->name, i + 1, m->sol.dimension[i]);
}

static void identities(const struct known *k, struct model *m)
{
    for (int i = 0; i < m->sys.rows; i++) {
        CHECK(model_zero(m, expr_sub(&m->st, model_dot(m, i, m->sol.field), m->sys.row[i].alpha)), "%s: row %d", k->name, i);
        for (int g = 0; g < m->sol.free_columns; g++)
            CHECK(model_zero(m, model_dot(m, i, m->sol.gauge + g * m->sys.variables)), "%s: gauge of row %d", k->name, i);
    }
    for (int i = 0; i < m->sol.constraints; i++) {
        struct expr_term *term = NULL;
        struct expr_cone cone;
        size_t cap = 0;
        expr_id rate = expr_int(&m->st, 0);
        unsigned char *active = calloc((size_t)m->st.symbols + 1, 1);
        memset(active, 1, (size_t)m->st.symbols);
        expr_cone_init(&cone);
        int terms = expr_gradient(&m->st, &cone, m->sol.constraint[i].expr, active, &term, &cap);
        for (int q = 0; q < terms; q++) {
            for (int j = 0; j < m->sys.variables; j++)
                if (m->sys.variable[j].symbol == term[q].symbol)
                    rate = expr_add(&m->st, rate, expr_mul(&m->st, term[q].value, m->sol.field[j]));
            if (term[q].symbol == m->sys.time)
                rate = expr_add(&m->st, rate, term[q].value);
        }
        CHECK(model_zero(m, m->sol.constraint[i].expr) && model_zero(m, rate), "%s: constraint %d", k->name, i);
        expr_cone_clear(&cone);
        free(term);
        free(active);
    }
    for (int i = 0; i < 3 && k->vanish[i]; i++)
        CHECK(model_zero(m, model_read(m, k->vanish[i])), "%s: %s", k->name, k->vanish[i]);
}

static void solve(const struct known *k, const int *variables, const int *rows)
{
    struct model m;
    model_begin(&m, &k->text, variables, rows);
    bool ok = model_reduce(&m, NULL);
    CHECK(ok, "%s: %s", k->name, m.err.detail);
    CHECK(m.sol.verdict == k->verdict, "%s: %s", k->name, sga_verdict_text(m.sol.verdict));
    if (ok && m.sol.verdict == k->verdict) {
        dimensions(k, &m);
        if (k->verdict != SGA_INCONSISTENT)
            identities(k, &m);
        CHECK(m.sol.free_columns == k->gauges || k->verdict == SGA_INCONSISTENT, "%s: %d gauge fields", k->name, m.sol.free_columns);
    }
    model_end(&m);
}

static int names(const char *text)
{
    int n = *text != 0;
    for (; *text; text++)
        n += *text == ' ';
    return n;
}

/* A guess decides between parts of a union: x (x - 1) = 0. */
static void near(void)
{
    static const struct model_text t = { "x y", "", { { "y:1", "x" }, { "", "x*(x - 1)" } }, { 0 } };
    for (int side = 0; side < 2; side++) {
        struct model m;
        double guess[2] = { side ? 0.9 : 0.2, 3 };
        model_begin(&m, &t, NULL, NULL);
        CHECK(model_reduce(&m, guess) && m.sol.verdict == SGA_UNIQUE && m.sol.branches == 1, "%s", m.err.detail);
        CHECK(model_zero(&m, expr_sub(&m.st, model_read(&m, "x"), expr_int(&m.st, side))), "part %d", side);
        model_end(&m);
    }
}

/* Time and cancelling end it with their codes, not with an answer. */
static bool cancelled(void *ctx)
{
    return --*(int *)ctx < 0;
}

static void ended(void)
{
    for (int left = 0; left < 40; left += 3) {
        struct model m;
        int n = left;
        model_begin(&m, &pendulum->text, NULL, NULL);
        m.budget.cancelled = cancelled;
        m.budget.cancel_ctx = &n;
        bool ok = model_reduce(&m, NULL);
        CHECK(ok || m.err.code == SGA_E_CANCELLED, "%s", m.err.detail);
        model_end(&m);
    }
}

int main(void)
{
    uint64_t random = check_seed(5);
    for (size_t i = 0; i < sizeof all / sizeof *all; i++) {
        int variables = names(all[i].text.variables), rows = 0, order[2][MODEL_ROWS];
        while (all[i].text.row[rows].alpha)
            rows++;
        solve(all + i, NULL, NULL);
        for (int k = 0; k < check_scale(8); k++) {
            model_shuffle(order[0], variables, &random);
            model_shuffle(order[1], rows, &random);
            solve(all + i, order[0], order[1]);
        }
    }
    near();
    ended();
    flint_cleanup();
    return CHECK_END();
}
