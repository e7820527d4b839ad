/* Requests that are refused: code, pointer, place, a word of the message. Then mutated
 * requests, which are read or refused with a code, and never crash. */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "buf.h"
#include "check.h"
#include "error.h"
#include "mem.h"
#include "request.h"

/* A system that is right, to put wrong things beside. */
#define GOOD "\"system\":{\"form\":\"quasilinear\",\"variables\":[\"x\",\"y\"],\"A\":[[1,0],[0,1]],\"alpha\":[\"y\",\"-x\"]}"
#define QL(members) "{\"system\":{\"form\":\"quasilinear\"," members "}}"
#define EQ(members) "{\"system\":{\"form\":\"equations\"," members "}}"
#define WITH(members) "{" GOOD "," members "}"
#define TRAJ(members) WITH("\"trajectory\":{" members "}")

static const struct {
    const char *text;
    enum sga_code code;
    const char *pointer;
    int line, column;      /* 0: not checked */
    const char *says;
} table[] = {
    { "", SGA_E_JSON_SYNTAX, "", 1, 1, "empty" },
    { " \n", SGA_E_JSON_SYNTAX, "", 1, 1, "empty" },
    { "{", SGA_E_JSON_SYNTAX, "", 1, 1, "" },
    { "{} x", SGA_E_JSON_SYNTAX, "", 1, 0, "end of file" },
    { "{\"system\":1,\n\"system\":2}", SGA_E_DUPLICATE_NAME, "", 2, 0, "system" },
    { "{\"a\":\"\xFF\"}", SGA_E_JSON_SYNTAX, "", 1, 0, "UTF-8" },
    { "{\"a\":\"\\u0000\"}", SGA_E_JSON_SYNTAX, "", 1, 0, "U+0000" },
    { "{\"a\":\n NaN}", SGA_E_JSON_SYNTAX, "", 2, 2, "no NaN" },
    { "{\"a\": -Infinity}", SGA_E_JSON_SYNTAX, "", 1, 8, "no NaN" },
    { "{\"a\": inf}", SGA_E_JSON_SYNTAX, "", 1, 7, "no NaN" },
    { "{\"a\": 1e-400}", SGA_E_JSON_NUMBER, "", 1, 7, "string" },
    { "{\"a\":[1,\n2,1e400]}", SGA_E_JSON_NUMBER, "", 2, 3, "string" },
    { "{\"a\": 9223372036854775808}", SGA_E_JSON_NUMBER, "", 1, 7, "string" },
    { "{\"a\": -9223372036854775809}", SGA_E_JSON_NUMBER, "", 1, 0, "string" },
    { "[]", SGA_E_SCHEMA, "", 0, 0, "an array" },
    { "3", SGA_E_SCHEMA, "", 0, 0, "a number" },
    { "{}", SGA_E_MISSING_MEMBER, "", 0, 0, "system" },
    { "{\"sistem\":{}}", SGA_E_UNKNOWN_MEMBER, "/sistem", 0, 0, "\"system\"" },
    { "{\"system\":{}, \"a/b~c\":1}", SGA_E_UNKNOWN_MEMBER, "/a~1b~0c", 0, 0, "known are" },
    { "{\"system\":[]}", SGA_E_SCHEMA, "/system", 0, 0, "an array" },
    { "{\"system\":{}}", SGA_E_MISSING_MEMBER, "/system", 0, 0, "form" },
    { "{\"system\":{\"form\":\"quasi-linear\"}}", SGA_E_SCHEMA, "/system/form", 0, 0, "\"quasilinear\"" },
    { "{\"system\":{\"form\":\"mechanical\"}}", SGA_E_MISSING_MEMBER, "/system", 0, 0, "coordinates" },
    { "{\"system\":{\"form\":\"mechanical\",\"coordinates\":[\"x\",\"y\"],\"masses\":[1]}}", SGA_E_SHAPE, "/system/masses", 0, 0, "1 masses" },
    { "{\"system\":{\"form\":\"mechanical\",\"coordinates\":\"x\",\"masses\":\"x'\"}}", SGA_E_EXPR_DERIVATIVE, "/system/masses", 1, 1, "" },
    { QL("\"A\":1,\"alpha\":1"), SGA_E_MISSING_MEMBER, "/system", 0, 0, "variables" },
    { QL("\"variables\":\"x\",\"alpha\":1"), SGA_E_MISSING_MEMBER, "/system", 0, 0, "\"A\"" },
    { QL("\"variables\":\"x\",\"A\":1"), SGA_E_MISSING_MEMBER, "/system", 0, 0, "alpha" },
    { QL("\"variables\":\"x\",\"A\":1,\"alpha\":1,\"equations\":[]"), SGA_E_UNKNOWN_MEMBER, "/system/equations", 0, 0, "known" },
    { QL("\"variables\":[],\"A\":[],\"alpha\":[]"), SGA_E_EMPTY_SYSTEM, "/system/variables", 0, 0, "variable" },
    { QL("\"variables\":\"x\",\"A\":[],\"alpha\":[]"), SGA_E_EMPTY_SYSTEM, "/system", 0, 0, "no equation" },
    { QL("\"variables\":[\"x\",\"x\"],\"A\":[],\"alpha\":[]"), SGA_E_DUPLICATE_NAME, "/system/variables/1", 0, 0, "x" },
    { QL("\"variables\":[\"x\",\"2x\"]"), SGA_E_BAD_NAME, "/system/variables/1", 0, 0, "2x" },
    { QL("\"variables\":[\"x'\"]"), SGA_E_BAD_NAME, "/system/variables/0", 0, 0, "letters" },
    { QL("\"variables\":[\"sin\"]"), SGA_E_BAD_NAME, "/system/variables/0", 0, 0, "grammar" },
    { QL("\"variables\":[\"pi\"]"), SGA_E_BAD_NAME, "/system/variables/0", 0, 0, "grammar" },
    { QL("\"variables\":\"t\""), SGA_E_BAD_NAME, "/system/variables", 0, 0, "system.time" },
    { QL("\"time\":\"s\",\"variables\":[\"t\",\"s\"]"), SGA_E_BAD_NAME, "/system/variables/1", 0, 0, "independent" },
    { QL("\"parameters\":{\"r\":1},\"variables\":[\"r\"]"), SGA_E_BAD_NAME, "/system/variables/0", 0, 0, "a parameter" },
    { QL("\"parameters\":{\"t\":1},\"variables\":[\"r\"]"), SGA_E_BAD_NAME, "/system/parameters/t", 0, 0, "independent" },
    { QL("\"parameters\":{\"exp\":1},\"variables\":[\"r\"]"), SGA_E_BAD_NAME, "/system/parameters/exp", 0, 0, "grammar" },
    { QL("\"parameters\":{\"r\":true},\"variables\":[\"x\"]"), SGA_E_SCHEMA, "/system/parameters/r", 0, 0, "true" },
    { QL("\"parameters\":{\"r\":\"1/\"},\"variables\":[\"x\"]"), SGA_E_EXPR_SYNTAX, "/system/parameters/r", 1, 3, "the end" },
    { QL("\"parameters\":{\"r\":1,\"s\":\"2*r\"},\"variables\":[\"x\"]"), SGA_E_EXPR_NAME, "/system/parameters/s", 1, 3, "r" },
    { QL("\"parameters\":[1],\"variables\":[\"x\"]"), SGA_E_SCHEMA, "/system/parameters", 0, 0, "an array" },
    { QL("\"variables\":[\"x\",3]"), SGA_E_SCHEMA, "/system/variables/1", 0, 0, "a number" },
    { QL("\"variables\":[\"x\",\"y\"],\"A\":[[1,2],[3]],\"alpha\":[1,2]"), SGA_E_SHAPE, "/system/A/1", 0, 0, "1 entries" },
    { QL("\"variables\":[\"x\",\"y\"],\"A\":[[1,2]],\"alpha\":[1,2]"), SGA_E_SHAPE, "/system/A", 0, 0, "1 rows" },
    { QL("\"variables\":[\"x\",\"y\"],\"A\":[[1,2,3]],\"alpha\":[1],\"transpose\":true"), SGA_E_SHAPE, "/system/A", 0, 0, "transpose" },
    { QL("\"variables\":[\"x\",\"y\"],\"A\":[[1,2],[3,\"x+\"]],\"alpha\":[1,2]"), SGA_E_EXPR_SYNTAX, "/system/A/1/1", 1, 3, "the end" },
    { QL("\"variables\":[\"x\",\"y\"],\"A\":[[1,2],[3,null]],\"alpha\":[1,2]"), SGA_E_SCHEMA, "/system/A/1/1", 0, 0, "null" },
    { QL("\"variables\":\"x\",\"A\":1,\"alpha\":\"x'\""), SGA_E_EXPR_DERIVATIVE, "/system/alpha", 1, 1, "not allowed" },
    { QL("\"variables\":\"x\",\"A\":1,\"alpha\":\"NaN\""), SGA_E_EXPR_UNDEFINED, "/system/alpha", 1, 1, "not a number" },
    { QL("\"variables\":\"x\",\"A\":1,\"alpha\":[\"9^9^9\"]"), SGA_E_LIMIT_EXPONENT, "/system/alpha/0", 1, 2, "10000" },
    { QL("\"variables\":\"x\",\"parameters\":{\"r\":0},\"A\":1,\"alpha\":[\"x/r\"]"), SGA_E_EXPR_UNDEFINED, "/system/alpha/0", 1, 2, "division" },
    { QL("\"variables\":\"x\",\"A\":1,\"alpha\":1,\"transpose\":\"yes\""), SGA_E_SCHEMA, "/system/transpose", 0, 0, "true or false" },
    { QL("\"variables\":\"x\",\"A\":{\"rows\":1,\"cols\":1},\"alpha\":1"), SGA_E_MISSING_MEMBER, "/system/A", 0, 0, "entries" },
    { QL("\"variables\":\"x\",\"A\":{\"rows\":2,\"cols\":1,\"entries\":[]},\"alpha\":1"), SGA_E_SHAPE, "/system/A/rows", 0, 0, "2 rows" },
    { QL("\"variables\":\"x\",\"A\":{\"rows\":1,\"cols\":1,\"entries\":[[0,0,1],[0,1,\"x\"]]},\"alpha\":1"), SGA_E_SHAPE, "/system/A/entries/1/1", 0, 0, "column 1" },
    { QL("\"variables\":\"x\",\"A\":{\"rows\":1,\"cols\":1,\"entries\":[[0,0]]},\"alpha\":1"), SGA_E_SHAPE, "/system/A/entries/0", 0, 0, "3 values" },
    { QL("\"variables\":\"x\",\"A\":{\"rows\":1,\"cols\":1,\"entries\":[[0.5,0,1]]},\"alpha\":1"), SGA_E_SCHEMA, "/system/A/entries/0/0", 0, 0, "integer" },
    { EQ("\"variables\":\"x\",\"equations\":[]"), SGA_E_EMPTY_SYSTEM, "/system/equations", 0, 0, "no equation" },
    { EQ("\"variables\":\"x\",\"equations\":[\"x' = 1\",\"x - 2\"]"), SGA_E_EXPR_SYNTAX, "/system/equations/1", 1, 6, "left = right" },
    { EQ("\"variables\":\"x\",\"equations\":[5]"), SGA_E_SCHEMA, "/system/equations/0", 0, 0, "a number" },
    { EQ("\"variables\":\"x\",\"equations\":\"x' =\\n 2*omga\""), SGA_E_EXPR_NAME, "/system/equations", 2, 4, "omga" },
    { EQ("\"variables\":\"x\",\"equations\":\"t' = x\""), SGA_E_EXPR_DERIVATIVE, "/system/equations", 1, 1, "'t'" },
    { WITH("\"want\":[\"index\",\"guage\"]"), SGA_E_SCHEMA, "/want/1", 0, 0, "\"gauge\"" },
    { WITH("\"want\":{\"index\":true}"), SGA_E_SCHEMA, "/want", 0, 0, "an object" },
    { WITH("\"want\":\"trajectory\""), SGA_E_MISSING_MEMBER, "", 0, 0, "\"trajectory\" is missing" },
    { WITH("\"strata\":1"), SGA_E_SCHEMA, "/strata", 0, 0, "true or false" },
    { WITH("\"symmetries\":{\"chek\":[]}"), SGA_E_UNKNOWN_MEMBER, "/symmetries/chek", 0, 0, "\"check\"" },
    { WITH("\"limits\":{\"seconds\":-1}"), SGA_E_SCHEMA, "/limits/seconds", 0, 0, "limits" },
    { WITH("\"limits\":{\"nodes\":1.5}"), SGA_E_SCHEMA, "/limits/nodes", 0, 0, "integer" },
    { WITH("\"limits\":{\"megabytes\":0}"), SGA_E_SCHEMA, "/limits/megabytes", 0, 0, "limits" },
    { WITH("\"limits\":{\"bits\":1000000}"), SGA_E_SCHEMA, "/limits/bits", 0, 0, "131072" },
    { WITH("\"limits\":{\"bits\":10}"), SGA_E_SCHEMA, "/limits/bits", 0, 0, "64" },
    { WITH("\"limits\":{\"terms\":0}"), SGA_E_SCHEMA, "/limits/terms", 0, 0, "limits" },
    { WITH("\"limits\":{\"memory\":1}"), SGA_E_UNKNOWN_MEMBER, "/limits/memory", 0, 0, "megabytes" },
    { "{\"system\":{\"form\":\"quasilinear\",\"variables\":\"x\",\"A\":1,\"alpha\":\"3^100*x\"},\"limits\":{\"bits\":100}}",
      SGA_E_LIMIT_BITS, "/system/alpha", 1, 0, "100 bits" },
    { WITH("\"accuracy\":{\"rtol\":0}"), SGA_E_SCHEMA, "/accuracy/rtol", 0, 0, "0.1" },
    { WITH("\"accuracy\":{\"arithmetic\":\"quad\"}"), SGA_E_SCHEMA, "/accuracy/arithmetic", 0, 0, "double-double" },
    { TRAJ("\"samples\":5"), SGA_E_MISSING_MEMBER, "/trajectory", 0, 0, "stop" },
    { TRAJ("\"stop\":1,\"samples\":1"), SGA_E_SCHEMA, "/trajectory/samples", 0, 0, "2 to 1000000" },
    { TRAJ("\"stop\":1,\"samples\":1000001"), SGA_E_SCHEMA, "/trajectory/samples", 0, 0, "1000000" },
    { TRAJ("\"stop\":1,\"times\":[1]"), SGA_E_SCHEMA, "/trajectory/times", 0, 0, "either" },
    { TRAJ("\"stop\":\"0*pi\""), SGA_E_SCHEMA, "/trajectory/stop", 0, 0, "no room" },
    { TRAJ("\"stop\":\"1e400\""), SGA_E_SCHEMA, "/trajectory/stop", 0, 0, "finite" },
    { TRAJ("\"stop\":\"x\""), SGA_E_SCHEMA, "/trajectory/stop", 0, 0, "constant" },
    { TRAJ("\"times\":[1,3,2]"), SGA_E_SCHEMA, "/trajectory/times/2", 0, 0, "one way" },
    { TRAJ("\"times\":[1,1]"), SGA_E_SCHEMA, "/trajectory/times/1", 0, 0, "one way" },
    { TRAJ("\"times\":[]"), SGA_E_SCHEMA, "/trajectory/times", 0, 0, "0 times" },
    { TRAJ("\"stop\":1,\"initial\":{\"z\":1}"), SGA_E_EXPR_NAME, "/trajectory/initial/z", 0, 0, "z" },
    { TRAJ("\"stop\":1,\"initial\":{\"x'\":1}"), SGA_E_EXPR_DERIVATIVE, "/trajectory/initial/x'", 0, 0, "first order" },
    { TRAJ("\"stop\":1,\"initial\":{\"x\":\"y\"}"), SGA_E_SCHEMA, "/trajectory/initial/x", 0, 0, "constant" },
    { TRAJ("\"stop\":1,\"initial\":{\"x\":\"NaN\"}"), SGA_E_EXPR_UNDEFINED, "/trajectory/initial/x", 1, 1, "not a number" },
    { TRAJ("\"stop\":1,\"initial\":{\"x\":null}"), SGA_E_SCHEMA, "/trajectory/initial/x", 0, 0, "null" },
    { TRAJ("\"stop\":1,\"hold\":[\"x\",\"x\"]"), SGA_E_DUPLICATE_NAME, "/trajectory/hold/1", 0, 0, "twice" },
    { TRAJ("\"stop\":1,\"outputs\":[\"x\",\"x*\"]"), SGA_E_EXPR_SYNTAX, "/trajectory/outputs/1", 1, 3, "the end" },
    { TRAJ("\"stop\":1,\"gauge\":{\"rate\":{}}"), SGA_E_UNKNOWN_MEMBER, "/trajectory/gauge/rate", 0, 0, "\"rates\"" },
    { TRAJ("\"stop\":1,\"gauge\":{\"rates\":{\"x\":\"q\"}}"), SGA_E_EXPR_NAME, "/trajectory/gauge/rates/x", 1, 1, "q" },
    { "{\"system\":{\"form\":\"quasilinear\",\"variables\":\"x\",\"parameters\":{\"r\":null},\"A\":1,\"alpha\":\"r\"},"
      "\"trajectory\":{\"stop\":1}}", SGA_E_SCHEMA, "/system/parameters/r", 0, 0, "needs the value" },
    { "{\"system\":{\"form\":\"equations\",\"variables\":\"x\",\"equations\":\"x'' = 1\"},\"trajectory\":{\"stop\":1,"
      "\"initial\":{\"x'\":1,\"der(x)\":1}}}", SGA_E_DUPLICATE_NAME, "/trajectory/initial/der(x)", 0, 0, "twice" },
    { "{\"system\":{\"form\":\"equations\",\"variables\":\"x\",\"equations\":\"x'' = 1\"},\"trajectory\":{\"stop\":1,"
      "\"outputs\":\"x''\"}}", SGA_E_EXPR_DERIVATIVE, "/trajectory/outputs", 1, 1, "number 2" },
};

static void refusals(void)
{
    for (size_t i = 0; i < sizeof table / sizeof *table; i++) {
        struct request r;
        struct sga_error e = { 0 };
        bool ok = request_read(&r, table[i].text, strlen(table[i].text), &e);
        CHECK(!ok && e.code == table[i].code && strcmp(e.pointer, table[i].pointer) == 0 && strstr(e.detail, table[i].says)
                  && (!table[i].line || e.line == table[i].line) && (!table[i].column || e.column == table[i].column),
              "%s\n  %s at '%s' %d:%d: %s", table[i].text, sga_code_text(e.code), e.pointer, e.line, e.column, e.detail);
        CHECK(strcmp(e.stage, "request") == 0 && !r.store.node, "cleared, with a stage");
        if (ok)
            request_clear(&r);
    }
}

static void expect(char *text, enum sga_code code, const char *says)
{
    struct request r;
    struct sga_error e = { 0 };
    bool ok = request_read(&r, text, strlen(text), &e);
    CHECK(ok == (code == SGA_E_OK) && e.code == code && strstr(e.detail, says), "%.60s...: %s %s", text, sga_code_text(e.code), e.detail);
    if (ok)
        request_clear(&r);
    free(text);
}

static void sizes(void)
{
    struct sga_buf b = { 0 };
    for (int i = 0; i < 65; i++)
        sga_buf_puts(&b, "[");
    expect(sga_buf_take(&b), SGA_E_JSON_DEPTH, "64");
    for (int i = 0; i < 1000000; i++)
        sga_buf_puts(&b, "{\"a\":");
    expect(sga_buf_take(&b), SGA_E_JSON_DEPTH, "64");
    for (int i = 0; i < 64; i++)
        sga_buf_puts(&b, "[");
    for (int i = 0; i < 64; i++)
        sga_buf_puts(&b, "]");
    struct sga_buf out = { 0 };
    CHECK(request_canonical(b.data, b.len, &out, NULL) && strcmp(out.data, b.data) == 0, "64 deep is read");
    sga_buf_free(&out);
    sga_buf_free(&b);
    sga_buf_puts(&b, "{\"system\":{\"form\":\"equations\",\"variables\":[\"x\"");
    for (int i = 0; i < REQUEST_MAX_VARIABLES; i++)
        sga_buf_printf(&b, ",\"x%d\"", i);
    sga_buf_puts(&b, "],\"equations\":[\"x=1\"]}}");
    expect(sga_buf_take(&b), SGA_E_LIMIT_VARIABLES, "400000");
    sga_buf_puts(&b, "{\"system\":{\"form\":\"equations\",\"variables\":[\"");
    for (int i = 0; i < 200; i++)
        sga_buf_puts(&b, "x");
    sga_buf_puts(&b, "\"]}}");
    expect(sga_buf_take(&b), SGA_E_BAD_NAME, "128");
    sga_buf_puts(&b, "{\"system\":{\"form\":\"equations\",\"variables\":\"x\",\"equations\":\"x' = x");
    for (int i = 0; i < 3000; i++)
        sga_buf_printf(&b, "+sin(x*%d)", i);
    sga_buf_puts(&b, "\"},\"limits\":{\"nodes\":2000}}");
    expect(sga_buf_take(&b), SGA_E_LIMIT_NODES, "2000");
    sga_buf_puts(&b, "{\"");
    for (int i = 0; i < 300; i++)
        sga_buf_puts(&b, "\u20AC");
    sga_buf_puts(&b, "\":1}");
    expect(sga_buf_take(&b), SGA_E_UNKNOWN_MEMBER, "known are");
}

static unsigned next(unsigned long *seed, unsigned n)
{
    *seed = *seed * 6364136223846793005ul + 1442695040888963407ul;
    return (unsigned)(*seed >> 33) % n;
}

static void mutations(void)
{
    static const char *const good[] = {
        WITH("\"want\":[\"index\"],\"accuracy\":{\"rtol\":1e-6}"),
        "{\"system\":{\"form\":\"equations\",\"variables\":[\"x\",\"y\"],\"parameters\":{\"r\":\"1/3\"},\"equations\":[\"x'' = y*r\","
        "\"x'*y' = sin(x)^2\"]},\"trajectory\":{\"stop\":1,\"initial\":{\"x'\":2},\"outputs\":[\"x'\",\"y\"]}}",
        "{\"system\":{\"form\":\"quasilinear\",\"variables\":\"x\",\"A\":{\"rows\":1,\"cols\":1,\"entries\":[[0,0,\"x\"]]},\"alpha\":1}}",
    };
    static const char *const bits[] = { "\"", ":", ",", "{", "}", "[", "]", "1", "-", "e", ".", "x", "'", "null", "1e-400", "NaN",
                                        "\\u0000", "\xC3\xA9", "\xFF", "true", "(", "\n", "\\", "/0", "t" };
    unsigned long seed = check_seed(4242);
    int read = 0, refused = 0, right = 0, n = check_scale(15000);
    for (int i = 0; i < n; i++) {
        struct sga_buf b = { 0 };
        const char *from = good[next(&seed, 3)];
        size_t length = strlen(from), at = 0;
        for (unsigned k = next(&seed, 4); k; k--) {
            size_t to = at + next(&seed, (unsigned)(length - at) + 1);
            sga_buf_put(&b, from + at, to - at);
            if (next(&seed, 2))
                sga_buf_puts(&b, bits[next(&seed, sizeof bits / sizeof *bits)]);
            at = to + next(&seed, 3);
            at = at > length ? length : at;
        }
        sga_buf_put(&b, from + at, length - at);
        struct request r;
        struct sga_error e = { 0 };
        bool ok = request_read(&r, b.data, b.len, &e);
        right += ok ? e.code == SGA_E_OK : e.code != SGA_E_OK && e.code != SGA_E_INTERNAL && e.detail[0];
        read += ok;
        refused += !ok;
        if (ok)
            request_clear(&r);
        sga_buf_free(&b);
    }
    CHECK(right == n, "%d of %d end rightly", right, n);
    CHECK(read > n / 50 && refused > n / 4, "both happen: %d, %d", read, refused);
}

int main(void)
{
    refusals();
    sizes();
    mutations();
    return CHECK_END();
}
