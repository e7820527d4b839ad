/* Standard output has the answer, standard error what is said about it. */
#include "show.h"

#include <errno.h>
#include <stdio.h>
#include <string.h>
#include <unistd.h>

#include "caret.h"
#include "motion_svg.h"
#include "pretty.h"
#include "samples.h"
#include "samples_files.h"
#include "save.h"
#include "view.h"

bool show_readable(const struct arguments *args)
{
    return args->text || args->csv || args->svg || args->npy || args->mat || args->language || (!args->json && !args->output && isatty(STDOUT_FILENO));
}

int show_text(const struct sga_buf *text)
{
    if (fwrite(text->data, 1, text->len, stdout) == text->len && fflush(stdout) == 0)
        return DONE;
    fprintf(stderr, "sga: cannot write the result: %s\n", strerror(errno));
    return FAILED;
}

int show_json(struct slice value)
{
    struct sga_buf out = { 0 };
    pretty_json(value, &out);
    int status = show_text(&out);
    sga_buf_free(&out);
    return status;
}

static int show_csv(struct slice result)
{
    struct slice t = scan_member(result, "trajectory");
    struct sga_buf out = { 0 };
    struct view v;
    if (!t.at)
        t = scan_member(result, "trajectories");
    if (!t.at || !view_open(&v, VIEW_CSV, t)) {
        fprintf(stderr, "sga: the result has no trajectory: add \"trajectory\" to the request\n");
        return FAILED;
    }
    int status = DONE;
    while (status == DONE && view_line(&v, &out)) {
        status = show_text(&out);
        sga_buf_clear(&out);
    }
    view_close(&v);
    sga_buf_free(&out);
    return status;
}

/* An image, or bytes for other programs. */
static int show_samples(const struct arguments *args, struct slice result)
{
    struct slice t = scan_member(result, "trajectory");
    struct sga_buf out = { 0 }, why = { 0 };
    struct samples s;
    bool ok = samples_read(&s, t.at ? t : scan_member(result, "trajectories"));
    if (!ok)
        sga_buf_puts(&why, "the result has no samples: add \"trajectory\" to the request");
    else if (args->svg)
        ok = motion_svg(&s, args->columns, args->x, &out, &why);
    else if (args->npy)
        samples_npy(&s, &out);
    else if (!(ok = samples_mat(&s, &out)))
        sga_buf_puts(&why, "the samples are longer than a MAT-file of level 5 can be");
    if (!ok)
        fprintf(stderr, "sga: %s\n", why.data);
    int status = ok ? show_text(&out) : FAILED;
    samples_end(&s);
    sga_buf_free(&out);
    sga_buf_free(&why);
    return status;
}

bool show_open(const struct arguments *args)
{
    bool ok = !args->output || freopen(args->output, "we", stdout);
    if (!ok)
        fprintf(stderr, "sga: cannot write %s: %s\n", args->output, strerror(errno));
    return ok;
}

int show_result(const struct arguments *args, const struct answer *a)
{
    struct slice result = scan_value(a->text.data, a->text.data + a->text.len);
    int status;
    if (!show_open(args))
        return FAILED;
    if (args->csv) {
        status = show_csv(result);
    } else if (args->svg || args->npy || args->mat) {
        status = show_samples(args, result);
    } else if (a->readable) {
        struct sga_buf out = { 0 };
        pretty_text(result, &out);
        status = show_text(&out);
        sga_buf_free(&out);
    } else {
        status = show_json(result);
    }
    bool saved = !(args->tradeoff_csv || args->tradeoff_svg) || save_tradeoff(result, args->tradeoff_csv, args->tradeoff_svg);
    return saved ? status : FAILED;
}

void show_problem(const struct answer *a, struct slice request)
{
    fprintf(stderr, "sga: %s\n", a->problem);
    if (!a->text.len)
        return;
    struct slice problem = scan_value(a->text.data, a->text.data + a->text.len);
    struct sga_buf mark = { 0 };
    if (request.at)
        caret_put(&mark, problem, request);
    if (mark.len)
        fputs(mark.data, stderr);
    sga_buf_free(&mark);
    if (!a->readable)
        show_json(problem);
}
