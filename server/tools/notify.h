/* What systemd is told of the service: the protocol of sd_notify(3), which is one datagram to the
 * socket that NOTIFY_SOCKET names. Where there is no such variable nothing happens. */
#ifndef SERVER_NOTIFY_H
#define SERVER_NOTIFY_H

/* Lines NAME=VALUE with \n between, formed as by printf; 512 bytes at most. It does not wait: what
 * cannot be sent at once is lost. */
void notify(const char *fmt, ...) __attribute__((format(printf, 1, 2)));

/* Seconds between two signs of life (`WATCHDOG=1`): half of what WATCHDOG_USEC allows. 0: nobody
 * wants them, as where WATCHDOG_PID names another process. */
double notify_watchdog(void);

/* The clock that RELOADING=1 goes with, in microseconds. */
unsigned long long notify_clock(void);

#endif
