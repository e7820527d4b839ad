"""A daemon of our own on a free port, and a small HTTP client for it."""
import http.client
import json
import os
import re
import shutil
import signal
import socket
import subprocess
import tempfile
import time


class Daemon:
    """Used as a context: starts with an own state folder, stops the process that it started.

    A guest is told of what every daemon does and answers: see turns.py."""

    guest = None

    def __init__(self, build, *flags, state=None, env=None, stderr=None):
        """env: added to the environment; stderr: a descriptor instead of the file that errors() reads."""
        self.build, self.flags, self.env, self.stderr = build, flags, env, stderr
        self.own = state is None
        self.state = state or tempfile.mkdtemp(prefix="sgad-test-")
        self.process = self.port = None
        if self.guest:
            self.env = {**(env or {}), **self.guest.env()}

    def __enter__(self):
        self.start()
        return self

    def __exit__(self, *_):
        try:
            if self.process and self.process.poll() is None:
                self.stop()
        finally:
            if self.process and self.process.poll() is None:
                if self.guest:
                    self.guest.stuck(self.errors())
                self.process.kill()
                self.process.wait()
            if self.guest:
                self.guest.left(self)
            if self.own:
                shutil.rmtree(self.state, ignore_errors=True)

    def given(self):
        """Options of every daemon of this run of the tests."""
        return os.environ.get("SGA_TEST_DAEMON_FLAGS", "").split()

    def shares(self):
        """Whether its state is a database that may be another's too."""
        return "--store" in [*self.given(), *self.flags]

    def successors(self):
        """Processes that took its place: see upgrade.py."""
        return []

    def place(self):
        """Where its state is, for commands that change it beside the daemon: its folder, or the database that it shares."""
        words = [*self.given(), *self.flags]
        return ["--store", words[words.index("--store") + 1]] if "--store" in words else ["--state", os.path.join(self.state, "sgad")]

    def start(self):
        self.log = open(os.path.join(self.state, "test.log"), "ab")
        os.makedirs(os.path.join(self.state, "sgad"), exist_ok=True)
        self.process = subprocess.Popen(
            [os.path.join(self.build, "sgad"), "--listen", "127.0.0.1:0", "--state", os.path.join(self.state, "sgad"),
             *self.given(), *self.flags],
            stdout=subprocess.PIPE, stderr=self.log if self.stderr is None else self.stderr, env={**os.environ, **(self.env or {})},
            start_new_session=True)
        line = self.process.stdout.readline().decode()
        if not line.startswith("listening on http://127.0.0.1:"):
            raise RuntimeError(f"the daemon said {line!r}: {self.errors()}")
        self.port = int(re.match(r"listening on http://127\.0\.0\.1:(\d+)", line)[1])
        if self.guest:
            self.guest.began()

    def stop(self, seconds=30):
        """SIGTERM; the exit status."""
        self.process.send_signal(signal.SIGTERM)
        return self.ended(seconds)

    def ended(self, seconds=30):
        status = self.process.wait(seconds)
        self.process.stdout.close()
        self.log.close()
        if self.guest:
            self.guest.lived(status, self.all_errors())
        with open(os.path.join(self.state, "test.log"), "rb") as f:
            found = re.search(rb"(WARNING: ThreadSanitizer|ERROR: \w+Sanitizer|runtime error: ).*", f.read(), re.S)
        if found:                 # also of children, whose end nobody else looks at
            raise RuntimeError(found[0][:3000].decode(errors="replace"))
        return status

    def errors(self):
        return self.all_errors()[-3000:]

    def all_errors(self):
        """Of all processes in its place: the last words of one may not be the last lines."""
        with open(os.path.join(self.state, "test.log"), "rb") as f:
            return f.read().decode(errors="replace")

    def url(self):
        return f"http://127.0.0.1:{self.port}"

    # Asking

    def ask(self, method, path, body=None, headers=None, seconds=60):
        """An Answer. body: an object, text or bytes."""
        c = http.client.HTTPConnection("127.0.0.1", self.port, timeout=seconds)
        try:
            send = dict(headers or {})
            if body is not None and "Content-Type" not in send:
                send["Content-Type"] = "application/json"
            data = body if isinstance(body, bytes) else body.encode() if isinstance(body, str) else \
                None if body is None else json.dumps(body).encode()
            try:
                c.request(method, path, data, {k: v for k, v in send.items() if v is not None})
            except (BrokenPipeError, ConnectionResetError):
                pass    # it may have answered before it had read the whole body
            try:
                r = c.getresponse()
                answer = Answer(r.status, {k.lower(): v for k, v in r.getheaders()}, r.read())
            except (OSError, http.client.HTTPException):
                if self.guest:
                    self.guest.lost(self, method, path)
                raise
            if self.guest:
                self.guest.heard(self, method, path, answer, headers)
            return answer
        finally:
            c.close()

    def get(self, path, **headers):
        return self.ask("GET", path, headers={k.replace("_", "-"): v for k, v in headers.items()})

    def raw(self, data, seconds=5):
        """Sends bytes as they are; all that comes back until the other side closes or is silent."""
        with socket.create_connection(("127.0.0.1", self.port), timeout=seconds) as s:
            s.sendall(data)
            out = b""
            try:
                while True:
                    piece = s.recv(65536)
                    if not piece:
                        return out, True
                    out += piece
            except (socket.timeout, ConnectionResetError):
                return out, False

    def wait(self, id_, seconds=60):
        """The job once it has ended."""
        end = time.monotonic() + seconds
        while time.monotonic() < end:
            job = self.get("/v1/jobs/" + id_).json()
            if job["status"] not in ("queued", "running"):
                return job
            time.sleep(0.02)
        said = [x for x in self.all_errors().splitlines() if id_ in x or '"level":"error"' in x or '"level":"warn"' in x]
        raise RuntimeError(f"job {id_} did not end in {seconds} s: {job}; children {self.children()}; log {said[-8:]}")

    def children(self, role=""):
        """Its children: all, or those that run jobs (sgad-job) or check requests (sgad-check)."""
        found = []
        for task in os.listdir(f"/proc/{self.process.pid}/task"):
            try:
                with open(f"/proc/{self.process.pid}/task/{task}/children", encoding="ascii") as f:
                    found += [int(p) for p in f.read().split()]
            except OSError:
                pass
        return [pid for pid in found if self.role(pid).startswith(role)]

    @staticmethod
    def role(pid):
        try:
            with open(f"/proc/{pid}/cmdline", encoding="ascii") as f:
                return f.read().split("\0")[0]
        except OSError:
            return "gone"

    def cpu(self):
        """CPU seconds of the process so far, without its children."""
        with open(f"/proc/{self.process.pid}/stat", encoding="ascii") as f:
            parts = f.read().rsplit(")", 1)[1].split()
        return (int(parts[11]) + int(parts[12])) / os.sysconf("SC_CLK_TCK")


class Answer:
    def __init__(self, status, headers, body):
        self.status, self.headers, self.body = status, headers, body

    def json(self):
        return json.loads(self.body, parse_constant=self.no_constant)

    @staticmethod
    def no_constant(text):
        raise ValueError(f"{text} is not JSON")
