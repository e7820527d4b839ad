/* Solving by a daemon: post, and where the answer is 202, ask again until the job ends. */
#include "budget.h"
#include "http_client.h"
#include "json_scan.h"
#include "json_string.h"
#include "solve.h"

#include <stdio.h>
#include <string.h>
#include <time.h>

enum { LONG_POLL = 20 };     /* seconds that one HTTP request waits */

/* "code at POINTER, line L, column C: detail" from problem details. */
static void describe(struct slice problem, struct answer *a)
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
        describe(all, a);
        return true;
    }
    struct slice result = scan_member(all, "result"), error = scan_member(all, "error");
    *ok = result.at != NULL;
    if (result.at)
        sga_buf_put(&a->text, result.at, result.len);
    else if (error.at)
        describe(error, a);
    return result.at || error.at;
}

static int poll_seconds(double until)
{
    double left = until - sga_now();
    return until == 0 || left > LONG_POLL ? LONG_POLL : left > 1 ? (int)left : 1;
}

bool solve_there(const char *url, const char *request, size_t length, double seconds, struct answer *a)
{
    struct http_server server;
    struct http_reply reply;
    bool ok = false;
    double until = seconds > 0 ? sga_now() + seconds : 0;
    if (!http_parse(url, &server)) {
        snprintf(a->problem, sizeof a->problem, "'%s' is no address of the form http://HOST:PORT, https://HOST:PORT or unix:PATH", url);
        return false;
    }
    if (!http_ask(&server, "POST", "/v1/solve", request, length, poll_seconds(until), &reply, a->problem, sizeof a->problem))
        return false;
    char path[sizeof reply.location];
    snprintf(path, sizeof path, "%s", reply.location);
    while (!ended(&reply, a, &ok)) {
        if (*path != '/' || (until > 0 && sga_now() >= until)) {
            snprintf(a->problem, sizeof a->problem, "the job has not ended yet; it is %s", path);
            break;
        }
        struct timespec pause = { .tv_nsec = 50000000 };
        nanosleep(&pause, NULL);        /* a server that does not wait is not to be asked in a tight loop */
        sga_buf_free(&reply.body);
        if (!http_ask(&server, "GET", path, NULL, 0, poll_seconds(until), &reply, a->problem, sizeof a->problem))
            return false;
    }
    sga_buf_free(&reply.body);
    return ok;
}
