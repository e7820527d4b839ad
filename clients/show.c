/* Standard output has the answer, standard error what is said about it. */
#include "show.h"

#include <errno.h>
#include <stdio.h>
#include <string.h>
#include <unistd.h>

#include "caret.h"
#include "motion_plot.h"
#include "pretty.h"
#include "save.h"
#include "view.h"

bool show_readable(const struct arguments *args)
{
    return args->text || args->csv || args->svg || args->language || (!args->json && isatty(STDOUT_FILENO));
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

static int show_svg(const struct arguments *args, struct slice result)
{
    struct sga_buf out = { 0 };
    int status = motion_plot(result, args->columns, args->x, &out) ? show_text(&out) : FAILED;
    sga_buf_free(&out);
    return status;
}

int show_result(const struct arguments *args, const struct answer *a)
{
    struct slice result = scan_value(a->text.data, a->text.data + a->text.len);
    int status;
    if (args->csv) {
        status = show_csv(result);
    } else if (args->svg) {
        status = show_svg(args, result);
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
