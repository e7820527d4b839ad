"""Audit lines: who changed what, or tried to, whatever the log's level is; and what is counted by token."""
import json
import os
import re
import signal
import subprocess
import tempfile
import time

from common import slow, trivial
from daemon import Daemon


def lines(d, event, count=1, seconds=10):
    """The audit lines of that event, once there are so many."""
    found, end = [], time.monotonic() + seconds
    while time.monotonic() < end:
        with open(os.path.join(d.state, "test.log"), encoding="utf-8") as f:
            found = [json.loads(line) for line in f if f'"event":"{event}"' in line and line.endswith("\n")]
        if len(found) >= count:
            break
        time.sleep(0.02)
    return found


def token(build, d, *arguments):
    run = subprocess.run([os.path.join(build, "sgad"), "token", *arguments, *d.place()], capture_output=True, text=True, check=True)
    return run.stdout.strip()


def bearer(text, **more):
    return {"Authorization": "Bearer " + text, **more}


def tell_many(d, count, token="sgad_" + "1" * 64):
    """So many requests at once, on one connection; how many were answered."""
    one = f"GET /v1/jobs HTTP/1.1\r\nHost: localhost\r\nAuthorization: Bearer {token}\r\n"
    out, _ = d.raw((one + "\r\n").encode() * (count - 1) + (one + "Connection: close\r\n\r\n").encode(), 30)
    return out.count(b"HTTP/1.1 401 ")


def known(d, text, status=200):
    for _ in range(200):
        if d.ask("GET", "/v1/jobs", headers=bearer(text)).status == status:
            return True
        time.sleep(0.05)
    return False


def audit(build, c):
    with tempfile.TemporaryDirectory() as folder:
        settings = folder + "/sgad.conf"
        with open(settings, "w", encoding="ascii") as f:
            f.write("log-level = error\nqueue = 10\n")
        with Daemon(build, "--access", "tokens", "--config", settings) as d:
            ann = token(build, d, "create", "--name", "ann", "--scope", "submit,read", "--expires", "9d")
            # the log says when the daemon knows them: to ask until it does would be told too, twenty times a second at most
            made = lines(d, "token_created")
            c(known(d, ann), "audit: a token is known")
            c(len(made) == 1 and made[0]["level"] == "audit" and made[0]["token"] == "ann" and made[0]["scopes"] == "submit,read" and made[0]["expires"], "audit: it was made", made)
            bob = token(build, d, "create", "--name", "bob", "--scope", "read")
            lines(d, "token_created", 2)
            c(known(d, bob) and not lines(d, "login_failed", 0), "audit: nobody has failed yet")
            d.ask("GET", "/v1/jobs", headers=bearer("sgad_" + "0" * 64))
            d.ask("GET", "/v1/jobs", headers={"Authorization": "Basic YTpi"})
            d.get("/v1/jobs")
            failed = lines(d, "login_failed", 2)
            c(len(failed) == 2 and all(f["peer"] == "127.0.0.1" and f["route"] == "/v1/jobs" and "token" not in f and f["request_id"] for f in failed),
              "audit: logins that fail", failed)
            c(not any("0" * 20 in json.dumps(f) for f in failed), "audit: what was shown is not told")
            tried = 2 + tell_many(d, 100)       # who has no token takes no room from what is told of those who have one
            a = d.ask("POST", "/v1/jobs", trivial(), bearer(bob))
            denied = lines(d, "access_denied")
            c(a.status == 403 and len(denied) == 1 and denied[0]["token"] == "bob" and denied[0]["reason"] == "submit", "audit: what a token may not", denied)
            id_ = d.ask("POST", "/v1/jobs", slow(), bearer(ann)).json()["id"]
            d.ask("DELETE", "/v1/jobs/" + id_, headers=bearer(ann))
            ended = lines(d, "job_cancelled")
            c(len(ended) == 1 and ended[0]["job"] == id_ and ended[0]["token"] == "ann" and ended[0]["peer"] == "127.0.0.1", "audit: a job is cancelled", ended)
            token(build, d, "revoke", "--name", "bob")
            c(known(d, bob, 401) and [r["token"] for r in lines(d, "token_revoked")] == ["bob"], "audit: a token is revoked", lines(d, "token_revoked"))
            tried += 1                # the revoked one's
            for _ in range(40):       # what was left out is told with the next line that is written
                many = lines(d, "login_failed", 0)
                told = len(many) + sum(line.get("left_out", 0) for line in many)
                if len(many) < told == tried:
                    break
                tried += tell_many(d, 100 if len(many) == told else 1)
                time.sleep(0.3)
            c(len(many) < told == tried, "audit: who tries without end does not fill the log", (len(many), told, tried))
            reloads(d, c, settings)
            d.process.send_signal(signal.SIGUSR1)
            drained = lines(d, "draining")
            c(len(drained) == 1 and drained[0]["level"] == "audit" and drained[0]["by_pid"] == os.getpid(), "audit: who drains", drained)
            c(d.ended() == 0, "audit: and it ends")
            with open(os.path.join(d.state, "test.log"), encoding="utf-8") as f:
                c(ann not in f.read(), "audit: no token stands in the log")


def reloads(d, c, settings):
    """What changes, and the log's level with it."""
    with open(settings, "w", encoding="ascii") as f:
        f.write("log-level = info\nqueue = 11\nworkers = 7\n")
    d.process.send_signal(signal.SIGHUP)
    told = lines(d, "reloaded")
    c(len(told) == 1 and "queue: 10 -> 11" in told[0]["changed"] and "log-level: error -> info" in told[0]["changed"] and told[0]["needs_restart"] == "workers"
      and told[0]["by_pid"] == os.getpid() and told[0]["by_uid"] == os.getuid(), "audit: settings that change", told)
    c(not lines(d, "request", 0, 0.1) and (d.get("/v1/jobs"), lines(d, "request"))[1], "audit: the log's level changes while it runs")


def counted(build, c):
    """By token, for who watches; the scope `watch` sees counts and no job."""
    with Daemon(build, "--access", "tokens", "--workers", "1") as d:
        ann, bob = (token(build, d, "create", "--name", n, "--scope", "submit,read", "--jobs", "2") for n in ("ann", "bob"))
        eye = token(build, d, "create", "--name", "prometheus", "--scope", "watch")
        c(known(d, ann) and known(d, bob) and known(d, eye, 403), "watch: sees no job")
        c(d.ask("POST", "/v1/solve", trivial(), bearer(ann)).status == 200, "watch: ann's job")
        ids = [d.ask("POST", "/v1/jobs", slow(), bearer(bob)).json()["id"] for _ in range(2)]
        c.problem(d.ask("POST", "/v1/jobs", slow(), bearer(bob)), 429, "quota_exceeded", "watch: bob's third")
        while d.ask("GET", "/v1/jobs/" + ids[0], headers=bearer(bob)).json()["status"] != "running":
            time.sleep(0.02)
        a = d.ask("GET", "/metrics", headers=bearer(eye))
        text = a.body.decode()
        value = lambda name, **labels: float((re.findall(rf"^sgad_{name}{{{','.join(f'{k}=.{v}.' for k, v in labels.items())}}} (\S+)$", text, re.M) or ["nan"])[0])  # noqa: E731
        c(a.status == 200 and value("token_jobs_accepted_total", token="ann") == 1 and value("token_jobs_accepted_total", token="bob") == 2, "watch: accepted", text[-2500:])
        c(value("token_refusals_total", token="bob") == 1 and value("token_refusals_total", token="ann") == 0, "watch: refused")
        c(value("token_jobs", token="bob", status="running") == 1 and value("token_jobs", token="bob", status="queued") == 1, "watch: running and queued")
        c(value("token_run_seconds_total", token="ann") > 0, "watch: seconds")
        c(value("state_bytes", file="queue") > 0 and value("state_bytes", file="results") > 0
          and re.search(r"^sgad_reply_cache_bytes [1-9]", text, re.M), "watch: bytes")
        for id_ in ids:
            d.ask("DELETE", "/v1/jobs/" + id_, headers=bearer(bob))
        c.problem(d.get("/metrics"), 401, "unauthenticated", "watch: nobody else")
    with Daemon(build, "--access", "tokens", "--isolation", "token") as d:
        ann = token(build, d, "create", "--name", "ann", "--scope", "submit,read")
        eye = token(build, d, "create", "--name", "eye", "--scope", "watch")
        c(known(d, ann) and known(d, eye, 403), "watch: tokens")
        c("token=" not in d.ask("GET", "/metrics", headers=bearer(ann)).body.decode(), "watch: where tokens are kept apart, none sees the others' counts")
        c('token="ann"' in d.ask("GET", "/metrics", headers=bearer(eye)).body.decode(), "watch: but who watches")


ALL = [audit, counted]
