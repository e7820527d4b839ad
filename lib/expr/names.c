/* Texts with named subexpressions: what is shared and large is written once. */
#include "print.h"

#include <stdlib.h>
#include <string.h>

#include "arena.h"
#include "buf.h"
#include "error.h"
#include "mem.h"
#include "names_solve.h"
#include "print_text.h"

struct naming {
    struct expr_store *st;
    const struct expr_naming *how;
    struct expr_cone cone;
    expr_id *root;
    int roots;
    char **name;           /* by node; owned by the result once it is given out */
    size_t bytes;          /* of all texts so far */
    size_t max_bytes;
};

/* Marks (name = "") the nodes that get names. A named node counts as one in the trees
 * above it, so no text is much longer than what it adds. */
static int mark(struct naming *n)
{
    const struct expr_store *st = n->st;
    int inline_nodes = n->how && n->how->inline_nodes ? n->how->inline_nodes : 8, count = 0;
    SGA_ARENA(mem);
    int *uses = sga_zeros(&mem, (size_t)st->nodes, sizeof *uses), *size = sga_zeros(&mem, (size_t)st->nodes, sizeof *size);
    for (int i = 0; i < n->cone.count; i++)
        for (int k = 0, m = expr_children(st, n->cone.list[i]); k < m; k++)
            uses[expr_child(st, n->cone.list[i], k)]++;
    for (int i = 0; i < n->roots; i++)
        uses[n->root[i]]++;
    for (int i = 0; i < n->cone.count; i++) {
        expr_id e = n->cone.list[i];
        long total = 1;
        for (int k = 0, m = expr_children(st, e); k < m; k++) {
            expr_id c = expr_child(st, e, k);
            total += n->name[c] ? 1 : size[c];
        }
        size[e] = total < 1 << 30 ? (int)total : 1 << 30;
        if (uses[e] > 1 && size[e] > inline_nodes) {
            n->name[e] = sga_strdup("");
            count++;
        }
    }
    return count;
}

/* The number of a symbol that looks like prefix + number, or 0. */
static long number_of(const char *symbol, const char *prefix)
{
    size_t n = strlen(prefix);
    if (strncmp(symbol, prefix, n) != 0 || symbol[n] < '1' || symbol[n] > '9')
        return 0;
    char *end;
    long v = strtol(symbol + n, &end, 10);
    return *end ? 0 : v;
}

/* Gives the marked nodes their names, in the order of definition. */
static void number(struct naming *n, int count)
{
    const char *prefix = n->how && n->how->prefix ? n->how->prefix : "s";
    long last = (long)count + n->st->symbols, next = 1;
    SGA_FREED unsigned char *taken = sga_calloc((size_t)last + 2, 1);
    for (int i = 0; i < n->st->symbols; i++) {
        long v = number_of(n->st->symbol[i].name, prefix);
        if (v <= last)
            taken[v] = 1;
    }
    struct sga_buf text = { 0 };
    for (int i = 0; i < n->cone.count; i++) {
        expr_id e = n->cone.list[i];
        if (!n->name[e])
            continue;
        while (taken[next])
            next++;
        sga_buf_printf(&text, "%s%ld", prefix, next++);
        free(n->name[e]);
        n->name[e] = sga_buf_take(&text);
    }
}

static bool write_text(struct naming *n, expr_id e, char **out)
{
    struct print_request r = { .st = n->st, .name = (const char *const *)n->name, .limit = n->max_bytes - n->bytes };
    struct sga_buf text = { 0 };
    bool ok = print_tree(&r, e, &text);
    n->bytes += text.len;
    *out = sga_buf_take(&text);
    return ok;
}

static bool write_all(struct naming *n, struct expr_names *out)
{
    bool ok = true;
    for (int i = 0; ok && i < n->cone.count; i++) {
        expr_id e = n->cone.list[i];
        if (!n->name[e])
            continue;
        ok = write_text(n, e, &out->text[out->count]);
        out->name[out->count++] = sga_strdup(n->name[e]);
    }
    for (int i = 0; ok && i < n->roots; i++) {
        expr_id e = n->root[i];
        if (n->name[e])
            out->root[i] = sga_strdup(n->name[e]);
        else
            ok = write_text(n, e, &out->root[i]);
        out->roots = i + 1;
    }
    return ok;
}

bool expr_print_named(struct expr_store *st, const expr_id *roots, int nroots,
                      const struct expr_naming *naming, struct expr_names *out)
{
    struct naming n = { .st = st, .how = naming, .roots = nroots };
    struct sga_error before = *st->error;
    n.max_bytes = naming && naming->max_bytes ? naming->max_bytes : (size_t)16 << 20;
    n.root = sga_malloc(((size_t)nroots + 1) * sizeof *n.root);
    memcpy(n.root, roots, (size_t)nroots * sizeof *n.root);
    *out = (struct expr_names){ 0 };
    bool ok = expr_write_out_solves(st, n.root, nroots);
    *st->error = before;
    if (ok) {
        expr_cone_init(&n.cone);
        expr_cone_of(st, &n.cone, n.root, nroots);
        n.name = sga_calloc((size_t)st->nodes, sizeof *n.name);
        int count = mark(&n);
        number(&n, count);
        out->name = sga_calloc((size_t)count + 1, sizeof *out->name);
        out->text = sga_calloc((size_t)count + 1, sizeof *out->text);
        out->root = sga_calloc((size_t)nroots + 1, sizeof *out->root);
        ok = write_all(&n, out);
        for (int i = 0; i < n.cone.count; i++)
            free(n.name[n.cone.list[i]]);
        free(n.name);
        expr_cone_clear(&n.cone);
        if (!ok)
            expr_names_clear(out);
    }
    free(n.root);
    return ok;
}

void expr_names_clear(struct expr_names *n)
{
    for (int i = 0; i < n->count; i++) {
        free(n->name[i]);
        free(n->text[i]);
    }
    for (int i = 0; i < n->roots; i++)
        free(n->root[i]);
    free(n->name);
    free(n->text);
    free(n->root);
    *n = (struct expr_names){ 0 };
}
