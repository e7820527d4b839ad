/* The interpreter of the tape, and the way to machine code. */
#define _GNU_SOURCE    /* sincos */
#include "tape_code.h"

#include <limits.h>
#include <math.h>
#include <string.h>

#include "exec.h"
#include "lu.h"
#include "table.h"
#include "tape_jit.h"
#include "tape_stages.h"

double tape_power(double x, int n)
{
    unsigned k = n < 0 ? -(unsigned)n : (unsigned)n;
    double r = 1;
    for (; k; k >>= 1, x *= x)
        if (k & 1)
            r *= x;
    return n < 0 ? 1 / r : r;
}

/* NaN in, NaN out, on either side. */
double tape_least(double x, double y) { return x < y || isnan(x) ? x : y; }
double tape_greatest(double x, double y) { return x > y || isnan(x) ? x : y; }
double tape_sign(double x) { return isnan(x) ? x : (x > 0) - (x < 0); }
double tape_real_power(double x, double y) { return x < 0 ? NAN : pow(x, y); }

static void solve(struct tape_solve *s, const struct tape_solve *all, const double *v)
{
    for (int i = 0; i < s->m * s->m && s->factored < 0; i++)
        s->lu[i] = v[s->matrix[i]];
    for (int i = 0; i < s->m; i++)
        s->work[i] = v[s->rhs[i]];
    s->singular = s->factored < 0 ? !num_lu_factor(s->lu, s->perm, s->m) : all[s->factored].singular;
    if (!s->singular)
        num_lu_solve(s->lu, s->perm, s->m, s->work, s->y);
    for (int i = 0; s->singular && i < s->m; i++)
        s->y[i] = NAN;
}

void tape_run(struct num_tape *t, int from, int to)
{
    double *v = t->value, *w = v + t->code_slot + from;
    for (const struct tape_code *c = t->code + from, *end = t->code + to; c < end; c++, w++) {
        switch (c->op) {
        case EXPR_ADD:   *w = v[c->a] + v[c->b]; break;
        case EXPR_SUB:   *w = v[c->a] - v[c->b]; break;
        case EXPR_MUL:   *w = v[c->a] * v[c->b]; break;
        case EXPR_DIV:   *w = v[c->a] / v[c->b]; break;
        case EXPR_NEG:   *w = -v[c->a]; break;
        case TAPE_SQUARE: *w = v[c->a] * v[c->a]; break;
        case TAPE_CUBE:  *w = v[c->a] * v[c->a] * v[c->a]; break;
        case EXPR_POWI:  *w = tape_power(v[c->a], c->b); break;
        case EXPR_POW:   *w = tape_real_power(v[c->a], v[c->b]); break;
        case TAPE_SINCOS: sincos(v[c->a], w, w + 1); break;
        case TAPE_PAIRED: break;
#define X(sym, name) case EXPR_##sym: *w = name(v[c->a]); break;
        EXPR_ELEMENTARY_TABLE(X)
#undef X
        case EXPR_ATAN2: *w = atan2(v[c->a], v[c->b]); break;
        case EXPR_SQRT:  *w = sqrt(v[c->a]); break;
        case EXPR_CBRT:  *w = cbrt(v[c->a]); break;
        case EXPR_ABS:   *w = fabs(v[c->a]); break;
        case EXPR_SIGN:  *w = tape_sign(v[c->a]); break;
        case EXPR_MIN:   *w = tape_least(v[c->a], v[c->b]); break;
        case EXPR_MAX:   *w = tape_greatest(v[c->a], v[c->b]); break;
        case TAPE_FACTOR: solve(t->solve + c->a, t->solve, v); break;
        case TAPE_COMPONENT: *w = t->solve[c->a].y[c->b]; break;
        case TAPE_SIGNAL: *w = tape_signal(t, c, 0); break;
        case TAPE_SLOPE_A: *w = tape_slope(t, c->a, false); break;
        case TAPE_SLOPE_B: *w = tape_slope(t, c->a, true); break;
        default:         *w = NAN; break;
        }
    }
}

double tape_signal(const struct num_tape *t, const struct tape_code *c, int more)
{
    return expr_table_value(t->table[c->b >> 8], (c->b & 255) + more, t->value[c->a]);
}

/* False if the exponent of one of them is all ones: infinite or not a number. */
static bool all_finite(const double *v, int n)
{
    uint64_t carry = 0;
    for (int i = 0; i < n; i++) {
        uint64_t bits;
        memcpy(&bits, v + i, sizeof bits);
        carry |= (bits & 0x7FF0000000000000u) + 0x0010000000000000u;
    }
    return carry >> 63 == 0;
}

void tape_forget_time(struct num_tape *t)
{
    static const uint64_t none = 0x7FF4A5A55A5A1234u;      /* a NaN that no time is */
    memcpy(t->value + t->slots, &none, sizeof none);
}

static void load(struct num_tape *t, const double *in, int count)
{
    for (int i = 0; i < count; i++)
        t->value[i] = in[i];
}

static void gather(const struct num_tape *t, double *out, double *rest)
{
    for (int r = 0; r < t->first_roots; r++)
        out[r] = t->value[t->root[r]];
    for (int r = t->first_roots; r < t->nroots; r++)
        rest[r - t->first_roots] = t->value[t->root[r]];
}

static long runs_before(const struct num_tape *t)
{
    return sga_exec_repeats(t->memory) ? TAPE_RUNS_REPEATED : TAPE_RUNS_BEFORE + TAPE_INSTRUCTIONS_BEFORE / (t->ncode - t->nstatic + 1);
}

static inline bool roots_finite(const struct num_tape *t, const double *out, const double *rest)
{
    bool first = all_finite(out, t->first_roots);      /* both: no branch between */
    bool others = all_finite(rest, t->nroots - t->first_roots);
    return first && others;
}

/* What was loaded. */
static inline bool run(struct num_tape *t, double *out, double *rest)
{
    if (t->compiled) {
        t->compiled(t->value, out, rest, t->value);
    } else {
        tape_run(t, t->nstatic, t->ncode);
        gather(t, out, rest);
        if (t->memory && ++t->runs >= runs_before(t) && !tape_compile(t))
            t->runs = LONG_MIN / 2;
    }
    return roots_finite(t, out, rest);
}

bool tape_eval_parts(struct num_tape *t, const double *in, double *out, double *rest)
{
    load(t, in, t->ninputs);
    return run(t, out, rest);
}

bool num_tape_eval_field(struct num_tape *t, const double *x, double time, int first, double *out, double *rest)
{
    if (first != t->first_roots) {
        num_tape_compile(t, t->memory);      /* machine code knows where the parts end */
        t->first_roots = first;
    }
    t->value[t->ninputs - 1] = time;
    if (t->compiled && t->reads_inputs) {
        t->compiled(t->value, out, rest, x);
        return roots_finite(t, out, rest);
    }
    load(t, x, t->ninputs - 1);
    return run(t, out, rest);
}

bool num_tape_eval(struct num_tape *t, const double *in, double *out)
{
    return tape_eval_parts(t, in, out, out + t->first_roots);
}

bool tape_eval_all(struct num_tape *t, const double *in, double *out)
{
    if (t->keep_all)
        return num_tape_eval(t, in, out);
    load(t, in, t->ninputs);
    tape_forget_time(t);
    tape_run(t, t->nstatic, t->ncode);
    gather(t, out, out + t->first_roots);
    return all_finite(out, t->nroots);
}

void num_tape_compile(struct num_tape *t, struct sga_exec *memory)
{
    if (t->compiled)
        sga_exec_drop(t->memory, (const void *)(uintptr_t)t->compiled);
    tape_stages_drop(t);
    t->compiled = NULL;
    t->memory = memory;
    t->runs = 0;
}

bool num_tape_code(struct num_tape *t, int first, struct num_code *code)
{
    *code = (struct num_code){ t->compiled, t->value, t->value + t->ninputs - 1 };
    return t->compiled && t->reads_inputs && t->first_roots == first;
}

bool num_tape_compiled(const struct num_tape *t) { return t->compiled != NULL; }
