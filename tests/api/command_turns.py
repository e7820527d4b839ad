"""The commands of `sgad` that change files, and a start of the daemon, with one call after the other failing (see turns.py).

A command that says 0 has done it, whole; any other end says why, and leaves what was there before, whole. A start either serves or
says why it does not, and loses nothing."""
import os
import re
import shutil
import sqlite3
import subprocess
import tempfile
import time

from common import moving, slow, trivial
from daemon import Daemon
from shim import KINDS


def sgad(build, *words, env=None):
    return subprocess.run([os.path.join(build, "sgad"), *words], capture_output=True, text=True, timeout=120, check=False, env={**os.environ, **(env or {})})


def jobs_of(state):
    """Its jobs with their ends, as the file has them; None where it cannot be read."""
    try:
        with sqlite3.connect(f"file:{state}/queue.db?mode=ro", uri=True) as db:
            found = dict(db.execute("SELECT id, status FROM jobs").fetchall())
        db.close()
        return found
    except sqlite3.Error:
        return None


def state_made(build, folder):
    """A state with jobs that are done, one that is queued behind one that runs, and a token."""
    os.mkdir(folder)
    with Daemon(build, "--workers", "1", state=folder) as d:
        for k in range(4):
            d.ask("POST", "/v1/solve", moving(k + 1))
        d.ask("POST", "/v1/jobs", slow(1000))
        d.ask("POST", "/v1/jobs", trivial())
        sgad(build, "token", "create", *d.place(), "--name", "ann")
        d.stop()


class Scene:
    """A copy of the state for one run of a command."""

    def __init__(self, build, folder, made):
        self.build, self.made, self.folder = build, made, folder
        self.state, self.to = os.path.join(folder, "work"), os.path.join(folder, "to")
        self.jobs = jobs_of(made)

    def lay_out(self):
        for path in (self.state, self.to, self.to + ".partial"):
            shutil.rmtree(path, ignore_errors=True)
        shutil.copytree(self.made, self.state)

    def sound(self, state):
        return sgad(self.build, "check", "--state", state).returncode == 0

    def tokens(self):
        run = sgad(self.build, "token", "list", "--state", self.state)
        return dict(re.findall(r"^(\S+)\t(\S+)", run.stdout, re.M)) if run.returncode == 0 else None


def copied(s, run):
    """backup and restore: whole or absent."""
    there = os.path.exists(s.to)
    if run.returncode == 0 and not there:
        return "it says 0, and there is no copy"
    if run.returncode != -6 and os.path.exists(s.to + ".partial"):
        return "half a copy is left"
    if there and not (s.sound(s.to) and jobs_of(s.to) == s.jobs):
        return "the copy is not whole"
    if there and open(s.to + "/instance", "rb").read() != open(s.state + "/instance", "rb").read():
        return "the copy has not the name of the state"
    return ""


def unchanged(s, run):
    return "" if jobs_of(s.state) == s.jobs else "the state is another"


def pruned(s, run):
    """Queued jobs stay; what was to go went, where it says 0."""
    now, open_ = jobs_of(s.state), {i for i, status in s.jobs.items() if status in (0, 1)}
    if now is None or not open_ <= set(now) <= set(s.jobs):
        return "other jobs are there"
    return "it says 0, and jobs are left" if run.returncode == 0 and len(now) != len(open_) + 1 else ""


def named(s, run):
    """token create: what is printed is in the list."""
    now = s.tokens()
    if now is None:
        return "the tokens cannot be read"
    return "" if "ann" in now and (run.returncode != 0 or "bob" in now and run.stdout.startswith("sgad_")) else f"the tokens are {now}"


def revoked(s, run):
    now = s.tokens()
    if now is None:
        return "the tokens cannot be read"
    return "it says 0, and the token is valid" if run.returncode == 0 and now.get("ann") != "revoked" else ""


def damaged(s):
    with sqlite3.connect(os.path.join(s.state, "queue.db")) as db:
        db.execute("UPDATE jobs SET request = CAST(request AS TEXT) || ' '")
    db.close()


def not_sound(s, run):
    return "it says that damage is none" if run.returncode == 0 else ""


def started(s, run):
    return "" if jobs_of(s.state) is not None and set(s.jobs) <= set(jobs_of(s.state)) and s.sound(s.state) else "jobs are lost"


COMMANDS = {
    "backup": (lambda s: ["backup", s.to, "--state", s.state], copied, None),
    "restore": (lambda s: ["restore", s.state, "--state", s.to], copied, None),
    "check": (lambda s: ["check", "--state", s.state], unchanged, None),
    "check of damage": (lambda s: ["check", "--state", s.state], not_sound, damaged),
    "prune": (lambda s: ["prune", "--keep", "1", "--state", s.state], pruned, None),
    "token create": (lambda s: ["token", "create", "--name", "bob", "--state", s.state], named, None),
    "token revoke": (lambda s: ["token", "revoke", "--name", "ann", "--state", s.state], revoked, None),
    "start": (None, started, None),
}


def start(s, env):
    """Until it serves, and a little longer; then it is ended."""
    p = subprocess.Popen([os.path.join(s.build, "sgad"), "--listen", "127.0.0.1:0", "--state", s.state, "--workers", "1"], stdout=subprocess.PIPE, stderr=subprocess.PIPE,
                         text=True, env={**os.environ, **env})
    if p.stdout.readline().startswith("listening"):
        time.sleep(0.05)
        p.terminate()
    try:
        out, err = p.communicate(timeout=60)
    except subprocess.TimeoutExpired:
        p.kill()
        out, err = p.communicate()
        return subprocess.CompletedProcess("start", 99, out, "it hangs: " + err)
    return subprocess.CompletedProcess("start", p.returncode, out, err)


def once(s, shim, name, kind, nth, length):
    words, after, before = COMMANDS[name]
    s.lay_out()
    if before:
        before(s)
    shim.arm(kind, nth, length)
    run = sgad(s.build, *words(s), env=shim.env) if words else start(s, shim.env)
    if kind:
        shim.disarm()
    return run, after


def commands(tally, build, shim, count, rng):
    with tempfile.TemporaryDirectory(prefix="sgad-commands-") as folder:
        state_made(build, folder + "/made")
        s, failed = Scene(build, folder, folder + "/made/sgad"), 0
        tally.check(s.jobs and len(s.jobs) == 6, "a state for the commands", s.jobs)
        for name in COMMANDS:
            run, after = once(s, shim, name, "", 0, 0)
            found = after(s, run)
            tally.check(not found and run.returncode == (1 if "damage" in name else 0), f"{name}: without faults", (found, run))
            counts = {k: shim.count(k) for k in KINDS[1:]}
            for kind, total in counts.items():
                for nth in range(1, total + 1) if not count or total <= count else sorted(rng.sample(range(1, total + 1), count)):
                    length = rng.choice((1, 1, 20))
                    run, after = once(s, shim, name, kind, nth, length)
                    failed += shim.failed()
                    what = f"{name}, {kind} {nth}" + (f" to {nth + length - 1}" if length > 1 else "")
                    tally.check(run.returncode in (0, 1) or run.returncode == -6 and kind == "memory" and "out of memory" in run.stderr, f"{what}: it ends in order", run)
                    tally.check(run.returncode == 0 or run.stderr or run.stdout or kind == "log", f"{what}: it says why", run)
                    found = after(s, run)
                    tally.check(not found, f"{what}: {found}", run)
        print(f"calls of commands that failed: {failed}", flush=True)
