/* The table of settings: the one list that the parser, --help, --print-config, the sample
 * file and the check of the manual page read. */
#ifndef SERVER_SETTINGS_H
#define SERVER_SETTINGS_H

#include <stdbool.h>
#include <stddef.h>

enum setting_kind { SETTING_TEXT, SETTING_NUMBER, SETTING_SWITCH };

struct setting {
    const char *name;
    size_t offset;            /* in struct config: char * of a text, else atomic_long */
    enum setting_kind kind;
    bool live;                /* SIGHUP changes it; the others need a new start */
    const char *text;         /* default of a text; NULL: none */
    long value, low, high;    /* default and range of a number or a switch (0, 1) */
    const char *help;
};

extern const struct setting settings[];
extern const int settings_count;

/* The setting of this name, or NULL. */
const struct setting *setting_find(const char *name, size_t length);

#endif
