/* /proc/self/stat (proc(5)), its descriptors, its limits. */
#include "process.h"

#include <dirent.h>
#include <stdio.h>
#include <string.h>
#include <sys/resource.h>
#include <time.h>
#include <unistd.h>

#include "buf.h"

/* The fields of stat that are wanted, by their numbers in proc(5); the first two end at the last ')'. */
enum { FIRST = 3, USER = 14, SYSTEM = 15, THREADS = 20, START = 22, VIRTUAL = 23, RESIDENT = 24, FIELDS = 25 };

static void put(struct sga_buf *out, const char *name, const char *type, const char *help, double value)
{
    sga_buf_printf(out, "# HELP process_%s %s\n# TYPE process_%s %s\nprocess_%s %.10g\n", name, help, name, type, name, value);
}

static bool read_stat(double field[FIELDS])
{
    char text[1024];
    FILE *f = fopen("/proc/self/stat", "re");
    size_t n = f ? fread(text, 1, sizeof text - 1, f) : 0;
    if (f)
        fclose(f);
    text[n] = 0;
    const char *p = strrchr(text, ')');
    if (!p)
        return false;
    p++;
    for (int i = FIRST; i < FIELDS; i++) {
        int used = 0;
        field[i] = 0;
        if (i == FIRST ? sscanf(p, " %*c%n", &used) != 0 : sscanf(p, " %lf%n", &field[i], &used) != 1)
            return false;
        p += used;
    }
    return true;
}

static void write_stat(struct sga_buf *out)
{
    double field[FIELDS], ticks = (double)sysconf(_SC_CLK_TCK), page = (double)sysconf(_SC_PAGESIZE);
    struct timespec day, boot;
    if (!read_stat(field))
        return;
    clock_gettime(CLOCK_REALTIME, &day);
    clock_gettime(CLOCK_BOOTTIME, &boot);
    double booted = (double)(day.tv_sec - boot.tv_sec) + 1e-9 * (double)(day.tv_nsec - boot.tv_nsec);
    put(out, "cpu_seconds_total", "counter", "Seconds of processor time used, without child processes", (field[USER] + field[SYSTEM]) / ticks);
    put(out, "resident_memory_bytes", "gauge", "Memory in use", field[RESIDENT] * page);
    put(out, "virtual_memory_bytes", "gauge", "Address space in use", field[VIRTUAL]);
    put(out, "threads", "gauge", "Threads", field[THREADS]);
    put(out, "start_time_seconds", "gauge", "When the process was started, in seconds since 1970", booted + field[START] / ticks);
}

static void write_descriptors(struct sga_buf *out)
{
    struct rlimit limit;
    DIR *folder = opendir("/proc/self/fd");
    if (folder) {
        long count = -1;       /* the folder itself is open */
        for (const struct dirent *e; (e = readdir(folder));)
            count += *e->d_name != '.';
        closedir(folder);
        put(out, "open_fds", "gauge", "Open descriptors", (double)count);
    }
    if (getrlimit(RLIMIT_NOFILE, &limit) == 0)
        put(out, "max_fds", "gauge", "Descriptors that may be open", (double)limit.rlim_cur);
}

void process_write(struct sga_buf *out)
{
    write_stat(out);
    write_descriptors(out);
}
