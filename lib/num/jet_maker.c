/* Sums of products for the code of series.
 *
 * What takes time is waiting: coefficient k of one row is a factor in the sum for coefficient
 * k of the next. So all products of older coefficients come first (in pairs, one of the two
 * rows from a copy that runs downwards), and the few with coefficients of the present order
 * last, the newest at the very end. Pairs are read only of coefficients that were stored long ago: a
 * pair cannot be read while its halves are on their way to memory. The sums are routines, one for each length: code that
 * does not fit into the caches near the processor runs no faster than it can be fetched. */
#include "jet_maker.h"

#include <string.h>

#include "mem.h"

void jet_do(struct jet_maker *m, enum jet_act_kind kind, int to, int from)
{
    SGA_RESERVE(m->act, m->cap, m->count + 1);
    m->act[m->count++] = (struct jet_act){ .kind = (unsigned char)kind, .to = (unsigned char)to, .from = (unsigned char)from };
}

void jet_at(struct jet_maker *m, enum jet_act_kind kind, int to, int slot)
{
    jet_do(m, kind, to, 0);
    m->act[m->count - 1].slot = slot;
}

void jet_forget(struct jet_maker *m)
{
    for (int r = JET_RING; r < JET_RING_END; r++) {
        if (m->holds[r] >= 0)
            m->held[m->holds[r]] = -1;
        m->holds[r] = -1;
    }
}

void jet_next_order(struct jet_maker *m)
{
    jet_forget(m);
    memset(m->made, 0, (size_t)m->p->rows * sizeof *m->made);
    m->clock = 0;
}

int jet_fresh(struct jet_maker *m)
{
    int r = m->ring, row = m->holds[r];
    m->ring = r + 1 == JET_RING_END ? JET_RING : r + 1;
    if (row >= 0 && m->owed[row] && m->last[row] >= m->at)
        jet_at(m, ACT_STORE, r, jet_slot(m, row, m->k));
    if (row >= 0)
        m->owed[row] = 0;
    if (m->holds[r] >= 0)
        m->held[m->holds[r]] = -1;
    m->holds[r] = -1;
    return r;
}

void jet_hold(struct jet_maker *m, int reg, int row)
{
    m->holds[reg] = row;
    m->held[row] = reg;
}

void jet_keep(struct jet_maker *m, int reg, int row, int i)
{
    bool down = m->reversed[row] >= 0;
    if (m->owed[row] && !down)
        return;
    jet_at(m, m->owed[row] || !down ? ACT_STORE : ACT_STORE_BOTH, reg, m->owed[row] ? m->reversed[row] - i : jet_slot(m, row, i));
    m->act[m->count - 1].other = m->reversed[row] - i;
}

void jet_put(struct jet_maker *m, int reg, int row)
{
    m->owed[row] = m->k > 0 && !m->lasting[row];
    jet_keep(m, reg, row, m->k);
    jet_hold(m, reg, row);
    m->made[row] = ++m->clock;
}

static int register_of(const struct jet_maker *m, int row, int i) { return i == m->k ? m->held[row] : -1; }

void jet_get(struct jet_maker *m, int to, int row, int i)
{
    int r = register_of(m, row, i);
    if (r >= 0)
        jet_do(m, ACT_MOVE, to, r);
    else
        jet_at(m, ACT_LOAD, to, jet_slot(m, row, i));
}

void jet_with(struct jet_maker *m, enum jet_act_kind op, int to, int row, int i)
{
    int r = register_of(m, row, i);
    if (r >= 0)
        jet_do(m, op, to, r);
    else
        jet_at(m, op + (ACT_ADD_SLOT - ACT_ADD), to, jet_slot(m, row, i));
}

static int operand(const struct jet_maker *m, int row, int i)
{
    int r = register_of(m, row, i);
    return r >= 0 ? r - JET_REGISTERS : jet_slot(m, row, i);
}

/* a_i b_j (twice it), to be put into, added to or subtracted from `to`. */
static void product(struct jet_maker *m, enum jet_act_kind kind, int to, int a, int i, int b, int j, bool twice)
{
    jet_at(m, kind, to, operand(m, a, i));
    struct jet_act *c = m->act + m->count - 1;
    c->other = operand(m, b, j);
    c->from = (unsigned char)(4 + m->turn++ % 2);
    c->number = twice ? 2 : 1;
}

/* One product more (or the first) in `to`. */
static void term(struct jet_maker *m, int to, bool begun, int a, int i, int b, int j)
{
    product(m, begun ? ACT_ADD_PRODUCT : ACT_PRODUCT, to, a, i, b, j, false);
}

/* Products i = from .. to into a register. One of the rows' first factors is at an even slot. */
static void pairs(struct jet_maker *m, int reg, int a, int first_a, int b, int top, int from, int to)
{
    int up = jet_slot(m, a, first_a + from), down = m->reversed[b] - (top - from);
    jet_at(m, ACT_PRODUCTS, reg, up % 2 ? up : down);
    m->act[m->count - 1].other = up % 2 ? down : up;
    m->act[m->count - 1].number = (short)(to - from);
}

static void postpone(const struct jet_maker *m, struct jet_late *late, int a, int i, int b, int j)
{
    int n = late->count++, now = m->made[a] * (i == m->k), other = m->made[b] * (j == m->k);
    now = now > other ? now : other;
    if (n == 1) {
        int first = m->made[late->a[0]] * (late->i[0] == m->k), second = m->made[late->b[0]] * (late->j[0] == m->k);
        if ((first > second ? first : second) > now) {       /* the newest comes last */
            late->a[1] = late->a[0], late->i[1] = late->i[0], late->b[1] = late->b[0], late->j[1] = late->j[0];
            n = 0;
        }
    }
    late->a[n] = a, late->i[n] = i, late->b[n] = b, late->j[n] = j;
}

bool jet_sum(struct jet_maker *m, int to, int a, int first_a, int b, int first_b, int n, struct jet_late *late)
{
    int top = first_b + n - 1;                   /* coefficient top - i of b */
    int from = top - m->degree[b], end = m->degree[a] - first_a + 1;
    from = from > 0 ? from : 0;
    end = end < n ? end : n;
    late->count = 0;
    bool begun = false;
    int low = from, high = end, newest = m->k - !m->wide;      /* the products of coefficients before that */
    while (low < high && top - low >= newest)
        low++;
    while (high > low && first_a + high - 1 >= newest)
        high--;
    if (high - low >= JET_PAIRS_FROM + 1 && m->reversed[b] >= 0) {
        int odd = (first_a + low) % 2 && (m->reversed[b] - (top - low)) % 2;
        pairs(m, to, a, first_a, b, top, low + odd, high);
        begun = true;
        if (odd)
            term(m, to, begun, a, first_a + low, b, top - low);
        low = high;
    }
    for (int i = low; i < high; i++, begun = true)
        term(m, to, begun, a, first_a + i, b, top - i);
    for (int i = from; i < end; i++) {
        bool older = first_a + i < newest && top - i < newest;
        if (older)
            i = high - 1 > i ? high - 1 : i;     /* done above */
        else if (first_a + i == m->k || top - i == m->k)
            postpone(m, late, a, first_a + i, b, top - i);
        else
            term(m, to, begun, a, first_a + i, b, top - i), begun = true;
    }
    return begun;
}

bool jet_add_late(struct jet_maker *m, enum jet_act_kind op, int to, bool begun, bool twice, const struct jet_late *late)
{
    for (int q = 0; q < late->count; q++, begun = true) {
        product(m, !begun ? ACT_PRODUCT : op == ACT_ADD ? ACT_ADD_PRODUCT : ACT_SUB_PRODUCT, to, late->a[q], late->i[q], late->b[q],
                late->j[q], twice);
        if (!begun && op == ACT_SUB)
            jet_do(m, ACT_NEGATE, to, 0);
    }
    return begun;
}

bool jet_double(struct jet_maker *m, int to, bool begun, int a, int k)
{
    if (begun)
        jet_do(m, ACT_ADD, to, to);
    if (k % 2 || m->degree[a] < k / 2)
        return begun;
    term(m, to, begun, a, k / 2, a, k / 2);
    return true;
}

void jet_finish(struct jet_maker *m, int to, bool begun)
{
    if (!begun)
        jet_do(m, ACT_ZERO, to, 0);
}
