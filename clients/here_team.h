/* Copies of this process that make a part of a sweep's sets. */
#ifndef CLIENTS_HERE_TEAM_H
#define CLIENTS_HERE_TEAM_H

#include "team.h"

struct here_team;

/* For a job of this process and at most so many in all; 1: NULL. NULL too where memory ends: then it makes all by itself.
 * Copies are made once the library asks for help, and go on from there. */
struct here_team *here_team_new(int processes);
struct sga_team *here_team_of(struct here_team *t);
/* Ends the copies. NULL is allowed. */
void here_team_free(struct here_team *t);

#endif
