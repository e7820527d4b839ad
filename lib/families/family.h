/* Inside lib/families only: entries as texts with numbers in them. */
#ifndef SGA_FAMILIES_FAMILY_H
#define SGA_FAMILIES_FAMILY_H

#include <stdint.h>

#include "families.h"

struct sga_arena;

/* Whole numbers that may vary: between [ and ]; elsewhere in a text; the member tangency_of. */
enum slot_kind { SLOT_INDEX, SLOT_LITERAL, SLOT_MEMBER };
struct slot { size_t at, length; enum slot_kind kind; };

struct entry {
    const char *text; size_t length;     /* 0-terminated only where all of the list is */
    uint64_t shape;                      /* of what is between the slots: equal for equal texts */
    int slots;
    long place;                          /* in the list, from 0; in an object 0 */
    long *value;                         /* slots of them */
};

/* The end of the JSON value at s. */
const char *family_value_end(const char *s, const char *end);
/* The entries of a list, or of an object ("name":value), at s. */
struct entry *family_entries(const char *s, const char *end, int *count, struct sga_arena *mem);
/* The slots of an entry's text, into `slot` (or NULL); their number. `value`, where it is not NULL, and `shape` are set too. */
int family_slots(const char *text, size_t length, struct slot *slot, long *value, uint64_t *shape);

/* count entries from `first`, `rows` times (1: one loop). Entry (r, k) of an object's or list's group stands at first + r * count + k. */
struct family {
    const struct entry *const *at;       /* of rows * count */
    int count, rows;
    bool object;
};
/* Appends the folded entry. False: no loop can say it. */
bool family_print(const struct family *f, const struct families_letters *letters, struct sga_buf *out);
/* Whether steps of numbers can be said with the names of a loop: entry b after a, by the inner loop (rows 1), or row after row. */
bool family_sayable(const struct family *f);

/* A folded entry of a list taken apart: all in the arena. False: it is none. */
struct folded { char *loop, *place, *body; long count; };
bool folded_read(const char *text, size_t length, struct folded *out, struct sga_arena *mem);
/* Calls give(ctx, place, text) for each entry; false where it does, or the loop is none. */
typedef bool folded_give(void *ctx, long place, const struct sga_buf *text);
bool folded_each(const struct folded *f, folded_give *give, void *ctx);
/* The same for a member of an object, "name[i = 1:3]":value; no place. */
bool folded_member_each(const char *text, size_t length, folded_give *give, void *ctx, struct sga_arena *mem);
bool folded_member_is(const char *text, size_t length);

#endif
