/* What there is to say of a request before it runs: what is wrong with it, names that nothing uses, how many equations stand for
 * how many unknowns. Reading alone: no rank is asked for. */
#include "run.h"

#include "budget.h"
#include "problem.h"
#include "request.h"
#include "run_job.h"
#include "warnings.h"
#include "write.h"

/* The form `operator` keeps no rows: its matrices are square. */
static void count(const struct job *j, int *equations, int *unknowns)
{
    const struct request *r = j->request;
    if (r->op.has)
        *equations = *unknowns = r->op.unknowns;
    else
        answer_count_given(j, equations, unknowns);
}

/* Rows that the run makes, or that constraints in velocities become, are not there to be counted. */
static bool counted(const struct request *r)
{
    return r->op.has || (r->system.rows > 0 && !r->hamiltonian && !r->mechanical);
}

static const char *plural(int n)
{
    return n == 1 ? "" : "s";
}

static void warn_count(const struct job *j, int equations, int unknowns)
{
    if (equations < unknowns)
        sga_warn(j->budget, SGA_W_FEWER_EQUATIONS, "/system", "%d equation%s for %d unknown%s: some stay free, unless their consequences determine them",
                 equations, plural(equations), unknowns, plural(unknowns));
    if (equations > unknowns)
        sga_warn(j->budget, SGA_W_MORE_EQUATIONS, "/system", "%d equation%s for %d unknown%s: some follow from the others, or they contradict each other",
                 equations, plural(equations), unknowns, plural(unknowns));
}

static void write_problems(const struct request_faults *f, struct sga_json *w)
{
    sga_json_key(w, "problems");
    sga_json_array(w);
    for (int i = 0; i < f->count; i++)
        problem_write(w, &f->list[i]);
    sga_json_end_array(w);
}

static void write_number(struct sga_json *w, const char *key, bool known, int n)
{
    sga_json_key(w, key);
    if (known)
        sga_json_int(w, n);
    else
        sga_json_null(w);
}

/* What was read: j->request stands. */
static void write_system(struct job *j, struct sga_json *w, bool stands)
{
    int equations = 0, unknowns = 0;
    bool known = stands && counted(j->request);
    if (stands)
        answer_warn_unused(j);
    if (known) {
        count(j, &equations, &unknowns);
        warn_count(j, equations, unknowns);
    }
    sga_json_key(w, "warnings");
    sga_warnings_write(j->warnings, w);
    sga_json_key(w, "form");
    if (j->request->form)
        sga_json_string(w, j->request->form);
    else
        sga_json_null(w);
    if (stands)
        answer_write_variables(j, w);
    else
        sga_json_key(w, "variables"), sga_json_null(w);
    write_number(w, "equations", known, equations);
    write_number(w, "unknowns", known, unknowns);
}

void sga_review(const char *request, size_t length, struct sga_buf *out)
{
    struct request r;
    struct request_faults faults;
    struct request_bounds bounds = { .seconds = REQUEST_CHECK_SECONDS, .nodes = REQUEST_CHECK_NODES };
    struct sga_warnings warnings = { 0 };
    struct sga_budget budget = { .warnings = &warnings };
    struct job j = { .request = &r, .warnings = &warnings, .budget = &budget };
    struct sga_json w;
    bool good = request_read_all(&r, request, length, &bounds, &faults), stands = good && !bounds.met;
    if (faults.cut)
        sga_limit_met(&budget, SGA_LIMIT_FAULTS);
    sga_json_begin(&w, out);
    sga_json_object(&w);
    sga_json_key(&w, "valid");
    if (good && bounds.met)
        sga_json_null(&w);
    else
        sga_json_bool(&w, good);
    write_problems(&faults, &w);
    write_system(&j, &w, stands);
    sga_json_end_object(&w);
    sga_warnings_clear(&warnings);
    request_faults_clear(&faults);
    if (stands)
        request_clear(&r);
}
