/* Families: what is found, and that it is what it was once it is written out. */
#include <stdlib.h>
#include <string.h>

#include "buf.h"
#include "check.h"
#include "families.h"

static const struct families_how how = { .longest = 3, .least = 4, .letters = { "i", "j" } };
static unsigned long state;

/* Folds, and writes out again: the same text. */
static char *folded(const struct sga_buf *text, bool *is)
{
    struct sga_buf short_one = { 0 }, again = { 0 };
    sga_buf_puts(&short_one, "7,");                  /* what stands before it stays */
    sga_buf_put(&short_one, text->data, text->len);
    *is = families_fold(&short_one, 2, &how);
    CHECK(memcmp(short_one.data, "7,", 2) == 0);
    CHECK(families_expand(short_one.data + 2, short_one.len - 2, &again));
    CHECK(strcmp(again.data, text->data) == 0, "%s", again.data);
    sga_buf_free(&again);
    return sga_buf_take(&short_one);
}

static void gives(const char *from, const char *to)
{
    struct sga_buf text = { 0 };
    bool is;
    sga_buf_puts(&text, from);
    char *made = folded(&text, &is);
    CHECK(is == (strcmp(from, to) != 0));
    CHECK(strcmp(made + 2, to) == 0, "%s", made + 2);
    free(made);
    sga_buf_free(&text);
}

static void lists(void)
{
    gives("[\"x[1]\",\"x[2]\",\"x[3]\",\"x[4]\"]", "[{\"for\":\"i = 1:4\",\"count\":4,\"place\":\"i-1\",\"expression\":\"x[i]\"}]");
    gives("[\"x[1]\",\"x[2]\",\"x[3]\"]", "[\"x[1]\",\"x[2]\",\"x[3]\"]");
    /* by twos, downwards, and with what does not change */
    gives("[\"x[2] - y[9] + 3*z[5]\",\"x[4] - y[8] + 3*z[5]\",\"x[6] - y[7] + 3*z[5]\",\"x[8] - y[6] + 3*z[5]\"]",
          "[{\"for\":\"i = 1:4\",\"count\":4,\"place\":\"i-1\",\"expression\":\"x[2*i] - y[10-i] + 3*z[5]\"}]");
    /* a number in a text is the loop's name, or nothing is said */
    gives("[\"4*x[3]\",\"5*x[4]\",\"6*x[5]\",\"7*x[6]\"]", "[{\"for\":\"i = 4:7\",\"count\":4,\"place\":\"i-4\",\"expression\":\"i*x[i-1]\"}]");
    gives("[\"2*x[3]\",\"4*x[4]\",\"6*x[5]\",\"8*x[6]\"]", "[\"2*x[3]\",\"4*x[4]\",\"6*x[5]\",\"8*x[6]\"]");
    gives("[\"x1\",\"x2\",\"x3\",\"x4\"]", "[\"x1\",\"x2\",\"x3\",\"x4\"]");
    gives("[\"1.5*x\",\"2.5*x\",\"3.5*x\",\"4.5*x\"]", "[\"1.5*x\",\"2.5*x\",\"3.5*x\",\"4.5*x\"]");
    gives("[\"x[1]\",\"x[2]\",\"x[4]\",\"x[8]\",\"x[16]\"]", "[\"x[1]\",\"x[2]\",\"x[4]\",\"x[8]\",\"x[16]\"]");
    gives("[1,2,3,4,5]", "[1,2,3,4,5]");
    gives("[{\"expression\":\"x[1]\"},{\"expression\":\"x[2]\"},{\"expression\":\"x[3]\"},{\"expression\":\"x[4]\"}]",
          "[{\"expression\":\"x[1]\"},{\"expression\":\"x[2]\"},{\"expression\":\"x[3]\"},{\"expression\":\"x[4]\"}]");
}

static void objects(void)
{
    gives("[{\"g\":1,\"e\":\"x[1]\"},{\"g\":1,\"e\":\"x[2]\"},{\"g\":2,\"e\":\"y\"},{\"g\":1,\"e\":\"x[3]\"},{\"g\":1,\"e\":\"x[4]\"}]",
          "[{\"g\":1,\"e\":\"x[1]\"},{\"g\":1,\"e\":\"x[2]\"},{\"g\":2,\"e\":\"y\"},{\"g\":1,\"e\":\"x[3]\"},{\"g\":1,\"e\":\"x[4]\"}]");
    /* two that take turns: each stands where it did */
    gives("[{\"e\":\"x[1]\"},{\"e\":\"y[1]\"},{\"e\":\"x[2]\"},{\"e\":\"y[2]\"},{\"e\":\"x[3]\"},{\"e\":\"y[3]\"},{\"e\":\"x[4]\"},{\"e\":\"y[4]\"}]",
          "[{\"for\":\"i = 1:4\",\"count\":4,\"place\":\"2*i-2\",\"e\":\"x[i]\"},{\"for\":\"i = 1:4\",\"count\":4,\"place\":\"2*i-1\",\"e\":\"y[i]\"}]");
    gives("[{\"tangency_of\":5,\"f\":\"1\"},{\"tangency_of\":6,\"f\":\"1\"},{\"tangency_of\":7,\"f\":\"1\"},{\"tangency_of\":8,\"f\":\"1\"}]",
          "[{\"for\":\"i = 1:4\",\"count\":4,\"place\":\"i-1\",\"tangency_of\":\"constraints[i+4]\",\"f\":\"1\"}]");
}

/* Members of an object: the name has the loop; their order is not kept. */
static void members(const char *from, const char *to, const char *again)
{
    struct sga_buf text = { 0 }, whole = { 0 };
    sga_buf_puts(&text, from);
    families_fold(&text, 0, &how);
    CHECK(strcmp(text.data, to) == 0, "%s", text.data);
    CHECK(families_expand(text.data, text.len, &whole) && strcmp(whole.data, again) == 0, "%s", whole.data);
    sga_buf_free(&text);
    sga_buf_free(&whole);
}

static void named(void)
{
    members("{\"x[1]'\":\"x[1]\",\"x[2]'\":\"x[2]\",\"y\":\"0\",\"x[3]'\":\"x[3]\",\"x[4]'\":\"x[4]\"}",
            "{\"x[i = 1:4]'\":\"x[i]\",\"y\":\"0\"}", "{\"x[1]'\":\"x[1]\",\"x[2]'\":\"x[2]\",\"x[3]'\":\"x[3]\",\"x[4]'\":\"x[4]\",\"y\":\"0\"}");
    /* a name by steps of two is no range */
    const char *twos = "{\"x[1]\":\"0\",\"x[3]\":\"0\",\"x[5]\":\"0\",\"x[7]\":\"0\"}";
    members(twos, twos, twos);
    members("{\"u[1,1]\":\"v[1]\",\"u[1,2]\":\"v[2]\",\"u[1,3]\":\"v[3]\",\"u[1,4]\":\"v[4]\"}", "{\"u[1,i = 1:4]\":\"v[i]\"}",
            "{\"u[1,1]\":\"v[1]\",\"u[1,2]\":\"v[2]\",\"u[1,3]\":\"v[3]\",\"u[1,4]\":\"v[4]\"}");
}

static unsigned draw(unsigned n)
{
    state = state * 6364136223846793005u + 1442695040888963407u;
    return (unsigned)(state >> 33) % n;
}

/* A grid with borders of their own, by rows or by columns, with others strewn in: all of it comes back, and its inside is one entry. */
static void grid(int rows, int columns, bool strewn)
{
    struct sga_buf text = { 0 };
    bool is;
    for (int r = 0; r < rows; r++)
        for (int c = 0; c < columns; c++) {
            bool border = r == 0 || c == 0 || r == rows - 1 || c == columns - 1;
            sga_buf_printf(&text, "%s{\"g\":%d,\"e\":\"", text.len ? "," : "[", strewn && draw(9) == 0 ? 2 : 1);
            sga_buf_printf(&text, border ? "u[%d,%d]" : "u[%d,%d] - 4*w[%d]", r, c, 2 * r + 3 * c);
            sga_buf_puts(&text, "\"}");
        }
    sga_buf_puts(&text, "]");
    char *made = folded(&text, &is);
    const char *inside = strstr(made, "u[i,j] - 4*w[2*i+3*j]");
    CHECK(strewn || (is && inside && !strstr(inside + 10, "- 4*w[")), "%d %d %s", rows, columns, made);
    int entries = 0;
    for (const char *s = made; (s = strstr(s, "\"g\"")); s++)
        entries++;
    CHECK(strewn || entries == 5, "%d %d %s", rows, columns, made);      /* and each side is one */
    free(made);
    sga_buf_free(&text);
}

static void texts_of_others(void)
{
    static const char *const wrong[] = {
        "[{\"for\":\"i = 1:4\",\"count\":5,\"place\":\"i-1\",\"expression\":\"x[i]\"}]", "[{\"for\":\"i = 1:4\",\"count\":4,\"place\":\"i\",\"expression\":\"x[i]\"}]",
        "[{\"for\":\"i = 1:4\",\"count\":4,\"place\":\"1\",\"expression\":\"x[i]\"}]", "[{\"for\":\"i\",\"count\":4,\"place\":\"i-1\",\"expression\":\"x[i]\"}]",
        "[{\"for\":\"i = 1:999999999\",\"count\":999999999,\"place\":\"i-1\",\"expression\":\"x[i]\"}]", "{\"x[i = 1:4,\":\"0\"}", "[[\"x\"", "]" };
    for (size_t i = 0; i < sizeof wrong / sizeof *wrong; i++) {
        struct sga_buf out = { 0 };
        CHECK(!families_expand(wrong[i], strlen(wrong[i]), &out), "%s", wrong[i]);
        sga_buf_free(&out);
    }
}

int main(void)
{
    state = check_seed(20261125);
    lists();
    objects();
    named();
    for (int n = 6; n < 12; n++)
        grid(n, 17 - n, false);
    for (int k = 0; k < check_scale(200); k++)
        grid(3 + (int)draw(20), 3 + (int)draw(20), true);
    texts_of_others();
    return CHECK_END();
}
