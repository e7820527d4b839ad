/* Stamps and places of cones, lent one after the other. */
#include "raw_nodes.h"

#include <assert.h>
#include <stdlib.h>

#include "mem.h"

enum { KEPT = 8 };             /* more cones at a time make their own */

struct expr_marks {
    int users;                 /* the store, and cones that borrowed */
    int count;
    struct expr_cone kept[KEPT];   /* stamps and places only */
};

struct expr_marks *expr_marks_new(void)
{
    struct expr_marks *m = sga_calloc(1, sizeof *m);
    m->users = 1;
    return m;
}

void expr_marks_leave(struct expr_marks *m)
{
    if (!m)
        return;
    assert(m->users > 0);
    if (--m->users)
        return;
    for (int i = 0; i < m->count; i++) {
        free(m->kept[i].stamp);
        free(m->kept[i].place);
    }
    free(m);
}

void expr_marks_lend(struct expr_marks *m, struct expr_cone *c)
{
    assert(m && !c->from && !c->stamp);
    m->users++;
    if (m->count)
        *c = (struct expr_cone){ .list = c->list, .list_cap = c->list_cap, .stamp = m->kept[m->count - 1].stamp,
                                 .stamp_cap = m->kept[m->count - 1].stamp_cap, .now = m->kept[m->count - 1].now,
                                 .place = m->kept[m->count - 1].place, .place_cap = m->kept[m->count - 1].place_cap };
    m->count -= m->count > 0;
    c->from = m;
}

void expr_marks_back(struct expr_cone *c)
{
    struct expr_marks *m = c->from;
    if (m && m->users > 1 && m->count < KEPT) {
        m->kept[m->count++] = (struct expr_cone){ .stamp = c->stamp, .stamp_cap = c->stamp_cap, .now = c->now,
                                                  .place = c->place, .place_cap = c->place_cap };
    } else {
        free(c->stamp);
        free(c->place);
    }
    c->stamp = NULL;
    c->place = NULL;
    c->from = NULL;
    expr_marks_leave(m);
}
