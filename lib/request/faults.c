/* All faults of a request. Reading goes on where what comes after does not depend on what could not be read: in lists, among the
 * members of an object, in the parts of a request. */
#include "reader.h"

#include <stdlib.h>
#include <string.h>

#include "error.h"
#include "mem.h"
#include "warnings.h"

/* Limits end the reading: what was met would be met again. */
static bool ends_reading(const struct reader *rd)
{
    enum sga_code code = rd->err->code;
    return !expr_store_ok(&rd->r->store) || code == SGA_E_LIMIT_NODES || code == SGA_E_LIMIT_SECONDS || code == SGA_E_LIMIT_MEMORY
        || code == SGA_E_LIMIT_GROWTH;
}

/* Names and derivatives outside a system with faults: what they name may be what could not be read. */
static bool may_follow(const struct reader *rd)
{
    const struct request_faults *f = rd->faults;
    static const char system[] = "/system/";
    bool names = rd->err->code == SGA_E_EXPR_NAME || rd->err->code == SGA_E_EXPR_DERIVATIVE;
    if (!names || strncmp(rd->err->pointer, system, sizeof system - 1) == 0)
        return false;
    for (int i = 0; i < f->count; i++)
        if (strncmp(f->list[i].pointer, system, sizeof system - 1) == 0)
            return true;
    return false;
}

void faults_add(struct reader *rd)
{
    struct request_faults *f = rd->faults;
    if (f->count == SGA_MOST_FAULTS) {
        f->cut = true;
        return;
    }
    if (!rd->err->stage[0])
        strcpy(rd->err->stage, "request");
    make_utf8(rd->err->detail);
    make_utf8(rd->err->pointer);
    SGA_RESERVE(f->list, f->cap, f->count + 1);
    f->list[f->count++] = *rd->err;
}

bool at_pass(struct reader *rd, size_t mark)
{
    if (!rd->faults || rd->faults->cut || ends_reading(rd))
        return false;
    if (rd->err->code != SGA_E_OK && !may_follow(rd))
        faults_add(rd);
    *rd->err = (struct sga_error){ 0 };
    at_back(rd, mark);
    return !rd->faults->cut;
}

expr_id read_listed(struct reader *rd, const json_t *v, char **text)
{
    size_t mark = rd->at.len;
    expr_id e = read_expression(rd, v, text);
    if (e || !at_pass(rd, mark))
        return e;
    if (text)
        *text = sga_take_text(&rd->r->mem, "1");
    return expr_int(&rd->r->store, 1);
}

void request_faults_clear(struct request_faults *f)
{
    free(f->list);
    *f = (struct request_faults){ 0 };
}
