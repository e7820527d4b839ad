/* Texts of any length (spool.h): the same bytes whether they are in memory or in a file, however they grow, and few pages in the process. */
#include <dirent.h>
#include <pthread.h>
#include <stdint.h>
#include <string.h>
#include <unistd.h>

#include "check.h"
#include "digest.h"
#include "json_scan.h"
#include "spool.h"

static char folder[] = "/tmp/sgad-spool-XXXXXX";

static char letter(size_t i)
{
    return (char)('a' + (i * 2654435761u >> 7) % 26);
}

static void fill(char *text, size_t from, size_t to)
{
    for (size_t i = from; i < to; i++)
        text[i] = letter(i);
}

static size_t wrong(const char *text, size_t length)
{
    size_t n = 0;
    for (size_t i = 0; i < length; i++)
        n += text[i] != letter(i);
    return n;
}

/* Kilobytes of the process in memory, those of files too. */
static long resident(void)
{
    char line[200];
    long kilobytes = 0;
    FILE *f = fopen("/proc/self/status", "r");
    while (f && fgets(line, sizeof line, f))
        if (sscanf(line, "VmRSS: %ld", &kilobytes) == 1)
            break;
    if (f)
        fclose(f);
    return kilobytes;
}

static int files(void)
{
    int n = 0;
    DIR *d = opendir("/proc/self/fd");
    while (d && readdir(d))
        n++;
    if (d)
        closedir(d);
    return n;
}

/* Of each length, by steps over the border between memory and file, back again, and with what stands before. */
static void lengths(void)
{
    static const size_t sizes[] = { 0, 1, 100, SPOOL_LONG - 1, SPOOL_LONG, SPOOL_LONG + 4097, 5 * SPOOL_LONG, 3, 2 * SPOOL_LONG, SPOOL_LONG / 2 };
    int before = files();
    for (size_t k = 0; k < sizeof sizes / sizeof *sizes; k++) {
        char *text = spool_new(sizes[k]);
        CHECK(text);
        memset(text - SPOOL_HEAD, 'h', SPOOL_HEAD);
        fill(text, 0, sizes[k]);
        text[sizes[k]] = 0;
        for (size_t m = 0; m < sizeof sizes / sizeof *sizes; m++) {
            char *other = spool_new(sizes[k]);
            memcpy(other, text, sizes[k] + 1);
            memset(other - SPOOL_HEAD, 'h', SPOOL_HEAD);
            other = spool_resize(other, sizes[m]);
            CHECK(other && wrong(other, sizes[k] < sizes[m] ? sizes[k] : sizes[m]) == 0, "from %zu to %zu", sizes[k], sizes[m]);
            CHECK(other[-1] == 'h' && other[-SPOOL_HEAD] == 'h');
            if (sizes[m] > sizes[k])
                fill(other, sizes[k], sizes[m]);
            CHECK(wrong(other, sizes[m]) == 0);
            spool_free(other);
        }
        spool_free(text);
    }
    CHECK(files() == before, "no file stays open");
    char *settled = spool_new(2 * SPOOL_LONG);
    fill(settled, 0, 2 * SPOOL_LONG);
    spool_settle(settled);
    CHECK(files() == before && wrong(settled, 2 * SPOOL_LONG) == 0, "settled: no descriptor");
    settled = spool_resize(settled, 3 * SPOOL_LONG);
    CHECK(settled && wrong(settled, 2 * SPOOL_LONG) == 0);
    spool_settle(settled);
    settled = spool_resize(settled, SPOOL_LONG);
    CHECK(settled && wrong(settled, SPOOL_LONG) == 0);
    spool_free(settled);
    CHECK(files() == before);
    CHECK(!spool_new(SIZE_MAX - 5), "more than there can be");
    spool_free(NULL);
}

/* What rests comes back as it was; what is no text of ours, or beside one, is not touched. */
static void rests(void)
{
    enum { LENGTH = 64 << 20 };
    char *text = spool_new(LENGTH), *own = malloc(LENGTH / 8), *other = spool_new(2 * SPOOL_LONG);
    long begin = resident(), most = 0;
    for (size_t at = 0; at < LENGTH; at += SPOOL_STEP) {
        fill(text, at, at + SPOOL_STEP);
        spool_rest(text + at, SPOOL_STEP);
        long now = resident() - begin;
        most = now > most ? now : most;
    }
    CHECK(most < LENGTH / 1024 / 4, "%ld KiB of %d in the process", most, LENGTH / 1024);
    CHECK(wrong(text, LENGTH) == 0);
    unsigned char whole[DIGEST_BYTES], pieces[DIGEST_BYTES];
    struct digest_run d;
    digest_kept(whole, "id", text, LENGTH);
    digest_begin(&d, "id");
    digest_add(&d, text, 12345);
    digest_add(&d, text + 12345, LENGTH - 12345);
    digest_end(&d, pieces);
    CHECK(memcmp(whole, pieces, sizeof whole) == 0 && wrong(text, LENGTH) == 0);
    fill(own, 0, LENGTH / 8);
    fill(other, 0, 2 * SPOOL_LONG);
    spool_rest(own, LENGTH / 8);
    spool_rest(other + 100, 50);
    spool_rest(other + 1000, 2 * SPOOL_LONG - 1000);
    spool_rest(other - SPOOL_HEAD, (size_t)1 << 40);
    CHECK(wrong(own, LENGTH / 8) == 0 && wrong(other, 2 * SPOOL_LONG) == 0);
    spool_free(text);
    spool_free(other);
    free(own);
}

/* A long value is skipped with few of its pages in the process. */
static void scans(void)
{
    enum { LENGTH = 32 << 20 };
    char *text = spool_new(LENGTH);
    for (size_t at = 0; at < LENGTH; at += SPOOL_STEP) {
        for (size_t i = at; i < at + SPOOL_STEP; i++)
            text[i] = i % 8 == 7 ? ',' : '1';
        spool_rest(text + at, SPOOL_STEP);
    }
    memcpy(text, "{\"a\":[", 6);
    memcpy(text + LENGTH - 9, "1],\"b\":2}", 9);
    long begin = resident();
    struct slice b = scan_member((struct slice){ text, LENGTH }, "b");
    CHECK(b.len == 1 && *b.at == '2');
    CHECK(resident() - begin < LENGTH / 1024 / 4, "%ld KiB", resident() - begin);
    spool_free(text);
}

static void *reader(void *text)
{
    size_t bad = 0;
    for (int turn = 0; turn < 3; turn++)
        bad += wrong(text, 4 * SPOOL_LONG);
    return (void *)bad;
}

/* Others read what one lets rest. */
static void shared(void)
{
    pthread_t thread[2];
    void *bad;
    char *text = spool_new(4 * SPOOL_LONG);
    fill(text, 0, 4 * SPOOL_LONG);
    for (int i = 0; i < 2; i++)
        CHECK(pthread_create(&thread[i], NULL, reader, text) == 0);
    for (int i = 0; i < 200; i++) {
        spool_rest(text, 4 * SPOOL_LONG);
        spool_free(spool_new(SPOOL_LONG));
    }
    for (int i = 0; i < 2; i++) {
        pthread_join(thread[i], &bad);
        CHECK(!bad);
    }
    spool_free(text);
}

static int left(void)
{
    int n = 0;
    DIR *d = opendir(folder);
    for (const struct dirent *e; d && (e = readdir(d));)
        n += e->d_name[0] != '.';
    if (d)
        closedir(d);
    return n;
}

int main(void)
{
    lengths();                          /* all in memory: no folder was told */
    CHECK(mkdtemp(folder));
    spool_folder(folder);
    lengths();
    rests();
    scans();
    shared();
    char *text = spool_new(SPOOL_LONG);
    CHECK(text && left() == 0, "a file without a name");
    spool_free(text);
    CHECK(left() == 0);
    spool_folder("/nowhere/at/all");    /* then it is in memory */
    lengths();
    spool_folder(NULL);
    rmdir(folder);
    return CHECK_END();
}
