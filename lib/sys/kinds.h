/* What a variable is to a person who gives a start: a coordinate, a velocity, or something that follows. */
#ifndef SGA_SYS_KINDS_H
#define SGA_SYS_KINDS_H

struct sys_system;

enum sys_kind {
    SYS_COORDINATE,     /* its derivative enters the equations */
    SYS_VELOCITY,       /* of another one: by its role, or by a row x' = v (times a positive number) */
    SYS_ALGEBRAIC,      /* its derivative is asked for by no equation */
    SYS_MULTIPLIER      /* so too, and it is met only beside derivatives, or in what is: multipliers, inputs, forces that have a name */
};

/* kind[j] for each variable. A row that only defines a velocity which nothing else asks for (that of a multiplier among the
 * coordinates) asks for nothing. Velocities of each other in a circle are coordinates. Depends on the rows as a set alone.
 * Cost: the entries of the rows and their expressions. */
void sys_kinds(const struct sys_system *s, unsigned char *kind);

/* The variables in the order of their names into order (n). */
void sys_by_name(const struct sys_system *s, int *order);

#endif
