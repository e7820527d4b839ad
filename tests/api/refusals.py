"""Whatever is wrong gets a problem with its code, and the daemon goes on."""
import json
import re

from common import moving, slow, trivial


def bodies(d, c):
    good = trivial()
    text = json.dumps(good)
    c.problem(d.ask("POST", "/v1/jobs", '{"system": '), 400, "json_syntax", "cut JSON")
    c.problem(d.ask("POST", "/v1/jobs", ""), 400, "json_syntax", "empty body")
    c.problem(d.ask("POST", "/v1/jobs", b'{"system": "\xff\xfe"}'), 400, "json_syntax", "not UTF-8")
    c.problem(d.ask("POST", "/v1/jobs", b'{"a": "\x00"}'), 400, "json_syntax", "a zero byte")
    c.problem(d.ask("POST", "/v1/jobs", "[" * 100000), 400, ("json_too_deep", "json_syntax"), "deep JSON")
    c.problem(d.ask("POST", "/v1/jobs", text.replace('"A"', '"B"')), 422, ("unknown_member", "missing_member"), "unknown member")
    for kind in ("text/plain", "application/x-www-form-urlencoded", "multipart/form-data; boundary=x", ""):
        c.problem(d.ask("POST", "/v1/jobs", text, {"Content-Type": kind}), 415, "unsupported_media_type", f"content type {kind!r}")
    c.status(d.ask("POST", "/v1/solve", text, {"Content-Type": "application/json; charset=utf-8"}), 200, "charset parameter")
    p = c.problem(d.ask("POST", "/v1/solve", {"system": {**good["system"], "alpha": ["1 + * x"]}}), 422, "expression_syntax", "syntax")
    c(p.get("pointer") == "/system/alpha/0" and (p.get("line"), p.get("column")) == (1, 5), "syntax: place", p)
    p = c.problem(d.ask("POST", "/v1/jobs", {"system": {**good["system"], "alpha": ["x + yy"]}}), 422, "unknown_name", "name")
    c(p.get("column") == 5, "name: column", p)


def large(d, c):
    big = json.dumps({**trivial(), "padding": "x" * (5 << 20)})
    a = d.ask("POST", "/v1/jobs", big)
    c.problem(a, 413, "body_too_large", "5 MB")
    head = (f"POST /v1/jobs HTTP/1.1\r\nHost: 127.0.0.1:{d.port}\r\nContent-Type: application/json\r\n"
            "Content-Length: 99999999999\r\n\r\n").encode()
    out, closed = d.raw(head + b"{", 5)
    c(out.startswith(b"HTTP/1.1 413") and closed, "a huge Content-Length is refused before the body", out[:200])
    long_path, _ = d.raw(b"GET /" + b"a" * 100000 + f" HTTP/1.1\r\nHost: 127.0.0.1:{d.port}\r\n\r\n".encode())
    c(long_path == b"" or long_path.split(b" ")[1][:1] == b"4", "a long path", long_path[:100])
    nested = {"system": {**trivial()["system"], "alpha": ["(" * 200000 + "x" + ")" * 200000]}}
    c.problem(d.ask("POST", "/v1/jobs", nested), 422, ("expression_too_deep", "expression_too_large"), "deep expression")
    wide = {"system": {**trivial()["system"], "alpha": ["+".join(["x"] * 600000)]}}
    c.status(d.ask("POST", "/v1/jobs", wide), (200, 202, 422), "wide expression")
    c.status(d.get("/healthz"), 200, "alive")


def paths(d, c):
    c.problem(d.get("/v1/nothing"), 404, "not_found", "unknown path")
    c.problem(d.get("/v1/schema/nothing"), 404, "not_found", "unknown schema")
    c.problem(d.get("/v1/schema/../request"), 404, "not_found", "dots in a path")
    c.problem(d.get("/v1/jobs/" + "0" * 32), 404, "not_found", "unknown job")
    c.problem(d.get("/v1/jobs/%27%20OR%201=1"), 404, "not_found", "no id at all")
    c.problem(d.get("/v1/jobs/" + "0" * 32 + "/trajectory"), 404, "not_found", "trajectory of an unknown job")
    c.problem(d.get("/v1/jobs/" + "0" * 32 + "/events"), 404, "not_found", "events of an unknown job")
    c.problem(d.ask("DELETE", "/v1/jobs/" + "0" * 32), 404, "not_found", "cancelling an unknown job")
    for method, path in (("PUT", "/v1/jobs"), ("DELETE", "/v1/jobs"), ("GET", "/v1/solve"), ("POST", "/healthz"), ("PATCH", "/v1/solve")):
        a = d.ask(method, path, "{}" if method != "GET" else None)
        c.problem(a, 405, "method_not_allowed", f"{method} {path}")
        c("allow" in a.headers, f"{method} {path}: Allow", a.headers)


def hosts(d, c):
    c.problem(d.get("/healthz", Host="evil.example"), 403, "forbidden_host", "another host")
    c.status(d.get("/healthz", Host="localhost:1"), 200, "localhost")
    a = d.ask("POST", "/v1/jobs", trivial(), {"Origin": "https://evil.example"})
    c.problem(a, 403, "forbidden_host", "another origin")
    a = d.get("/healthz")
    c("access-control-allow-origin" not in a.headers, "no cross-origin headers")
    c(a.headers.get("x-request-id"), "request id", a.headers)


def failed(d, c):
    """A request that is well-formed and still fails: the job says why."""
    request = moving()
    request["trajectory"]["initial"] = {"x": 5, "y": 5000}
    request["trajectory"]["hold"] = ["x", "y"]
    a = d.ask("POST", "/v1/solve", request)
    c.status(a, 200, "failed job")
    job = c.job(a, "failed job")
    error = job.get("error", {})
    c(job.get("status") == "failed" and error.get("code") == "inconsistent_initial", "failed job", job)
    c(error.get("stage"), "failed job: stage", error)
    again = d.get("/v1/jobs/" + job["id"]).json()
    c(again["error"] == error, "failed job: by its id", again)
    c.problem(d.get(f"/v1/jobs/{job['id']}/trajectory"), 409, "no_trajectory", "trajectory of a failed job")
    c.status(d.ask("DELETE", "/v1/jobs/" + job["id"]), 204, "removing an ended job")
    job = d.ask("POST", "/v1/solve", slow(0.5)).json()
    ended = (job.get("result", {}).get("trajectory", {}).get("ended") or {}).get("reason")
    c("time_limit" in (ended, job.get("error", {}).get("code")), "time limit", job)


def unknown_words(d, c):
    """What is not known is refused: parameters, codings, second origins. A target may name its host."""
    for path in ("/v1/jobs?limt=3", "/v1/jobs?limit=3&limit=4", "/v1/jobs/" + "0" * 32 + "?format=csv", "/healthz?x=1"):
        c.problem(d.get(path), 400, "bad_request", path)
    c("limit" in d.get("/v1/jobs?limt=3").json()["detail"], "the known ones are named")
    for name, value in (("Content-Encoding", "gzip"), ("Content-Type", "application/json; charset=utf-16")):
        c.problem(d.ask("POST", "/v1/jobs", trivial(), {name: value}), 415, "unsupported_media_type", value)
    for name, value in (("Content-Encoding", "identity"), ("Content-Type", "application/json; charset=UTF-8")):
        c.status(d.ask("POST", "/v1/jobs", trivial(), {name: value}), 202, value)
    host = f"Host: 127.0.0.1:{d.port}\r\n"
    out, _ = d.raw(f"GET /v1/jobs HTTP/1.1\r\n{host}Origin: http://localhost\r\nOrigin: http://elsewhere.example\r\nConnection: close\r\n\r\n".encode())
    c(out.startswith(b"HTTP/1.1 400"), "two origins", out[:200])
    out, _ = d.raw(f"GET http://127.0.0.1:{d.port}/healthz HTTP/1.1\r\n{host}Connection: close\r\n\r\n".encode())
    c(out.startswith(b"HTTP/1.1 200"), "a target in absolute form", out[:200])
    out, _ = d.raw(f"GET http://127.0.0.1:{d.port} HTTP/1.1\r\n{host}Connection: close\r\n\r\n".encode())
    c(out.startswith(b"HTTP/1.1 200"), "one without a path", out[:200])


def smuggling(d, c):
    host = f"Host: 127.0.0.1:{d.port}\r\n"
    second = f"GET /v1/jobs/smuggled HTTP/1.1\r\n{host}\r\n"
    post = f"POST /v1/jobs HTTP/1.1\r\n{host}Content-Type: application/json\r\n"
    attacks = {
        "two lengths": post + f"Content-Length: 2\r\nContent-Length: {2 + len(second)}\r\n\r\n{{}}" + second,
        "length and chunked": post + f"Content-Length: 5\r\nTransfer-Encoding: chunked\r\n\r\n0\r\n\r\n" + second,
        "blank before the colon": post + f"Content-Length : 2\r\n\r\n{{}}" + second,
        "another coding": post + "Transfer-Encoding: gzip\r\n\r\n{}" + second,
        "two codings": post + "Transfer-Encoding: chunked\r\nTransfer-Encoding: identity\r\n\r\n0\r\n\r\n" + second,
        "no host": "GET /healthz HTTP/1.1\r\n\r\n" + second,
        "two hosts": f"GET /healthz HTTP/1.1\r\n{host}Host: evil.example\r\n\r\n" + second,
        "zero byte in the path": f"GET /healthz%00x HTTP/1.1\r\n{host}\r\n" + second,
        "no number": post + "Content-Length: 2x\r\n\r\n{}" + second,
        "negative length": post + "Content-Length: -2\r\n\r\n{}" + second,
    }
    for name, text in attacks.items():
        out, closed = d.raw(text.encode(), 3)
        replies = set(re.findall(rb"HTTP/1\.1 (\d+)", out))
        c(replies <= {b"400", b"411", b"501"}, f"smuggling: {name}: refused, and no second request answered", out[:400])
        c(closed, f"smuggling: {name}: the connection is closed", out[:200])
    # What the HTTP library takes for the end of a head, and other spellings, may be answered, but
    # nothing else on that connection is.
    odd = {
        "a line without a name": f"GET /healthz HTTP/1.1\r\n{host}: x\r\n" + second,
        "its shortest form": f"GET /healthz HTTP/1.1\r\n{host}:\r\n" + second,
        "no blank to make up for it": f"GET /healthz HTTP/1.1\r\n{host}A:b\r\n:\r\n" + second,
        "bare line feeds": f"GET /healthz HTTP/1.1\nHost: localhost\n\n" + second,
        "a length after a line without a name": post + ": x\r\nContent-Length: 2\r\n\r\n{}" + second,
    }
    for name, text in odd.items():
        out, closed = d.raw(text.encode(), 3)
        c(out.count(b"HTTP/1.1 ") == 1 and closed, f"smuggling: {name}: one reply, then closed", out[:400])
    pipelined = (f"GET /healthz HTTP/1.1\r\n{host}\r\n" * 2 + f"GET /healthz HTTP/1.1\r\n{host}Connection: close\r\n\r\n").encode()
    out, closed = d.raw(pipelined, 5)
    c(out.count(b"HTTP/1.1 200") == 3 and closed, "three requests on one connection", out[:200])
    c.status(d.get("/healthz"), 200, "alive")


ALL = [bodies, large, paths, hosts, failed, unknown_words, smuggling]
