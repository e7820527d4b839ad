/* The word that was probably meant. */
#ifndef SGA_EXPR_SUGGEST_H
#define SGA_EXPR_SUGGEST_H

#include <stddef.h>

/* Looks for the candidate nearest to a wrong word: at most 2 edits away, 1 for words
 * of up to 3 letters, and fewer edits than letters; letter case is free. Offer candidates one by one;
 * the first of the nearest wins. Candidates are not copied. */
struct suggest {
    const char *word;
    size_t length;
    const char *best;      /* NULL: nothing is near */
    int distance;
};
void suggest_begin(struct suggest *s, const char *word, size_t length);
void suggest_offer(struct suggest *s, const char *candidate);

/* Edits (insert, delete, replace, swap neighbours) between two words of at most 64
 * bytes; 99 for longer ones. */
int suggest_distance(const char *a, size_t na, const char *b, size_t nb);

#endif
