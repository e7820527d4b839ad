/* An answer as a source FMU of FMI 3.0, for Model Exchange and Co-Simulation: its files. What packs them is the caller's.
 *
 * All variables of the answer are continuous states, with the constraints between them: which of them could be coordinates changes along a
 * motion. Start and Event Mode project. Gauge functions are inputs, parameters without a value are fixed parameters, `output`s are
 * outputs, and where the formulas have abs, sign, min or max there are event indicators. Functional Mock-up Interface 3.0.2. */
#ifndef SGA_EXPORT_FMU_H
#define SGA_EXPORT_FMU_H

#include "buf.h"
#include "export.h"

struct fmu_simulation {
    const double *start;          /* by variable; NULL: not known */
    const double *argument;       /* by parameter that is an argument; NaN: it has no value before one is set */
    const char **input;           /* names, by gauge field */
    double begin, stop, tolerance;/* of the experiment; NaN: not said */
};

enum { FMU_FILES = 4 };
struct fmu_file {
    const char *name;             /* its path in the archive */
    struct sga_buf text;          /* the caller frees it, after a failure too */
};

/* False: err (no_code) says why; in addition to what export_code refuses that is a constraint that jumps. Cost: as export_code. */
bool export_fmu(const struct export_source *s, const struct fmu_simulation *sim, struct fmu_file file[FMU_FILES], struct sga_error *err);

#endif
