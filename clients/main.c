/* sga: solves a request, here or by a daemon, and prints the result; looks at a daemon's jobs. */
#include "arguments.h"
#include "code_want.h"
#include "code_view.h"
#include "jobs_run.h"
#include "run.h"
#include "show.h"
#include "solve.h"
#include "top.h"

#include <errno.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "error.h"

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

/* Where the process ends inside a call: the request is not at hand. */
static void stuck(const struct answer *a)
{
    show_problem(a, (struct slice){ NULL, 0 });
}

/* The answer as source. What made it is this program: there is no job. */
static int print_code(const struct arguments *args, const struct answer *a, struct slice request)
{
    struct sga_buf out = { 0 }, plain = { 0 };
    struct sga_error err = { 0 };
    struct slice result = scan_value(a->text.data, a->text.data + a->text.len);
    bool ok = sga_plain(request.at, request.len, &plain, &err) && code_view((struct slice){ plain.data, plain.len }, result, (struct code_origin){ "(none: sga code)", sga_version() }, code_format_find(args->language), &out, &err);
    if (!ok)
        fprintf(stderr, "sga: %s: %s\n", sga_code_text(err.code), err.detail);
    int status = ok && show_open(args) ? show_text(&out) : FAILED;
    sga_buf_free(&plain);
    sga_buf_free(&out);
    return status;
}

/* The request; with what an export needs, where one is asked for. */
static bool read_wanted(const struct arguments *args, struct sga_buf *out)
{
    struct sga_buf given = { 0 };
    if (!args->language)
        return read_request(args->file, out);
    bool ok = read_request(args->file, &given);
    if (ok && given.len)
        code_want(given.data, given.len, strcmp(args->language, "fmu") == 0, out);
    sga_buf_free(&given);
    return ok;
}

static int solve(const struct arguments *args)
{
    struct sga_buf request = { 0 };
    struct answer a = { .readable = show_readable(args), .interpret_only = args->interpret_only, .processes = args->processes };
    int status = FAILED;
    if (read_wanted(args, &request)) {
        const char *text = request.data ? request.data : "";
        bool ok = args->server ? solve_there(args->server, text, request.len, args->wait, &a) : solve_here(text, request.len, &a, stuck);
        if (ok)
            status = args->language ? print_code(args, &a, scan_value(text, text + request.len)) : show_result(args, &a);
        else
            show_problem(&a, (struct slice){ text, request.len });
    }
    sga_buf_free(&request);
    sga_buf_free(&a.text);
    return a.interrupted ? INTERRUPTED : status;
}

static int check(const struct arguments *args)
{
    struct sga_buf request = { 0 };
    int status = FAILED;
    if (read_request(args->file, &request))
        status = check_run(args, request.data ? request.data : "", request.len);
    sga_buf_free(&request);
    return status;
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
        else if (strcmp(argv[i], "--every") != 0 || i + 1 >= argc || !arguments_seconds(argv[++i], &seconds))
            return bad_usage("unknown option, or one without a good value: ", argv[i]);
    }
    return url && *url ? top_run(url, seconds, once) : bad_usage("top needs --server URL", "");
}

int main(int argc, char **argv)
{
    struct arguments args;
    const char *command = argc > 1 ? argv[1] : "";
    if (strcmp(command, "--help") == 0 || strcmp(command, "-h") == 0 || strcmp(command, "help") == 0) {
        fputs(arguments_usage, stdout);
        return DONE;
    }
    if (strcmp(command, "version") == 0 || strcmp(command, "--version") == 0) {
        printf("sga %s\n", sga_version());
        return DONE;
    }
    if (strcmp(command, "top") == 0)
        return top(argc, argv);
    if (!*command)
        return bad_usage("a command is missing", "");
    int status = arguments_read(argc, argv, &args);
    if (status != DONE)
        return status;
    return args.command <= CODE ? solve(&args) : args.command == CHECK ? check(&args) : jobs_run(&args);
}
