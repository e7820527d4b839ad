/* Tokens of the expression grammar. ASCII only: everything else is one LEX_BAD
 * character, whole in UTF-8, so that messages can show it. */
#include "lex.h"

#include <stdio.h>
#include <string.h>

static int is_digit(char c) { return c >= '0' && c <= '9'; }
static int is_letter(char c) { return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || c == '_'; }
static int is_blank(char c) { return c == ' ' || c == '\t' || c == '\n' || c == '\r'; }

static size_t digits(const char *s)
{
    size_t n = 0;
    while (is_digit(s[n]))
        n++;
    return n;
}

/* digits [. digits] [e [sign] digits]; an e without digits is not part of it. */
static size_t number_length(const char *s)
{
    size_t n = digits(s);
    if (s[n] == '.')
        n += 1 + digits(s + n + 1);
    if (s[n] == 'e' || s[n] == 'E') {
        size_t sign = s[n + 1] == '+' || s[n + 1] == '-';
        size_t d = digits(s + n + 1 + sign);
        if (d)
            n += 1 + sign + d;
    }
    return n;
}

size_t lex_indices(const char *s)
{
    size_t n = 0;
    if (s[0] != '[')
        return 0;
    do {
        size_t d = digits(s + n + 1);
        if (d == 0 || (d > 1 && s[n + 1] == '0'))
            return 0;
        n += 1 + d;
    } while (s[n] == ',');
    return s[n] == ']' ? n + 1 : 0;
}

/* Bytes of the character at s: 1 where it is not well-formed UTF-8. */
static size_t character_length(const char *s)
{
    unsigned char c = (unsigned char)s[0];
    size_t n = c >= 0xF0 && c < 0xF8 ? 4 : c >= 0xE0 ? 3 : c >= 0xC2 ? 2 : 1;
    for (size_t i = 1; i < n; i++)
        if (((unsigned char)s[i] & 0xC0) != 0x80)
            return 1;
    return n;
}

static enum lex_kind single(char c)
{
    switch (c) {
    case 0:    return LEX_END;
    case '+':  return LEX_PLUS;
    case '-':  return LEX_MINUS;
    case '*':  return LEX_TIMES;
    case '/':  return LEX_OVER;
    case '^':  return LEX_POWER;
    case '(':  return LEX_OPEN;
    case ')':  return LEX_CLOSE;
    case ',':  return LEX_COMMA;
    case '=':
    case '~':  return LEX_EQUAL;
    case '<':  return LEX_LESS;
    case '>':  return LEX_GREATER;
    case '\'': return LEX_QUOTES;
    default:   return LEX_BAD;
    }
}

struct lex_token lex_next(const char *text, size_t at)
{
    while (is_blank(text[at]))
        at++;
    const char *s = text + at;
    if (is_digit(s[0]) || (s[0] == '.' && is_digit(s[1])))
        return (struct lex_token){ LEX_NUMBER, at, number_length(s) };
    size_t n = 0;
    if (is_letter(s[0])) {
        while (is_letter(s[n]) || is_digit(s[n]))
            n++;
        return (struct lex_token){ LEX_NAME, at, n + lex_indices(s + n) };
    }
    if (s[0] == '*' && s[1] == '*')
        return (struct lex_token){ LEX_POWER, at, 2 };
    if (s[0] == '=' && s[1] == '=')
        return (struct lex_token){ LEX_EQUAL, at, 2 };
    if (s[0] && strchr("<>!~", s[0]) && s[1] == '=')
        return (struct lex_token){ s[0] == '<' ? LEX_LESS_EQUAL : s[0] == '>' ? LEX_GREATER_EQUAL : LEX_NOT_EQUAL, at, 2 };
    enum lex_kind kind = single(s[0]);
    if (kind == LEX_QUOTES) {
        while (s[n] == '\'')
            n++;
        return (struct lex_token){ kind, at, n };
    }
    return (struct lex_token){ kind, at, kind == LEX_END ? 0 : kind == LEX_BAD ? character_length(s) : 1 };
}

void lex_place(const char *text, size_t at, int *line, int *column)
{
    *line = 1;
    *column = 1;
    for (size_t i = 0; i < at && text[i]; i++) {
        if (text[i] == '\n') {
            ++*line;
            *column = 1;
        } else if (((unsigned char)text[i + 1] & 0xC0) != 0x80) {
            ++*column;      /* the next byte starts another character */
        }
    }
}

void lex_show(const char *text, struct lex_token tok, char out[LEX_SHOWN])
{
    unsigned char c = (unsigned char)text[tok.start];
    if (tok.kind == LEX_END)
        snprintf(out, LEX_SHOWN, "the end");
    else if (tok.kind == LEX_BAD && (c < 0x20 || c == 0x7F || (c >= 0x80 && tok.length == 1)))
        snprintf(out, LEX_SHOWN, "the byte 0x%02X", c);
    else if (tok.length > 40)
        snprintf(out, LEX_SHOWN, "'%.36s...'", text + tok.start);
    else
        snprintf(out, LEX_SHOWN, "'%.*s'", (int)tok.length, text + tok.start);
}

const char *lex_instead(const char *text, struct lex_token tok)
{
    static const struct {
        const char *character, *advice;
    } table[] = {
        { "\u2212", "write -" }, { "\u2013", "write -" }, { "\u2014", "write -" },
        { "\u00B7", "write *" }, { "\u22C5", "write *" }, { "\u00D7", "write *" }, { "\u2217", "write *" },
        { "\u00F7", "write /" }, { "\u2215", "write /" },
        { "\u00B2", "write ^2" }, { "\u00B3", "write ^3" }, { "\u221A", "write sqrt( )" },
        { "\u03C0", "write pi" }, { "\u2019", "write x' or der(x)" }, { "\u2032", "write x' or der(x)" },
        { "\u221E", "there is no infinity here" }, { "\u00A0", "write a plain space" },
        { "[", "write ( )" }, { "]", "write ( )" }, { "{", "write ( )" }, { "}", "write ( )" },
        { "%", "there is no remainder" }, { "!", "there is no factorial; write not in a condition" }, { "&", "write and, in the condition of if" }, { "|", "write abs( )" },
        { ".", "a number needs digits" }, { ";", "write one expression for each text" },
    };
    for (size_t i = 0; i < sizeof table / sizeof *table; i++)
        if (strlen(table[i].character) == tok.length && memcmp(table[i].character, text + tok.start, tok.length) == 0)
            return table[i].advice;
    return NULL;
}
