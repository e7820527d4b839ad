"""kill.py BUILD_DIR [ROUNDS]: the daemon is killed at random moments while clients post, and
the history that the clients saw is checked.

A 202 is a promise: every accepted job ends, in this life of the daemon or a later one, with
the answer to its own request. What a client saw as ended stays so, in all lives after. A
job that runs whenever the daemon dies is given up after three tries, with a code.
The seed is printed; SGA_TEST_SEED sets it.
"""
import http.client
import json
import os
import random
import signal
import sys
import threading
import time

HERE = os.path.dirname(os.path.abspath(__file__))
sys.path[:0] = [HERE, os.path.dirname(HERE)]

from common import slow  # noqa: E402
from daemon import Daemon  # noqa: E402
from tally import Tally  # noqa: E402

GONE = (OSError, http.client.HTTPException, ValueError, AttributeError)    # the daemon died in between


def request(k):
    """x' = k x: the answer names its request. Every third job has something to integrate."""
    r = {"system": {"form": "quasilinear", "variables": ["x"], "A": [[1]], "alpha": [f"{k}*x"]}}
    if k % 3 == 0:
        r["trajectory"] = {"stop": 0.001, "samples": 20 + k % 500, "initial": {"x": 1}}
    return r


class History:
    """What clients saw: ids and ends by the number in the request."""

    def __init__(self, check):
        self.check = check      # an end is (status, finished)
        self.lock = threading.Lock()
        self.sent, self.accepted, self.told = set(), {}, {}

    def post(self, d, k):
        with self.lock:
            self.sent.add(k)
        a = d.ask("POST", "/v1/jobs", request(k), seconds=20)
        if a.status == 202:
            job = a.json()
            with self.lock:
                old = self.accepted.setdefault(k, job["id"])
            self.check(old == job["id"], "the same request is the same job", (k, old, job["id"]))
        else:
            self.check(a.status in (200, 503), "a post is accepted, answered, or refused for now", (a.status, a.body[:200]))
        if a.status in (200, 202):
            self.tell(k, a.json())

    def tell(self, k, job):
        """Whoever sees an end sees the same one, for ever."""
        end = (job["status"], job["finished"])
        if end[1] is None:
            return
        with self.lock:
            first = self.told.setdefault(k, end)
        self.check(first == end, "an end that was told stays as it is", (k, first, end))

    def right(self, k, job):
        answer = (job.get("result") or {}).get("vector_field", {}).get("components", {}).get("x")
        self.check(job["status"] == "done" and answer == (f"{k}*x" if k > 1 else "x"), "the job's own answer",
                   (k, job["status"], answer, job.get("error")))

    def begin(self, d):
        """At the beginning of a life."""
        with self.lock:
            known = sorted(self.accepted)
        for k in random.sample(known, min(len(known), 400)):
            id_ = self.accepted[k]
            a = d.get("/v1/jobs/" + id_)
            if not self.check(a.status == 200, "an accepted job is there after a crash", (k, a.status, a.body[:200])):
                continue
            job = a.json()
            if self.check(k not in self.told or job["finished"], "an end that was told is there after a crash", (k, job)):
                self.tell(k, job)


def clients(d, history, numbers, stop):
    def one(rng):
        while not stop.is_set():
            try:
                with history.lock:
                    k = next(numbers)
                history.post(d, k if rng.random() < 0.9 else rng.randrange(2, k + 1))
                if rng.random() < 0.2:
                    d.get("/v1/jobs?limit=20")
            except GONE:
                if d.process.poll() is not None or stop.is_set():
                    return
    threads = [threading.Thread(target=one, args=(random.Random(random.random()),)) for _ in range(4)]
    for t in threads:
        t.start()
    return threads


def poisonous(d, check):
    a = d.ask("POST", "/v1/jobs", slow(3000))
    check(a.status == 202, "the poison job is accepted", a.body[:200])
    return a.json()["id"]


def one_life(d, history, numbers, rng):
    history.begin(d)
    stop = threading.Event()
    threads = clients(d, history, numbers, stop)
    time.sleep(0.15 + rng.random() ** 2)
    d.process.send_signal(signal.SIGKILL)
    stop.set()
    d.ended()
    for t in threads:
        t.join()


def run(build, rounds, check):
    seed = int(os.environ.get("SGA_TEST_SEED", "20261121"))
    print(f"seed {seed}, {rounds} rounds", flush=True)
    random.seed(seed)
    rng = random.Random(seed)
    history = History(check)
    numbers = iter(range(2, 10**9))
    d = Daemon(build, "--workers", "2", "--queue", "100000")
    with d:
        poison = poisonous(d, check)
        while d.get("/v1/jobs/" + poison).json()["status"] != "running":
            time.sleep(0.01)
        for _ in range(rounds):
            one_life(d, history, numbers, rng)
            d.start()
        last(d, history, poison, rounds, check)


def last(d, history, poison, rounds, check):
    """A life without an end: everything accepted ends, and nothing else is there."""
    for k, id_ in history.accepted.items():
        job = d.wait(id_, 600)
        history.right(k, job)
        history.tell(k, job)
    listed, cursor = [], ""
    while True:
        page = d.get(f"/v1/jobs?limit=500{cursor}").json()
        listed += [j["id"] for j in page["jobs"]]
        if not page.get("next"):
            break
        cursor = "&cursor=" + page["next"]
    check(len(listed) == len(set(listed)), "no job is listed twice", len(listed))
    check(set(history.accepted.values()) <= set(listed), "every accepted job is listed")
    check(len(listed) <= len(history.sent) + 1, "nothing is listed that nobody asked for", (len(listed), len(history.sent)))
    job = d.get("/v1/jobs/" + poison).json()
    if rounds >= 3:
        check(job["status"] == "failed" and job["error"]["code"] == "worker_died" and "3 times" in job["error"]["detail"],
              "a job that runs whenever the daemon dies is given up", job)
    print(f"{len(history.accepted)} jobs accepted, {len(history.told)} ends watched", flush=True)
    check(d.stop(60) == 0, "the daemon ends with 0")


def kill_loop(build, c):
    """Five rounds among the tests of the API."""
    run(build, 5, c)


ALL = [kill_loop]

if __name__ == "__main__":
    TALLY = Tally("kill")
    run(sys.argv[1], int(sys.argv[2]) if len(sys.argv) > 2 else 100, lambda ok, label, detail="": TALLY.check(ok, label, str(detail)[:600]))
    sys.exit(TALLY.end())
