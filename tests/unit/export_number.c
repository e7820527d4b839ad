/* Exact rationals as literals: what is read back is the nearest double, decimals keep their digits, what is no double is refused. */
#include <math.h>
#include <string.h>

#include "buf.h"
#include "check.h"
#include "number.h"
#include "operators.h"

/* The text of a rational; "" where it is refused. The caller frees it. */
static char *text_of(const char *rational, int *binds)
{
    struct sga_buf b = { 0 };
    fmpq_t q;
    fmpq_init(q);
    CHECK(fmpq_set_str(q, rational, 10) == 0);
    bool ok = export_number(q, &b, binds);
    CHECK(ok == (b.len > 0));
    fmpq_clear(q);
    return sga_buf_take(&b);
}

static void texts(void)
{
    static const struct { const char *rational, *text; int binds; } known[] = {
        { "0", "0.0", BINDS_ALL }, { "7", "7.0", BINDS_ALL }, { "-7", "-7.0", BINDS_SIGN }, { "981/100", "9.81", BINDS_ALL },
        { "1/10", "0.1", BINDS_ALL }, { "-1/400", "-0.0025", BINDS_SIGN }, { "1/3", "1.0/3.0", BINDS_PRODUCT },
        { "-2/7", "-2.0/7.0", BINDS_PRODUCT }, { "1/10000000000000000000000000", "0.0000000000000000000000001", BINDS_ALL },
        { "12345678901234567890123/1000", "12345678901234567890.123", BINDS_ALL },
    };
    for (size_t i = 0; i < sizeof known / sizeof *known; i++) {
        int binds;
        char *text = text_of(known[i].rational, &binds);
        CHECK(strcmp(text, known[i].text) == 0, "%s is %s", known[i].rational, text);
        CHECK(binds == known[i].binds, "%s", known[i].rational);
        free(text);
    }
}

/* (2^80 + 1) / 3^60 and its like: neither decimal nor a quotient of doubles. */
static void nearest(void)
{
    for (int k = 60; k < 400; k += 17) {
        struct sga_buf b = { 0 };
        fmpq_t q;
        int binds;
        fmpq_init(q);
        fmpz_set_ui(fmpq_numref(q), 2);
        fmpz_pow_ui(fmpq_numref(q), fmpq_numref(q), (ulong)k + 20);
        fmpz_add_ui(fmpq_numref(q), fmpq_numref(q), 1);
        fmpz_set_ui(fmpq_denref(q), 3);
        fmpz_pow_ui(fmpq_denref(q), fmpq_denref(q), (ulong)k);
        fmpq_canonicalise(q);
        double d = fmpq_get_d(q);          /* towards zero, so that the nearest is it or the next */
        CHECK(export_number(q, &b, &binds));
        double read = strtod(b.data, NULL);
        CHECK(read == d || read == nextafter(d, INFINITY), "%s", b.data);
        fmpq_clear(q);
        sga_buf_free(&b);
    }
}

static void refused(void)
{
    struct sga_buf b = { 0 };
    fmpq_t q;
    int binds;
    fmpq_init(q);
    fmpz_set_ui(fmpq_numref(q), 10);
    fmpz_pow_ui(fmpq_numref(q), fmpq_numref(q), 400);
    fmpz_one(fmpq_denref(q));
    CHECK(!export_number(q, &b, &binds) && b.len == 0);
    fmpq_inv(q, q);
    CHECK(!export_number(q, &b, &binds) && b.len == 0);
    fmpq_neg(q, q);
    CHECK(!export_number(q, &b, &binds) && b.len == 0);
    fmpq_clear(q);
    sga_buf_free(&b);
}

int main(void)
{
    texts();
    nearest();
    refused();
    return CHECK_END();
}
