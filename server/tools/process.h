/* What the system says of this process, by the names that Prometheus' own clients use. */
#ifndef SERVER_PROCESS_H
#define SERVER_PROCESS_H

struct sga_buf;

/* Writes process_cpu_seconds_total, process_resident_memory_bytes, process_virtual_memory_bytes,
 * process_threads, process_open_fds, process_max_fds and process_start_time_seconds as Prometheus
 * text; what cannot be read is left out. Reads /proc/self, which needs no disk. */
void process_write(struct sga_buf *out);

#endif
