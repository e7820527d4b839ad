/* The steps of the schema as SQL, made of schema-N.sql by steps.sh. */
#ifndef SERVER_PG_STEPS_H
#define SERVER_PG_STEPS_H

extern const char *const pg_steps[];

#endif
