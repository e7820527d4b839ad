/* A folder in memory for the files of one run of a target, and its end. */
#ifndef TESTS_FUZZ_FOLDER_H
#define TESTS_FUZZ_FOLDER_H

#include <dirent.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

/* On tmpfs where there is one: the store waits for the disk at each commit. */
static inline void folder_make(char *out, size_t size)
{
    snprintf(out, size, "%s/sgad-fuzz-XXXXXX", access("/dev/shm", W_OK) == 0 ? "/dev/shm" : "/tmp");
    if (!mkdtemp(out))
        abort();
}

/* All files in it; the folder itself too where `whole` is not 0. */
static inline void folder_empty(const char *path, int whole)
{
    DIR *d = opendir(path);
    for (struct dirent *e; d && (e = readdir(d));)
        if (strcmp(e->d_name, ".") != 0 && strcmp(e->d_name, "..") != 0)
            unlinkat(dirfd(d), e->d_name, 0);
    if (d)
        closedir(d);
    if (whole)
        rmdir(path);
}

#endif
