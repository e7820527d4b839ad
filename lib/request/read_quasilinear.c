/* The form `quasilinear`: A dense or sparse, alpha, restrict, transpose. */
#include <stdlib.h>

#include "error.h"
#include "form.h"
#include "reader.h"

static bool read_quasilinear_matrix(struct reader *rd, const json_t *system, struct read_matrix *m,
                                    struct form_quasilinear *q, int equations)
{
    q->rows = m->rows = q->transpose ? q->variables : equations;
    q->cols = m->cols = q->transpose ? equations : q->variables;
    m->per_row = q->transpose ? "variables" : "alpha";
    m->per_col = q->transpose ? "alpha" : "variables";
    m->hint = q->transpose ? " (with transpose, A has a row for each variable)" : NULL;
    return read_matrix(rd, system, m);
}

bool read_quasilinear(struct reader *rd, const json_t *system)
{
    struct form_quasilinear q = { 0 };
    struct read_matrix m = { .name = "A" };
    expr_id *alpha = NULL, *restriction = NULL;
    int equations = 0, restrictions = 0;
    const json_t *transpose = json_object_get(system, "transpose");
    if (transpose) {
        size_t mark = at_member(rd, "transpose");
        if (!read_boolean(rd, transpose, &q.transpose))
            return false;
        at_back(rd, mark);
    }
    int *variable = read_variables(rd, system, "variables", &q.variables);
    bool ok = variable && need_member(rd, system, "alpha") && read_expression_list(rd, system, "alpha", &alpha, &equations)
        && read_expression_list(rd, system, "restrict", &restriction, &restrictions)
        && read_quasilinear_matrix(rd, system, &m, &q, equations);
    if (ok && equations == 0 && restrictions <= 0)
        ok = at_fail(rd, SGA_E_EMPTY_SYSTEM, "the system has no equation: A and alpha are empty");
    if (ok) {
        q.variable = variable;
        q.entry = m.entry;
        q.entries = m.entries;
        q.alpha = alpha;
        q.restriction = restriction;
        q.restrictions = restrictions > 0 ? restrictions : 0;
        form_quasilinear(&rd->r->system, &q);
    }
    return ok;
}
