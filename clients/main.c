/* sga: solves a request, here or by a daemon, and prints the result. */
#include "code_view.h"
#include "pretty.h"
#include "run.h"
#include "save.h"
#include "solve.h"
#include "top.h"

#include <errno.h>
#include <stdbool.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

enum { DONE = 0, FAILED = 1, USAGE = 2 };

struct arguments {
    const char *file, *server;
    const char *csv, *svg;       /* where the tradeoff goes, or NULL */
    double wait;
    const char *language;        /* of `sga code`, else NULL */
    bool json, text, interpret_only;
};

static const char usage[] =
    "usage: sga solve FILE [--server URL] [--ca FILE] [--json | --text] [--wait SECONDS]\n"
    "                      [--tradeoff-csv FILE] [--tradeoff-svg FILE] [--interpret-only]\n"
    "       sga code FILE --language L [--server URL] [--ca FILE] [--wait SECONDS]\n"
    "       sga top [--server URL] [--ca FILE] [--every SECONDS] [--once]\n"
    "       sga version\n"
    "       sga --help\n"
    "\n"
    "solve reads a request (JSON) from FILE, or from standard input where FILE is -, and\n"
    "prints the result: as JSON, or as text on a terminal.\n"
    "\n"
    "code solves a request, and prints constraints, reduced field, gauge fields, Jacobian and\n"
    "a projection as source: --language c, python, matlab, julia, casadi, modelica, or as\n"
    "formulas in print: latex, mathml.\n"
    "\n"
    "top shows what a daemon does: queue, stages, rates, refusals.\n"
    "\n"
    "  --server URL     http://HOST:PORT, https://HOST:PORT or unix:PATH of a daemon (else the variable\n"
    "                   SGA_SERVER, else the request runs in this process)\n"
    "  --ca FILE        certificates that are trusted for https (PEM; else SGA_CA, else the system's)\n"
    "  --wait SECONDS   stop waiting for the daemon after this time\n"
    "  --json, --text   choose the form\n"
    "  --tradeoff-csv FILE, --tradeoff-svg FILE\n"
    "                   put the tradeoff that the request wants into a table or an image\n"
    "  --interpret-only make no machine code of formulas in this process: the same answer, later\n"
    "\n"
    "The variable SGA_TOKEN holds the token for a daemon that wants one.\n"
    "\n"
    "Exit code: 0 solved, 1 not solved (the reason is on standard error), 2 wrong usage.\n";

static int bad_usage(const char *what, const char *which)
{
    fprintf(stderr, "sga: %s%s\n%s", what, which, usage);
    return USAGE;
}

static bool read_all(FILE *f, struct sga_buf *out)
{
    char piece[16384];
    size_t n;
    while ((n = fread(piece, 1, sizeof piece, f)) > 0)
        sga_buf_put(out, piece, n);
    return !ferror(f);
}

static bool read_request(const char *file, struct sga_buf *out)
{
    FILE *f = strcmp(file, "-") == 0 ? stdin : fopen(file, "re");
    bool ok = f && read_all(f, out);
    if (!ok)
        fprintf(stderr, "sga: cannot read %s: %s\n", file, strerror(errno));
    if (f && f != stdin)
        fclose(f);
    return ok;
}

static int print_result(const struct answer *a, bool text)
{
    struct sga_buf out = { 0 };
    struct slice result = scan_value(a->text.data, a->text.data + a->text.len);
    if (text)
        pretty_text(result, &out);
    else
        pretty_json(result, &out);
    bool ok = fwrite(out.data, 1, out.len, stdout) == out.len && fflush(stdout) == 0;
    sga_buf_free(&out);
    if (!ok)
        fprintf(stderr, "sga: cannot write the result: %s\n", strerror(errno));
    return ok ? DONE : FAILED;
}

static void print_problem(const struct answer *a)
{
    fprintf(stderr, "sga: %s\n", a->problem);
    if (!a->readable && a->text.len)      /* programs get the problem object */
        print_result(a, false);
}

/* The answer as source. What made it is this program: there is no job. */
static int print_code(const struct arguments *args, const struct answer *a, struct slice request)
{
    struct sga_buf out = { 0 };
    struct sga_error err = { 0 };
    struct slice result = scan_value(a->text.data, a->text.data + a->text.len);
    bool ok = code_view(request, result, (struct code_origin){ "(none: sga code)", sga_version() }, export_language_find(args->language), &out, &err);
    if (!ok)
        fprintf(stderr, "sga: %s: %s\n", sga_code_text(err.code), err.detail);
    else if (!(ok = fwrite(out.data, 1, out.len, stdout) == out.len && fflush(stdout) == 0))
        fprintf(stderr, "sga: cannot write the source: %s\n", strerror(errno));
    sga_buf_free(&out);
    return ok ? DONE : FAILED;
}

/* The result is shown; what else is wanted of it goes into files. */
static int finish(const struct arguments *args, const struct answer *a)
{
    int status = print_result(a, a->readable);
    struct slice result = scan_value(a->text.data, a->text.data + a->text.len);
    bool saved = !(args->csv || args->svg) || save_tradeoff(result, args->csv, args->svg);
    return saved ? status : FAILED;
}

static int solve(const struct arguments *args)
{
    struct sga_buf request = { 0 };
    struct answer a = { .readable = args->text || args->language || (!args->json && isatty(STDOUT_FILENO)), .interpret_only = args->interpret_only };
    int status = FAILED;
    if (read_request(args->file, &request)) {
        const char *text = request.data ? request.data : "";
        bool ok = args->server ? solve_there(args->server, text, request.len, args->wait, &a) : solve_here(text, request.len, &a, print_problem);
        if (ok)
            status = args->language ? print_code(args, &a, scan_value(text, text + request.len)) : finish(args, &a);
        else
            print_problem(&a);
    }
    sga_buf_free(&request);
    sga_buf_free(&a.text);
    return status;
}

static bool read_seconds(const char *text, double *out)
{
    char *end;
    *out = strtod(text, &end);
    return end != text && !*end && *out > 0 && *out < 1e9;
}

/* `code` needs a language, and nothing else takes one. */
static int check_language(const struct arguments *args, bool code)
{
    if (code && !args->language)
        return bad_usage("code needs --language", "");
    if (!code && args->language)
        return bad_usage("--language belongs to code", "");
    if (code && (args->json || args->text || args->csv || args->svg))
        return bad_usage("code prints source alone", "");
    return !code || export_language_find(args->language) != EXPORT_LANGUAGES ? DONE : bad_usage("unknown language ", args->language);
}

static int read_arguments(int argc, char **argv, struct arguments *args)
{
    *args = (struct arguments){ .server = getenv("SGA_SERVER") };
    if (args->server && !*args->server)
        args->server = NULL;
    for (int i = 2; i < argc; i++) {
        const char *a = argv[i];
        bool csv = strcmp(a, "--tradeoff-csv") == 0, svg = strcmp(a, "--tradeoff-svg") == 0;
        bool takes = csv || svg || strcmp(a, "--server") == 0 || strcmp(a, "--wait") == 0 || strcmp(a, "--ca") == 0 || strcmp(a, "--language") == 0;
        if (takes && i + 1 >= argc)
            return bad_usage("a value is missing after ", a);
        if (strcmp(a, "--json") == 0)
            args->json = true;
        else if (strcmp(a, "--text") == 0)
            args->text = true;
        else if (strcmp(a, "--interpret-only") == 0)
            args->interpret_only = true;
        else if (strcmp(a, "--server") == 0)
            args->server = argv[++i];
        else if (csv || svg)
            *(csv ? &args->csv : &args->svg) = argv[++i];
        else if (strcmp(a, "--language") == 0)
            args->language = argv[++i];
        else if (strcmp(a, "--ca") == 0)
            setenv("SGA_CA", argv[++i], 1);       /* where http_parse looks */
        else if (strcmp(a, "--wait") == 0 && !read_seconds(argv[++i], &args->wait))
            return bad_usage("--wait needs a number of seconds, not ", argv[i]);
        else if (!takes && *a == '-' && a[1])
            return bad_usage("unknown option ", a);
        else if (!takes && args->file)
            return bad_usage("more than one file: ", a);
        else if (!takes)
            args->file = a;
    }
    if (args->json && args->text)
        return bad_usage("--json and --text exclude each other", "");
    return args->file ? check_language(args, strcmp(argv[1], "code") == 0) : bad_usage(argv[1], " needs a file");
}

static int top(int argc, char **argv)
{
    const char *url = getenv("SGA_SERVER");
    double seconds = 2;
    bool once = false;
    for (int i = 2; i < argc; i++) {
        if (strcmp(argv[i], "--once") == 0)
            once = true;
        else if (strcmp(argv[i], "--server") == 0 && i + 1 < argc)
            url = argv[++i];
        else if (strcmp(argv[i], "--ca") == 0 && i + 1 < argc)
            setenv("SGA_CA", argv[++i], 1);
        else if (strcmp(argv[i], "--every") != 0 || i + 1 >= argc || !read_seconds(argv[++i], &seconds))
            return bad_usage("unknown option, or one without a good value: ", argv[i]);
    }
    return url && *url ? top_run(url, seconds, once) : bad_usage("top needs --server URL", "");
}

int main(int argc, char **argv)
{
    struct arguments args;
    const char *command = argc > 1 ? argv[1] : "";
    if (strcmp(command, "--help") == 0 || strcmp(command, "-h") == 0 || strcmp(command, "help") == 0) {
        fputs(usage, stdout);
        return DONE;
    }
    if (strcmp(command, "version") == 0 || strcmp(command, "--version") == 0) {
        printf("sga %s\n", sga_version());
        return DONE;
    }
    if (strcmp(command, "top") == 0)
        return top(argc, argv);
    if (strcmp(command, "solve") != 0 && strcmp(command, "code") != 0)
        return *command ? bad_usage("unknown command ", command) : bad_usage("a command is missing", "");
    int status = read_arguments(argc, argv, &args);
    return status == DONE ? solve(&args) : status;
}
