/* Inside the form folder only: symbols of derivatives. */
#ifndef SGA_FORM_DERIVATIVES_H
#define SGA_FORM_DERIVATIVES_H

struct form_equations;

int form_derivative_symbol(struct form_equations *f, int u, int order);

#endif
