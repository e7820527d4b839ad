/* Errors as users see them: problem details (RFC 9457), from the library's error table. */
#ifndef SGA_BASE_PROBLEM_H
#define SGA_BASE_PROBLEM_H

struct sga_error;
struct sga_json;

/* Writes the object {type, title, status, code, detail, pointer, line, column, stage};
 * members that say nothing are left out. Text that is not UTF-8 is mended. */
void problem_write(struct sga_json *w, const struct sga_error *err);
/* The same as a string that the caller frees. */
char *problem_text(const struct sga_error *err);

#endif
