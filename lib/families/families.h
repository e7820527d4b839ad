/* Families: entries of a list that differ in whole numbers alone, said once in the loops of a request.
 *
 *   [{"generation":1,"expression":"u[1,0] - u[1,1]"}, ..., {"generation":1,"expression":"u[9,0] - u[9,1]"}]
 *   [{"for":"i = 1:9","count":9,"place":"i-1","generation":1,"expression":"u[i,0] - u[i,1]"}]
 *   {"u[1,1]":"u[1,0]", ..., "u[9,9]":"u[9,8]"}
 *   {"u[i = 1:9, j = 1:9]":"u[i,j-1]"}
 *
 * In every text of such an entry, names of the loop and indices are worked out as in a request (index.h). `place` says where in the whole list
 * each stands, from 0; the entries without a loop fill the other places in their order. A list of texts has {"for", "count", "place",
 * "expression"} in it. The number `tangency_of` becomes the text "constraints[...]" where it is another one in each.
 *
 * Texts are compact JSON, as buf.h writes it: what others wrote is not to be given here. */
#ifndef SGA_FAMILIES_H
#define SGA_FAMILIES_H

#include <stdbool.h>
#include <stddef.h>

struct sga_buf;

/* Names for the loops: letters that no name of the system is, or begins with before a [. False: there are not two of them.
 * `taken` is asked of each letter. */
struct families_letters { char outer[2], inner[2]; };
bool families_letters(bool taken[26], struct families_letters *out);

/* What may be folded: lists and objects of more than `longest` entries; a family has `least` (2 at least) in each loop. */
struct families_how {
    int longest, least;
    struct families_letters letters;
};
/* The list or object that out's text is from byte `start` on is replaced by one with families. Each family is expanded again by the request's
 * reader of loops before it counts, and must give the entries that it stands for to the byte. Entries of one shape are looked at in their
 * order; runs whose numbers grow by constant steps are families, rows of runs by a second loop. True: some were found. Cost: linear in the
 * text, and sorting of the entries. */
bool families_fold(struct sga_buf *out, size_t start, const struct families_how *how);

/* Appends the text with all families in it as the entries that they stand for; the order of an object's members is not kept. False: a family
 * in it is none (it was not made by families_fold), or makes more than REQUEST_MAX_WRITTEN entries; out is then not to be used. Linear in what
 * is made. */
bool families_expand(const char *text, size_t length, struct sga_buf *out);

#endif
