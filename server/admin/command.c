/* Choosing a command, and what all of them read. */
#include "command.h"
#include "config.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

bool command_run(int argc, char **argv, int *status)
{
    static const struct { const char *name; int (*run)(int, char **); } commands[] = {
        { "token", command_token }, { "backup", command_backup }, { "restore", command_restore }, { "prune", command_prune }, { "check", command_check }, { "migrate", command_migrate },
    };
    for (size_t i = 0; argc > 1 && i < sizeof commands / sizeof *commands; i++)
        if (strcmp(argv[1], commands[i].name) == 0) {
            *status = commands[i].run(argc, argv);
            return true;
        }
    return false;
}

const char *command_option(int argc, char **argv, int *i, const char *name)
{
    const char *arg = argv[*i];
    size_t n = strlen(name);
    if (strncmp(arg, "--", 2) != 0 || strncmp(arg + 2, name, n) != 0)
        return NULL;
    if (arg[2 + n] == '=')
        return arg + 3 + n;
    if (arg[2 + n] || *i + 1 >= argc)
        return NULL;
    return argv[++*i];
}

char *command_place(const char *store, const char *state, const char *file)
{
    char *found = store ? strdup(store) : NULL, why[512];
    if (!found && !state && file) {
        struct config c;
        char *args[] = { "sgad", "--print-config", "--config", (char *)(size_t)file };
        if (config_read(&c, 4, args, why, sizeof why) != CONFIG_BAD && c.store)
            found = strdup(c.store);
        config_free(&c);
    }
    return found ? found : command_state(state, file);
}

char *command_state(const char *state, const char *file)
{
    char *found = state ? strdup(state) : NULL, why[512];
    if (!found && file) {
        struct config c;
        char *args[] = { "sgad", "--print-config", "--config", (char *)(size_t)file };
        if (config_read(&c, 4, args, why, sizeof why) == CONFIG_BAD)
            fprintf(stderr, "sgad: %s\n", why);
        else if (c.state)
            found = strdup(c.state);
        config_free(&c);
    }
    if (!found)
        fprintf(stderr, "sgad: --state DIR is needed, or --config FILE with a state in it\n");
    return found;
}
