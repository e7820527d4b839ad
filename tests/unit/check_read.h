/* Expressions from texts, for tests. */
#ifndef TESTS_UNIT_CHECK_READ_H
#define TESTS_UNIT_CHECK_READ_H

#include "check.h"
#include "error.h"
#include "parse.h"

static inline expr_id check_read(struct expr_store *st, const char *text)
{
    struct sga_error err = { 0 };
    expr_id e = expr_parse(st, text, NULL, &err);
    CHECK(e, "%s: %s", text, err.detail);
    return e;
}

#endif
