/* The child's side of processes that make one job together. */
#ifndef SERVER_CHILD_TEAM_H
#define SERVER_CHILD_TEAM_H

#include "team.h"

struct child_team {
    struct sga_team team;
    int fd;               /* to the worker */
    bool *cancelled;      /* set where the worker says so while it is asked */
};

/* A team whose functions are messages to the worker on fd. It must stay where it is. */
void child_team_begin(struct child_team *t, int fd, bool *cancelled);

#endif
