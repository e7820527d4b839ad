"""What happens over time: cancelling, many clients, dying children, restarts, shutdown."""
import json
import os
import signal
import subprocess
import threading
import time

from common import moving, slow, trivial
from daemon import Daemon


def running(d, id_, seconds=20):
    end = time.monotonic() + seconds
    while time.monotonic() < end:
        if d.get("/v1/jobs/" + id_).json()["status"] == "running":
            return True
        time.sleep(0.02)
    return False


def cancel(build, c):
    with Daemon(build, "--workers", "1") as d:
        first = d.ask("POST", "/v1/jobs", slow()).json()["id"]
        second = d.ask("POST", "/v1/jobs", slow()).json()["id"]
        c(running(d, first), "a slow job runs")
        job = d.get("/v1/jobs/" + second).json()
        c(job["status"] == "queued", "the next one is queued", job)
        c.problem(d.get(f"/v1/jobs/{second}/trajectory"), 409, "no_trajectory", "trajectory of a queued job")
        a = d.ask("DELETE", "/v1/jobs/" + second)
        c(a.status == 200 and c.job(a, "cancel")["status"] == "cancelled", "cancelling a queued job", a.body)
        a = d.ask("DELETE", "/v1/jobs/" + first)
        c(a.status in (200, 202), "cancelling a running job", d.get("/v1/jobs/" + first).body)
        c(d.wait(first, 20)["status"] == "cancelled", "a running job is cancelled")
        c.status(d.ask("DELETE", "/v1/jobs/" + first), 204, "once more removes it")
        c.problem(d.get("/v1/jobs/" + first), 404, "not_found", "a job that was removed")
        c(first not in [j["id"] for j in d.get("/v1/jobs").json()["jobs"]], "nor is it in the list")
        job = c.job(d.ask("POST", "/v1/solve", trivial()), "after cancelling")
        c(job.get("status") == "done", "the worker goes on after a cancelled job", job)


def full(build, c):
    with Daemon(build, "--workers", "1", "--queue", "2") as d:
        ids = [d.ask("POST", "/v1/jobs", slow()).json()["id"]]
        c(running(d, ids[0]), "a slow job runs")
        ids += [d.ask("POST", "/v1/jobs", slow()).json()["id"] for _ in range(2)]
        a = d.ask("POST", "/v1/jobs", slow())
        c.problem(a, 503, "queue_full", "full queue")
        c("retry-after" in a.headers, "full queue: Retry-After", a.headers)
        c.problem(d.get("/readyz"), 503, "queue_full", "not ready when full")
        c.status(d.get("/healthz"), 200, "healthy when full")
        for i in ids[::-1]:
            c.status(d.ask("DELETE", "/v1/jobs/" + i), (200, 202), "cancel")
        d.wait(ids[0], 20)
        c.status(d.get("/readyz"), 200, "ready again")


def crowd(build, c):
    """Many clients at once, each job once."""
    with Daemon(build) as d:
        answers, lock = [], threading.Lock()

        def client(k):
            for n in range(5):
                a = d.ask("POST", "/v1/solve", trivial(100 * (k % 4) + n), {"Prefer": "wait=60"})
                with lock:
                    answers.append((k, n, a))
        threads = [threading.Thread(target=client, args=(k,)) for k in range(16)]
        for t in threads:
            t.start()
        for t in threads:
            t.join()
        c(len(answers) == 80 and all(a.status == 200 and a.json()["status"] == "done" for _, _, a in answers),
          "80 answers", [a.status for _, _, a in answers if a.status != 200])
        ids = {a.json()["id"] for _, _, a in answers}
        c(len(ids) == 20, "20 different jobs", len(ids))
        c(len(d.get("/v1/jobs?limit=100").json()["jobs"]) == 20, "20 jobs in the list")


def killed(build, c):
    """A child that dies takes one job with it, and nothing else."""
    with Daemon(build, "--workers", "1") as d:
        id_ = d.ask("POST", "/v1/jobs", slow()).json()["id"]
        c(running(d, id_), "a slow job runs")
        for _ in range(4):
            job = d.get("/v1/jobs/" + id_).json()
            if job["status"] not in ("queued", "running"):
                break
            before = d.children()
            c(before, "there is a child")
            for pid in before:    # children of the daemon that this test started
                os.kill(pid, signal.SIGKILL)
            time.sleep(0.3)
        job = d.wait(id_, 30)
        c(job["status"] == "failed" and job["error"]["code"] == "worker_died", "a job whose child is killed fails", job)
        job = c.job(d.ask("POST", "/v1/solve", trivial()), "after a killed child")
        c(job.get("status") == "done", "the next job has a new child", job)


def restart(build, c):
    with Daemon(build, "--workers", "1") as d:
        request = moving()
        one = d.ask("POST", "/v1/solve", request).json()
        c(d.stop() == 0, "SIGTERM ends with 0", d.errors())
        d.start()
        a = d.ask("POST", "/v1/solve", request)
        two = c.job(a, "after a restart")
        c(two.get("cached") is True and two.get("result") == one["result"], "the answer is cached after a restart", two.get("cached"))
        c(d.get("/v1/jobs/" + one["id"]).json()["result"] == one["result"], "the job is there after a restart")
        c(d.get("/v1/jobs").json()["jobs"][0]["id"] == one["id"], "the list is there after a restart")


def shutdown(build, c):
    """Waiters are answered, what runs goes back to the queue and runs again."""
    with Daemon(build, "--workers", "1") as d:
        request = slow()
        id_ = d.ask("POST", "/v1/jobs", request).json()["id"]
        c(running(d, id_), "a slow job runs")
        got = []
        waiter = threading.Thread(target=lambda: got.append(d.ask("POST", "/v1/solve", request, {"Prefer": "wait=100"})))
        stream = threading.Thread(target=lambda: got.append(d.get(f"/v1/jobs/{id_}/events")))
        waiter.start()
        stream.start()
        time.sleep(0.5)
        begun = time.monotonic()
        status = d.stop(60)
        took = time.monotonic() - begun
        waiter.join(10)
        stream.join(10)
        c(status == 0, "SIGTERM with waiters ends with 0", d.errors())
        c(took < 20, "SIGTERM ends in time", took)
        posts = [a for a in got if not a.headers.get("content-type", "").startswith("text/event-stream")]
        c(len(got) == 2 and posts and posts[0].status in (202, 503), "the waiter is answered", [(a.status, a.body[:200]) for a in got])
        d.start()
        job = d.get("/v1/jobs/" + id_).json()
        c(job["status"] in ("queued", "running"), "the job is queued again", job)
        c(running(d, id_), "and runs again")
        c.status(d.ask("DELETE", "/v1/jobs/" + id_), (200, 202), "cancel")


def drained(build, c):
    """SIGUSR1: what runs may end, however short the grace; nothing new is taken; what waits is there at the next start."""
    with Daemon(build, "--workers", "1", "--grace", "0") as d:
        for hasty in (False, True):
            going = d.ask("POST", "/v1/jobs", slow(120 if hasty else 3)).json()["id"]
            c(running(d, going), "a job runs")
            waits = d.ask("POST", "/v1/jobs", trivial()).json()["id"]
            d.process.send_signal(signal.SIGUSR1)
            end = time.monotonic() + 30
            while d.get("/readyz").status != 503 and time.monotonic() < end:
                time.sleep(0.02)
            c.problem(d.get("/readyz"), 503, "draining", "not ready while it drains")
            c.problem(d.ask("POST", "/v1/jobs", trivial()), 503, "draining", "no new job while it drains")
            c.status(d.get("/v1/jobs/" + going), 200, "jobs can be read while it drains")
            if hasty:
                d.process.send_signal(signal.SIGTERM)
            c(d.ended(60) == 0, "it ends with 0 by itself")
            d.start()
            job = d.get("/v1/jobs/" + going).json()
            c(job["status"] in (("queued", "running") if hasty else ("done", "failed")), "what ran has ended" if not hasty else "in haste it goes back", job)
            d.ask("DELETE", "/v1/jobs/" + going)
            c(d.wait(waits)["status"] == "done", "what waited runs in the next life")


def slow_children(build, c):
    """Children that stand still, even before they have said a word, hold up no end."""
    for _ in range(3):
        with Daemon(build, "--workers", "2", "--grace", "0") as d:
            for pid in d.children("sgad-"):       # not those that have not begun to be one
                os.kill(pid, signal.SIGSTOP)
            begun = time.monotonic()
            c(d.stop(60) == 0 and time.monotonic() - begun < 25, "it ends beside children that stand still", time.monotonic() - begun)


def crashed(build, c):
    """A daemon that is killed loses no job that it took."""
    with Daemon(build, "--workers", "1") as d:
        a = d.ask("POST", "/v1/jobs", slow())
        ids = [a.json()["id"], d.ask("POST", "/v1/jobs", trivial()).json()["id"]]
        d.process.kill()
        d.ended()
        d.start()
        for i in ids:
            c(d.get("/v1/jobs/" + i).status == 200, "a job that was taken is there after a crash")
        d.ask("DELETE", "/v1/jobs/" + ids[0])
        c(d.wait(ids[1], 30)["status"] == "done", "and is done")


def second(build, c):
    """Two daemons cannot share one state folder; wrong options are refused."""
    with Daemon(build) as d:
        run = subprocess.run([os.path.join(build, "sgad"), "--listen", "127.0.0.1:0", "--state", os.path.join(d.state, "sgad")],
                             capture_output=True, timeout=30, check=False)
        c(run.returncode != 0 and run.stderr, "a second daemon on the same state is refused", run.stdout)
    for flags in ([], ["--listen", "127.0.0.1:0"], ["--listen", "0.0.0.0:0", "--state", "/nonexistent/x"], ["--nonsense", "1"]):
        run = subprocess.run([os.path.join(build, "sgad"), *flags], capture_output=True, timeout=30, check=False)
        c(run.returncode not in (0, -11, -6) and run.stderr, f"refused: sgad {' '.join(flags)}", run.stderr)


def client(build, c):
    """The command-line client against a daemon gives what it gives without one."""
    with Daemon(build) as d:
        path = os.path.join(d.state, "request.json")
        with open(path, "w", encoding="utf-8") as f:
            json.dump(moving(), f)
        program = os.path.join(build, "sga")
        far = subprocess.run([program, "solve", path, "--server", d.url(), "--json"], capture_output=True, timeout=60, check=False)
        near = subprocess.run([program, "solve", path, "--json"], capture_output=True, timeout=60, check=False)
        c(far.returncode == 0 and near.returncode == 0, "sga solve", far.stderr + near.stderr)
        try:
            one, two = json.loads(far.stdout), json.loads(near.stdout)
        except ValueError as e:
            c(False, "sga solve --json", e)
            return
        for r in (one, two):
            r.pop("work", None)
        c(one == two, "the client gives the same with and without a daemon")
        env = {**os.environ, "SGA_SERVER": d.url()}
        by_env = subprocess.run([program, "solve", path, "--json"], capture_output=True, timeout=60, check=False, env=env)
        c(by_env.returncode == 0, "SGA_SERVER", by_env.stderr)
        with open(path, "w", encoding="utf-8") as f:
            f.write('{"system": {"form": "quasilinear", "variables": ["x"], "A": [[1]], "alpha": ["1 + * x"]}}')
        for extra in (["--server", d.url()], []):
            bad = subprocess.run([program, "solve", path, *extra], capture_output=True, timeout=60, check=False)
            c(bad.returncode not in (0, -11, -6) and b"expression_syntax" in bad.stdout + bad.stderr, "sga solve: a refused request",
              bad.stdout + bad.stderr)
        gone = subprocess.run([program, "solve", path, "--server", "http://127.0.0.1:9"], capture_output=True, timeout=60, check=False)
        c(gone.returncode not in (0, -11, -6) and gone.stderr, "sga solve: no daemon there", gone.stderr)


ALL = [cancel, full, crowd, killed, restart, shutdown, drained, slow_children, crashed, second, client]
