/* An archive of files in memory (PKWARE's APPNOTE 6.3.10, as FMI and JAR use it), deflated by zlib. The same files give the same bytes. */
#ifndef SERVER_ZIP_H
#define SERVER_ZIP_H

#include "buf.h"

struct zip {
    struct sga_buf *out, directory;
    size_t start;                 /* where the archive begins in out */
    int files;
};

void zip_begin(struct zip *z, struct sga_buf *out);
/* False: memory ended, or the archive grows past 4 GB; zip_end is to be called all the same. */
bool zip_file(struct zip *z, const char *name, const struct sga_buf *content);
/* Appends the directory. */
void zip_end(struct zip *z);

#endif
