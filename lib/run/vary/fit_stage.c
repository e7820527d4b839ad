/* The stage `fit`: the unknowns from the guess, and from further guesses; what the data tell of them. */
#include "vary.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "budget.h"
#include "buf.h"
#include "error.h"
#include "fit_work.h"
#include "points_random.h"
#include "run_job.h"
#include "seeds.h"
#include "stage_clock.h"

enum { MOST_STEPS = 1000 };
/* Columns of derivatives are good to this; what functions cannot be told from, beside the data; two fits are the same that differ by this. */
static const double UNSURE = 3e-9, NOISE = 1e-10, SAME = 1e-6;
/* Further guesses of what has no bounds: by so many powers of 2. */
static const double SPREAD = 3;

struct fits {
    struct fit_work work;
    struct fit_result best;
    bool has_best;
    int tried, converged, same;
};

static double uniform(uint64_t *state)
{
    return (double)(points_random(state) >> 11) * 0x1p-53;
}

/* A further guess. */
static void draw(const struct fit_work *w, uint64_t *state, double *x)
{
    for (int k = 0; k < w->unknowns; k++) {
        double u = uniform(state), low = w->low[k], high = w->high[k];
        if (isfinite(low) && isfinite(high))
            x[k] = low > 0 && high / low > 100 ? low * pow(high / low, u) : low + u * (high - low);
        else
            x[k] = w->guess[k] != 0 ? w->guess[k] * exp2(SPREAD * (2 * u - 1)) : 2 * u - 1;
        x[k] = fmin(fmax(x[k], low), high);
    }
}

static double data_size(const struct fit_work *w)
{
    double sum = 0;
    for (int i = 0; i < w->fit->experiments; i++)
        for (int c = 0; c < w->fit->experiment[i].columns; c++)
            for (int k = 0; k < w->fit->experiment[i].times; k++) {
                const struct request_column *q = w->fit->experiment[i].column + c;
                sum += isfinite(q->value[k]) ? q->weight[k] * q->value[k] * q->value[k] : 0;
            }
    return sqrt(sum);
}

static bool alike(const struct fit_work *w, const struct fit_result *a, const struct fit_result *b)
{
    for (int k = 0; k < w->unknowns; k++)
        if (fabs(a->x[k] - b->x[k]) > SAME * (fabs(a->x[k]) + fabs(b->x[k])))
            return false;
    return true;
}

/* Those that converged come before others, less residual before more. */
static bool better(const struct fit_result *a, const struct fit_result *b)
{
    bool x = a->status == FIT_CONVERGED, y = b->status == FIT_CONVERGED;
    return x != y ? x : a->sum < b->sum;
}

static void one(struct fits *f, const double *guess)
{
    struct fit_work *w = &f->work;
    struct fit_problem q = { .m = w->data, .p = w->unknowns, .ctx = w, .low = w->low, .high = w->high, .value = fit_work_value, .goes_on = fit_work_goes_on,
                             .noise = NOISE * data_size(w), .unsure = UNSURE, .most = MOST_STEPS };
    struct fit_result r;
    fit_least_squares(&q, guess, &r);
    f->tried++;
    f->converged += r.status == FIT_CONVERGED;
    if (r.status == FIT_NO_VALUE || (f->has_best && !better(&r, &f->best))) {
        f->same += f->has_best && r.status == FIT_CONVERGED && alike(w, &r, &f->best);
        fit_result_clear(&r);
        return;
    }
    f->same = f->has_best && f->best.status == FIT_CONVERGED && alike(w, &r, &f->best) ? f->same + 1 : 1;
    fit_result_clear(&f->best);
    f->best = r;
    f->has_best = true;
}

static bool search(struct fits *f)
{
    struct fit_work *w = &f->work;
    uint64_t state = SGA_SEED_FIT;
    double *x = sga_take(&w->mem, ((size_t)w->unknowns + 1) * sizeof *x);
    one(f, w->guess);
    struct sga_error why = w->why;
    for (int k = 0; k < w->fit->starts && job_goes_on(w->j); k++) {
        draw(w, &state, x);
        one(f, x);
    }
    if (!job_goes_on(w->j))
        return false;
    if (f->has_best)
        return true;
    char place[64] = "/fit/data";
    if (w->fit->list)
        snprintf(place, sizeof place, "/fit/data/%d", w->lost < 0 ? 0 : w->lost);
    return sga_fail_at(w->j->err, why.code == SGA_E_OK ? SGA_E_NO_MOTION : why.code, place, "at the guess%s the data are not on the motion: %.700s; give another guess, bounds, or let \"starts\" search",
                       f->tried > 1 ? ", and at all further ones," : "", why.detail[0] ? why.detail : "it has no finite value or derivative at some of them");
}

static void unknown_name(const struct fit_work *w, int k, char *name, size_t size)
{
    int i = k - w->fit->parameters;
    if (i < 0)
        snprintf(name, size, "%s", w->fit->parameter[k].name);
    else if (!w->fit->list)
        snprintf(name, size, "%s", w->fit->initial[i].name);
    else
        snprintf(name, size, "data[%d].%s", i / w->fit->initials, w->fit->initial[i % w->fit->initials].name);
}

static void key_of(const struct fit_work *w, int k, struct sga_json *json)
{
    char name[400];
    unknown_name(w, k, name, sizeof name);
    sga_json_key(json, name);
}

static void write_null(struct sga_json *w, const char *key)
{
    sga_json_key(w, key);
    sga_json_null(w);
}

/* What is known of an unknown: nothing, where the fit did not converge or the data do not tell. */
static void write_unknown(struct sga_json *w, const struct fits *f, const struct fit_spread *s, int k, double variance)
{
    const struct fit_result *r = &f->best;
    bool known = r->status == FIT_CONVERGED && (s->told[k] || r->bound[k]);
    sga_json_object(w);
    if (known) {
        sga_json_member_double(w, "value", r->x[k]);
    } else {
        write_null(w, "value");
        sga_json_member_double(w, "last", r->x[k]);
    }
    if (known && s->told[k] && isfinite(variance))
        sga_json_member_double(w, "standard_error", sqrt(s->covariance[(size_t)k * (size_t)s->p + (size_t)k] * variance));
    else
        write_null(w, "standard_error");
    sga_json_member_bool(w, "at_bound", r->bound[k]);
    sga_json_end_object(w);
}

static void write_unknowns(struct sga_json *w, const struct fits *f, const struct fit_spread *s, double variance)
{
    const struct request_fit *q = f->work.fit;
    sga_json_key(w, "parameters");
    sga_json_object(w);
    for (int k = 0; k < q->parameters; k++) {
        sga_json_key(w, q->parameter[k].name);
        write_unknown(w, f, s, k, variance);
    }
    sga_json_end_object(w);
    sga_json_key(w, "initial_values");
    sga_json_array(w);
    for (int e = 0; e < q->experiments && q->initials; e++) {
        sga_json_object(w);
        for (int i = 0; i < q->initials; i++) {
            sga_json_key(w, q->initial[i].name);
            write_unknown(w, f, s, q->parameters + e * q->initials + i, variance);
        }
        sga_json_end_object(w);
    }
    sga_json_end_array(w);
}

static void write_covariance(struct sga_json *w, const struct fits *f, const struct fit_spread *s, double variance)
{
    bool known = f->best.status == FIT_CONVERGED && isfinite(variance);
    char name[400];
    sga_json_key(w, "names");
    sga_json_array(w);
    for (int k = 0; k < s->p; k++) {
        unknown_name(&f->work, k, name, sizeof name);
        sga_json_string(w, name);
    }
    sga_json_end_array(w);
    sga_json_key(w, "covariance");
    sga_json_array(w);
    for (int a = 0; a < s->p; a++) {
        sga_json_array(w);
        for (int b = 0; b < s->p; b++)
            sga_json_double(w, known && s->told[a] && s->told[b] ? s->covariance[(size_t)a * (size_t)s->p + (size_t)b] * variance : NAN);
        sga_json_end_array(w);
    }
    sga_json_end_array(w);
}

static void write_told(struct sga_json *w, const struct fits *f, const struct fit_spread *s)
{
    char name[400];
    sga_json_key(w, "identifiable");
    sga_json_array(w);
    for (int k = 0; k < s->p; k++) {
        unknown_name(&f->work, k, name, sizeof name);
        if (s->told[k])
            sga_json_string(w, name);
    }
    sga_json_end_array(w);
    sga_json_key(w, "not_identifiable");
    sga_json_array(w);
    for (int k = s->rank; k < s->p; k++) {
        const double *d = s->direction + (size_t)k * (size_t)s->p;
        bool bound = false;
        for (int i = 0; i < s->p; i++)
            bound |= f->best.bound[i] && fabs(d[i]) > 0.5;
        if (bound)
            continue;
        sga_json_object(w);
        sga_json_member_double(w, "singular_value", s->singular[k]);
        sga_json_key(w, "combination");
        sga_json_object(w);
        for (int i = 0; i < s->p; i++)
            if (fabs(d[i]) > 1e-4) {
                key_of(&f->work, i, w);
                sga_json_double(w, d[i]);
            }
        sga_json_end_object(w);
        sga_json_end_object(w);
    }
    sga_json_end_array(w);
    sga_json_key(w, "singular_values");
    sga_json_array(w);
    for (int k = 0; k < s->p; k++)
        sga_json_double(w, s->singular[k]);
    sga_json_end_array(w);
}

/* The motions at the data's times, and by how much they miss. */
static bool write_motions(struct sga_json *w, struct fits *f)
{
    struct fit_work *k = &f->work;
    int at = 0;
    sga_json_key(w, "trajectory");
    if (k->fit->list)
        sga_json_array(w);
    for (int i = 0; i < k->fit->experiments; i++) {
        const struct request_experiment *d = k->fit->experiment + i;
        if (!answer_fits(k->j, w->out))
            return false;
        sga_json_object(w);
        sga_json_key(w, "columns");
        sga_json_array(w);
        sga_json_string(w, k->j->request->store.symbol[k->j->request->system.time].name);
        for (int c = 0; c < d->columns; c++)
            sga_json_string(w, d->column[c].text);
        sga_json_end_array(w);
        for (int what = 0; what < 2; what++) {
            sga_json_key(w, what ? "residuals" : "rows");
            sga_json_array(w);
            for (int t = 0; t < d->times; t++) {
                sga_json_array(w);
                if (!what)
                    sga_json_double(w, d->time[t]);
                for (int c = 0; c < d->columns; c++) {
                    double value = k->sample[at + c * d->times + t];
                    sga_json_double(w, what ? d->column[c].value[t] - value : value);
                }
                sga_json_end_array(w);
            }
            sga_json_end_array(w);
        }
        sga_json_end_object(w);
        at += d->columns * d->times;
    }
    if (k->fit->list)
        sga_json_end_array(w);
    return true;
}

static const char *reason(const struct fits *f)
{
    static const char *const text[] = {
        [FIT_NO_VALUE] = "the motion has no value at the guess", [FIT_TOO_MANY] = "too many steps: give another guess, bounds, or let \"starts\" search",
        [FIT_STALLED] = "no step makes the residual less, and it is not the least one as far as its derivatives tell: the model jumps or ends there, or computed motions are not good enough; "
                        "tighten accuracy.rtol, or give another guess",
        [FIT_STOPPED] = "the time granted is used up",
    };
    return f->best.status == FIT_CONVERGED ? NULL : text[f->best.status];
}

static bool write(struct fits *f, const struct fit_spread *s)
{
    struct fit_work *k = &f->work;
    const struct fit_result *r = &f->best;
    struct sga_buf out = { 0 };
    struct sga_json w;
    int freedom = k->measured - s->rank;
    double variance = freedom > 0 ? r->sum / freedom : NAN;
    sga_json_begin(&w, &out);
    sga_json_object(&w);
    sga_json_member_bool(&w, "converged", r->status == FIT_CONVERGED);
    if (reason(f))
        sga_json_member_string(&w, "reason", reason(f));
    write_unknowns(&w, f, s, variance);
    write_covariance(&w, f, s, variance);
    sga_json_member_double(&w, "residual", r->sum);
    sga_json_member_double(&w, "residual_standard_deviation", sqrt(variance));
    sga_json_member_int(&w, "degrees_of_freedom", freedom);
    sga_json_member_int(&w, "observations", k->measured);
    sga_json_member_double(&w, "motion_error", k->noise);
    sga_json_member_int(&w, "iterations", r->steps);
    sga_json_member_int(&w, "evaluations", r->evaluations);
    write_told(&w, f, s);
    if (k->fit->starts) {
        sga_json_key(&w, "starts");
        sga_json_object(&w);
        sga_json_member_int(&w, "tried", f->tried);
        sga_json_member_int(&w, "converged", f->converged);
        sga_json_member_int(&w, "same", f->same);
        sga_json_end_object(&w);
    }
    bool ok = write_motions(&w, f);
    sga_json_end_object(&w);
    k->j->fit = sga_buf_take(&out);
    return ok;
}

/* The best one once more, with estimates, and what it tells. */
static bool finish(struct fits *f)
{
    struct fit_work *w = &f->work;
    struct fit_result *r = &f->best;
    struct fit_spread s;
    w->sample = sga_zeros(&w->mem, (size_t)w->data + 1, sizeof *w->sample);
    if (!fit_work_estimate(w, r->x, r->r, r->J)) {
        *w->j->err = w->why;
        return false;
    }
    fit_spread_of(&(struct fit_at){ .size = r->size, .J = r->J, .bound = r->bound, .unsure = UNSURE, .noise = NOISE * data_size(w) }, w->data, w->unknowns, &s);
    bool ok = write(f, &s);
    fit_spread_clear(&s);
    return ok;
}

bool answer_fit(struct job *j)
{
    struct fits f = { .tried = 0 };
    stage_begin(j->clock, STAGE_FIT);
    bool ok = fit_work_begin(&f.work, j);
    if (ok && !f.work.measured)
        ok = sga_fail_at(j->err, SGA_E_SCHEMA, "/fit/data", "every value is null or has the weight 0: there is nothing to fit to");
    ok = ok && search(&f) && finish(&f);
    fit_result_clear(&f.best);
    fit_work_end(&f.work);
    return ok && job_goes_on(j);
}
