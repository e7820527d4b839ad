/* Solving by a daemon: post, and where the answer is 202, ask again until the job ends. */
#include "budget.h"
#include "interrupt.h"
#include "json_string.h"
#include "progress.h"
#include "solve.h"
#include "there.h"

#include <stdio.h>
#include <string.h>
#include <time.h>

enum { LONG_POLL = 20 };     /* seconds that one HTTP request waits */

void problem_there(struct slice problem, struct answer *a)
{
    struct sga_buf b = { 0 };
    sga_buf_clear(&a->text);
    if (problem.at)
        sga_buf_put(&a->text, problem.at, problem.len);
    struct slice code = scan_member(problem, "code"), pointer = scan_member(problem, "pointer");
    struct slice line = scan_member(problem, "line"), detail = scan_member(problem, "detail");
    if (!code.at) {
        snprintf(a->problem, sizeof a->problem, "the server's reply cannot be read");
        return;
    }
    string_put(&b, code);
    if (pointer.at && pointer.len > 2) {
        sga_buf_puts(&b, " at ");
        string_put(&b, pointer);
    }
    if (line.at)
        sga_buf_printf(&b, ", line %g, column %g", scan_number(line, 0), scan_number(scan_member(problem, "column"), 0));
    sga_buf_puts(&b, ": ");
    string_put(&b, detail);
    snprintf(a->problem, sizeof a->problem, "%s", b.data);
    sga_buf_free(&b);
}

/* True once the reply says how it ended; *ok tells whether there is a result. */
static bool ended(const struct http_reply *reply, struct answer *a, bool *ok)
{
    struct slice all = scan_value(reply->body.data, reply->body.data + reply->body.len);
    if (reply->status >= 300 || !all.at) {
        problem_there(all, a);
        return true;
    }
    struct slice result = scan_member(all, "result"), error = scan_member(all, "error");
    *ok = result.at != NULL;
    if (result.at)
        sga_buf_put(&a->text, result.at, result.len);
    else if (error.at)
        problem_there(error, a);
    return result.at || error.at;
}

/* Where a line of progress is shown, often. */
static int poll_seconds(double until, const struct progress *shown)
{
    double left = until - sga_now(), most = shown && shown->on ? 1 : LONG_POLL;
    return until == 0 || left > most ? (int)most : left > 1 ? (int)left : 1;
}

static void show_progress(struct progress *shown, const struct http_reply *reply)
{
    struct slice p = scan_member(scan_value(reply->body.data, reply->body.data + reply->body.len), "progress"), stage = scan_member(p, "stage");
    struct sga_buf name = { 0 };
    if (shown->on && stage.at) {
        string_put(&name, stage);
        progress_show(shown, name.data, scan_number(scan_member(p, "fraction"), 0));
    }
    sga_buf_free(&name);
}

/* Nobody waits for it any longer. */
static void withdraw(const struct http_server *server, const char *path, struct answer *a)
{
    struct http_reply reply;
    char why[512];
    bool told = http_ask(server, "DELETE", path, NULL, 0, 0, &reply, why, sizeof why) && reply.status < 300;
    if (told)
        snprintf(a->problem, sizeof a->problem, "interrupted; the job %s was cancelled", path);
    else
        snprintf(a->problem, sizeof a->problem, "interrupted; the job %s could not be cancelled", path);
    sga_buf_free(&reply.body);
    a->interrupted = true;
}

static void rest(void)
{
    struct timespec pause = { .tv_nsec = 50000000 };
    nanosleep(&pause, NULL);        /* a server that does not wait is not to be asked in a tight loop */
}

bool answer_there(const struct http_server *server, const char *path, struct http_reply *reply, double until, struct answer *a)
{
    bool ok = false;
    struct progress shown;
    progress_begin(&shown);
    while (!ended(reply, a, &ok)) {
        show_progress(&shown, reply);
        if (*path != '/' || (until > 0 && sga_now() >= until)) {
            snprintf(a->problem, sizeof a->problem, "the job has not ended yet; it is %s", path);
            break;
        }
        rest();
        sga_buf_free(&reply->body);
        if (interrupted() || !http_ask(server, "GET", path, NULL, 0, poll_seconds(until, &shown), reply, a->problem, sizeof a->problem)) {
            progress_end(&shown);
            if (interrupted())
                withdraw(server, path, a);
            return false;
        }
    }
    progress_end(&shown);
    sga_buf_free(&reply->body);
    return ok;
}

bool server_there(const char *url, struct http_server *server, struct answer *a)
{
    if (http_parse(url, server))
        return true;
    snprintf(a->problem, sizeof a->problem, "'%s' is no address of the form http://HOST:PORT, https://HOST:PORT or unix:PATH", url);
    return false;
}

/* The post itself does not wait, so that the job's name is known as soon as there is a job; Ctrl-C before that cancels it then. */
bool solve_there(const char *url, const char *request, size_t length, double seconds, struct answer *a)
{
    struct http_server server;
    struct http_reply reply;
    char path[sizeof reply.location];
    double until = seconds > 0 ? sga_now() + seconds : 0;
    interrupt_catch();
    if (!server_there(url, &server, a) || !http_ask(&server, "POST", "/v1/solve", request, length, 0, &reply, a->problem, sizeof a->problem))
        return false;
    snprintf(path, sizeof path, "%s", reply.location);
    return answer_there(&server, path, &reply, until, a);
}

bool job_there(const char *url, const char *id, bool wait, double seconds, struct answer *a)
{
    struct http_server server;
    struct http_reply reply;
    char path[sizeof reply.location];
    double until = !wait ? sga_now() : seconds > 0 ? sga_now() + seconds : 0;
    snprintf(path, sizeof path, "/v1/jobs/%.200s", id);
    return server_there(url, &server, a) && http_ask(&server, "GET", path, NULL, 0, 0, &reply, a->problem, sizeof a->problem) &&
           answer_there(&server, path, &reply, until, a);
}
