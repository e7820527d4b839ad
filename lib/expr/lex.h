/* Tokens of the expression grammar, and places in its text. */
#ifndef SGA_EXPR_LEX_H
#define SGA_EXPR_LEX_H

#include <stddef.h>

enum lex_kind {
    LEX_END, LEX_NUMBER, LEX_NAME,
    LEX_QUOTES,                          /* one or more ' */
    LEX_PLUS, LEX_MINUS, LEX_TIMES, LEX_OVER, LEX_POWER,   /* POWER: ^ or ** */
    LEX_OPEN, LEX_CLOSE, LEX_COMMA,
    LEX_EQUAL,                           /* = or == or ~ */
    LEX_LESS, LEX_LESS_EQUAL, LEX_GREATER, LEX_GREATER_EQUAL, LEX_NOT_EQUAL,   /* !=, or ~= */
    LEX_BAD                              /* one character that starts nothing */
};

struct lex_token {
    enum lex_kind kind;
    size_t start, length;                /* bytes */
};

/* The token at or after byte `at` of a 0-terminated text. Blanks are skipped. */
struct lex_token lex_next(const char *text, size_t at);

/* Bytes of the indices that s begins with, as names have them: [7], [2,13], without blanks and zeros in front; 0: of none. */
size_t lex_indices(const char *s);

/* Line and column (both from 1, columns in characters of UTF-8) of a byte. */
void lex_place(const char *text, size_t at, int *line, int *column);

/* A token as a message shows it, at most 40 bytes of it: "the end" or "'x1'". */
#define LEX_SHOWN 64
void lex_show(const char *text, struct lex_token tok, char out[LEX_SHOWN]);

/* What to write instead of a character that is not in the grammar; NULL: nothing known. */
const char *lex_instead(const char *text, struct lex_token tok);

#endif
