/* sgad backup, sgad restore and sgad check. */
#include "command.h"
#include "state_files.h"

#include <stdio.h>
#include <stdlib.h>

struct wish { const char *folder, *state, *config; };

static int bad(const char *usage, const char *arg)
{
    fprintf(stderr, "sgad: unexpected or incomplete: '%s'\nusage: sgad %s\n", arg, usage);
    return COMMAND_USAGE;
}

static int read_wish(int argc, char **argv, bool folder, const char *usage, struct wish *w)
{
    for (int i = 2; i < argc; i++) {
        const char *value, *arg = argv[i];
        if ((value = command_option(argc, argv, &i, "state")))
            w->state = value;
        else if ((value = command_option(argc, argv, &i, "config")))
            w->config = value;
        else if (folder && !w->folder && *arg != '-')
            w->folder = arg;
        else
            return bad(usage, arg);
    }
    return folder && !w->folder ? bad(usage, "no folder") : COMMAND_DONE;
}

int command_backup(int argc, char **argv)
{
    struct wish w = { NULL };
    int status = read_wish(argc, argv, true, "backup FOLDER --state DIR | --config FILE", &w);
    if (status != COMMAND_DONE)
        return status;
    char *state = command_state(w.state, w.config);
    status = !state ? COMMAND_USAGE : state_copy(state, w.folder) ? COMMAND_DONE : COMMAND_FAILED;
    free(state);
    return status;
}

int command_restore(int argc, char **argv)
{
    struct wish w = { NULL };
    int status = read_wish(argc, argv, true, "restore FOLDER --state DIR | --config FILE", &w);
    if (status != COMMAND_DONE)
        return status;
    char *state = command_state(w.state, w.config);
    status = !state ? COMMAND_USAGE : state_copy(w.folder, state) ? COMMAND_DONE : COMMAND_FAILED;
    free(state);
    return status;
}

int command_check(int argc, char **argv)
{
    struct wish w = { NULL };
    int status = read_wish(argc, argv, false, "check --state DIR | --config FILE", &w);
    if (status != COMMAND_DONE)
        return status;
    char *state = command_state(w.state, w.config);
    status = !state ? COMMAND_USAGE : state_sound(state, false) ? COMMAND_DONE : COMMAND_FAILED;
    free(state);
    return status;
}
