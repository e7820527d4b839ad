"""An upgrade (SIGUSR2): another process takes over the listening sockets and the state; clients lose nothing."""
import http.client
import os
import re
import shutil
import signal
import socket
import tempfile
import threading
import time

from common import slow, trivial
from daemon import Answer, Daemon


class Upgraded(Daemon):
    """A daemon that may be another process by now. Each that this one started is ended at the end."""

    def take_over(self, seconds=60):
        """SIGUSR2; True once the old process has ended and another one serves."""
        before, old = self.successors(), self.pid()
        os.kill(old, signal.SIGUSR2)
        end = time.monotonic() + seconds
        while time.monotonic() < end:
            if len(self.successors()) > len(before) and self.gone(old):
                self.process_pid = self.successors()[-1]
                return True
            time.sleep(0.02)
        return False

    def gone(self, pid):
        if pid == self.process.pid:
            return self.process.poll() is not None
        try:
            with open(f"/proc/{pid}/stat", encoding="ascii") as f:
                return f.read().rsplit(")", 1)[1].split()[0] == "Z"      # nobody may be there to take note of its end
        except OSError:
            return True

    def text(self):
        with open(os.path.join(self.state, "test.log"), encoding="utf-8", errors="replace") as f:
            return f.read()

    def successors(self):
        return [int(n) for n in re.findall(r'"event":"handing_over".*?"successor":(\d+)', self.text())]

    def pid(self):
        return getattr(self, "process_pid", self.process.pid)

    def finish(self):
        """Ends the last one by SIGTERM; True where it went in time."""
        pid = self.pid()
        if pid == self.process.pid:
            return self.stop() == 0
        os.kill(pid, signal.SIGTERM)
        for _ in range(1000):
            if self.gone(pid):
                return True
            time.sleep(0.02)
        return False

    def __exit__(self, *arguments):
        for pid in self.successors():
            try:
                os.kill(pid, signal.SIGKILL)
            except ProcessLookupError:
                pass
        super().__exit__(*arguments)


class Crowd:
    """Clients that go on asking, each in its way; what went wrong stands in `wrong`."""

    def __init__(self, d):
        self.d, self.stop, self.wrong, self.asked, self.accepted, self.lock = d, False, [], 0, [], threading.Lock()
        self.threads = [threading.Thread(target=self.run, args=(way, k)) for k, way in
                        enumerate([self.fresh, self.fresh, self.kept, self.kept, self.posting, self.posting, self.solving, self.slowly])]

    def __enter__(self):
        for t in self.threads:
            t.start()
        return self

    def __exit__(self, *_):
        self.stop = True
        for t in self.threads:
            t.join(60)

    def run(self, way, k):
        n = 0
        while not self.stop:
            try:
                n += 1
                way(k, n)
                self.asked += 1
            except Exception as e:       # whatever a client would see
                with self.lock:
                    self.wrong.append(f"{way.__name__}: {type(e).__name__}: {e}")

    def expect(self, a, statuses, what):
        if a.status not in statuses:
            with self.lock:
                self.wrong.append(f"{what}: {a.status} {a.body[:200]!r}")

    def fresh(self, _k, _n):
        self.expect(self.d.get("/v1/jobs?limit=3"), (200,), "fresh connection")

    def kept(self, _k, _n):
        h = http.client.HTTPConnection("127.0.0.1", self.d.port, timeout=60)
        try:
            for _ in range(200):
                h.request("GET", "/version")
                r = h.getresponse()
                body = r.read()
                self.expect(Answer(r.status, {}, body), (200,), "kept connection")
                if r.getheader("connection") == "close" or self.stop:
                    return
        finally:
            h.close()

    def posting(self, k, n):
        a = self.d.ask("POST", "/v1/jobs", trivial(100000 * (k + 1) + n))
        self.expect(a, (200, 202), "posted job")
        with self.lock:
            self.accepted.append(a.json()["id"])
        time.sleep(0.01)

    def solving(self, k, n):
        a = self.d.ask("POST", "/v1/solve", trivial(100000 * (k + 1) + n))
        self.expect(a, (200, 202), "solved job")
        with self.lock:
            self.accepted.append(a.json()["id"])

    def slowly(self, _k, _n):
        """A request that comes in pieces."""
        with socket.create_connection(("127.0.0.1", self.d.port), timeout=60) as s:
            out = b""
            for piece in (b"GET /healthz HT", b"TP/1.1\r\nHost: localhost\r\n", b"Connection: close\r\n\r\n"):
                s.sendall(piece)
                time.sleep(0.05)
            while got := s.recv(4096):
                out += got
            self.expect(Answer(int(out[9:12] or 0), {}, out), (200,), "slow client")


def upgrade(build, c):
    """Three times under load, the second time by a program that was put in the place of the old one."""
    folder = tempfile.mkdtemp(prefix="sgad-upgrade-")
    try:
        program = os.path.join(folder, "sgad")
        shutil.copy(os.path.join(build, "sgad"), program)
        with Upgraded(folder, "--workers", "2", "--grace", "1") as d:
            running_id = d.ask("POST", "/v1/jobs", slow(1000)).json()["id"]
            with Crowd(d) as crowd:
                for k in range(3):
                    time.sleep(0.7)
                    if k == 1:
                        shutil.copy(program, program + ".new")
                        os.rename(program + ".new", program)
                    c(d.take_over(), f"upgrade {k}: another process took over", d.errors())
                    exe = os.readlink(f"/proc/{d.pid()}/exe")
                    c(exe == program, f"upgrade {k}: it is the program that lies there now", exe)
                time.sleep(0.7)
            c(not crowd.wrong, "upgrade: no client lost anything", (len(crowd.wrong), crowd.wrong[:5]))
            c(crowd.asked > 100, "upgrade: clients asked meanwhile", crowd.asked)
            job = d.get("/v1/jobs/" + running_id).json()
            c(job["status"] in ("queued", "running"), "upgrade: a job that ran goes on as an accepted one", job)
            c.status(d.ask("DELETE", "/v1/jobs/" + running_id), (200, 202), "upgrade: and can be cancelled")
            for id_ in crowd.accepted:
                job = d.wait(id_)
                if job["status"] != "done":
                    c(False, "upgrade: an accepted job", job)
            c(len(crowd.accepted) > 20, "upgrade: all accepted jobs are done", len(crowd.accepted))
            open_files = os.listdir(f"/proc/{d.pid()}/fd")
            c(len(open_files) < 60, "upgrade: no descriptor is handed on without need", len(open_files))
            c(d.finish(), "upgrade: the last one ends by SIGTERM", d.errors())
            c("Sanitizer" not in d.text(), "upgrade: no sanitizer spoke", d.errors())
    finally:
        shutil.rmtree(folder, ignore_errors=True)


def upgrade_idle(build, c):
    """Connections that are kept alive: one that rests ends without a word and without a reset; one that is asked again and again is told which answer is the last."""
    ask, last = b"GET /healthz HTTP/1.1\r\nHost: localhost\r\n\r\n", {}
    with Upgraded(build) as d:
        kept = [socket.create_connection(("127.0.0.1", d.port), timeout=60) for _ in range(20)]
        for s in kept:
            s.sendall(ask)
            first = s.recv(4096)
            c(first.startswith(b"HTTP/1.1 200") and b"Connection: close" not in first, "upgrade: a connection is kept alive", first)

        def rest(k):
            try:
                last[k] = kept[k].recv(4096)
            except OSError as e:
                last[k] = e

        def go_on(k):
            try:
                last[k] = first
                while b"Connection: close" not in last[k]:
                    time.sleep(0.02)
                    kept[k].sendall(ask)
                    last[k] = kept[k].recv(4096)
                last[k] += kept[k].recv(4096)
            except OSError as e:
                last[k] = e
        threads = [threading.Thread(target=go_on if k % 2 else rest, args=(k,)) for k in range(len(kept))]
        for t in threads:
            t.start()
        c(d.take_over(), "upgrade: with connections that are kept alive", d.errors())
        for t in threads:
            t.join(60)
        c([last[k] for k in range(0, 20, 2)] == [b""] * 10, "upgrade: one that rests ends, and without a reset", last)
        answers = [last[k] for k in range(1, 20, 2)]
        c(all(isinstance(a, bytes) and a.startswith(b"HTTP/1.1 200") and a.count(b"HTTP/1.1") == 1 and b"Connection: close" in a for a in answers),
          "upgrade: the last answer says so, and is whole", answers)
        for s in kept:
            s.close()
        c.status(d.get("/healthz"), 200, "upgrade: the successor answers")
        c(d.finish(), "upgrade: it ends by SIGTERM", d.errors())


class Kept:
    """Files that are as they were, afterwards."""

    def __init__(self, *paths):
        self.paths = paths

    def __enter__(self):
        for path in self.paths:
            shutil.copy(path, path + ".kept")

    def __exit__(self, *_):
        for path in self.paths:
            os.replace(path + ".kept", path)


def upgrade_refused(build, c):
    """One that cannot start changes nothing; one without settings neither."""
    folder = tempfile.mkdtemp(prefix="sgad-upgrade-")
    try:
        program, settings = os.path.join(folder, "sgad"), os.path.join(folder, "sgad.conf")
        shutil.copy(os.path.join(build, "sgad"), program)
        with open(settings, "w", encoding="ascii") as f:
            f.write("queue = 5\n")
        with Upgraded(folder, "--config", settings) as d, Kept(program, settings):
            for what, change in (("wrong settings", lambda: open(settings, "a", encoding="ascii").write("quue = 6\n")), ("no program", lambda: os.remove(program))):
                change()
                before = d.text().count("no_successor")
                os.kill(d.process.pid, signal.SIGUSR2)
                for _ in range(500):
                    if d.text().count("no_successor") > before:
                        break
                    time.sleep(0.02)
                c(d.text().count("no_successor") == before + 1, f"upgrade: {what}: the log says so", d.errors())
                c.status(d.get("/readyz"), 200, f"upgrade: {what}: ready")
                a = d.ask("POST", "/v1/solve", trivial())
                c(a.status == 200 and a.headers.get("connection") != "close", f"upgrade: {what}: it goes on", (a.status, a.headers))
            c(d.stop() == 0, "upgrade: it ends as ever")
    finally:
        shutil.rmtree(folder, ignore_errors=True)


def upgrade_waiters(build, c):
    """Who waits for a job is told where it is; event streams end and are taken up again; UNIX sockets and systemd hear of it."""
    folder = tempfile.mkdtemp(prefix="sgad-upgrade-")
    notify = socket.socket(socket.AF_UNIX, socket.SOCK_DGRAM)
    try:
        notify.bind(folder + "/notify")
        notify.settimeout(20)
        path = folder + "/socket"
        with Upgraded(build, "--workers", "1", "--listen", f"127.0.0.1:0,unix:{path}",
                      env={"NOTIFY_SOCKET": folder + "/notify", "WATCHDOG_USEC": "10000000"}) as d:
            request, got = slow(1000), []
            waiting = threading.Thread(target=lambda: got.append(d.ask("POST", "/v1/solve", request, {"Prefer": "wait=100"})))
            waiting.start()
            while not d.get("/v1/jobs").json()["jobs"]:
                time.sleep(0.02)
            id_ = d.get("/v1/jobs").json()["jobs"][0]["id"]
            stream = http.client.HTTPConnection("127.0.0.1", d.port, timeout=60)
            stream.request("GET", f"/v1/jobs/{id_}/events")
            events = stream.getresponse()
            old = d.pid()
            c(d.take_over(), "upgrade: with waiters", d.errors())
            waiting.join(30)
            c(got and got[0].status == 202 and got[0].json()["id"] == id_ and got[0].headers["location"].endswith(id_), "upgrade: who waits gets a 202", got and got[0].body)
            c(b"event: end" not in events.read(), "upgrade: an event stream ends without an end of the job")
            stream.close()
            stream = http.client.HTTPConnection("127.0.0.1", d.port, timeout=60)
            stream.request("GET", f"/v1/jobs/{id_}/events", headers={"Last-Event-ID": "1"})
            events = stream.getresponse()
            c(events.status == 200 and b"retry" in events.read(30), "upgrade: and is taken up again")
            stream.close()
            with socket.socket(socket.AF_UNIX) as s:
                s.settimeout(20)
                s.connect(path)
                s.sendall(b"GET /healthz HTTP/1.1\r\nHost: localhost\r\nConnection: close\r\n\r\n")
                c(s.recv(4096).startswith(b"HTTP/1.1 200"), "upgrade: the UNIX socket answers")
            said = []
            while not said or said.count("READY=1") < 2:
                said += notify.recv(4096).decode().split("\n")
            c(f"MAINPID={d.pid()}" in said and d.pid() != old and "STOPPING=1" not in said, "upgrade: systemd hears whom to watch", said)
            alive = None
            for _ in range(100):
                alive = notify.recv(4096).decode()
                if "WATCHDOG=1" in alive:
                    break
            c("WATCHDOG=1" in (alive or ""), "upgrade: and gets signs of life", alive)
            c.status(d.ask("DELETE", "/v1/jobs/" + id_), (200, 202), "upgrade: cancelled")
            c(d.finish() and not os.path.exists(path), "upgrade: the last one removes the UNIX socket's name", os.listdir(folder))
    finally:
        notify.close()
        shutil.rmtree(folder, ignore_errors=True)


ALL = [upgrade, upgrade_idle, upgrade_refused, upgrade_waiters]
