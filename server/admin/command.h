/* What the program sgad does besides serving: `sgad token`, `sgad backup`, `sgad restore`, `sgad check`, `sgad prune`, `sgad migrate`. */
#ifndef SERVER_COMMAND_H
#define SERVER_COMMAND_H

#include <stdbool.h>

enum { COMMAND_DONE = 0, COMMAND_FAILED = 1, COMMAND_USAGE = 2 };

/* Is argv[1] one of them? Then its exit status is in *status. */
bool command_run(int argc, char **argv, int *status);

/* The value of --name VALUE or --name=VALUE at argv[*i], which then moves on; NULL where
 * this is another argument. */
const char *command_option(int argc, char **argv, int *i, const char *name);
/* The state folder: --state, else what the file after --config says. NULL, with the reason
 * on standard error, where there is none. malloc'ed. */
char *command_state(const char *state, const char *config);
/* Where tokens are: --store, else --state, else what the file says, its store first. As command_state. */
char *command_place(const char *store, const char *state, const char *config);

int command_token(int argc, char **argv);      /* command_token.c */
int command_backup(int argc, char **argv);     /* command_store.c */
int command_restore(int argc, char **argv);
int command_check(int argc, char **argv);
int command_prune(int argc, char **argv);      /* command_prune.c */
int command_migrate(int argc, char **argv);    /* command_migrate.c */

#endif
