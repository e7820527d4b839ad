/* Inside the run folder: which stage a job is in, and what each has taken.
 *
 * At every moment one stage runs, and its time is counted once: what they took adds up to the
 * whole. A stage that begins inside another one puts it off until it ends. */
#ifndef SGA_RUN_STAGE_CLOCK_H
#define SGA_RUN_STAGE_CLOCK_H

/* The one table: symbol, member of `work.seconds`. */
#define STAGE_TABLE(X) \
    X(READ, "read") \
    X(OPERATOR, "operator") \
    X(MECHANICAL, "mechanical") \
    X(REDUCTION, "reduction") \
    X(TEXTS, "texts") \
    X(STRATA, "strata") \
    X(SIGNS, "signs") \
    X(WITNESS, "witness") \
    X(STRUCTURE, "structure") \
    X(SYMMETRIES, "symmetries") \
    X(INITIAL, "initial") \
    X(TRAJECTORY, "trajectory") \
    X(SENSITIVITIES, "sensitivities") \
    X(TRADEOFF, "tradeoff") \
    X(LINEARIZATION, "linearization") \
    X(TRANSFER, "transfer") \
    X(EQUILIBRIA, "equilibria") \
    X(DERIVATION, "derivation") \
    X(FIT, "fit") \
    X(WRITING, "writing")

enum stage {
#define X(symbol, text) STAGE_##symbol,
    STAGE_TABLE(X)
#undef X
    STAGES
};

struct stage_clock {
    double seconds[STAGES];
    double sampling;           /* of the reduction: drawing points */
    enum stage now;
    double since;              /* sga_now() from which on it has not been counted; 0: it stands still */
};

/* The clock goes on with this stage; returns the one before. */
enum stage stage_begin(struct stage_clock *c, enum stage stage);
const char *stage_text(enum stage stage);

#endif
