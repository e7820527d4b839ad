/* Inside this folder: programs of series that outlive their jets (num_jet_programs of jet.h).
 *
 * A program is made of a plan's steps, rows and roots, of which rows are constant, of the highest order and the number of variables; constants
 * stand in its slots. So plans that agree in these have the same acts and code. A few are kept, the first ones that come; they go together. */
#ifndef SGA_NUM_JET_PROGRAMS_H
#define SGA_NUM_JET_PROGRAMS_H

#include "jet_machine.h"

/* Lends acts, layout and code to m, which has its memory for code; its numbers are left to be filled. False: there are none. */
bool jet_programs_find(const struct num_jet_programs *kept, struct jet_machine *m, const struct jet_plan *p, int order, int count);
/* Takes acts and code of m. False: they stay m's, as there is no room. */
bool jet_programs_keep(struct num_jet_programs *kept, const struct jet_machine *m, const struct jet_plan *p);

#endif
