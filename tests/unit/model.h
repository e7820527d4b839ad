/* Systems from texts, for tests of what reduces, checks and follows them. */
#ifndef TESTS_UNIT_MODEL_H
#define TESTS_UNIT_MODEL_H

#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <flint/flint.h>

#include "budget.h"
#include "check_read.h"
#include "error.h"
#include "oracle.h"
#include "points.h"
#include "points_random.h"
#include "reduction.h"
#include "system.h"

enum { MODEL_ROWS = 12, MODEL_VARIABLES = 12 };

/* A row is "x:1; y:z" (coefficients of derivatives) and its right side. */
struct model_text {
    const char *variables, *parameters;                        /* names apart by blanks */
    struct { const char *entries, *alpha; } row[MODEL_ROWS];
    const char *restriction[MODEL_ROWS];
};

struct model {
    struct expr_store st;
    struct sys_system sys;
    struct points_oracle oracle;
    struct sga_solution sol;
    struct sga_error err;
    struct sga_budget budget;
};

static inline expr_id model_read(struct model *m, const char *text)
{
    return check_read(&m->st, text);
}

static inline int model_names(struct model *m, const char *names, enum expr_symbol_kind kind, char list[][16])
{
    char copy[200], *save = NULL;
    int n = 0;
    snprintf(copy, sizeof copy, "%s", names ? names : "");
    for (char *p = strtok_r(copy, " ", &save); p; p = strtok_r(NULL, " ", &save), n++) {
        snprintf(list[n], 16, "%s", p);
        if (expr_symbol_find(&m->st, p, strlen(p)) < 0)
            expr_symbol_add(&m->st, p, kind);
    }
    return n;
}

static inline int model_variable(const struct model *m, const char *name)
{
    int symbol = expr_symbol_find(&m->st, name, strlen(name)), at = -1;
    for (int j = 0; j < m->sys.variables; j++)
        at = m->sys.variable[j].symbol == symbol ? j : at;
    CHECK(at >= 0, "%s", name);
    return at;
}

/* The system with its variables and rows in these orders (NULL: as they are written). */
static inline void model_begin(struct model *m, const struct model_text *t, const int *variables, const int *rows)
{
    char name[MODEL_VARIABLES][16], copy[200], *save = NULL;
    *m = (struct model){ .budget = { .max_generations = 20 } };
    expr_store_init(&m->st);
    sys_init(&m->sys, &m->st);
    expr_symbol_add(&m->st, "t", EXPR_TIME);
    m->sys.time = expr_symbol_find(&m->st, "t", 1);
    int n = model_names(m, t->variables, EXPR_VARIABLE, name), count = 0;
    for (int j = 0; j < n; j++)
        sys_add_variable(&m->sys, expr_symbol_find(&m->st, name[variables ? variables[j] : j], strlen(name[variables ? variables[j] : j])), "variable");
    for (int j = model_names(m, t->parameters, EXPR_PARAMETER, name) - 1; j >= 0; j--)
        sys_add_parameter(&m->sys, expr_symbol_find(&m->st, name[j], strlen(name[j])));
    while (t->row[count].alpha)
        count++;
    for (int i = 0; i < count; i++) {
        int k = rows ? rows[i] : i;
        sys_add_row(&m->sys, model_read(m, t->row[k].alpha), "row");
        snprintf(copy, sizeof copy, "%s", t->row[k].entries);
        for (char *p = strtok_r(copy, "; ", &save); p; p = strtok_r(NULL, "; ", &save)) {
            char *colon = strchr(p, ':');
            *colon = 0;
            sys_add_entry(&m->sys, i, model_variable(m, p), model_read(m, colon + 1));
        }
    }
    for (int i = 0; t->restriction[i]; i++)
        sys_add_restriction(&m->sys, model_read(m, t->restriction[i]));
    points_oracle_init(&m->oracle, 20250101);
}

static inline bool model_reduce(struct model *m, const double *near)
{
    struct reduction_options options = { .near = near, .seed = 1, .combinations = true, .gauge_fields = true, .rows = true, .budget = &m->budget };
    return sga_reduce(&m->sys, &options, &m->oracle, &m->sol, &m->err);
}

static inline void model_end(struct model *m)
{
    points_oracle_clear(&m->oracle);
    sga_solution_clear(&m->sol);
    sys_clear(&m->sys);
    expr_store_clear(&m->st);
}

/* Zero all over the final set, as far as the oracle's points tell. */
static inline bool model_zero(struct model *m, expr_id e)
{
    return points_oracle_zero(&m->oracle, e).truth == POINTS_ZERO;
}

static inline expr_id model_dot(struct model *m, int row, const expr_id *v)
{
    expr_id sum = expr_int(&m->st, 0);
    for (int k = 0; k < m->sys.row[row].entries; k++)
        sum = expr_add(&m->st, sum, expr_mul(&m->st, m->sys.row[row].entry[k].value, v[m->sys.row[row].entry[k].col]));
    return sum;
}

/* Integers 0 .. n - 1 in a random order. */
static inline void model_shuffle(int *order, int n, uint64_t *random)
{
    for (int i = 0; i < n; i++)
        order[i] = i;
    for (int i = n - 1; i > 0; i--) {
        int k = (int)(points_random(random) % (uint64_t)(i + 1)), swap = order[i];
        order[i] = order[k];
        order[k] = swap;
    }
}

#endif
