/* Shapes in all symbols at once, against those by one symbol after the other: random expressions of few symbols, so that many meet themselves, and sums of many. */
#include "arena.h"
#include "check.h"
#include "expr.h"
#include "shape.h"

enum { SYMBOLS = 4, POOL = 24 };

static unsigned long state;

static int below(int n)
{
    state = state * 6364136223846793005ul + 1442695040888963407ul;
    return (int)((state >> 33) % (unsigned long)n);
}

static expr_id grown(struct expr_store *st, expr_id a, expr_id b)
{
    switch (below(9)) {
    case 0: case 1: return expr_add(st, a, b);
    case 2: return expr_sub(st, a, b);
    case 3: return expr_mul(st, a, b);
    case 4: return expr_div(st, a, b);
    case 5: return expr_powi(st, a, 2 + below(3));
    case 6: return expr_fun(st, EXPR_SIN, a);
    case 7: return expr_fun(st, EXPR_SQRT, a);
    default: return expr_neg(st, a);
    }
}

static void one(struct expr_store *st, const expr_id *symbol)
{
    expr_id pool[POOL];
    int count = 0;
    for (int i = 0; i < SYMBOLS; i++)
        pool[count++] = symbol[i];
    pool[count++] = expr_int(st, 3);
    while (count < POOL) {
        expr_id e = grown(st, pool[below(count)], pool[below(count)]);
        pool[count++] = e ? e : symbol[0];
    }
    SGA_ENDS(expr_cone_clear) struct expr_cone c;
    expr_cone_init(&c);
    expr_cone_of(st, &c, pool + count - 1, 1);
    expr_cone_index(&c);
    unsigned char all[1000], shape[1000];
    if (c.count > 1000)
        return;
    points_shapes(st, &c, all);
    for (int k = 0; k < c.count; k++) {
        if (expr_op_of(st, c.list[k]) != EXPR_SYM)
            continue;
        enum points_shape is = points_shape_in(st, &c, st->node[c.list[k]].a, shape);
        CHECK(all[k] == is, "%d, and it is %d", all[k], is);
        CHECK(is != POINTS_FREE, "it is there");
    }
}

/* x + 2 y - x z + sin(z) / w + u (u + y). */
static void known(void)
{
    struct expr_store st;
    expr_store_init(&st);
    expr_id x = expr_symbol_add(&st, "x", EXPR_VARIABLE), y = expr_symbol_add(&st, "y", EXPR_VARIABLE), z = expr_symbol_add(&st, "z", EXPR_VARIABLE);
    expr_id w = expr_symbol_add(&st, "w", EXPR_VARIABLE), u = expr_symbol_add(&st, "u", EXPR_VARIABLE);
    expr_id e = expr_add(&st, expr_sub(&st, expr_add(&st, x, expr_mul(&st, expr_int(&st, 2), y)), expr_mul(&st, x, z)), expr_div(&st, expr_fun(&st, EXPR_SIN, z), w));
    e = expr_add(&st, e, expr_mul(&st, u, expr_add(&st, u, y)));
    SGA_ENDS(expr_cone_clear) struct expr_cone c;
    expr_cone_init(&c);
    expr_cone_of(&st, &c, &e, 1);
    expr_cone_index(&c);
    unsigned char all[100], shape[100];
    points_shapes(&st, &c, all);
    CHECK(all[c.place[x]] == POINTS_AFFINE && all[c.place[y]] == POINTS_AFFINE && all[c.place[z]] == POINTS_HIDDEN && all[c.place[w]] == POINTS_CURVED);
    CHECK(all[c.place[u]] == POINTS_CURVED && points_shape_in(&st, &c, st.node[u].a, shape) == POINTS_CURVED);
    expr_store_clear(&st);
}

/* The sum of a_i (1 + b_i) a_(i + 1) for odd i and of a_i + b_i otherwise, with more symbols than a word has bits; a_0 is in a product with itself. */
static void many(void)
{
    enum { COUNT = 150 };
    struct expr_store st;
    expr_store_init(&st);
    expr_id a[COUNT], b[COUNT], e = expr_int(&st, 0);
    char name[20];
    for (int i = 0; i < COUNT; i++) {
        a[i] = (snprintf(name, sizeof name, "a%d", i), expr_symbol_add(&st, name, EXPR_VARIABLE));
        b[i] = (snprintf(name, sizeof name, "b%d", i), expr_symbol_add(&st, name, EXPR_VARIABLE));
    }
    for (int i = 0; i < COUNT; i++)
        e = expr_add(&st, e, i % 2 ? expr_mul(&st, expr_mul(&st, a[i], expr_add(&st, b[i], expr_int(&st, 1))), a[(i + 1) % COUNT]) : expr_add(&st, a[i], b[i]));
    e = expr_add(&st, e, expr_mul(&st, expr_add(&st, a[0], b[7]), expr_add(&st, a[0], b[90])));
    SGA_ENDS(expr_cone_clear) struct expr_cone c;
    expr_cone_init(&c);
    expr_cone_of(&st, &c, &e, 1);
    expr_cone_index(&c);
    unsigned char all[4000];
    CHECK(c.count <= 4000);
    points_shapes(&st, &c, all);
    for (int i = 0; i < COUNT; i++)
        CHECK(all[c.place[a[i]]] == (i ? POINTS_AFFINE : POINTS_CURVED) && all[c.place[b[i]]] == POINTS_AFFINE, "%d", i);
    expr_store_clear(&st);
}

int main(void)
{
    state = check_seed(20261201);
    for (int round = check_scale(300); round > 0; round--) {
        struct expr_store st;
        expr_id symbol[SYMBOLS];
        expr_store_init(&st);
        for (int i = 0; i < SYMBOLS; i++)
            symbol[i] = expr_symbol_add(&st, (const char *[]){ "a", "b", "c", "d" }[i], EXPR_VARIABLE);
        one(&st, symbol);
        expr_store_clear(&st);
    }
    known();
    many();
    return CHECK_END();
}
