"""Faults of the environment: what was promised stays promised, and the service goes on.

The shim (shim.c) stands between the daemon and the C library."""
import contextlib
import os
import re
import signal
import sqlite3
import time

from common import moving, slow, trivial
from daemon import Daemon
from shim import sanitized, shim

def metric(d, name):
    found = re.search(rf"^sgad_{re.escape(name)} (\S+)$", d.get("/metrics").body.decode(), re.M)
    return float(found[1]) if found else None


def unread_log(build, c):
    """Nobody reads the log: requests go on, and what was dropped is counted and told."""
    reader, writer = os.pipe()
    try:
        with Daemon(build, stderr=writer) as d:
            asked, seen = 0, set()
            while asked < 20000 and not metric(d, "log_dropped_total"):
                seen |= {d.get("/v1/jobs/" + "a" * 32).status for _ in range(200)}
                asked += 200
            c(seen == {404}, "requests while nobody reads the log", seen)
            c(metric(d, "log_dropped_total"), "lines that nobody reads are dropped and counted", asked)
            c.status(d.get("/healthz"), 200, "healthy while nobody reads the log")
            c(d.ask("POST", "/v1/solve", trivial()).json()["status"] == "done", "a job while nobody reads the log")
            c(d.stop() == 0, "it ends while nobody reads the log")
    finally:
        os.close(reader)
        os.close(writer)


def until(condition, seconds=60):
    """Whether it comes true within a bound that only a failing test meets."""
    end = time.monotonic() + seconds
    while not condition():
        if time.monotonic() > end:
            return False
        time.sleep(0.02)
    return True


def status_of(d, id_):
    return d.get("/v1/jobs/" + id_).json()["status"]


def kill_children(d, role="sgad-job"):
    """How many: one that was just started has its name a little later."""
    pids = d.children(role)               # children of the daemon that this test started
    for pid in pids:
        os.kill(pid, signal.SIGKILL)
    return len(pids)


def no_children(build, c):
    """No process can be started: jobs wait, the service is not ready, and all ends well afterwards."""
    if sanitized(build):
        return
    with shim() as s, Daemon(build, "--workers", "2", env=s.env) as d:
        going = [d.ask("POST", "/v1/jobs", slow()).json()["id"] for _ in range(2)]
        c(until(lambda: all(status_of(d, i) == "running" for i in going)), "both workers run a job")
        waiting = [d.ask("POST", "/v1/jobs", trivial()).json()["id"] for _ in range(20)]
        s.set(spawn=1)
        kill_children(d)
        c(until(lambda: d.get("/readyz").status == 503), "not ready without a process")
        c(until(lambda: metric(d, "child_start_failures_total") >= 4), "starting one is tried again")
        c({status_of(d, i) for i in going + waiting} == {"queued"}, "without a process jobs wait")
        c.status(d.ask("POST", "/v1/jobs", trivial()), 202, "a job without a process to run it")
        kill_children(d, "sgad-check")
        c.problem(d.ask("POST", "/v1/jobs", trivial()), 503, "busy", "a job without a process to check it")
        for id_ in going:
            c.status(d.ask("DELETE", "/v1/jobs/" + id_), 200, "what was taken back can be cancelled")
        s.set()
        c({d.wait(i)["status"] for i in waiting} == {"done"}, "with processes again they run")
        c(until(lambda: d.get("/readyz").status == 200), "ready again")


def computes(d, id_):
    """Whether a process has the job and said so: one that dies before it has it is no fault of the job."""
    job = d.get("/v1/jobs/" + id_).json()
    return job["status"] == "running" and job["progress"]["stage"] not in ("queued", "running")     # "running": taken by a worker


def killed_once(build, c):
    """A process that is killed once, as where the machine's memory ends, fails no job; twice does."""
    with Daemon(build, "--workers", "1") as d:
        for kills, code in ((1, "cancelled"), (2, "worker_died")):
            before = metric(d, "child_deaths_total")
            id_ = d.ask("POST", "/v1/jobs", slow()).json()["id"]
            for k in range(kills):
                c(until(lambda: metric(d, "child_deaths_total") == before + k and computes(d, id_)), f"it runs after {k} kills")
                c(until(lambda: kill_children(d)), f"its process is found after {k} kills")
            c(until(lambda: metric(d, "child_deaths_total") == before + kills), "the death is seen")
            if kills == 1:
                c(until(lambda: status_of(d, id_) == "running"), "a job whose process was killed once runs again")
                c.status(d.ask("DELETE", "/v1/jobs/" + id_), 200, "and can be cancelled")
            c(d.wait(id_).get("error", {}).get("code") == code, f"a job whose process was killed {kills} times")


def crash(d):
    d.process.kill()
    d.ended()
    d.start()


def told_ends(build, c):
    """What a client was told to have ended, has: on a slow disk, over kill -9 the moment after."""
    if sanitized(build):
        return
    with shim() as s, Daemon(build, "--workers", "1", env=s.env) as d:
        for _ in range(4):
            going = d.ask("POST", "/v1/jobs", slow()).json()["id"]
            behind = d.ask("POST", "/v1/jobs", trivial()).json()["id"]
            c(until(lambda i=going: status_of(d, i) == "running"), "a job runs")
            s.set(write=30)
            a = d.ask("DELETE", "/v1/jobs/" + behind)
            c.status(a, 200, "a waiting job is cancelled")
            s.set()
            crash(d)
            job = d.get("/v1/jobs/" + behind).json()
            c(job["status"] == "cancelled" and job["finished"] == a.json()["finished"], "a cancellation stays over a crash", job)
            d.ask("DELETE", "/v1/jobs/" + going)
            s.set(write=30)
            a = d.ask("POST", "/v1/solve", trivial())
            c(a.status == 200 and a.json()["status"] == "done", "an answer on a slow disk", a.body[:200])
            s.set()
            crash(d)
            b = d.get("/v1/jobs/" + a.json()["id"])
            c(b.headers.get("etag") == a.headers["etag"], "an end stays over a crash", (a.headers, b.status, b.headers))


def large(k):
    """A result of about a megabyte."""
    return {"system": {"form": "equations", "variables": ["x", "y"], "equations": ["x' = y", f"y' = -{k}*x"]}, "want": ["trajectory"],
            "trajectory": {"start": 0, "stop": 1, "samples": 20000, "initial": {"x": 0, "y": k}}}


def slow_disk(build, c):
    """Results come faster than the disk takes them: they are few in memory, and a 202 does not wait for them."""
    if sanitized(build):
        return
    limit = 2 << 20
    with shim() as s, Daemon(build, "--workers", "2", "--cache-memory", "0", "--unsaved-memory", str(limit), env=s.env) as d:
        s.set(write=1)
        ids = [d.ask("POST", "/v1/jobs", large(k)).json()["id"] for k in range(1, 8)]
        most, quick = 0, False
        while any(status_of(d, i) in ("queued", "running") for i in ids):
            most = max(most, metric(d, "unsaved_bytes"))
            if most > 0 and not quick:
                c.status(d.ask("POST", "/v1/jobs", trivial()), 202, "a job beside results on their way")
                quick = metric(d, "unsaved_bytes") > 0
        c(quick, "its 202 does not wait for them")
        c(0 < most < limit + 3 * (2 << 20), "results that wait for the disk are few", most)
        c(all(status_of(d, i) == "done" for i in ids), "all end")


def standing_disk(build, c):
    """A disk that does not come back: the post is answered all the same."""
    if sanitized(build):
        return
    with shim() as s, Daemon(build, "--store-timeout", "1", env=s.env) as d:
        s.set(write=4000)
        a = d.ask("POST", "/v1/jobs", trivial(), seconds=50)
        c.problem(a, 503, "store_failed", "a job on a disk that stands still")
        s.set()


def kept_answers(build, c):
    """The file of results takes nothing for a while: no job is done without its answer, over a restart neither."""
    with Daemon(build, "--workers", "1", "--cache-memory", "0") as d:
        for again in (False, True):
            with contextlib.closing(sqlite3.connect(os.path.join(d.state, "sgad", "cache.db"), isolation_level=None)) as db:
                db.execute("BEGIN IMMEDIATE")
                with open(os.path.join(d.state, "test.log"), encoding="utf-8") as f:
                    f.seek(0, os.SEEK_END)
                    id_ = d.ask("POST", "/v1/jobs", trivial()).json()["id"]
                    c(until(lambda log=f: "cache_write_failed" in log.read()), "a result is not written", d.errors())
                c(status_of(d, id_) == "running", "its job is not done", status_of(d, id_))
                if again:
                    crash(d)
                db.execute("ROLLBACK")
            job = d.wait(id_)
            c(job["status"] == "done", "it is done once the file takes it", job)
            a = d.get("/v1/jobs/" + id_)
            crash(d)
            b = d.get("/v1/jobs/" + id_)
            c(b.status == 200 and b.headers.get("etag") == a.headers.get("etag") and b.body == a.body, "its answer is there after a restart", (b.status, b.body[:200]))


def storing(d, id_):
    return (d.get("/v1/jobs/" + id_).json().get("progress") or {}).get("stage") == "storing"


def one_not_kept(build, c):
    """One result that is not taken keeps no other from being written; it is not ready while that lasts, and tells no end of it."""
    with Daemon(build, "--workers", "1") as d:
        c(d.ask("POST", "/v1/solve", trivial()).status == 200, "a job")
        with contextlib.closing(sqlite3.connect(os.path.join(d.state, "sgad", "cache.db"), isolation_level=None)) as db:
            db.execute("CREATE TRIGGER small BEFORE INSERT ON results WHEN length(new.result) > 30000 BEGIN SELECT RAISE(ABORT, 'no room'); END")
            large = d.ask("POST", "/v1/jobs", moving(samples=2000)).json()["id"]
            c(until(lambda: storing(d, large)), "a result that is not taken", d.errors())
            for _ in range(5):
                db.execute("BEGIN IMMEDIATE")          # so that all gather
                ids = [d.ask("POST", "/v1/jobs", trivial()).json()["id"] for _ in range(4)]
                c(until(lambda ids=ids: all(storing(d, i) for i in ids)), "others come to an end")
                db.execute("ROLLBACK")
                c(all(d.wait(i)["status"] == "done" for i in ids), "others are written")
            c(until(lambda: d.get("/readyz").status == 503), "not ready while it cannot be written")
            c.problem(d.get("/readyz"), 503, "store_failed", "readiness says why")
            c(status_of(d, large) == "running", "its end is not told", status_of(d, large))
            db.execute("DROP TRIGGER small")
        c(d.wait(large)["status"] == "done" and len(d.get("/v1/jobs/" + large).json()["result"]["trajectory"]["rows"]) == 2000, "it is done once it is taken")
        c(until(lambda: d.get("/readyz").status == 200), "ready again")


def clock_back(build, c):
    """The clock of the day is put back while a job runs: times stay in order, durations are those that passed."""
    if sanitized(build):
        return
    with shim() as s, Daemon(build, "--workers", "1", env=s.env) as d:
        id_ = d.ask("POST", "/v1/jobs", slow()).json()["id"]
        c(until(lambda: status_of(d, id_) == "running"), "a job runs")
        s.set(clock=-7200)
        d.ask("DELETE", "/v1/jobs/" + id_)
        job = d.wait(id_)
        c(job["created"] <= job["started"] <= job["finished"], "times are in order", job)
        c(0 <= metric(d, "job_duration_seconds_sum") < 600, "the duration is that which passed", metric(d, "job_duration_seconds_sum"))


ALL = [unread_log, no_children, killed_once, told_ends, slow_disk, standing_disk, kept_answers, one_not_kept, clock_back]
