/* What an answer says beside itself: its member `warnings`, [{"code", "pointer", "detail"}].
 *
 * A job owns one list; whoever holds the job's budget can add to it. Nothing here changes what is
 * computed. Constants that cut a search or a list stand in limits.def, each with its reason and the
 * warning that it raises where it is met: no cap is silent. */
#ifndef SGA_BASE_WARNINGS_H
#define SGA_BASE_WARNINGS_H

#include <stdbool.h>
#include <stddef.h>

struct sga_budget;
struct sga_error;
struct sga_json;

enum sga_warning {
#define X(symbol, code, says) SGA_W_##symbol,
#include "warning.def"
#undef X
    SGA_WARNINGS
};

/* SGA_MOST_NAME: its value. */
enum {
#define X(name, value, warning, what, why) SGA_MOST_##name = (value),
#include "limits.def"
#undef X
};

enum sga_limit {
#define X(name, value, warning, what, why) SGA_LIMIT_##name,
#include "limits.def"
#undef X
    SGA_LIMITS
};

/* Each said once: neither code, pointer and detail are those of another. */
struct sga_warned { enum sga_warning kind; char *pointer, *detail; };
struct sga_warnings {
    struct sga_warned *list; int count; size_t cap;
    bool open[SGA_LIMITS];         /* met, and what was asked stayed undecided */
};

void sga_warnings_clear(struct sga_warnings *w);

/* Adds a warning to the job's list, unless it stands there. pointer: a JSON Pointer into the request, or "".
 * Where b, or its list, is NULL nobody asks, and nothing is done. */
void sga_warn(const struct sga_budget *b, enum sga_warning kind, const char *pointer, const char *fmt, ...)
    __attribute__((format(printf, 4, 5)));
/* The limit was met, and that cut something: its warning, with its name, value and what is cut. */
void sga_limit_met(const struct sga_budget *b, enum sga_limit limit);
/* The limit of a proof was met: what was asked stays undecided. No warning, as something else may decide it: */
void sga_limit_open(const struct sga_budget *b, enum sga_limit limit);
/* these, and the searches that were cut, are said in the text of a refusal, as far as there is room. */
void sga_limits_explain(const struct sga_warnings *w, struct sga_error *err);

/* The list as JSON: by kind in the table's order, and by detail among one kind, so that it does not depend on what
 * was found first. */
void sga_warnings_write(const struct sga_warnings *w, struct sga_json *json);

const char *sga_warning_code(enum sga_warning kind);
const char *sga_limit_name(enum sga_limit limit);

#endif
