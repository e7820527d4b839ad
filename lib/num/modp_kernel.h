/* Inside this folder: functions that are not rational, modulo p. */
#ifndef SGA_NUM_MODP_KERNEL_H
#define SGA_NUM_MODP_KERNEL_H

#include "modp.h"

/* f(x), or f(x, y) for the functions of two arguments. False if it has no value here. */
bool modp_kernel(const struct num_modp *m, enum expr_op op, mp_limb_t x, mp_limb_t y, mp_limb_t *r);
mp_limb_t modp_pi(const struct num_modp *m);
/* x^exponent for a square x, itself a square; 0^exponent = 0 for exponent > 0. False for
 * other x. */
bool modp_rational_power(const struct num_modp *m, mp_limb_t x, const fmpq *exponent, mp_limb_t *r);

#endif
