/* The sets of a sweep, one after the other, and once that pays with other processes. Sets are whole pieces of work, so their texts do
 * not depend on who makes them. */
#include "sweep_team.h"

#include <assert.h>
#include <stdlib.h>
#include <string.h>

#include "budget.h"
#include "buf.h"
#include "error.h"
#include "mem.h"
#include "run_job.h"
#include "share.h"
#include "team.h"
#include "warnings.h"
#include "watch.h"

/* Another process starts, and comes to the sweep as this one did; more than so many times that, and so many seconds, should be left. */
static const double PAYS = 2, PAYS_SECONDS = 0.3, ASKED_EVERY = 0.1;

struct sweep_run {
    struct job *j;
    int sets;
    char **text;                  /* by set; NULL: not made yet */
    size_t bytes;
    int made;                     /* whose texts are here */
    int shown;                    /* as how many progress counts: others have some too */
    struct sweep_maker maker;
    struct sweep_left left;
    struct sga_share *share, whole;   /* share: of the budget, or NULL */
    int warned;                   /* warnings of the job that have been given to whoever leads */
    long counted[SGA_COUNTERS];   /* and counts of work */
};

/* -- What a member gives: the same program reads it -- */

struct given_head { struct sweep_left left; int warnings; long counted[SGA_COUNTERS]; };
struct given_warning { enum sga_warning kind; size_t pointer, detail; };

static void put(struct sga_buf *out, const void *data, size_t bytes)
{
    sga_buf_put(out, data, bytes);
}

/* The sets [from, to), with what is new since the last time. */
static void write_given(struct sweep_run *s, int from, int to, const struct sweep_left *left, struct sga_buf *out)
{
    const struct sga_warnings *w = s->j->warnings;
    struct given_head head = { .left = *left, .warnings = w->count - s->warned };
    for (int k = 0; k < SGA_COUNTERS; k++) {
        head.counted[k] = sga_watch_counted((enum sga_counter)k) - s->counted[k];
        s->counted[k] += head.counted[k];
    }
    put(out, &head, sizeof head);
    for (int i = s->warned; i < w->count; i++) {
        struct given_warning g = { w->list[i].kind, strlen(w->list[i].pointer), strlen(w->list[i].detail) };
        put(out, &g, sizeof g);
        put(out, w->list[i].pointer, g.pointer + 1);
        put(out, w->list[i].detail, g.detail + 1);
    }
    s->warned = w->count;
    for (int k = from; k < to; k++) {
        size_t length = strlen(s->text[k]);
        put(out, &length, sizeof length);
        put(out, s->text[k], length + 1);
    }
}

/* What is left to read of it. */
struct reading { const char *at; size_t bytes; };

static bool get(struct reading *r, void *out, size_t bytes)
{
    if (r->bytes < bytes)
        return false;
    memcpy(out, r->at, bytes);
    r->at += bytes;
    r->bytes -= bytes;
    return true;
}

/* A text of so many bytes and its 0, in its place; NULL: it is none. */
static const char *get_text(struct reading *r, size_t length)
{
    const char *text = r->at;
    if (r->bytes <= length || text[length] != 0 || strlen(text) != length)
        return NULL;
    r->at += length + 1;
    r->bytes -= length + 1;
    return text;
}

static bool read_warnings(struct sweep_run *s, struct reading *r, int count)
{
    for (int i = 0; i < count; i++) {
        struct given_warning g;
        const char *pointer, *detail;
        if (!get(r, &g, sizeof g) || g.kind >= SGA_WARNINGS || !(pointer = get_text(r, g.pointer)) || !(detail = get_text(r, g.detail)))
            return false;
        sga_warn(s->j->budget, g.kind, pointer, "%s", detail);
    }
    return true;
}

static bool keep(struct sweep_run *s, int set, char *text)
{
    assert(!s->text[set]);
    s->text[set] = text;
    s->bytes += strlen(text);
    s->made++;
    struct sga_buf all = { .len = s->bytes };
    return answer_fits(s->j, &all);
}

static bool take(void *of, int from, int to, const char *data, size_t bytes)
{
    struct sweep_run *s = of;
    struct reading r = { data, bytes };
    struct given_head head;
    if (from < 0 || from > to || to > s->sets || !get(&r, &head, sizeof head) || !read_warnings(s, &r, head.warnings))
        return sga_fail(s->j->err, SGA_E_INTERNAL, "a process that helped gave what is not understood");
    for (int k = from; k < to; k++) {
        size_t length;
        const char *text = get(&r, &length, sizeof length) ? get_text(&r, length) : NULL;
        if (!text || s->text[k])
            return sga_fail(s->j->err, SGA_E_INTERNAL, "a process that helped gave what is not understood");
        if (!keep(s, k, sga_strdup(text)))
            return false;
    }
    for (int k = 0; k < SGA_COUNTERS; k++)
        sga_watch_count((enum sga_counter)k, head.counted[k]);
    s->left.moved += head.left.moved;
    s->left.found += head.left.found;
    s->left.late |= head.left.late;
    return true;
}

/* -- Making them -- */

/* The share of the whole that the next set is. */
static void show(struct sweep_run *s)
{
    double each = (s->whole.to - s->whole.from) / s->sets;
    if (!s->share)
        return;
    s->share->from = s->whole.from + s->shown * each;
    s->share->to = s->share->from + each;
}

static bool make(struct sweep_run *s, int from, int to)
{
    for (int k = from; k < to; k++) {
        show(s);
        char *text = s->maker.make(s->maker.of, k, &s->left);
        if (!text)
            return false;
        if (!keep(s, k, text))
            return false;
        s->shown++;
    }
    return true;
}

/* Seconds that the job has run for. */
static double spent(const struct job *j)
{
    return sga_now() - (j->budget->deadline - j->budget->seconds);
}

/* Alone, until others help or all is made: *from is the first set that is not. */
static bool make_alone(struct sweep_run *s, struct sga_team *team, int *from)
{
    double begun = sga_now(), asked = 0, before = spent(s->j);
    for (*from = 0; *from < s->sets;) {
        if (!make(s, *from, *from + 1))
            return false;
        ++*from;
        double now = sga_now(), each = (now - begun) / *from, rest = each * (s->sets - *from);
        if (!team || s->sets - *from < 2 || rest < PAYS * before + PAYS_SECONDS || now < asked + ASKED_EVERY)
            continue;
        asked = now;
        if (team->share(team->ctx, *from, s->sets, spent(s->j), each))
            return true;
    }
    return true;
}

/* With others, until all is there. */
static bool make_shared(struct sweep_run *s, struct sga_team *team)
{
    int from, to, made;
    team->of = s;
    team->take = take;
    while (s->made < s->sets && team->next(team->ctx, &from, &to, &made)) {
        s->shown = made - (to - from);
        if (!make(s, from, to))
            return false;
    }
    return job_goes_on(s->j) && s->j->err->code == SGA_E_OK && (s->made == s->sets || sga_fail(s->j->err, SGA_E_INTERNAL, "sets of the sweep are missing"));
}

/* A member's part. */
static bool help(struct sweep_run *s, struct sga_team *team)
{
    int from, to, made;
    bool ok = true;
    s->warned = s->j->warnings->count;
    for (int k = 0; k < SGA_COUNTERS; k++)
        s->counted[k] = sga_watch_counted((enum sga_counter)k);
    while (ok && team->next(team->ctx, &from, &to, &made)) {
        struct sga_buf out = { 0 };
        s->left = (struct sweep_left){ .found = s->left.found };
        int found = s->left.found;
        ok = from >= 0 && to <= s->sets && make(s, from, to);
        if (ok) {
            struct sweep_left left = s->left;
            left.found -= found;
            write_given(s, from, to, &left, &out);
            ok = team->give(team->ctx, from, to, out.data, out.len);
        }
        sga_buf_free(&out);
    }
    return ok;
}

/* The texts as an array; they end on the way. */
static char *join(struct sweep_run *s)
{
    struct sga_buf out = { 0 };
    sga_buf_puts(&out, "[");
    for (int k = 0; k < s->sets; k++) {
        sga_buf_puts(&out, k ? "," : "");
        sga_buf_puts(&out, s->text[k]);
        free(s->text[k]);
        s->text[k] = NULL;
    }
    sga_buf_puts(&out, "]");
    return sga_buf_take(&out);
}

char *sweep_all(struct job *j, int sets, bool alone, struct sweep_maker maker, struct sweep_left *left)
{
    struct sweep_run s = { .j = j, .sets = sets, .text = sga_calloc((size_t)sets + 1, sizeof *s.text), .maker = maker, .share = j->budget->share };
    struct sga_team *team = j->host.team && !j->host.team->begun && !j->place.depth && !alone ? j->host.team : NULL;
    int made = 0;
    if (s.share)
        s.whole = *s.share;
    if (team)
        team->begun = true;
    bool ok = job_helps(j) || make_alone(&s, team, &made);
    if (ok && job_helps(j))
        ok = team && help(&s, team);
    else if (ok && made < sets)
        ok = make_shared(&s, team);
    if (job_helps(j) && !j->err->code)
        sga_fail(j->err, SGA_E_CANCELLED, "what this process was asked to help with is made");
    if (s.share)
        s.share->from = s.whole.from, s.share->to = s.whole.to;
    *left = s.left;
    char *all = ok && !job_helps(j) ? join(&s) : NULL;
    for (int k = 0; k < sets; k++)
        free(s.text[k]);
    free(s.text);
    return all;
}
