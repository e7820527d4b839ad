/* Inside the ode folder: the numbers of the Radau IIA formulas of 3, 5 and 7 stages,
 * orders 5, 9 and 13 (Hairer, Wanner, Solving Ordinary Differential Equations II, IV.5
 * and IV.8); computed to 21 digits by tests/radau_tables.py. The tests check the order
 * conditions. */
#ifndef SGA_ODE_RADAU_TABLES_H
#define SGA_ODE_RADAU_TABLES_H

enum { RADAU_TABLES = 3, RADAU_STAGES = 7, RADAU_PAIRS = 3 };

struct radau_table {
    int s;                          /* stages; order 2 s - 1 */
    double c[RADAU_STAGES];         /* nodes in (0, 1], the last is 1 */
    /* A^-1 = T D TI, D = diag(gamma, blocks): pair p (components 1 + 2p and 2 + 2p) acts
     * as w1 + i w2 -> (re + i im)(w1 + i w2). */
    double T[RADAU_STAGES][RADAU_STAGES], TI[RADAU_STAGES][RADAU_STAGES];
    double gamma, re[RADAU_PAIRS], im[RADAU_PAIRS];
    /* h X(x0) + sum defect_i z_i is h times the defect of the collocation polynomial at
     * the start of the step: the error estimate before it is filtered. */
    double defect[RADAU_STAGES];
    double dense;                   /* the polynomial's largest error inside, over that estimate */
    double bary[RADAU_STAGES + 1];  /* weights of the interpolation at 0, c_1, .., c_s */
    /* Two points far from the nodes, and h times the polynomial's derivative there. */
    double middle[2], slope[2][RADAU_STAGES];
};

extern const struct radau_table radau_tables[RADAU_TABLES];

#endif
