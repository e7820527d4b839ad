/* Errors that reach a user: one located object, the first failure wins.
 *
 * The table below is the only list of codes. HTTP status, title and code text
 * come from it, in the daemon, the schema test and the documentation. */
#ifndef SGA_BASE_ERROR_H
#define SGA_BASE_ERROR_H

#include <stdbool.h>

/*    symbol                code text                 status  title */
#define SGA_ERROR_TABLE(X) \
    X(OK,                  "ok",                     200, "No error") \
    X(JSON_SYNTAX,         "json_syntax",            400, "The body is not JSON") \
    X(JSON_DEPTH,          "json_too_deep",          400, "The JSON is nested too deeply") \
    X(JSON_NUMBER,         "json_number",            400, "A number cannot be represented") \
    X(BODY_TOO_LARGE,      "body_too_large",         413, "The body is too large") \
    X(MEDIA_TYPE,          "unsupported_media_type", 415, "The content type is not supported") \
    X(NOT_ACCEPTABLE,      "not_acceptable",         406, "No representation fits the Accept header") \
    X(BAD_REQUEST,         "bad_request",            400, "The HTTP request is malformed") \
    X(TARGET_TOO_LONG,     "target_too_long",        414, "The target of the HTTP request is too long") \
    X(HEADER_TOO_LARGE,    "header_too_large",       431, "The head of the HTTP request is too large") \
    X(HTTP_VERSION,        "http_version",           505, "This version of HTTP is not spoken") \
    X(UNAUTHENTICATED,     "unauthenticated",        401, "A valid token is needed") \
    X(SCOPE,               "insufficient_scope",     403, "The token does not allow this") \
    X(QUOTA,               "quota_exceeded",         429, "The token has used up a quota") \
    X(FORBIDDEN_HOST,      "forbidden_host",         403, "This host or origin is not served") \
    X(NOT_FOUND,           "not_found",              404, "There is no such resource") \
    X(METHOD,              "method_not_allowed",     405, "The method is not allowed here") \
    X(JOB_ENDED,           "job_ended",              409, "The job has already ended") \
    X(NO_TRAJECTORY,       "no_trajectory",          409, "The job has no trajectory") \
    X(NO_TRADEOFF,         "no_tradeoff",            409, "The job has no tradeoff") \
    X(NO_CODE,             "no_code",                409, "The job's answer cannot be exported") \
    X(QUEUE_FULL,          "queue_full",             503, "The queue is full") \
    X(BUSY,                "busy",                   503, "The service is reading as much as it can") \
    X(DRAINING,            "draining",               503, "The service is shutting down") \
    X(STORE,               "store_failed",           503, "The store cannot be used") \
    X(SCHEMA,              "invalid_request",        422, "The request has the wrong shape") \
    X(UNKNOWN_MEMBER,      "unknown_member",         422, "The request has a member that is not known") \
    X(MISSING_MEMBER,      "missing_member",         422, "The request lacks a member") \
    X(SHAPE,               "wrong_shape",            422, "Sizes do not fit together") \
    X(DUPLICATE_NAME,      "duplicate_name",         422, "A name is given twice") \
    X(BAD_NAME,            "bad_name",               422, "A name is not usable") \
    X(EMPTY_SYSTEM,        "empty_system",           422, "The system is empty") \
    X(EXPR_SYNTAX,         "expression_syntax",      422, "An expression cannot be read") \
    X(EXPR_NAME,           "unknown_name",           422, "An expression uses an unknown name") \
    X(EXPR_ARITY,          "wrong_arity",            422, "A function has the wrong number of arguments") \
    X(EXPR_DEPTH,          "expression_too_deep",    422, "An expression is nested too deeply") \
    X(EXPR_SIZE,           "expression_too_large",   422, "An expression is too large") \
    X(EXPR_DERIVATIVE,     "derivative_not_allowed", 422, "A derivative is not allowed here") \
    X(EXPR_UNDEFINED,      "undefined_expression",   422, "An expression has no value") \
    X(LIMIT_VARIABLES,     "too_many_variables",     422, "The system has too many variables") \
    X(LIMIT_EXPONENT,      "exponent_too_large",     422, "An exponent is too large") \
    X(LIMIT_BITS,          "number_too_large",       422, "An exact number is too large") \
    X(NOT_SUPPORTED,       "not_supported",          422, "This is not available in this version") \
    X(LIMIT_NODES,         "node_limit",             422, "The computation grew past its node limit") \
    X(LIMIT_SECONDS,       "time_limit",             422, "The computation ran past its time limit") \
    X(LIMIT_MEMORY,        "memory_limit",           422, "The computation ran past its memory limit") \
    X(LIMIT_GROWTH,        "bit_limit",              422, "An exact number grew past its bit limit") \
    X(LIMIT_RESULT,        "result_limit",           422, "The result is larger than it may be") \
    X(LIMIT_GENERATIONS,   "generation_limit",       422, "The reduction did not end") \
    X(LIMIT_STRATA,        "strata_limit",           422, "There are more strata than are solved") \
    X(NO_REAL_POINT,       "no_real_point",          422, "No real point was found on a constraint set") \
    X(IRREGULAR,           "irregular_constraint",   422, "A constraint is not regular on its own zeros") \
    X(UNDECIDED,           "undecided",              422, "A zero or rank question could not be decided") \
    X(SPLIT,               "reducible_constraints",  422, "The constraint set has several branches") \
    X(WITNESS,             "witness_failed",         500, "The independent check contradicts the answer") \
    X(INITIAL,             "inconsistent_initial",   422, "The initial values cannot be made consistent") \
    X(GAUGE,               "gauge_contradiction",    422, "The gauge choice contradicts the motion") \
    X(INPUTS,              "inputs_mismatch",        422, "The inputs are not what the motion leaves free") \
    X(IMPROPER,            "improper_input",         422, "A state moves with the derivative of an input") \
    X(EVENT_SET,           "event_off_constraints",  422, "What an event sets cannot be met") \
    X(MODE_VALUE,          "mode_value",             422, "A mode has no such value") \
    X(NO_MOTION,           "no_motion",              422, "There is no motion to integrate") \
    X(CANCELLED,           "cancelled",              409, "The job was cancelled") \
    X(WORKER_DIED,         "worker_died",            500, "The process that ran the job died") \
    X(INTERNAL,            "internal",               500, "An internal check failed")

enum sga_code {
#define X(sym, text, status, title) SGA_E_##sym,
    SGA_ERROR_TABLE(X)
#undef X
    SGA_E_COUNT
};

struct sga_error {
    enum sga_code code;   /* SGA_E_OK: no error */
    char detail[768];     /* one or two sentences: what, where, what to change */
    char pointer[256];    /* JSON Pointer into the request, or "" */
    char stage[32];       /* "request", "form", "sga", "witness", "initial", "trajectory", ... */
    int line, column;     /* inside an expression, from 1; 0: none */
};

/* Record an error unless one stands already. Always returns false, so that a
 * failing function can end with `return sga_fail(err, ...)`. err may be NULL. */
bool sga_fail(struct sga_error *err, enum sga_code code, const char *fmt, ...)
    __attribute__((format(printf, 3, 4)));
/* As sga_fail, with the place: a JSON Pointer (printf form). */
bool sga_fail_at(struct sga_error *err, enum sga_code code, const char *pointer,
                 const char *fmt, ...) __attribute__((format(printf, 4, 5)));

const char *sga_code_text(enum sga_code code);   /* "expression_syntax" */
const char *sga_code_title(enum sga_code code);
int sga_code_status(enum sga_code code);         /* HTTP status */

#endif
