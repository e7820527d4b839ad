/* Framing: what is handed on and what is refused, the same however the bytes are cut; random chunks decode to what was put in. */
#include "check.h"
#include "error.h"
#include "framing.h"

#include <string.h>

enum { MOST = 65536 };

struct outcome {
    bool ok;
    size_t kept;
    unsigned long heads;
    enum sga_code code;
    char text[MOST];
};

/* Fed in pieces of that size; 0: of random sizes. */
static void feed(const char *bytes, size_t n, size_t piece, struct outcome *o)
{
    struct framing f;
    struct sga_error err = { 0 };
    static char part[MOST];
    framing_init(&f);
    o->kept = 0;
    o->ok = true;
    for (size_t at = 0; at < n && o->ok;) {
        size_t k = piece ? piece : 1 + (size_t)rand() % 40, kept;
        k = k < n - at ? k : n - at;
        memcpy(part, bytes + at, k);
        o->ok = framing_take(&f, part, k, &kept, &err);
        CHECK(kept <= k);
        memcpy(o->text + o->kept, part, kept);
        o->kept += kept;
        at += k;
    }
    o->heads = f.heads;
    o->code = err.code;
}

static struct outcome whole, cut;

static void cuts_agree(const char *bytes, size_t n)
{
    static const size_t pieces[] = { 1, 2, 3, 7, 0, 0 };
    feed(bytes, n, n ? n : 1, &whole);
    for (size_t i = 0; i < sizeof pieces / sizeof *pieces; i++) {
        feed(bytes, n, pieces[i], &cut);
        CHECK(cut.ok == whole.ok && cut.kept == whole.kept && cut.heads == whole.heads && cut.code == whole.code
              && memcmp(cut.text, whole.text, whole.kept) == 0, "pieces of %zu: %.200s", pieces[i], bytes);
    }
}

#define H "Host: a\r\n"
#define GET "GET / HTTP/1.1\r\n" H "\r\n"
#define POST "POST /v1/jobs HTTP/1.1\r\n" H
#define CHUNKED POST "Transfer-Encoding: chunked\r\n\r\n"

static void accepted(void)
{
    static const struct { const char *in, *out; unsigned long heads; } good[] = {
        { GET, GET, 1 },
        { GET GET GET, GET GET GET, 3 },
        { "\r\n" GET "\r\n" GET, GET GET, 2 },
        { "GET / HTTP/1.0\r\n\r\n", "GET / HTTP/1.0\r\n\r\n", 1 },
        { "OPTIONS * HTTP/1.1\r\n" H "\r\n", "OPTIONS * HTTP/1.1\r\n" H "\r\n", 1 },
        { "GET http://a/b?c=%41 HTTP/1.1\r\n" H "\r\n", "GET http://a/b?c=%41 HTTP/1.1\r\n" H "\r\n", 1 },
        { "GET / HTTP/1.1\r\nhOST:\t a\r\nX-\x41: b \xc3\xa9\t\r\nEmpty:\r\n\r\n", "GET / HTTP/1.1\r\nhOST:\t a\r\nX-\x41: b \xc3\xa9\t\r\nEmpty:\r\n\r\n", 1 },
        { POST "Content-Length: 2\r\n\r\n{}" GET, POST "Content-Length: 2\r\n\r\n{}" GET, 2 },
        { POST "Content-Length:0\r\n\r\n" GET, POST "Content-Length:0\r\n\r\n" GET, 2 },
        { POST "Content-Length: 4\r\n\r\n\r\n\r\n" GET, POST "Content-Length: 4\r\n\r\n\r\n\r\n" GET, 2 },
        { CHUNKED "2\r\n{}\r\n0\r\n\r\n" GET, CHUNKED "2\r\n{}\r\n0\r\n\r\n" GET, 2 },
        { CHUNKED "00A\r\n0123456789\r\n000\r\n\r\n", CHUNKED "00A\r\n0123456789\r\n000\r\n\r\n", 1 },
        { CHUNKED "2;a=b;c=\"x\\\";\";d\r\n{}\r\n0;e\r\n\r\n" GET, CHUNKED "2\r\n{}\r\n0\r\n\r\n" GET, 2 },
        { CHUNKED "2 \t; a = b\r\n{}\r\n0\r\n\r\n" GET, CHUNKED "2\r\n{}\r\n0\r\n\r\n" GET, 2 },
        { CHUNKED "2\r\n\r\n\r\n0\r\nContent-Length: 3\r\nX:\r\n\r\n" GET, CHUNKED "2\r\n\r\n\r\n0\r\n\r\n" GET, 2 },
        { POST "transfer-ENCODING:cHuNkEd\r\n\r\n0\r\n\r\n" GET, POST "transfer-ENCODING:cHuNkEd\r\n\r\n0\r\n\r\n" GET, 2 },
        { "HEAD / HTTP/1.1\r\n" H "Transfer-Encodings: x\r\nContent-Length-2: x\r\nContent_Length: x\r\n\r\n",
          "HEAD / HTTP/1.1\r\n" H "Transfer-Encodings: x\r\nContent-Length-2: x\r\nContent_Length: x\r\n\r\n", 1 },
    };
    for (size_t i = 0; i < sizeof good / sizeof *good; i++) {
        cuts_agree(good[i].in, strlen(good[i].in));
        CHECK(whole.ok && whole.heads == good[i].heads && whole.kept == strlen(good[i].out) && memcmp(whole.text, good[i].out, whole.kept) == 0,
              "accepted %zu: %.*s", i, (int)whole.kept, whole.text);
    }
}

/* What is refused, and how much of it, from the end, may not be handed on at the least. */
static void refused(void)
{
#define R(text, code) { text, sizeof text - 1, code }
#define BAD(text) R(text, SGA_E_BAD_REQUEST)
    static const struct { const char *in; size_t n; enum sga_code code; } bad[] = {
        BAD("\r\n\r\n" GET), BAD("\n" GET), BAD(" " GET), BAD("G\xc3T / HTTP/1.1\r\n"), BAD("GET  / HTTP/1.1\r\n"), BAD("GET\t/ HTTP/1.1\r\n"),
        BAD("GET /\r\n"), BAD("GET / HTTP/1.1\n"), BAD("GET / HTTP/1.1 \r\n"), BAD("GET / http/1.1\r\n"), BAD("GET / HTTP/1.11\r\n"), BAD("GET / HTTP/1.x\r\n"),
        BAD("GET /\x01 HTTP/1.1\r\n"), BAD("GET /\xc3 HTTP/1.1\r\n"), BAD("GET /%0 HTTP/1.1\r\n"), BAD("GET /%zz HTTP/1.1\r\n"), BAD("GET /a%00 HTTP/1.1\r\n"),
        BAD("GET /#a HTTP/1.1\r\n"), BAD("GET a HTTP/1.1\r\n"), BAD("GET a:80 HTTP/1.1\r\n"), BAD("GET *a HTTP/1.1\r\n"), BAD("AAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAA / HTTP/1.1\r\n"),
        BAD("GET / HTTP/1.1\r\nHost : a\r\n\r\n"), BAD("GET / HTTP/1.1\r\n" H " x: y\r\n\r\n"), BAD("GET / HTTP/1.1\r\n: y\r\n" H "\r\n"), BAD("GET / HTTP/1.1\r\n:\r\n" H "\r\n"),
        BAD("GET / HTTP/1.1\r\n" H "x\r\n\r\n"), BAD("GET / HTTP/1.1\r\n" H "x: a\nb: c\r\n\r\n"), BAD("GET / HTTP/1.1\r\n" H "x: a\rb\r\n\r\n"),
        BAD("GET / HTTP/1.1\r\n" H "x: a\0b\r\n\r\n"), BAD("GET / HTTP/1.1\r\n" H "x: \x7f\r\n\r\n"), BAD("GET / HTTP/1.1\r\n" H "\n"), BAD("GET / HTTP/1.1\r\n\r\n"),
        BAD("GET / HTTP/1.1\r\n" H H "\r\n"), BAD("GET / HTTP/1.0\r\n" H H "\r\n"),
        BAD(POST "Content-Length: 2\r\nContent-Length: 2\r\n\r\n{}"), BAD(POST "Content-Length: 2, 2\r\n\r\n{}"), BAD(POST "Content-Length: +2\r\n\r\n{}"),
        BAD(POST "Content-Length: -2\r\n\r\n{}"), BAD(POST "Content-Length: 0x2\r\n\r\n{}"), BAD(POST "Content-Length: 2 \r\n\r\n{}"), BAD(POST "Content-Length:\r\n\r\n{}"),
        BAD(POST "Content-Length: 9999999999999999999\r\n\r\n{}"), BAD(POST "Content-Length: 2\r\nTransfer-Encoding: chunked\r\n\r\n0\r\n\r\n"),
        BAD(POST "Transfer-Encoding: chunked\r\nContent-Length: 2\r\n\r\n0\r\n\r\n"), BAD(POST "Transfer-Encoding: gzip\r\n\r\n"), BAD(POST "Transfer-Encoding: chunked, chunked\r\n\r\n"),
        BAD(POST "Transfer-Encoding: chunked \r\n\r\n"), BAD(POST "Transfer-Encoding: chunked;q=1\r\n\r\n"), BAD(POST "Transfer-Encoding:\r\n\r\n"), BAD(POST "Transfer-Encoding: \x0b" "chunked\r\n\r\n"),
        BAD(POST "Transfer-Encoding: chunked\0\r\n\r\n"), BAD(POST "Transfer-Encoding: chunked\r\nTransfer-Encoding: chunked\r\n\r\n"),
        BAD("POST / HTTP/1.0\r\n" H "Transfer-Encoding: chunked\r\n\r\n"),
        BAD(CHUNKED "2\n{}\r\n0\r\n\r\n"), BAD(CHUNKED "2\r\n{}\n0\r\n\r\n"), BAD(CHUNKED "2\r\n{}0\r\n\r\n"), BAD(CHUNKED "2\r\n{}\r0\r\n\r\n"), BAD(CHUNKED "2\r{}\r\n0\r\n\r\n"),
        BAD(CHUNKED "\r\n"), BAD(CHUNKED " 2\r\n{}\r\n"), BAD(CHUNKED "2 \r\n{}\r\n"), BAD(CHUNKED "2 3;a\r\n{}\r\n"), BAD(CHUNKED "+2\r\n{}\r\n"), BAD(CHUNKED "-2\r\n{}\r\n"),
        BAD(CHUNKED "0x2\r\n{}\r\n"), BAD(CHUNKED "g\r\n"), BAD(CHUNKED "2g\r\n"), BAD(CHUNKED "0000000000000002\r\n{}\r\n"), BAD(CHUNKED "ffffffffffffffff\r\n"),
        BAD(CHUNKED "2;a\n\r\n{}\r\n"), BAD(CHUNKED "2;a=\"\n\"\r\n{}\r\n"), BAD(CHUNKED "2;a=\"\r\n{}\r\n"), BAD(CHUNKED "2;\x01\r\n{}\r\n"), BAD(CHUNKED "2;a\rb\r\n{}\r\n"),
        BAD(CHUNKED "0\r\n\n"), BAD(CHUNKED "0\n\r\n"), BAD(CHUNKED "0\r\n x: y\r\n\r\n"), BAD(CHUNKED "0\r\nx : y\r\n\r\n"), BAD(CHUNKED "0\r\nx: y\n\r\n"), BAD(CHUNKED "0\r\nGET / HTTP/1.1\r\n\r\n"),
        R("GET / HTTP/2.0\r\n", SGA_E_HTTP_VERSION), R("PRI * HTTP/2.0\r\n\r\nSM\r\n\r\n", SGA_E_HTTP_VERSION), R("GET / HTTP/0.9\r\n", SGA_E_HTTP_VERSION),
    };
    for (size_t i = 0; i < sizeof bad / sizeof *bad; i++) {
        cuts_agree(bad[i].in, bad[i].n);
        CHECK(!whole.ok && whole.code == bad[i].code && whole.kept < bad[i].n, "refused %zu: %s", i, bad[i].in);
    }
}

static size_t repeat(char *out, const char *text, int times)
{
    size_t n = strlen(text);
    for (int i = 0; i < times; i++)
        memcpy(out + (size_t)i * n, text, n);
    return (size_t)times * n;
}

/* front, so many times text, back: refused with the code from the first size beyond most on. */
static void size_is(const char *front, const char *text, int times, const char *back, enum sga_code code)
{
    static char b[MOST];
    size_t n = strlen(front);
    memcpy(b, front, n);
    n += repeat(b + n, text, times);
    memcpy(b + n, back, strlen(back) + 1);
    cuts_agree(b, n + strlen(back));
    CHECK(code == SGA_E_OK ? whole.ok : !whole.ok && whole.code == code, "%d times %s: %d", times, text, whole.code);
}

static void sizes(void)
{
    const char *end = " HTTP/1.1\r\n" H "\r\n", *get = "GET / HTTP/1.1\r\n" H, *last = "\r\n";
    size_is("GET /", "a", FRAMING_TARGET - 1, end, SGA_E_OK);
    size_is("GET /", "a", FRAMING_TARGET, end, SGA_E_TARGET_TOO_LONG);
    size_is("GET /?a", "&", FRAMING_PARAMETERS - 1, end, SGA_E_OK);
    size_is("GET /?a", "&", FRAMING_PARAMETERS, end, SGA_E_TARGET_TOO_LONG);
    size_is(get, "a: b\r\n", FRAMING_FIELDS - 1, last, SGA_E_OK);
    size_is(get, "a: b\r\n", FRAMING_FIELDS, last, SGA_E_HEADER_TOO_LARGE);
    size_is("GET / HTTP/1.1\r\n" H "a: ", "b", FRAMING_HEAD - 16 - 9 - 3 - 4, "\r\n\r\n", SGA_E_OK);
    size_is("GET / HTTP/1.1\r\n" H "a: ", "b", FRAMING_HEAD - 16 - 9 - 3 - 3, "\r\n\r\n", SGA_E_HEADER_TOO_LARGE);
    size_is("GET / HTTP/1.1\r\n" H "Cookie: a", ";", FRAMING_COOKIES, "\r\n\r\n", SGA_E_OK);
    size_is("GET / HTTP/1.1\r\n" H "Cookie: a", ";", FRAMING_COOKIES + 1, "\r\n\r\n", SGA_E_HEADER_TOO_LARGE);
    size_is(CHUNKED "1;", "a", FRAMING_EXTRAS - 1, "\r\nx\r\n0\r\n\r\n", SGA_E_OK);
    size_is(CHUNKED "1;", "a", FRAMING_EXTRAS, "\r\nx\r\n0\r\n\r\n", SGA_E_HEADER_TOO_LARGE);
    size_is(CHUNKED "0\r\n", "a:\r\n", FRAMING_EXTRAS, "\r\n", SGA_E_HEADER_TOO_LARGE);
}

/* -- Random bodies, cut into random chunks with random extras; and what is handed on, decoded by another reader -- */

static size_t decode(const char *in, size_t n, char *out)
{
    const char *p = strstr(in, "\r\n\r\n") + 4;
    size_t got = 0, size;
    char *end;
    while ((size = strtoul(p, &end, 16)) > 0) {
        CHECK(memcmp(end, "\r\n", 2) == 0);
        memcpy(out + got, end + 2, size);
        got += size;
        p = end + 2 + size + 2;
        CHECK(memcmp(p - 2, "\r\n", 2) == 0);
    }
    CHECK(memcmp(end, "\r\n\r\n", 4) == 0 && end + 4 == in + n);
    return got;
}

static void random_chunks(void)
{
    static const char *const extras[] = { "", "", ";a", ";a=b", " ; x=\"\\\" ;\" ", ";q=\"0\"" }, *const trailers[] = { "", "", "A: b\r\n", "X:\r\nHost: c\r\n" };
    static char in[MOST], body[MOST], out[MOST];
    for (int k = check_scale(2000); k > 0; k--) {
        size_t n = (size_t)sprintf(in, CHUNKED), length = 0;
        for (int c = rand() % 8; c > 0; c--) {
            size_t size = 1 + (size_t)rand() % 300;
            n += (size_t)sprintf(in + n, rand() % 2 ? "%zx%s\r\n" : "%04zX%s\r\n", size, extras[rand() % 6]);
            for (size_t i = 0; i < size; i++)
                body[length++] = in[n++] = "\r\n0;ab\0\xff"[rand() % 8];
            n += (size_t)sprintf(in + n, "\r\n");
        }
        n += (size_t)sprintf(in + n, "0%s\r\n%s\r\n", extras[rand() % 6], trailers[rand() % 4]);
        feed(in, n, 0, &cut);
        cut.text[cut.kept] = 0;
        CHECK(cut.ok && cut.heads == 1);
        CHECK(decode(cut.text, cut.kept, out) == length && memcmp(out, body, length) == 0);
        in[(size_t)rand() % n] = "\r\n 0:;\0x"[rand() % 8];         /* whatever that makes of it, cuts do not matter */
        if (k % 10 == 0)
            cuts_agree(in, n);
    }
}

int main(void)
{
    srand((unsigned)check_seed(1));
    accepted();
    refused();
    sizes();
    random_chunks();
    return CHECK_END();
}
