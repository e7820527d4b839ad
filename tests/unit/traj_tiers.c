/* Tiers of a start, against the words of tiers.h, of all kinds of four variables, given, held or left out; and stages by what they move. */
#include "check.h"
#include "kinds.h"
#include "tiers.h"

enum { N = 4, KINDS = 4, WAYS = 3 };
enum way { LEFT_OUT, GIVEN, HELD };

/* What is said of one variable: its tier, or -1: it stays. */
static int tier_in_words(enum tiers_stage stage, enum sys_kind kind, enum way way)
{
    if (way == HELD)
        return -1;
    if (way == LEFT_OUT)
        return kind == SYS_COORDINATE ? 3 : kind == SYS_VELOCITY ? 4 : 5;
    switch (stage) {
    case TIERS_KEEP_ALL:
        return -1;
    case TIERS_KEEP_STATES:
        return kind == SYS_ALGEBRAIC || kind == SYS_MULTIPLIER ? 0 : -1;
    case TIERS_MOVE_ALL:
        return kind == SYS_MULTIPLIER ? 2 : 0;
    case TIERS_KEEP_PLACES:
        return kind == SYS_COORDINATE ? -1 : kind == SYS_VELOCITY ? 1 : kind == SYS_MULTIPLIER ? 2 : 0;
    default:
        return kind == SYS_VELOCITY ? 1 : kind == SYS_MULTIPLIER ? 2 : 0;
    }
}

struct start {
    unsigned char kind[N], given[N], held[N];
    double initial[N], x[N];
    struct traj_request rq;
};

/* The k-th of all; some have no list of what is held. */
static bool make(struct start *s, unsigned k)
{
    bool holds = false;
    *s = (struct start){ .initial = { 1, -2, 0, 1e-3 } };
    for (int j = 0; j < N; j++, k /= KINDS * WAYS) {
        enum way way = (enum way)(k % WAYS);
        s->kind[j] = (unsigned char)(k / WAYS % KINDS);
        s->given[j] = way != LEFT_OUT;
        s->held[j] = way == HELD;
        s->x[j] = s->initial[j];
        holds |= way == HELD;
    }
    s->rq = (struct traj_request){ .initial = s->initial, .given = s->given, .held = holds ? s->held : NULL };
    return k == 0;
}

static enum way way_of(const struct start *s, int j)
{
    return s->held[j] ? HELD : s->given[j] ? GIVEN : LEFT_OUT;
}

/* Of given values that are not held, whether some are of these kinds. */
static bool some(const struct start *s, unsigned kinds)
{
    bool any = false;
    for (int j = 0; j < N; j++)
        any |= way_of(s, j) == GIVEN && (kinds >> s->kind[j] & 1);
    return any;
}

static void stages(struct start *s)
{
    const unsigned states = 1u << SYS_COORDINATE | 1u << SYS_VELOCITY, follow = 1u << SYS_ALGEBRAIC | 1u << SYS_MULTIPLIER;
    for (int k = 0; k < TIERS_STAGES; k++) {
        signed char tier[N];
        enum tiers_stage stage = (enum tiers_stage)k;
        tiers_of(&s->rq, s->kind, N, stage, tier);
        for (int j = 0; j < N; j++)
            CHECK(tier[j] == tier_in_words(stage, s->kind[j], way_of(s, j)), "stage %d, kind %d, way %d: %d", k, s->kind[j], way_of(s, j), tier[j]);
        bool others = k == TIERS_KEEP_ALL || (k == TIERS_KEEP_STATES ? some(s, follow) : k == TIERS_MOVE_ALL ? some(s, states)
                    : some(s, 1u << SYS_COORDINATE) && some(s, 1u << SYS_VELOCITY));
        CHECK(tiers_differ(&s->rq, s->kind, N, stage) == others, "stage %d", k);
    }
}

/* One value after the other moves: the stage is the first that lets it. */
static void found(struct start *s)
{
    CHECK(tiers_stage_of(&s->rq, s->kind, N, s->x) == TIERS_KEEP_ALL);
    for (int i = 0; i < N; i++)
        for (int j = 0; j < N; j++) {
            s->x[i] += 0.5;
            s->x[j] += 0.25;
            bool state = false, any = false;
            for (int k = 0; k < N; k++) {
                bool moved = s->given[k] && (k == i || k == j);
                any |= moved;
                state |= moved && s->kind[k] < SYS_ALGEBRAIC;
            }
            CHECK(tiers_stage_of(&s->rq, s->kind, N, s->x) == (state ? TIERS_MOVE_ALL : any ? TIERS_KEEP_STATES : TIERS_KEEP_ALL), "%d and %d", i, j);
            s->x[i] = s->initial[i];
            s->x[j] = s->initial[j];
        }
}

int main(void)
{
    struct start s;
    for (unsigned k = 0; make(&s, k); k++) {
        stages(&s);
        found(&s);
    }
    return CHECK_END();
}
