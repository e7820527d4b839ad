/* A list taken apart into entries, and an entry into numbers and what is between them. */
#include <string.h>

#include "arena.h"
#include "family.h"

const char *family_value_end(const char *s, const char *end)
{
    int depth = 0;
    bool quoted = false;
    for (; s < end; s++) {
        if (quoted) {
            s += *s == '\\';
            quoted = *s != '"';
        } else if (*s == '"') {
            quoted = true;
        } else if (*s == '[' || *s == '{') {
            depth++;
        } else if (*s == ']' || *s == '}') {
            if (depth-- == 0)
                return s;
        } else if (*s == ',' && depth == 0) {
            return s;
        }
    }
    return end;
}

struct entry *family_entries(const char *s, const char *end, int *count, struct sga_arena *mem)
{
    struct entry *list = NULL;
    size_t room = 0;
    int n = 0;
    for (s++; s < end && *s != ']' && *s != '}'; s += *s == ',') {
        const char *stop = family_value_end(s, end);
        SGA_RESERVE_IN(mem, list, room, (size_t)n + 1);
        list[n] = (struct entry){ .text = s, .length = (size_t)(stop - s), .place = n };
        n++;
        s = stop;
    }
    *count = n;
    return list;
}

static bool is_digit(char c) { return c >= '0' && c <= '9'; }

static bool joins(char c)
{
    return is_digit(c) || (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || c == '_' || c == '.';
}

/* How many digits from s on are a number of their own; 0: they are a part of something. */
static size_t whole(const char *s, size_t left, size_t digits)
{
    return digits <= 9 && !(digits > 1 && *s == '0') && !joins(s[-1]) && (digits == left || !joins(s[digits])) ? digits : 0;
}

static long number(const char *s, size_t digits)
{
    long v = 0;
    for (size_t i = 0; i < digits; i++)
        v = v * 10 + (s[i] - '0');
    return v;
}

int family_slots(const char *text, size_t length, struct slot *slot, long *value, uint64_t *shape)
{
    static const char member[] = "\"tangency_of\":";
    const uint64_t prime = 1099511628211u;
    uint64_t hash = 14695981039346656037u;
    bool quoted = false, indices = false;
    int n = 0;
    for (size_t i = 0; i < length; i++) {
        char c = text[i];
        if (i && is_digit(c)) {
            size_t digits = 1, own;
            while (i + digits < length && is_digit(text[i + digits]))
                digits++;
            bool counted = !quoted && i >= sizeof member && memcmp(text + i - (sizeof member - 1), member, sizeof member - 1) == 0;
            own = quoted || counted ? whole(text + i, length - i, digits) : 0;
            if (own) {
                enum slot_kind kind = counted ? SLOT_MEMBER : indices ? SLOT_INDEX : SLOT_LITERAL;
                if (slot)
                    slot[n] = (struct slot){ i, own, kind };
                if (value)
                    value[n] = number(text + i, own);
                n++;
                hash = (hash ^ (256u + kind)) * prime;
            }
            for (size_t k = 0; !own && k < digits; k++)
                hash = (hash ^ (unsigned char)text[i + k]) * prime;
            i += digits - 1;
            continue;
        }
        if (c == '"' && !(quoted && text[i - 1] == '\\'))
            quoted = !quoted;
        indices = quoted && (c == '[' || (indices && c != ']'));
        hash = (hash ^ (unsigned char)c) * prime;
    }
    *shape = hash;
    return n;
}
