/* Inside the points folder: a path from a start to the constraints, where Newton's steps from there would wander. */
#ifndef SGA_POINTS_DAVIDENKO_H
#define SGA_POINTS_DAVIDENKO_H

struct points_jacobian;
struct points_point;

/* Moves p along the points where every constraint has the same part s of its value at p, from s = 1 to near 0 (Davidenko's path: Newton's steps
 * made infinitely short; the same in any regular coordinates). Each piece of it is met by Newton's steps that must become four times shorter
 * each; where they do not, it is halved. Where the path meets dependent differentials or the edge of the domain, or leads to
 * infinity, p stays. Cost: at most some hundred steps. */
void points_follow(struct points_jacobian *j, struct points_point *p);

#endif
