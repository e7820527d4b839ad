/* Start, experiment, names of inputs and outputs, out of the request and the result. */
#include "fmu_view.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "code_source.h"
#include "error.h"
#include "fmu.h"
#include "json_scan.h"
#include "zip.h"

/* A number, or a text that is one. */
static double number_of(struct code_source *r, struct slice v)
{
    const char *text = v.at ? code_source_text(r, v) : NULL;
    char *end;
    double value = text ? strtod(text, &end) : NAN;
    return text && end != text && !*end ? value : NAN;
}

/* The trajectory whose start is taken. */
static struct slice motion_of(const struct code_source *r)
{
    struct slice one = scan_member(r->result, "trajectory"), sets = scan_member(r->result, "trajectories");
    const char *cursor = NULL;
    while (!scan_member(one, "initial").at && sets.at && (one = scan_next(sets, &cursor)).at)
        ;
    return one;
}

static void read_start(struct code_source *r, struct slice motion, struct fmu_simulation *sim)
{
    struct slice start = scan_member(scan_member(motion, "initial"), "projected");
    int n = r->source.variables;
    if (!start.at)
        start = scan_member(scan_member(r->result, "consistent_initial"), "projected");
    if (!start.at)
        return;
    double *value = sga_zeros(&r->mem, (size_t)n, sizeof *value);
    for (int i = 0; i < n; i++) {
        double v = number_of(r, scan_member(start, r->source.variable[i]));
        value[i] = isnan(v) ? 0 : v;
    }
    sim->start = value;
}

static void read_arguments(struct code_source *r, struct slice motion, struct fmu_simulation *sim)
{
    const struct export_source *s = &r->source;
    struct slice given = scan_member(scan_member(r->request, "system"), "parameters"), taken = scan_member(motion, "parameters");
    double *value = sga_zeros(&r->mem, (size_t)s->parameters + 1, sizeof *value);
    int k = 0;
    for (int i = 0; i < s->parameters; i++)
        if (!s->parameter[i].value) {
            value[k] = number_of(r, scan_member(taken, s->parameter[i].name));
            if (isnan(value[k]))
                value[k] = number_of(r, scan_member(given, s->parameter[i].name));
            k++;
        }
    sim->argument = value;
}

static void read_inputs(struct code_source *r, struct fmu_simulation *sim)
{
    struct slice names = scan_member(scan_member(r->result, "vector_field"), "free");
    int n = r->source.gauges;
    bool told = code_source_count(names) == n;
    const char **name = sga_zeros(&r->mem, (size_t)n + 1, sizeof *name), *cursor = NULL;
    for (int i = 0; i < n; i++) {
        const char *said = told ? code_source_text(r, scan_next(names, &cursor)) : NULL;
        char made[24];
        snprintf(made, sizeof made, "gauge(%d)", i + 1);
        name[i] = said ? said : memcpy(sga_take(&r->mem, sizeof made), made, sizeof made);
    }
    sim->input = name;
}

/* Whether an output is a variable already, or its derivative. */
static bool known(const struct export_source *s, const char *text)
{
    size_t n = strlen(text);
    bool derivative = n > 5 && memcmp(text, "der(", 4) == 0 && text[n - 1] == ')';
    if (strcmp(text, s->time) == 0)
        return true;
    for (int i = 0; i < s->variables; i++)
        if (strcmp(text, s->variable[i]) == 0 || (derivative && strlen(s->variable[i]) == n - 5 && memcmp(text + 4, s->variable[i], n - 5) == 0))
            return true;
    for (int i = 0; i < s->outputs; i++)
        if (strcmp(text, s->output[i]) == 0)
            return true;
    for (int i = 0; i < s->parameters; i++)
        if (strcmp(text, s->parameter[i].name) == 0)
            return true;
    return false;
}

static void read_outputs(struct code_source *r)
{
    struct slice list = scan_member(scan_member(r->request, "trajectory"), "outputs"), v;
    const char *cursor = NULL;
    r->source.output = sga_zeros(&r->mem, (size_t)code_source_count(list) + 1, sizeof *r->source.output);
    while (list.at && *list.at == '[' && (v = scan_next(list, &cursor)).at) {
        const char *text = code_source_text(r, v);
        if (text && !known(&r->source, text))
            r->source.output[r->source.outputs++] = text;
    }
}

static void read_times(struct code_source *r, struct fmu_simulation *sim)
{
    struct slice t = scan_member(r->request, "trajectory"), times = scan_member(t, "times"), v;
    const char *cursor = NULL;
    sim->begin = number_of(r, scan_member(t, "start"));
    sim->stop = number_of(r, scan_member(t, "stop"));
    sim->tolerance = number_of(r, scan_member(scan_member(r->request, "accuracy"), "rtol"));
    for (int i = 0; times.at && *times.at == '[' && (v = scan_next(times, &cursor)).at; i++) {
        sim->stop = number_of(r, v);
        if (i == 0 && isnan(sim->begin))
            sim->begin = sim->stop;
    }
}

static bool pack(const struct fmu_file *file, struct sga_buf *out, struct sga_error *err)
{
    struct zip z;
    size_t before = out->len;
    bool ok = true;
    zip_begin(&z, out);
    for (int i = 0; i < FMU_FILES && ok; i++)
        ok = zip_file(&z, file[i].name, &file[i].text);
    zip_end(&z);
    if (!ok)
        out->len = before;
    return ok || sga_fail(err, SGA_E_NO_CODE, "The files of the FMU are too long for an archive.");
}

bool fmu_view(struct code_source *r, struct sga_buf *out, struct sga_error *err)
{
    struct fmu_simulation sim = { .start = NULL };
    struct fmu_file file[FMU_FILES];
    struct slice motion = motion_of(r);
    read_start(r, motion, &sim);
    read_arguments(r, motion, &sim);
    read_inputs(r, &sim);
    read_outputs(r);
    read_times(r, &sim);
    bool ok = export_fmu(&r->source, &sim, file, err) && pack(file, out, err);
    for (int i = 0; i < FMU_FILES; i++)
        sga_buf_free(&file[i].text);
    return ok;
}
