/* Edit distance with transpositions (optimal string alignment), for messages. */
#include "suggest.h"

#include <ctype.h>
#include <string.h>

enum { LONGEST = 64, FAR = 99 };

static int smaller(int a, int b) { return a < b ? a : b; }

int suggest_distance(const char *a, size_t na, const char *b, size_t nb)
{
    int row[3][LONGEST + 1];
    if (na > LONGEST || nb > LONGEST)
        return FAR;
    for (size_t j = 0; j <= nb; j++)
        row[0][j] = (int)j;
    for (size_t i = 1; i <= na; i++) {
        int *now = row[i % 3], *last = row[(i + 2) % 3], *before = row[(i + 1) % 3];
        now[0] = (int)i;
        for (size_t j = 1; j <= nb; j++) {
            now[j] = smaller(last[j - 1] + (a[i - 1] != b[j - 1]), smaller(last[j], now[j - 1]) + 1);
            if (i > 1 && j > 1 && a[i - 1] == b[j - 2] && a[i - 2] == b[j - 1])
                now[j] = smaller(now[j], before[j - 2] + 1);
        }
    }
    return row[na % 3][nb];
}

static int same_but_case(const char *a, const char *b, size_t n)
{
    for (size_t i = 0; i < n; i++)
        if (tolower((unsigned char)a[i]) != tolower((unsigned char)b[i]))
            return 0;
    return 1;
}

void suggest_begin(struct suggest *s, const char *word, size_t length)
{
    int most = length <= 3 ? 1 : 2;
    *s = (struct suggest){ .word = word, .length = length,
                           .distance = smaller(most, (int)smaller((int)length, LONGEST) - 1) + 1 };
}

void suggest_offer(struct suggest *s, const char *candidate)
{
    size_t n = strlen(candidate);
    size_t gap = n > s->length ? n - s->length : s->length - n;
    if (gap >= (size_t)s->distance && gap)
        return;
    int d = n == s->length && same_but_case(s->word, candidate, n)
        ? 0 : suggest_distance(s->word, s->length, candidate, n);
    if (d < s->distance) {
        s->best = candidate;
        s->distance = d;
    }
}
