/* The languages, and one export from texts to text. */
#include "export.h"

#include "buf.h"
#include "skeleton.h"

#include <assert.h>
#include <string.h>

static const struct {
    const char *name, *type;
    bool (*write)(struct export_model *m, struct sga_buf *out, struct sga_error *err);
} languages[EXPORT_LANGUAGES] = {
    [EXPORT_C] = { "c", "text/x-c", export_c },
    [EXPORT_PYTHON] = { "python", "text/x-python", export_python },
    [EXPORT_MATLAB] = { "matlab", "text/x-matlab", export_matlab },
    [EXPORT_JULIA] = { "julia", "text/x-julia", export_julia },
    [EXPORT_CASADI] = { "casadi", "text/x-python", export_casadi },
    [EXPORT_MODELICA] = { "modelica", "text/x-modelica", export_modelica },
    [EXPORT_LATEX] = { "latex", "text/x-tex", export_latex },
    [EXPORT_MATHML] = { "mathml", "application/mathml+xml", export_mathml },
};

enum export_language export_language_find(const char *name)
{
    int l = 0;
    while (l < EXPORT_LANGUAGES && strcmp(name, languages[l].name) != 0)
        l++;
    return (enum export_language)l;
}

const char *export_language_name(enum export_language l)
{
    return languages[l].name;
}

const char *export_language_type(enum export_language l)
{
    return languages[l].type;
}

bool export_code(const struct export_source *s, enum export_language language, struct sga_buf *out, struct sga_error *err)
{
    struct export_model m;
    size_t before = out->len;
    assert(language < EXPORT_LANGUAGES);
    bool ok = export_model_read(&m, s, language, err) && languages[language].write(&m, out, err);
    if (!ok && out->data)
        out->data[out->len = before] = 0;
    export_model_clear(&m);
    return ok;
}
