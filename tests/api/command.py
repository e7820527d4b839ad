"""The command line about a daemon's jobs: check, list, get, wait, cancel, events, samples as CSV, a caret under what is wrong, Ctrl-C."""
import contextlib
import http.server
import json
import os
import pty
import re
import signal
import subprocess
import threading
import time
import xml.etree.ElementTree

from access import until
from common import moving, slow, trivial
from daemon import Daemon


class Sga:
    def __init__(self, build, d):
        self.program, self.d = os.path.join(build, "sga"), d
        self.env = {k: v for k, v in os.environ.items() if k not in ("SGA_TOKEN", "SGA_SERVER")}

    def file(self, request):
        path = os.path.join(self.d.state, "request.json")
        with open(path, "w", encoding="utf-8") as f:
            f.write(request if isinstance(request, str) else json.dumps(request, ensure_ascii=False))
        return path

    def __call__(self, *words, server=True, **env):
        more = ["--server", self.d.url()] if server else []
        return subprocess.run([self.program, *words, *more], capture_output=True, text=True, timeout=60, check=False, env={**self.env, **env})


WRONG = {"system": {"form": "equations", "variables": ["x", "y"], "equations": ["x' = -x + ρ*q", "y' = x"]}}


def command_jobs(build, c):
    with Daemon(build, "--workers", "1") as d:
        sga = Sga(build, d)
        done = d.ask("POST", "/v1/solve", moving()).json()
        r = sga("get", done["id"], "--json")
        c(r.returncode == 0 and json.loads(r.stdout) == done["result"], "get: the result", r.stderr)
        r = sga("get", "/v1/jobs/" + done["id"], "--text")
        c(r.returncode == 0 and "verdict" in r.stdout.lower() and not r.stdout.startswith("{"), "get: as text, by its path", r.stdout[:200])
        table = d.get(f"/v1/jobs/{done['id']}/trajectory?format=csv").body.decode()
        r = sga("wait", done["id"], "--csv")
        c(r.returncode == 0 and r.stdout.splitlines() == table.splitlines() and len(table.splitlines()) > 2, "wait --csv: the daemon's table", r.stdout[:200])
        path = sga.file(moving())
        for name, r in (("here", sga("solve", path, "--csv", server=False)), ("there", sga("solve", path, "--csv"))):
            c(r.returncode == 0 and r.stdout.splitlines()[0] == table.splitlines()[0] and len(r.stdout.splitlines()) == len(table.splitlines()), f"solve --csv {name}", r.stderr)
        r = sga("solve", sga.file(trivial()), "--csv")
        c(r.returncode == 1 and not r.stdout and "trajectory" in r.stderr, "--csv without a trajectory", r)
        one = d.ask("POST", "/v1/jobs", slow()).json()["id"]
        c(until(lambda: d.get("/v1/jobs/" + one).json()["status"] == "running"), "a job runs")
        r = sga("list", "--json", "--limit", "1")
        c(r.returncode == 0 and [j["id"] for j in json.loads(r.stdout)["jobs"]] == [one], "list --limit", r)
        r = sga("list", "--text", "--status", "done", server=False, SGA_SERVER=d.url())
        c(r.returncode == 0 and done["id"] in r.stdout and one not in r.stdout and r.stdout.startswith("id "), "list --status, by SGA_SERVER", r)
        r = sga("get", one)
        c(r.returncode == 1 and not r.stdout and "not ended" in r.stderr, "get: not yet", r)
        r = sga("wait", one, "--wait", "1")
        c(r.returncode == 1 and "not ended" in r.stderr, "wait: no longer than asked", r)
        with subprocess.Popen([sga.program, "events", one, "--json", "--server", d.url()], stdout=subprocess.PIPE, text=True, env=sga.env) as watch:
            first = json.loads(watch.stdout.readline())
            c(first["id"] == one and first["status"] == "running", "events: what happens now", first)
            r = sga("cancel", one, "--text")
            c(r.returncode == 0 and r.stdout == "cancelled\n", "cancel", r)
            last = [json.loads(line) for line in watch.stdout][-1]
            c(last["status"] == "cancelled" and watch.wait(30) == 1, "events: the end", last)
        r = sga("events", done["id"], "--text")
        c(r.returncode == 0 and r.stdout.startswith("done") and "100.0 %" in r.stdout, "events of a job that has ended", r)
        r = sga("cancel", done["id"], "--text")
        c(r.returncode == 0 and "withdrawn" in r.stdout, "cancel: had ended", r)
        r = sga("wait", one)
        c(r.returncode == 1 and "cancelled" in r.stderr and not r.stderr.startswith("{"), "wait: of a cancelled job", r)
        for command in ("get", "wait", "cancel", "events"):
            r = sga(command, "0" * 32)
            c(r.returncode == 1 and "not_found" in r.stderr, f"{command}: no such job", r)
            r = sga(command, "../x")
            c(r.returncode == 2 and "no id of a job" in r.stderr, f"{command}: no id", r.stderr[:200])
            r = sga(command, one, server=False)
            c(r.returncode == 2 and "--server" in r.stderr, f"{command}: no server", r.stderr[:200])
        for words in (["list", "x"], ["list", "--csv"], ["list", "--limit", "1 x"], ["check"], ["cancel", one, "--wait", "1"], ["solve", path, "--json", "--csv"], ["code", path]):
            c(sga(*words).returncode == 2, f"wrong usage: {words}")


def command_ready(build, c):
    """For probes: takes jobs, does not, is not there."""
    with Daemon(build, "--access", "tokens", "--queue", "1") as d:
        sga = Sga(build, d)
        r = sga("ready", "--text")
        c(r.returncode == 0 and r.stdout == "ready\n" and not r.stderr, "ready", r)
        r = sga("ready", "--json")
        c(r.returncode == 0 and json.loads(r.stdout) == d.get("/readyz").json(), "ready --json", r)
        r = sga("ready", "x")
        c(r.returncode == 2 and "nothing belongs there" in r.stderr, "ready takes no word", r.stderr[:100])
    r = sga("ready")
    c(r.returncode == 1 and "cannot connect" in r.stderr, "no daemon is not ready", r)
    with Daemon(build, "--workers", "1", "--grace", "30") as d:
        sga = Sga(build, d)
        one = d.ask("POST", "/v1/jobs", slow()).json()["id"]
        c(until(lambda: d.get("/v1/jobs/" + one).json()["status"] == "running"), "a job runs")
        d.process.send_signal(signal.SIGUSR1)
        c(until(lambda: d.get("/readyz").status == 503), "it drains")
        r = sga("ready", "--text")
        c(r.returncode == 1 and not r.stdout and "draining" in r.stderr, "a service that drains is not ready", r)
        sga("cancel", one)


def command_checks(build, c):
    with Daemon(build) as d:
        sga = Sga(build, d)
        for server in (True, False):
            place = "there" if server else "here"
            r = sga("check", sga.file(moving()), "--text", server=server)
            c(r.returncode == 0 and r.stdout.splitlines()[-1].startswith("valid: "), f"check {place}: good", r)
            r = sga("check", sga.file(WRONG), "--json", server=server)
            said = json.loads(r.stdout)
            c(r.returncode == 1 and said["valid"] is False and said["problems"], f"check {place}: bad", r)
            r = sga("check", sga.file(WRONG), "--text", server=server)
            lines = r.stdout.splitlines()
            k = next((i for i, line in enumerate(lines) if line == "    x' = -x + ρ*q"), None)
            column = next((p["column"] for p in said["problems"] if p["pointer"] == "/system/equations/0"), 0)
            c(r.returncode == 1 and k is not None and lines[k + 1] == "    " + " " * (column - 1) + "^" and lines[k + 1].index("^") == lines[k].index("ρ"),
              f"check {place}: a caret under the column", r.stdout)
            r = sga("solve", sga.file({"system": {**WRONG["system"], "equations": ["x' = (1 + é", "y' = x"]}}), "--text", server=server)
            lines = r.stderr.splitlines()
            c(r.returncode == 1 and "    x' = (1 + é" in lines and lines[-1].strip() == "^", f"solve {place}: a caret", r.stderr)
            for before, behind in ((0, 500), (500, 0), (500, 500), (40, 40)):      # of a long line what is around the place
                text = "x' = " + "x + " * before + "ρ*ö" + " + x" * behind
                r = sga("solve", sga.file({"system": {**WRONG["system"], "equations": [text, "y' = x"]}}), "--text", server=server)
                lines = r.stderr.splitlines()
                c(r.returncode == 1 and len(lines[-2]) < 140 and lines[-2][lines[-1].index("^")] in "ρö" and lines[-2].strip().strip(".") in text,
                  f"solve {place}: a caret after {before} terms", r.stderr)
            r = sga("solve", sga.file('{"system":\n  {"form": equations}}'), "--text", server=server)
            lines = r.stderr.splitlines()
            c(r.returncode == 1 and '      {"form": equations}}' in lines and lines[-1].strip() == "^", f"solve {place}: a caret in JSON", r.stderr)


def command_interrupt(build, c):
    with Daemon(build, "--workers", "1") as d:
        sga = Sga(build, d)
        p = subprocess.Popen([sga.program, "solve", sga.file(slow()), "--server", d.url()], stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, env=sga.env)
        c(until(lambda: any(j["status"] == "running" for j in d.get("/v1/jobs").json()["jobs"])), "the job runs")
        p.send_signal(signal.SIGINT)
        out, said = p.communicate(timeout=30)
        c(p.returncode == 130 and "was cancelled" in said and not out, "Ctrl-C is said", (p.returncode, said))
        c(until(lambda: d.get("/v1/jobs").json()["jobs"][0]["status"] == "cancelled"), "Ctrl-C cancels the job")
        ends = set()
        for turn in range(16):            # before, while and after the job is posted
            p = subprocess.Popen([sga.program, "solve", sga.file(slow()), "--server", d.url()], stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, env=sga.env)
            time.sleep(0.004 * turn)
            p.send_signal(signal.SIGINT)
            p.communicate(timeout=30)
            ends.add(p.returncode)
        c(ends <= {-signal.SIGINT, 130}, "Ctrl-C ends it whenever it comes", ends)
        c(until(lambda: not any(j["status"] in ("queued", "running") for j in d.get("/v1/jobs").json()["jobs"])), "and leaves no job behind")


def lines_of(text):
    """The points of each line of an image, in pixels."""
    root = xml.etree.ElementTree.fromstring(text)
    return [[tuple(map(float, p.split(","))) for p in e.get("points").split()] for e in root.iter("{http://www.w3.org/2000/svg}polyline")]


def straight(pixels, values):
    """Whether pixels are an affine image of values, to what two decimals can tell."""
    low, high = min(range(len(values)), key=values.__getitem__), max(range(len(values)), key=values.__getitem__)
    slope = (pixels[high] - pixels[low]) / (values[high] - values[low])
    return abs(slope) > 1 and all(abs(pixels[low] + slope * (v - values[low]) - p) < 0.03 for p, v in zip(pixels, values))


def command_plots(build, c):
    with Daemon(build) as d:
        sga = Sga(build, d)
        request = {**moving(), "trajectory": {"stop": 7, "samples": 40, "initial": {"x": 0}}}
        request["system"] = {**request["system"], "equations": ["x' = y", "y' = -x", "x^2 + y^2 = 9"]}
        path = sga.file(request)
        table = [line.split(",") for line in sga("solve", path, "--csv").stdout.splitlines()]
        column = {name: [float(row[i]) for row in table[1:]] for i, name in enumerate(table[0])}
        for server in (True, False):
            r = sga("plot", path, server=server)
            lines = lines_of(r.stdout)
            c(r.returncode == 0 and len(lines) == len(column) - 1, "plot: a line for each column", r.stderr)
            for line, name in zip(lines, table[0][1:]):
                c(straight([p[0] for p in line], column["t"]) and straight([-p[1] for p in line], column[name]), f"plot: {name} over t")
        r = sga("solve", path, "--svg", "--columns", "y", "--x", "x")
        lines = lines_of(r.stdout)
        c(len(lines) == 1 and straight([p[0] for p in lines[0]], column["x"]) and straight([-p[1] for p in lines[0]], column["y"]), "solve --svg: a phase plane", r.stderr)
        r = sga("plot", path, "--columns", "x,nothing")
        c(r.returncode == 1 and not r.stdout and "no column nothing; it has t x y" in r.stderr, "plot: no such column", r)
        r = sga("plot", sga.file(trivial()))
        c(r.returncode == 1 and not r.stdout and "no samples" in r.stderr, "plot: no samples", r)
        c(sga("solve", path, "--x", "x").returncode == 2, "--x without an image")
        sweep = {"system": {"form": "equations", "variables": ["x"], "parameters": {"k": 1}, "equations": ["x' = -k*x"]},
                 "sweep": [{"parameters": {"k": 1}}, {"parameters": {"k": 0}}], "trajectory": {"stop": 1, "samples": 3, "initial": {"x": 2}}}
        r = sga("plot", sga.file(sweep))
        c(r.returncode == 0 and len(lines_of(r.stdout)) == 2 and "x, set 1" in r.stdout, "plot of a sweep", r.stderr)


@contextlib.contextmanager
def middleman(d):
    """Stands between client and daemon: takes requests in absolute form (a proxy) and below /sga (a site), and notes what came."""
    seen = []

    class Handler(http.server.BaseHTTPRequestHandler):
        def do_GET(self):
            seen.append((self.path, dict(self.headers)))
            path = self.path.split("/", 3)[-1] if "://" in self.path else self.path.split("/", 2)[2]
            length = int(self.headers.get("Content-Length") or 0)
            if self.path.startswith("/elsewhere/"):
                self.send_response(307)
                self.send_header("Location", d.url() + "/v1/jobs")
                self.send_header("Content-Length", "0")
                self.end_headers()
                return
            r = d.ask(self.command, "/" + path, self.rfile.read(length) or None, headers={k: self.headers[k] for k in ("Content-Type", "Prefer") if self.headers[k]})
            self.send_response(r.status)
            for name, value in r.headers.items():
                if name in ("content-type", "location"):
                    self.send_header(name, value)
            body = r.body[:len(r.body) // 2] if "short" in self.path else r.body
            self.send_header("Content-Length", str(len(r.body)))
            self.end_headers()
            self.wfile.write(body)
        do_POST = do_DELETE = do_GET

        def log_message(self, *_):
            pass

    server = http.server.ThreadingHTTPServer(("127.0.0.1", 0), Handler)
    threading.Thread(target=server.serve_forever, daemon=True).start()
    try:
        yield server.server_address[1], seen
    finally:
        server.shutdown()
        server.server_close()


def command_proxies(build, c):
    """Proxies as the environment names them, never for this machine; sites below a path; replies that break off; no redirects."""
    with Daemon(build) as d, middleman(d) as (port, seen):
        sga = Sga(build, d)
        sga.env = {k: v for k, v in sga.env.items() if k.lower() not in ("http_proxy", "https_proxy", "all_proxy", "no_proxy")}
        path, proxy = sga.file(moving()), f"http://127.0.0.1:{port}"
        r = sga("solve", path, "--json", "--server", "http://service.invalid:81", server=False, http_proxy=proxy)
        c(r.returncode == 0 and json.loads(r.stdout)["verdict"] == "unique", "a proxy of the environment", r)
        c(seen and seen[0][0] == "http://service.invalid:81/v1/solve" and seen[0][1]["Host"] == "service.invalid:81" and seen[0][1]["Prefer"] == "wait=0", "what the proxy saw", seen[:1])
        before = len(seen)
        r = sga("list", "--json", "--server", "http://service.invalid:81", server=False, http_proxy=proxy, no_proxy="service.invalid")
        c(r.returncode == 1 and "cannot find service.invalid port 81" in r.stderr and len(seen) == before, "no_proxy", r)
        r = sga("list", "--json", "--server", "https://service.invalid", server=False, https_proxy=proxy)
        c(r.returncode == 1 and not r.stdout and len(seen) == before, "a proxy that makes no tunnel", r)
        for name in ("127.0.0.1", "localhost"):
            r = sga("list", "--json", "--server", f"http://{name}:{d.port}/", server=False, http_proxy=proxy, all_proxy=proxy, SGA_TOKEN="secret")
            c(r.returncode == 0 and len(seen) == before, f"no proxy for {name}, nor for a token", r)
        r = sga("list", "--json", "--server", "http://127.service.invalid:81", server=False, http_proxy=proxy, SGA_TOKEN="secret")
        c(r.returncode == 1 and "token is not sent" in r.stderr and len(seen) == before, "a name that looks like loopback", r)
        site = f"http://127.0.0.1:{port}/sga/"
        r = sga("solve", path, "--json", "--server", site, server=False)
        c(r.returncode == 0 and json.loads(r.stdout)["verdict"] == "unique" and seen[-1][0].startswith("/sga/v1/"), "a site below a path", r)
        r = sga("list", "--json", "--server", f"http://127.0.0.1:{port}/elsewhere", server=False)
        c(r.returncode == 1 and not json.loads(r.stdout or "{}").get("jobs"), "redirections are not followed", r)
        seen_id = json.loads(sga("list", "--json").stdout)["jobs"][0]["id"]
        r = sga("get", seen_id, "--json", "--server", f"http://127.0.0.1:{port}/short", server=False)
        c(r.returncode == 1 and not r.stdout and "gave no whole reply" in r.stderr, "a reply that breaks off", r)
        for address in ("ftp://x", "127.0.0.1:80", "http://", f"{site}?a=1", "http://a b", "http://ann:word@127.0.0.1", "unix:relative"):
            r = sga("list", "--server", address, server=False)
            c(r.returncode == 1 and "is no address" in r.stderr, f"{address} is no address", r)


def on_terminal(command, env, until_shown=None):
    """Standard error as a terminal gets it; SIGINT once `until_shown` stands there. (exit status, standard output, text)"""
    ours, theirs = pty.openpty()
    with subprocess.Popen(command, stdout=subprocess.PIPE, stderr=theirs, env=env, start_new_session=True) as p:
        os.close(theirs)
        text = b""
        while True:
            try:
                piece = os.read(ours, 4096)
            except OSError:      # the other side is gone
                piece = b""
            if not piece:
                break
            text += piece
            if until_shown and re.search(until_shown, text):
                p.send_signal(signal.SIGINT)
                until_shown = None
        os.close(ours)
        return p.wait(60), p.stdout.read().decode(), text.decode()


def command_progress(build, c):
    """A line with share and time left, on a terminal alone, erased at the end."""
    line = rb"\rtrajectory, (\d+) %, \d+ s, about \d+ (?:s|min|h) left"
    with Daemon(build, "--workers", "1") as d:
        sga = Sga(build, d)
        status, out, text = on_terminal([sga.program, "solve", sga.file(slow()), "--server", d.url()], sga.env, line)
        c(status == 130 and not out and re.search(line.decode(), text), "progress there: the line", text[-300:])
        c(re.search(r"left *\r +\rsga: interrupted; the job \S+ was cancelled\r\n$", text), "progress there: erased before what is said", text[-300:])
        one = d.ask("POST", "/v1/jobs", slow()).json()["id"]
        status, out, text = on_terminal([sga.program, "wait", one, "--wait", "4", "--server", d.url()], sga.env)
        c(status == 1 and "\rtrajectory, " in text and re.search(r"\r +\rsga: the job has not ended yet", text), "progress of wait", text[-300:])
        d.ask("DELETE", "/v1/jobs/" + one)
        long = {**slow(), "limits": {"seconds": 9}}      # of which one solution gets four
        status, out, text = on_terminal([sga.program, "solve", sga.file(long), "--json"], sga.env)
        shown = [int(s) for s in re.findall(r"\rtrajectory, (\d+) %", text)]
        c(status in (0, 1) and out and len(shown) > 2 and shown == sorted(shown) and 50 <= shown[0] < shown[-1] < 100, "progress here: never back", text[-300:])
        c("left" in text and re.search(r"\r +\r(sga: [^\r]*\r\n)?$", text), "progress here: erased", text[-300:])
        status, out, text = on_terminal([sga.program, "solve", sga.file(trivial()), "--json"], sga.env)
        c(status == 0 and not text, "no progress of what is short", text)
        r = sga("solve", sga.file(long), "--json", server=False)
        c("%" not in r.stderr and "\r" not in r.stderr, "no progress off a terminal", r.stderr)


# Words of the text for members whose names it does not use; "": that they are there is seen otherwise.
WORDS = {"dimensions": "dimensions: ambient", "vector_field": "reduced vector field", "error_estimate": "error estimate", "constraint_residual": "constraint residual", "advice": "seconds", "components": "der(", "free": "", "fields": "gauge field", "columns": "", "rows": "",
         "ended": "", "definitions": "with", "name": "", "where": "0 = ", "kind": "", "trajectories": "trajectory of set", "constraints": "P1", "method": "by "}


def said(value, path, key):
    """Each member of the answer that holds something, and of its parts: (path, word that has to stand in the text)."""
    if value in (None, [], {}):
        return
    yield f"{path}{key}", WORDS.get(key, key)
    if key in ("dimensions", "index", "vector_field", "gauge", "trajectory", "tradeoff") and isinstance(value, dict):
        for k, v in value.items():
            yield from said(v, f"{path}{key}.", k)
    elif key in ("trajectories", "strata"):
        for i, one in enumerate(value):
            for k, v in one.items():
                yield from said(v, f"{path}{key}[{i}].", k)


def command_text(build, c):
    """What people read leaves nothing out in silence: every member of an answer and of its parts has its word, or stands among those that --json has."""
    from cases import load
    pendulum = {"form": "equations", "variables": ["x", "y", "lam"], "parameters": {"g": "9.81"}, "equations": ["x'' = -lam*x", "y'' = -lam*y - g", "x^2 + y^2 = 1"]}
    motion = {"stop": 1, "samples": 3, "initial": {"x": 1, "y": 0}, "events": [{"name": "lowest", "expression": "x"}], "integrals": ["g*y + (x'^2 + y'^2)/2"], "sensitivities": {"parameters": ["g"]}}
    every = ["constraints", "index", "vector_field", "gauge", "trajectory", "consistent_initial", "structure", "tradeoff", "derivation", "linearization"]
    requests = {
        "pendulum": {"system": pendulum, "want": every, "trajectory": motion, "linearization": {"at": "start"}},
        "digits": {"system": pendulum, "trajectory": {"stop": 1, "samples": 3, "initial": {"x": 1, "y": 0}}, "accuracy": {"arithmetic": "ball"}},
        "sweep": {"system": {"form": "equations", "variables": ["x"], "parameters": {"p": 1}, "equations": ["x' = -x/p"]}, "trajectory": {"stop": 1, "samples": 3, "initial": {"x": 1}},
                  "sweep": [{"parameters": {"p": p}} for p in (1, 0, 2)]},
        "solved strata": {"system": {"form": "quasilinear", "variables": ["x", "y", "z"], "A": [["x", 0, 0], [0, "y", 0], [0, 0, 1]], "alpha": ["y*z", "x", "1"]}, "strata": "solve"},
        "modes": {"system": {"form": "equations", "variables": ["x"], "modes": {"m": {"values": [1, 2], "start": 1}}, "equations": ["x' = if(m == 1, 1, -2)"]},
                  "trajectory": {"stop": 2, "samples": 5, "initial": {"x": 0}, "events": [{"name": "top", "expression": "x - 1", "direction": "up", "action": "set", "set": {"m": "2"}}]}},
        "slides": {"system": {"form": "equations", "variables": ["x", "v"], "equations": ["x' = v", "v' = -2*sign(v) + sin(t)"]}, "trajectory": {"stop": 3, "samples": 5, "initial": {"x": 0, "v": 1}, "sliding": True}},
    }
    for case in [x for x in load(()) if "request" in x and "refused" not in x["expect"]][::150]:
        requests[case["name"]] = case["request"]
    with Daemon(build) as d:
        sga = Sga(build, d)
        for name, request in requests.items():
            path = sga.file(request)
            answer, text = (sga("solve", path, how, server=False).stdout for how in ("--json", "--text"))
            result = json.loads(answer)
            if "verdict" not in result:
                continue
            left = " ".join(re.findall(r"^\(.*: --json\)$", text, re.M))
            missing = [at for k, v in result.items() for at, word in said(v, "", k) if not (word in text if word else True) and not re.search(rf"\b{re.escape(at.rpartition('.')[2])}\b", left)]
            c(not missing, f"text of {name}: nothing is left out in silence", missing)
            if name in ("pendulum", "sweep", "modes", "slides"):
                parts = {"pendulum": ["lowest", "d(x)/d(g)", "largest", "best"], "sweep": ["trajectory of set 2", "trajectories[1].error"], "modes": ["pieces", "top"], "slides": ["slides"]}[name]
                c(all(p in text for p in parts), f"text of {name}: its parts", [p for p in parts if p not in text])


ALL = [command_text, command_ready, command_progress, command_proxies, command_plots, command_jobs, command_checks, command_interrupt]
