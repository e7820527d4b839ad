/* The list of warnings and the two tables behind it. */
#include "warnings.h"

#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "budget.h"
#include "buf.h"
#include "error.h"
#include "mem.h"

static const char *const code[SGA_WARNINGS] = {
#define X(symbol, text, says) [SGA_W_##symbol] = text,
#include "warning.def"
#undef X
};

static const struct { const char *name; long value; enum sga_warning warning; const char *what; } limits[SGA_LIMITS] = {
#define X(symbol, most, kind, cuts, why) [SGA_LIMIT_##symbol] = { #symbol, (most), SGA_W_##kind, cuts },
#include "limits.def"
#undef X
};

const char *sga_warning_code(enum sga_warning kind)
{
    return code[kind];
}

const char *sga_limit_name(enum sga_limit limit)
{
    return limits[limit].name;
}

void sga_warnings_clear(struct sga_warnings *w)
{
    for (int i = 0; i < w->count; i++) {
        free(w->list[i].pointer);
        free(w->list[i].detail);
    }
    free(w->list);
    *w = (struct sga_warnings){ 0 };
}

static bool stands(const struct sga_warnings *w, enum sga_warning kind, const char *pointer, const char *detail)
{
    for (int i = 0; i < w->count; i++)
        if (w->list[i].kind == kind && strcmp(w->list[i].pointer, pointer) == 0 && strcmp(w->list[i].detail, detail) == 0)
            return true;
    return false;
}

void sga_warn(const struct sga_budget *b, enum sga_warning kind, const char *pointer, const char *fmt, ...)
{
    char detail[1024];
    va_list ap;
    if (!b || !b->warnings)
        return;
    va_start(ap, fmt);
    vsnprintf(detail, sizeof detail, fmt, ap);
    va_end(ap);
    struct sga_warnings *w = b->warnings;
    if (stands(w, kind, pointer, detail))
        return;
    SGA_RESERVE(w->list, w->cap, w->count + 1);
    w->list[w->count++] = (struct sga_warned){ kind, sga_strdup(pointer), sga_strdup(detail) };
}

void sga_limit_met(const struct sga_budget *b, enum sga_limit limit)
{
    sga_warn(b, limits[limit].warning, "", "%s (limit %s: %ld)", limits[limit].what, limits[limit].name, limits[limit].value);
}

void sga_limit_open(const struct sga_budget *b, enum sga_limit limit)
{
    if (b && b->warnings)
        b->warnings->open[limit] = true;
}

static void add_text(struct sga_error *err, const char *before, const char *text)
{
    size_t used = strlen(err->detail), more = strlen(before) + strlen(text);
    if (used + more < sizeof err->detail)
        sprintf(err->detail + used, "%s%s", before, text);
}

void sga_limits_explain(const struct sga_warnings *w, struct sga_error *err)
{
    int said = 0;
    for (int i = 0; i < w->count; i++)
        if (w->list[i].kind == SGA_W_SEARCH_CUT)
            add_text(err, said++ ? "; " : ". Limits were met: ", w->list[i].detail);
    for (int k = 0; k < SGA_LIMITS; k++) {
        char text[400];
        if (!w->open[k])
            continue;
        snprintf(text, sizeof text, "%s (limit %s: %ld)", limits[k].what, limits[k].name, limits[k].value);
        add_text(err, said++ ? "; " : ". Limits were met: ", text);
    }
}

static int by_table(const void *a, const void *b)
{
    const struct sga_warned *x = a, *y = b;
    int order = strcmp(x->pointer, y->pointer);
    if (x->kind != y->kind)
        return x->kind < y->kind ? -1 : 1;
    return order ? order : strcmp(x->detail, y->detail);
}

void sga_warnings_write(const struct sga_warnings *w, struct sga_json *json)
{
    if (w->count)
        qsort(w->list, (size_t)w->count, sizeof *w->list, by_table);
    sga_json_array(json);
    for (int i = 0; i < w->count; i++) {
        sga_json_object(json);
        sga_json_member_string(json, "code", code[w->list[i].kind]);
        sga_json_member_string(json, "pointer", w->list[i].pointer);
        sga_json_member_string(json, "detail", w->list[i].detail);
        sga_json_end_object(json);
    }
    sga_json_end_array(json);
}
