/* The result object. */
#ifndef SGA_RUN_WRITE_H
#define SGA_RUN_WRITE_H

#include <stdbool.h>
#include <stddef.h>

struct job;
struct sga_buf;
struct sga_json;

/* Appends the result to out. False: over answer_limit, memory or time. */
bool answer_write(struct job *j, struct sga_buf *out);

/* Its parts. */
void answer_write_operator(const struct job *j, struct sga_json *w);
void answer_write_mechanical(struct job *j, struct sga_json *w);
void answer_write_restrictions(struct job *j, struct sga_json *w);
/* write_families.c: what was written from byte `start` of its text on is a list or an object: what repeats in it is said once, as the request
 * asks for. */
void answer_fold(const struct job *j, struct sga_json *w, size_t start);
/* The member `variables`. */
void answer_write_variables(const struct job *j, struct sga_json *w);
/* Members of an object that is open: verdict, dimensions, index, and what is wanted of constraints and field. */
void answer_write_reduction(struct job *j, struct sga_json *w);
/* write_modes.c: {mode: value} of a request as it was read; the member `modes`; `pieces` of a motion. */
void answer_mode_values(const struct job *j, struct sga_json *w);
void answer_write_modes(struct job *j, struct sga_json *w);
void answer_write_pieces(const struct job *j, struct sga_json *w);
void answer_write_drift(const struct job *j, struct sga_json *w);
void answer_write_strata(const struct job *j, struct sga_json *w);
void answer_write_empty_strata(const struct job *j, struct sga_json *w);
void answer_write_evidence(struct job *j, struct sga_json *w);
void answer_write_initial(const struct job *j, struct sga_json *w);
bool answer_write_trajectory(struct job *j, struct sga_json *w);
/* The members of an object that is open, and its end: those of j->trajectory. */
bool answer_write_motion(struct job *j, struct sga_json *w);
/* Members of evidence, and of a start: what was not modelled. Nothing where all was. */
void answer_write_slice(const struct job *j, struct sga_json *w);
void answer_write_slice_start(const struct job *j, struct sga_json *w);
/* The tables of the system, where it has any, and what the answer uses of them. */
void answer_write_tables(const struct job *j, struct sga_json *w);
void answer_write_tradeoff(const struct job *j, struct sga_json *w);
/* Members of the object `structure`, which is open; needs the structure. */
void answer_write_structure(struct job *j, struct sga_json *w);
void answer_write_symmetries(struct job *j, struct sga_json *w);

/* What the answer says beside itself of names that nothing uses, before the system is cut; and of the number of
 * equations and the start, once all is known. */
void answer_warn_unused(struct job *j);
/* Equations and unknowns as they were given, without those of the order reduction. */
void answer_count_given(const struct job *j, int *equations, int *unknowns);
void answer_warn(struct job *j);

#endif
