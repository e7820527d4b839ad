/* Each command takes some of the options; a table says which. */
#include "arguments.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "code_view.h"

const char arguments_usage[] =
    "usage: sga solve FILE [--server URL] [--ca FILE] [--json | --text | --csv | --svg | --npy | --mat]\n"
    "                      [--output FILE] [--wait SECONDS] [--tradeoff-csv FILE] [--tradeoff-svg FILE] [--interpret-only]\n"
    "                      [--processes N]\n"
    "       sga plot FILE [--columns NAMES] [--x NAME] [--output FILE] [--server URL] [--ca FILE] [--wait SECONDS]\n"
    "       sga code FILE --language L [--output FILE] [--server URL] [--ca FILE] [--wait SECONDS]\n"
    "       sga check FILE [--server URL] [--ca FILE] [--json | --text]\n"
    "       sga list [--status S] [--limit N] [--server URL] [--ca FILE] [--json | --text]\n"
    "       sga get ID | sga wait ID [--wait SECONDS] [--server URL] [--ca FILE]\n"
    "                      [--json | --text | --csv | --svg | --npy | --mat] [--output FILE]\n"
    "                      [--tradeoff-csv FILE] [--tradeoff-svg FILE]\n"
    "       sga cancel ID | sga events ID [--server URL] [--ca FILE] [--json | --text]\n"
    "       sga ready [--server URL] [--ca FILE]\n"
    "       sga top [--server URL] [--ca FILE] [--every SECONDS] [--once]\n"
    "       sga version\n"
    "       sga --help\n"
    "\n"
    "solve reads a request (JSON) from FILE, or from standard input where FILE is -, and\n"
    "prints the result: as JSON, or as text on a terminal. Ctrl-C cancels the job of a daemon.\n"
    "\n"
    "code solves a request, and prints constraints, reduced field, gauge fields, Jacobian and\n"
    "a projection as source: --language c, python, matlab, julia, casadi, modelica, or as\n"
    "formulas in print: latex, mathml, or as a source FMU of FMI 3.0: fmu.\n"
    "\n"
    "check reads a request, runs nothing, and says all that is wrong with it.\n"
    "\n"
    "list, get, wait, cancel and events are about the jobs of a daemon: the newest ones, a\n"
    "result, a result once it is there, an end, and what happens until it ends.\n"
    "\n"
    "ready says whether a daemon takes jobs, and why not: for probes.\n"
    "\n"
    "top shows what a daemon does: queue, stages, rates, refusals.\n"
    "\n"
    "  --server URL     http://HOST:PORT, https://HOST:PORT or unix:PATH of a daemon (else the variable\n"
    "                   SGA_SERVER, else the request runs in this process)\n"
    "  --ca FILE        certificates that are trusted for https (PEM; else SGA_CA, else the system's)\n"
    "  --wait SECONDS   stop waiting for the daemon after this time\n"
    "  --json, --text   choose the form\n"
    "  --csv            print the samples of the trajectory alone, as CSV\n"
    "  --svg            print an image of the trajectory; plot is solve --svg\n"
    "  --npy, --mat     the samples as a file of NumPy or a MAT-file (level 5), with --output or into a pipe\n"
    "  --output FILE    print into a file, which is made once there is something (-o FILE, too)\n"
    "  --columns NAMES  curves of the image, separated by commas (all); --x NAME: what they stand over (time)\n"
    "  --status S       jobs of these statuses alone, separated by commas\n"
    "  --limit N        so many jobs at the most (50)\n"
    "  --tradeoff-csv FILE, --tradeoff-svg FILE\n"
    "                   put the tradeoff that the request wants into a table or an image\n"
    "  --interpret-only make no machine code of formulas in this process: the same answer, later\n"
    "  --processes N    a sweep that takes long is made by so many processes (1); 0: one for each processor\n"
    "\n"
    "The variable SGA_TOKEN holds the token for a daemon that wants one.\n"
    "\n"
    "Exit code: 0 solved, 1 not solved (the reason is on standard error), 2 wrong usage, 130 Ctrl-C.\n";

/* A letter for each option (options below), and what the command's word is. */
static const struct {
    const char *name, *takes, *word;
} commands[COMMANDS] = {
    [SOLVE] = { "solve", "sawjtcvnmoXYTSip", "a file" }, [PLOT] = { "plot", "sawXYoip", "a file" }, [CODE] = { "code", "sawloi", "a file" }, [CHECK] = { "check", "sajt", "a file" },
    [LIST] = { "list", "sajtuN", NULL }, [GET] = { "get", "sajtcvnmoXYTS", "the id of a job" }, [WAIT] = { "wait", "sawjtcvnmoXYTS", "the id of a job" },
    [CANCEL] = { "cancel", "sajt", "the id of a job" }, [EVENTS] = { "events", "sajt", "the id of a job" }, [READY] = { "ready", "sajt", NULL },
};

static const struct {
    const char *name;
    char letter;
    bool value;
} options[] = {
    { "--server", 's', true }, { "--ca", 'a', true }, { "--wait", 'w', true }, { "--json", 'j', false }, { "--text", 't', false },
    { "--csv", 'c', false }, { "--tradeoff-csv", 'T', true }, { "--tradeoff-svg", 'S', true }, { "--interpret-only", 'i', false },
    { "--language", 'l', true }, { "--svg", 'v', false }, { "--npy", 'n', false }, { "--mat", 'm', false },
    { "--output", 'o', true }, { "-o", 'o', true }, { "--columns", 'Y', true }, { "--x", 'X', true }, { "--status", 'u', true }, { "--limit", 'N', true },
    { "--processes", 'p', true },
};
enum { OPTIONS = sizeof options / sizeof *options, MOST_PROCESSES = 256 };

int bad_usage(const char *what, const char *which)
{
    fprintf(stderr, "sga: %s%s\nsga --help says how it is used.\n", what, which);
    return USAGE;
}

bool arguments_seconds(const char *text, double *out)
{
    char *end;
    *out = strtod(text, &end);
    return end != text && !*end && *out > 0 && *out < 1e9;
}

static int set_processes(struct arguments *args, const char *value)
{
    char *end;
    long n = strtol(value, &end, 10), processors = sysconf(_SC_NPROCESSORS_ONLN);
    if (end == value || *end || n < 0 || n > MOST_PROCESSES)
        return bad_usage("--processes needs a number from 0 to 256, not ", value);
    args->processes = (int)(n ? n : processors > 1 ? processors : 1);
    return DONE;
}

static int set(struct arguments *args, char letter, const char *value)
{
    switch (letter) {
    case 's': args->server = value; break;
    case 'a': setenv("SGA_CA", value, 1); break;       /* where http_parse looks */
    case 'j': args->json = true; break;
    case 't': args->text = true; break;
    case 'c': args->csv = true; break;
    case 'v': args->svg = true; break;
    case 'n': args->npy = true; break;
    case 'm': args->mat = true; break;
    case 'o': args->output = value; break;
    case 'Y': args->columns = value; break;
    case 'X': args->x = value; break;
    case 'T': args->tradeoff_csv = value; break;
    case 'S': args->tradeoff_svg = value; break;
    case 'i': args->interpret_only = true; break;
    case 'l': args->language = value; break;
    case 'u': args->status = value; break;
    case 'N': args->limit = value; break;
    case 'p': return set_processes(args, value);
    case 'w': return arguments_seconds(value, &args->wait) ? DONE : bad_usage("--wait needs a number of seconds, not ", value);
    }
    return DONE;
}

static int read_one(struct arguments *args, char **argv, int argc, int *i)
{
    const char *a = argv[*i];
    int k = 0;
    if (*a != '-' || !a[1]) {
        if (args->file || !commands[args->command].word)
            return bad_usage(args->file ? "more than one file: " : "nothing belongs there: ", a);
        args->file = a;
        return DONE;
    }
    while (k < OPTIONS && strcmp(options[k].name, a) != 0)
        k++;
    if (k == OPTIONS)
        return bad_usage("unknown option ", a);
    if (!strchr(commands[args->command].takes, options[k].letter)) {
        char what[80];
        snprintf(what, sizeof what, "%s does not take ", commands[args->command].name);
        return bad_usage(what, a);
    }
    if (options[k].value && *i + 1 >= argc)
        return bad_usage("a value is missing after ", a);
    return set(args, options[k].letter, options[k].value ? argv[++*i] : NULL);
}

static bool is_job(const char *id)
{
    size_t n = strspn(id, "0123456789abcdefghijklmnopqrstuvwxyz");
    return n > 0 && !id[n];
}

/* Ids come as messages have them, too: /v1/jobs/ID. */
static int check_word(struct arguments *args)
{
    static const char before[] = "/v1/jobs/";
    if (!args->file)
        return commands[args->command].word ? bad_usage(commands[args->command].name, args->command <= CHECK ? " needs a file, or - for standard input" : " needs the id of a job") : DONE;
    if (args->command <= CHECK)
        return DONE;
    if (strncmp(args->file, before, strlen(before)) == 0)
        args->file += strlen(before);
    return is_job(args->file) ? DONE : bad_usage("this is no id of a job: ", args->file);
}

static int check_together(const struct arguments *args)
{
    if (args->json + args->text + args->csv + args->svg + args->npy + args->mat > 1)
        return bad_usage("--json, --text, --csv, --svg, --npy and --mat exclude each other", "");
    if ((args->npy || args->mat) && !args->output && isatty(STDOUT_FILENO))
        return bad_usage("bytes of a file are nothing for a terminal: add --output FILE", "");
    if ((args->columns || args->x) && !args->svg)
        return bad_usage("--columns and --x belong to an image: add --svg", "");
    if (args->command > CHECK && !args->server)
        return bad_usage(commands[args->command].name, " needs --server URL, or the variable SGA_SERVER");
    if (args->command == CODE && !args->language)
        return bad_usage("code needs --language", "");
    if (args->language && strcmp(args->language, "fmu") == 0 && !args->output && isatty(STDOUT_FILENO))
        return bad_usage("an archive is nothing for a terminal: add --output FILE", "");
    return !args->language || code_format_find(args->language) != CODE_FORMATS ? DONE : bad_usage("unknown language ", args->language);
}

int arguments_read(int argc, char **argv, struct arguments *args)
{
    const char *server = getenv("SGA_SERVER");
    *args = (struct arguments){ .server = server && *server ? server : NULL };
    while (args->command < COMMANDS && strcmp(commands[args->command].name, argv[1]) != 0)
        args->command++;
    if (args->command == COMMANDS)
        return bad_usage("unknown command ", argv[1]);
    int status = DONE;
    args->svg = args->command == PLOT;
    for (int i = 2; i < argc && status == DONE; i++)
        status = read_one(args, argv, argc, &i);
    status = status == DONE ? check_word(args) : status;
    return status == DONE ? check_together(args) : status;
}
