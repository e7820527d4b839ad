/* Files of clients/page and etc/examples, put into the program when it is built (page.sh). */
#ifndef SERVER_PAGE_FILES_H
#define SERVER_PAGE_FILES_H

#include <stddef.h>

struct page_file {
    const char *name;                                /* "index.html", "plots.js", ... */
    const unsigned char *text; size_t length;        /* as it is */
    const unsigned char *packed; size_t packed_length;   /* as gzip makes of it */
};

extern const struct page_file page_files[];     /* ended by a NULL name */

#endif
