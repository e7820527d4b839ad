"""Who is let in: tokens, scopes, expiry, quotas, turns of the queue, TLS, sockets, settings."""
import http.client
import json
import os
import re
import shutil
import signal
import socket
import sqlite3
import ssl
import subprocess
import tempfile
import time

from common import moving, slow, trivial
from daemon import Daemon
from tally import ROOT


def sgad(build, *arguments, **more):
    return subprocess.run([os.path.join(build, "sgad"), *arguments], capture_output=True, timeout=30, check=False, text=True, **more)


def new_token(build, d, name, *options):
    run = sgad(build, "token", "create", *d.place(), "--name", name, *options)
    if run.returncode != 0:
        raise RuntimeError(run.stderr)
    return run.stdout.strip()


def bearer(token):
    return {"Authorization": "Bearer " + token}


def until(test, seconds=15):
    end = time.monotonic() + seconds
    while time.monotonic() < end:
        if test():
            return True
        time.sleep(0.05)
    return False


def tokens(build, c):
    with Daemon(build, "--access", "tokens") as d:
        for path in ("/healthz", "/readyz", "/version", "/openapi.json", "/v1/schema/request"):
            c.status(d.get(path), 200, f"{path} needs no token")
        for method, path in (("GET", "/v1/jobs"), ("POST", "/v1/jobs"), ("POST", "/v1/solve"), ("GET", "/metrics"),
                             ("GET", "/v1/jobs/" + "0" * 32), ("DELETE", "/v1/jobs/" + "0" * 32)):
            a = d.ask(method, path, trivial() if method == "POST" else None)
            c.problem(a, 401, "unauthenticated", f"{method} {path} without a token")
            c(a.headers.get("www-authenticate", "").startswith("Bearer "), f"{method} {path}: WWW-Authenticate", a.headers)
        both = new_token(build, d, "both")
        c(re.fullmatch(r"sgad_[0-9a-f]{64}", both), "a token has 256 bits", both)
        c(until(lambda: d.ask("GET", "/v1/jobs", headers=bearer(both)).status == 200), "a new token is noticed")
        job = d.ask("POST", "/v1/solve", trivial(), bearer(both))
        c.status(job, 200, "solve with a token")
        for bad in ("Basic " + both, "Bearer", "Bearer ", both, "Bearer " + both[:-1], "Bearer " + both + "0", "Bearer " + both.upper()):
            c.problem(d.ask("GET", "/v1/jobs", headers={"Authorization": bad}), 401, "unauthenticated", f"{bad[:12]}...")
        twice = f"GET /v1/jobs HTTP/1.1\r\nHost: 127.0.0.1\r\nAuthorization: Bearer {both}\r\nAuthorization: Bearer x\r\nConnection: close\r\n\r\n"
        out, _ = d.raw(twice.encode())
        c(out.startswith(b"HTTP/1.1 401"), "two Authorization headers", out[:100])
        c.problem(d.ask("GET", f"/v1/jobs?access_token={both}"), 401, "unauthenticated", "a token in the query")

        reader, sender, admin = (new_token(build, d, n, "--scope", n) for n in ("read", "submit", "admin"))
        os.kill(d.process.pid, signal.SIGHUP)
        c(until(lambda: d.ask("GET", "/v1/jobs", headers=bearer(admin)).status == 200), "SIGHUP reads the tokens")
        a = d.ask("POST", "/v1/solve", trivial(), bearer(reader))
        c.problem(a, 403, "insufficient_scope", "submitting with read")
        c('scope="submit"' in a.headers.get("www-authenticate", ""), "403 names the scope", a.headers)
        c.problem(d.ask("GET", "/v1/jobs", headers=bearer(sender)), 403, "insufficient_scope", "reading with submit")
        c.status(d.ask("GET", "/metrics", headers=bearer(reader)), 200, "metrics with read")
        c.status(d.ask("POST", "/v1/solve", trivial(), bearer(sender)), 200, "submitting with submit")

        id_ = d.ask("POST", "/v1/jobs", slow(), bearer(both)).json()["id"]
        c.problem(d.ask("DELETE", "/v1/jobs/" + id_, headers=bearer(sender)), 403, "insufficient_scope", "cancelling another's job")
        c.status(d.ask("DELETE", "/v1/jobs/" + id_, headers=bearer(admin)), (200, 202), "admin cancels any job")

        with open(os.path.join(d.state, "sgad", "tokens.db"), "rb") as f:
            kept = f.read()
        c(both.encode() not in kept and both[5:].encode() not in kept and bytes.fromhex(both[5:]) not in kept, "the file holds no token")
        c(os.stat(os.path.join(d.state, "sgad", "tokens.db")).st_mode & 0o077 == 0, "the file is the owner's alone")
        c(until(lambda: '"token":"both"' in d.errors()), "the log names the token", d.errors()[-300:])
        c(both not in d.errors(), "the log holds no token")

        state = os.path.join(d.state, "sgad")
        c(sgad(build, "token", "revoke", "--state", state, "--name", "both").returncode == 0, "revoke")
        c(until(lambda: d.ask("GET", "/v1/jobs", headers=bearer(both)).status == 401), "a revoked token is refused")
        c(sgad(build, "token", "revoke", "--state", state, "--name", "both").returncode == 1, "revoking twice")
        c(sgad(build, "token", "create", "--state", state, "--name", "both").returncode == 1, "a name is used once")
        listed = sgad(build, "token", "list", "--state", state).stdout
        c("both\trevoked\tsubmit,read" in listed and "read\tvalid\tread\t" in listed, "list", listed)
        c("sgad_" not in listed, "the list holds no token")
        brief = new_token(build, d, "brief", "--expires", "3s")
        c(until(lambda: d.ask("GET", "/v1/jobs", headers=bearer(brief)).status == 200, 2.5), "a token that will expire")
        c(until(lambda: d.ask("GET", "/v1/jobs", headers=bearer(brief)).status == 401), "an expired token is refused")
        c("brief\texpired" in sgad(build, "token", "list", "--state", state).stdout, "the list says expired")
    for wrong in (["create"], ["create", "--name", "a b"], ["create", "--name", "x", "--scope", "root"], ["create", "--name", "x", "--expires", "3w"],
                  ["create", "--name", "x", "--jobs", "-1"], ["make"], [], ["revoke"], ["create", "--name"]):
        run = sgad(build, "token", *wrong, "--state", "/nonexistent/x") if wrong != ["create", "--name"] else sgad(build, "token", *wrong)
        c(run.returncode == 2 and run.stderr, f"refused: sgad token {' '.join(wrong)}", run)


def cut_short(build, c):
    """A command that was killed while it wrote the tokens leaves a journal: who reads them next rolls it back, whoever that is."""
    with Daemon(build, "--access", "tokens") as d, tempfile.TemporaryDirectory() as folder:
        token, file, kept = new_token(build, d, "ann"), os.path.join(d.state, "sgad", "tokens.db"), os.path.join(folder, "tokens.db")
        c(until(lambda: d.ask("GET", "/v1/jobs", headers=bearer(token)).status == 200), "cut short: a token")

        def write(to):
            db = sqlite3.connect(file, isolation_level=None)
            db.execute("PRAGMA cache_size = 1")
            db.execute("BEGIN IMMEDIATE")
            for k in range(500):
                db.execute("INSERT INTO tokens VALUES(?, randomblob(32), 3, 0, 0, 0, 0, 0, 0, 0)", (f"half{k}",))
            db.execute("UPDATE tokens SET revoked = 1")
            for path in ("", "-journal"):
                shutil.copyfile(file + path, to + path)
            db.execute("ROLLBACK")
            db.close()
        write(kept)
        for label, look in (("the list", lambda: sgad(build, "token", "list", "--state", folder)), ("check", lambda: sgad(build, "check", "--state", folder))):
            write(kept)
            run = look()
            c(run.returncode == 0 and "half" not in run.stdout, f"cut short: {label}", run)
            c("ann\tvalid" in sgad(build, "token", "list", "--state", folder).stdout, f"cut short: rolled back by {label}")
        write(kept)
        d.stop()
        for path in ("", "-journal"):
            os.rename(kept + path, file + path)
        d.start()
        c.status(d.ask("GET", "/v1/jobs", headers=bearer(token)), 200, "cut short: the daemon starts, and knows its tokens")


def quotas(build, c):
    with Daemon(build, "--access", "tokens", "--workers", "1") as d:
        few = bearer(new_token(build, d, "few", "--jobs", "2", "--waiters", "1"))
        tired = bearer(new_token(build, d, "tired", "--seconds", "1"))
        small = bearer(new_token(build, d, "small", "--bytes", "10"))
        free = bearer(new_token(build, d, "free", "--scope", "admin"))
        c(until(lambda: d.ask("GET", "/v1/jobs", headers=free).status == 200), "tokens are there")
        ids = [d.ask("POST", "/v1/jobs", slow(), few).json()["id"] for _ in range(2)]
        a = d.ask("POST", "/v1/jobs", slow(), few)
        c.problem(a, 429, "quota_exceeded", "a third job of two")
        c(int(a.headers.get("retry-after", "0")) > 0, "429: Retry-After", a.headers)
        c.status(d.ask("POST", "/v1/jobs", trivial(), free), 202, "another token is not touched")
        c.problem(d.ask("POST", "/v1/jobs", trivial(), small), 429, "quota_exceeded", "a request of too many bytes")
        with socket.create_connection(("127.0.0.1", d.port), timeout=10) as s:
            s.sendall(f"GET /v1/jobs/{ids[0]}/events HTTP/1.1\r\nHost: localhost\r\nAuthorization: {few['Authorization']}\r\n\r\n".encode())
            got = b""
            while b"data:" not in got and len(got) < 10000:      # the first stream is under way; its place is taken, whatever it sends
                got += s.recv(1000) or b"data: it ended"
            c.problem(d.ask("GET", f"/v1/jobs/{ids[0]}/events", headers=few), 429, "quota_exceeded", "a second event stream of one")
        for i in ids:
            c.status(d.ask("DELETE", "/v1/jobs/" + i, headers=few), (200, 202), "cancelling its own job")
        c(until(lambda: d.ask("POST", "/v1/jobs", trivial(), few).status in (200, 202)), "room again after the end")
        d.ask("POST", "/v1/solve", slow(1.5), tired)
        a = d.ask("POST", "/v1/jobs", trivial(), tired)
        c.problem(a, 429, "quota_exceeded", "seconds of an hour")
        c(600 < int(a.headers.get("retry-after", "0")) <= 3601, "429: until the hour is over", a.headers)
        # what a body costs to read is on the account of who sent it
        reader = bearer(new_token(build, d, "reader", "--seconds", "1"))
        c(until(lambda: d.ask("GET", "/v1/jobs", headers=reader).status == 200), "its token is there")
        for k in range(8):
            costly = {"form": "equations", "variables": ["x"], "name": str(k), "equations": ["der(sin(cos(x^9*t))/exp(x*t), 30) = 0", "x = y"]}
            a = d.ask("POST", "/v1/jobs", {"system": costly}, reader)
            c(a.status in (422, 429), "a body that is refused after it was read", (a.status, a.body[:200]))
        c.problem(d.ask("POST", "/v1/jobs", trivial(), reader), 429, "quota_exceeded", "seconds of reading, in an hour")
        c.status(d.ask("POST", "/v1/jobs", trivial(), free), 202, "another token is not touched by them")


def owners(build, c):
    """A job is theirs who asked for it, also in the next life of the daemon: each lists it, none ends it for the others."""
    with Daemon(build, "--access", "tokens", "--workers", "1") as d:
        ann, bob, boss, eve = (bearer(new_token(build, d, n, *more)) for n, more in (
            ("ann", ["--jobs", "2"]), ("bob", []), ("boss", ["--scope", "admin"]), ("eve", [])))
        c(until(lambda: d.ask("GET", "/v1/jobs", headers=eve).status == 200), "tokens are there")

        def listed(who, query=""):
            return [j["id"] for j in d.ask("GET", "/v1/jobs" + query, headers=who).json()["jobs"]]
        request, both = slow(), trivial()
        hers = d.ask("POST", "/v1/jobs", request, ann).json()["id"]
        c(until(lambda: d.ask("GET", "/v1/jobs/" + hers, headers=ann).json()["status"] == "running"), "it runs")
        waits = d.ask("POST", "/v1/jobs", both, ann).json()["id"]
        his = d.ask("POST", "/v1/jobs", trivial(), bob).json()["id"]
        c(d.ask("POST", "/v1/jobs", request, bob).json()["id"] == hers, "the same request is the same job")
        c(d.ask("POST", "/v1/jobs", both, bob).json()["id"] == waits, "also where it waits")

        def looks(label):
            c(listed(ann) == [waits, hers] and listed(bob) == [waits, hers, his], f"{label}: each lists what it asked for", (listed(ann), listed(bob)))
            c(listed(boss) == [his, waits, hers], f"{label}: admin lists all", listed(boss))
            c(listed(bob, "?status=running") == [hers] and listed(bob, "?status=queued,running&limit=2") == [waits, hers], f"{label}: filters",
              listed(bob, "?status=queued,running&limit=2"))
            c(listed(ann, "?limit=1") == [waits], f"{label}: pages")
            c.status(d.ask("GET", "/v1/jobs/" + hers, headers=eve), 200, f"{label}: reading by id")
            c.problem(d.ask("DELETE", "/v1/jobs/" + hers, headers=eve), 403, "insufficient_scope", f"{label}: cancelling another's job")
            c.problem(d.ask("DELETE", "/v1/jobs/" + his, headers=ann), 403, "insufficient_scope", f"{label}: cancelling another's waiting job")
            c.problem(d.ask("POST", "/v1/jobs", trivial(), ann), 429, "quota_exceeded", f"{label}: a third job of two")
        looks("at first")
        d.process.kill()
        d.ended()
        d.start()
        c(until(lambda: d.ask("GET", "/v1/jobs/" + hers, headers=ann).json().get("status") == "running"), "it runs again")
        looks("after a crash")
        for id_ in (waits, hers):
            c.status(d.ask("DELETE", "/v1/jobs/" + id_, headers=ann), 204, "one of two withdraws")
            c(d.ask("GET", "/v1/jobs/" + id_, headers=bob).json()["status"] in ("queued", "running"), "the other's job goes on")
        c(listed(ann) == [] and listed(bob) == [waits, hers, his], "it is in the other's list only", (listed(ann), listed(bob)))
        d.process.kill()
        d.ended()
        d.start()
        c(listed(ann) == [] and listed(bob) == [waits, hers, his], "also after a crash", (listed(ann), listed(bob)))
        c.status(d.ask("DELETE", "/v1/jobs/" + hers, headers=bob), (200, 202), "the last one cancels")
        for id_ in (waits, his):
            c(until(lambda i=id_: d.ask("GET", "/v1/jobs/" + i, headers=bob).json()["status"] == "done"), "what waited runs")
        c(until(lambda: d.ask("POST", "/v1/jobs", both, eve).status == 200), "a third finds the answer")
        c(until(lambda: listed(eve) == [waits]), "and finds it in its list", listed(eve))
        c.problem(d.ask("DELETE", "/v1/jobs/" + waits, headers=ann), 409, "job_ended", "an ended job of others")
        c.status(d.ask("DELETE", "/v1/jobs/" + waits, headers=bob), 204, "taking an ended job from one's list")
        c(waits not in listed(bob) and waits in listed(eve), "from one's own only", (listed(bob), listed(eve)))
        c.status(d.ask("DELETE", "/v1/jobs/" + waits, headers=boss), 204, "an administrator removes it")
        c(waits not in listed(eve) and d.ask("GET", "/v1/jobs/" + waits, headers=eve).status == 404, "for all")


def isolated(build, c):
    """isolation = token: nobody can tell what others asked."""
    with Daemon(build, "--access", "tokens", "--isolation", "token", "--workers", "2") as d:
        ann, bob, boss = bearer(new_token(build, d, "ann")), bearer(new_token(build, d, "bob")), bearer(new_token(build, d, "boss", "--scope", "admin"))
        c(until(lambda: d.ask("GET", "/v1/jobs", headers=boss).status == 200), "tokens are there")
        for request, removed in ((trivial(), (204,)), (slow(), (200, 202))):
            one, two = (d.ask("POST", "/v1/jobs", request, who).json() for who in (ann, bob))
            c(one["id"] != two["id"], "each token has a job of its own", (one, two))
            for path in ("", "/events", "/trajectory", "/tradeoff"):
                c.problem(d.ask("GET", f"/v1/jobs/{one['id']}{path}", headers=bob), 404, "not_found", f"another's job{path}")
            c.problem(d.ask("DELETE", "/v1/jobs/" + one["id"], headers=bob), 404, "not_found", "cancelling another's job")
            c.status(d.ask("GET", "/v1/jobs/" + one["id"], headers=ann), 200, "one's own")
            c.status(d.ask("GET", "/v1/jobs/" + one["id"], headers=boss), 200, "an administrator sees it")
            for who, job in ((ann, one), (bob, two)):
                if removed == (204,):            # one that ends while it is cancelled is neither
                    c(until(lambda i=job["id"], w=who: d.ask("GET", "/v1/jobs/" + i, headers=w).json()["status"] == "done"), "the short one is done")
                c.status(d.ask("DELETE", "/v1/jobs/" + job["id"], headers=who), removed, "one's own can be cancelled or removed")
        request = trivial()
        first = d.ask("POST", "/v1/solve", request, ann)
        c.status(first, 200, "solved for one")
        again_, other = d.ask("POST", "/v1/solve", request, ann).json(), d.ask("POST", "/v1/solve", request, bob).json()
        c(again_["cached"] is True and other["cached"] is False, "the answer is cached for that one only", (again_["cached"], other["cached"]))
        c(again_["result"]["vector_field"] == other["result"]["vector_field"], "and the same for the other")
    run = sgad(build, "--check-config", "--listen", "127.0.0.1:0", "--state", "x", "--isolation", "token")
    c(run.returncode == 2 and "access = tokens" in run.stderr, "isolation without tokens", run.stderr)


def waiters(path):
    """Requests that wait for a job, as a second address tells it."""
    with socket.socket(socket.AF_UNIX) as s:
        s.settimeout(10)
        s.connect(path)
        s.sendall(b"GET /metrics HTTP/1.1\r\nHost: localhost\r\nConnection: close\r\n\r\n")
        text = b""
        while piece := s.recv(4096):
            text += piece
    return int(re.search(rb"^sgad_waiters (\d+)", text, re.M)[1])


def closed(s):
    """Has the other side closed? What came before is read."""
    s.settimeout(0.3)
    try:
        while s.recv(4096):
            pass
        return True
    except OSError as e:
        return not isinstance(e, TimeoutError)


def crowd_of_one(build, c):
    """One address does not hold all connections; of its own, those without a request give their place to the next."""
    with tempfile.TemporaryDirectory() as folder, Daemon(build, "--address-connections", "5", "--connections", "5", "--workers", "1",
                                                         "--listen", f"127.0.0.1:0,unix:{folder}/admin") as d:
        held = []

        def in_turn():
            """Five take all places, then others come: those at rest are closed, the oldest first."""
            for s in held:
                s.close()
            held[:] = []
            for _ in range(5):
                held.append(socket.create_connection(("127.0.0.1", d.port), timeout=10))
                held[-1].sendall(b"GET /healthz HTTP/1.1\r\nHost: localhost\r\n\r\n")
                c(held[-1].recv(100).startswith(b"HTTP/1.1 200"), "within the limit")
            for k in range(8):
                c.status(d.get("/healthz"), 200, f"one more takes the place of one at rest: {k}")
            ended = [closed(s) for s in held]
            return ended[0] and ended == sorted(ended, reverse=True)

        try:
            # An answer is read a moment before its connection is at rest: on a busy machine a later one may rest first.
            c(until(in_turn), "those at rest are closed, the oldest first")
            id_ = d.ask("POST", "/v1/jobs", slow()).json()["id"]

            def all_wait():
                """The same moment may cost one of the five its place: they come once more then."""
                for s in held:
                    s.close()
                until(lambda: waiters(folder + "/admin") == 0, seconds=20)
                held[:] = [socket.create_connection(("127.0.0.1", d.port), timeout=10) for _ in range(5)]
                try:
                    for s in held:
                        s.sendall(f"GET /v1/jobs/{id_} HTTP/1.1\r\nHost: localhost\r\nPrefer: wait=15\r\n\r\n".encode())
                except OSError:
                    return False
                return until(lambda: waiters(folder + "/admin") == 5, seconds=6)

            c(until(all_wait, seconds=60), "all wait for a job")
            with socket.create_connection(("127.0.0.1", d.port), timeout=10) as more:
                try:
                    more.sendall(b"GET /healthz HTTP/1.1\r\nHost: localhost\r\n\r\n")
                    out = more.recv(100)
                except OSError:
                    out = b""
                c(out == b"", "where all have a request one more is closed", out)
            for path in ("/healthz", "/metrics", "/v1/jobs"):          # a second address has connections of its own: for probes and administrators
                with socket.socket(socket.AF_UNIX) as admin:
                    admin.settimeout(10)
                    admin.connect(folder + "/admin")
                    admin.sendall(f"GET {path} HTTP/1.1\r\nHost: localhost\r\nConnection: close\r\n\r\n".encode())
                    c(admin.recv(100).startswith(b"HTTP/1.1 200"), f"{path} by the UNIX socket meanwhile")
        finally:
            for s in held:
                s.close()
        def served():
            try:
                return d.get("/healthz").status == 200
            except (OSError, http.client.HTTPException):
                return False
        c(until(served, seconds=40), "room again")


def reading_only(build, c):
    """Who may only read starts no work: a result that is gone says how to get it again."""
    with Daemon(build, "--access", "tokens", "--workers", "1", "--cache-memory", "0") as d:
        ann, eve = bearer(new_token(build, d, "ann")), bearer(new_token(build, d, "eve", "--scope", "read"))
        c(until(lambda: d.ask("GET", "/v1/jobs", headers=eve).status == 200), "tokens are there")
        request = trivial()
        id_ = d.ask("POST", "/v1/solve", request, ann).json()["id"]
        c.status(d.ask("GET", "/v1/jobs/" + id_, headers=eve), 200, "reading")
        d.stop()
        for name in os.listdir(os.path.join(d.state, "sgad")):
            if name.startswith("cache.db"):
                os.remove(os.path.join(d.state, "sgad", name))
        d.start()
        for path in ("", "/events", "/trajectory"):
            a = d.ask("GET", f"/v1/jobs/{id_}{path}", headers=eve)
            c("submit" in c.problem(a, 404, "not_found", "a result that is gone")["detail"], "what to do is said", a.body)
        a = d.ask("GET", "/metrics", headers=eve).body.decode()
        c("sgad_jobs_accepted_total 0\n" in a, "nothing was started")
        c.status(d.ask("GET", "/v1/jobs/" + id_, headers=ann), 200, "who may submit")
        c(until(lambda: d.ask("GET", "/v1/jobs/" + id_, headers=eve).json().get("status") == "done"), "has it made again")


def shares(build, c):
    """No token holds the whole queue or all workers; seconds are reserved, and kept over a restart."""
    with Daemon(build, "--access", "tokens", "--workers", "2", "--queue", "10", "--token-queue", "50", "--token-workers", "50") as d:
        ann, bob, few = bearer(new_token(build, d, "ann")), bearer(new_token(build, d, "bob")), bearer(new_token(build, d, "few", "--seconds", "200"))
        c(until(lambda: d.ask("GET", "/v1/jobs", headers=few).status == 200), "tokens are there")
        answers = [d.ask("POST", "/v1/jobs", slow(), ann) for _ in range(12)]
        taken = [a.json()["id"] for a in answers if a.status == 202]
        c(4 <= len(taken) <= 6, "one token gets half of the queue", len(taken))
        c.problem(answers[-1], 429, "quota_exceeded", "not more")
        c(d.ask("POST", "/v1/solve", trivial(), bob).json()["status"] == "done", "the other finds a place and a worker")
        for id_ in taken:
            c.status(d.ask("DELETE", "/v1/jobs/" + id_, headers=ann), (200, 202), "cancelling")
        first = d.ask("POST", "/v1/jobs", slow(100), few)
        c.status(first, 202, "100 seconds of 200")
        c.problem(d.ask("POST", "/v1/jobs", slow(150), few), 429, "quota_exceeded", "150 more are reserved already")
        d.process.kill()
        d.ended()
        d.start()
        c.problem(d.ask("POST", "/v1/jobs", slow(150), few), 429, "quota_exceeded", "also after a crash")
        c.status(d.ask("DELETE", "/v1/jobs/" + first.json()["id"], headers=few), (200, 202), "cancelling")
        c(until(lambda: d.ask("POST", "/v1/jobs", slow(150), few).status == 202), "what was not used is given back")


def turns(build, c):
    """One user's long queue delays another's job by one job, not by all of them."""
    with Daemon(build, "--access", "tokens", "--workers", "1") as d:
        many, one = bearer(new_token(build, d, "many")), bearer(new_token(build, d, "one"))
        c(until(lambda: d.ask("GET", "/v1/jobs", headers=one).status == 200), "tokens are there")
        block = d.ask("POST", "/v1/jobs", slow(), many).json()["id"]
        c(until(lambda: d.ask("GET", "/v1/jobs/" + block, headers=many).json()["status"] == "running"), "the worker is busy")
        queue = [d.ask("POST", "/v1/jobs", trivial(), many).json()["id"] for _ in range(20)]
        late = [d.ask("POST", "/v1/jobs", trivial(), one).json()["id"] for _ in range(2)]
        d.ask("DELETE", "/v1/jobs/" + block, headers=many)

        def job(i, who):
            return d.ask("GET", "/v1/jobs/" + i, headers=who).json()
        c(until(lambda: all(job(i, many)["status"] == "done" for i in queue + late), 60), "all are done")

        def ended():
            with open(os.path.join(d.state, "test.log"), encoding="utf-8") as f:
                return re.findall(r'"event":"job_ended","job":"([0-9a-f]{32})"', f.read())
        c(until(lambda: set(queue + late) <= set(ended())), "all are told of in the log")
        order = ended()
        place = {i: order.index(i) for i in queue + late}
        before = [sum(place[q] < place[i] for q in queue) for i in late]
        c(before[0] <= 2 and before[1] <= 3, "the other user's jobs come in turn", before)
        c([place[q] for q in queue] == sorted(place[q] for q in queue), "one user's jobs keep their order")


def certificate(folder, name="localhost"):
    key, cert = os.path.join(folder, f"{name}.key"), os.path.join(folder, f"{name}.pem")
    subprocess.run(["openssl", "req", "-x509", "-newkey", "ec", "-pkeyopt", "ec_paramgen_curve:prime256v1", "-nodes", "-keyout", key, "-out", cert,
                    "-days", "2", "-subj", f"/CN={name}", "-addext", f"subjectAltName=DNS:{name},IP:127.0.0.1"], check=True, capture_output=True)
    return cert, key


def start(build, state, *flags, **more):
    """A daemon on a socket of any kind; its process and the line it printed."""
    guest = Daemon.guest
    if guest:
        more["env"] = {**(more.get("env") or os.environ), **guest.env()}
    p = subprocess.Popen([os.path.join(build, "sgad"), "--state", state, *flags], stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, **more)
    line = p.stdout.readline().strip()
    if guest:
        guest.began()
    return p, line


def finish(p):
    p.send_signal(signal.SIGTERM)
    try:
        _, err = p.communicate(timeout=30)
    except subprocess.TimeoutExpired:
        p.kill()
        _, err = p.communicate()
        if Daemon.guest:
            Daemon.guest.stuck(err)
    if Daemon.guest:
        Daemon.guest.lived(p.returncode, err)
    return p.returncode, err


def shown(port):
    """The certificate that a new connection gets, and its end by the metrics."""
    any_ = ssl.SSLContext(ssl.PROTOCOL_TLS_CLIENT)
    any_.check_hostname, any_.verify_mode = False, ssl.CERT_NONE
    with socket.create_connection(("127.0.0.1", port), timeout=10) as s, any_.wrap_socket(s) as t:
        t.sendall(b"GET /metrics HTTP/1.1\r\nHost: localhost\r\nConnection: close\r\n\r\n")
        text = b"".join(iter(lambda: t.recv(65536), b"")).decode()
        found = re.search(r"^sgad_certificate_expiry_timestamp_seconds (\d+)$", text, re.M)
        return t.getpeercert(True), int(found[1]) if found else 0


def renewal(p, port, folder, cert, key, c):
    """A certificate that is renewed is shown after SIGHUP, also to those who are connected already by their next connection."""
    first, ends = shown(port)
    c(86400 < ends - time.time() < 3 * 86400, "its end is a metric", ends)
    with open(cert, "rb") as f, open(key, "rb") as g:
        was = f.read(), g.read()
    with open(cert, "wb") as f:
        f.write(b"no certificate")
    p.send_signal(signal.SIGHUP)
    time.sleep(0.3)
    c(shown(port)[0] == first, "what is no certificate changes nothing")
    fresh = certificate(folder, "renewed")
    for new, old in zip(fresh, (cert, key)):
        shutil.copyfile(new, old)
    p.send_signal(signal.SIGHUP)
    c(until(lambda: shown(port)[0] != first), "SIGHUP: the renewed one is shown")
    for text, name in zip(was, (cert, key)):
        with open(name, "wb") as f:
            f.write(text)
    c(until(lambda: shown(port)[0] == first, 30), "by time of the file: also without a signal")


def tls(build, c):
    with tempfile.TemporaryDirectory() as folder:
        cert, key = certificate(folder)
        p, line = start(build, folder + "/state", "--listen", "127.0.0.1:0", "--tls-cert", cert, "--tls-key", key)
        try:
            c(line.startswith("listening on https://127.0.0.1:"), "TLS: the line", line)
            port = int(line.rsplit(":", 1)[1])
            trust = ssl.create_default_context(cafile=cert)
            h = http.client.HTTPSConnection("127.0.0.1", port, context=trust, timeout=30)
            h.request("POST", "/v1/solve", json.dumps(moving()), {"Content-Type": "application/json"})
            r = h.getresponse()
            c(r.status == 200 and json.loads(r.read())["status"] == "done", "TLS: solve", r.status)
            h.close()
            with socket.create_connection(("127.0.0.1", port), timeout=10) as s:
                s.sendall(b"GET /healthz HTTP/1.1\r\nHost: localhost\r\n\r\n")
                out = b""
                try:
                    out = s.recv(100)
                except OSError:
                    pass
                c(b"200" not in out, "TLS: plain text is not answered", out)
            path = folder + "/request.json"
            with open(path, "w", encoding="utf-8") as f:
                json.dump(moving(), f)

            def sga(host, *more, **env):
                return subprocess.run([os.path.join(build, "sga"), "solve", path, "--json", "--server", f"https://{host}:{port}", *more],
                                      capture_output=True, timeout=60, check=False, text=True, env={**os.environ, **env})
            for run in (sga("localhost", "--ca", cert), sga("127.0.0.1", SGA_CA=cert)):
                c(run.returncode == 0 and json.loads(run.stdout)["verdict"] == "unique", "TLS: the client", run.stderr)
            stranger, _ = certificate(folder, "stranger")
            for label, run in (("not trusted", sga("localhost")), ("trusting another", sga("localhost", "--ca", stranger)),
                               ("another name", sga("other.localhost", "--ca", cert)), ("no file", sga("localhost", "--ca", folder + "/none"))):
                c(run.returncode == 1 and not run.stdout and ("certificate" in run.stderr.lower()), f"TLS: the client, {label}: refused", run)
            run = subprocess.run([os.path.join(build, "sga"), "top", "--once", "--ca", cert, "--server", f"https://localhost:{port}"],
                                 capture_output=True, timeout=60, check=False, text=True)
            c(run.returncode == 0 and "store healthy" in run.stdout, "TLS: sga top", run)
            run = subprocess.run([os.path.join(build, "sga"), "solve", path, "--server", "http://host.invalid"], capture_output=True, timeout=60,
                                 check=False, text=True, env={**os.environ, "SGA_TOKEN": "secret"})
            c(run.returncode == 1 and "token is not sent" in run.stderr, "a token is not sent in the clear", run.stderr)
            for suite in ("AES128-SHA", "AES128-GCM-SHA256", "AES256-CCM", "ECDHE-ECDSA-AES128-SHA", "ECDHE-ECDSA-AES256-SHA384", "ECDHE-ECDSA-AES128-CCM"):
                weak = ssl.SSLContext(ssl.PROTOCOL_TLS_CLIENT)
                weak.check_hostname, weak.verify_mode, weak.maximum_version = False, ssl.CERT_NONE, ssl.TLSVersion.TLSv1_2
                weak.set_ciphers(suite + ":@SECLEVEL=0")
                try:
                    with socket.create_connection(("127.0.0.1", port), timeout=10) as s, weak.wrap_socket(s):
                        c(False, f"{suite} is refused")
                except (ssl.SSLError, OSError):
                    c(True, f"{suite} is refused")
            renewal(p, port, folder, cert, key, c)
            old = ssl.SSLContext(ssl.PROTOCOL_TLS_CLIENT)
            old.check_hostname, old.verify_mode = False, ssl.CERT_NONE
            old.set_ciphers("ALL:@SECLEVEL=0")
            old.minimum_version = ssl.TLSVersion.TLSv1
            old.maximum_version = ssl.TLSVersion.TLSv1_1
            try:
                with socket.create_connection(("127.0.0.1", port), timeout=10) as s, old.wrap_socket(s):
                    c(False, "TLS 1.1 is refused")
            except (ssl.SSLError, OSError):
                c(True, "TLS 1.1 is refused")
        finally:
            status, err = finish(p)
        c(status == 0, "TLS: ends with 0", err[-500:])
        other, _ = certificate(folder, "other")
        for flags in (["--tls-cert", cert], ["--tls-key", key], ["--tls-cert", cert, "--tls-key", folder + "/none"],
                      ["--tls-cert", other, "--tls-key", key], ["--tls-cert", key, "--tls-key", key]):
            run = sgad(build, "--listen", "127.0.0.1:0", "--state", folder + "/state", *flags)
            c(run.returncode in (1, 2) and run.stderr, f"refused: {[os.path.basename(f) for f in flags]}", run)


def remote(build, c):
    """Off loopback nothing starts by accident."""
    with tempfile.TemporaryDirectory() as folder:
        cert, key = certificate(folder)
        state, secure = folder + "/state", ["--tls-cert", cert, "--tls-key", key]
        plain, everyone = "--allow-remote-without-tls", "--allow-remote-without-tokens"
        for flags, named in (([], (plain, everyone)), (secure, (everyone,)), (["--access", "tokens"], (plain,)), ([plain], (everyone,)),
                             ([everyone], (plain,))):
            for address in ("0.0.0.0:0", "[::]:0"):
                run = sgad(build, "--listen", address, "--state", state, *flags)
                c(run.returncode == 1 and all(n in run.stderr for n in named), f"refused: {address} {flags[:1]}", run)
        # Bound to every address, and asked through loopback: nothing leaves this machine.
        for flags in ([*secure, "--access", "tokens"], [plain, everyone], [plain, "--access", "tokens"]):
            p, line = start(build, state, "--listen", "0.0.0.0:0", *flags)
            status, err = finish(p)
            c(line.startswith("listening on http") and status == 0, f"allowed: {flags[-1]}", err[-300:])


def sockets(build, c):
    class Unix(http.client.HTTPConnection):
        def connect(self):
            self.sock = socket.socket(socket.AF_UNIX)
            self.sock.settimeout(30)
            self.sock.connect(self.path)

    def solve(path):
        h = Unix("localhost")
        h.path = path
        h.request("POST", "/v1/solve", json.dumps(trivial()), {"Content-Type": "application/json"})
        status = h.getresponse().status
        h.close()
        return status
    with tempfile.TemporaryDirectory() as folder:
        path = folder + "/socket"
        p, line = start(build, folder + "/state", "--listen", "unix:" + path)
        try:
            c(line == "listening on unix:" + path, "UNIX socket: the line", line)
            c(solve(path) == 200, "UNIX socket: solve")
            c(os.stat(path).st_mode & 0o007 == 0, "UNIX socket: not for others")
            run = sgad(build, "--listen", "unix:" + path, "--state", folder + "/two")
            c(run.returncode == 1 and os.path.exists(path), "UNIX socket: one that answers is not taken over", run)
            p.kill()
            p.communicate()
            p, line = start(build, folder + "/state", "--listen", "unix:" + path)
            c(line and solve(path) == 200, "UNIX socket: the name of a dead one is used again")
        finally:
            status, err = finish(p)
        c(status == 0 and not os.path.exists(path), "UNIX socket: ends and leaves nothing", err[-300:])
        with open(path, "w", encoding="utf-8") as f:
            f.write("precious")
        run = sgad(build, "--listen", "unix:" + path, "--state", folder + "/state")
        c(run.returncode == 1 and open(path, encoding="utf-8").read() == "precious", "a file in the way is not touched", run)
        run = sgad(build, "--listen", "unix:relative", "--state", folder + "/state")
        c(run.returncode == 1, "a relative path is refused", run)

        # Passed as systemd does: descriptor 3, and the pid that only the child knows.
        with socket.create_server(("127.0.0.1", 0)) as s:
            script = 'exec 3<&"$FD" && LISTEN_FDS="$COUNT" LISTEN_PID=$$ exec "$@"'
            command = ["bash", "-c", script, "bash", os.path.join(build, "sgad"), "--listen", "systemd", "--state", folder + "/state"]
            env = {**os.environ, "FD": str(s.fileno())}
            p = subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, pass_fds=[s.fileno()], env={**env, "COUNT": "1"})
            line = p.stdout.readline().strip()
            c(line == f"listening on http://127.0.0.1:{s.getsockname()[1]}", "activation: the line", line)
            h = http.client.HTTPConnection("127.0.0.1", s.getsockname()[1], timeout=30)
            h.request("GET", "/healthz")
            c(h.getresponse().status == 200, "activation: it answers")
            h.close()
            status, err = finish(p)
            c(status == 0, "activation: ends with 0", err[-300:])
            run = subprocess.run(command, capture_output=True, timeout=30, check=False, pass_fds=[s.fileno()], env={**env, "COUNT": "2"})
            c(run.returncode == 1 and run.stderr, "activation: two sockets are refused", run)
        run = sgad(build, "--listen", "systemd", "--state", folder + "/state", env={**os.environ, "LISTEN_FDS": "1", "LISTEN_PID": "1"})
        c(run.returncode == 1 and "LISTEN_PID" in run.stderr, "activation: a socket for another process", run)


def handed_over(build, c):
    """As the shipped unit starts it: settings all at their defaults, the rest from systemd's environment."""
    with open(os.path.join(ROOT, "etc/sgad.service"), encoding="utf-8") as f:
        words = re.search(r"^ExecStart=/usr/bin/sgad (.*)$", f.read(), re.M)[1].replace("/etc/sgad.conf", os.path.join(ROOT, "etc/sgad.conf")).split()
    with tempfile.TemporaryDirectory() as folder, socket.create_server(("127.0.0.1", 0)) as s:
        cert, key = certificate(folder)
        os.mkdir(folder + "/credentials")
        os.mkdir(folder + "/none")
        shutil.copy(cert, folder + "/credentials/sgad.tls-cert")
        shutil.copy(key, folder + "/credentials/sgad.tls-key")
        given = {**os.environ, "STATE_DIRECTORY": folder + "/state", "CREDENTIALS_DIRECTORY": folder + "/none"}
        run = sgad(build, "--print-config", *words, env=given)
        c(run.stdout.startswith("listen = 127.0.0.1:8080\n") and f"\nstate = {folder}/state\n" in run.stdout and "# tls-cert" in run.stdout, "unit: settings", run)
        c(sgad(build, "--check-config", *words, env=given).returncode == 0, "unit: the shipped settings are good")
        for scheme, more in (("http", {}), ("https", {"CREDENTIALS_DIRECTORY": folder + "/credentials"})):
            command = ["bash", "-c", 'exec 3<&"$FD" && LISTEN_FDS=1 LISTEN_PID=$$ exec "$@"', "bash", os.path.join(build, "sgad"), *words]
            p = subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, pass_fds=[s.fileno()],
                                 env={**given, "FD": str(s.fileno()), **more})
            line = p.stdout.readline().strip()
            c(line == f"listening on {scheme}://127.0.0.1:{s.getsockname()[1]}", f"unit: {scheme}, on the socket that was passed", line)
            p.send_signal(signal.SIGHUP)
            until(lambda: os.path.exists(folder + "/state/queue.db"))
            status, err = finish(p)
            reloaded = [json.loads(text) for text in err.splitlines() if '"reloaded"' in text]
            c(status == 0 and all("needs_restart" not in e for e in reloaded), f"unit: {scheme}, ends with 0; read again, nothing differs", err[-500:])
        os.remove(folder + "/credentials/sgad.tls-key")
        run = sgad(build, "--check-config", *words, env={**given, "CREDENTIALS_DIRECTORY": folder + "/credentials"})
        c(run.returncode == 2 and "tls-key is missing" in run.stderr, "unit: half a pair of credentials is refused", run.stderr)


def several(build, c):
    """More than one address at once: each by its own rules."""
    with tempfile.TemporaryDirectory() as folder:
        cert, key = certificate(folder)
        path, request = folder + "/socket", folder + "/request.json"
        with open(request, "w", encoding="utf-8") as f:
            json.dump(moving(), f)
        p, line = start(build, folder + "/state", "--listen", f"127.0.0.1:0,unix:{path},127.0.0.1:0", "--tls-cert", cert, "--tls-key", key)
        try:
            found = re.fullmatch(r"listening on (https://127\.0\.0\.1:\d+), (unix:\S+), (https://127\.0\.0\.1:\d+)", line)
            if c(found, "several addresses: the line", line):
                answers = []
                for url in found.groups():
                    run = subprocess.run([os.path.join(build, "sga"), "solve", request, "--json", "--ca", cert, "--server", url], capture_output=True,
                                         timeout=60, check=False, text=True)
                    c(run.returncode == 0, f"several addresses: {url.split(':')[0]}", run.stderr)
                    answers.append(run.stdout)
                c(answers[0] and len(set(answers)) == 1, "several addresses: one service")
        finally:
            status, err = finish(p)
        c(status == 0 and not os.path.exists(path), "several addresses: ends and leaves nothing", err[-300:])
        for wrong, word in ((f"unix:{path},127.0.0.1", "needs HOST:PORT"), (",127.0.0.1:0", "commas"), ("127.0.0.1:0,,127.0.0.1:0", "commas"),
                            (",".join(["127.0.0.1:0"] * 9), "1 to 8"), (f"unix:{path},0.0.0.0:0", "no loopback address")):
            run = sgad(build, "--listen", wrong, "--state", folder + "/state")
            c(run.returncode == 1 and word in run.stderr and not os.path.exists(path), f"refused: --listen {wrong[:20]}", run)


def settings(build, c):
    sample = sgad(build, "--sample-config").stdout
    with open(os.path.join(ROOT, "etc/sgad.conf"), encoding="utf-8") as f:
        c(f.read() == sample, "etc/sgad.conf is what --sample-config prints")
    defaults = re.findall(r"^#([a-z-]+) =(.*)$", sample, re.M)
    help_, manual = sgad(build, "--help").stdout, ""
    with open(os.path.join(ROOT, "etc/man/sgad.conf.5"), encoding="utf-8") as f:
        manual = f.read().replace("\\-", "-")
    c(len(defaults) > 20, "settings", len(defaults))
    for name, value in defaults:
        c(re.search(rf"^  --{name}\b", help_, re.M), f"--help has {name}")
        c(re.search(rf"^\.B {name}\n", manual, re.M), f"sgad.conf(5) has {name}")
        c(not value.strip() or f"Default: {value.strip()}." in re.split(r"^\.TP$", manual[manual.find(f".B {name}\n"):], 1, re.M)[0],
          f"sgad.conf(5): default of {name}", value)
    c(set(re.findall(r"^\.B ([a-z][a-z-]*)$", manual, re.M)) == {n for n, _ in defaults}, "sgad.conf(5) has no other setting")
    with tempfile.TemporaryDirectory() as folder:
        path = folder + "/sgad.conf"

        def write(text):
            with open(path, "w", encoding="utf-8") as f:
                f.write(text)
            return path
        needed = f"listen = 127.0.0.1:0\nstate = {folder}/state\n"
        write(needed + re.sub(r"^#([a-z-]+ = .+)$", r"\1", sample, flags=re.M))
        c(sgad(build, "--check-config", "--config", path).returncode == 0, "every default can be set")
        shown = sgad(build, "--print-config", "--config", path, "--queue", "7").stdout
        c("\nqueue = 7\n" in shown, "flags override the file", shown)
        write(shown)
        c(sgad(build, "--print-config", "--config", path).stdout == shown, "what is printed can be read back")
        c(not os.path.exists(folder + "/state"), "checking touches no state")
        for text, word in (("queue = many\n", ":3: queue must be"), ("queue = 0\n", "from 1 to"), ("nonsense = 1\n", "no setting 'nonsense'"),
                           ("queue\n", "key = value"), ("access = some\n", "access must be"), ("log-level = loud\n", "log-level must be"),
                           ("tls-cert = /none\n", "tls-key is missing"), ("allow-remote-without-tls = 1\n", "yes or no")):
            run = sgad(build, "--check-config", "--config", write(needed + text))
            c(run.returncode == 2 and word in run.stderr, f"refused: {text.strip()}", run)
        write(needed + "queue = 5\nworkers = 1\n")
        p, line = start(build, folder + "/state", "--config", path)
        try:
            c(line, "started from a file")
            write(needed + "queue = 1\nworkers = 2\nstreams = 0\n")
            p.send_signal(signal.SIGHUP)
            text = next(l for l in p.stderr if '"reloaded"' in l)
            c('"needs_restart":"workers"' in text, "a reload says what needs a new start", text)
            port = int(line.rsplit(":", 1)[1])

            def post():
                h = http.client.HTTPConnection("127.0.0.1", port, timeout=30)
                h.request("POST", "/v1/jobs", json.dumps(slow()), {"Content-Type": "application/json"})
                status = h.getresponse().status
                h.close()
                return status
            seen = [post() for _ in range(4)]
            c(503 in seen, "a reload changes the limits", seen)
            write(needed + "queue = none\n")
            p.send_signal(signal.SIGHUP)
            text = next(l for l in p.stderr if "reload" in l)
            c("reload_refused" in text and p.poll() is None, "wrong settings change nothing", text)
        finally:
            c(finish(p)[0] == 0, "ends with 0")


def upkeep(build, c):
    with Daemon(build) as d:
        state, folder = os.path.join(d.state, "sgad"), os.path.join(d.state, "backup")
        done = d.ask("POST", "/v1/solve", moving()).json()
        run = sgad(build, "backup", folder, "--state", state)
        c(run.returncode == 0, "backup while it runs", run.stderr)
        after = d.ask("POST", "/v1/solve", moving()).json()
        c(sgad(build, "backup", folder, "--state", state).returncode == 1, "a backup is never overwritten")
        run = sgad(build, "check", "--state", state)
        c(run.returncode == 0 and run.stdout == "queue.db: ok\ncache.db: ok\n", "check while it runs", run)
        p, line = start(build, folder, "--listen", "127.0.0.1:0")
        try:
            port = int(line.rsplit(":", 1)[1])

            def get(id_):
                h = http.client.HTTPConnection("127.0.0.1", port, timeout=30)
                h.request("GET", "/v1/jobs/" + id_)
                r = h.getresponse()
                out = r.status, r.read()
                h.close()
                return out
            # A reply does not wait for the disk: the copy may hold the job as one that still runs.
            until(lambda: b'"result"' in get(done["id"])[1], 30)
            status, body = get(done["id"])
            c(status == 200 and json.loads(body)["result"] == done["result"], "a backup is a state folder", (status, body[:200]))
            c(get(after["id"])[0] == 404, "what came later is not in it")
        finally:
            c(finish(p)[0] == 0, "ends with 0")
        c(not os.path.exists(folder + ".partial"), "nothing half is left")
        with open(os.path.join(state, "instance"), encoding="ascii") as f, open(os.path.join(folder, "instance"), encoding="ascii") as g:
            c(f.read() == g.read(), "the name of the state goes with it")
        fresh = os.path.join(d.state, "restored")
        run = sgad(build, "restore", folder, "--state", fresh)
        c(run.returncode == 0 and sorted(os.listdir(fresh))[0] == "cache.db", "restore", run.stderr)
        c(sgad(build, "restore", folder, "--state", fresh).returncode == 1, "a state is never overwritten")
        for name, sql in (("queue.db", "UPDATE jobs SET request = CAST(request AS TEXT) || ' '"), ("cache.db", "UPDATE results SET result = x'7b7d'")):
            with sqlite3.connect(os.path.join(fresh, name)) as db:
                db.execute(sql)
            db.close()
            run = sgad(build, "check", "--state", fresh)
            c(run.returncode == 1 and f"{name}: the text of job " in run.stdout, f"check verifies the digests in {name}", run.stdout)
        run = sgad(build, "backup", folder + "3", "--state", fresh)
        c(run.returncode == 1 and "damaged" in run.stderr and not os.path.exists(folder + "3") and not os.path.exists(folder + "3.partial"),
          "a backup of what is damaged is none", run.stderr)
        for name, bad in (("queue.db", 1), ("cache.db", 1)):
            path = os.path.join(folder, name)
            db = sqlite3.connect(path)
            db.execute("PRAGMA wal_checkpoint(TRUNCATE)")
            db.close()
            size = os.path.getsize(path)
            with open(path, "r+b") as f:
                f.seek(4096)
                f.write(b"\xa5" * min(4096, size - 4096))
            run = sgad(build, "restore", folder, "--state", fresh + name)
            c(run.returncode == 1 and "damaged" in run.stderr and not os.path.exists(fresh + name) and not os.path.exists(fresh + name + ".partial"),
              f"a backup whose {name} is damaged is not restored", run.stderr)
            run = sgad(build, "check", "--state", folder)
            c(run.returncode == bad and f"{name}: ok" not in run.stdout, f"check finds damage in {name}", run)
        for wrong in (["backup"], ["backup", folder], ["backup", "a", "b", "--state", state], ["check", "x", "--state", state]):
            c(sgad(build, *wrong).returncode == 2, f"refused: sgad {wrong[0]} with {len(wrong)} words")
        c(sgad(build, "check", "--state", "/nonexistent/x").returncode == 1, "check of nothing")
        c(sgad(build, "backup", folder + "2", "--state", "/nonexistent/x").returncode == 1, "backup of nothing")


def unit(build, c):
    """The service file, by systemd's own measure, where that tool is installed."""
    tool = shutil.which("systemd-analyze")
    path = os.path.join(ROOT, "etc/sgad.service")
    with open(path, encoding="utf-8") as f:
        text = f.read()
    c("NoNewPrivileges=yes" in text and "User=sgad" in text and "User=root" not in text, "sgad.service is hardened")
    c("Type=notify\n" in text and "WatchdogSec=" in text and not re.search("^IPAddress", text, re.M), "sgad.service tells that it is ready, and shuts no client out")
    if tool:
        with tempfile.TemporaryDirectory() as folder:
            for name in ("sgad.service", "sgad.socket"):
                with open(os.path.join(ROOT, "etc", name), encoding="utf-8") as f, open(f"{folder}/{name}", "w", encoding="utf-8") as out:
                    out.write(re.sub("^Documentation=.*\n", "", f.read(), flags=re.M).replace("/usr/bin/sgad", os.path.abspath(os.path.join(build, "sgad"))))
            run = subprocess.run([tool, "verify", f"{folder}/sgad.service", f"{folder}/sgad.socket"], capture_output=True, timeout=60, check=False, text=True)
            c(run.returncode == 0 and "sgad" not in run.stderr, "the units are sound", run)
        run = subprocess.run([tool, "security", "--offline=true", path], capture_output=True, timeout=60, check=False, text=True)
        level = re.search(r"exposure level for sgad.service: ([0-9.]+)", run.stdout)
        c(level and float(level[1]) < 2.5, "sgad.service: exposure below 2.5", run.stdout[-200:] + run.stderr)


ALL = [tokens, cut_short, quotas, owners, isolated, crowd_of_one, reading_only, shares, turns, tls, remote, sockets, handed_over, several, settings, upkeep, unit]
