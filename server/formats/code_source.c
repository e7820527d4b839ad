/* JSON to the texts of an export. Names and expressions are ASCII without escapes in what we write; a text with an escape is refused by
 * the reader of expressions. */
#include "code_source.h"

#include <assert.h>
#include <string.h>

#include "buf.h"
#include "error.h"
#include "families.h"
#include "json_scan.h"

int code_source_count(struct slice array)
{
    const char *cursor = NULL;
    int n = 0;
    while (scan_next(array, &cursor).at)
        n++;
    return n;
}

const char *code_source_text(struct code_source *r, struct slice v)
{
    if (!v.at || *v.at == 'n')
        return NULL;
    const char *from = v.at;
    if (*from == '"') {
        from++;
        v.len -= 2;
    }
    char *text = sga_take(&r->mem, v.len + 1);
    assert(text);
    memcpy(text, from, v.len);
    text[v.len] = 0;
    return text;
}

static bool lacks(struct code_source *r, const char *what)
{
    return sga_fail(r->err, SGA_E_NO_CODE, "The answer lacks %s, which an export needs.", what);
}

/* A member of the answer with its families written out; what is none is as it is. */
static struct slice whole(struct code_source *r, const char *member)
{
    struct slice v = scan_member(r->result, member);
    struct sga_buf all = { 0 };
    if (!v.at || (*v.at != '[' && *v.at != '{'))
        return v;
    bool ok = families_expand(v.at, v.len, &all);
    size_t length = all.len;
    char *text = sga_keep(&r->mem, sga_buf_take(&all));
    return ok ? (struct slice){ text, length } : v;
}

static bool read_variables(struct code_source *r)
{
    struct slice list = whole(r, "variables"), v;
    const char *cursor = NULL;
    struct export_source *s = &r->source;
    s->variable = sga_zeros(&r->mem, (size_t)code_source_count(list), sizeof *s->variable);
    while ((v = scan_next(list, &cursor)).at)
        if (!(s->variable[s->variables++] = code_source_text(r, scan_member(v, "name"))))
            return lacks(r, "the name of a variable");
    return s->variables > 0 || lacks(r, "its variables");
}

static bool read_definitions(struct code_source *r)
{
    struct slice list = scan_member(r->result, "definitions"), v;
    const char *cursor = NULL;
    struct export_source *s = &r->source;
    s->definition = sga_zeros(&r->mem, (size_t)code_source_count(list), sizeof *s->definition);
    while ((v = scan_next(list, &cursor)).at) {
        struct export_definition d = { code_source_text(r, scan_member(v, "name")), code_source_text(r, scan_member(v, "expression")) };
        s->definition[s->definitions++] = d;
        if (!d.name || !d.text)
            return lacks(r, "the text of a definition");
    }
    return true;
}

static bool read_constraints(struct code_source *r)
{
    struct slice list = whole(r, "constraints"), v;
    const char *cursor = NULL;
    struct export_source *s = &r->source;
    s->constraint = sga_zeros(&r->mem, (size_t)code_source_count(list), sizeof *s->constraint);
    while ((v = scan_next(list, &cursor)).at) {
        struct export_constraint c = { (int)scan_number(scan_member(v, "generation"), 0), code_source_text(r, scan_member(v, "expression")) };
        s->constraint[s->constraints++] = c;
        if (!c.text)
            return lacks(r, "the text of a constraint (it was too long to be written)");
    }
    return list.at || lacks(r, "`constraints`: ask for them in `want`");
}

/* Members of a field that are not there are 0. */
static bool read_components(struct code_source *r, struct slice field, const char **out)
{
    const struct export_source *s = &r->source;
    for (int i = 0; i < s->variables; i++) {
        struct slice v = scan_member(field, s->variable[i]);
        out[i] = v.at ? code_source_text(r, v) : "0";
        if (!out[i])
            return lacks(r, "a component of a field (it was too long to be written)");
    }
    return true;
}

static bool read_field(struct code_source *r)
{
    struct export_source *s = &r->source;
    struct slice gauge = whole(r, "gauge"), fields = scan_member(gauge, "fields"), v;
    struct slice components = scan_member(whole(r, "vector_field"), "components");
    const char *cursor = NULL;
    int rows = code_source_count(fields);
    if (!components.at || *components.at != '{')
        return lacks(r, "`vector_field`: ask for it in `want`, or there is no motion");
    if (!gauge.at || *gauge.at != '{' || scan_number(scan_member(gauge, "dimension"), -1) != rows)
        return lacks(r, "`gauge`: ask for it in `want`");
    s->component = sga_zeros(&r->mem, (size_t)s->variables, sizeof *s->component);
    s->gauge = sga_zeros(&r->mem, (size_t)rows * (size_t)s->variables, sizeof *s->gauge);
    while ((v = scan_next(fields, &cursor)).at)
        if (!read_components(r, v, s->gauge + s->gauges++ * s->variables))
            return false;
    return read_components(r, components, s->component);
}

/* Where the next member's key begins, with its value; a key without `at` ends the walk. */
static struct slice next_member(struct slice object, const char **cursor, struct slice *value)
{
    const char *end = object.at + object.len, *p = *cursor ? *cursor : object.at + 1;
    while (p < end && strchr(" \t\r\n,", *p))
        p++;
    struct slice key = p < end && *p == '"' ? scan_value(p, end) : (struct slice){ NULL, 0 };
    if (!key.at)
        return key;
    p = key.at + key.len;
    while (p < end && strchr(" \t\r\n:", *p))
        p++;
    *value = scan_value(p, end);
    *cursor = value->at ? value->at + value->len : end;
    return key;
}

static bool swept(struct slice request, const char *name)
{
    struct slice sets = scan_member(request, "sweep"), v;
    const char *cursor = NULL;
    while ((v = scan_next(sets, &cursor)).at)
        if (scan_member(scan_member(v, "parameters"), name).at)
            return true;
    return false;
}

static bool read_parameters(struct code_source *r, struct slice request)
{
    struct slice list = scan_member(scan_member(request, "system"), "parameters"), key, value = { NULL, 0 };
    struct export_source *s = &r->source;
    const char *cursor = NULL;
    size_t room = 0;
    if (!list.at || *list.at != '{')
        return true;
    while ((key = next_member(list, &cursor, &value)).at && value.at) {
        const char *name = code_source_text(r, key);
        SGA_RESERVE_IN(&r->mem, s->parameter, room, (size_t)s->parameters + 1);
        s->parameter[s->parameters++] = (struct export_parameter){ name, swept(request, name) ? NULL : code_source_text(r, value) };
    }
    return true;
}

/* Some event of the request has "set", or its system has modes. */
static bool sets_variables(const struct code_source *r)
{
    struct slice list = scan_member(scan_member(r->request, "trajectory"), "events"), v;
    const char *cursor = NULL;
    bool sets = scan_member(scan_member(r->request, "system"), "modes").at != NULL;
    while (list.at && *list.at == '[' && (v = scan_next(list, &cursor)).at)
        sets |= scan_member(v, "set").at != NULL;
    return sets;
}

bool code_source_read(struct code_source *r, struct slice request, struct slice result, struct code_origin origin, struct sga_error *err)
{
    *r = (struct code_source){ .request = request, .result = result, .err = err, .source = { .job = origin.job, .version = origin.version } };
    const char *time = code_source_text(r, scan_member(scan_member(request, "system"), "time"));
    struct slice tables = scan_member(result, "tables");
    r->source.time = time ? time : "t";
    bool ok = !tables.at || sga_fail(err, SGA_E_NO_CODE, "The system has tables, whose values an export does not carry: write the signals as expressions in time.");
    ok = ok && (!sets_variables(r) || sga_fail(err, SGA_E_NO_CODE, "Events of the trajectory set variables, or the system has modes, which an export does not carry: its motion would go on without them. "
                                               "Leave these events out, put numbers in the place of modes, and program them where the model is used."));
    return ok && read_variables(r) && read_definitions(r) && read_constraints(r) && read_field(r) && read_parameters(r, request);
}

void code_source_end(struct code_source *r)
{
    sga_arena_end(&r->mem);
}
