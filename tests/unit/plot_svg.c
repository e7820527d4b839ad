/* The image of curves: the same twice, whole for any input, texts escaped, axes that hold the points. */
#include <math.h>
#include <string.h>

#include "buf.h"
#include "check.h"
#include "plot.h"
#include "plot_text.h"

static int count(const char *text, const char *what)
{
    int n = 0;
    for (const char *p = text; (p = strstr(p, what)); p += strlen(what))
        n++;
    return n;
}

static void draw(const struct plot *p, struct sga_buf *out)
{
    struct sga_buf again = { 0 };
    plot_svg(p, out);
    plot_svg(p, &again);
    CHECK(again.len == out->len && memcmp(again.data, out->data, out->len) == 0);
    CHECK(strncmp(out->data, "<?xml", 5) == 0 && strcmp(out->data + out->len - 7, "</svg>\n") == 0);
    CHECK(!strstr(out->data, "nan") && !strstr(out->data, "inf"));
    sga_buf_free(&again);
}

static void points_and_marks(void)
{
    struct plot_point a[] = { { 1e-3, 1e-4, false }, { 1e-6, 2e-4, false }, { 1e-9, 1e-3, true } };
    struct plot_point b[] = { { 0, 1, false }, { NAN, 1, false }, { 1e-2, INFINITY, false }, { -1, 1, false } };
    struct plot_curve c[] = { { "one", a, 3 }, { "nothing to show", b, 4 } };
    struct sga_buf out = { 0 };
    draw(&(struct plot){ .title = "t", .x_label = "x", .y_label = "y", .bound_label = "at most", .curve = c, .curves = 2 }, &out);
    CHECK(count(out.data, "<polyline") == 1);
    CHECK(count(out.data, "<circle") == 3 + 1 + 1, "%d", count(out.data, "<circle"));      /* points, legend, what hollow means */
    CHECK(count(out.data, "fill=\"#ffffff\" stroke") == 2);
    CHECK(strstr(out.data, "points=\"548.0,398.0 313.0,292.6 78.0,48.0\"") != NULL, "%s", strstr(out.data, "points="));
    CHECK(strstr(out.data, ">nothing to show<") != NULL);
    sga_buf_free(&out);
}

static void many_and_none(void)
{
    struct plot_point a = { 1, 1, false };
    struct plot_curve c[30];
    struct sga_buf out = { 0 };
    for (int k = 0; k < 30; k++)
        c[k] = (struct plot_curve){ "c", &a, 1 };
    draw(&(struct plot){ .title = "", .x_label = "", .y_label = "", .curve = c, .curves = 30 }, &out);
    CHECK(count(out.data, ">c</text>") == 30);
    CHECK(strstr(out.data, "height=\"672\"") != NULL);     /* the legend needs room */
    sga_buf_clear(&out);
    draw(&(struct plot){ .title = "", .x_label = "", .y_label = "", .curve = c, .curves = 0 }, &out);
    CHECK(count(out.data, "<polyline") == 0);
    struct plot_point far[] = { { 1e-300, 5e-324, false }, { 1e300, 1e308, false } };
    struct plot_curve wide = { "wide", far, 2 };
    sga_buf_clear(&out);
    draw(&(struct plot){ .title = "", .x_label = "", .y_label = "", .curve = &wide, .curves = 1 }, &out);
    CHECK(count(out.data, "<tspan") <= 22, "%d", count(out.data, "<tspan"));
    sga_buf_free(&out);
}

static void escapes(void)
{
    static const struct { const char *text, *should; } known[] = {
        { "a<b>&\"c\"", "a&lt;b&gt;&amp;&quot;c&quot;" }, { "\x01\x1f\tx\x7f", "\tx\x7f" }, { "\xc3\xa9", "\xc3\xa9" },
        { "\xc0\xaf\xff", "" }, { "\xed\xa0\x80z", "z" }, { "\xe2\x82", "" }, { "\xf0\x9f\x98\x80", "\xf0\x9f\x98\x80" },
        { "\xf4\x90\x80\x80", "" }, { "\xef\xbf\xbf", "" }, { "]]>", "]]&gt;" }, { "", "" },
    };
    for (size_t i = 0; i < sizeof known / sizeof *known; i++) {
        struct sga_buf out = { 0 };
        plot_escape(known[i].text, &out);
        CHECK(strcmp(out.data ? out.data : "", known[i].should) == 0, "%zu: %s", i, out.data);
        sga_buf_free(&out);
    }
}

int main(void)
{
    points_and_marks();
    many_and_none();
    escapes();
    return CHECK_END();
}
