/* All faults of a request: what ends a plain reading is among them, and there are none exactly where it reads. Values and names of good
 * requests of every form are replaced at random by others, wrong ones mostly: several at a time. */
#include <ctype.h>
#include <stdlib.h>
#include <string.h>

#include "buf.h"
#include "check.h"
#include "error.h"
#include "request.h"

#define TRAJECTORY "\"trajectory\":{\"start\":0,\"stop\":2,\"samples\":5,\"initial\":{\"x\":1},\"hold\":[\"x\"],\"outputs\":[\"x\",\"2*x\"],\"integrals\":[\"x^2\"]," \
                   "\"gauge\":{\"rates\":{\"x\":\"0\"},\"conditions\":[\"x-1\"]},\"events\":[{\"name\":\"a\",\"expression\":\"x\",\"direction\":\"up\"}]}"
#define REST "\"want\":[\"index\",\"gauge\"],\"accuracy\":{\"rtol\":1e-6,\"atol\":1e-9,\"arithmetic\":\"double\"},\"limits\":{\"seconds\":3,\"nodes\":100000},\"strata\":\"list\"," \
             "\"symmetries\":{\"check\":[{\"name\":\"s\",\"field\":{\"x\":\"1\"}},{\"name\":\"m\",\"map\":{\"x\":\"x\"}}],\"search\":{\"degree\":1,\"functions\":[\"x\"]}}"

static const char *const good[] = {
    "{\"system\":{\"name\":\"n\",\"form\":\"equations\",\"variables\":[\"x\",\"y\"],\"parameters\":{\"r\":\"1/3\",\"s\":2},\"equations\":[\"x'' = y*r\",\"x'*y' = sin(x)^2\"]}," TRAJECTORY "," REST "}",
    "{\"system\":{\"form\":\"quasilinear\",\"variables\":[\"x\",\"y\"],\"time\":\"s\",\"A\":[[1,\"x\"],[\"y\",2]],\"alpha\":[\"y\",\"-x*s\"],\"restrict\":[\"x-y\"]}," TRAJECTORY "," REST "}",
    "{\"system\":{\"form\":\"quasilinear\",\"variables\":[\"x\"],\"A\":{\"rows\":1,\"cols\":1,\"entries\":[[0,0,\"x\"]]},\"alpha\":[1]}," REST "}",
    "{\"system\":{\"form\":\"linear\",\"variables\":[\"x\",\"y\"],\"A\":[[1,0],[0,0]],\"B\":[[0,1],[\"1/2\",1]],\"C\":[[0],[1]],\"inputs\":[\"sin(t)\"]}," TRAJECTORY "}",
    "{\"system\":{\"form\":\"control\",\"variables\":[\"x\",\"y\"],\"inputs\":[\"u\"],\"F\":[\"y\",\"-x\"],\"G\":[[0,1]],\"constraints\":[\"y+x\"]}," TRAJECTORY "}",
    "{\"system\":{\"form\":\"hamiltonian\",\"variables\":[\"x\",\"p\"],\"hamiltonian\":\"p^2/2+x^2\",\"omega\":[[0,1],[-1,0]],\"restrict\":[\"x\"]}}",
    "{\"system\":{\"form\":\"lagrangian\",\"coordinates\":[\"x\",\"y\"],\"lagrangian\":\"x'^2/2+y'^2/2-y\",\"forces\":[\"-x'\",\"0\"],\"holonomic\":[\"x^2+y^2-1\"]}," TRAJECTORY "}",
    "{\"system\":{\"form\":\"mechanical\",\"coordinates\":[\"x\",\"y\"],\"masses\":[1,2],\"forces\":[\"0\",\"-1\"],\"constraints\":[\"x*y'-y*x'\"]}," TRAJECTORY "}",
    "{\"system\":{\"form\":\"operator\",\"unknowns\":[\"x\",\"y\"],\"coefficients\":[[[1,0],[0,1]],[[0,\"t\"],[0,0]]],\"sources\":[\"e\",\"sin(t)\"]}}",
    "{\"system\":{\"form\":\"equations\",\"variables\":[\"x\"],\"parameters\":{\"k\":1},\"tables\":{\"w\":{\"times\":[0,1,2],\"values\":[1,2,3]}},\"equations\":[\"x' = -k*x + w\"]},"
    "\"trajectory\":{\"times\":[0,1,2],\"initial\":{\"x\":1}},\"sweep\":[{\"parameters\":{\"k\":2}},{\"initial\":{\"x\":3}}]}",
};
static const char *const words[] = { "\"x +\"", "\"zz\"", "\"2x\"", "\"\"", "7", "-3.5", "null", "[]", "{}", "true", "\"x'\"", "\"x''\"", "\"1/0\"", "\"x)\"", "[[1]]", "\"t\"", "\"x\"", "0", "\"x = = 1\"" };
static const char *const names[] = { "\"zz\"", "\"x\"", "\"stop\"", "\"form\"", "\"2x\"", "\"\"" };

static unsigned next(unsigned long *seed, unsigned n)
{
    *seed = *seed * 6364136223846793005ul + 1442695040888963407ul;
    return (unsigned)(*seed >> 33) % n;
}

/* The length of a string, number or word of JSON at s; 0: there is none. */
static size_t token(const char *s)
{
    if (*s == '"')
        return strcspn(s + 1, "\"") + 2;
    return isdigit((unsigned char)*s) || *s == '-' ? strspn(s, "0123456789.eE+-") : 0;
}

/* About one of so many tokens is replaced. */
static void spoil(const char *from, unsigned one_of, unsigned long *seed, struct sga_buf *out)
{
    for (size_t n; *from; from += n) {
        n = token(from);
        bool name = n && from[n] == ':';
        if (n && next(seed, one_of) == 0)
            sga_buf_puts(out, name ? names[next(seed, sizeof names / sizeof *names)] : words[next(seed, sizeof words / sizeof *words)]);
        else
            sga_buf_put(out, from, n ? n : 1);
        n = n ? n : 1;
    }
}

static bool listed(const struct request_faults *f, const struct sga_error *e)
{
    for (int i = 0; i < f->count; i++)
        if (f->list[i].code == e->code && strcmp(f->list[i].pointer, e->pointer) == 0 && strcmp(f->list[i].detail, e->detail) == 0)
            return true;
    return false;
}

/* How many faults there are; -1 where the two readings do not agree. */
static int compare(const char *text, size_t length)
{
    struct request r;
    struct sga_error e = { 0 };
    struct request_bounds bounds = { .seconds = REQUEST_CHECK_SECONDS, .nodes = REQUEST_CHECK_NODES }, same = bounds;
    struct request_faults faults;
    bool ok = request_read_within(&r, text, length, &same, &e);
    if (ok)
        request_clear(&r);
    bool all = request_read_all(&r, text, length, &bounds, &faults);
    if (all && !bounds.met)
        request_clear(&r);
    bool agree = ok == all && (ok || listed(&faults, &e));
    for (int i = 0; i < faults.count; i++)
        agree = agree && faults.list[i].code != SGA_E_OK && faults.list[i].code != SGA_E_INTERNAL && faults.list[i].detail[0] && strcmp(faults.list[i].stage, "request") == 0;
    int count = faults.count;
    CHECK(agree, "%d %d, %d faults, first: %s %s '%s' in\n%s", ok, all, count, sga_code_text(e.code), e.pointer, e.detail, text);
    request_faults_clear(&faults);
    return agree ? count : -1;
}

static void spoilt(void)
{
    unsigned long seed = check_seed(1717);
    int several = 0, n = check_scale(12000);
    for (size_t k = 0; k < sizeof good / sizeof *good; k++)
        CHECK(compare(good[k], strlen(good[k])) == 0, "%s", good[k]);
    for (int i = 0; i < n; i++) {
        struct sga_buf b = { 0 };
        spoil(good[next(&seed, sizeof good / sizeof *good)], 3 + next(&seed, 30), &seed, &b);
        int count = compare(b.data, b.len);
        sga_buf_free(&b);
        several += count > 1;
    }
    CHECK(several > n / 5, "several faults at a time: %d of %d", several, n);
}

/* What may only follow from another fault is not told. */
static void followers(void)
{
    static const struct { const char *text; int count; } table[] = {
        { "{\"system\":{\"form\":\"equations\",\"variables\":[\"x\",\"2y\"],\"equations\":[\"x' = y\",\"y = 2y\"]}}", 1 },
        { "{\"system\":{\"form\":\"equations\",\"variables\":[\"x\",\"y\"],\"equations\":[\"x'' = \",\"y = x\"]},\"trajectory\":{\"stop\":1,\"initial\":{\"x'\":1},\"outputs\":[\"x'\"]}}", 1 },
        { "{\"system\":{\"form\":\"equations\",\"variables\":\"x\",\"parameters\":{\"m\":\"(\"},\"equations\":\"x' = 1/m\"}}", 1 },
        { "{\"system\":{\"form\":\"equations\",\"variables\":\"x\",\"equations\":\"x' = 1\"},\"trajectory\":{\"times\":[0,\"(\",2,\"2*\"],\"initial\":{\"x\":1}}}", 2 },
        { "{\"system\":{\"form\":\"equations\",\"variables\":\"x\",\"equations\":\"x' = 1\"},\"accuracy\":{\"rtol\":\"1/\"},\"limits\":{\"seconds\":\"x\"}}", 2 },
    };
    for (size_t k = 0; k < sizeof table / sizeof *table; k++)
        CHECK(compare(table[k].text, strlen(table[k].text)) == table[k].count, "%s", table[k].text);
}

int main(void)
{
    request_init();
    followers();
    spoilt();
    return CHECK_END();
}
