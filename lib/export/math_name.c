/* A name is taken apart into a word, an index and primes, and put together in the language. */
#include "math_name.h"

#include <stdio.h>
#include <string.h>

#include "arena.h"
#include "buf.h"

/* Names in TeX with their letters; those that look like a Latin one stay words. */
static const struct {
    const char *name;
    int letter;
} greek[] = {
    { "alpha", 0x3B1 }, { "beta", 0x3B2 }, { "gamma", 0x3B3 }, { "delta", 0x3B4 }, { "epsilon", 0x3B5 }, { "zeta", 0x3B6 }, { "eta", 0x3B7 },
    { "theta", 0x3B8 }, { "iota", 0x3B9 }, { "kappa", 0x3BA }, { "lambda", 0x3BB }, { "mu", 0x3BC }, { "nu", 0x3BD }, { "xi", 0x3BE },
    { "rho", 0x3C1 }, { "sigma", 0x3C3 }, { "tau", 0x3C4 }, { "upsilon", 0x3C5 }, { "phi", 0x3C6 }, { "chi", 0x3C7 }, { "psi", 0x3C8 },
    { "omega", 0x3C9 }, { "Gamma", 0x393 }, { "Delta", 0x394 }, { "Theta", 0x398 }, { "Lambda", 0x39B }, { "Xi", 0x39E }, { "Pi", 0x3A0 },
    { "Sigma", 0x3A3 }, { "Upsilon", 0x3A5 }, { "Phi", 0x3A6 }, { "Psi", 0x3A8 }, { "Omega", 0x3A9 },
};

struct parts {
    char *word;
    char *index;              /* digits, or "" */
    int primes;
};

static struct parts take_apart(struct sga_arena *mem, const char *name, bool index)
{
    size_t n = strcspn(name, "'"), all = n, open = strcspn(name, "[");
    int primes = (int)(strlen(name) - n);
    if (index && open > 0 && open + 2 < n) {          /* x[2,13]: both are indices */
        struct parts p = { sga_zeros(mem, all + 1, 1), sga_zeros(mem, all + 1, 1), primes };
        memcpy(p.word, name, open);
        memcpy(p.index, name + open + 1, n - open - 2);
        return p;
    }
    while (index && n > 0 && name[n - 1] >= '0' && name[n - 1] <= '9')
        n--;
    size_t word = n && n < all && name[n - 1] == '_' ? n - 1 : n;
    if (word == 0)
        word = n = all;
    struct parts p = { sga_zeros(mem, all + 1, 1), sga_zeros(mem, all + 1, 1), primes };
    memcpy(p.word, name, word);
    memcpy(p.index, name + n, all - n);
    return p;
}

static int greek_place(const char *word)
{
    int n = (int)(sizeof greek / sizeof *greek);
    for (int i = 0; i < n; i++)
        if (!strcmp(greek[i].name, word))
            return i;
    return -1;
}

/* Signs that TeX has a use for get a backslash; the grammar's names have _ alone, others may come from elsewhere. */
static void put_word(enum export_language l, const char *word, struct sga_buf *b)
{
    for (; *word; word++) {
        if (l == EXPORT_LATEX && strchr("_#$%&{}", *word))
            sga_buf_puts(b, "\\");
        if (l == EXPORT_MATHML && strchr("<>&", *word))
            sga_buf_printf(b, "&#%d;", *word);
        else
            sga_buf_put(b, word, 1);
    }
}

static void put_base(enum export_language l, const char *word, struct sga_buf *b)
{
    int letter = greek_place(word);
    if (l == EXPORT_MATHML) {
        sga_buf_puts(b, "<mi>");
        if (letter >= 0)
            sga_buf_printf(b, "&#x%X;", (unsigned)greek[letter].letter);
        else
            put_word(l, word, b);
        sga_buf_puts(b, "</mi>");
    } else if (letter >= 0) {
        sga_buf_printf(b, "\\%s", word);
    } else {
        sga_buf_puts(b, word[1] ? "\\mathrm{" : "");
        put_word(l, word, b);
        sga_buf_puts(b, word[1] ? "}" : "");
    }
}

static void put_latex(const struct parts *p, struct sga_buf *b)
{
    put_base(EXPORT_LATEX, p->word, b);
    if (*p->index)
        sga_buf_printf(b, "_{%s}", p->index);
    for (int i = 0; i < p->primes; i++)
        sga_buf_puts(b, "'");
}

static void put_mathml(const struct parts *p, struct sga_buf *b)
{
    sga_buf_puts(b, p->primes ? "<msup>" : "");
    sga_buf_puts(b, *p->index ? "<msub>" : "");
    put_base(EXPORT_MATHML, p->word, b);
    if (*p->index)
        sga_buf_printf(b, "<mn>%s</mn></msub>", p->index);
    sga_buf_puts(b, p->primes ? "<mo>" : "");
    for (int i = 0; i < p->primes; i++)
        sga_buf_puts(b, "&#x2032;");
    sga_buf_puts(b, p->primes ? "</mo></msup>" : "");
}

static const char *put_together(struct sga_arena *mem, enum export_language l, const struct parts *p)
{
    struct sga_buf b = { 0 };
    (l == EXPORT_LATEX ? put_latex : put_mathml)(p, &b);
    char *text = sga_take(mem, b.len + 1);
    memcpy(text, b.data, b.len + 1);
    sga_buf_free(&b);
    return text;
}

static bool is_taken(const char *const *taken, int count, const char *text)
{
    for (int i = 0; i < count; i++)
        if (taken[i] && !strcmp(taken[i], text))
            return true;
    return false;
}

const char *math_name(struct sga_arena *mem, enum export_language l, const char *const *taken, int count, const char *name)
{
    struct parts p = take_apart(mem, name, true);
    const char *text = put_together(mem, l, &p);
    if (!is_taken(taken, count, text))
        return text;
    p = take_apart(mem, name, false);
    return put_together(mem, l, &p);
}
