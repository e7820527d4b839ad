/* Requests that are read: what comes out of each member. */
#include <math.h>
#include <string.h>

#include "buf.h"
#include "check.h"
#include "error.h"
#include "parse.h"
#include "request.h"

static bool read(struct request *r, const char *text)
{
    struct sga_error err = { 0 };
    bool ok = request_read(r, text, strlen(text), &err);
    CHECK(ok, "%s\n  %s at %s %d:%d: %s", text, sga_code_text(err.code), err.pointer, err.line, err.column, err.detail);
    return ok;
}

/* The expression of a text in the request's own names. */
static expr_id says(struct request *r, const char *text)
{
    return expr_parse(&r->store, text, NULL, NULL);
}

static const char *name_of(const struct request *r, int variable)
{
    return r->store.symbol[r->system.variable[variable].symbol].name;
}

static void quasilinear(void)
{
    struct request r;
    if (!read(&r, "{\"system\":{\"name\":\"two\",\"form\":\"quasilinear\",\"variables\":[\"x\",\"y\"],"
                  "\"parameters\":{\"r\":\"1/3\",\"s\":null,\"q\":0.1},"
                  "\"A\":[[1,\"x*r\"],[0,\"q*s\"]],\"alpha\":[\"y\",\"t\"],\"restrict\":\"x - r\"}}"))
        return;
    CHECK(r.system.rows == 2 && r.system.variables == 2 && r.system.restrictions == 1 && r.system.parameters == 1, "sizes");
    CHECK(!r.system.square && strcmp(r.name, "two") == 0 && strcmp(r.form, "quasilinear") == 0, "names");
    CHECK(r.system.row[0].entries == 2 && r.system.row[1].entries == 1 && r.system.row[1].entry[0].col == 1, "zeros dropped");
    CHECK(r.system.row[0].entry[1].value == says(&r, "x*(1/3)"), "parameters are their values");
    CHECK(r.system.row[1].entry[0].value == says(&r, "0.1*s"), "0.1 is 1/10; a null parameter stays");
    CHECK(r.system.row[1].alpha == says(&r, "t") && r.store.symbol[r.system.time].kind == EXPR_TIME, "time");
    CHECK(r.system.restriction[0] == says(&r, "x - 1/3"), "restrict, a scalar for a list");
    CHECK(r.want == (REQUEST_CONSTRAINTS | REQUEST_INDEX | REQUEST_VECTOR_FIELD | REQUEST_GAUGE), "the default want");
    CHECK(r.accuracy.rtol == 1e-8 && r.accuracy.atol == 1e-10 && r.limits.seconds == 30 && !r.trajectory.has, "defaults");
    request_clear(&r);
}

/* The same system in other spellings gives the same rows. */
static void spellings(void)
{
    static const char *const same[] = {
        "\"A\":[[1,\"x\"],[\"0\",2.5]],\"alpha\":[\"y\",\"x^2\"]",
        "\"A\":{\"rows\":2,\"cols\":2,\"entries\":[[1,1,\"5/2\"],[0,1,\"x\"],[0,0,\"1\"]]},\"alpha\":[\"y\",\"x**2\"]",
        "\"A\":{\"rows\":2,\"cols\":2,\"entries\":[[1,1,2],[0,1,\"x\"],[0,0,\"1\"],[1,1,0.5]]},\"alpha\":[\"y\",\"x*x\"],\"transpose\":false",
        "\"A\":[[\"1\",0],[\"x\",\"2.50\"]],\"alpha\":[\"y\",\"x^2\"],\"transpose\":true,\"restrict\":[]",
    };
    for (int i = 0; i < 4; i++) {
        char text[512];
        struct request r;
        snprintf(text, sizeof text, "{\"system\":{\"form\":\"quasilinear\",\"variables\":[\"x\",\"y\"],%s}}", same[i]);
        if (!read(&r, text))
            continue;
        const struct sys_row *row = r.system.row;
        CHECK(r.system.square && row[0].entries == 2 && row[1].entries == 1 && row[1].entry[0].col == 1, "%s", same[i]);
        CHECK(row[0].entry[1].value == says(&r, "x") && row[1].entry[0].value == says(&r, "5/2")
                  && row[1].alpha == says(&r, "x^2"), "%s", same[i]);
        request_clear(&r);
    }
    struct request r;
    if (read(&r, "{\"system\":{\"form\":\"quasilinear\",\"variables\":\"x\",\"A\":2,\"alpha\":\"-x\"}}")) {
        CHECK(r.system.rows == 1 && r.system.variables == 1 && r.system.row[0].entries == 1, "scalars for lists");
        request_clear(&r);
    }
    if (read(&r, "{\"system\":{\"form\":\"quasilinear\",\"variables\":[\"x\",\"y\"],\"A\":[1,\"x\"],\"alpha\":0}}")) {
        CHECK(r.system.rows == 1 && r.system.row[0].entries == 2, "a flat row");
        request_clear(&r);
    }
    if (read(&r, "{\"system\":{\"form\":\"quasilinear\",\"variables\":[\"x\"],\"A\":[1,\"x\"],\"alpha\":[0, 1]}}")) {
        CHECK(r.system.rows == 2 && r.system.row[1].entries == 1, "a flat column");
        request_clear(&r);
    }
    if (read(&r, "{\"system\":{\"form\":\"quasilinear\",\"variables\":[\"x\"],\"A\":[],\"alpha\":[],\"restrict\":[\"x\"]}}")) {
        CHECK(r.system.rows == 0 && r.system.restrictions == 1, "no rows, on a submanifold");
        request_clear(&r);
    }
}

static void equations(void)
{
    struct request r;
    if (!read(&r, "{\"system\":{\"form\":\"equations\",\"variables\":[\"x\",\"y\",\"lam\"],\"time\":\"tau\",\"parameters\":{\"g\":9.81},"
                  "\"equations\":[\"x'' = -lam*x\",\"der(y, 2) = -lam*y - g\",\"x^2 + y^2 == 1\"]},"
                  "\"want\":[\"index\",\"trajectory\"],\"limits\":{\"seconds\":\"1/4\",\"nodes\":100000},"
                  "\"accuracy\":{\"rtol\":1e-6,\"arithmetic\":\"double\",\"method\":\"dopri\"},\"strata\":true,"
                  "\"trajectory\":{\"stop\":\"pi\",\"samples\":5,\"initial\":{\"y\":\"-sqrt(2)/2\",\"x'\":0.1,\"x\":\"1/3\"},"
                  "\"hold\":[\"x\",\"y'\"],\"outputs\":[\"x\",\"x'*y + g\",2],"
                  "\"gauge\":{\"rates\":{\"lam\":\"0\"},\"conditions\":[\"x - 1\"]}}}"))
        return;
    const struct request_trajectory *t = &r.trajectory;
    CHECK(r.system.variables == 5 && r.system.rows == 5 && r.system.square, "order reduction");
    CHECK(strcmp(r.store.symbol[r.system.time].name, "tau") == 0 && strcmp(r.system.row[3].source, "definition of x'") == 0, "names");
    CHECK(r.want == (REQUEST_INDEX | REQUEST_TRAJECTORY) && r.limits.seconds == 0.25 && r.strata, "options");
    CHECK(r.accuracy.rtol == 1e-6 && r.accuracy.arithmetic == REQUEST_DOUBLE && strcmp(r.accuracy.method, "dopri") == 0, "accuracy");
    CHECK(t->has && t->start == 0 && t->samples == 5 && t->times[4] == M_PI && fabs(t->times[1] - M_PI / 4) < 1e-15, "times");
    CHECK(t->initials == 3 && strcmp(name_of(&r, t->initial[0].variable), "x") == 0 && t->initial[0].value == 1.0 / 3
              && strcmp(t->initial[0].text, "1/3") == 0, "initial in the order of the variables");
    CHECK(fabs(t->initial[1].value + sqrt(0.5)) < 1e-15 && strcmp(name_of(&r, t->initial[2].variable), "x'") == 0
              && t->initial[2].value == 0.1, "initial of a derivative");
    CHECK(t->holds == 2 && strcmp(name_of(&r, t->hold[1]), "y'") == 0, "hold");
    CHECK(t->outputs == 3 && strcmp(t->output_text[1], "x'*y + g") == 0 && strcmp(t->output_text[2], "2") == 0, "outputs");
    CHECK(t->rates == 1 && expr_is_zero(&r.store, t->rate[0].rate) && t->conditions == 1
              && t->condition[0] == says(&r, "x - 1"), "gauge");
    request_clear(&r);
}

static void times(void)
{
    struct request r;
    const char *head = "{\"system\":{\"form\":\"quasilinear\",\"variables\":\"x\",\"A\":1,\"alpha\":\"x\"},\"trajectory\":";
    struct { const char *text; double start, last; int samples; } table[] = {
        { "{\"stop\":2}", 0, 2, 101 },
        { "{\"start\":1,\"stop\":-1,\"samples\":2}", 1, -1, 2 },
        { "{\"times\":[0.5,1,4]}", 0.5, 4, 3 },
        { "{\"times\":3,\"start\":1}", 1, 3, 1 },
        { "{\"times\":[\"-1/2\",-1],\"start\":0}", 0, -1, 2 },
    };
    for (int i = 0; i < 5; i++) {
        char text[512];
        snprintf(text, sizeof text, "%s%s}", head, table[i].text);
        if (!read(&r, text))
            continue;
        CHECK(r.trajectory.start == table[i].start && r.trajectory.samples == table[i].samples
                  && r.trajectory.times[table[i].samples - 1] == table[i].last, "%s", text);
        CHECK(r.want & REQUEST_TRAJECTORY, "a trajectory that is there is wanted");
        request_clear(&r);
    }
    char text[512];
    snprintf(text, sizeof text, "%s{\"initial\":{\"x\":1}},\"want\":\"consistent_initial\"}", head);
    if (read(&r, text)) {
        CHECK(r.want == REQUEST_CONSISTENT_INITIAL && r.trajectory.initials == 1 && !r.trajectory.times, "no stop needed");
        request_clear(&r);
    }
}

static void canonical(void)
{
    static const char *const same[] = { "{\"b\":[1,2.0,\"x\\u0041\"],\"a\":{\"d\":null,\"c\":true}}",
                                        " { \"a\" : {\"c\":true,\n\"d\":null}, \"b\":[1e0, 2,\"xA\"]} " };
    struct sga_buf b[2] = { { 0 }, { 0 } };
    for (int i = 0; i < 2; i++) {
        struct sga_error err = { 0 };
        CHECK(request_canonical(same[i], strlen(same[i]), &b[i], &err), "%s", err.detail);
    }
    CHECK(b[0].data && strcmp(b[0].data, "{\"a\":{\"c\":true,\"d\":null},\"b\":[1,2,\"xA\"]}") == 0, "%s", b[0].data);
    CHECK(b[1].data && strcmp(b[0].data, b[1].data) == 0, "%s", b[1].data);
    struct sga_buf again = { 0 };
    CHECK(request_canonical(b[0].data, b[0].len, &again, NULL) && strcmp(again.data, b[0].data) == 0, "a fixed point");
    sga_buf_free(&again);
    sga_buf_free(&b[0]);
    sga_buf_free(&b[1]);
}

/* One request of each other form: variables with their roles, rows, square. */
static void other_forms(void)
{
    static const struct {
        const char *system;
        int variables, rows, restrictions;
        bool square;
        const char *last, *role;
    } table[] = {
        { "\"form\":\"linear\",\"variables\":\"x\",\"A\":1,\"B\":-1,\"C\":1,\"inputs\":\"sin(t)\"", 1, 1, 0, true, "x", "variable" },
        { "\"form\":\"linear\",\"variables\":\"x\",\"A\":1,\"B\":-1,\"C\":[[1,2]],\"inputs\":[\"u\",3]", 2, 1, 0, false, "u", "input" },
        { "\"form\":\"linear\",\"variables\":\"x\",\"A\":1,\"B\":-1,\"C\":2,\"D\":3,\"inputs\":\"u\"", 1, 1, 0, true, "x", "variable" },
        { "\"form\":\"control\",\"variables\":\"x\",\"inputs\":\"u\",\"F\":0,\"G\":1,\"constraints\":\"x\"", 2, 2, 0, true, "u", "input" },
        { "\"form\":\"hamiltonian\",\"variables\":[\"q\",\"p\"],\"hamiltonian\":\"p^2\"", 2, 2, 0, true, "p", "variable" },
        { "\"form\":\"hamiltonian\",\"variables\":[\"q\",\"p\"],\"hamiltonian\":\"p^2\",\"restrict\":\"p\"", 2, 0, 1, false, "p", "variable" },
        { "\"form\":\"lagrangian\",\"coordinates\":\"q\",\"lagrangian\":\"der(q)^2 - q\"", 2, 2, 0, true, "q'", "velocity" },
        { "\"form\":\"lagrangian\",\"coordinates\":\"q\",\"lagrangian\":\"q'^2\",\"holonomic\":\"q\"", 3, 3, 0, true, "lambda1", "multiplier" },
    };
    for (size_t i = 0; i < sizeof table / sizeof *table; i++) {
        char text[400];
        struct request r;
        snprintf(text, sizeof text, "{\"system\":{%s}}", table[i].system);
        if (!read(&r, text))
            continue;
        const struct sys_system *s = &r.system;
        CHECK(s->variables == table[i].variables && s->rows == table[i].rows && s->restrictions == table[i].restrictions
                  && s->square == table[i].square, "%s", table[i].system);
        CHECK(strcmp(name_of(&r, s->variables - 1), table[i].last) == 0
                  && strcmp(s->variable[s->variables - 1].role, table[i].role) == 0, "%s", table[i].system);
        request_clear(&r);
    }
}

/* Bounds of who asks end the reading without a word against the request. */
static void bounds(void)
{
    struct sga_buf b = { 0 };
    struct request r;
    sga_buf_puts(&b, "{\"system\":{\"form\":\"quasilinear\",\"variables\":\"x\",\"A\":1,\"alpha\":\"x");
    for (int i = 1; i < 3000; i++)
        sga_buf_printf(&b, "+sin(%d*x)", i);
    sga_buf_puts(&b, "\"}}");
    struct request_bounds wide = { .seconds = 1000, .nodes = 100000 }, few = { .seconds = 1000, .nodes = 2000 };
    struct request_bounds brief = { .seconds = -1, .nodes = 100000 };
    struct sga_error err = { 0 };
    CHECK(request_read_within(&r, b.data, b.len, &wide, &err) && !wide.met, "%s", err.detail);
    request_clear(&r);
    CHECK(!request_read_within(&r, b.data, b.len, &few, &err) && few.met && err.code == SGA_E_LIMIT_NODES, "%s", err.detail);
    sga_buf_clear(&b);
    sga_buf_puts(&b, "{\"system\":{\"form\":\"quasilinear\",\"variables\":\"x\",\"A\":1,\"alpha\":\"x");
    for (int i = 1; i < 20000; i++)
        sga_buf_printf(&b, "+sin(%d*x)", i);
    sga_buf_puts(&b, "\"}}");
    err = (struct sga_error){ 0 };
    CHECK(!request_read_within(&r, b.data, b.len, &brief, &err) && brief.met && err.code == SGA_E_LIMIT_SECONDS, "%s", err.detail);
    sga_buf_clear(&b);
    sga_buf_puts(&b, "{\"system\":{\"form\":\"quasilinear\",\"variables\":\"x\",\"A\":1,\"alpha\":\"x+\"}}");
    err = (struct sga_error){ 0 };
    CHECK(!request_read_within(&r, b.data, b.len, &few, &err) && !few.met && err.code == SGA_E_EXPR_SYNTAX, "%s", err.detail);
    sga_buf_free(&b);
}

int main(void)
{
    quasilinear();
    spellings();
    other_forms();
    equations();
    times();
    canonical();
    bounds();
    return CHECK_END();
}
