"""Long results: streamed from the job to the disk and to whoever asks, with a few megabytes of them in the daemon; in pieces in cache.db."""
import csv
import gzip
import io
import json
import os
import sqlite3
import subprocess

import numpy

from common import moving
from daemon import Daemon
from store import essence, path

SAMPLES = 300000


def peak(d):
    """Bytes that the daemon had in memory at the most."""
    with open(f"/proc/{d.process.pid}/status", encoding="ascii") as f:
        return 1024 * int(next(line for line in f if line.startswith("VmHWM:")).split()[1])


def sanitized(build):
    return "-" in os.path.basename(os.path.normpath(build))


def same_samples(d, c, where, job):
    """As every format has them."""
    trajectory = job["result"]["trajectory"]
    rows, columns = trajectory["rows"], trajectory["columns"]
    c(len(rows) == SAMPLES, "long: all samples are there", len(rows))
    a = d.get(where + "/trajectory")
    c(a.status == 200 and a.json() == trajectory, "long: the samples alone", a.status)
    lines = list(csv.reader(io.StringIO(d.get(where + "/trajectory?format=csv").body.decode())))
    c(lines[0] == columns and [[float(v) for v in line] for line in lines[1:]] == rows, "long: as CSV", lines[:2])
    lines = d.get(where + "/trajectory?format=ndjson").body.decode().splitlines()
    c([list(json.loads(line).values()) for line in lines] == rows, "long: as NDJSON", lines[:2])
    table = numpy.load(io.BytesIO(d.get(where + "/trajectory?format=npy").body))
    c(list(table.dtype.names) == columns and table.tolist() == [tuple(row) for row in rows], "long: for NumPy", table.shape)


def long_streams(build, c):
    """What a job makes goes to the disk, and from there to clients, without standing in the daemon's memory."""
    with Daemon(build, "--workers", "1") as d:
        d.ask("POST", "/v1/solve", moving())
        begin = peak(d)
        a = d.ask("POST", "/v1/solve", moving(samples=SAMPLES), {"Prefer": "wait=120"}, seconds=150)
        if not c(a.status == 200, "long: solved", a.body[:200]):
            return
        job = a.json()
        where = "/v1/jobs/" + job["id"]
        length = len(a.body)
        c(length > 20 << 20, "long: it is", length)
        again = d.get(where)
        c(again.body == a.body, "long: the same again", len(again.body))
        c(gzip.decompress(d.get(where, Accept_Encoding="gzip").body) == a.body, "long: packed")
        same_samples(d, c, where, job)
        c(peak(d) - begin < length / 2 or sanitized(build), "long: the daemon stays small", (begin, peak(d), length))
        if d.shares():
            return
        d.stop()
        d.start()
        c(d.get(where).body == a.body, "long: the same after a restart")
        c(peak(d) - begin < length / 2 or sanitized(build), "long: small when it is read, too", (begin, peak(d), length))
        direct = subprocess.run([os.path.join(build, "sga"), "solve", "--json", "-"], input=json.dumps(moving(k=job["result"]["trajectory"]["rows"][0][2], samples=SAMPLES)).encode(),
                                capture_output=True, timeout=150, check=False)
        c(essence({"result": json.loads(direct.stdout)}) == essence(job), "long: as without a daemon", direct.stderr)


def edit(d, sql):
    with sqlite3.connect(path(d, "cache.db")) as db:
        count = db.execute(sql).rowcount
    db.close()
    return count


def sound(d):
    run = subprocess.run([os.path.join(d.build, "sgad"), "check", "--state", os.path.join(d.state, "sgad")], capture_output=True, timeout=60, check=False)
    return run.returncode == 0


def long_pieces(build, c):
    """Pieces that are damaged or gone are noticed, and go with their result."""
    with Daemon(build, "--workers", "1", "--cache-memory", "0") as d:
        if d.shares():
            return
        job = d.ask("POST", "/v1/solve", moving(samples=30000), {"Prefer": "wait=120"}, seconds=150).json()
        where, was = "/v1/jobs/" + job["id"], essence(job)
        pieces = edit(d, "UPDATE pieces SET n = n WHERE 1")
        c(pieces > 4, "long: in pieces", pieces)
        c(sound(d), "long: sgad check finds nothing")
        for label, sql in (("changed", "UPDATE pieces SET piece = cast(replace(piece, '1', '2') AS BLOB) WHERE n = 2"), ("gone", "DELETE FROM pieces WHERE n = 3"),
                           ("swapped", "UPDATE pieces SET n = CASE n WHEN 1 THEN 1000 ELSE n END"), ("longer", "UPDATE pieces SET piece = cast(piece || ' ' AS BLOB) WHERE n = 1"),
                           ("all gone", "DELETE FROM pieces")):
            c(edit(d, sql) > 0, f"long: a piece {label}")
            c(not sound(d), f"long: a piece {label}: sgad check tells")
            c(essence(d.wait(job["id"])) == was, f"long: a piece {label}: the same answer")
            c(sound(d), f"long: a piece {label}: sound again")
            c(edit(d, "UPDATE pieces SET n = n WHERE 1") == pieces, f"long: a piece {label}: as many pieces as before")
        short = d.ask("POST", "/v1/solve", moving()).json()
        edit(d, f"DELETE FROM results WHERE id = '{job['id']}'")
        c(edit(d, "UPDATE pieces SET n = n WHERE 1") == 0, "long: pieces go with their result")
        c(essence(d.get("/v1/jobs/" + short["id"]).json()) == essence(short), "long: others stay")
        c(edit(d, f"INSERT INTO pieces VALUES('{job['id']}', 1, x'2020'), ('{job['id']}', 900, x'2020')") == 2, "long: pieces of no result")
        c(essence(d.wait(job["id"])) == was and d.get(where).status == 200, "long: and are made again")
        c(edit(d, "UPDATE pieces SET n = n WHERE 1") == pieces and sound(d), "long: with no others' pieces")
        d.stop()
        run = subprocess.run([os.path.join(build, "sgad"), "prune", "--state", os.path.join(d.state, "sgad"), "--results-keep", "0"], capture_output=True, timeout=60, check=False)
        c(run.returncode == 0 and b"2 results removed" in run.stdout and edit(d, "UPDATE pieces SET n = n WHERE 1") == 0, "long: sgad prune", run)
        d.start()


def long_too_long(build, c):
    """What is over the limit is refused while it is written, and nothing of it stays."""
    with Daemon(build, "--workers", "1", "--result-limit", str(2 << 20)) as d:
        job = d.ask("POST", "/v1/solve", moving(samples=SAMPLES), {"Prefer": "wait=120"}, seconds=150).json()
        c(job.get("error", {}).get("code") == "result_limit" and "2.0 MB" in job["error"]["detail"], "long: over the limit", job.get("error"))
        job = d.ask("POST", "/v1/solve", moving(samples=12000), {"Prefer": "wait=120"}, seconds=150).json()
        c(job["status"] == "done" and len(job["result"]["trajectory"]["rows"]) == 12000, "long: the next one is whole", job.get("error"))


ALL = [long_streams, long_pieces, long_too_long]
