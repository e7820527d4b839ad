/* Guards: functions of time and state that are watched along a motion's steps.
 *
 * An event, a switch, a pulse, a pivot, a denominator, the border of a domain: each is a function whose zeros, and whose places near zero, matter, and
 * what a zero means is for those to say who watch it. Where zeros are is found here, for all of them, on the way that a step makes: a curve over
 * [0, 1], as the polynomial of the method that made it, and whatever the functions do along it. Nothing here knows of steps, methods or systems.
 *
 * A table has nodes on the way between which each function is monotone as far as its values are known to rounding, so that no change of sign and no
 * touch of 0 hides between neighbours, however close others are (products, clusters of zeros). Of two neighbours with values of opposite signs
 * guard_root finds the place between; of three with the least value in the middle, guard_least the least value. */
#ifndef SGA_GUARD_H
#define SGA_GUARD_H

#include <stdbool.h>
#include <stddef.h>

struct sga_budget;

struct guard_way {
    int count;
    /* All functions at s in [0, 1]; what is not finite has no value there. */
    void (*at)(void *of, double s, double *g);
    /* The same where the way begins (false) and ends (true): the points there may lie beside what `at` gives, by what steps are corrected by. NULL: as at. */
    void (*end)(void *of, bool end, double *g);
    bool from_end;             /* extremes between an end and the node beside it are looked for too, where what `end` gives may make some */
    void *of;
    double grain;              /* of the way, > 0: places are not told apart that are nearer */
    const double *noise;       /* by function: what its values are uncertain by, beside some roundings of the largest one; NULL: nothing */
    const struct sga_budget *budget;       /* told where a limit is met; may be NULL */
};

/* A function seems not to change from a to b, as far as rounding of its largest value, `most`, tells. */
struct guard_quiet { double a, b, most; int function; };

struct guard_table {
    int count, nodes, room;
    double *theta, *value;     /* nodes, ascending from 0 to 1; nodes x count */
    double *g;                 /* count: those of the last place asked for */
    double *low, *high;        /* ranges over the nodes */
    double *noise, *tail;      /* what values are uncertain by; work */
    double *turn;              /* where functions turn */
    struct guard_quiet *quiet;
    size_t turn_room, quiet_room;
    int turns, quiets;
};

void guard_table_init(struct guard_table *t, int count);
void guard_table_clear(struct guard_table *t);
/* Nodes in equal distances, as many as tell the values between them, and one beside each end. Cost: 30 evaluations, more where functions vary faster than the way. */
void guard_table_fill(struct guard_table *t, const struct guard_way *way);
/* After that: nodes where any of the functions has an extreme. Cost: some 20 evaluations, and more where functions vary faster than polynomials of degree 16. */
void guard_table_monotone(struct guard_table *t, const struct guard_way *way);
/* Value k of the function at a node. */
static inline double guard_value(const struct guard_table *t, int node, int k) { return t->value[(size_t)node * (size_t)t->count + (size_t)k]; }
/* Nodes ascend from 0 to 1 (linear cost). */
bool guard_table_sane(const struct guard_table *t);

/* Inside this folder, guard_turns.c: where functions turn into t->turn, ascending; t->low and t->high are known. */
void guard_table_turns(struct guard_table *t, const struct guard_way *way);

/* Where function k changes its sign between a and b, to the grain: the place beyond, or where it is 0. ga, gb: its values there, of which none has the sign of the other.
 * g (count): work; the functions at some place near. Regula falsi with halving (Illinois), and a bisection in every fourth turn, for those that bend. */
double guard_root(const struct guard_way *way, int k, double a, double ga, double b, double gb, double *g);

/* Three places on the way and the value s g_k in the middle, which is the least: sense is the s that makes it a minimum. */
struct guard_dip { double a, at, b, value; int function, sense; };
/* The place moves to the least value between a and b, to `near` of the way. Golden sections; the values need not be smooth.
 * g: work. */
void guard_least(const struct guard_way *way, struct guard_dip *d, double near, double *g);

/* A function at both ends of a way: values, and derivatives by s. */
struct guard_ends { double start, rate, last, last_rate; };
/* The cubic of these has one sign, and comes to no less than half of the lesser value. And: the function is that cubic, more or less, as its value at s in (0, 1) tells. Both: it
 * does not come near 0, as far as it varies no faster than the way. */
bool guard_stays(const struct guard_ends *e);
double guard_lowest(const struct guard_ends *e, double side);      /* of side times that cubic */
bool guard_fits(const struct guard_ends *e, double s, double value);

#endif
