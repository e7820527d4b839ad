/* Inside the ode folder: the numbers of Tsitouras' method of order 5 with an error estimate of
 * order 4 and dense output of order 4, as published: Ch. Tsitouras, Runge-Kutta pairs of order
 * 5(4) satisfying only the first column simplifying assumption, Computers and Mathematics
 * with Applications 62 (2011) 770. The tests check the order conditions.
 *
 * Stage s is at t + c[s] h and x + h sum a[s] k. Stage 6 is the end of the step itself. */
#ifndef SGA_ODE_TSIT5_TABLES_H
#define SGA_ODE_TSIT5_TABLES_H

#include "rk_sum.h"

enum { TSIT5_END = 6, TSIT5_STAGES = 7 };

static const double tsit5_c[TSIT5_STAGES] = {0, 0.161, 0.327, 0.9, 0.9800255409045097, 1, 1};

static const struct sga_row tsit5_a[TSIT5_STAGES] = {
    {0, {0}, {0}},
    {1, {0}, {0.161}},
    {2, {0, 1}, {-0.008480655492356989, 0.335480655492357}},
    {3, {0, 1, 2}, {2.8971530571054935, -6.359448489975075, 4.3622954328695815}},
    {4, {0, 1, 2, 3}, {5.325864828439257, -11.748883564062828, 7.4955393428898365, -0.09249506636175525}},
    {5, {0, 1, 2, 3, 4},
     {5.86145544294642, -12.92096931784711, 8.159367898576159, -0.071584973281401, -0.028269050394068383}},
    {6, {0, 1, 2, 3, 4, 5},
     {0.09646076681806523, 0.01, 0.4798896504144996, 1.379008574103742, -3.290069515436081, 2.324710524099774}},
};

/* The weights minus those of order 4. */
static const struct sga_row tsit5_error =
    {7, {0, 1, 2, 3, 4, 5, 6},
     {-0.00178001105222577714, -0.0008164344596567469, 0.007880878010261995, -0.1447110071732629, 0.5823571654525552,
      -0.45808210592918697, 0.015151515151515152}};

/* Weights of the stages at t + theta h: theta (p[0] + theta (p[1] + theta (p[2] + theta p[3]))). */
static const double tsit5_dense[TSIT5_STAGES][4] = {
    {1, -2.763706197274826, 2.9132554618219126, -1.0530884977290216},
    {0, 0.13169999999999998, -0.2234, 0.1017},
    {0, 3.9302962368947516, -5.941033872131505, 2.490627285651253},
    {0, -12.411077166933676, 30.33818863028232, -16.548102889244902},
    {0, 37.50931341651104, -88.1789048947664, 47.37952196281928},
    {0, -27.896526289197286, 65.09189467479366, -34.87065786149661},
    {0, 1.5, -4, 2.5},
};

#endif
