/* Inside the points folder: the constraint set on the other sides of its switches.
 *
 * Constraints that are made with abs, sign, min, max, or roots of squares are one analytic function on each side of a
 * surface. What was found to be 0 on the set near the points holds as far as that surface: y = x max(x, 0) and
 * z y = 0 leave z free where x < 0 only, though z y itself has no sides. So points of the set are looked for on the other
 * sides, near the first point, one switch after the other as a motion would meet them, and functions are asked
 * there. Searches, within a bound that they share. */
#ifndef SGA_POINTS_BEYOND_H
#define SGA_POINTS_BEYOND_H

#include "points.h"

struct points_side;

/* A point of the set where some switches are on other sides than at the first point. */
struct points_piece {
    struct points_point p;
    signed char *sign;             /* by switch */
    int last;                      /* it was found by passing this one */
    int backed;                    /* `back`: 0 not looked for, 1 there, -1 none was found */
    struct points_point back;      /* from it, the other way over the same switch */
};

enum points_reached { POINTS_NOT_ASKED, POINTS_NOT_SEARCHED, POINTS_NONE_BEYOND, POINTS_BEYOND };

struct points_switch {
    expr_id function;              /* what changes its sign */
    signed char sign;              /* at the first point */
    int group;                     /* of variables that constraints connect, as points_beyond.group says */
    bool fixed;                    /* it depends on parameters alone, and is passed by changing these */
    bool timed;
    bool root;                     /* of a square: modulo a prime it is this or that root */
    enum points_reached reached;
};

struct points_beyond {
    bool listed;
    struct points_switch *at; int count; size_t cap;
    int *group;                    /* by symbol: its representative, for variables of constraints */
    int symbols;
    int *constraint_group;         /* by constraint: that of its variables, or -1 */
    struct points_piece *piece; int pieces; size_t piece_cap;
    bool denied;                   /* the last search found nothing because it had no work left */
    bool cut_short;                /* some switches were not looked at: too many, or too much work; stays */
    double work;                   /* of all searches so far: steps times what a step costs; stays */
};

/* The switches of the space's constraints at p, a point of the set. Cost: a walk through the constraints. */
void points_beyond_list(struct points_beyond *b, const struct points_space *space, struct points_point *p);
/* Of a variable of the constraints, by symbol: its group. */
int points_beyond_group(struct points_beyond *b, int symbol);
/* A new set: what was found is dropped. */
void points_beyond_forget(struct points_beyond *b);
void points_beyond_clear(struct points_beyond *b);
/* Whether the function is that of a switch of the constraints. */
bool points_beyond_has(const struct points_beyond *b, expr_id function);

/* The last sides but `known` are of switches of e alone, found by putting in the other branch: drops those beyond which
 * e is 0 at a point of the set all the same, as several change together (max(x, -x) = |x|); what the set
 * does not come near to, as far as could be found, is unseen. */
void points_beyond_check(struct points_beyond *b, const struct points_space *space, struct points_point *p, expr_id e,
                         const expr_id *list, int count, struct points_side *side, int *sides, int known);
/* e is 0 at p, and with any one of its own switches on the other branch: adds a side for each two that must both change, and can. */
void points_beyond_pairs(struct points_beyond *b, const struct points_space *space, struct points_point *p, expr_id e,
                         const expr_id *list, int count, struct points_side **side, int *sides, size_t *cap);
/* e is 0 on the set near p (list: its cone). Adds to *side the sides on which that rests: e is not 0 at a point beyond,
 * or (unseen) there is none beyond that could be found. Searches beyond each switch that constraints connect with e, once for a set.
 * roots: only beyond those of square roots. */
void points_beyond_sides(struct points_beyond *b, const struct points_space *space, struct points_point *p, expr_id e,
                         const expr_id *list, int count, bool roots, struct points_side **side, int *sides, size_t *cap);

/* e is not 0 at p (list: its cone). Adds to *side the sides beyond which it is 0 on the set, of its own switches and of the
 * constraints'. Searches as above. */
void points_beyond_zeros(struct points_beyond *b, const struct points_space *space, struct points_point *p, expr_id e,
                         const expr_id *list, int count, struct points_side **side, int *sides, size_t *cap);

#endif
