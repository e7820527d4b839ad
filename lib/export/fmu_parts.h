/* Inside the export folder: what the files of an FMU are made of. */
#ifndef SGA_EXPORT_FMU_PARTS_H
#define SGA_EXPORT_FMU_PARTS_H

#include "fmu.h"
#include "model.h"

#define FMU_MODEL "sga_model"

/* The functions of FMI, the same for all (fmu_*.c.in, one after the other). */
extern const char fmu_runtime[];

struct fmu {
    struct export_model m;
    const struct fmu_simulation *sim;
    expr_id *indicator; int indicators;
    char token[40];
};

void fmu_description(const struct fmu *f, struct sga_buf *out);
void fmu_build_description(struct sga_buf *out);
void fmu_page(const struct fmu *f, struct sga_buf *out);

#endif
