/* One row for each language. */
#include "dialect.h"

/* Lines of programs stay short, and what is shared gets a name at once; in print a name costs the reader more than a long line. MathML
 * takes some ten times the characters of TeX. */
enum { LONG_LINE = 90, TEX_SHARED = 300, TEX_LINE = 3000, MATHML_SHARED = 3000, MATHML_LINE = 30000 };

static const struct export_dialect dialects[EXPORT_LANGUAGES] = {
    [EXPORT_C] = { 0, "x[%d]", "p[%d]", "f[%d]", NULL, "%s[%d]", NULL, "w%d", "    const double %s = %s;\n", "    %s = %s;\n", "(", ")", 0, LONG_LINE },
    [EXPORT_PYTHON] = { 0, "x[%d]", "p[%d]", "f[%d]", NULL, "%s[%d]", NULL, "w%d", "    %s = %s\n", "    %s = %s\n", "(", ")", 0, LONG_LINE },
    [EXPORT_MATLAB] = { 1, "x(%d)", "p(%d)", "f(%d)", "P(%d)", "%s(%d)", "%s(%d, %d)", "w%d", "  %s = %s;\n", "  %s = %s;\n", "(", ")", 0, LONG_LINE },
    [EXPORT_JULIA] = { 1, "x[%d]", "p[%d]", "f[%d]", NULL, "%s[%d]", "%s[%d, %d]", "w%d", "    %s = %s\n", "    %s = %s\n", "(", ")", 0, LONG_LINE },
    [EXPORT_CASADI] = { 0, "x[%d]", "p[%d]", "f[%d]", NULL, "%s[%d]", NULL, "w%d", "    %s = %s\n", "    %s = %s\n", "(", ")", 0, LONG_LINE },
    [EXPORT_MODELICA] = { 1, "x[%d]", "p[%d]", "f[%d]", NULL, "%s[%d]", "%s[%d, %d]", "w[%d]", "    %s := %s;\n", "    %s := %s;\n", "(", ")", 0, LONG_LINE },
    [EXPORT_LATEX] = { 1, NULL, NULL, "\\mathcal{F}_{%d}", NULL, NULL, NULL, "\\mathcal{W}_{%d}", "  %s &= %s \\\\\n", "  %s &= %s \\\\\n",
                       "\\left(", "\\right)", TEX_SHARED, TEX_LINE },
    [EXPORT_MATHML] = { 1, NULL, NULL, "<msub><mi mathvariant=\"script\">F</mi><mn>%d</mn></msub>", NULL, NULL, NULL,
                        "<msub><mi mathvariant=\"script\">W</mi><mn>%d</mn></msub>",
                        "<mtr><mtd>%s</mtd><mtd><mo>=</mo></mtd><mtd>%s</mtd></mtr>\n", "<mtr><mtd>%s</mtd><mtd><mo>=</mo></mtd><mtd>%s</mtd></mtr>\n",
                        "<mrow><mo>(</mo>", "<mo>)</mo></mrow>", MATHML_SHARED, MATHML_LINE },
};

const struct export_dialect *export_dialect(enum export_language l)
{
    return &dialects[l];
}

bool export_is_print(enum export_language l)
{
    return !dialects[l].list;
}
