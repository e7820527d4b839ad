/* One table of what rows of each form are. */
#include "given.h"

#include <stdlib.h>
#include <string.h>

#include "buf.h"
#include "request.h"
#include "run_job.h"

/* By form and by how the row's source begins; the first that fits counts. */
static const struct {
    const char *form, *source, *text;
} words[] = {
    { "quasilinear", "row", "a row of A x' = alpha" },
    { "linear", "row", "a row of A x' = B x + C u" },
    { "descriptor", "row", "a row of E x' = A x + B u" },
    { "control", "equation", "x' = F + sum of u G" },
    { "control", "constraints", "a constraint that is held" },
    { "hamiltonian", "row", "Hamilton's equations, a component of i_X omega = dH" },
    { "hamiltonian", "pull-back", "Hamilton's equations along a field tangent to the restriction (evidence.pull_back lists the fields)" },
    { "lagrangian", "equation", "the equation of Euler and Lagrange, d/dt dL/dv = dL/dq and forces" },
    { "lagrangian", "definition", "the velocity of a coordinate is a variable" },
    { "lagrangian", "holonomic", "a holonomic constraint" },
    { "mechanical", "equation", "M v' = F and the constraints' forces" },
    { "mechanical", "definition", "the velocity of a coordinate is a variable" },
    { "mechanical", "constraints", "a constraint" },
    { "operator", "equations", "a row of the operator's equations" },
    { "", "choice", "the multiplier of a constraint that follows from others is chosen" },
    { "", "definition", "order reduction: a derivative becomes a variable" },
};

static bool begins(const char *text, const char *with)
{
    return strncmp(text, with, strlen(with)) == 0;
}

void derivation_row_text(const struct job *j, int row, struct sga_buf *out)
{
    const char *source = j->request->system.row[row].source;
    int n = (int)(sizeof words / sizeof *words), number = begins(source, "equations[") ? atoi(source + strlen("equations[")) : -1;
    sga_buf_printf(out, "given, %s", source);
    if (number >= 0 && number < j->request->equations && j->request->equation[number]) {
        sga_buf_printf(out, ": %s", j->request->equation[number]);
        return;
    }
    for (int k = 0; k < n; k++)
        if ((!*words[k].form || strcmp(words[k].form, j->request->form) == 0) && begins(source, words[k].source)) {
            sga_buf_printf(out, ": %s", words[k].text);
            return;
        }
}

bool derivation_row_is_solved(const struct job *j, int row, int *variable)
{
    const struct sys_row *r = j->request->system.row + row;
    *variable = r->entries == 1 ? r->entry[0].col : -1;
    return r->entries == 1 && expr_is_one(&j->request->store, r->entry[0].value);
}
