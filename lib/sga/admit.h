/* Inside the sga folder: admission of candidates (state_admit), one or all of them. */
#ifndef SGA_SGA_ADMIT_H
#define SGA_SGA_ADMIT_H

struct candidate;
struct state;

/* One candidate, the oracle being on the present set, as constraints of generation g. Returns how many were added, or -1 with
 * the error; s->inconsistent where it contradicts the set. */
int admit_one(struct state *s, const struct candidate *c, int g);
/* All at once: full rank at certified points shows that they are independent. Returns how
 * many constraints were added, -1 where they must be looked at one by one, -2 failed. */
int admit_together(struct state *s, const struct candidate *cand, int count, int g);
/* Back to the first `to` constraints; the points stay where they are. */
void admit_pop(struct state *s, int to);

#endif
