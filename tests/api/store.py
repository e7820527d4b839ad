"""Files that are gone, damaged, newer or full: each has a defined behaviour."""
import contextlib
import os
import random
import resource
import shutil
import sqlite3
import subprocess
import tempfile
import time

from common import moving, slow, trivial
from daemon import Daemon


def path(d, name):
    return os.path.join(d.state, "sgad", name)


def essence(job):
    """What an answer says, apart from when it was computed."""
    return {k: v for k, v in job.get("result", {}).items() if k != "work"}


def some_jobs(d, n=6):
    return {j["id"]: essence(j) for j in (d.ask("POST", "/v1/solve", moving()).json() for _ in range(n))}


def again(d, c, jobs, label):
    """Every job still has its answer, computed once more where it must be."""
    for id_, was in jobs.items():
        a = d.get("/v1/jobs/" + id_)
        if c(a.status == 200, f"{label}: the job is there", a.body[:200]):
            now = d.wait(id_)
            c(essence(now) == was, f"{label}: the same answer", (now["status"], now.get("error"), list(now)))


def refused(d, c, label, word):
    """The daemon does not start, says why, and leaves the file as it is."""
    with open(path(d, "queue.db"), "rb") as f:
        before = f.read()
    run = subprocess.run([os.path.join(d.build, "sgad"), "--listen", "127.0.0.1:0", "--state", os.path.join(d.state, "sgad")],
                         capture_output=True, timeout=30, check=False)
    c(run.returncode == 1 and word in run.stderr.decode(), f"{label}: refused with the reason", (run.returncode, run.stderr))
    with open(path(d, "queue.db"), "rb") as f:
        c(f.read() == before, f"{label}: the file is left as it is")


def dropped(build, c):
    """The results are in a file of their own that may go at any time."""
    with Daemon(build, "--cache-memory", "0") as d:
        jobs = some_jobs(d)
        again(d, c, jobs, "from the file")
        d.stop()
        for name in os.listdir(os.path.join(d.state, "sgad")):
            if name.startswith("cache.db"):
                os.remove(path(d, name))
        d.start()
        again(d, c, jobs, "results deleted")
        d.stop()
        with open(path(d, "cache.db"), "wb") as f:
            f.write(random.Random(1).randbytes(20000))
        d.start()
        again(d, c, jobs, "results overwritten")
        d.stop()                  # the last lines of the log are there once it has ended
        with open(os.path.join(d.state, "test.log"), encoding="utf-8") as f:
            c("cache_dropped" in f.read(), "results overwritten: it is logged")
        with sqlite3.connect(path(d, "cache.db")) as db:
            db.execute("PRAGMA user_version=999")
        db.close()
        run = subprocess.run([os.path.join(build, "sgad"), "--listen", "127.0.0.1:0", "--state", os.path.join(d.state, "sgad")],
                             capture_output=True, timeout=30, check=False)
        c(run.returncode == 1 and b"newer sgad" in run.stderr, "newer results: refused", run.stderr)
        os.remove(path(d, "cache.db"))
        d.start()


def flipped(build, c):
    """Bytes of the results change, before the start and while it runs: never a wrong answer."""
    rng = random.Random(20261121)
    with Daemon(build, "--cache-memory", "0") as d:
        jobs = some_jobs(d, 12)
        for kind in ("bytes", "pages"):
            for running in (False, True):
                if not running:
                    d.stop()
                else:                 # put what the log holds into the file, which readers then read
                    with sqlite3.connect(path(d, "cache.db")) as db:
                        db.execute("PRAGMA wal_checkpoint(PASSIVE)")
                    db.close()
                with open(path(d, "cache.db"), "r+b") as f:
                    size = f.seek(0, 2)
                    for _ in range(40 if kind == "bytes" else 4):
                        f.seek(rng.randrange(4096, size - 4096))
                        f.write(rng.randbytes(1 if kind == "bytes" else 4096))
                if not running:
                    d.start()
                again(d, c, jobs, f"changed {kind} of results, {'running' if running else 'stopped'}")
                again(d, c, jobs, f"after changed {kind} of results, {'running' if running else 'stopped'}")
        c.status(d.get("/readyz"), 200, "ready")
        if d.shares():
            return
        with sqlite3.connect(path(d, "cache.db")) as db:        # what tells which run it was, and the text
            db.execute("UPDATE results SET epoch = 1 << 60, result = replace(result, 'unique', 'uniqve')")
        db.close()
        again(d, c, jobs, "results and their epochs changed")
        again(d, c, jobs, "after results and their epochs changed")


def damaged(build, c):
    """The queue is a promise: damaged or newer, it is refused and left alone; a changed
    request is not run as if it were the one that was accepted."""
    with Daemon(build, "--workers", "1") as d:
        blocker = d.ask("POST", "/v1/jobs", slow()).json()["id"]
        waiting = {k: d.ask("POST", "/v1/jobs", trivial(k)).json()["id"] for k in range(70001, 70009)}
        d.process.kill()
        d.ended()
        shutil.copytree(os.path.join(d.state, "sgad"), os.path.join(d.state, "kept"))
        with sqlite3.connect(path(d, "queue.db")) as db:
            db.execute("PRAGMA user_version=999")
        db.close()
        refused(d, c, "a newer queue", "newer sgad")
        with sqlite3.connect(path(d, "queue.db")) as db:
            db.execute("PRAGMA user_version=7")
            bad = waiting[70003]
            db.execute("UPDATE jobs SET request=replace(request, '70003', '90009') WHERE id=?", (bad,))
        db.execute("PRAGMA wal_checkpoint(TRUNCATE)")
        db.close()
        d.start()
        d.ask("DELETE", "/v1/jobs/" + blocker)
        for k, id_ in waiting.items():
            job = d.wait(id_)
            if id_ == bad:
                c(job["status"] == "failed" and job["error"]["code"] == "store_failed", "a changed request is not run", job)
            else:
                c(job["status"] == "done" and job["result"]["vector_field"]["components"]["x"] == f"{k}*x", "the others run", job)
        d.stop()
        with open(path(d, "queue.db"), "r+b") as f:
            for place in range(4096, f.seek(0, 2), 4096):
                f.seek(place)
                f.write(random.Random(place).randbytes(4096))
        refused(d, c, "a damaged queue", "move the whole folder away")
        shutil.rmtree(os.path.join(d.state, "sgad"))
        shutil.copytree(os.path.join(d.state, "kept"), os.path.join(d.state, "sgad"))
        d.start()
        d.ask("DELETE", "/v1/jobs/" + blocker)
        for k, id_ in waiting.items():
            c(d.wait(id_)["status"] == "done", "a restored queue runs")


def lost(build, c):
    """A queue that is missing or empty in a folder that was in use, as where a volume is not mounted."""
    with Daemon(build, "--workers", "1") as d:
        folder = os.path.join(d.state, "sgad")
        some_jobs(d, 2)
        d.stop()
        with open(path(d, "instance"), encoding="ascii") as f:
            name = f.read()
        c(len(name) == 33 and set(name.strip()) <= set("0123456789abcdef"), "the state has a name of its own", name)
        for k, word in ((0, "missing"), (1, "empty")):
            os.rename(path(d, "queue.db"), path(d, "kept"))
            try:
                if k:
                    with open(path(d, "queue.db"), "wb"):
                        pass
                run = subprocess.run([os.path.join(build, "sgad"), "--listen", "127.0.0.1:0", "--state", folder],
                                     capture_output=True, timeout=30, check=False)
                c(run.returncode == 1 and word in run.stderr.decode(), f"a queue that is {word} is refused", run.stderr)
                c(os.path.exists(path(d, "queue.db")) == bool(k), "and no other is made")
            finally:
                os.replace(path(d, "kept"), path(d, "queue.db"))
        os.remove(path(d, "instance"))      # as before it was written
        d.start()
        c(os.path.exists(path(d, "instance")), "a folder without a name gets one")


def gone(build, c):
    """The folder goes away under the daemon: no 202 into nothing, and all is well once it is back."""
    with Daemon(build, "--workers", "1") as d:
        folder = os.path.join(d.state, "sgad")
        done = some_jobs(d, 2)
        os.rename(folder, folder + ".away")
        try:
            c.problem(d.ask("POST", "/v1/jobs", trivial()), 503, "store_failed", "a job without the folder")
            c.status(d.get("/readyz"), 503, "not ready without the folder")
            c.status(d.get("/healthz"), 200, "healthy without the folder")
        finally:
            os.rename(folder + ".away", folder)
        c(until(d, 200), "ready with the folder again")
        a = d.ask("POST", "/v1/jobs", trivial())
        c.status(a, 202, "a job with the folder again")
        d.process.kill()
        d.ended()
        d.start()
        c(d.wait(a.json()["id"])["status"] == "done", "it is there after a crash")
        again(d, c, done, "the folder went away")


def listed(d):
    return [j["id"] for j in d.get("/v1/jobs?limit=500").json()["jobs"]]


def kept(build, c):
    """Ended jobs go by age and number; what waits or runs stays."""
    with Daemon(build, "--workers", "1", "--keep-days", "3", "--keep-jobs", "4") as d:
        ids = list(some_jobs(d, 8))
        going = d.ask("POST", "/v1/jobs", slow()).json()["id"]
        end = time.monotonic() + 60
        while len(listed(d)) > 5 and time.monotonic() < end:
            time.sleep(0.1)
        c(set(listed(d)) == {going, *ids[-4:]}, "the latest are kept, and what has not ended", (listed(d), ids))
        with sqlite3.connect(path(d, "queue.db")) as db:        # between two writes of the daemon's
            db.execute("UPDATE jobs SET finished = finished - 4 * 86400000, created = 1, started = 1 WHERE id IN (?, ?)", ids[-4:-2])
        db.close()
        while len(listed(d)) > 3 and time.monotonic() < end:
            time.sleep(0.1)
        c(set(listed(d)) == {going, *ids[-2:]}, "old ones go", listed(d))
        run = [os.path.join(build, "sgad"), "prune", "--state", os.path.join(d.state, "sgad")]
        for wrong in ([], ["--older", "3"], ["--keep", "x"], ["--other", "1"]):
            c(subprocess.run(run + wrong, capture_output=True, check=False).returncode == 2, f"refused: prune {wrong}")
        a = subprocess.run(run + ["--keep", "1"], capture_output=True, check=False)
        c(a.returncode == 1 and b"in use" in a.stderr, "not beside a daemon", a.stderr)
        d.stop()
        a = subprocess.run(run + ["--keep", "1", "--older", "30d"], capture_output=True, check=False)
        c(a.returncode == 0, "prune", a.stderr)
        d.start()
        c(set(listed(d)) == {going, ids[-1]}, "one is left, and what has not ended", listed(d))


def results_in(d):
    with contextlib.closing(sqlite3.connect(f"file:{path(d, 'cache.db')}?mode=ro", uri=True)) as db:
        return {i for (i,) in db.execute("SELECT id FROM results")}


def kept_apart(build, c):
    """Results go by age and number, and their jobs stay; jobs go by bytes, too."""
    with Daemon(build, "--workers", "1", "--cache-results", "3", "--cache-days", "2", "--cache-memory", "0") as d:
        ids, end = list(some_jobs(d, 8)), time.monotonic() + 60
        while len(results_in(d)) > 3 and time.monotonic() < end:
            time.sleep(0.1)
        c(results_in(d) == set(ids[-3:]), "the latest results are kept", (results_in(d), ids))
        with contextlib.closing(sqlite3.connect(path(d, "cache.db"), isolation_level=None)) as db:
            db.execute("UPDATE results SET made = made - 3 * 86400000 WHERE id = ?", (ids[-3],))
        while len(results_in(d)) > 2 and time.monotonic() < end:
            time.sleep(0.1)
        c(results_in(d) == set(ids[-2:]), "old ones go", results_in(d))
        c(set(listed(d)) == set(ids), "their jobs stay", listed(d))
        c.status(d.get("/v1/jobs/" + ids[0]), (200, 202), "and are computed again when they are asked for")
        d.wait(ids[0])
        d.stop()
        prune = [os.path.join(build, "sgad"), "prune", "--state", os.path.join(d.state, "sgad")]
        a = subprocess.run([*prune, "--results-keep", "1"], capture_output=True, text=True, check=False)
        c(a.returncode == 0 and "results removed" in a.stdout and results_in(d) == {ids[0]}, "prune of results", a)
        a = subprocess.run([*prune, "--results-older", "0d"], capture_output=True, text=True, check=False)
        c(a.returncode == 0 and not results_in(d), "by age", a)
        d.start()
        c(set(listed(d)) == set(ids), "no job went with them", listed(d))
    with Daemon(build, "--workers", "1", "--keep-bytes", str(1 << 20)) as d:
        going, ids, end = d.ask("POST", "/v1/jobs", slow()).json()["id"], [], time.monotonic() + 60
        for _ in range(16):                                     # of a tenth of a megabyte each; they wait, and are cancelled
            big = trivial()
            big["system"]["alpha"] = [big["system"]["alpha"][0] + "".join(f" + {k}*x" for k in range(9000))]
            ids.append(d.ask("POST", "/v1/jobs", big).json()["id"])
            c.status(d.ask("DELETE", "/v1/jobs/" + ids[-1]), 200, "cancelling")
        while len(listed(d)) > 12 and time.monotonic() < end:
            time.sleep(0.1)
        left = set(listed(d))
        c(5 < len(left) <= 12 and left == {going, *ids[1 - len(left):]}, "by bytes the oldest go, and what has not ended stays", (len(left), left, ids))
        d.stop()
        a = subprocess.run([os.path.join(build, "sgad"), "prune", "--state", os.path.join(d.state, "sgad"), "--bytes", "300000"], capture_output=True, text=True, check=False)
        d.start()
        c(a.returncode == 0 and 2 <= len(listed(d)) <= 5 and {going, ids[-1]} <= set(listed(d)), "prune by bytes", (a, listed(d)))


def long_list(build, c):
    """A short list among very many jobs costs what it shows (SGA_TEST_ROWS of them)."""
    rows = int(os.environ.get("SGA_TEST_ROWS", "200000"))
    with Daemon(build, "--workers", "1") as d:
        some_jobs(d, 1)
        d.stop()
        with sqlite3.connect(path(d, "queue.db")) as db:
            db.execute("WITH RECURSIVE n(k) AS (SELECT 1 UNION ALL SELECT k+1 FROM n WHERE k < ?) INSERT INTO jobs(id, status, attempts, created,"
                       " started, finished, request, sum, owner) SELECT printf('%032x', k), 2, 0, 1, 1, 1, x'7b7d', x'00', 'many' FROM n",
                       (rows,))
            db.execute("INSERT INTO interests(id, owner, status) SELECT id, owner, status FROM jobs WHERE owner = 'many'")
            plans = [str(db.execute("EXPLAIN QUERY PLAN " + q).fetchall()) for q in (
                "SELECT * FROM interests i JOIN jobs j ON j.id = i.id WHERE i.seq < 9 AND i.owner = 'x' ORDER BY i.seq DESC LIMIT 5",
                "SELECT * FROM interests i JOIN jobs j ON j.id = i.id WHERE i.seq < 9 AND i.owner = 'x' AND i.status = 3 ORDER BY i.seq DESC LIMIT 5",
                "SELECT * FROM jobs WHERE seq < 9 AND status = 3 ORDER BY seq DESC LIMIT 5")]
        db.close()
        c(not any("SCAN" in p or "TEMP B-TREE" in p for p in plans), "no list scans or sorts", plans)
        d.start()
        before = d.cpu()
        for query in ("", "?status=failed", "?status=queued,failed", "?status=done&limit=500"):
            for _ in range(10):
                c.status(d.get("/v1/jobs" + query), 200, "a list")
        c(d.cpu() - before < 1, f"lists among {rows} jobs", d.cpu() - before)


def older(build, c):
    """Queues of the schemas before are brought up to date, and what waited in them runs."""
    for version, change in ((1, "ALTER TABLE jobs DROP COLUMN sum"), (2, "UPDATE jobs SET sum=zeroblob(32)")):
        with Daemon(build, "--workers", "1") as d:
            jobs = some_jobs(d, 2)
            d.ask("POST", "/v1/jobs", slow())
            waits = d.ask("POST", "/v1/jobs", trivial()).json()["id"]
            d.process.kill()
            d.ended()
            for name in ("queue.db", "cache.db"):
                with sqlite3.connect(path(d, name)) as db:
                    if name == "queue.db":
                        db.execute(change)
                        db.execute("ALTER TABLE jobs DROP COLUMN owner")
                        db.executescript("DROP TABLE filler; DROP INDEX jobs_by_end; DROP TRIGGER job_made; DROP TRIGGER job_moved; DROP TRIGGER job_gone;"
                                         "DROP TABLE interests; ALTER TABLE jobs DROP COLUMN seconds; DROP TABLE lives; DROP TABLE turns")
                        for column in ("epoch", "lease", "cancel", "stage", "fraction"):
                            db.execute(f"ALTER TABLE jobs DROP COLUMN {column}")
                    db.execute(f"PRAGMA user_version={version}")
                db.close()
            d.start()
            for job in d.get("/v1/jobs?status=queued,running").json()["jobs"]:
                if job["id"] != waits:
                    d.ask("DELETE", "/v1/jobs/" + job["id"])
            c(d.wait(waits)["status"] == "done", f"a queue of version {version}: what waited runs")
            again(d, c, jobs, f"a queue of version {version}")
            d.stop()
            with sqlite3.connect(path(d, "queue.db")) as db:
                c(db.execute("PRAGMA user_version").fetchone()[0] == 7, f"a queue of version {version}: its version after")
            db.close()
            d.start()


def until(d, should, seconds=30):
    end = time.monotonic() + seconds
    while time.monotonic() < end:
        a = d.get("/readyz")
        if a.status == should:
            return True
        time.sleep(0.1)
    return False


def no_room(build, c):
    """Nothing can be written for a while (a file size limit of 0 stands for a full disk): new
    jobs are refused, what runs is finished, and its end reaches the disk afterwards."""
    with Daemon(build, "--workers", "2") as d:
        done = some_jobs(d, 2)
        going = d.ask("POST", "/v1/jobs", slow(2)).json()["id"]
        while d.get("/v1/jobs/" + going).json()["status"] != "running":
            time.sleep(0.02)
        resource.prlimit(d.process.pid, resource.RLIMIT_FSIZE, (0, resource.RLIM_INFINITY))
        c.problem(d.ask("POST", "/v1/jobs", trivial()), 503, "store_failed", "a job without room for it")
        c(until(d, 503), "not ready without room")
        for _ in range(20):           # what only reads brings no readiness back
            c.status(d.get("/v1/jobs"), 200, "a list without room")
            c.status(d.get("/readyz"), 503, "still not ready without room")
        c.status(d.get("/healthz"), 200, "healthy without room")
        a = d.ask("POST", "/v1/solve", trivial())
        c(a.status in (200, 503), "solving without room", (a.status, a.body[:200]))
        again(d, c, done, "without room")
        end = time.monotonic() + 60
        while (job := d.get("/v1/jobs/" + going).json())["progress"]["stage"] != "storing" and time.monotonic() < end:
            time.sleep(0.02)
        c(job["status"] == "running" and job["progress"]["stage"] == "storing", "the end of a job is not told before it is on disk", job)
        resource.prlimit(d.process.pid, resource.RLIMIT_FSIZE, (resource.RLIM_INFINITY, resource.RLIM_INFINITY))
        c(until(d, 200), "ready again")
        a = d.ask("POST", "/v1/jobs", trivial())
        c.status(a, 202, "a job with room again")
        d.wait(a.json()["id"])
        ended = d.wait(going)         # ends that were held back are tried each second
        c(ended["status"] in ("done", "failed"), "a job that ran without room has ended", ended)
        d.process.kill()
        d.ended()
        d.start()
        job = d.get("/v1/jobs/" + going).json()
        c((job["status"], job["finished"]) == (ended["status"], ended["finished"]), "the end that was held back is on disk", job)


def small_disk(build, c):
    """A real full disk and a read-only one, where this may mount."""
    folder = tempfile.mkdtemp(prefix="sgad-disk-")
    mount = subprocess.run(["mount", "-t", "tmpfs", "-o", "size=1m", "tmpfs", folder], capture_output=True, check=False)
    if mount.returncode != 0:
        os.rmdir(folder)
        return
    try:
        with Daemon(build) as d:
            d.stop()
            shutil.rmtree(os.path.join(d.state, "sgad"))
            os.symlink(folder, os.path.join(d.state, "sgad"))
            try:
                d.start()
                done = some_jobs(d, 2)
                accepted, refusals = [], 0
                for k in range(80001, 80041):
                    big = trivial(k)
                    big["system"]["name"] = "n" * 100
                    big["system"]["alpha"] = [f"{k}*x" + "".join(f" + {i}*x" for i in range(5000))]
                    a = d.ask("POST", "/v1/jobs", big)
                    if a.status in (200, 202):
                        accepted.append(a.json()["id"])
                    else:
                        refusals += 1
                        c.problem(a, 503, "store_failed", "a job on a full disk")
                c(accepted and refusals, "some fit, some do not", (len(accepted), refusals))
                again(d, c, done, "full disk")
                c(until(d, 503), "not ready on a full disk")
                for k in range(20):           # small writes that still fit bring no readiness back
                    d.ask("POST", "/v1/jobs", trivial(90000 + k))
                    c.status(d.get("/readyz"), 503, "still not ready on a full disk")
                d.process.kill()
                d.ended()
                d.start()
                again(d, c, done, "started on a full disk")
                subprocess.run(["mount", "-o", "remount,size=64m", folder], check=True)
                for id_ in accepted:
                    c(d.wait(id_)["status"] == "done", "what was accepted is there after a full disk")
                c(until(d, 200), "ready with a larger disk")
                d.stop()
                subprocess.run(["mount", "-o", "remount,ro", folder], check=True)
                run = subprocess.run([os.path.join(build, "sgad"), "--listen", "127.0.0.1:0", "--state", folder],
                                     capture_output=True, timeout=30, check=False)
                c(run.returncode == 1 and b"ead-only" in run.stderr, "a read-only disk is refused with the reason", run.stderr)
                subprocess.run(["mount", "-o", "remount,rw", folder], check=True)
                d.start()
            finally:          # what was accepted is looked for after the test too
                subprocess.run(["mount", "-o", "remount,rw,size=64m", folder], check=False)
    finally:
        subprocess.run(["umount", folder], check=False)
        os.rmdir(folder)


def results_give_way(build, c):
    """A disk smaller than the share that results may have of it: older results go, every job ends, the service stays ready."""
    folder = tempfile.mkdtemp(prefix="sgad-disk-")
    mount = subprocess.run(["mount", "-t", "tmpfs", "-o", "size=64m", "tmpfs", folder], capture_output=True, check=False)
    if mount.returncode != 0:
        os.rmdir(folder)
        return
    try:
        with Daemon(build, "--cache-memory", "0") as d:
            d.stop()
            shutil.rmtree(os.path.join(d.state, "sgad"))
            os.symlink(folder, os.path.join(d.state, "sgad"))
            d.start()
            ids = []
            for _ in range(80):                                # of a megabyte each
                a = d.ask("POST", "/v1/jobs", moving(samples=12000))
                c.status(a, (200, 202), "a job on a disk that results fill")
                ids.append(a.json()["id"])
                d.wait(ids[-1])
            c(d.get("/v1/jobs/" + ids[-1]).json().get("result"), "the latest result is there")
            c.status(d.get("/readyz"), 200, "ready")
            c(d.get("/metrics").body.decode().split("\nsgad_results_evicted_total ")[1].split("\n")[0] != "0", "older results went")
            free = os.statvfs(folder)
            c(free.f_bavail * 25 > free.f_blocks, "a part of the disk stays free", (free.f_bavail, free.f_blocks))
            # somebody else fills the disk to the last byte: a new result takes the place of older ones
            with open(os.path.join(folder, "other"), "wb", buffering=0) as f:
                try:
                    while f.write(b"x" * 4096):
                        pass
                except OSError:
                    pass
            a = d.ask("POST", "/v1/jobs", trivial())
            if a.status != 503:
                c(d.wait(a.json()["id"])["status"] == "done", "a job on a disk that others fill")
            os.remove(os.path.join(folder, "other"))
            c(until(d, 200), "ready once there is room")
            c(d.stop() == 0, "it ends with 0", d.errors())
    finally:
        subprocess.run(["umount", folder], check=False)
        os.rmdir(folder)


ALL = [results_give_way, dropped, flipped, damaged, lost, gone, kept, kept_apart, long_list, older, no_room, small_disk]
