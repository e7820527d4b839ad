/* Inside the ask folder: the transfer matrix of a linear system whose coefficients move with time. */
#ifndef SGA_RUN_TRANSFER_MOVING_H
#define SGA_RUN_TRANSFER_MOVING_H

#include <stdbool.h>

#include "fraction.h"

struct ask_work;
struct sga_error;

/* The equations and outputs as operators over Q(t), inputs apart, and from them the fraction left y = right u. *linear: whether they are affine in
 * variables and tables, with rational functions of time for coefficients; else nothing is found, and why says what stands in the way (160 bytes). False with
 * err, or *linear false. op_fraction_clear is due in every case. Cost: gradients of the rows, and fraction.h. */
bool transfer_moving(struct op_fraction *f, enum op_fraction_status *status, const struct ask_work *s, bool *linear, char *why, struct sga_error *err);

#endif
