"""What is too large ends by its own limit, with the figure, and nothing else notices."""
import http.client
import json
import math
import os
import resource
import signal
import threading
import time

import schemas
from common import moving, slow, trivial
from daemon import Daemon


def names(n):
    return [f"x{i}" for i in range(n)]


def identity(n):
    return {"rows": n, "cols": n, "entries": [[i, i, 1] for i in range(n)]}


def dense(n, limits):
    """A matrix of n^2 different products of variables."""
    v = names(n)
    rows = [[f"{v[(7 * i + 3 * j) % n]}*{v[j]} + {i + 1}" for j in range(n)] for i in range(n)]
    return {"system": {"form": "quasilinear", "variables": v, "A": rows, "alpha": v}, "limits": limits}


def chain(n, limits):
    """Each derivative of a sum of products is longer than the one before."""
    v = names(n)
    a = {"rows": n, "cols": n, "entries": [[i, i, 1] for i in range(n - 1)]}
    alpha = [f"{q} + {p}^2*sin({p})" for p, q in zip(v, v[1:])] + ["x0 - sin(t)*x0^2"]
    return {"system": {"form": "quasilinear", "variables": v, "A": a, "alpha": alpha}, "limits": limits}


def numbers(limits):
    rows = [[f"{2 * i + 3}^300 + {3 * j + 2}^310*{i + j + 1}" for j in range(6)] for i in range(6)]
    return {"system": {"form": "quasilinear", "variables": names(6), "A": rows, "alpha": names(6)}, "limits": limits}


def operator(degree, limits):
    """Polynomials in time so long that single calls of the algebra take seconds."""
    def entry(i):
        return "+".join(f"{(7 * i + 3 * k) % 19 - 9}*t^{k}" for k in range(degree))
    rows = [[[entry(9 * i + 3 * j + k) for k in range(3)] for j in range(3)] for i in range(3)]
    return {"system": {"form": "operator", "unknowns": names(3), "coefficients": rows}, "limits": limits}


def samples(n, count):
    return {"system": {"form": "quasilinear", "variables": names(n), "A": identity(n), "alpha": [f"-{x}" for x in names(n)]},
            "trajectory": {"start": 0, "stop": 1, "samples": count, "initial": {"x0": 1}}, "want": ["trajectory"]}


def sums(count, power):
    """Exact numbers by the thousand: refused while they are read."""
    alpha = ["+".join(f"{k}^{power}*x0" for k in range(3, 1003))] * count
    return {"system": {"form": "quasilinear", "variables": names(count), "A": identity(count), "alpha": alpha}}


# name: (request, code, a figure that the message names, pointer)
CASES = {
    "seconds": (slow(0.7), "time_limit", "0.7 seconds", None),
    "seconds in the reduction": (dense(60, {"seconds": 1}), "time_limit", "1 seconds", None),
    "seconds in one call": (operator(400, {"seconds": 1}), "time_limit", "1 seconds", None),
    "memory": (dense(60, {"megabytes": 48}), "memory_limit", "48 MB", None),
    "memory in texts": (dense(120, {"megabytes": 60}), "memory_limit", "60 MB", None),
    "nodes": (chain(30, {"nodes": 20000}), "node_limit", "20000", None),
    "generations": (chain(8, {"generations": 3}), "generation_limit", "3", None),
    "bits": (numbers({"bits": 2000}), "bit_limit", "2000 bits", None),
    "samples": (samples(20000, 1000000), "result_limit", "1000000 samples", "/trajectory"),
    "samples in memory": ({**samples(100, 30000), "limits": {"megabytes": 20}}, "memory_limit", "20 MB", "/trajectory"),
    "result": (samples(100, 40000), "result_limit", "MB", None),
}


def ended(build, c):
    """Each limit by itself, beside normal requests."""
    with Daemon(build, "--workers", "2", "--result-limit", str(8 << 20)) as d:
        jobs, wrong, stop = {}, [], threading.Event()

        def others():
            while not stop.is_set():
                for a in (d.get("/healthz"), d.get("/metrics"), d.ask("POST", "/v1/jobs", "{}")):
                    if a.status not in (200, 422):
                        wrong.append((a.status, a.body[:200]))
                time.sleep(0.05)
        watcher = threading.Thread(target=others)
        watcher.start()
        for name, (request, *_) in CASES.items():
            a = d.ask("POST", "/v1/jobs", request)
            if c(a.status == 202, f"limit of {name}: accepted", a.body[:300]):
                jobs[name] = a.json()["id"]
            good = d.ask("POST", "/v1/jobs", moving())
            jobs["normal beside " + name] = good.json()["id"]
        for name, id_ in jobs.items():
            job = d.wait(id_, 120)
            if name.startswith("normal"):
                c(job["status"] == "done", name, job.get("error"))
                continue
            _, code, figure, pointer = CASES[name]
            error = job.get("error", {})
            c(error.get("code") == code, f"limit of {name}: code {code}", error or job.get("result", {}).get("verdict"))
            c(figure in error.get("detail", ""), f"limit of {name}: the figure", error)
            c(error.get("pointer") == pointer, f"limit of {name}: the place", error)
            c(error.get("stage"), f"limit of {name}: the stage", error)
        stop.set()
        watcher.join()
        c(not wrong, "health checks, metrics and refusals go on", wrong[:3])
        c.status(d.get("/healthz"), 200, "alive")


def wide(n, limits):
    """Nonlinear, and coupled across: no machine reduces 200,000 of them in seconds."""
    v = names(n)
    equations = [f"{v[i]}' = -{v[i]}^3 + {i % 7 + 1}*{v[(i + 1) % n]} - sin({v[(7 * i + 3) % n]})" if i % 2 == 0
                 else f"{v[i]}^3 + {v[i]} = {v[(i + 1) % n]} + {i % 5 + 1}*{v[i - 1]}*sin({v[(7 * i + 3) % n // 2 * 2]})/2" for i in range(n)]
    return {"system": {"form": "equations", "variables": v, "equations": equations}, "want": ["index", "constraints"], "limits": limits}


def large_ended(build, c):
    """A large job ends by its own limit, the time for reading it included, before its worker loses patience."""
    with Daemon(build, "--workers", "1", "--body-limit", str(64 << 20)) as d:
        for seconds in (4, 8):
            job = d.wait(d.ask("POST", "/v1/jobs", wide(200000, {"seconds": seconds})).json()["id"], 120)
            error = job.get("error", {})
            c(error.get("code") == "time_limit" and f"{seconds} seconds" in error.get("detail", ""), f"{seconds} s: its limit", error or job.get("status"))
            c("had not come to an end" not in error.get("detail", ""), f"{seconds} s: by itself", error)
        c(d.wait(d.ask("POST", "/v1/jobs", trivial()).json()["id"])["status"] == "done", "the next one runs")


def rows_kept(build, c):
    """A motion whose time ends gives the rows that it has, with errors that hold; one that came no further than its start fails."""
    with Daemon(build, "--workers", "1") as d:
        request = slow(2)
        request["trajectory"].update(samples=400001, stop=8000, events=[{"name": "zero", "expression": "x"}])
        omega = float(request["system"]["equations"][0].split("*x")[0].split("-")[1]) ** 0.5
        job = d.ask("POST", "/v1/solve", request, {"Prefer": "wait=60"}, seconds=90).json()
        t = job.get("result", {}).get("trajectory")
        if not c(job["status"] == "done" and t, "rows kept: the job is done", job.get("error")):
            return
        end, rows = t["ended"], t["rows"]
        c(end and end["reason"] == "time_limit" and "2 seconds" in end["detail"] and 1 < len(rows) < 400001, "rows kept: it says that the time ended", end)
        c(0 < rows[-1][0] <= end["t"] < 8000 and all(e["t"] <= end["t"] for e in t["events"]), "rows kept: none and no event lies past the end", (rows[-1], end))
        c(not schemas.faults(c.result_schema, job["result"]), "rows kept: schema")
        # Sines by the hundred of some 1e-15 beside the spring add no more than this.
        noise = 400e-15 * omega * rows[-1][0]
        wrong = [(r, e) for r, e in zip(rows, t["errors"]) if e is None or not abs(r[1] - math.cos(omega * r[0])) <= e + noise]
        c(not wrong and t["error_estimate"] is not None, "rows kept: their errors hold", wrong[:2])
        zeros = [e for e in t["events"] if e["name"] == "zero"]
        c(len(zeros) == math.floor(omega * end["t"] / math.pi + 0.5) and all(abs(math.cos(omega * e["t"])) <= omega * e["error"] + 1e-9 for e in zeros), "rows kept: every event up to there", len(zeros))
        csv = d.get(f"/v1/jobs/{job['id']}/trajectory?format=csv")
        c(csv.status == 200 and csv.body.count(b"\n") == len(rows) + 1, "rows kept: as CSV")
        request = slow(0.5)
        error = d.ask("POST", "/v1/solve", request, {"Prefer": "wait=60"}).json().get("error", {})
        c(error.get("code") == "time_limit" and "limit of 0.5 seconds" in error["detail"], "rows kept: the start alone is no answer", error)


def progress_t(build, c):
    """While a motion is made, progress says where it is: `t` in the system's time, which moves on."""
    with Daemon(build, "--workers", "1") as d:
        path = "/v1/jobs/" + d.ask("POST", "/v1/jobs", slow(600)).json()["id"]
        seen = []
        for _ in range(6000):
            job = d.get(path).json()
            t = job["progress"].get("t")
            if t is not None and t not in seen:
                seen.append(t)
                c(job["status"] == "running" and job["progress"]["stage"] == "trajectory" and 0 < job["progress"]["fraction"] < 1, "progress t: of a motion that runs", job)
                c(not schemas.faults(c.job_schema, job), "progress t: schema", job)
            if len(seen) > 2 or job["status"] not in ("queued", "running"):
                break
            time.sleep(0.01)
        c(len(seen) > 2 and 0 <= seen[0] < seen[1] < seen[2] <= 8000, "progress t: it moves on", (seen, job))
        c.status(d.ask("DELETE", path), (200, 202, 204), "progress t: cancelled")
        for _ in range(6000):
            job = d.get(path).json()
            if job["status"] not in ("queued", "running"):
                break
            time.sleep(0.01)
        c(job["status"] == "cancelled" and "t" not in job["progress"], "progress t: none after the end", job)


def maxima(build, c):
    """The service's maxima hold where a request asks for more."""
    with Daemon(build, "--workers", "1", "--max-seconds", "1", "--child-memory", str(320 << 20)) as d:
        job = d.ask("POST", "/v1/solve", slow(1000), {"Prefer": "wait=60"}).json()
        c("limit of 1 seconds" in job.get("error", {}).get("detail", ""), "max-seconds holds", job.get("error"))
        job = d.ask("POST", "/v1/solve", dense(60, {"seconds": 1000, "megabytes": 100000}), {"Prefer": "wait=60"}).json()
        c(job.get("error", {}).get("code") in ("memory_limit", "time_limit"), "child-memory holds", job.get("error"))
    with Daemon(build, "--workers", "1", "--child-memory", str(200 << 20)) as d:
        job = d.ask("POST", "/v1/solve", dense(60, {"seconds": 60, "megabytes": 100000}), {"Prefer": "wait=90"}).json()
        c(job.get("error", {}).get("code") == "memory_limit", "child-memory is told as memory_limit", job.get("error"))
        job = d.ask("POST", "/v1/solve", trivial()).json()
        c(job["status"] == "done", "the next job runs", job)


def refused(build, c):
    """What is refused while it is read costs the daemon little."""
    with Daemon(build, "--workers", "1") as d:
        for name, request in (("many large numbers", sums(100, 9000)), ("many equal numbers", sums(100, 8999))):
            p = c.problem(d.ask("POST", "/v1/jobs", request), 422, "number_too_large", name)
            c("268435456 bits" in p.get("detail", "") and p.get("pointer", "").startswith("/system/alpha/"), name, p)
        # a short text whose system of first order has millions of terms: judged where it runs
        names_ = [f"q{i}" for i in range(2000)]
        long = {"system": {"form": "lagrangian", "coordinates": names_, "lagrangian": "*".join(f"(1+{q}'^2*{q}^2)" for q in names_)},
                "limits": {"seconds": 2}}
        a = d.ask("POST", "/v1/jobs", long)
        c.status(a, 202, "a short text with a long meaning is accepted")
        error = d.wait(a.json()["id"]).get("error", {})
        c(error.get("code") == "time_limit" and "2 seconds" in error.get("detail", ""), "and ends by its limit", error)
        with open(f"/proc/{d.process.pid}/status", encoding="ascii") as f:
            peak = int(next(line for line in f if line.startswith("VmHWM:")).split()[1])
        c(peak < (1 << 20) or "-" in os.path.basename(os.path.normpath(build)), "the daemon stays small", peak)
        c.status(d.get("/healthz"), 200, "alive")


def reading(build, c):
    """Requests that take long to read keep nobody else waiting."""
    def long_one(k):
        names_ = [f"q{i}_{k}" for i in range(2000)]
        return {"system": {"form": "lagrangian", "coordinates": names_, "lagrangian": "*".join(f"(1+{q}'^2*{q}^2)" for q in names_)},
                "limits": {"seconds": 2}}
    with Daemon(build, "--workers", "1") as d:
        known = trivial()
        d.ask("POST", "/v1/solve", known)
        answers = []
        threads = [threading.Thread(target=lambda k=k: answers.append(d.ask("POST", "/v1/jobs", long_one(k), seconds=120))) for k in range(12)]
        for t in threads:
            t.start()
        time.sleep(0.5)
        for _ in range(20):
            c.status(d.get("/healthz"), 200, "a health check beside long reading")
            c.status(d.ask("POST", "/v1/solve", known), 200, "a hit beside long reading")
        still = 12 - len(answers)
        for t in threads:
            t.join()
        c(still >= 4, "they were answered while requests were being read", still)
        c(all(a.status in (202, 503) for a in answers), "the long ones are accepted", [(a.status, a.body[:100]) for a in answers if a.status != 202][:2])
    with Daemon(build, "--workers", "1") as d:      # and the service ends while it reads
        ends = []

        def ask(k):
            try:
                ends.append(d.ask("POST", "/v1/jobs", long_one(k), seconds=120).status)
            except (OSError, http.client.HTTPException):
                ends.append(0)
        threads = [threading.Thread(target=ask, args=(k,)) for k in range(8)]
        for t in threads:
            t.start()
        time.sleep(0.3)
        c(d.stop(60) == 0, "SIGTERM while requests are read ends with 0", d.errors()[-500:])
        for t in threads:
            t.join()
        c(len(ends) == 8 and set(ends) <= {0, 202, 503}, "all of them hear something", ends)


def stopped(build, c):
    """A child that answers nobody: the deadline and DELETE end its job all the same."""
    with Daemon(build, "--workers", "1") as d:
        def hang(seconds):
            id_ = d.ask("POST", "/v1/jobs", slow(seconds)).json()["id"]
            while d.get("/v1/jobs/" + id_).json()["status"] == "queued":
                time.sleep(0.02)
            for pid in d.children("sgad-job"):    # of the daemon that this test started
                os.kill(pid, signal.SIGSTOP)
            return id_
        error = d.wait(hang(0.5), 60).get("error", {})
        c(error.get("code") == "time_limit" and "0.5 seconds" in error.get("detail", ""), "a stopped child: the deadline", error)
        took = []
        for _ in range(3):
            id_ = hang(100)
            begun = time.monotonic()
            c.status(d.ask("DELETE", "/v1/jobs/" + id_), (200, 202), "DELETE")
            c(d.wait(id_, 60)["status"] == "cancelled", "a stopped child: DELETE")
            took.append(time.monotonic() - begun)
            if took[-1] < 1:
                break
        c(min(took) < 1, "DELETE stops a running job within a second", took)
        c(d.ask("POST", "/v1/solve", trivial()).json()["status"] == "done", "the next job runs")


def no_memory(build, c):
    """Where the daemon itself may have no more memory it refuses to read requests, and lives."""
    if "-" in os.path.basename(os.path.normpath(build)):
        return                    # sanitizers map terabytes
    with Daemon(build, "--workers", "1") as d:
        done = trivial()
        c.status(d.ask("POST", "/v1/solve", done), 200, "with memory")
        with open(f"/proc/{d.process.pid}/statm", encoding="ascii") as f:
            now = int(f.read().split()[0]) * os.sysconf("SC_PAGE_SIZE")
        resource.prlimit(d.process.pid, resource.RLIMIT_AS, (now + (4 << 20), resource.RLIM_INFINITY))
        a = d.ask("POST", "/v1/solve", trivial())
        c.problem(a, 503, "busy", "without memory")
        c("retry-after" in a.headers, "without memory: Retry-After", a.headers)
        c.status(d.ask("POST", "/v1/solve", done), 200, "without memory: what is known is answered")
        c.status(d.get("/healthz"), 200, "without memory: alive")
        resource.prlimit(d.process.pid, resource.RLIMIT_AS, (resource.RLIM_INFINITY, resource.RLIM_INFINITY))
        c.status(d.ask("POST", "/v1/solve", trivial()), 200, "with memory again")


def hostile(build, c):
    """Short bodies that take a second to read: they are read one beside another, not by who answers the others."""
    body = {"system": {"form": "equations", "variables": ["x"], "name": "", "equations": ["der(sin(cos(x^9*t))/exp(x*t), 30) = 0"]}}
    with Daemon(build, "--workers", "1") as d:
        known = trivial()
        d.ask("POST", "/v1/solve", known)
        before, answers = d.cpu(), []

        def ask(k):
            answers.append(d.ask("POST", "/v1/jobs", {"system": {**body["system"], "name": str(k)}}, seconds=120).status)
        threads = [threading.Thread(target=ask, args=(k,)) for k in range(8)]
        for t in threads:
            t.start()
        while len(answers) < 8:
            c.status(d.get("/healthz"), 200, "a health check beside hostile bodies")
            c.status(d.ask("POST", "/v1/solve", known), 200, "a hit beside hostile bodies")
            time.sleep(0.05)
        for t in threads:
            t.join()
        c(set(answers) <= {202, 422}, "they are answered", answers)
        c(d.cpu() - before < 2, "and cost the daemon's own process nothing to speak of", d.cpu() - before)
        for pid in d.children():          # children of the daemon that this test started
            os.kill(pid, signal.SIGKILL)
        c.status(d.ask("POST", "/v1/jobs", trivial()), 202, "a reader that was killed is replaced")


ALL = [hostile, no_memory, ended, large_ended, rows_kept, progress_t, maxima, refused, reading, stopped]
