/* sgad migrate: makes the tables of a shared store, or brings them up to date. */
#include "command.h"
#include "postgres.h"

#include <stdio.h>
#include <stdlib.h>

static const char usage[] = "usage: sgad migrate --store postgresql://... | --config FILE\n";

int command_migrate(int argc, char **argv)
{
    const char *store = NULL, *config = NULL;
    char why[1024] = "";
    int from, to;
    for (int i = 2; i < argc; i++) {
        const char *value;
        if ((value = command_option(argc, argv, &i, "store")))
            store = value;
        else if ((value = command_option(argc, argv, &i, "config")))
            config = value;
        else {
            fputs(usage, stderr);
            return COMMAND_USAGE;
        }
    }
    char *address = store || config ? command_place(store, NULL, config) : NULL;
    if (!address || !postgres_address(address)) {
        fputs(usage, stderr);
        free(address);
        return COMMAND_USAGE;
    }
    bool ok = postgres_migrate(address, &from, &to, why, sizeof why);
    free(address);
    if (!ok)
        fprintf(stderr, "sgad: %s\n", why);
    else if (from == to)
        printf("the schema is %d: nothing to do\n", to);
    else
        printf("the schema was %d and is %d\n", from, to);
    return ok ? COMMAND_DONE : COMMAND_FAILED;
}
