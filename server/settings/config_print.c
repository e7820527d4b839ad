/* Settings as text, for people and as a file that can be read back. */
#include "config.h"
#include "settings.h"

#include <stdint.h>

static const char *yes_no(long value)
{
    return value ? "yes" : "no";
}

static void put_default(const struct setting *s, FILE *out)
{
    if (s->kind == SETTING_TEXT)
        fputs(s->text ? s->text : "", out);
    else if (s->kind == SETTING_SWITCH)
        fputs(yes_no(s->value), out);
    else
        fprintf(out, "%ld", s->value);
}

void config_usage(FILE *out)
{
    fprintf(out, "usage: sgad --listen 127.0.0.1:PORT --state DIR [--workers N] [--config FILE] [--NAME VALUE ...]\n"
                 "       sgad token create|list|revoke ...     tokens of those who may ask\n"
                 "       sgad backup FOLDER --state DIR        a copy of the state, while the daemon runs\n"
                 "       sgad restore FOLDER --state DIR       a backup, looked through, in the place of a state\n"
                 "       sgad check --state DIR                looks for damage in the state\n"
                 "       sgad prune --state DIR [--older DAYSd] [--keep JOBS] [--bytes BYTES]\n"
                 "                  [--results-older DAYSd] [--results-keep RESULTS]\n"
                 "                                             removes jobs that have ended, and results\n"
                 "       sgad migrate --store ADDRESS          makes the tables of a database that daemons share\n\n"
                 "A file holds lines `NAME = VALUE` with the same names; flags override it. SIGHUP reads the\n"
                 "file again and takes over the limits (marked *) and the tokens.\n\n");
    for (int i = 0; i < settings_count; i++) {
        const struct setting *s = &settings[i];
        fprintf(out, "  --%-28s%c %s", s->name, s->live ? '*' : ' ', s->help);
        if (s->kind != SETTING_TEXT || s->text)
            fputs(" (", out), put_default(s, out), fputc(')', out);
        fputc('\n', out);
    }
    fprintf(out, "  --%-28s  %s\n  --%-28s  %s\n  --%-28s  %s\n  --%-28s  %s\n  --%-28s  %s\n  --%-28s  %s\n", "config", "file of settings",
            "check-config", "read the settings, say what is wrong with them, and end",
            "print-config", "print the settings as they are in force, and end",
            "sample-config", "print a settings file with every default as a comment, and end",
            "check-sandbox", "try what the processes that run jobs must not be able to do, and say what came of it", "version", "print the version");
}

void config_print(const struct config *c, FILE *out)
{
    for (int i = 0; i < settings_count; i++) {
        const struct setting *s = &settings[i];
        const void *at = (const char *)c + s->offset;
        if (s->kind == SETTING_TEXT) {
            const char *text = *(char *const *)at;
            fprintf(out, text ? "%s = %s\n" : "# %s =\n", s->name, text);
        } else {
            long value = atomic_load((atomic_long *)(uintptr_t)at);
            if (s->kind == SETTING_SWITCH)
                fprintf(out, "%s = %s\n", s->name, yes_no(value));
            else
                fprintf(out, "%s = %ld\n", s->name, value);
        }
    }
}

void config_sample(FILE *out)
{
    fputs("# Settings of sgad. Lines are NAME = VALUE; what stands here as a comment is the default.\n"
          "# Flags of the same names override this file. sgad --check-config --config FILE checks it.\n"
          "# SIGHUP takes over the limits marked (live) without a new start.\n", out);
    for (int i = 0; i < settings_count; i++) {
        const struct setting *s = &settings[i];
        fprintf(out, "\n# %s", s->help);
        if (s->kind == SETTING_NUMBER)
            fprintf(out, " (%ld to %ld)", s->low, s->high);
        fprintf(out, "%s\n#%s =%s", s->live ? " (live)" : "", s->name, s->kind == SETTING_TEXT && !s->text ? "" : " ");
        put_default(s, out);
        fputc('\n', out);
    }
}
