/* The evaluation tape: some expressions of a store as straight-line code in double.
 *
 * Slots hold inputs, then constants, then one value for each instruction (static
 * single assignment), so that derivatives can run over the same values. Only the
 * cones of the roots are compiled; parts without symbols are computed once, when the
 * tape is made. The executor is hidden behind num_tape_eval.
 *
 * A tape owns its working memory: one thread at a time. It keeps no reference to
 * the store, but one to the tables of signals (expr/signal.h), which it looks up at the
 * input that is time, where the signals themselves are no inputs. */
#ifndef SGA_NUM_TAPE_H
#define SGA_NUM_TAPE_H

#include <stdbool.h>

#include "expr.h"

struct num_tape;
struct sga_exec;
struct sga_stage_code;
struct sga_stages;

/* Compile roots[0..nroots). in[i] of an evaluation is the value of symbol inputs[i]
 * (an index into st->symbol; no index twice). NULL, with err, where a root uses a symbol that is not
 * listed (EXPR_NAME) or has no value (EXPR_UNDEFINED). Constants become the nearest
 * doubles. Cost: the cones of the roots, and st->nodes words once. */
struct num_tape *num_tape_new(const struct expr_store *st, const expr_id *roots, int nroots,
                              const int *inputs, int ninputs, struct sga_error *err);
void num_tape_free(struct num_tape *t);    /* NULL is allowed */

/* The same, and each abs, sign, min and max that `w` knows can be held on one side: num_tape_hold. */
struct num_switches;
struct num_tape *num_tape_new_switched(const struct expr_store *st, const struct num_switches *w, const expr_id *roots, int nroots,
                                       const int *inputs, int ninputs, struct sga_error *err);
/* From now on switch k is what it is where its argument has the sign side[k], wherever it is evaluated; 0: as its
 * argument says, as after num_tape_new_switched. NULL: all 0. */
void num_tape_hold(struct num_tape *t, const signed char *side);

int num_tape_inputs(const struct num_tape *t);
int num_tape_roots(const struct num_tape *t);
/* Instructions run by each evaluation. */
int num_tape_length(const struct num_tape *t);

/* out[r] = value of root r. False if any of them is not finite (out is filled all the
 * same): outside of the domain of a function the value is NaN, a division by zero is
 * infinite, and the components of a singular solve are NaN. */
bool num_tape_eval(struct num_tape *t, const double *in, double *out);
/* The same with the last input apart (variables and time), and the roots in two parts: the
 * first so many into out, the others into rest. For fields, where each copy counts: results
 * must not overlap x, which is read while they are written. */
bool num_tape_eval_field(struct num_tape *t, const double *x, double time, int first, double *out, double *rest);

/* From now on the tape may become machine code in `memory` (which must outlive it; NULL: none), once it
 * has been evaluated often enough for that to pay. Values are the same to the bit. */
void num_tape_compile(struct num_tape *t, struct sga_exec *memory);
/* It has. */
/* The machine code behind num_tape_eval_field with this `first`, where there is any that reads x itself:
 * run(slots, out, rest, x) after *time = the time. False: none (yet). Valid until the tape's next use. */
struct num_code {
    void (*run)(double *slots, double *out, double *rest, const double *x);
    double *slots, *time;
};
bool num_tape_code(struct num_tape *t, int first, struct num_code *code);
/* The same for all stages of a Runge-Kutta step at once, `first` variables, whose values the code gives: made once
 * this was asked often enough for that to pay. Not for large fields. code->rest is left to the caller. */
bool num_tape_stages(struct num_tape *t, int first, const struct sga_stages *plan, struct sga_stage_code *code);
bool num_tape_compiled(const struct num_tape *t);

#endif
