/* A guess of which some values are given: the others follow from the equations where these say them. */
#ifndef SGA_SGA_GUESS_H
#define SGA_SGA_GUESS_H

struct sys_system;

/* Fills near (by variable) where given is 0: what an equation without derivatives (or a restriction) that is affine in it says, once all
 * else in it is known; where that comes to an end what moves by itself stays at 0, then the rest; and so on. The same in
 * every order of equations and variables. Parameters: at parameter_near, or some general value where that is NULL or not a
 * number. A few evaluations of each equation. */
void guess_complete(const struct sys_system *sys, const unsigned char *given, double time, const double *parameter_near, double *near);

/* By variable: 1 where its derivative occurs; the caller frees it. */
unsigned char *guess_moving(const struct sys_system *sys);

#endif
