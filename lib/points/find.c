/* Finding a point: starts, and the order of the stages. */
#include "points.h"

#include <assert.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "arb_ends.h"
#include "arena.h"
#include "branches.h"
#include "budget.h"
#include "differentials.h"
#include "davidenko.h"
#include "into_domain.h"
#include "newton.h"
#include "one_by_one.h"
#include "parts.h"
#include "points_random.h"
#include "mem.h"
#include "refine.h"
#include "search.h"
#include "sides.h"
#include "triangular.h"

enum { STARTS = 24, POSITIVE_STARTS = 10, NEWTON_BITS = 64, BRANCH_STARTS = 3, FEW_STAGES = 12, FOLLOWED = 4 };
/* Of the starts: those whose values may leave the range of doubles where constraints are solved one after the other. */
enum { LAST_STARTS = 2 };
/* How much nearer to the guess the next start is, where one led over a change of branch. */
static const double NEARER = 0.125;
uint64_t points_random(uint64_t *state)
{
    uint64_t z = (*state += 0x9E3779B97F4A7C15u);
    z = (z ^ (z >> 30)) * 0xBF58476D1CE4E5B9u;
    z = (z ^ (z >> 27)) * 0x94D049BB133111EBu;
    return z ^ (z >> 31);
}

double points_uniform(uint64_t *state)
{
    return ((double)(points_random(state) >> 34) + 0.5) * 0x1p-30;
}

double points_scatter(const char *name, int turn)
{
    uint64_t h = 1469598103934665603u + (uint64_t)turn;
    for (; *name; name++)
        h = (h ^ (unsigned char)*name) * 1099511628211u;
    return 4 * points_uniform(&h) - 2;
}

/* A guess below it was meant to be 0. */
static const double LEAST_SIZE = 1e-12;

double points_short(double v)
{
    int e;
    double m = frexp(v, &e);
    return ldexp(round(m * 0x1p24), e - 24);
}

static void take_over(const struct points_space *s, struct points_point *p)
{
    const struct points_point *b = s->before;
    for (int i = 0; i < s->variables; i++) {
        p->x[i] = b->x[i];
        num_ball_set_d(&p->ball, s->variable[i], p->x[i]);
    }
    for (int i = 0; i < s->parameters; i++) {
        p->parameter[i] = b->parameter[i];
        num_ball_set_d(&p->ball, s->parameter[i], p->parameter[i]);
    }
    p->t = b->t;
    if (s->time >= 0)
        num_ball_set_d(&p->ball, s->time, p->t);
}

/* Positive ones first: as they are meant as a rule. */
static double parameter_value(const struct points_space *s, int i, uint64_t *random, int attempt)
{
    if (s->parameter_value)
        return s->parameter_value[i];
    double v = points_short(0.5 + 1.5 * points_uniform(random));
    double guess = s->parameter_near ? s->parameter_near[i] : NAN;
    if (isfinite(guess) && attempt < POSITIVE_STARTS)      /* near it, but a general value */
        return points_short(guess + 0.03 * (fabs(guess) + 0.1) * (v - 1.25));
    if (s->parameter_sign)
        return s->parameter_sign[i] * v;
    return attempt >= POSITIVE_STARTS && points_uniform(random) < 0.5 ? -v : v;
}

/* A point of the larger set is no start where the parameters are to have other signs. */
static bool signs_fit(const struct points_space *s)
{
    for (int i = 0; i < s->parameters; i++)
        if (s->parameter_sign && s->parameter_sign[i] * s->before->parameter[i] < 0)
            return false;
    return true;
}

/* In (0, 1), for a symbol at a start: by its name where that is asked for, else the next one. */
static double draw(const struct points_space *s, int symbol, uint64_t turn, uint64_t *random)
{
    if (!s->by_name)
        return points_uniform(random);
    uint64_t h = 1469598103934665603u;
    for (const char *name = s->st->symbol[symbol].name; *name; name++)
        h = (h ^ (unsigned char)*name) * 1099511628211u;
    h ^= turn;
    return points_uniform(&h);
}

static void start(const struct points_space *s, double spread, uint64_t *random, int attempt, struct points_point *p)
{
    if (s->before && attempt <= 1 && signs_fit(s)) {
        take_over(s, p);
        return;
    }
    double box = spread > 0 ? spread : 0;
    const int *scale = p->scaled ? s->scale : NULL;
    if (attempt > 8)
        box = fmax(box, 0.1) * (1 + 0.5 * (attempt - 8));
    uint64_t turn = s->by_name ? points_random(random) : 0;
    for (int i = 0; i < s->variables; i++) {
        double u = 2 * draw(s, s->variable[i], turn, random) - 1;
        double size = scale ? ldexp(1, scale[i]) : 1;
        if (s->near && attempt % 3 != 1 && fabs(s->near[i]) > LEAST_SIZE * size)
            size = fmin(size, fabs(s->near[i]));       /* it may be small because its unit is large */
        if (s->near)
            p->x[i] = box > 0 ? points_short(s->near[i] + box * (size + 0.02 * fabs(s->near[i])) * u) : s->near[i];
        else
            p->x[i] = points_short(size * fmax(box, 1.0) * 1.5 * u);
        num_ball_set_d(&p->ball, s->variable[i], p->x[i]);
    }
    for (int i = 0; i < s->parameters; i++) {
        p->parameter[i] = parameter_value(s, i, random, attempt);
        num_ball_set_d(&p->ball, s->parameter[i], p->parameter[i]);
    }
    /* the first start at a guess is at its own time; others are near it */
    p->t = s->near && spread == 0 && attempt == 0 ? s->near_time
           : points_short(s->near_time + (s->time_unit > 0 ? s->time_unit : 1) * 0.9 * points_uniform(random) * (s->near ? fmin(1, 4 * fmax(spread, 0.01)) : 1));
    if (s->time >= 0)
        num_ball_set_d(&p->ball, s->time, p->t);
    if (box > 0 || !s->near)       /* the guess itself stays */
        points_into_domain(s, box, random, p);
}

static enum points_status accepted(const struct points_space *s, struct points_point *p, bool strict, bool *outside)
{
    if (!points_on_sides(s->st, &p->ball, s->side, s->sides))
        return POINTS_NONE;
    bool out = strict && !points_in_domain(s, p);
    *outside |= out;
    return out ? POINTS_NONE : POINTS_OK;
}

/* strict: points outside of the domain are passed over, and *outside says that there were some. */
static enum points_status find(const struct points_space *s, double spread, uint64_t *random, slong prec, bool strict, bool *outside,
                               struct points_point *p)
{
    *p = (struct points_point){ .variables = s->variables, .constraints = s->constraints, .parameters = s->parameters };
    p->x = sga_calloc((size_t)s->variables, sizeof *p->x);
    p->parameter = sga_calloc((size_t)s->parameters, sizeof *p->parameter);
    p->solved = sga_calloc((size_t)s->constraints, sizeof *p->solved);
    num_ball_init(&p->ball, s->st, NEWTON_BITS);
    struct points_search own, *w = s->search ? s->search : &own;
    if (s->search)
        w->j.space = s;
    else
        points_search_init(w, s);
    SGA_ENDS(points_parts_clear) struct points_parts parts;
    points_parts_init(&parts, &w->j);
    enum points_status status = POINTS_NONE;
    SGA_FREED double *irregular = NULL;
    SGA_ENDS(points_branches_clear) struct points_branches branches;
    points_branches_init(&branches, s);
    double nearer = 1;
    int starts = s->starts ? s->starts : STARTS;
    for (int a = 0; a < starts && status != POINTS_OK; a++) {
        if (!sga_budget_ok(s->budget, NULL)) {
            status = POINTS_STOPPED;
            break;
        }
        if (s->steps && *s->steps <= 0)
            break;
        p->ball.prec = NEWTON_BITS;
        p->triangular = false;
        p->scaled = s->scale && a % 3 != 2;     /* sizes are a guess: not at every start */
        p->cheaply = s->near && s->cheap && a % 4 != 3;     /* what was given may have to move (x = 3 on a circle) */
        start(s, a < BRANCH_STARTS ? spread * nearer : spread, random, a, p);
        points_parts_restore(&parts, s, p);
        bool ask = branches.asked && a < BRANCH_STARTS;
        if (ask) {
            points_branches_at_guess(&branches, s, p);
            points_branches_at(&branches, s, p);
        }
        if (a >= (s->by_shape ? 0 : s->near ? 4 : 1) && s->constraints && points_triangular(s, p, prec, s->by_shape || a + LAST_STARTS >= starts)) {
            status = accepted(s, p, strict, outside);
            continue;
        }
        if (a % 2 && s->constraints > POINTS_MANY)
            points_one_by_one(&w->j, p);
        else if (a % FOLLOWED == FOLLOWED - 1 && s->constraints)
            points_follow(&w->j, p);
        /* from a point of the larger set only what is new must be met: moving new variables
         * alone often does that at once */
        int got = s->constraints ? points_newton(w, p, &parts, s->before && a == 0 && !(s->cheap && s->near && s->variables <= POINTS_FEW)) : 1;
        if (got == 1 && ask && !points_branches_kept(&branches, s, p)) {
            nearer *= NEARER;
            continue;           /* a step went over the change of branch: another start may stay where the guess is */
        }
        if (got == 1 && s->passing && s->constraints > POINTS_MANY) {
            num_ball_forget(&p->ball);      /* of the place before the last step */
            status = accepted(s, p, strict, outside);
        } else if (got == 1 && points_refine_with(w, p, prec) && (p->certified || !points_at_kink(s, p)))
            status = accepted(s, p, strict, outside);
        else if (got != 0 && !p->away && !irregular && p->scaled == (s->scale != NULL))      /* in units far from their sizes all is small */
            irregular = memcpy(sga_malloc((size_t)s->variables * sizeof(double)), p->x, (size_t)s->variables * sizeof(double));
        if (a >= (s->near ? 12 : 6) && irregular)     /* near a guess the first starts are beside it, where nothing regular may be */
            break;
    }
    if (status == POINTS_NONE && irregular) {
        status = POINTS_IRREGULAR;
        memcpy(p->x, irregular, (size_t)s->variables * sizeof(double));
    }
    if (!s->search)
        points_search_clear(&own);
    return status;
}

/* What a point that was found has: numbers of bits, and as many solved variables as constraints, each one of the space. */
static bool point_sane(const struct points_space *s, const struct points_point *p)
{
    bool sane = p->variables == s->variables && p->constraints == s->constraints && p->ball.prec > 1;
    for (int i = 0; i < s->constraints && sane; i++)
        sane = p->solved[i] >= 0 && p->solved[i] < s->variables;
    return sane;
}

enum points_status points_find(const struct points_space *s, double spread, uint64_t *random,
                               slong prec, struct points_point *p)
{
    bool outside = false;
    enum points_status status = find(s, spread, random, prec, true, &outside, p);
    assert(status != POINTS_OK || point_sane(s, p));
    if (status == POINTS_OK || status == POINTS_STOPPED || !outside)
        return status;
    points_point_clear(p);
    return find(s, spread, random, prec, false, &outside, p);
}

/* Through `most` of the stages at the most, each as many of them as the others. */
static enum points_status through_stages(const struct points_space *s, const int *end, int stages, int most, double spread, uint64_t *random, slong prec,
                                         struct points_point *p)
{
    struct points_space part = *s;
    struct points_point before = { 0 };
    part.search = NULL;                /* that is of all constraints */
    enum points_status status = POINTS_OK;
    *p = (struct points_point){ 0 };
    for (int turn = 0, turns = stages < most ? stages : most; turn < turns && status == POINTS_OK; turn++) {
        int k = (int)((turn + 1) * (long)stages / turns) - 1;
        assert(end[k] >= (k ? end[k - 1] : 0) && end[k] <= s->constraints);
        part.constraints = end[k];
        part.end = end;
        part.ends = k + 1;
        part.passing = k + 1 < stages;
        part.before = before.x ? &before : NULL;
        points_point_clear(p);
        status = points_find(&part, spread, random, k + 1 < stages ? NEWTON_BITS : prec, p);
        if (k + 1 < stages) {
            points_point_clear(&before);
            before = *p;
            *p = (struct points_point){ 0 };
        }
    }
    points_point_clear(&before);
    return status;
}

enum points_status points_find_staged(const struct points_space *s, const int *end, int stages,
                                      double spread, uint64_t *random, slong prec, struct points_point *p)
{
    enum points_status status = through_stages(s, end, stages, FEW_STAGES, spread, random, prec, p);
    if (stages > FEW_STAGES && status != POINTS_OK && status != POINTS_STOPPED) {      /* one after the other costs as many solutions as there are */
        points_point_clear(p);
        status = through_stages(s, end, stages, stages, spread, random, prec, p);
    }
    /* a first stage may lead to where the later ones cannot follow */
    if (!stages || (status != POINTS_OK && status != POINTS_STOPPED && !(s->starts && stages == 1))) {
        points_point_clear(p);
        status = points_find(s, spread, random, prec, p);
    }
    return status;
}

bool points_refine(const struct points_space *s, struct points_point *p, slong prec)
{
    assert(p->constraints == s->constraints && p->variables == s->variables);
    SGA_ENDS(points_search_clear) struct points_search w;
    points_search_init(&w, s);
    return points_refine_with(&w, p, prec);
}

static void *copied(const void *from, int count, size_t size)
{
    void *to = sga_malloc((size_t)(count + 1) * size);
    if (count)
        memcpy(to, from, (size_t)count * size);
    return to;
}

void points_point_copy(struct points_point *to, const struct points_point *from, slong prec)
{
    assert(from->x && prec > 1);
    *to = *from;
    to->x = copied(from->x, from->variables, sizeof *to->x);
    to->parameter = copied(from->parameter, from->parameters, sizeof *to->parameter);
    to->solved = copied(from->solved, from->constraints, sizeof *to->solved);
    num_ball_init(&to->ball, from->ball.st, prec);
    for (int i = 0; i < from->ball.st->symbols && (size_t)i < from->ball.symbol_cap; i++)
        num_ball_set(&to->ball, i, from->ball.symbol + i);
}

void points_point_clear(struct points_point *p)
{
    num_ball_clear(&p->ball);
    free(p->x);
    free(p->parameter);
    free(p->solved);
    *p = (struct points_point){ 0 };
}
