"""load.py BUILD_DIR many [REQUESTS] | soak [SECONDS]: many requests, and a long time.

many: requests of all kinds, several at a time on each connection. Each reply must be the one to
its request (the request id comes back, the answer names the number in the request), and in the
end the daemon has counted as many requests as were sent and holds each job once.

soak: the same, with streams, cancelled jobs, refusals and results that are evicted, for a time;
after a while of warming up the memory of the daemon and its children grows no more.
The seed is printed; SGA_TEST_SEED sets it.
"""
import json
import os
import random
import socket
import sys
import threading
import time

HERE = os.path.dirname(os.path.abspath(__file__))
sys.path[:0] = [HERE, os.path.dirname(HERE)]

from common import slow  # noqa: E402
from daemon import Daemon  # noqa: E402
from tally import Tally  # noqa: E402

CLIENTS, BATCH = 4, 8


def request(k):
    r = {"system": {"form": "quasilinear", "variables": ["x"], "A": [[1]], "alpha": [f"{k}*x"]}}
    if k % 10 == 0:
        r["trajectory"] = {"stop": 0.001, "samples": 10 + k % 90, "initial": {"x": 1}}
    return r


class Connection:
    """Requests are sent in batches; replies come back in their order."""

    def __init__(self, d):
        self.port = d.port
        self.socket = socket.create_connection(("127.0.0.1", d.port), timeout=120)
        self.socket.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
        self.rest = b""

    def bytes(self, method, path, id_, body=None):
        data = b"" if body is None else body if isinstance(body, bytes) else json.dumps(body).encode()
        head = f"{method} {path} HTTP/1.1\r\nHost: 127.0.0.1:{self.port}\r\nX-Request-Id: {id_}\r\n"
        if body is not None:
            head += f"Content-Type: application/json\r\nContent-Length: {len(data)}\r\n"
        return head.encode() + b"\r\n" + data

    def reply(self):
        while b"\r\n\r\n" not in self.rest:
            self.more()
        head, self.rest = self.rest.split(b"\r\n\r\n", 1)
        lines = head.decode().split("\r\n")
        headers = {k.lower(): v for k, v in (line.split(": ", 1) for line in lines[1:])}
        length = int(headers["content-length"])
        while len(self.rest) < length:
            self.more()
        body, self.rest = self.rest[:length], self.rest[length:]
        return int(lines[0].split(" ")[1]), headers, body

    def more(self):
        piece = self.socket.recv(1 << 18)
        if not piece:
            raise RuntimeError("the connection was closed")
        self.rest += piece


class Book:
    """What was sent, and which job each number became."""

    def __init__(self, check):
        self.check, self.lock = check, threading.Lock()
        self.sent, self.ids, self.next = 0, {}, 2

    def number(self, rng):
        """Mostly one that was asked before."""
        with self.lock:
            if rng.random() < 0.15 or self.next < 10:
                self.next += 1
                return self.next - 1
            return rng.randrange(max(2, self.next - 3000), self.next)

    def mine(self, k, job):
        with self.lock:
            same = self.ids.setdefault(k, job["id"]) == job["id"]
        if not same:
            self.check(False, "the same request is the same job", (k, job["id"]))
        if job["status"] == "done" and "result" in job:
            answer = job["result"]["vector_field"]["components"]["x"]
            if answer != f"{k}*x":
                self.check(False, "the answer to another request", (k, answer))

    def judge(self, kind, k, status, body):
        if kind == "bad":
            right = status == 400 and b'"json_syntax"' in body
        elif kind == "none":
            right = status == 404
        elif kind == "health":
            right = status == 200
        else:
            right = status in (200, 202)
            if right:
                self.mine(k, json.loads(body))
        if not right:
            self.check(False, f"the reply to a request of kind {kind}", (k, status, body[:300]))


def batch(connection, book, rng, name):
    sent, data = [], b""
    for _ in range(BATCH):
        kind = rng.choices(("solve", "post", "get", "health", "none", "bad"), (50, 20, 20, 5, 3, 2))[0]
        k = book.number(rng)
        id_ = f"{name}-{book_count(book)}"
        if kind == "get" and k not in book.ids:
            kind = "solve"
        data += {"solve": lambda: connection.bytes("POST", "/v1/solve", id_, request(k)),
                 "post": lambda: connection.bytes("POST", "/v1/jobs", id_, request(k)),
                 "get": lambda: connection.bytes("GET", "/v1/jobs/" + book.ids[k], id_),
                 "health": lambda: connection.bytes("GET", "/healthz", id_),
                 "none": lambda: connection.bytes("GET", "/v1/jobs/" + "0" * 32, id_),
                 "bad": lambda: connection.bytes("POST", "/v1/jobs", id_, b'{"system": ')}[kind]()
        sent.append((kind, k, id_))
    connection.socket.sendall(data)
    for kind, k, id_ in sent:
        status, headers, body = connection.reply()
        if headers.get("x-request-id") != id_:
            book.check(False, "a reply to another request", (id_, headers))
        book.judge(kind, k, status, body)


def book_count(book):
    with book.lock:
        book.sent += 1
        return book.sent


def crowd(d, book, go, seed):
    """Clients at once, each until go(book) is false."""
    def client(n):
        rng, connection = random.Random(seed + n), Connection(d)
        try:
            while go(book):
                batch(connection, book, rng, f"c{n}")
        except Exception as e:    # a thread has no other way to tell
            book.check(False, "a client", f"{type(e).__name__}: {e}")
        finally:
            connection.socket.close()
    threads = [threading.Thread(target=client, args=(n,)) for n in range(CLIENTS)]
    for t in threads:
        t.start()
    return threads


def counted(d):
    """Requests that the daemon has answered, by its own count, without those for metrics."""
    total = 0
    for line in d.get("/metrics").body.decode().splitlines():
        if line.startswith("sgad_http_requests_total{") and 'route="/metrics"' not in line:
            total += int(float(line.rsplit(" ", 1)[1]))
    return total


def start_seed():
    seed = int(os.environ.get("SGA_TEST_SEED", "20261121"))
    print(f"seed {seed}", flush=True)
    return seed


def run_many(build, count, check):
    book, begun = Book(check), time.monotonic()
    with Daemon(build, "--workers", "2", "--queue", "100000", "--log-level", "warn") as d:
        for t in crowd(d, book, lambda b: b.sent < count, start_seed()):
            t.join()
        check(book.sent >= count, "all were sent", book.sent)
        check(counted(d) == book.sent, "each request is counted once", (counted(d), book.sent))
        for k in list(book.ids)[::max(1, len(book.ids) // 2000)]:
            book.mine(k, d.wait(book.ids[k]))
        listed, cursor = [], ""
        while cursor is not None:
            page = d.get("/v1/jobs?limit=500" + (f"&cursor={cursor}" if cursor else "")).json()
            listed += [j["id"] for j in page["jobs"]]
            cursor = page["next"]
        check(sorted(listed) == sorted(book.ids.values()), "each job is there once", (len(listed), len(set(listed)), len(book.ids)))
        check(d.stop(60) == 0, "the daemon ends with 0", d.errors()[-300:])
    print(f"{book.sent} requests, {len(book.ids)} jobs, {time.monotonic() - begun:.0f} s", flush=True)


def resident(pid):
    with open(f"/proc/{pid}/status", encoding="ascii") as f:
        return next(int(line.split()[1]) for line in f if line.startswith("VmRSS:"))


def odd_things(d, stop, rng):
    """Streams that are left, jobs that are cancelled, bodies that are cut."""
    while not stop.is_set():
        id_ = d.ask("POST", "/v1/jobs", slow()).json()["id"]
        with socket.create_connection(("127.0.0.1", d.port), timeout=20) as s:
            s.sendall(f"GET /v1/jobs/{id_}/events HTTP/1.1\r\nHost: localhost\r\n\r\n".encode())
            s.recv(200)
        with socket.create_connection(("127.0.0.1", d.port), timeout=20) as s:
            s.sendall(b"POST /v1/jobs HTTP/1.1\r\nHost: localhost\r\nContent-Type: application/json\r\nContent-Length: 100000\r\n\r\n" + b" " * 50000)
        d.ask("DELETE", "/v1/jobs/" + id_)
        time.sleep(0.05 + 0.1 * rng.random())


def run_soak(build, seconds, check):
    """A third of the time is for warming up: caches fill, pools grow. A short run is still at it
    (the page caches of the store's readers alone take some megabytes), and is judged less strictly."""
    seed, book, stop = start_seed(), Book(check), threading.Event()
    with Daemon(build, "--workers", "2", "--queue", "100000", "--cache-memory", "1000000", "--cache-disk", "4000000", "--log-level", "warn") as d:
        end = time.monotonic() + seconds
        threads = crowd(d, book, lambda b: time.monotonic() < end, seed)
        threads.append(threading.Thread(target=odd_things, args=(d, stop, random.Random(seed))))
        threads[-1].start()
        seen = []
        while time.monotonic() < end:
            time.sleep(min(1.0, seconds / 30))
            seen.append((book.sent, resident(d.process.pid), max(map(resident, d.children()), default=0)))
        stop.set()
        for t in threads:
            t.join()
        third = len(seen) // 3
        middle, late = seen[third:2 * third], seen[2 * third:]
        for which, name in ((1, "the daemon"), (2, "its largest child")):
            before, after = (sorted(s[which] for s in part)[len(part) // 2] for part in (middle, late))
            grown = 1024 * (after - before) / max(1, late[len(late) // 2][0] - middle[len(middle) // 2][0])
            check(after <= before * 1.05 + (2048 if seconds >= 60 else 8192), f"the memory of {name} does not grow", (before, after, grown))
            print(f"{name}: {before / 1024:.1f} MB, then {after / 1024:.1f} MB; {grown:.1f} bytes for each request", flush=True)
        check(d.get("/healthz").status == 200, "alive")
        check(d.stop(60) == 0, "the daemon ends with 0", d.errors()[-300:])
    print(f"{book.sent} requests, {len(book.ids)} jobs", flush=True)


def many_requests(build, c):
    run_many(build, int(6000 * float(os.environ.get("SGA_TEST_SCALE", "1"))), c)


def soak(build, c):
    """Short, and without judging sanitizers' memory, which keeps what was freed for a while."""
    if "-" not in os.path.basename(os.path.normpath(build)):
        run_soak(build, 15, c)


ALL = [many_requests, soak]

if __name__ == "__main__":
    TALLY = Tally(sys.argv[2])

    def check_(ok, label, detail=""):
        return TALLY.check(ok, label, str(detail)[:600])
    if sys.argv[2] == "many":
        run_many(sys.argv[1], int(sys.argv[3]) if len(sys.argv) > 3 else 100000, check_)
    else:
        run_soak(sys.argv[1], float(sys.argv[3]) if len(sys.argv) > 3 else 600, check_)
    sys.exit(TALLY.end())
