/* An export's texts as nodes of one store: what is shared between them is shared in the code. */
#ifndef SGA_EXPORT_MODEL_H
#define SGA_EXPORT_MODEL_H

#include "arena.h"
#include "export.h"
#include "expr.h"

struct export_model {
    struct sga_arena memory;
    struct expr_store store;
    const struct export_source *source;
    enum export_language language;
    int free_parameters;          /* those that are arguments */
    int parts;                    /* how many shared parts the last lines have (export_lines) */
    const char **symbol;          /* by symbol of the store: its text in the language */
    expr_id *value;               /* by parameter: of those that have one */
    expr_id *constraint, *component, *gauge, *output;       /* gauge: by rows */
    struct export_entry {
        int row, column;
        expr_id value;
    } *entry;                     /* of the Jacobian, by rows, those that are not the constant 0 */
    int entries;
};

/* Takes all the texts in. False: err says which could not be read and why; the model is to be cleared all the same. */
bool export_model_read(struct export_model *m, const struct export_source *s, enum export_language l, struct sga_error *err);
void export_model_clear(struct export_model *m);

#endif
