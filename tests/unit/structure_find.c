/* What the reduction says about the structure: free starts count the dimension and determine the rest, every equation has a role, blocks
 * give every velocity once; the differentiation index of systems in Hessenberg form. */
#include "error.h"
#include "model.h"
#include "oracle.h"
#include "points.h"
#include "structure.h"
#include "system.h"

struct known { const char *name; struct model_text text; int index, redundant; };      /* redundant -1: of which equations is a matter of choice */

static const struct known all[] = {
    { "an equation for each", { "x y", "", { { "x:1", "y" }, { "y:1", "-x" } }, { 0 } }, 0, 0 },
    { "index 1", { "x y", "", { { "x:1", "y" }, { "", "y^3 + y - x" } }, { 0 } }, 1, 0 },
    { "index 2", { "x y z", "", { { "x:1", "z" }, { "y:1", "x" }, { "", "x - sin(y)" } }, { 0 } }, 2, 0 },
    { "a pendulum", { "x y l u v", "g", { { "x:1", "u" }, { "y:1", "v" }, { "u:1", "-l*x" }, { "v:1", "-l*y - g" }, { "", "x^2 + y^2 - 1" } }, { 0 } }, 3, 0 },
    { "an equation twice", { "x y", "", { { "x:1", "y" }, { "", "x - y" }, { "", "2*x - 2*y" } }, { 0 } }, 1, 1 },
    { "a derivative given too", { "x y", "", { { "x:1", "x" }, { "", "x - y" }, { "x:1; y:-1", "0" } }, { 0 } }, 0, -1 },
};

static void check(const struct known *k, const int *variables, const int *rows)
{
    struct model m;
    struct structure s = { 0 };
    struct sga_error err = { 0 };
    model_begin(&m, &k->text, variables, rows);
    CHECK(model_reduce(&m, NULL), "%s: %s", k->name, m.err.detail);
    CHECK(structure_index(&m.sys, &m.sol, &m.oracle, &m.budget) == k->index, "%s: index", k->name);
    CHECK(structure_find(&m.sys, &m.sol, &m.oracle, &m.budget, &s, &err), "%s: %s", k->name, err.detail);
    int n = m.sys.variables, c = m.sol.constraints, follow = 0, consequences = 0, velocities = 0;
    bool *of = calloc((size_t)n + 1, 1), distinct = true;
    for (int i = 0; i < s.frees; i++) {
        distinct &= !of[s.free_initial[i]];
        of[s.free_initial[i]] = true;
    }
    for (int i = 0; i < c; i++) {
        distinct &= !of[s.solved_for[i]];
        of[s.solved_for[i]] = true;
    }
    CHECK(s.has_initial && s.frees == n - c && distinct, "%s: %d free of %d", k->name, s.frees, n - c);
    for (int i = 0; i < s.equations; i++) {
        consequences += s.equation[i].role == STRUCTURE_CONSEQUENCE && s.equation[i].source < m.sys.rows;
        follow += s.equation[i].role == STRUCTURE_DERIVATIVE;
    }
    CHECK(k->redundant < 0 || consequences == k->redundant, "%s: %d consequences", k->name, consequences);
    for (int j = 0; j < n; j++)
        velocities += s.block[j] >= 0 && s.matched[j] >= 0;
    CHECK(velocities == n - m.sol.free_columns, "%s: %d velocities", k->name, velocities);
    CHECK(follow <= velocities, "%s: %d equations give %d velocities", k->name, follow, velocities);
    free(of);
    structure_clear(&s);
    model_end(&m);
}

static int count(const struct model_text *t, int *variables)
{
    int rows = 0;
    *variables = 1;
    for (const char *p = t->variables; *p; p++)
        *variables += *p == ' ';
    while (t->row[rows].alpha)
        rows++;
    return rows;
}

int main(void)
{
    uint64_t random = check_seed(8);
    for (size_t i = 0; i < sizeof all / sizeof *all; i++) {
        int n, rows = count(&all[i].text, &n), order[2][MODEL_ROWS];
        check(all + i, NULL, NULL);
        for (int k = 0; k < check_scale(6); k++) {
            model_shuffle(order[0], n, &random);
            model_shuffle(order[1], rows, &random);
            check(all + i, order[0], order[1]);
        }
    }
    flint_cleanup();
    return CHECK_END();
}
