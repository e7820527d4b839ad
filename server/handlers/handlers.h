/* What answers requests. The table of paths (routes.c) names them. */
#ifndef SERVER_HANDLERS_H
#define SERVER_HANDLERS_H

struct exchange;

typedef enum MHD_Result handler(struct exchange *e);

handler handle_post_job, handle_solve;                               /* post.c */
handler handle_get_job, handle_list, handle_delete;                  /* get.c */
handler handle_check;                                                /* check.c */
handler handle_page;                                                 /* page.c */
handler handle_request;                                              /* request.c */
handler handle_events;                                               /* events.c */
handler handle_trajectory;                                           /* trajectory.c */
handler handle_tradeoff;                                             /* tradeoff.c */
handler handle_code, handle_fmu;                                     /* code.c */
handler handle_health, handle_ready, handle_metrics, handle_openapi, handle_schema, handle_version;   /* about.c */

#endif
