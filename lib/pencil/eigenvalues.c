/* All eigenvalues with as many digits as are asked, and as it takes to tell them apart. */
#include <assert.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "arena.h"
#include "budget.h"
#include "mem.h"
#include "pencil.h"
#include "roots.h"

static int by_value(const void *x, const void *y)
{
    const struct root *a = x, *b = y;
    int c = arf_cmp(arb_midref(acb_realref(&a->value)), arb_midref(acb_realref(&b->value)));
    return c ? c : arf_cmp(arb_midref(acb_imagref(&a->value)), arb_midref(acb_imagref(&b->value)));
}

void pencil_eigenvalues_clear(struct pencil_eigenvalue *e, int count)
{
    for (int i = 0; i < count; i++) {
        free(e[i].re);
        free(e[i].im);
    }
    free(e);
}

static int by_text(const void *x, const void *y)
{
    const struct pencil_eigenvalue *a = *(const struct pencil_eigenvalue *const *)x;
    const struct pencil_eigenvalue *b = *(const struct pencil_eigenvalue *const *)y;
    int c = strcmp(a->re, b->re);
    return c ? c : strcmp(a->im, b->im);
}

static bool all_differ(const struct pencil_eigenvalue *e, int n)
{
    SGA_FREED const struct pencil_eigenvalue **sorted = sga_malloc((size_t)(n + 1) * sizeof *sorted);
    bool differ = true;
    for (int i = 0; i < n; i++)
        sorted[i] = e + i;
    qsort(sorted, (size_t)n, sizeof *sorted, by_text);
    for (int i = 0; i + 1 < n; i++)
        differ = differ && by_text(sorted + i, sorted + i + 1) != 0;
    return differ;
}

/* The texts at these digits, or NULL where some ball is too wide. */
static struct pencil_eigenvalue *texts(const struct root_list *l, slong digits, slong precision)
{
    struct pencil_eigenvalue *e = sga_calloc((size_t)l->count + 1, sizeof *e);
    bool ok = true;
    for (int i = 0; i < l->count && ok; i++) {
        e[i].factor = l->root[i].factor;
        e[i].re = root_text(acb_realref(&l->root[i].value), digits, precision);
        e[i].im = root_text(acb_imagref(&l->root[i].value), digits, precision);
        ok = e[i].re && e[i].im;
    }
    if (ok)
        return e;
    pencil_eigenvalues_clear(e, l->count);
    return NULL;
}

bool pencil_eigenvalues(const struct pencil_structure *s, double rtol, const struct sga_budget *budget,
                        struct pencil_eigenvalue **out, int *count, struct sga_error *err)
{
    assert(rtol > 0);
    slong digits = rtol >= 1e-15 ? 0 : (slong)ceil(-log10(rtol)) + 1;
    slong precision = digits ? (slong)((double)digits * 3.4) + 64 : 128;
    for (;;) {
        SGA_ENDS(root_list_clear) struct root_list l = { .count = 0 };
        struct pencil_eigenvalue *e;
        for (int i = 0; i < s->factors; i++) {
            if (budget && !sga_budget_ok(budget, err))
                return false;
            root_list_of(&l, s->factor[i].f, i, precision);
        }
        if (l.count)
            qsort(l.root, (size_t)l.count, sizeof *l.root, by_value);
        e = texts(&l, digits, precision);
        *count = l.count;
        assert(*count >= s->factors);
        if (e && (!*count || all_differ(e, *count))) {
            *out = e;
            return true;
        }
        if (e) {                       /* two look equal: more digits */
            pencil_eigenvalues_clear(e, *count);
            digits = digits ? digits * 2 : 34;
            precision = (slong)((double)digits * 3.4) + 64;
        } else {
            precision *= 2;
        }
    }
}
