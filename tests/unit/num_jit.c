/* Machine code against the interpreter, bit for bit: random expressions over all operators, at
 * ordinary and at extreme points; and what happens where no memory may be made executable. */
#define _GNU_SOURCE
#include "check_read.h"

#include <errno.h>
#include <linux/filter.h>
#include <linux/seccomp.h>
#include <math.h>
#include <signal.h>
#include <stddef.h>
#include <string.h>
#include <sys/mman.h>
#include <sys/prctl.h>
#include <sys/syscall.h>
#include <sys/wait.h>
#include <unistd.h>

#include "exec.h"
#include "jacobian.h"
#include "random_expr.h"
#include "table.h"

enum { SYMBOLS = 6, MOST = 400 };

static struct random_source rng;
static int solved;     /* Jacobians that stayed with the sweeps */
static int direct;     /* runs of code that reads its inputs itself */

/* NaN is one value: which one comes out of two depends on their order. */
static bool same(double a, double b)
{
    return memcmp(&a, &b, sizeof a) == 0 || (isnan(a) && isnan(b));
}

static double coordinate(void)
{
    static const double extreme[] = { 0, -0.0, 1, -1, 2, 0.5, INFINITY, -INFINITY, NAN, 1e308, -1e308, 5e-324, -3e-310, 1e-160, 1e160, 3.14159265358979 };
    if (random_below(&rng, 4) == 0)
        return extreme[random_below(&rng, (int)(sizeof extreme / sizeof *extreme))];
    return random_unit(&rng) * (random_below(&rng, 2) ? 2 : 100);
}

static expr_id any_solve(struct expr_store *st, const expr_id *pool, int n)
{
    enum { M = 3 };
    expr_id a[M * M], r[M];
    for (int i = 0; i < M * M; i++)
        a[i] = pool[random_below(&rng, n)];
    for (int i = 0; i < M; i++)
        r[i] = pool[random_below(&rng, n)];
    int s = expr_solve_add(st, M, a, r);
    return expr_sub(st, expr_solution(st, s, random_below(&rng, M)), expr_solution(st, s, 0));
}

/* Any operator on any operands, in or out of their domains. */
static expr_id any_node(struct expr_store *st, const expr_id *pool, int n, bool functions)
{
    expr_id a = pool[random_below(&rng, n)], b = pool[random_below(&rng, n)];
    enum expr_op op = (enum expr_op)(EXPR_SIN + random_below(&rng, EXPR_MAX - EXPR_SIN + 1));
    switch (functions ? random_below(&rng, 16) : random_below(&rng, 9)) {
    case 0: case 1: return expr_add(st, a, b);
    case 2: return expr_sub(st, a, b);
    case 3: case 4: return expr_mul(st, a, b);
    case 5: return expr_is_zero(st, b) ? a : expr_div(st, a, b);
    case 6: return expr_neg(st, a);
    case 7: return expr_is_zero(st, a) ? b : expr_powi(st, a, random_below(&rng, 25) - 12);
    case 8: return expr_add(st, a, expr_rational(st, random_below(&rng, 19) - 9, 1 + random_below(&rng, 7)));
    case 9: return expr_pow(st, a, b);
    case 10: return n > 12 && random_below(&rng, 8) == 0 ? any_solve(st, pool, n) : expr_add(st, expr_fun(st, EXPR_SIN, a), expr_fun(st, EXPR_COS, a));
    default: return expr_op_args(op) == 2 ? expr_fun2(st, op, a, b) : expr_fun(st, op, a);
    }
}

/* A pool of nodes over the symbols; how many there are. */
static int make_pool(struct expr_store *st, expr_id *pool, int *inputs, int most, bool functions)
{
    int n = 0;
    for (; n < SYMBOLS; n++) {
        char name[8];
        sprintf(name, "x%d", n);
        pool[n] = expr_symbol_add(st, name, EXPR_VARIABLE);
        inputs[n] = SYMBOLS - 1 - n;
    }
    pool[n++] = expr_pi(st);
    while (n < most) {
        expr_id e = any_node(st, pool, n, functions);
        if (!expr_store_ok(st))
            break;
        pool[n] = e == EXPR_UNDEF ? pool[n - 1] : e;
        n++;
    }
    return n;
}

static void warm(struct num_tape *t, double *out)
{
    double in[SYMBOLS] = { 0.1, 0.2, 0.3, 0.4, 0.5, 0.6 };
    for (int i = 0; i < 9100; i++)
        num_tape_eval(t, in, out);
}

/* As fields are evaluated: inputs where they lie, the last one apart, roots in two parts; and by
 * the code itself, where there is such code. */
static void by_parts(struct num_tape *b, const double *in, const double *plain, bool finite, int roots)
{
    double x[SYMBOLS], *out = calloc((size_t)roots + 1, sizeof *out);
    struct num_code code;
    int first = roots / 2, bad = -1;
    memcpy(x, in, sizeof x);
    x[SYMBOLS - 1] = 77;       /* not what is read */
    CHECK(num_tape_eval_field(b, x, in[SYMBOLS - 1], first, out, out + first) == finite, "finite %d", finite);
    for (int turn = 0; turn < 2; turn++) {
        for (int r = 0; r < roots; r++)
            bad = same(plain[r], out[r]) ? bad : r;
        CHECK(bad < 0, "root %d of %d: %a, %a", bad, roots, plain[bad < 0 ? 0 : bad], out[bad < 0 ? 0 : bad]);
        memset(out, 0x7F, (size_t)roots * sizeof *out);
        if (!num_tape_code(b, first, &code))
            break;
        direct++;
        *code.time = in[SYMBOLS - 1];
        code.run(code.slots, out, out + first, x);
    }
    CHECK(!num_tape_code(b, first + 1, &code), "other parts");
    free(out);
}

static void random_tapes(struct sga_exec *memory)
{
    struct expr_store st;
    expr_id pool[MOST];
    int inputs[SYMBOLS], n;
    double in[SYMBOLS], *plain = calloc(MOST, sizeof *plain), *fast = calloc(MOST, sizeof *fast);
    expr_store_init(&st);
    n = make_pool(&st, pool, inputs, 10 + random_below(&rng, MOST - 10), random_below(&rng, 2));
    int roots = random_below(&rng, 3) ? 1 + random_below(&rng, 6) : n;      /* the last ones, or all */
    struct num_tape *a = num_tape_new(&st, pool + n - roots, roots, inputs, SYMBOLS, NULL);
    struct num_tape *b = num_tape_new(&st, pool + n - roots, roots, inputs, SYMBOLS, NULL);
    num_tape_compile(b, memory);
    warm(b, fast);
    CHECK(num_tape_compiled(b) == (memory != NULL) && !num_tape_compiled(a), "%d roots", roots);
    for (int point = 0; point < 20; point++) {
        int bad = -1;
        for (int i = 0; i < SYMBOLS; i++)
            in[i] = coordinate();
        bool finite = num_tape_eval(a, in, plain);
        CHECK(finite == num_tape_eval(b, in, fast), "finite %d", finite);
        for (int r = 0; r < roots; r++)
            if (!same(plain[r], fast[r]))
                bad = r;
        CHECK(bad < 0, "root %d of %d: %a, %a", bad, roots, plain[bad < 0 ? 0 : bad], fast[bad < 0 ? 0 : bad]);
    }
    for (int point = 0; point < 20 && memory; point++) {
        for (int i = 0; i < SYMBOLS; i++)
            in[i] = coordinate();
        for (int i = 0; i < 9100 && point == 0; i++)
            num_tape_eval_field(b, in, 0.5, roots / 2, fast, fast + roots / 2);
        bool finite = num_tape_eval(a, in, plain);
        by_parts(b, in, plain, finite, roots);
    }
    num_tape_free(a);
    num_tape_free(b);
    free(plain);
    free(fast);
    expr_store_clear(&st);
}

/* Each operator alone, at all pairs of special values. */
static void every_operator(struct sga_exec *memory)
{
    static const double value[] = { 0, -0.0, 1, -1, 0.5, -0.5, 1.5, 3, -7, 1e-320, -1e-320, 1e300, -1e300, INFINITY, -INFINITY, NAN };
    enum { VALUES = sizeof value / sizeof *value };
    for (int op = EXPR_ADD; op <= EXPR_MAX; op++)
        for (int power = -5; power <= (op == EXPR_POWI ? 9 : -5); power++) {
            struct expr_store st;
            int inputs[2] = { 0, 1 };
            expr_store_init(&st);
            expr_id x = expr_symbol_add(&st, "x", EXPR_VARIABLE), y = expr_symbol_add(&st, "y", EXPR_VARIABLE), e;
            switch (op) {
            case EXPR_ADD: e = expr_add(&st, x, y); break;
            case EXPR_SUB: e = expr_sub(&st, x, y); break;
            case EXPR_MUL: e = expr_mul(&st, x, y); break;
            case EXPR_DIV: e = expr_div(&st, x, y); break;
            case EXPR_NEG: e = expr_neg(&st, x); break;
            case EXPR_POWI: e = expr_powi(&st, x, power); break;
            case EXPR_POW: e = expr_pow(&st, x, y); break;
            default: e = expr_op_args((enum expr_op)op) == 2 ? expr_fun2(&st, (enum expr_op)op, x, y) : expr_fun(&st, (enum expr_op)op, x); break;
            }
            struct num_tape *a = num_tape_new(&st, &e, 1, inputs, 2, NULL), *b = num_tape_new(&st, &e, 1, inputs, 2, NULL);
            double out, again;
            num_tape_compile(b, memory);
            warm(b, &out);
            CHECK(num_tape_compiled(b), "%s", expr_op_text((enum expr_op)op));
            for (int i = 0; i < VALUES * VALUES; i++) {
                double in[2] = { value[i / VALUES], value[i % VALUES] };
                num_tape_eval(a, in, &out);
                num_tape_eval(b, in, &again);
                CHECK(same(out, again), "%s(%g, %g): %a, %a", expr_op_text((enum expr_op)op), in[0], in[1], out, again);
            }
            num_tape_free(a);
            num_tape_free(b);
            expr_store_clear(&st);
        }
}

static void random_jacobians(struct sga_exec *memory)
{
    struct expr_store st;
    expr_id pool[MOST];
    int inputs[SYMBOLS], columns[4] = { 3, 0, 5, 1 }, n;
    double in[SYMBOLS];
    expr_store_init(&st);
    n = make_pool(&st, pool, inputs, 10 + random_below(&rng, 60), random_below(&rng, 2));
    int roots = 1 + random_below(&rng, 12), some = random_below(&rng, 2);
    roots = roots < n ? roots : n;
    struct num_tape *a = num_tape_new(&st, pool + n - roots, roots, inputs, SYMBOLS, NULL);
    struct num_tape *b = num_tape_new(&st, pool + n - roots, roots, inputs, SYMBOLS, NULL);
    struct num_jacobian *p = num_jacobian_new(a, some ? columns : NULL, 4), *q = num_jacobian_new(b, some ? columns : NULL, 4);
    double *v = calloc((size_t)p->nnz + 1, sizeof *v), *w = calloc((size_t)p->nnz + 1, sizeof *w), y[MOST], z[MOST];
    num_jacobian_compile(q, memory);
    for (int point = 0; point < 90; point++) {
        int bad = -1;
        for (int i = 0; i < SYMBOLS; i++)
            in[i] = point % 2 ? coordinate() : 0.7 + random_unit(&rng) / 2;
        bool finite = num_jacobian_eval(p, in, y, v);
        CHECK(finite == num_jacobian_eval(q, in, point % 3 ? z : NULL, w), "finite %d", finite);
        for (int r = 0; r < roots; r++)
            if (point % 3 && !same(y[r], z[r]))
                bad = r;
        CHECK(bad < 0, "root %d", bad);
        bad = -1;
        for (int i = 0; i < p->nnz; i++)
            if (!same(v[i], w[i]))
                bad = i;
        CHECK(bad < 0, "point %d entry %d: %a, %a", point, bad, v[bad < 0 ? 0 : bad], w[bad < 0 ? 0 : bad]);
    }
    solved += !num_jacobian_compiled(q);
    num_jacobian_free(p);
    num_jacobian_free(q);
    num_tape_free(a);
    num_tape_free(b);
    free(v);
    free(w);
    expr_store_clear(&st);
}

/* A measured signal in a field, and its slope in the Jacobian. */
static void signals(struct sga_exec *memory)
{
    static const double knot[] = { 0, 1, 2.5, 4 }, measured[] = { 1, -2, 0.5, 3 };
    struct expr_store st;
    expr_store_init(&st);
    expr_id x = expr_symbol_add(&st, "x", EXPR_VARIABLE), t = expr_symbol_add(&st, "t", EXPR_TIME), u = expr_symbol_add(&st, "u", EXPR_SIGNAL);
    struct expr_symbol *s = st.symbol + expr_symbol_find(&st, "u", 1);
    s->table = expr_table_new(EXPR_CUBIC, 4, knot, measured);
    int inputs[2] = { 0, 1 };
    expr_id root[2] = { expr_mul(&st, expr_add(&st, u, x), expr_sub(&st, u, t)), u };
    struct num_tape *a = num_tape_new(&st, root, 2, inputs, 2, NULL), *b = num_tape_new(&st, root, 2, inputs, 2, NULL);
    struct num_jacobian *p = num_jacobian_new(a, NULL, 0), *q = num_jacobian_new(b, NULL, 0);
    double v[4], w[4], y[2], z[2];
    CHECK(p->nnz == 3, "%d", p->nnz);
    num_jacobian_compile(q, memory);
    for (int i = 0; i < 5000; i++) {
        double in[2] = { random_unit(&rng), 4 * fabs(random_unit(&rng)) };
        bool same_all = num_jacobian_eval(p, in, y, v) && num_jacobian_eval(q, in, z, w);
        for (int k = 0; k < 3; k++)
            same_all &= same(v[k], w[k]);
        same_all &= same(y[0], z[0]) && same(y[1], z[1]) && num_tape_eval(b, in, z) && same(y[0], z[0]) && same(y[1], z[1]);
        if (i % 500 == 0 || !same_all)
            CHECK(same_all, "at %d", i);
    }
    CHECK(num_jacobian_compiled(q) && num_tape_compiled(b), "compiled");
    num_jacobian_free(p);
    num_jacobian_free(q);
    num_tape_free(a);
    num_tape_free(b);
    expr_table_free(s->table);
    expr_store_clear(&st);
}

/* Where a motion goes on from one piece of a signal to the next, the same time comes again with another value; and what
 * depends on time alone is not evaluated again for the same time. */
static void same_time(struct sga_exec *memory)
{
    static const double knot[] = { 0, 1, 2, 3 }, measured[] = { 1, -2, 0.5, 3 };
    for (int with_signal = 0; with_signal < 2; with_signal++) {
        struct expr_store st;
        expr_store_init(&st);
        expr_id x = expr_symbol_add(&st, "x", EXPR_VARIABLE), t = expr_symbol_add(&st, "t", EXPR_TIME), u = expr_symbol_add(&st, "u", EXPR_SIGNAL);
        struct expr_symbol *s = st.symbol + expr_symbol_find(&st, "u", 1);
        s->table = expr_table_new(EXPR_LINEAR, 4, knot, measured);
        int inputs[2] = { 0, 1 };
        expr_id wave = expr_fun(&st, EXPR_SIN, expr_mul(&st, t, t)), timed = with_signal ? expr_mul(&st, wave, u) : expr_fun(&st, EXPR_EXP, wave);
        expr_id root[2] = { expr_mul(&st, timed, x), timed };
        struct num_tape *a = num_tape_new(&st, root, 2, inputs, 2, NULL), *b = num_tape_new(&st, root, 2, inputs, 2, NULL);
        num_tape_compile(b, memory);
        for (int i = 0; i < 9000; i++) {
            double in[2] = { random_unit(&rng), i < 8000 ? 1 + random_unit(&rng) : i / 8 % 2 ? 0.0 : -0.0 }, y[2], z[2];
            s->table->at = random_below(&rng, 3);
            bool finite = num_tape_eval(a, in, y);
            bool ok = finite == num_tape_eval_field(b, in, in[1], 1, z, z + 1) && same(y[0], z[0]) && same(y[1], z[1]);
            if (i % 500 == 0 || !ok)
                CHECK(ok, "with signal %d, at %d: %a, %a; %a, %a", with_signal, i, y[0], z[0], y[1], z[1]);
        }
        CHECK(num_tape_compiled(b));
        num_tape_free(a);
        num_tape_free(b);
        expr_table_free(s->table);
        expr_store_clear(&st);
    }
}

/* Pages are found, given back, and never written and run at one time. */
static void pages(void)
{
    static const unsigned char code[] = { 0xB8, 42, 0, 0, 0, 0xC3 }, other[] = { 0xB8, 43, 0, 0, 0, 0xC3 };       /* mov eax, 42; ret */
    unsigned char wide[3 * 4096] = { 0xB8, 7, 0, 0, 0, 0xC3 };
    struct sga_exec *m = sga_exec_new(4 * 4096);
    void *base;
    size_t bytes;
    sga_exec_range(m, &base, &bytes);
    CHECK(bytes == 4 * 4096 && (uintptr_t)base % bytes == 0, "%zu", bytes);
    const void *a = sga_exec_add(m, code, sizeof code), *b = sga_exec_add(m, wide, sizeof wide);
    CHECK(a && b && ((int (*)(void))(uintptr_t)a)() == 42 && ((int (*)(void))(uintptr_t)b)() == 7, "two pieces");
    CHECK(!sga_exec_add(m, other, sizeof other), "no room is left");
    CHECK(sga_exec_add(m, code, sizeof code) == a && sga_exec_add(m, wide, sizeof wide) == b, "the same again needs none");
    sga_exec_drop(m, b);
    CHECK(!sga_exec_add(m, other, sizeof other), "used by another still");
    sga_exec_drop(m, b);
    CHECK(sga_exec_add(m, wide, sizeof wide) == b && ((int (*)(void))(uintptr_t)b)() == 7, "kept, as long as its room is not wanted");
    sga_exec_drop(m, b);
    const void *c = sga_exec_add(m, other, sizeof other);
    CHECK(c && ((int (*)(void))(uintptr_t)c)() == 43 && ((int (*)(void))(uintptr_t)a)() == 42, "room again");
    sga_exec_drop(m, a);
    CHECK(!sga_exec_add(m, wide, sizeof wide), "one user is left of the first");
    CHECK(!sga_exec_add(m, wide, sizeof wide) && !sga_exec_add(m, wide, 5 * 4096), "too much");
    fflush(stdout);
    pid_t child = fork();
    if (child == 0) {
        signal(SIGSEGV, SIG_DFL);
        *(volatile unsigned char *)(uintptr_t)a = 0;        /* ends with a signal */
        _exit(0);
    }
    int status = 0;
    waitpid(child, &status, 0);
    CHECK(!(WIFEXITED(status) && WEXITSTATUS(status) == 0), "code could be written");
    sga_exec_free(m);
}

/* Code by what it is made from. */
static void named(void)
{
    static const unsigned char code[] = { 0xB8, 42, 0, 0, 0, 0xC3 };
    unsigned char wide[2 * 4096] = { 0xB8, 7, 0, 0, 0, 0xC3 };
    struct sga_exec *m = sga_exec_new(2 * 4096);
    CHECK(!sga_exec_known(m, "key", 3), "nothing is there");
    const void *a = sga_exec_add(m, code, sizeof code);
    sga_exec_name(m, a, "key", 3);
    CHECK(sga_exec_known(m, "key", 3) == a && !sga_exec_known(m, "kez", 3) && !sga_exec_known(m, "key", 2) && !sga_exec_known(m, "", 0), "by its key alone");
    sga_exec_name(m, a, "another", 7);
    CHECK(sga_exec_known(m, "key", 3) == a && !sga_exec_known(m, "another", 7), "the first key stays");
    sga_exec_drop(m, a);
    sga_exec_drop(m, a);
    CHECK(!sga_exec_add(m, wide, sizeof wide), "who found it uses it");
    sga_exec_drop(m, a);
    CHECK(sga_exec_known(m, "key", 3) == a && ((int (*)(void))(uintptr_t)a)() == 42, "kept without users");
    sga_exec_drop(m, a);
    const void *b = sga_exec_add(m, wide, sizeof wide);
    CHECK(b && !sga_exec_known(m, "key", 3), "its room was wanted");
    sga_exec_drop(m, b);
    sga_exec_free(m);
}

/* Tapes of one form with other constants share their code, and each has its own values; tapes of other forms do not. */
static void constants(void)
{
    enum { TAPES = 40 };
    static const char *const form[] = { "%.6f*x^2 + sin(%.6f*x + y)/%.6f", "%.6f*x^2 - sin(%.6f*x + y)/%.6f", "%.6f*y^2 + sin(%.6f*x + y)/%.6f", "%.6f*x^3 + sin(%.6f*x + y)/%.6f" };
    struct sga_exec *m = sga_exec_new(sizeof form / sizeof *form * 4096);     /* a page for each form */
    struct expr_store st;
    struct num_tape *plain[TAPES], *fast[TAPES];
    double in[2] = { 0.7, -1.3 }, a, b;
    expr_store_init(&st);
    expr_symbol_add(&st, "x", EXPR_VARIABLE);
    expr_symbol_add(&st, "y", EXPR_VARIABLE);
    for (int i = 0; i < TAPES; i++) {
        char text[200];
        snprintf(text, sizeof text, form[i % 4], 1.5 + random_unit(&rng), 2 + random_unit(&rng) / 3, 7 + random_unit(&rng));
        expr_id e = check_read(&st, text);
        plain[i] = num_tape_new(&st, &e, 1, (int[]){ 0, 1 }, 2, NULL);
        fast[i] = num_tape_new(&st, &e, 1, (int[]){ 0, 1 }, 2, NULL);
        num_tape_compile(fast[i], m);
        warm(fast[i], &b);
        CHECK(num_tape_compiled(fast[i]), "tape %d has no code", i);
    }
    for (int i = 0; i < TAPES; i++) {
        num_tape_eval(plain[i], in, &a);
        num_tape_eval(fast[i], in, &b);
        CHECK(same(a, b), "tape %d: %a, %a", i, a, b);
    }
    for (int i = 0; i < TAPES; i++) {
        num_tape_free(plain[i]);
        num_tape_free(fast[i]);
    }
    expr_store_clear(&st);
    sga_exec_free(m);
}

/* From now on mprotect with PROT_EXEC fails, as under systemd's MemoryDenyWriteExecute. */
static bool forbid(void)
{
    struct sock_filter code[] = {
        BPF_STMT(BPF_LD | BPF_W | BPF_ABS, offsetof(struct seccomp_data, nr)),
        BPF_JUMP(BPF_JMP | BPF_JEQ | BPF_K, __NR_mprotect, 0, 3),
        BPF_STMT(BPF_LD | BPF_W | BPF_ABS, offsetof(struct seccomp_data, args[2])),
        BPF_JUMP(BPF_JMP | BPF_JSET | BPF_K, PROT_EXEC, 0, 1),
        BPF_STMT(BPF_RET | BPF_K, SECCOMP_RET_ERRNO | EPERM),
        BPF_STMT(BPF_RET | BPF_K, SECCOMP_RET_ALLOW),
    };
    struct sock_fprog program = { sizeof code / sizeof *code, code };
    return prctl(PR_SET_NO_NEW_PRIVS, 1, 0, 0, 0) == 0 && prctl(PR_SET_SECCOMP, SECCOMP_MODE_FILTER, &program) == 0;
}

/* What was compiled before stays, for those too who make the same; what comes after is interpreted. */
static int refused(struct sga_exec *memory)
{
    struct expr_store st;
    int inputs[2] = { 0, 1 };
    expr_store_init(&st);
    expr_id x = expr_symbol_add(&st, "x", EXPR_VARIABLE), y = expr_symbol_add(&st, "y", EXPR_VARIABLE), sum = expr_add(&st, x, y),
            e = expr_mul(&st, x, sum), f = expr_mul(&st, y, sum);
    struct num_tape *before = num_tape_new(&st, &e, 1, inputs, 2, NULL), *same = num_tape_new(&st, &e, 1, inputs, 2, NULL),
                    *after = num_tape_new(&st, &f, 1, inputs, 2, NULL);
    struct num_jacobian *j = num_jacobian_new(after, NULL, 0);
    double in[2] = { 3, 4 }, out = 0, slopes[2] = { 0, 0 };
    num_tape_compile(before, memory);
    warm(before, &out);
    if (!num_tape_compiled(before) || !forbid())
        return 2;
    num_jacobian_compile(j, memory);
    warm(after, &out);
    for (int i = 0; i < 100; i++)
        num_jacobian_eval(j, in, NULL, slopes);
    num_tape_compile(same, memory);
    warm(same, &out);
    bool ok = !num_tape_compiled(after) && !num_jacobian_compiled(j) && slopes[0] == 4 && slopes[1] == 11 && num_tape_compiled(same);
    ok = ok && num_tape_eval(after, in, &out) && out == 28 && num_tape_eval(before, in, &out) && out == 21 && num_tape_eval(same, in, &out) && out == 21;
    return ok ? 0 : 1;
}

static void without_leave(void)
{
    struct sga_exec *memory = sga_exec_new(1 << 20);        /* without the code of other tests */
    fflush(stdout);
    int status = 0;
    pid_t child = fork();
    if (child == 0)
        _exit(refused(memory));
    waitpid(child, &status, 0);
    CHECK(WIFEXITED(status) && WEXITSTATUS(status) == 0, "status %x", (unsigned)status);
    sga_exec_free(memory);
}

int main(void)
{
    struct sga_exec *memory = sga_exec_new(1 << 20);
    rng.state = check_seed(20261);
#if defined(__x86_64__) && defined(__linux__)
    CHECK(memory, "no address space");
#else
    CHECK(!memory, "machine code of another processor");
#endif
    if (!memory)
        return CHECK_END();
    every_operator(memory);
    int n = check_scale(300);
    for (int i = 0; i < n; i++)
        random_tapes(memory);
    for (int i = 0; i < n; i++)
        random_jacobians(memory);
    /* counts of kinds are asked of full runs only */
    CHECK(n < 300 || (solved > 0 && solved < n / 2), "%d of %d have linear solves", solved, n);
    CHECK(n < 300 || direct > 0, "no code read its inputs itself");
    random_tapes(NULL);
    random_jacobians(NULL);
    signals(memory);
    same_time(memory);
    pages();
    named();
    constants();
    without_leave();
    sga_exec_free(memory);
    flint_cleanup();
    return CHECK_END();
}
