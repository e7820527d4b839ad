/* What is written of an answer, by format. */
#include "code_view.h"

#include <string.h>

#include "code_source.h"
#include "fmu_view.h"
#include "json_scan.h"

int code_format_find(const char *name)
{
    return strcmp(name, "fmu") == 0 ? CODE_FMU : export_language_find(name) == EXPORT_LANGUAGES ? CODE_FORMATS : (int)export_language_find(name);
}

const char *code_format_name(int format)
{
    return format == CODE_FMU ? "fmu" : export_language_name((enum export_language)format);
}

const char *code_format_type(int format)
{
    return format == CODE_FMU ? "application/zip" : export_language_type((enum export_language)format);
}

bool code_view(struct slice request, struct slice result, struct code_origin origin, int format, struct sga_buf *out, struct sga_error *err)
{
    struct code_source r;
    bool ok = code_source_read(&r, request, result, origin, err) &&
              (format == CODE_FMU ? fmu_view(&r, out, err) : export_code(&r.source, (enum export_language)format, out, err));
    code_source_end(&r);
    return ok;
}
