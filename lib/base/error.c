/* The error table and the one way to fill an error. */
#include "error.h"

#include <stdarg.h>
#include <stdio.h>

static const struct {
    const char *text;
    int status;
    const char *title;
} table[SGA_E_COUNT] = {
#define X(sym, text, status, title) [SGA_E_##sym] = { text, status, title },
    SGA_ERROR_TABLE(X)
#undef X
};

const char *sga_code_text(enum sga_code code)
{
    return table[code].text;
}

const char *sga_code_title(enum sga_code code)
{
    return table[code].title;
}

int sga_code_status(enum sga_code code)
{
    return table[code].status;
}

bool sga_fail(struct sga_error *err, enum sga_code code, const char *fmt, ...)
{
    if (!err || err->code != SGA_E_OK)
        return false;
    err->code = code;
    va_list ap;
    va_start(ap, fmt);
    vsnprintf(err->detail, sizeof err->detail, fmt, ap);
    va_end(ap);
    return false;
}

bool sga_fail_at(struct sga_error *err, enum sga_code code, const char *pointer,
                 const char *fmt, ...)
{
    if (!err || err->code != SGA_E_OK)
        return false;
    err->code = code;
    snprintf(err->pointer, sizeof err->pointer, "%s", pointer);
    va_list ap;
    va_start(ap, fmt);
    vsnprintf(err->detail, sizeof err->detail, fmt, ap);
    va_end(ap);
    return false;
}
