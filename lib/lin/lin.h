/* Numerical linear algebra. The only folder that includes KLU and GSL's linear algebra.
 *
 * lin_init() must be called once by every process before anything else of this folder:
 * GSL's error handler is a global of the process that aborts, and it is switched off
 * here, once, so that failures come back as values. Calling it again does no harm. It is
 * not called by the functions themselves, because a library call must not change a
 * global behind another thread's back. */
#ifndef SGA_LIN_H
#define SGA_LIN_H

void lin_init(void);

#endif
