/* See vary_copies.h. */
#include "error.h"
#include "vary_copies.h"

bool vary_copies_make(struct vary_copies *p, const struct variation *v, const struct vary_copied *from, struct sga_error *err)
{
    *p = (struct vary_copies){ .has_own = false };
    bool ok = sweep_case_of(&p->c, from->of, &v->system, &v->solution, &v->request, from->parameter, err), solved = ok && p->c.solved;
    if (ok && v->jumps) {
        p->has_own = true;
        ok = sweep_case_of(&p->own, from->of, from->sys, from->sol, from->rq, from->parameter, err);
        solved &= ok && p->own.solved;
        p->carried = (struct traj_carried){ &p->c.system, &p->c.solution, &p->c.request };
        p->own.request.carried = &p->carried;
        p->own.request.single = v->request.single;
        p->own.request.relations = 0;      /* the start that is placed has met them */
        p->own.request.low = p->own.request.high = NULL;
        if (v->request.arithmetic == TRAJ_AUTO)
            p->own.request.arithmetic = p->c.request.arithmetic = TRAJ_DOUBLE;
    }
    return ok && (solved || sga_fail(err, SGA_E_EXPR_UNDEFINED, "the reduction for general values of the parameters has no value at these"));
}

void vary_copies_clear(struct vary_copies *p)
{
    sweep_case_clear(&p->c);
    if (p->has_own)
        sweep_case_clear(&p->own);
}
