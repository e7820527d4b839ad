"""The command line about a daemon's jobs: check, list, get, wait, cancel, events, samples as CSV, a caret under what is wrong, Ctrl-C."""
import json
import os
import signal
import subprocess

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


ALL = [command_jobs, command_checks, command_interrupt]
