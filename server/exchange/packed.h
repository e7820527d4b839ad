/* Bodies that are made while they are sent: of long texts, and packed by gzip, a piece at a time: no thread packs for longer than a piece, and no packed body stands in memory. */
#ifndef SERVER_PACKED_H
#define SERVER_PACKED_H

#include <microhttpd.h>
#include <stdbool.h>
#include <stddef.h>

enum {
    PACKED_LEAST = 1024,         /* bytes: below it a body fits into one packet anyway */
    PACKED_MOST = 256,           /* bodies packed at a time, each with 96 KiB; what is asked for beyond is sent as it is */
};

/* A body that is read: as MHD_ContentReaderCallback, which returns 1 to max bytes, or MHD_CONTENT_READER_END_OF_STREAM. */
struct packed_source {
    MHD_ContentReaderCallback read;
    MHD_ContentReaderFreeCallback release;
    void *cls;
};

/* May another body be packed now? */
bool packed_room(void);
/* The response; what it holds of the source is released with it. NULL when memory ends: then it has been released. */
struct MHD_Response *packed_response(struct packed_source source);
/* The same of pieces of memory, at most three; what it has read of them rests (spool.h). */
struct MHD_Response *packed_pieces(const struct MHD_IoVec *part, int count, MHD_ContentReaderFreeCallback release, void *cls);
/* Such pieces as they are, when together they are long. */
struct MHD_Response *plain_pieces(const struct MHD_IoVec *part, int count, MHD_ContentReaderFreeCallback release, void *cls);

#endif
