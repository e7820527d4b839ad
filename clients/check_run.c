/* The daemon and the library say the same of a request (schema/check.json). */
#include <stdio.h>
#include <string.h>

#include "caret.h"
#include "jobs_run.h"
#include "json_string.h"
#include "run.h"
#include "show.h"
#include "there.h"

static bool is(struct slice v, const char *text)
{
    return v.at && v.len == strlen(text) && !memcmp(v.at, text, v.len);
}

static void put_place(struct sga_buf *out, struct slice said, const char *kind)
{
    struct slice pointer = scan_member(said, "pointer"), column = scan_member(said, "column");
    sga_buf_puts(out, kind);
    string_put(out, scan_member(said, "code"));
    if (pointer.at && pointer.len > 2) {
        sga_buf_puts(out, " at ");
        string_put(out, pointer);
    }
    if (column.at)
        sga_buf_printf(out, ", line %g, column %g", scan_number(scan_member(said, "line"), 1), scan_number(column, 0));
    sga_buf_puts(out, ": ");
    string_put(out, scan_member(said, "detail"));
    sga_buf_puts(out, "\n");
}

static void put_all(struct sga_buf *out, struct slice review, struct slice request)
{
    struct slice valid = scan_member(review, "valid"), one, list[2] = { scan_member(review, "problems"), scan_member(review, "warnings") };
    for (int k = 0; k < 2; k++) {
        const char *cursor = NULL;
        while ((one = scan_next(list[k], &cursor)).at) {
            put_place(out, one, k ? "warning: " : "");
            caret_put(out, one, request);
        }
    }
    if (is(valid, "null"))
        sga_buf_puts(out, "nothing is known against it; reading all of it takes longer than a check may\n");
    else if (is(valid, "true"))
        sga_buf_printf(out, "valid: %g equations, %g unknowns\n", scan_number(scan_member(review, "equations"), 0),
                       scan_number(scan_member(review, "unknowns"), 0));
}

/* The review into text; false: there is none, which was said. */
static bool review(const struct arguments *args, const char *request, size_t length, struct sga_buf *text)
{
    struct http_server server;
    struct http_reply reply = { 0 };
    struct answer a = { .readable = show_readable(args) };
    if (!args->server) {
        sga_init();
        sga_review(request, length, text);
        return true;
    }
    bool ok = server_there(args->server, &server, &a) && http_ask(&server, "POST", "/v1/check", request, length, 0, &reply, a.problem, sizeof a.problem);
    if (ok && reply.status != 200) {
        problem_there(reply.body.data ? scan_value(reply.body.data, reply.body.data + reply.body.len) : (struct slice){ NULL, 0 }, &a);
        ok = false;
    }
    if (ok)
        sga_buf_put(text, reply.body.data, reply.body.len);
    else
        show_problem(&a, (struct slice){ request, length });
    sga_buf_free(&reply.body);
    sga_buf_free(&a.text);
    return ok;
}

int check_run(const struct arguments *args, const char *request, size_t length)
{
    struct sga_buf text = { 0 }, out = { 0 };
    if (!review(args, request, length, &text))
        return FAILED;
    struct slice said = scan_value(text.data, text.data + text.len);
    int status = FAILED;
    if (show_readable(args)) {
        put_all(&out, said, (struct slice){ request, length });
        status = show_text(&out);
    } else {
        status = show_json(said);
    }
    bool good = status == DONE && !is(scan_member(said, "valid"), "false");
    sga_buf_free(&text);
    sga_buf_free(&out);
    return good ? DONE : FAILED;
}
