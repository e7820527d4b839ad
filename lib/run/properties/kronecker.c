/* The member `kronecker`: exact structure of the pencil s A - B, generic where parameters are symbolic. */
#include "kronecker.h"

#include <assert.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "budget.h"
#include "buf.h"
#include "error.h"
#include "kronecker_reduced.h"
#include "pencil.h"
#include "run_job.h"
#include "reduction.h"
#include "request.h"
#include "system.h"

static void write_list(struct sga_json *w, const char *key, const int *v, int n)
{
    if (key)
        sga_json_key(w, key);
    sga_json_array(w);
    for (int i = 0; i < n; i++)
        sga_json_int(w, v[i]);
    sga_json_end_array(w);
}

/* Coefficients [a0, a1, ...] as exact texts. */
static void write_poly(struct sga_json *w, const fmpz_poly_t f)
{
    sga_json_array(w);
    for (slong i = 0; i < fmpz_poly_length(f); i++) {
        char *s = fmpz_get_str(NULL, 10, f->coeffs + i);
        sga_json_string(w, s);
        flint_free(s);
    }
    sga_json_end_array(w);
}

static void write_number(struct sga_json *w, const char *text)
{
    sga_json_raw(w, text, strlen(text));
}

static void write_eigenvalues(struct sga_json *w, const struct pencil_structure *s, const struct pencil_eigenvalue *e, int n)
{
    sga_json_key(w, "eigenvalues");
    sga_json_array(w);
    for (int i = 0; i < n; i++) {
        assert(e[i].factor >= 0 && e[i].factor < s->factors);
        sga_json_array(w);
        write_number(w, e[i].re);
        write_number(w, e[i].im);
        sga_json_int(w, s->factor[e[i].factor].multiplicity);
        sga_json_end_array(w);
    }
    sga_json_end_array(w);
    sga_json_key(w, "jordan");
    sga_json_array(w);
    for (int i = 0; i < n; i++)
        write_list(w, NULL, s->factor[e[i].factor].block, s->factor[e[i].factor].blocks);
    sga_json_end_array(w);
}

static void write_polynomials(struct sga_json *w, const struct pencil_structure *s)
{
    fmpz_poly_t f;
    fmpz_poly_init(f);
    sga_json_key(w, "invariant_factors");
    sga_json_array(w);
    for (int k = pencil_invariant_factors(s) - 1; k >= 0; k--) {
        pencil_invariant_factor(s, k, f);
        write_poly(w, f);
    }
    sga_json_end_array(w);
    fmpz_poly_clear(f);
    sga_json_key(w, "factors");
    sga_json_array(w);
    for (int i = 0; i < s->factors; i++) {
        sga_json_object(w);
        sga_json_key(w, "polynomial");
        write_poly(w, s->factor[i].f);
        sga_json_member_int(w, "multiplicity", s->factor[i].multiplicity);
        write_list(w, "blocks", s->factor[i].block, s->factor[i].blocks);
        sga_json_end_object(w);
    }
    sga_json_end_array(w);
}

struct spectrum {
    struct pencil_eigenvalue *value; int count;
    const char *missing;       /* why there are no eigenvalues, or NULL */
};

static void write_structure(struct sga_json *w, const struct pencil_structure *s, const struct spectrum *e, const char *basis)
{
    sga_json_object(w);
    sga_json_member_bool(w, "regular", s->regular);
    sga_json_member_int(w, "normal_rank", s->normal_rank);
    sga_json_member_int(w, "finite", s->finite);
    if (!e->missing) {
        write_eigenvalues(w, s, e->value, e->count);
        write_polynomials(w, s);
    } else {
        sga_json_key(w, "eigenvalues");
        sga_json_null(w);
        sga_json_member_string(w, "reason", e->missing);
    }
    write_list(w, "infinite", s->infinite, s->infinites);
    sga_json_member_int(w, "nilpotency", s->nilpotency);
    write_list(w, "right", s->right, s->rights);
    write_list(w, "left", s->left, s->lefts);
    sga_json_member_string(w, "basis", basis);
    sga_json_member_int(w, "primes", s->primes);
    sga_json_end_object(w);
}

static const char *basis_text(const struct pencil_structure *s)
{
    return s->basis == PENCIL_PROVED ? "proved" : "modular";
}

/* Past its share of the time eigenvalues are left out, past its size the whole structure; either
 * with a reason, and the rest of the answer is given. */
enum { SHARE_PERCENT = 60 };

static struct sga_budget share_of(const struct sga_budget *all)
{
    struct sga_budget b = *all;
    if (b.deadline > 0) {
        b.seconds = (b.deadline - sga_now()) * SHARE_PERCENT / 100;
        b.deadline = sga_now() + b.seconds;
    }
    return b;
}

static bool left_out(struct job *j, struct kronecker_system *k, const struct sga_error *err)
{
    if (err->code == SGA_E_LIMIT_VARIABLES) {
        snprintf(k->reason, sizeof k->reason, "%.480s", err->detail);
        return true;
    }
    if (j->err->code == SGA_E_OK)
        *j->err = *err;
    return false;
}

static const char *const TOO_LONG = "the eigenvalues were not found within their share of the time; raise limits.seconds";

/* A few primes tell the indices when the spectrum took too long. */
static bool write_without_spectrum(struct job *j, struct kronecker_system *k, const struct pencil *p, struct sga_json *w)
{
    struct pencil_structure s;
    struct pencil_options options = { .budget = j->budget, .max_work = 1 };
    struct spectrum e = { .missing = TOO_LONG };
    struct sga_error err = { 0 };
    if (!pencil_structure(p, &options, &s, &err))
        return left_out(j, k, &err);
    write_structure(w, &s, &e, kronecker_shown(j, p, &s) ? "proved" : basis_text(&s));
    pencil_structure_clear(&s);
    return true;
}

/* Of a pencil that is too large for its determinant what the reduction shows. False: nothing. */
static bool write_large(struct job *j, const struct pencil *p, struct sga_json *w)
{
    struct pencil_structure s;
    char why[160];
    struct spectrum e = { .missing = why };
    if ((p->rows <= PENCIL_MAX && p->cols <= PENCIL_MAX) || !kronecker_reduced(j, p, &s))
        return false;
    snprintf(why, sizeof why, "the matrix pencil has %d rows and %d columns; its eigenvalues are computed for at most %d of each", p->rows, p->cols, PENCIL_MAX);
    write_structure(w, &s, &e, basis_text(&s));
    pencil_structure_clear(&s);
    return true;
}

static bool write_exact(struct job *j, struct kronecker_system *k, const struct pencil *p, struct sga_json *w)
{
    if (write_large(j, p, w))
        return true;
    struct pencil_structure s;
    struct sga_budget budget = share_of(j->budget);
    struct sga_error err = { 0 };
    struct pencil_options options = { .spectrum = true, .budget = &budget };
    struct spectrum e = { .missing = NULL };
    bool ok = pencil_structure(p, &options, &s, &err);
    if (ok && s.no_spectrum) {
        e.missing = TOO_LONG;
        write_structure(w, &s, &e, kronecker_shown(j, p, &s) ? "proved" : basis_text(&s));
    } else if (ok && pencil_eigenvalues(&s, j->request->accuracy.rtol, &budget, &e.value, &e.count, &err)) {
        write_structure(w, &s, &e, basis_text(&s));
        pencil_eigenvalues_clear(e.value, e.count);
    }
    if (ok)
        pencil_structure_clear(&s);
    if (err.code == SGA_E_LIMIT_SECONDS && job_goes_on(j))
        return write_without_spectrum(j, k, p, w);
    return err.code == SGA_E_OK || left_out(j, k, &err);
}

/* The more generic of two structures of one pencil has the larger rank, and then the smaller
 * regular part; what they may differ in beyond that has probability about size / 2^40. */
static int generic_size(const struct pencil_structure *s)
{
    int infinite = 0;
    for (int i = 0; i < s->infinites; i++)
        infinite += s->infinite[i];
    return s->normal_rank * 4096 - s->finite - infinite;
}

static bool better(const struct pencil_structure *a, const struct pencil_structure *b)
{
    int x = generic_size(a), y = generic_size(b);
    return x > y || (x == y && a->nilpotency < b->nilpotency);
}

/* Symbolic parameters: at random integers of 40 bits a rank is generic but with probability about
 * degree / 2^40 (Schwartz, Zippel), and is never too large; the best of three is taken. */
static bool write_generic(struct job *j, struct kronecker_system *k, struct sga_json *w)
{
    struct sga_error err = { 0 };
    struct pencil_options options = { .budget = j->budget };
    struct spectrum e = { .missing = "the eigenvalues depend on symbolic parameters; give the parameters values" };
    struct pencil_structure best = { 0 };
    int n = j->request->system.parameters, found = 0;
    fmpz *value = _fmpz_vec_init(n);
    flint_rand_t random;
    bool ok = true;
    flint_randinit(random);
    for (int tries = 0; tries < 3 && ok; tries++) {
        struct pencil p;
        struct pencil_structure s;
        for (int i = 0; i < n; i++)
            fmpz_set_ui(value + i, (1UL << 40) + n_randbits(random, 40));
        if (!kronecker_pencil(j, k, value, &p))
            break;
        ok = pencil_structure(&p, &options, &s, &err);
        pencil_clear(&p);
        if (ok && (!found++ || better(&s, &best))) {
            struct pencil_structure t = best;
            best = s;
            s = t;
        }
        if (ok)
            pencil_structure_clear(&s);
    }
    if (ok && found) {
        k->reason[0] = 0;              /* of a later try only */
        write_structure(w, &best, &e, "generic");
    }
    pencil_structure_clear(&best);
    flint_randclear(random);
    _fmpz_vec_clear(value, n);
    return ok || left_out(j, k, &err);
}

static bool depends_on_parameters(struct job *j, const struct kronecker_system *k)
{
    const struct expr_store *st = &j->request->store;
    for (int i = 0; i < k->count; i++)
        if (j->request->system.parameters && !expr_is_const(st, k->c[i].value))
            return true;
    return false;
}

bool kronecker_text(struct job *j, char **text, bool *has)
{
    assert(!*text);                           /* the member is written once */
    struct sga_buf out = { 0 };
    struct kronecker_system k;
    struct sga_json json, *w = &json;
    bool ok = true;
    sga_json_begin(w, &out);
    kronecker_read(j, &k);
    if (!k.reason[0] && depends_on_parameters(j, &k)) {
        ok = write_generic(j, &k, w);
    } else if (!k.reason[0]) {
        struct pencil p;
        fmpz *none = _fmpz_vec_init(j->request->system.parameters);
        if (kronecker_pencil(j, &k, none, &p))
            ok = write_exact(j, &k, &p, w);
        pencil_clear(&p);
        _fmpz_vec_clear(none, j->request->system.parameters);
    }
    *has = !k.reason[0];
    if (ok && !*has) {
        sga_json_object(w);
        sga_json_member_string(w, "reason", k.reason);
        sga_json_end_object(w);
    }
    kronecker_system_clear(&k);
    *text = sga_buf_take(&out);
    return ok;
}
