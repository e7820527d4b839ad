/* Each command is one exchange with the daemon, and a text or JSON of its reply. */
#include "jobs_run.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "json_string.h"
#include "show.h"
#include "there.h"

static const struct slice nowhere = { NULL, 0 };

static struct slice whole(const struct sga_buf *b)
{
    return b->data ? scan_value(b->data, b->data + b->len) : nowhere;
}

/* Appends a member as text, "-" where it is null or is not there, then spaces up to a width. */
static void put_cell(struct sga_buf *out, struct slice object, const char *member, int width)
{
    struct slice v = scan_member(object, member);
    size_t before = out->len;
    if (!v.at || (v.len == 4 && !memcmp(v.at, "null", 4)))
        sga_buf_puts(out, "-");
    else
        string_put(out, v);
    do
        sga_buf_puts(out, " ");
    while ((int)(out->len - before) < width);
}

static int show_and_free(struct sga_buf *out)
{
    int status = show_text(out);
    sga_buf_free(out);
    return status;
}

/* One exchange; false: it was said why not. The body is the caller's. */
static bool ask(const struct arguments *args, const char *method, const char *path, struct http_reply *reply)
{
    struct http_server server;
    struct answer a = { .readable = show_readable(args) };
    bool ok = server_there(args->server, &server, &a) && http_ask(&server, method, path, NULL, 0, 0, reply, a.problem, sizeof a.problem);
    if (ok && reply->status >= 300) {
        problem_there(whole(&reply->body), &a);
        sga_buf_free(&reply->body);
        ok = false;
    }
    if (!ok)
        show_problem(&a, nowhere);
    sga_buf_free(&a.text);
    return ok;
}

static void put_row(struct sga_buf *out, struct slice job)
{
    put_cell(out, job, "id", 34);
    put_cell(out, job, "status", 10);
    put_cell(out, job, "form", 14);
    put_cell(out, job, "verdict", 17);
    put_cell(out, job, "created", 26);
    put_cell(out, job, "name", 0);
    out->data[out->len - 1] = '\n';      /* for the space behind the last one */
}

static int list(const struct arguments *args)
{
    struct http_reply reply;
    struct sga_buf out = { 0 };
    const char *cursor = NULL;
    sga_buf_printf(&out, "/v1/jobs?limit=%s%s%s", args->limit ? args->limit : "50", args->status ? "&status=" : "", args->status ? args->status : "");
    bool plain = strspn(out.data + 8, "abcdefghijklmnopqrstuvwxyz0123456789?=&,") == out.len - 8;
    if (!plain) {
        sga_buf_free(&out);
        return bad_usage("--status takes words with commas, --limit a number", "");
    }
    bool ok = ask(args, "GET", out.data, &reply);
    sga_buf_clear(&out);
    if (!ok)
        return FAILED;
    if (show_readable(args)) {
        struct slice jobs = scan_member(whole(&reply.body), "jobs"), job;
        sga_buf_puts(&out, "id                                status    form          verdict          created                   name\n");
        while ((job = scan_next(jobs, &cursor)).at)
            put_row(&out, job);
    } else {
        sga_buf_free(&out);
        int status = show_json(whole(&reply.body));
        sga_buf_free(&reply.body);
        return status;
    }
    sga_buf_free(&reply.body);
    return show_and_free(&out);
}

static int get(const struct arguments *args)
{
    struct answer a = { .readable = show_readable(args) };
    int status = FAILED;
    if (job_there(args->server, args->file, args->command == WAIT, args->wait, &a))
        status = show_result(args, &a);
    else
        show_problem(&a, nowhere);
    sga_buf_free(&a.text);
    return status;
}

static int cancel(const struct arguments *args)
{
    struct http_reply reply;
    char path[256];
    snprintf(path, sizeof path, "/v1/jobs/%.200s", args->file);
    if (!ask(args, "DELETE", path, &reply))
        return FAILED;
    struct slice job = whole(&reply.body);
    int status = DONE;
    if (!show_readable(args) && job.at)
        status = show_json(job);
    else if (show_readable(args))
        printf("%s\n", reply.status == 204 ? "withdrawn: it had ended, or goes on for others" : "cancelled");
    sga_buf_free(&reply.body);
    return status;
}

static int ready(const struct arguments *args)
{
    struct http_reply reply;
    if (!ask(args, "GET", "/readyz", &reply))
        return FAILED;
    int status = show_readable(args) ? (puts("ready"), DONE) : show_json(whole(&reply.body));
    sga_buf_free(&reply.body);
    return status;
}

/* -- Events -- */

struct watch {
    bool readable, end, done;
};

static void put_event(const struct watch *w, struct slice job)
{
    struct slice progress = scan_member(job, "progress"), t = scan_member(progress, "t");
    struct sga_buf out = { 0 };
    if (w->readable) {
        put_cell(&out, job, "status", 10);
        put_cell(&out, progress, "stage", 12);
        sga_buf_printf(&out, "%5.1f %%", 100 * scan_number(scan_member(progress, "fraction"), 0));
        if (t.at)
            sga_buf_printf(&out, "  t = %.6g", scan_number(t, 0));
    } else {
        sga_buf_put(&out, job.at, job.len);
    }
    sga_buf_puts(&out, "\n");
    show_and_free(&out);
}

static bool event_line(void *ctx, const char *text)
{
    struct watch *w = ctx;
    if (!strncmp(text, "event: end", 10))
        w->end = true;
    if (strncmp(text, "data: ", 6) != 0)
        return true;
    struct slice job = scan_value(text + 6, text + strlen(text)), status = scan_member(job, "status");
    put_event(w, job);
    w->done = status.len == 6 && !memcmp(status.at, "\"done\"", 6);
    return !w->end;
}

static int events(const struct arguments *args)
{
    struct watch w = { .readable = show_readable(args) };
    struct answer a = { .readable = w.readable };
    struct http_server server;
    struct http_reply reply = { 0 };
    char path[256];
    snprintf(path, sizeof path, "/v1/jobs/%.200s/events", args->file);
    bool ok = server_there(args->server, &server, &a) && http_lines(&server, path, event_line, &w, &reply, a.problem, sizeof a.problem);
    if (ok && reply.status != 200)
        problem_there(whole(&reply.body), &a);
    else if (ok && !w.end)
        snprintf(a.problem, sizeof a.problem, "the stream of events broke off before the job ended");
    if (*a.problem)
        show_problem(&a, nowhere);
    sga_buf_free(&reply.body);
    sga_buf_free(&a.text);
    return w.end && w.done ? DONE : FAILED;
}

int jobs_run(const struct arguments *args)
{
    switch (args->command) {
    case LIST: return list(args);
    case CANCEL: return cancel(args);
    case EVENTS: return events(args);
    case READY: return ready(args);
    default: return get(args);
    }
}
