/* Inside the ask folder: a linearization as JSON. */
#ifndef SGA_RUN_LINEAR_WRITE_H
#define SGA_RUN_LINEAR_WRITE_H

#include "linear_modes.h"
#include "linearize.h"

struct job;
struct sga_json;

/* What names the columns and rows. */
struct linear_ports {
    const struct linear_input *input; int inputs;
    char *const *output; int outputs;
    const char *gauge;         /* how freedom that is no input is taken; NULL: there is none. Static */
};

/* [[re, im, multiplicity], ...] under a key, or null. */
void linear_write_spectrum(struct sga_json *w, const char *key, const struct spectrum_of *s);
/* "inputs" and "outputs": their names; "gauge" where there is one. */
void linear_write_ports(const struct linear_ports *p, struct sga_json *w);
/* One object. at_point: the answer says where (not where no point was asked for). */
void linear_write(const struct job *j, const struct linear_ports *ports, const struct linearization *l, const struct linear_modes *m, bool at_point,
                  struct sga_json *w);

#endif
