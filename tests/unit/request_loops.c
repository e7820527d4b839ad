/* Ranges and loops: what is wrong with them is said of the place as it was written, before memory is taken; what a text stands for
 * is compared with the same written by hand (the suite loops compares answers). */
#include <string.h>

#include "buf.h"
#include "check.h"
#include "error.h"
#include "request.h"

#define SYSTEM(variables, equations) "{\"system\":{\"form\":\"equations\",\"sizes\":{\"n\":4,\"m\":2},\"parameters\":{\"k\":1}," \
    "\"variables\":[" variables "],\"equations\":[" equations "]}}"
#define LOOP(range, equation) "{\"for\":\"" range "\",\"equation\":\"" equation "\"}"
#define ONE(equation) SYSTEM("\"x[1:n]\"", LOOP("i = 1:n", equation))
#define OVER(range) SYSTEM("\"x[1:n]\"", LOOP(range, "x[i]' = 1"))
#define MOVE(trajectory) "{\"system\":{\"form\":\"equations\",\"variables\":[\"x[1:3]\"],\"equations\":[" LOOP("i = 1:3", "x[i]' = 1") "]},\"trajectory\":{\"stop\":1," trajectory "}}"

static const struct {
    const char *text, *pointer, *detail;
    enum sga_code code;
} wrong[] = {
    { ONE("x[i]' = x[i+1]"), "/system/equations/0/equation", "there are 4, from x[1] to x[4] (where i = 4", SGA_E_EXPR_NAME },
    { ONE("x[i]' = y"), "/system/equations/0/equation", "unknown name 'y'", SGA_E_EXPR_NAME },
    { ONE("x[i]' = 1/(i - 3)"), "/system/equations/0/equation", "0 (where i = 3", SGA_E_EXPR_UNDEFINED },
    { ONE("x[i]' = 2i"), "/system/equations/0/equation", "joined with *", SGA_E_EXPR_SYNTAX },
    { ONE("x[i]' = 2n"), "/system/equations/0/equation", "joined with *", SGA_E_EXPR_SYNTAX },
    { ONE("x[i]' = i.5"), "/system/equations/0/equation", "joined with *", SGA_E_EXPR_SYNTAX },
    { ONE("x[i]' = i 2"), "/system/equations/0/equation", "joined with *", SGA_E_EXPR_SYNTAX },
    { ONE("x[i]' = k + 3.i"), "/system/equations/0/equation", "joined with *", SGA_E_EXPR_SYNTAX },
    { ONE("x[2i]' = 1"), "/system/equations/0/equation", "a ] is missing behind an index; whole numbers are joined by + - * /", SGA_E_EXPR_SYNTAX },
    { ONE("x[i/2]' = 1"), "/system/equations/0/equation", "no whole number; choose bounds for which it is (i = 1)", SGA_E_EXPR_UNDEFINED },
    { ONE("x[4+1/(i-2)]' = 1"), "/system/equations/0/equation", "division by 0 in an index; choose other bounds (i = 2)", SGA_E_EXPR_UNDEFINED },
    { ONE("x[i-2]' = 1"), "/system/equations/0/equation", "below 0; raise the lower bound of the loop, or shift the index (i = 1)", SGA_E_EXPR_NAME },
    { ONE("x[i' = 1"), "/system/equations/0/equation", "a ] is missing behind an index", SGA_E_EXPR_SYNTAX },
    { ONE("x[k]' = 1"), "/system/equations/0/equation", "'k' is no loop name and no size of system.sizes", SGA_E_EXPR_NAME },
    { ONE("x[i*1000000*1000000*1000000]' = 1"), "/system/equations/0/equation", "limit of 999999999", SGA_E_LIMIT_VARIABLES },
    { ONE("x[]' = 1"), "/system/equations/0/equation", "where a whole number, a loop name or a size is expected", SGA_E_EXPR_SYNTAX },
    { ONE("x[i]' = sum(j = 1:i, x[j+1])"), "/system/equations/0/equation", "there are 4, from x[1] to x[4] (where i = 4", SGA_E_EXPR_NAME },
    { ONE("x[i]' = sum(j = 1:i-3, x[j]) + sum(j = 1:i, 1/(j - 3))"), "/system/equations/0/equation", "0 (where i = 3", SGA_E_EXPR_UNDEFINED },
    { ONE("x[i]' = sum(i = 1:2, x[i])"), "/system/equations/0/equation", "'i' is already a loop name or a size; take another name (i = 1)", SGA_E_DUPLICATE_NAME },
    { ONE("x[i]' = sum(k = 1:2, x[k])"), "/system/equations/0/equation", "\"k\" is a name of the system; take another for the sum (i = 1)", SGA_E_DUPLICATE_NAME },
    { ONE("x[i]' = x[1:n]"), "/system/equations/0/equation", "may be an element of a list or the name of a member, not a part of an expression", SGA_E_EXPR_SYNTAX },
    { OVER("i = 5:2"), "/system/equations/0/for", "range 5:2: its first number is larger than its last; leave it out, or turn it around", SGA_E_SHAPE },
    { OVER("i = 1:q"), "/system/equations/0/for", "'q' is no loop", SGA_E_EXPR_NAME },
    { OVER("i = 1:2.5"), "/system/equations/0/for", "whole number", SGA_E_EXPR_SYNTAX },
    { OVER("i in 1:n"), "/system/equations/0/for", "a loop is written", SGA_E_EXPR_SYNTAX },
    { OVER("i = 1:2:n"), "/system/equations/0/for", "a range is low:high, in steps of 1", SGA_E_EXPR_SYNTAX },
    { OVER("i = 1:n, i = 1:n"), "/system/equations/0/for", "'i' is already a loop name or a size; take another name", SGA_E_DUPLICATE_NAME },
    { OVER("k = 1:n"), "/system/equations/0/for", "\"k\" is a name of the system; take another", SGA_E_DUPLICATE_NAME },
    { OVER("n = 1:4"), "/system/equations/0/for", "'n' is already a loop name or a size; take another name", SGA_E_DUPLICATE_NAME },
    { OVER("t = 1:4"), "/system/equations/0/for", "a name of the system; take another", SGA_E_DUPLICATE_NAME },
    { OVER("pi = 1:4"), "/system/equations/0/for", "a name of the grammar; take another", SGA_E_BAD_NAME },
    { OVER("i = 1:1000000000"), "/system/equations/0/for", "limit of 999999999", SGA_E_LIMIT_VARIABLES },
    { OVER("i = 1:1000000, j = 1:1000000"), "/system/equations/0/for", "elements that are left of those that all ranges and loops of a request may make", SGA_E_LIMIT_VARIABLES },
    { OVER("i = 1:1000000, j = 1:1000000, l = 1:0"), "/system/equations/0/for", "range 1:0", SGA_E_SHAPE },
    { SYSTEM("\"x[1:n]\",\"x[3:5]\"", "\"x[1]' = 1\""), "/system/variables/1", "(x[3])", SGA_E_DUPLICATE_NAME },
    { SYSTEM("\"x[1:10000000]\"", "\"x[1]' = 1\""), "/system/variables/0", "elements that are left", SGA_E_LIMIT_VARIABLES },
    { SYSTEM("\"x[1:n]\"", "\"x[1:n]' = x[1:n]\""), "/system/equations/0", "{\"for\": \"i = 1:3\", ...} repeats one", SGA_E_EXPR_SYNTAX },
    { SYSTEM("\"x[1:n]\"", "{\"for\":\"i = 1:n\"}"), "/system/equations/0", "\"expression\" is missing", SGA_E_MISSING_MEMBER },
    { SYSTEM("\"x[1:n]\"", "{\"for\":\"i = 1:n\",\"equation\":\"x[i]' = 1\",\"step\":2}"), "/system/equations/0/step", "not known", SGA_E_UNKNOWN_MEMBER },
    { SYSTEM("\"x[1:n]\"", "{\"for\":3,\"equation\":\"x[1]' = 1\"}"), "/system/equations/0/for", "expected a string, found a number", SGA_E_SCHEMA },
    { SYSTEM("\"x[1:m,1:m]\"", LOOP("i = 1:m, j = 1:m", "x[i,j]' = x[i,j+1]")), "/system/equations/0/equation", "from x[1,1] to x[2,2] (where i = 1, j = 2", SGA_E_EXPR_NAME },
    { MOVE("\"initial\":{\"x[1:4]\":0}"), "/trajectory/initial/x[1:4]", "(x[4])", SGA_E_EXPR_NAME },
    { MOVE("\"initial\":{\"x[i = 1:3]\":\"1/(i-2)\"}"), "/trajectory/initial/x[i = 1:3]", "(i = 2)", SGA_E_EXPR_UNDEFINED },
    { MOVE("\"initial\":{\"x[1:3]\":0,\"x[2]\":1}"), "/trajectory/initial/x[2]", "given twice", SGA_E_DUPLICATE_NAME },
    { MOVE("\"initial\":{\"x[1:3]\":0},\"outputs\":[\"x[1]\",\"x[2:5]^2\"]"), "/trajectory/outputs/1", "not a part of an expression", SGA_E_EXPR_SYNTAX },
};

static void faults(void)
{
    for (size_t i = 0; i < sizeof wrong / sizeof *wrong; i++) {
        struct request r;
        struct sga_error e = { 0 };
        struct request_bounds bounds = { .seconds = 100, .nodes = 2000000 };
        struct request_faults all;
        bool ok = request_read(&r, wrong[i].text, strlen(wrong[i].text), &e);
        CHECK(!ok && e.code == wrong[i].code, "%s: code %d, %s", wrong[i].text, e.code, e.detail);
        CHECK(strcmp(e.pointer, wrong[i].pointer) == 0, "%s: at %s", wrong[i].text, e.pointer);
        CHECK(strstr(e.detail, wrong[i].detail), "%s: %s", wrong[i].text, e.detail);
        if (ok)
            request_clear(&r);
        ok = request_read_all(&r, wrong[i].text, strlen(wrong[i].text), &bounds, &all);
        CHECK(!ok && all.count && strcmp(all.list[0].pointer, e.pointer) == 0 && strcmp(all.list[0].detail, e.detail) == 0, "%s: %d faults", wrong[i].text, all.count);
        if (ok)
            request_clear(&r);
        request_faults_clear(&all);
    }
}

/* The names that a list stands for. */
static void stands_for(const char *list, const char *names)
{
    struct request r;
    struct sga_error e = { 0 };
    struct sga_buf text = { 0 }, got = { 0 };
    sga_buf_printf(&text, "{\"system\":{\"form\":\"equations\",\"sizes\":{\"n\":3},\"variables\":[%s],\"equations\":[\"u' = 1\"]}}", list);
    bool ok = request_read(&r, text.data, text.len, &e);
    CHECK(ok, "%s: %s", list, e.detail);
    for (int i = 0; ok && i < r.system.variables; i++)
        sga_buf_printf(&got, "%s%s", i ? " " : "", r.store.symbol[r.system.variable[i].symbol].name);
    CHECK(ok && strcmp(got.data, names) == 0, "%s: %s", list, got.data);
    if (ok)
        request_clear(&r);
    sga_buf_free(&text);
    sga_buf_free(&got);
}

/* What is left as it is. */
static void indices(void)
{
    struct sga_error e = { 0 };
    struct request r;
    static const char text[] = MOVE("\"initial\":{\"x[1]\":0,\"x[02]\":1,\"x[ 3 ]\":2},\"outputs\":[\"x[1]\",\"x[02]*x[3]\",\"x[1,2\"]");
    bool ok = request_read(&r, text, sizeof text - 1, &e);
    CHECK(!ok && strcmp(e.pointer, "/trajectory/outputs/2") == 0, "%s", e.pointer);
    if (ok)
        request_clear(&r);
}

/* What a text with sums in it becomes. */
static void sums(const char *equation, const char *becomes)
{
    struct request r;
    struct sga_error e = { 0 };
    struct sga_buf text = { 0 };
    sga_buf_printf(&text, "{\"system\":{\"form\":\"equations\",\"sizes\":{\"n\":3},\"variables\":[\"x[1:n]\",\"sum\",\"asum\"],\"equations\":[\"%s\"]}}", equation);
    bool ok = request_read(&r, text.data, text.len, &e);
    CHECK(ok && strcmp(r.equation[0], becomes) == 0, "%s: %s", equation, ok ? r.equation[0] : e.detail);
    if (ok)
        request_clear(&r);
    sga_buf_free(&text);
}

/* Two indices, and triangles. */
static void counts(void)
{
    static const char text[] = "{\"system\":{\"form\":\"equations\",\"sizes\":{\"n\":300},\"variables\":[\"x[1:n,1:n]\"],"
                               "\"equations\":[{\"for\":\"i = 1:n, j = 1:i\",\"equation\":\"x[i,j]' = i*j*x[j,i]\"},{\"for\":\"i = 1:n, j = i+1:n\",\"equation\":\"x[i,j]' = -1\"}]}}";
    struct request r;
    struct sga_error e = { 0 };
    bool ok = request_read(&r, text, sizeof text - 1, &e);
    CHECK(ok && r.system.variables == 90000 && r.equations == 90000, "%s", e.detail);
    CHECK(ok && strcmp(r.equation[45149], "x[300,300]' = 300*300*x[300,300]") == 0 && strcmp(r.equation[45150], "x[1,2]' = -1") == 0, "triangles");
    if (ok)
        request_clear(&r);
}

int main(void)
{
    request_init();
    faults();
    stands_for("\"u\",\"x[1:n]\"", "u x[1] x[2] x[3]");
    stands_for("\"u\",\"x[0:1,n-1:n]\",\"z[2*n,(n+1)/2]\"", "u x[0,2] x[0,3] x[1,2] x[1,3] z[6,2]");
    stands_for("\"u\",\"x[ 7 ]\",\"y[ i = 1 : 2 ]\",\"z[- (-n)]\"", "u x[7] y[1] y[2] z[3]");
    stands_for("\"u\",\"a[1:2]\",\"x[i = 1:3, j = i:2]\"", "u a[1] a[2] x[1,1] x[1,2] x[2,2]");
    sums("sum(i = 1:n, i*x[i]) = 1", "((1*x[1]) + (2*x[2]) + (3*x[3])) = 1");
    sums("1 = 2*sum ( i = 1:2, j = i:2 , x[i]^j + n)", "1 = 2*((x[1]^1 + 3) + (x[1]^2 + 3) + (x[2]^2 + 3))");
    sums("sum(i = 2:n, sum(j = 1:i-2, x[j])) = -sum(i = 1:n, max(x[i], (1 + i)))",
         "(((0)) + (((x[1])))) = -((max(x[1], (1 + 1))) + (max(x[2], (1 + 2))) + (max(x[3], (1 + 3))))");
    sums("sum = asum + sum(i = 1:1, sum*i) + sum(i=3:3,x[i-2])", "sum = asum + ((sum*1)) + ((x[1]))");
    counts();
    indices();
    return CHECK_END();
}
