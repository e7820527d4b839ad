/* A family as one entry: where its loops start, and each number by their names. */
#include <assert.h>
#include <stdlib.h>
#include <string.h>

#include "arena.h"
#include "buf.h"
#include "family.h"

struct face {
    const struct family *f;
    const char *row, *along;      /* the loops' names: of rows, and along them */
    struct slot *slot;
    int slots, keys;              /* keys: the first of them are indices of an object's name */
    long inner, outer;            /* where the loops start */
};

static const struct entry *corner(const struct family *f, int row, int k)
{
    return f->at[row * f->count + k];
}

/* By how much slot s grows along a row, and from row to row; slot -1 is the place. */
static long value(const struct entry *e, int s)
{
    return s < 0 ? e->place : e->value[s];
}

static long step(const struct family *f, int s)
{
    return value(corner(f, 0, 1), s) - value(corner(f, 0, 0), s);
}

static long jump(const struct family *f, int s)
{
    return f->rows > 1 ? value(corner(f, 1, 0), s) - value(corner(f, 0, 0), s) : 0;
}

static int keys_of(const struct family *f, const struct slot *slot, int slots)
{
    const struct entry *e = corner(f, 0, 0);
    const char *colon = f->object ? memchr(e->text, ':', e->length) : NULL;
    int keys = 0;
    while (colon && keys < slots && e->text + slot[keys].at < colon)
        keys++;
    return keys;
}

/* The slot that a loop's name stands for alone, which is where the loop starts: of an object's name, or of a number in a text, which
 * nothing but the name can say; otherwise the first index that it can. -1: none. */
static int leader(const struct face *s, bool outer)
{
    int first = -1;
    for (int k = 0; k < s->slots; k++) {
        long own = outer ? jump(s->f, k) : step(s->f, k), other = outer ? step(s->f, k) : jump(s->f, k);
        if (own != 1 || other)
            continue;
        if (k < s->keys || s->slot[k].kind == SLOT_LITERAL)
            return k;
        if (first < 0 && s->slot[k].kind == SLOT_INDEX)
            first = k;
    }
    return first;
}

static void start(struct face *s)
{
    int inner = leader(s, false), outer = leader(s, true);
    const struct entry *e = corner(s->f, 0, 0);
    s->inner = inner < 0 ? 1 : e->value[inner];
    s->outer = outer < 0 ? 1 : e->value[outer];
}

/* A number in a text must be a loop's name, as sums in it are not worked out; so must an index that a member's name has. */
static bool sayable(const struct face *s)
{
    int inner = 0, outer = 0;
    for (int k = 0; k < s->slots; k++) {
        long a = step(s->f, k), b = jump(s->f, k), v = corner(s->f, 0, 0)->value[k];
        if ((!a && !b) || (k >= s->keys && s->slot[k].kind != SLOT_LITERAL))
            continue;
        if ((a && b) || (a && (a != 1 || v != s->inner)) || (b && (b != 1 || v != s->outer)))
            return false;
        inner += k < s->keys && a;
        outer += k < s->keys && b;
    }
    return !s->f->object || (inner == 1 && outer == (s->f->rows > 1));
}

static bool term(struct sga_buf *out, long factor, const char *name, bool first)
{
    if (!factor)
        return first;
    sga_buf_puts(out, factor < 0 ? "-" : first ? "" : "+");
    if (labs(factor) != 1)
        sga_buf_printf(out, "%ld*", labs(factor));
    sga_buf_puts(out, name);
    return false;
}

static void put_value(const struct face *s, int k, struct sga_buf *out)
{
    long a = step(s->f, k), b = jump(s->f, k), rest = value(corner(s->f, 0, 0), k) - a * s->inner - b * s->outer;
    bool before = rest > 0 && a <= 0 && b <= 0, first = !before;
    if (before)
        sga_buf_printf(out, "%ld", rest);
    first = term(out, b, s->row, first);
    first = term(out, a, s->along, first);
    if (!before && (rest || first))
        sga_buf_printf(out, first ? "%ld" : "%+ld", rest);
}

static void put_slot(const struct face *s, int k, struct sga_buf *out)
{
    long a = step(s->f, k), b = jump(s->f, k);
    if (k < s->keys && (a || b))
        sga_buf_printf(out, "%s = %ld:%ld", a ? s->along : s->row, a ? s->inner : s->outer,
                       a ? s->inner + s->f->count - 1 : s->outer + s->f->rows - 1);
    else if (s->slot[k].kind == SLOT_MEMBER && (a || b))
        sga_buf_puts(out, "\"constraints["), put_value(s, k, out), sga_buf_puts(out, "]\"");
    else
        put_value(s, k, out);
}

/* The entry's text with what stands in its slots, from byte `from` on. */
static void put_text(const struct face *s, size_t from, struct sga_buf *out)
{
    const struct entry *e = corner(s->f, 0, 0);
    for (int k = 0; k < s->slots; k++) {
        sga_buf_put(out, e->text + from, s->slot[k].at - from);
        put_slot(s, k, out);
        from = s->slot[k].at + s->slot[k].length;
    }
    sga_buf_put(out, e->text + from, e->length - from);
}

static void put_loop(const struct face *s, struct sga_buf *out)
{
    const struct family *f = s->f;
    sga_buf_puts(out, "{\"for\":\"");
    if (f->rows > 1)
        sga_buf_printf(out, "%s = %ld:%ld, ", s->row, s->outer, s->outer + f->rows - 1);
    sga_buf_printf(out, "%s = %ld:%ld\",\"count\":%d,\"place\":\"", s->along, s->inner, s->inner + f->count - 1, f->count * f->rows);
    put_value(s, -1, out);
    sga_buf_puts(out, "\",");
}

/* An object with one member `expression` is what a text becomes. */
static bool reads_as_text(const struct entry *e)
{
    static const char only[] = "{\"expression\":\"";
    size_t n = sizeof only - 1;
    return e->length > n && memcmp(e->text, only, n) == 0 && family_value_end(e->text + 1, e->text + e->length) == e->text + e->length - 1;
}

static struct face face_of(const struct family *f, const struct families_letters *letters, struct sga_arena *mem)
{
    const struct entry *e = corner(f, 0, 0);
    uint64_t shape;
    struct face s = { .f = f, .row = letters->outer, .along = f->rows > 1 ? letters->inner : letters->outer, .slots = e->slots };
    s.slot = sga_zeros(mem, (size_t)e->slots, sizeof *s.slot);
    int again = family_slots(e->text, e->length, s.slot, NULL, &shape);
    assert(again == e->slots && shape == e->shape);
    s.keys = keys_of(f, s.slot, s.slots);
    start(&s);
    return s;
}

bool family_sayable(const struct family *f)
{
    SGA_ARENA(mem);
    struct families_letters none = { "i", "j" };
    struct face s = face_of(f, &none, &mem);
    return sayable(&s);
}

bool family_print(const struct family *f, const struct families_letters *letters, struct sga_buf *out)
{
    SGA_ARENA(mem);
    assert(f->count >= 2 && f->rows >= 1);
    const struct entry *e = corner(f, 0, 0);
    struct face s = face_of(f, letters, &mem);
    if (!sayable(&s) || (!f->object && ((*e->text != '{' && *e->text != '"') || e->length < 3 || reads_as_text(e))))
        return false;
    if (f->object) {
        put_text(&s, 0, out);
        return true;
    }
    put_loop(&s, out);
    if (*e->text == '"')
        sga_buf_puts(out, "\"expression\":");
    put_text(&s, *e->text == '{', out);
    if (*e->text == '"')
        sga_buf_puts(out, "}");
    return true;
}
