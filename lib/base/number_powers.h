/* Inside the base folder, and its test: powers of ten for the number writer. */
#ifndef SGA_BASE_NUMBER_POWERS_H
#define SGA_BASE_NUMBER_POWERS_H

#include <stdint.h>

#define SGA_POWER_MIN (-292)
#define SGA_POWER_MAX 324

/* [k - SGA_POWER_MIN]: high and low word of ceil(10^k / 2^(floor(log2 10^k) - 127)). */
extern const uint64_t sga_power_of_ten[SGA_POWER_MAX - SGA_POWER_MIN + 1][2];

#endif
