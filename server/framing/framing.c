/* The grammar of RFC 9112 (2.2, 3, 5, 6, 7.1), one byte after the other. What it lets pass by indulgence is not let pass: bare
 * line feeds, folded lines, blanks before colons. Two readers that disagree about such bytes see different requests. */
#include "framing.h"

#include <assert.h>
#include <string.h>

#include "error.h"

enum state {
    START, EMPTY_LINE,                                            /* CR LF before a request */
    METHOD, TARGET, PERCENT, PERCENT_2, VERSION, LINE_END,
    FIELD, NAME, BEFORE_VALUE, VALUE, VALUE_END, HEAD_END,
    BODY,
    SIZE_1, SIZE, SIZE_BLANK, EXTENSION, QUOTED, QUOTED_PAIR, EXTENSION_END, SIZE_END, DATA, DATA_END, DATA_END_2,
    TRAILER, TRAILER_NAME, TRAILER_VALUE, TRAILER_END, MESSAGE_END,
};
enum { SIZE_DIGITS = 15, LENGTH_DIGITS = 18, METHOD_MOST = 32 };
enum kind { OTHER, HOST, LENGTH, CODING, COOKIE };      /* of a field */

/* What a byte may be: of a token (tchar of RFC 9110, 5.6.2); of a value (visible characters, blanks, tabs, bytes from 128 on); of
 * a target, with nothing to be done about it. */
enum { TOKEN = 1, TEXT = 2, PLAIN = 4 };
#define IS_TOKEN(c) (((c) >= '0' && (c) <= '9') || ((c) >= 'A' && (c) <= 'Z') || ((c) >= '^' && (c) <= 'z') || (c) == '!' || ((c) >= '#' && (c) <= '\'') \
                     || (c) == '*' || (c) == '+' || (c) == '-' || (c) == '.' || (c) == '|' || (c) == '~')
#define IS_TEXT(c) ((c) == '\t' || ((c) >= ' ' && (c) != 0x7f))
#define IS_PLAIN(c) ((c) > ' ' && (c) < 0x7f && (c) != '#' && (c) != '%' && (c) != '?' && (c) != '&')
#define OF(c) (IS_TOKEN(c) ? TOKEN : 0) | (IS_TEXT(c) ? TEXT : 0) | (IS_PLAIN(c) ? PLAIN : 0),
#define OF_4(c) OF(c) OF(c + 1) OF(c + 2) OF(c + 3)
#define OF_16(c) OF_4(c) OF_4(c + 4) OF_4(c + 8) OF_4(c + 12)
#define OF_64(c) OF_16(c) OF_16(c + 16) OF_16(c + 32) OF_16(c + 48)
static const unsigned char class_of[256] = { OF_64(0) OF_64(64) OF_64(128) OF_64(192) };

static bool token(unsigned char c)
{
    return class_of[c] & TOKEN;
}

static bool text(unsigned char c)
{
    return class_of[c] & TEXT;
}

static int hex(unsigned char c)
{
    return c >= '0' && c <= '9' ? c - '0' : c >= 'a' && c <= 'f' ? c - 'a' + 10 : c >= 'A' && c <= 'F' ? c - 'A' + 10 : -1;
}

static bool bad(struct sga_error *err, const char *what)
{
    return sga_fail(err, SGA_E_BAD_REQUEST, "%s", what);
}

/* The first characters of a word, in lower case. */
static void keep(char *word, unsigned char *at, size_t size, unsigned char c)
{
    if (*at < size - 1)
        word[*at] = c >= 'A' && c <= 'Z' ? (char)(c + 32) : (char)c;
    if (*at < size)
        word[++*at < size ? *at : size - 1] = 0;
}

void framing_init(struct framing *f)
{
    *f = (struct framing){ .state = START };
}

bool framing_in_head(const struct framing *f)
{
    return f->state < BODY;
}

static void begin(struct framing *f)
{
    *f = (struct framing){ .state = METHOD, .heads = f->heads };
}

static bool method_done(struct framing *f)
{
    f->head_request = strcmp(f->name, "head") == 0;
    f->connect = strcmp(f->name, "connect") == 0;
    f->state = TARGET;
    f->name_at = 0;
    f->name[0] = 0;
    return true;
}

/* A path, a URL of http or https, or *: what the methods of a server that is no proxy take. */
static bool target_done(struct framing *f, struct sga_error *err)
{
    const char *t = f->name;
    if (*t != '/' && strcmp(t, "*") != 0 && strncmp(t, "http://", 7) != 0 && strncmp(t, "https://", 8) != 0 && !(f->connect && *t))
        return bad(err, "The target of a request is a path, such as /v1/jobs, or a URL.");
    f->state = VERSION;
    return true;
}

static bool target(struct framing *f, unsigned char c, struct sga_error *err)
{
    if (c == ' ')
        return target_done(f, err);
    if (c <= ' ' || c >= 0x7f || c == '#')
        return bad(err, "The target of the request holds a byte that is not allowed there; such are sent as %HH.");
    if (++f->target > FRAMING_TARGET)
        return sga_fail(err, SGA_E_TARGET_TOO_LONG, "The target of a request may have at most %d bytes.", FRAMING_TARGET);
    f->parameters += c == '?' || c == '&';
    if (f->parameters > FRAMING_PARAMETERS)
        return sga_fail(err, SGA_E_TARGET_TOO_LONG, "A query may have at most %d parameters.", FRAMING_PARAMETERS);
    keep(f->name, &f->name_at, sizeof f->name, c);
    f->state = c == '%' ? PERCENT : TARGET;
    return true;
}

static bool percent(struct framing *f, unsigned char c, struct sga_error *err)
{
    f->target++;
    keep(f->name, &f->name_at, sizeof f->name, c);
    if (hex(c) < 0)
        return bad(err, "The target of the request has a % that two hexadecimal digits do not follow.");
    if (f->state == PERCENT_2 && f->percent == '0' && c == '0')
        return bad(err, "The target of the request holds a zero byte (%00).");
    f->percent = (char)c;
    f->state = f->state == PERCENT ? PERCENT_2 : TARGET;
    return true;
}

static bool version_done(struct framing *f, struct sga_error *err)
{
    const char *v = f->value;
    bool form = strncmp(v, "http/", 5) == 0 && v[5] >= '0' && v[5] <= '9' && v[6] == '.' && v[7] >= '0' && v[7] <= '9' && !v[8];
    if (form && v[5] != '1')
        return sga_fail(err, SGA_E_HTTP_VERSION, "The versions of HTTP known are 1.1 and 1.0.");
    if (!form)
        return bad(err, "The request line does not end in HTTP/1.1.");
    f->http10 = v[7] == '0';
    f->state = LINE_END;
    return true;
}

/* One blank and eight characters, as they stand: only the letters HTTP, and these large. */
static bool version(struct framing *f, unsigned char c, struct sga_error *err)
{
    if (c == '\r')
        return version_done(f, err);
    if (c <= ' ' || c >= 0x7f || (c >= 'a' && c <= 'z') || f->value_at == 8)
        return bad(err, "The request line is not a method, a target and HTTP/1.1, with single blanks between and CR LF at its end.");
    keep(f->value, &f->value_at, sizeof f->value, c);
    return true;
}

static enum kind kind_of(const char *name)
{
    switch (*name) {
    case 'h': return strcmp(name, "host") == 0 ? HOST : OTHER;
    case 't': return strcmp(name, "transfer-encoding") == 0 ? CODING : OTHER;
    case 'c': return strcmp(name, "content-length") == 0 ? LENGTH : strcmp(name, "cookie") == 0 ? COOKIE : OTHER;
    default: return OTHER;
    }
}

static bool name_done(struct framing *f, struct sga_error *err)
{
    f->kind = (unsigned char)kind_of(f->name);
    if (f->kind == HOST && f->host)
        return bad(err, "There is more than one Host header.");
    if (f->kind == LENGTH && f->length_given)
        return bad(err, "There is more than one Content-Length header.");
    if (f->kind == CODING && f->coding_given)
        return bad(err, "The only transfer encoding known is chunked.");
    f->host |= f->kind == HOST;
    f->length_given |= f->kind == LENGTH;
    f->coding_given |= f->kind == CODING;
    f->state = BEFORE_VALUE;
    f->value_at = 0;
    f->value[0] = 0;
    return true;
}

static bool name(struct framing *f, unsigned char c, struct sga_error *err)
{
    if (c == ':')
        return name_done(f, err);
    if (!token(c))
        return bad(err, "A header name holds a character that is not allowed, such as a blank before the colon.");
    keep(f->name, &f->name_at, sizeof f->name, c);
    return true;
}

/* A line of the head begins. */
static bool field(struct framing *f, unsigned char c, struct sga_error *err)
{
    if (c == '\r') {
        f->state = HEAD_END;
        return true;
    }
    if (c == ' ' || c == '\t')
        return bad(err, "A header is continued on a line of its own, which is not allowed any more.");
    if (!token(c))
        return bad(err, "A line of the head is no header, or the line before it did not end in CR LF.");
    if (++f->fields > FRAMING_FIELDS)
        return sga_fail(err, SGA_E_HEADER_TOO_LARGE, "A request may have at most %d headers.", FRAMING_FIELDS);
    f->state = NAME;
    f->name_at = 0;
    keep(f->name, &f->name_at, sizeof f->name, c);
    return true;
}

static bool length_digit(struct framing *f, unsigned char c, struct sga_error *err)
{
    if (c < '0' || c > '9' || f->digits == LENGTH_DIGITS)
        return bad(err, "Content-Length is no number of bytes.");
    f->left = 10 * f->left + (uint64_t)(c - '0');
    f->digits++;
    return true;
}

static bool value(struct framing *f, unsigned char c, struct sga_error *err)
{
    if (f->state == BEFORE_VALUE && (c == ' ' || c == '\t'))
        return true;
    f->state = VALUE;
    if (c == '\r') {
        f->state = VALUE_END;
        return true;
    }
    if (!text(c))
        return bad(err, "A header holds a byte that is not allowed: a line ends in CR LF, and no zero stands in it.");
    switch (f->kind) {
    case LENGTH:
        return length_digit(f, c, err);
    case CODING:
        keep(f->value, &f->value_at, sizeof f->value, c);
        return true;
    case COOKIE:
        f->cookies += c == ';' || c == ',';
        return f->cookies <= FRAMING_COOKIES
            || sga_fail(err, SGA_E_HEADER_TOO_LARGE, "A request may have at most %d cookies, and none is needed.", FRAMING_COOKIES);
    default:
        return true;
    }
}

static bool value_done(struct framing *f, struct sga_error *err)
{
    if (f->kind == LENGTH && !f->digits)
        return bad(err, "Content-Length is no number of bytes.");
    if (f->kind == CODING && strcmp(f->value, "chunked") != 0)
        return bad(err, "The only transfer encoding known is chunked.");
    f->state = FIELD;
    return true;
}

/* The empty line has come: how far does the body go? */
static bool head_done(struct framing *f, struct sga_error *err)
{
    if (!f->host && !f->http10)
        return bad(err, "The Host header is missing.");
    if (f->length_given && f->coding_given)
        return bad(err, "Content-Length and Transfer-Encoding exclude each other.");
    if (f->coding_given && f->http10)
        return bad(err, "HTTP/1.0 has no Transfer-Encoding.");
    f->heads++;
    f->digits = 0;
    f->state = f->coding_given ? SIZE_1 : f->left ? BODY : START;
    return true;
}

static bool head_byte(struct framing *f, unsigned char c, struct sga_error *err)
{
    const char *line = "A line of the head does not end in CR LF.";
    assert(f->state >= METHOD && f->state < BODY);
    if (f->state > EMPTY_LINE && ++f->head > FRAMING_HEAD)
        return sga_fail(err, SGA_E_HEADER_TOO_LARGE, "The request line and the headers may have at most %d bytes.", FRAMING_HEAD);
    switch (f->state) {
    case METHOD:
        if (c == ' ' && f->name_at)
            return method_done(f);
        if (!token(c) || f->head > METHOD_MOST)
            return bad(err, "The request line does not begin with a method and a blank.");
        keep(f->name, &f->name_at, sizeof f->name, c);
        return true;
    case TARGET: return target(f, c, err);
    case PERCENT: case PERCENT_2: return percent(f, c, err);
    case VERSION: return version(f, c, err);
    case LINE_END: f->state = FIELD; return c == '\n' || bad(err, line);
    case FIELD: return field(f, c, err);
    case NAME: return name(f, c, err);
    case VALUE_END: return c == '\n' ? value_done(f, err) : bad(err, line);
    case HEAD_END: return c == '\n' ? head_done(f, err) : bad(err, line);
    default: return value(f, c, err);
    }
}

/* -- Runs of bytes about which there is nothing to decide: most of a head, and one by one they would cost several times as much.
 * Each says how many there are; what it does not take, the states above do. -- */

static size_t run_name(struct framing *f, const unsigned char *b, size_t n)
{
    size_t k = 0;
    if (f->state == FIELD && n && f->fields < FRAMING_FIELDS && token(b[0])) {
        f->fields++;
        f->state = NAME;
        f->name_at = 0;
    }
    if (f->state == NAME)
        for (; k < n && token(b[k]); k++)
            keep(f->name, &f->name_at, sizeof f->name, b[k]);
    return k;
}

static size_t run_value(struct framing *f, const unsigned char *b, size_t n)
{
    size_t k = 0;
    if (f->kind != OTHER)
        return 0;
    while (k < n && text(b[k]))
        k++;
    f->state = k ? VALUE : f->state;
    if (k + 1 >= n || b[k] != '\r' || b[k + 1] != '\n')
        return k;
    f->state = FIELD;
    return k + 2;
}

static size_t run_target(struct framing *f, const unsigned char *b, size_t n)
{
    size_t k = 0, most = FRAMING_TARGET - f->target;
    for (n = n < most ? n : most; k < n && class_of[b[k]] & PLAIN; k++)
        keep(f->name, &f->name_at, sizeof f->name, b[k]);
    f->target += (unsigned)k;
    return k;
}

static size_t run_version(struct framing *f, const unsigned char *b, size_t n)
{
    static const char usual[] = "HTTP/1.1\r\n";
    if (f->value_at || n < sizeof usual - 1 || memcmp(b, usual, sizeof usual - 1) != 0)
        return 0;
    f->state = FIELD;
    return sizeof usual - 1;
}

static size_t run(struct framing *f, const unsigned char *b, size_t n)
{
    size_t most = FRAMING_HEAD - f->head, k;
    n = n < most ? n : most;
    switch (f->state) {
    case FIELD: case NAME: k = run_name(f, b, n); break;
    case BEFORE_VALUE: case VALUE: k = run_value(f, b, n); break;
    case TARGET: k = run_target(f, b, n); break;
    case VERSION: k = run_version(f, b, n); break;
    default: return 0;
    }
    f->head += (unsigned)k;
    return k;
}

/* -- Chunks: what stands between their data. *drop: nobody else needs the byte. -- */

static bool extra(struct framing *f, struct sga_error *err)
{
    return ++f->extras <= FRAMING_EXTRAS || sga_fail(err, SGA_E_HEADER_TOO_LARGE, "Extensions of chunks and trailers may have at most %d bytes.", FRAMING_EXTRAS);
}

static bool size(struct framing *f, unsigned char c, bool *drop, struct sga_error *err)
{
    int digit = f->state == SIZE_BLANK ? -1 : hex(c);
    if (digit >= 0) {
        f->left = 16 * f->left + (uint64_t)digit;
        f->state = SIZE;
        return ++f->digits <= SIZE_DIGITS || bad(err, "The size of a chunk has more digits than there can be bytes.");
    }
    if (f->state == SIZE && c == '\r') {
        f->state = SIZE_END;
        return true;
    }
    if (f->state != SIZE_1 && (c == ' ' || c == '\t' || c == ';')) {
        f->state = c == ';' ? EXTENSION : SIZE_BLANK;
        *drop = true;
        return extra(f, err);
    }
    return bad(err, "The size of a chunk is not hexadecimal digits with CR LF behind them.");
}

static bool extension(struct framing *f, unsigned char c, bool *drop, struct sga_error *err)
{
    *drop = true;
    if (f->state == EXTENSION && c == '\r') {
        f->state = SIZE_END;
        *drop = false;
        return true;
    }
    if (!extra(f, err))
        return false;
    bool quoted = f->state != EXTENSION;
    if (quoted ? !text(c) : !token(c) && !(c && strchr(";= \t\"", c)))
        return bad(err, "An extension of a chunk holds a byte that is not allowed.");
    f->state = f->state == QUOTED_PAIR ? QUOTED : c == '"' ? (quoted ? EXTENSION : QUOTED) : quoted && c == '\\' ? QUOTED_PAIR : f->state;
    return true;
}

static bool trailer(struct framing *f, unsigned char c, bool *drop, struct sga_error *err)
{
    *drop = true;
    if (f->state == TRAILER && c == '\r') {
        f->state = MESSAGE_END;
        *drop = false;
        return true;
    }
    if (!extra(f, err))
        return false;
    if (f->state == TRAILER_VALUE && c == '\r')
        f->state = TRAILER_END;
    else if (f->state == TRAILER_NAME && c == ':')
        f->state = TRAILER_VALUE;
    else if (f->state == TRAILER_VALUE ? !text(c) : !token(c))
        return bad(err, "A trailer holds a byte that is not allowed.");
    else if (f->state == TRAILER)
        f->state = TRAILER_NAME;
    return true;
}

static bool chunk_byte(struct framing *f, unsigned char c, bool *drop, struct sga_error *err)
{
    assert(f->state > BODY && f->state != DATA);
    switch (f->state) {
    case SIZE_1: case SIZE: case SIZE_BLANK: return size(f, c, drop, err);
    case EXTENSION: case QUOTED: case QUOTED_PAIR: return extension(f, c, drop, err);
    case SIZE_END:
        f->state = f->left ? DATA : TRAILER;
        f->digits = 0;
        return c == '\n' || bad(err, "The size of a chunk does not end in CR LF.");
    case DATA_END: f->state = DATA_END_2; return c == '\r' || bad(err, "The data of a chunk do not end in CR LF.");
    case DATA_END_2: f->state = SIZE_1; return c == '\n' || bad(err, "The data of a chunk do not end in CR LF.");
    case TRAILER_END: f->state = TRAILER; *drop = true; return c == '\n' || bad(err, "A trailer does not end in CR LF.");
    case MESSAGE_END: f->state = START; return c == '\n' || bad(err, "The end of a message in chunks is not CR LF.");
    default: return trailer(f, c, drop, err);
    }
}

/* Between messages: a request begins, or one empty line that some clients send behind a body. */
static bool start_byte(struct framing *f, unsigned char c, bool *drop, struct sga_error *err)
{
    if (f->state == START && c == '\r' && !f->extras) {
        f->state = EMPTY_LINE;
        *drop = true;
        return true;
    }
    if (f->state == EMPTY_LINE) {
        f->state = START;
        f->extras = 1;               /* one, and no more */
        *drop = true;
        return c == '\n' || bad(err, "A line does not end in CR LF.");
    }
    begin(f);
    return head_byte(f, c, err);
}

bool framing_take(struct framing *f, char *bytes, size_t n, size_t *kept, struct sga_error *err)
{
    size_t out = 0;
    for (size_t i = 0; i < n;) {
        bool drop = false, ok;
        bool body = f->state == BODY || f->state == DATA;
        assert(out <= i && (!body || f->left > 0));
        size_t part = body ? (f->left < n - i ? (size_t)f->left : n - i) : f->state < BODY ? run(f, (unsigned char *)bytes + i, n - i) : 0;
        if (part || body) {
            if (out != i)
                memmove(bytes + out, bytes + i, part);
            i += part;
            out += part;
            if (!body)
                continue;
            f->left -= part;
            if (!f->left)
                f->state = f->state == BODY ? START : DATA_END;
            f->extras = f->state == START ? 0 : f->extras;
            continue;
        }
        unsigned char c = (unsigned char)bytes[i];
        if (f->state <= EMPTY_LINE)
            ok = start_byte(f, c, &drop, err);
        else if (f->state < BODY)
            ok = head_byte(f, c, err);
        else
            ok = chunk_byte(f, c, &drop, err);
        if (!ok) {
            *kept = out;
            return false;
        }
        if (f->state == START && !drop)
            f->extras = 0;
        if (!drop)
            bytes[out++] = (char)c;
        i++;
    }
    *kept = out;
    return true;
}
