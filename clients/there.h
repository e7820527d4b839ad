/* Exchanges with a daemon: what is common to posting a request and to looking at a job. */
#ifndef CLIENTS_THERE_H
#define CLIENTS_THERE_H

#include "http_client.h"
#include "json_scan.h"
#include "solve.h"

/* Takes the address apart (http_parse); false with the problem in a. */
bool server_there(const char *url, struct http_server *server, struct answer *a);
/* "code at POINTER, line L, column C: detail" from problem details; the object into a->text. */
void problem_there(struct slice problem, struct answer *a);
/* From a first reply about the job at path on, asks until it has ended or the time is `until` (sga_now's; 0: as long as it takes). Takes the
 * reply's body. An interrupt that was caught (interrupt.h) cancels the job. */
bool answer_there(const struct http_server *server, const char *path, struct http_reply *reply, double until, struct answer *a);
/* The result of a job, as it is now or once it is there. */
bool job_there(const char *url, const char *id, bool wait, double seconds, struct answer *a);

#endif
