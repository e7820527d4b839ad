/* Lines of the log: which are wanted, and their text. log_ring.c brings them out. */
#include "log.h"
#include "clock.h"
#include "log_ring.h"

#include <stdarg.h>
#include <stdatomic.h>
#include <stdio.h>
#include <string.h>
#include <unistd.h>

enum { LINE = 8192 };

static atomic_int threshold = LOG_L_INFO;
static bool as_text;

/* From LOG_L_AUDIT on. */
static const char *const level_names[] = { "audit", "error", "warn", "info", "debug" };

static const char *name_of(enum log_level level)
{
    return level_names[level - LOG_L_AUDIT];
}

void log_set_level(enum log_level level)
{
    atomic_store(&threshold, level);
}

void log_open(enum log_level level)
{
    log_set_level(level);
    as_text = isatty(STDERR_FILENO);
    log_ring_open();
}

bool log_level_from_text(const char *text, enum log_level *level)
{
    for (int i = LOG_L_ERROR; i <= LOG_L_DEBUG; i++)
        if (strcmp(text, name_of((enum log_level)i)) == 0) {
            *level = (enum log_level)i;
            return true;
        }
    return false;
}

bool log_wants(enum log_level level)
{
    return (int)level <= atomic_load_explicit(&threshold, memory_order_relaxed);
}

struct line {
    char text[LINE];
    size_t len;
};

static void put(struct line *l, const char *s)
{
    while (*s && l->len < LINE - 8)
        l->text[l->len++] = *s++;
}

/* A JSON string. Bytes that are not ASCII are written as '?': header values of any
 * encoding may come here. */
static void put_quoted(struct line *l, const char *s)
{
    put(l, "\"");
    for (; *s && l->len < LINE - 16; s++) {
        unsigned char c = (unsigned char)*s;
        if (c == '"' || c == '\\') {
            l->text[l->len++] = '\\';
            l->text[l->len++] = (char)c;
        } else {
            l->text[l->len++] = c < 0x20 || c > 0x7e ? (c == '\n' ? ' ' : '?') : (char)c;
        }
    }
    put(l, "\"");
}

void log_event(enum log_level level, const char *event, ...)
{
    if (!log_wants(level))
        return;
    struct line l;
    l.len = 0;
    char now[CLOCK_TEXT];
    clock_text(now, clock_ms());
    if (as_text) {
        put(&l, now), put(&l, " "), put(&l, name_of(level)), put(&l, " "), put(&l, event);
    } else {
        put(&l, "{\"time\":"), put_quoted(&l, now);
        put(&l, ",\"level\":"), put_quoted(&l, name_of(level));
        put(&l, ",\"event\":"), put_quoted(&l, event);
    }
    va_list ap;
    va_start(ap, event);
    for (const char *name; (name = va_arg(ap, const char *));) {
        const char *value = va_arg(ap, const char *);
        if (!value)
            continue;
        bool number = *name == '#';
        put(&l, as_text ? " " : ",");
        (as_text ? put : put_quoted)(&l, name + number);
        put(&l, as_text ? "=" : ":");
        (number ? put : put_quoted)(&l, value);
    }
    va_end(ap);
    put(&l, as_text ? "" : "}");
    l.text[l.len++] = '\n';
    log_ring_put(l.text, l.len);
}
