/* Every allocation fails once, in turn, while requests, expressions and JSON are read and
 * written. The library's own allocations, and those of FLINT and GMP, end the process by the
 * wall, which tells the code memory_limit; those of the JSON library come back as an error with
 * that code, and nothing is lost (the leak sanitizer looks at the end of each process). Each
 * failure happens in a process of its own. The linker leads malloc to the functions below. */
#include <string.h>
#include <sys/wait.h>
#include <unistd.h>

#include "budget.h"
#include "buf.h"
#include "check.h"
#include "error.h"
#include "parse.h"
#include "print.h"
#include "request.h"
#include "watch.h"

enum { WHOLE = 0, REFUSED = 40, WALL = 41, WRONG_CODE = 42 };

void *__real_malloc(size_t size);
void *__real_calloc(size_t count, size_t size);
void *__real_realloc(void *p, size_t size);
void *__wrap_malloc(size_t size);
void *__wrap_calloc(size_t count, size_t size);
void *__wrap_realloc(void *p, size_t size);

static long allocations, fail_at;      /* 0: none fails */

static bool fails(void)
{
    return ++allocations == fail_at;
}

void *__wrap_malloc(size_t size) { return fails() ? NULL : __real_malloc(size); }
void *__wrap_calloc(size_t count, size_t size) { return fails() ? NULL : __real_calloc(count, size); }
void *__wrap_realloc(void *p, size_t size) { return fails() ? NULL : __real_realloc(p, size); }

static void wall(void *ctx, const struct sga_error *err)
{
    (void)ctx;
    _exit(err->code == SGA_E_LIMIT_MEMORY && *err->detail ? WALL : WRONG_CODE);
}

/* A reader under test: true where it came to its end. */
typedef bool reader(const char *text, struct sga_error *err);

static bool read_request(const char *text, struct sga_error *err)
{
    struct request r;
    bool ok = request_read(&r, text, strlen(text), err);
    if (ok)
        request_clear(&r);
    return ok;
}

static bool canonical(const char *text, struct sga_error *err)
{
    struct sga_buf out = { 0 };
    bool ok = request_canonical(text, strlen(text), &out, err);
    sga_buf_free(&out);
    return ok;
}

static bool expression(const char *text, struct sga_error *err)
{
    struct expr_store st;
    struct sga_buf out = { 0 };
    expr_store_init(&st);
    expr_symbol_add(&st, "x", EXPR_VARIABLE);
    expr_symbol_add(&st, "y", EXPR_VARIABLE);
    expr_id e = expr_parse(&st, text, NULL, err);
    bool ok = e != EXPR_UNDEF && expr_print(&st, e, 1 << 16, &out);
    sga_buf_free(&out);
    expr_store_clear(&st);
    return ok;
}

static bool writer(const char *text, struct sga_error *err)
{
    struct sga_buf out = { 0 };
    struct sga_json w;
    (void)err;
    sga_json_begin(&w, &out);
    sga_json_object(&w);
    for (int i = 0; i < 300; i++) {
        sga_json_member_string(&w, text, "value \n \"quoted\"");
        sga_json_member_double(&w, "number", 0.1 * i);
    }
    sga_json_end_object(&w);
    sga_buf_free(&out);
    return true;
}

/* In a process of its own: how it ends. */
static int attempt(reader *read, const char *text, long at)
{
    pid_t pid = fork();
    if (pid == 0) {
        struct sga_budget budget = { .max_memory = (size_t)1 << 40 };
        struct sga_error err = { 0 };
        sga_watch_begin(&budget, wall, NULL);
        allocations = 0;
        fail_at = at;
        bool ok = read(text, &err);
        bool past = allocations < at;
        fail_at = 0;
        sga_watch_end();
        flint_cleanup();
        exit(ok && past ? WHOLE : !ok && err.code == SGA_E_LIMIT_MEMORY && *err.detail ? REFUSED : WRONG_CODE);
    }
    int status = 0;
    waitpid(pid, &status, 0);
    return WIFEXITED(status) ? WEXITSTATUS(status) : -WTERMSIG(status);
}

static void every_one(const char *name, reader *read, const char *text)
{
    struct sga_error err = { 0 };
    int ended[3] = { 0 }, step = 4 / check_scale(4), status = REFUSED;
    CHECK(read(text, &err), "%s: %s at %s: %s", name, sga_code_text(err.code), err.pointer, err.detail);
    long at = 1;
    for (; status != WHOLE && at < 100000; at += step) {
        status = attempt(read, text, at);
        CHECK(status == WHOLE || status == REFUSED || status == WALL, "%s: allocation %ld fails: ended with %d", name, at, status);
        ended[status == WALL ? 2 : status == REFUSED ? 1 : 0]++;
    }
    CHECK(status == WHOLE && at > step, "%s: no end", name);
    printf("%s: %d by the wall, %d as an error\n", name, ended[2], ended[1]);
}

static const struct { const char *name, *text; } requests[] = {
    { "quasilinear", "{\"system\":{\"name\":\"n\",\"form\":\"quasilinear\",\"variables\":[\"x\",\"y\"],\"parameters\":{\"r\":\"1/3\",\"s\":null},"
      "\"A\":[[1,\"x*r\"],[0,\"123456789012345678901234567890*s\"]],\"alpha\":[\"y\",\"sin(t)\"],\"restrict\":\"x - r\"},\"want\":[\"index\"]}" },
    { "equations", "{\"system\":{\"form\":\"equations\",\"variables\":[\"x\",\"y\",\"lam\"],\"parameters\":{\"g\":\"9.81\"},\"equations\":"
      "[\"x'' = -lam*x\",\"der(y, 2) = -lam*y - g\",\"x^2 + y^2 = 1\"]},\"trajectory\":{\"stop\":10,\"samples\":5,\"initial\":{\"x\":1,\"y\":0},"
      "\"hold\":[\"x\"],\"outputs\":[\"x*y\"],\"events\":[{\"name\":\"e\",\"expression\":\"y\"}]},\"sweep\":[{\"initial\":{\"x\":\"1/2\"}}]}" },
    { "linear", "{\"system\":{\"form\":\"linear\",\"variables\":[\"x\",\"y\"],\"A\":[[1,0],[0,0]],\"B\":[[1,\"1/7\"],[1,1]],\"C\":[[1],[0]],\"inputs\":[\"u\"]}}" },
    { "hamiltonian", "{\"system\":{\"form\":\"hamiltonian\",\"variables\":[\"q1\",\"p1\"],\"hamiltonian\":\"p1^2/2 + q1^2/2\"},"
      "\"symmetries\":{\"check\":[{\"name\":\"turn\",\"field\":{\"q1\":\"p1\",\"p1\":\"-q1\"}}],\"search\":{\"degree\":1}},\"want\":[\"symmetries\"]}" },
    { "lagrangian", "{\"system\":{\"form\":\"lagrangian\",\"coordinates\":[\"x\",\"y\"],\"lagrangian\":\"(x'^2 + y'^2)/2 - y\",\"holonomic\":[\"x^2 + y^2 - 1\"]}}" },
    { "mechanical", "{\"system\":{\"form\":\"mechanical\",\"coordinates\":[\"x\",\"y\"],\"masses\":[1,2],\"forces\":[\"0\",\"-y'\"],\"constraints\":[\"x'^2 + y'^2 - 1\"]}}" },
    { "control", "{\"system\":{\"form\":\"control\",\"variables\":[\"x\",\"y\"],\"inputs\":[\"u\"],\"F\":[\"y\",\"0\"],\"G\":[[0,1]],\"constraints\":[\"x - y\"]}}" },
    { "operator", "{\"system\":{\"form\":\"operator\",\"unknowns\":[\"x\",\"y\"],\"coefficients\":[[[1,\"t\"],[0,1]],[[\"t^2\",0],[1,0]]],\"sources\":[\"e\",\"f\"]}}" },
};

int main(void)
{
    sga_watch_init();
    sga_watch_hook();
    request_init();
    for (size_t i = 0; i < sizeof requests / sizeof *requests; i++)
        every_one(requests[i].name, read_request, requests[i].text);
    every_one("canonical text", canonical, requests[1].text);
    every_one("expression", expression, "sin(x)^3*(y - 1/3)/(x + 123456789012345678901234567890123) - min(x, y, 2.5e-30) + x^y");
    every_one("JSON writer", writer, "a member of some length");
    return CHECK_END();
}
