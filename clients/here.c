/* Solving in process: the library's face, nothing more. */
#include "exec.h"
#include "here_team.h"
#include "json_scan.h"
#include "problem.h"
#include "progress.h"
#include "run.h"
#include "solve.h"

#include <signal.h>
#include <stdio.h>
#include <string.h>
#include <unistd.h>

#include "error.h"

/* Bytes of machine code of formulas. */
static const size_t CODE = 4 << 20;

static void describe(const struct sga_error *err, char *out, size_t size)
{
    int n = snprintf(out, size, "%s", sga_code_text(err->code));
    if (*err->pointer && n < (int)size)
        n += snprintf(out + n, size - (size_t)n, " at %s", err->pointer);
    if (err->line > 0 && n < (int)size)
        n += snprintf(out + n, size - (size_t)n, ", line %d, column %d", err->line, err->column);
    if (n < (int)size)
        snprintf(out + n, size - (size_t)n, ": %s", *err->detail ? err->detail : sga_code_title(err->code));
}

static void tell(const struct sga_error *err, struct answer *a)
{
    struct sga_json w;
    describe(err, a->problem, sizeof a->problem);
    sga_buf_clear(&a->text);
    sga_json_begin(&w, &a->text);
    problem_write(&w, err);
}

struct stuck {
    struct answer *answer;
    void (*tell)(const struct answer *a);
    struct progress shown;
    struct sga_team *team;           /* or NULL */
};

static void told(void *ctx, const char *stage, double fraction, double t)
{
    (void)t;
    struct stuck *s = ctx;
    if (s->team && s->team->member)
        return;
    progress_show(&s->shown, stage, fraction);
}

/* It is asked often, which keeps the line alive between the stages. */
static bool cancelled(void *ctx)
{
    struct stuck *s = ctx;
    if (!s->team || !s->team->member)
        progress_again(&s->shown);
    return false;
}

/* Memory or time ended inside a library call that cannot be left. */
static void wall(void *ctx, const struct sga_error *err)
{
    struct stuck *s = ctx;
    if (s->team && s->team->member)
        _exit(1);                    /* what it had is made by the others */
    progress_end(&s->shown);
    tell(err, s->answer);
    s->tell(s->answer);
    _exit(1);
}

/* For a call that neither ends nor allocates: what is to be said when the alarm comes, made
 * beforehand, because little may be done in a handler. The daemon kills its child instead. */
static struct sga_buf late_line, late_object;
static const double DEFAULT_SECONDS = 30, GRACE_SECONDS = 10;

static void too_late(int number)
{
    (void)number;
    ssize_t ignored = write(STDERR_FILENO, late_line.data, late_line.len);
    if (late_object.len)
        ignored = write(STDOUT_FILENO, late_object.data, late_object.len);
    (void)ignored;
    _exit(1);
}

static void set_alarm(const char *request, size_t length, bool readable, bool shown)
{
    struct slice limits = scan_member(scan_value(request, request + length), "limits");
    double seconds = scan_number(scan_member(limits, "seconds"), DEFAULT_SECONDS);
    struct sga_error err = { .code = SGA_E_LIMIT_SECONDS };
    struct answer a = { .readable = readable };
    if (!(seconds > 0 && seconds < 1e6))
        return;
    snprintf(err.detail, sizeof err.detail, "the limit of %g seconds was reached, and %g seconds later the job had not come to "
             "an end; raise limits.seconds or ask for less in want", seconds, GRACE_SECONDS);
    tell(&err, &a);
    sga_buf_printf(&late_line, "%ssga: %s\n", shown ? "\r" : "", a.problem);       /* over the line of progress, which is shorter */
    if (!readable)
        late_object = a.text;
    else
        sga_buf_free(&a.text);
    sga_buf_puts(&late_object, readable ? "" : "\n");
    signal(SIGALRM, too_late);
    alarm((unsigned)(seconds + GRACE_SECONDS) + 1);
}

bool solve_here(const char *request, size_t length, struct answer *a, void (*stuck)(const struct answer *a))
{
    struct here_team *team = here_team_new(a->processes);
    struct stuck s = { a, stuck, { .on = false }, here_team_of(team) };
    progress_begin(&s.shown);
    struct sga_run_options options = { .wall = wall, .progress = s.shown.on ? told : NULL, .cancelled = s.shown.on ? cancelled : NULL, .ctx = &s,
                                       .exec = a->interpret_only ? NULL : sga_exec_new(CODE), .team = s.team };
    struct sga_error err = { 0 };
    sga_init();
    set_alarm(request, length, a->readable, s.shown.on);
    bool ok = sga_run(request, length, &options, &a->text, &err);
    alarm(0);
    here_team_free(team);
    progress_end(&s.shown);
    sga_exec_free(options.exec);
    if (ok)
        return true;
    tell(&err, a);
    return false;
}
