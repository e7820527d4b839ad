"""Sweeps whose sets several processes make: the same answer, whoever makes them, whichever of them ends."""
import json
import os
import signal
import subprocess
import tempfile
import time

from common import COUNTER, slow, trivial
from daemon import Daemon
from isolation import gone, status

HELPS = 5      # the niceness of a process that helps


def sweep(sets=400, stop=20, swept="initial", **more):
    """A double pendulum from starts, or at parameters, that were not asked for before."""
    k = 1e-7 * next(COUNTER)
    members = [{"initial": {"a": 1 + k + 1e-6 * i}} if swept == "initial" else {"parameters": {"m": 1 + k + 1e-3 * i}} for i in range(sets)]
    return {"system": {"form": "lagrangian", "coordinates": ["a", "b"], "parameters": {"m": 1}, "lagrangian": "m*a'^2 + b'^2/2 + a'*b'*cos(a - b) + 20*cos(a) + 10*cos(b)"},
            "want": ["trajectory"], "trajectory": {"start": 0, "stop": stop, "samples": 5, "initial": {"a": 1, "b": 2, "a'": 0, "b'": 0}},
            "accuracy": {"rtol": 1e-10}, "sweep": members, "limits": {"seconds": 300}, **more}


def solve(build, request, *flags):
    with subprocess.Popen([os.path.join(build, "sga"), "solve", "-", "--json", *flags], stdin=subprocess.PIPE, stdout=subprocess.PIPE) as p:
        return p, json.loads(p.communicate(json.dumps(request).encode())[0])


def timeless(result):
    """Everything of a result but how long it took: the counts of work stay."""
    return {**result, "work": {k: v for k, v in result["work"].items() if k != "seconds"}}


def niceness(pid):
    try:
        return os.getpriority(os.PRIO_PROCESS, pid)
    except OSError:
        return None


def helpers(d):
    return [pid for pid in d.children("sgad-job") if niceness(pid) == HELPS]


def leader(d):
    """The process that runs the one job there is: of those that do not help, the one that worked."""
    def worked(pid):
        with open(f"/proc/{pid}/stat", encoding="ascii") as f:
            return sum(map(int, f.read().rsplit(")", 1)[1].split()[11:13]))
    return max((pid for pid in d.children("sgad-job") if niceness(pid) == 0), key=worked)


def asleep(pid):
    """It waits for somebody: it sleeps however often one looks."""
    for _ in range(20):
        if not status(pid)["State"].startswith("S"):
            return False
        time.sleep(0.005)
    return True


def until(condition, seconds=60):
    end = time.monotonic() + seconds
    while time.monotonic() < end:
        found = condition()
        if found:
            return found
        time.sleep(0.005)
    return condition()


def team(build, c):
    with Daemon(build, "--workers", "3") as d:
        for swept in ("initial", "parameters"):
            request = sweep(400 if swept == "initial" else 150, swept=swept)
            id_ = d.ask("POST", "/v1/jobs", request).json()["id"]
            c(until(lambda: helpers(d)), f"team: {swept}: others help")
            job = d.wait(id_, 300)
            c(job["status"] == "done", f"team: {swept}: is done", job.get("error"))
            c(until(lambda: not helpers(d)), f"team: {swept}: nobody helps any more", helpers(d))
            alone = solve(build, request)[1]
            c(timeless(job["result"]) == timeless(alone), f"team: {swept}: the answer is that of one process, to the last digit and count",
              {k: (job["result"][k], alone[k]) for k in alone if k != "trajectories" and job["result"].get(k) != alone[k]})
        request = sweep(12, 1)
        id_ = d.ask("POST", "/v1/jobs", request).json()["id"]
        c(timeless(d.wait(id_)["result"]) == timeless(solve(build, request)[1]), "team: a small sweep")


def team_killed(build, c):
    """What a process had that helped is made by another."""
    with Daemon(build, "--workers", "3") as d:
        request = sweep()
        id_ = d.ask("POST", "/v1/jobs", request).json()["id"]
        found = until(lambda: helpers(d))
        for pid in found:             # children of the daemon that this test started
            os.kill(pid, signal.SIGKILL)
        job = d.wait(id_, 300)
        c(found and job["status"] == "done", "team: helpers that are killed end no job", job.get("error"))
        c(timeless(job.get("result", {"work": {}})) == timeless(solve(build, request)[1]), "team: nor change an answer")


def team_leader_killed(build, c):
    """The process that runs the job is killed: the job runs once more, and nobody helps the one that is gone."""
    with Daemon(build, "--workers", "2") as d:
        request = sweep()
        id_ = d.ask("POST", "/v1/jobs", request).json()["id"]
        c(until(lambda: helpers(d)), "team: another helps")
        os.kill(leader(d), signal.SIGKILL)
        job = d.wait(id_, 300)
        c(job["status"] == "done", "team: a leader that is killed", job.get("error"))
        c(timeless(job.get("result", {"work": {}})) == timeless(solve(build, request)[1]), "team: has its answer later")


def team_leader_killed_asking(build, c):
    """It is killed when it has asked for pieces and was not answered yet: that is a death too, no fault of its message."""
    with Daemon(build, "--workers", "2") as d:
        id_ = d.ask("POST", "/v1/jobs", sweep()).json()["id"]
        c(until(lambda: helpers(d)), "team: another helps, until")
        pid = leader(d)
        d.process.send_signal(signal.SIGSTOP)
        try:
            asked = until(lambda: asleep(pid))
            os.kill(pid, signal.SIGKILL)
            gone(pid)
        finally:
            d.process.send_signal(signal.SIGCONT)
        job = d.wait(id_, 300)
        c(asked and job["status"] == "done", "team: a leader that is killed when it has asked", job.get("error"))


def team_cancelled(build, c):
    with Daemon(build, "--workers", "2") as d:
        id_ = d.ask("POST", "/v1/jobs", sweep(4000)).json()["id"]
        c(until(lambda: helpers(d)), "team: another helps a long sweep")
        c.status(d.ask("DELETE", "/v1/jobs/" + id_), (200, 202), "team: cancelled")
        c(d.wait(id_, 30)["status"] == "cancelled", "team: is cancelled")
        c(until(lambda: not helpers(d), 10), "team: and nobody helps it", helpers(d))
        c(d.ask("POST", "/v1/solve", trivial()).json().get("status") == "done", "team: the next job is done")


def team_gives_way(build, c):
    """Whoever helps leaves once a worker wants the place."""
    with Daemon(build, "--workers", "2") as d:
        long = d.ask("POST", "/v1/jobs", sweep(4000, 60)).json()["id"]
        c(until(lambda: helpers(d)), "team: another helps a very long sweep")
        c(d.ask("POST", "/v1/solve", trivial()).json().get("status") == "done", "team: a short job passes")
        other = d.ask("POST", "/v1/jobs", slow()).json()["id"]
        c(until(lambda: not helpers(d), 30), "team: a long one takes the place of who helps", helpers(d))
        c(d.get("/v1/jobs/" + long).json()["status"] == "running", "team: the sweep goes on")
        c.status(d.ask("DELETE", "/v1/jobs/" + other), (200, 202), "team: the other is cancelled")
        c(until(lambda: helpers(d), 30), "team: the place is free, another helps again")
        c(d.stop() == 0, "team: the daemon ends while others help", d.errors()[-500:])
        d.start()
        c(d.get("/v1/jobs/" + long).json()["status"] in ("queued", "running"), "team: the sweep is queued again")
        d.ask("DELETE", "/v1/jobs/" + long)


def copies_of(pid):
    try:
        with open(f"/proc/{pid}/task/{pid}/children", encoding="ascii") as f:
            return [int(p) for p in f.read().split()]
    except OSError:
        return []


def processes(build, c):
    """The command with several processes, one of which is killed."""
    request = sweep()
    one = timeless(solve(build, request)[1])
    c(timeless(solve(build, request, "--processes", "3")[1]) == one, "sga solve --processes: the answer of one process")
    with tempfile.TemporaryFile() as out:
        with subprocess.Popen([os.path.join(build, "sga"), "solve", "-", "--json", "--processes", "3"], stdin=subprocess.PIPE, stdout=out) as p:
            p.stdin.write(json.dumps(request).encode())
            p.stdin.close()
            found = until(lambda: copies_of(p.pid))
            if found:
                os.kill(found[0], signal.SIGKILL)
            status = p.wait(300)
        out.seek(0)
        c(found and status == 0 and timeless(json.loads(out.read())) == one, "sga solve --processes: a copy that is killed changes nothing", status)
    for wrong in ("-1", "x", "257"):
        c(subprocess.run([os.path.join(build, "sga"), "solve", "-", "--processes", wrong], input=b"{}", capture_output=True).returncode == 2, f"--processes {wrong}")


ALL = [team, team_killed, team_leader_killed, team_leader_killed_asking, team_cancelled, team_gives_way, processes]
