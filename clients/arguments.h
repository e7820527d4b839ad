/* What a command line says. */
#ifndef CLIENTS_ARGUMENTS_H
#define CLIENTS_ARGUMENTS_H

#include <stdbool.h>

enum { DONE = 0, FAILED = 1, USAGE = 2, INTERRUPTED = 130 };

enum command { SOLVE, PLOT, CODE, CHECK, LIST, GET, WAIT, CANCEL, EVENTS, READY, COMMANDS };

struct arguments {
    enum command command;
    const char *file;            /* or the id of a job */
    const char *server;
    const char *tradeoff_csv, *tradeoff_svg;       /* where the tradeoff goes, or NULL */
    double wait;
    const char *language;        /* of `sga code`, else NULL */
    const char *status, *limit;  /* of `sga list`, or NULL */
    const char *columns, *x;     /* of an image, or NULL */
    int processes;               /* for a job of this process */
    const char *output;          /* the file that standard output becomes, or NULL */
    bool json, text, csv, svg, npy, mat, interpret_only;
};

extern const char arguments_usage[];

/* Says on standard error what is wrong, and how it is right; USAGE. */
int bad_usage(const char *what, const char *which);
/* From the command in argv[1] on. DONE, or USAGE: said on standard error. */
int arguments_read(int argc, char **argv, struct arguments *args);
bool arguments_seconds(const char *text, double *out);

#endif
