"""Several daemons that share one database of PostgreSQL: any of them answers for any job."""
import os
import shutil
import signal
import socket
import subprocess
import tempfile
import threading
import time

from cluster import Cluster
from common import moving, slow, trivial
from daemon import Daemon
from long_results import SAMPLES, peak, sanitized
from store import essence


ENDS = ("CREATE TABLE ends(id text, epoch bigint); CREATE FUNCTION note_end() RETURNS trigger LANGUAGE plpgsql AS"
        " $$ BEGIN INSERT INTO public.ends VALUES(new.id, new.epoch); RETURN NULL; END $$;"
        "CREATE TRIGGER ends AFTER UPDATE OF status ON sgad.jobs FOR EACH ROW WHEN (new.status >= 2 AND old.status < 2) EXECUTE FUNCTION note_end()")


def prepared(build, server, name):
    """The address of a fresh database with the tables."""
    address = server.database(name)
    subprocess.run([os.path.join(build, "sgad"), "migrate", "--store", address], check=True, capture_output=True, timeout=60)
    return address


def of_schema(server, name, version):
    """The address of a database with the tables of a version before."""
    address, text = server.database(name), ""
    for n in range(1, version + 1):
        with open(os.path.join(os.path.dirname(__file__), f"../../server/postgres/schema-{n}.sql"), encoding="utf-8") as f:
            text += f.read()
    server.sql(f"CREATE SCHEMA sgad; SET search_path = sgad; CREATE TABLE schema(version int NOT NULL); {text}; INSERT INTO schema VALUES({version})", name)
    return address


def until(what, seconds=40):
    end = time.monotonic() + seconds
    while time.monotonic() < end:
        if what():
            return True
        time.sleep(0.05)
    return False


def status(d, id_):
    a = d.get("/v1/jobs/" + id_)
    return a.json().get("status") if a.status == 200 else a.status


def said(d):
    with open(os.path.join(d.state, "test.log"), encoding="utf-8") as f:
        return f.read()


def flags(address, *more):
    return ("--store", address, "--workers", "2", "--lease", "3", *more)


def shared_answers(build, c):
    """Submit to one, read, wait, watch and cancel at the other."""
    with Cluster() as server:
        address = server.database("two")
        run = subprocess.run([os.path.join(build, "sgad"), "--listen", "127.0.0.1:0", "--store", address], capture_output=True, text=True, timeout=30, check=False)
        c(run.returncode == 1 and "sgad migrate" in run.stderr, "no daemon without the tables", run)
        for words in ("was 0 and is 3", "nothing to do"):
            run = subprocess.run([os.path.join(build, "sgad"), "migrate", "--store", address], capture_output=True, text=True, timeout=30, check=False)
            c(run.returncode == 0 and words in run.stdout, "migrate", run)
        with Daemon(build, *flags(address)) as a, Daemon(build, *flags(address)) as b:
            c(until(lambda: "no_synchronous_standby" in said(a)), "the start warns where there is no standby", a.errors())
            request = trivial()
            posted = a.ask("POST", "/v1/jobs", request)
            c(posted.status == 202 and posted.headers["location"].startswith("/v1/jobs/"), "a job is accepted", posted.body)
            id_ = posted.json()["id"]
            other = b.ask("GET", "/v1/jobs/" + id_, headers={"Prefer": "wait=30"})
            c(other.status == 200 and other.json()["status"] == "done", "waited for at the other", other.body[:300])
            one = a.get("/v1/jobs/" + id_)
            c(one.json() == other.json() and one.headers["etag"] == other.headers["etag"], "both say the same", (one.body[:300], other.body[:300]))
            hit = b.ask("POST", "/v1/jobs", request)
            c(hit.status == 200 and hit.json()["cached"] is True and hit.json()["id"] == id_, "the other's result is a hit here", hit.body[:200])
            solved = b.ask("POST", "/v1/solve", trivial())
            c(solved.status == 200 and solved.json()["status"] == "done", "solve", solved.body[:200])
            # four long jobs take all workers of both
            long = [a.ask("POST", "/v1/jobs", slow(60)).json()["id"] for _ in range(4)]
            c(until(lambda: all(status(b, i) == "running" for i in long)), "four workers run four jobs", [status(b, i) for i in long])

            def ran():     # a daemon's own count, which follows what the database says
                return [sum(d.get("/metrics").body.decode().count(f"\nsgad_jobs{{status=\"running\"}} {n}\n") * n for n in (1, 2)) for d in (a, b)]
            c(until(lambda: ran() == [2, 2]), "two on each", ran())
            places = {(d.port, i): set() for d in (a, b) for i in long}

            def moving():
                for d in (a, b):
                    for i in long:
                        places[d.port, i] |= {d.get("/v1/jobs/" + i).json()["progress"].get("t")} - {None}
                return all(len(p) > 1 for p in places.values())
            c(until(moving) and all(0 <= t <= 8000 for p in places.values() for t in p), "each says how far each motion is, whoever runs it", places)
            waits = b.ask("POST", "/v1/jobs", trivial()).json()["id"]
            listed = a.get("/v1/jobs?status=queued").json()["jobs"]
            c([j["id"] for j in listed] == [waits], "the list is everybody's", listed)
            streams = {}

            def watch(d, i):
                streams[d.port, i] = d.raw(f"GET /v1/jobs/{i}/events HTTP/1.1\r\nHost: 127.0.0.1\r\n\r\n".encode(), 20)[0]

            threads = [threading.Thread(target=watch, args=(d, i)) for d in (a, b) for i in long[:2]]
            [t.start() for t in threads]
            time.sleep(0.5)
            for d, i in ((b, long[0]), (a, long[1]), (b, long[2]), (a, long[3])):
                got = d.ask("DELETE", "/v1/jobs/" + i)
                c(got.status in (200, 202), "cancelled from anywhere", got.body[:200])
            c(until(lambda: all(status(d, i) == "cancelled" for d in (a, b) for i in long)), "all are cancelled", [status(b, i) for i in long])
            [t.join() for t in threads]
            c(len(streams) == 4 and all(b"event: end" in s and b'"cancelled"' in s for s in streams.values()), "and all streams were told", streams)
            c(b.wait(waits)["status"] == "done", "what waited runs")
            got = a.ask("DELETE", "/v1/jobs/" + long[0])
            c(got.status == 204, "a job that has ended is removed", got.body)
            c(until(lambda: status(b, long[0]) == 404), "for all", status(b, long[0]))
            # the same request at both at once is one job
            same, answers = trivial(), []
            threads = [threading.Thread(target=lambda d=d: answers.append(d.ask("POST", "/v1/solve", same))) for d in (a, b) * 4]
            [t.start() for t in threads]
            [t.join() for t in threads]
            c(all(x.status == 200 and x.json()["status"] == "done" for x in answers) and len({x.json()["id"] for x in answers}) == 1, "asked eight times",
              [x.body[:200] for x in answers])
            c(server.sql("SELECT count(*) FROM sgad.jobs WHERE attempts > 0", "two") == [["0"]], "no run was lost")
            c(a.stop() == 0 and b.stop() == 0, "both end with 0", a.errors()[-500:] + b.errors()[-500:])


def shared_killed(build, c):
    """A daemon that is gone, or stands still longer than its lease: the other ends its jobs, each once."""
    with Cluster() as server:
        address = prepared(build, server, "killed")
        server.sql(ENDS, "killed")
        with Daemon(build, *flags(address)) as a, Daemon(build, *flags(address)) as b:
            b.process.send_signal(signal.SIGSTOP)
            mine = [a.ask("POST", "/v1/jobs", slow(4)).json()["id"] for _ in range(2)]
            c(until(lambda: all(status(a, i) == "running" for i in mine)), "two jobs run", [status(a, i) for i in mine])
            b.process.send_signal(signal.SIGCONT)
            a.process.kill()
            a.ended()
            more = [b.ask("POST", "/v1/jobs", trivial()).json()["id"] for _ in range(10)]
            c(until(lambda: all(status(b, i) in ("done", "failed") for i in mine + more)), "the other ends them", [status(b, i) for i in mine + more])
            c(all(status(b, i) == "done" for i in more), "each with its answer")
            c([int(r[0]) for r in server.sql(f"SELECT attempts FROM sgad.jobs WHERE id IN ('{mine[0]}', '{mine[1]}')", "killed")] == [1, 1], "with one attempt more")
            c(until(lambda: "jobs_reaped" in said(b)), "that is logged", b.errors())
            a.start()
            waits = [a.ask("POST", "/v1/jobs", slow(5)).json()["id"] for _ in range(4)]
            c(until(lambda: all(status(b, i) == "running" for i in waits)), "four run", [status(b, i) for i in waits])
            a.process.send_signal(signal.SIGSTOP)
            time.sleep(5)
            a.process.send_signal(signal.SIGCONT)
            c(until(lambda: all(status(d, i) == "failed" for d in (a, b) for i in waits), 60), "one that stood still", [status(b, i) for i in waits])
            c(server.sql("SELECT id FROM ends GROUP BY id HAVING count(*) > 1", "killed") == [], "nothing ended twice")
            c(int(server.sql("SELECT count(*) FROM ends", "killed")[0][0]) == 16, "and everything once")
            c(a.stop() == 0 and b.stop() == 0, "both end with 0", a.errors()[-500:] + b.errors()[-500:])


def shared_away(build, c):
    """The database stops: what is in memory is answered, posts get 503, what runs is handed in later."""
    with Cluster() as server:
        address = prepared(build, server, "away")
        with Daemon(build, *flags(address)) as a:
            known = trivial()
            id_ = a.ask("POST", "/v1/solve", known).json()["id"]
            runs = a.ask("POST", "/v1/jobs", slow(3)).json()["id"]
            c(until(lambda: status(a, runs) == "running"), "a job runs")
            for how in (signal.SIGINT, signal.SIGQUIT):
                server.stop(how)
                hit = a.ask("POST", "/v1/jobs", known)
                c(hit.status == 200 and hit.json()["cached"] is True, "an answer in memory is given", hit.body[:200])
                c.problem(a.ask("POST", "/v1/jobs", trivial()), 503, "store_failed", "a new job while the database is away")
                c(until(lambda: a.get("/readyz").status == 503), "not ready")
                c(a.get("/healthz").status == 200, "but alive")
                time.sleep(2)
                server.start()
                c(until(lambda: a.get("/readyz").status == 200), "ready once it is back", a.get("/readyz").body)
                c(a.ask("POST", "/v1/solve", trivial()).json()["status"] == "done", "and new jobs run")
            c(until(lambda: status(a, runs) == "failed"), "what ran is handed in", status(a, runs))
            row = server.sql(f"SELECT attempts, status FROM sgad.jobs WHERE id = '{runs}'", "away")
            c(row[0][1] == "3", "in the database too", row)
            server.sql("SELECT pg_terminate_backend(pid) FROM pg_stat_activity WHERE datname = 'away' AND pid <> pg_backend_pid()", "away")
            c(a.ask("POST", "/v1/solve", trivial()).json()["status"] == "done", "connections that were cut are made anew")
            c(id_ == a.ask("POST", "/v1/jobs", known).json()["id"] and a.stop() == 0, "it ends with 0", a.errors()[-500:])


def shared_tenants(build, c):
    """Tokens and quotas are those of all daemons."""
    with Cluster() as server:
        address = prepared(build, server, "tenants")

        def token(*words):
            return subprocess.run([os.path.join(build, "sgad"), "token", *words, "--store", address], capture_output=True, text=True, timeout=30, check=True).stdout.strip()

        ann, bob = token("create", "--name", "ann", "--jobs", "3"), token("create", "--name", "bob")
        with Daemon(build, *flags(address, "--access", "tokens")) as a, Daemon(build, *flags(address, "--access", "tokens")) as b:
            hers, his = {"Authorization": "Bearer " + ann}, {"Authorization": "Bearer " + bob}
            c(a.ask("GET", "/v1/jobs").status == 401, "nobody without a token")
            jobs = [d.ask("POST", "/v1/jobs", slow(60), hers).json()["id"] for d in (a, b, a)]
            for d in (a, b):
                c.problem(d.ask("POST", "/v1/jobs", trivial(), hers), 429, "quota_exceeded", "her quota counts at both")
            one = b.ask("POST", "/v1/jobs", trivial(), his)
            c(one.status == 202, "another's does not", one.body)
            c(len(b.ask("GET", "/v1/jobs", headers=hers).json()["jobs"]) == 3 and len(a.ask("GET", "/v1/jobs", headers=his).json()["jobs"]) == 1, "lists are one's own")
            c.problem(b.ask("DELETE", "/v1/jobs/" + jobs[0], headers=his), 403, "insufficient_scope", "another's job is not his to cancel")
            for i, d in zip(jobs, (b, a, b)):
                c(d.ask("DELETE", "/v1/jobs/" + i, headers=hers).status in (200, 202), "hers are")
            token("revoke", "--name", "ann")
            c(until(lambda: all(d.ask("GET", "/v1/jobs", headers=hers).status == 401 for d in (a, b)), 10), "a token that is revoked is nobody's")
            c(a.stop() == 0 and b.stop() == 0, "both end with 0", a.errors()[-500:] + b.errors()[-500:])


def shared_turns(build, c):
    """One who has filled the queue of all waits for his turn: tokens are served in turns whichever daemon they ask, and whichever runs the job."""
    with Cluster() as server:
        address = prepared(build, server, "turns")

        def token(name):
            words = [os.path.join(build, "sgad"), "token", "create", "--name", name, "--store", address]
            return {"Authorization": "Bearer " + subprocess.run(words, capture_output=True, text=True, timeout=30, check=True).stdout.strip()}

        ann, bob, eve = token("ann"), token("bob"), token("eve")
        one = ("--access", "tokens", "--workers", "1", "--store", address)
        with Daemon(build, *one) as a, Daemon(build, *one) as b:
            for k in range(24):
                c.status((a, b)[k % 2].ask("POST", "/v1/jobs", slow(1), ann), 202, "hers")
            c(until(lambda: server.sql("SELECT count(*) FROM sgad.jobs WHERE status = 1", "turns") == [["2"]]), "two run, one at each daemon")
            for who, d in ((bob, a), (eve, b)):
                for _ in range(3):
                    c.status(d.ask("POST", "/v1/jobs", slow(1), who), 202, "theirs")
            by = "SELECT owner, started > (SELECT max(created) FROM sgad.jobs WHERE owner <> 'ann') FROM sgad.jobs WHERE status > 0 ORDER BY started, seq"
            c(until(lambda: sum(o[0] != "ann" for o in server.sql(by, "turns")) == 6, 60), "theirs are run while hers wait")
            order = [o[0] for o in server.sql(by, "turns") if o[1] == "t"]      # since all of theirs wait
            last = max((k for k, o in enumerate(order) if o != "ann"), default=-1)
            # three rounds at the most, each with one of hers; two more are on their way at once
            c(order[:last + 1].count("ann") <= 3 + 2, "each in turn", order)
            for d in (a, b):
                for job in d.ask("GET", "/v1/jobs?status=queued", headers=ann).json()["jobs"]:
                    d.ask("DELETE", "/v1/jobs/" + job["id"], headers=ann)
            c(a.stop() == 0 and b.stop() == 0, "both end with 0", a.errors()[-500:] + b.errors()[-500:])


def shared_versions(build, c):
    """Versions side by side: a job is left to daemons of its version while one of them lives, then anybody runs it; a newer schema is refused."""
    with Cluster() as server:
        address = prepared(build, server, "versions")
        with Daemon(build, *flags(address)) as a:
            busy = [a.ask("POST", "/v1/jobs", slow(60)).json()["id"] for _ in range(2)]
            c(until(lambda: all(status(a, i) == "running" for i in busy)), "both workers are busy")
            other = a.ask("POST", "/v1/jobs", trivial()).json()["id"]
            server.sql(f"UPDATE sgad.jobs SET version = 'other' WHERE id = '{other}'", "versions")
            server.sql("INSERT INTO sgad.daemons VALUES('elsewhere', 'other', 2, clock_timestamp() + interval '1 hour')", "versions")
            for i in busy:
                a.ask("DELETE", "/v1/jobs/" + i)
            own = a.ask("POST", "/v1/solve", trivial())
            c(own.status == 200 and own.json()["status"] == "done", "a later job of its own version runs", own.body[:200])
            c(status(a, other) == "queued", "that of another version is left to a daemon that has it", status(a, other))
            server.sql("UPDATE sgad.daemons SET seen = clock_timestamp() - interval '1 hour' WHERE name = 'elsewhere'", "versions")
            c(a.wait(other)["status"] == "done", "once that is gone it is run by any")
            own_version = a.get("/version").json()["version"]
            row = server.sql(f"SELECT version FROM sgad.results WHERE id = '{other}'", "versions")
            c(row == [[own_version]], "and the row says which version computed it", (row, own_version))
            c(a.stop() == 0, "it ends with 0", a.errors()[-500:])
        # tables of versions before: a daemon goes on with them, until they are brought up to date beside it
        for version in (1, 2):
            before = of_schema(server, f"before_{version}", version)
            with Daemon(build, *flags(before), "--cache-memory", "0") as a:
                jobs = [a.ask("POST", "/v1/solve", r, {"Prefer": "wait=60"}).json() for r in (trivial(), moving(samples=30000))]
                c([j["status"] for j in jobs] == ["done"] * 2, f"schema {version}", [j.get("error") for j in jobs])
                run = subprocess.run([os.path.join(build, "sgad"), "migrate", "--store", before], capture_output=True, text=True, timeout=30, check=False)
                c(run.returncode == 0 and f"was {version} and is 3" in run.stdout, f"schema {version}: brought up to date", run)
                jobs += [a.ask("POST", "/v1/solve", r, {"Prefer": "wait=60"}).json() for r in (trivial(), moving(samples=30000))]
                c(jobs[3]["status"] == "done" and server.sql("SELECT count(*) FROM sgad.pieces", f"before_{version}") == [["0"]], f"schema {version}: and it goes on, with whole results",
                  jobs[3].get("error"))
            with Daemon(build, *flags(before), "--cache-memory", "0") as a:
                c(all(essence(a.wait(j["id"])) == essence(j) for j in jobs), f"schema {version}: the jobs of before are there, after the step")
        server.sql("UPDATE sgad.schema SET version = 99", "versions")
        run = subprocess.run([os.path.join(build, "sgad"), "--listen", "127.0.0.1:0", "--store", address], capture_output=True, text=True, timeout=30, check=False)
        c(run.returncode == 1 and "newer" in run.stderr, "a schema that is newer is refused", run)


def shared_long(build, c):
    """A long result is in pieces: no daemon has all of it in memory, and those that are damaged, replaced or of nobody go."""
    with Cluster() as server:
        address = prepared(build, server, "long")
        count = lambda: int(server.sql("SELECT count(*) FROM sgad.pieces", "long")[0][0])  # noqa: E731
        with Daemon(build, *flags(address), "--cache-memory", "0") as a, Daemon(build, *flags(address), "--cache-memory", "0") as b:
            for d in (a, b):
                d.ask("POST", "/v1/solve", moving(), {"Prefer": "wait=60"})
            begin = [peak(a), peak(b)]
            told = a.ask("POST", "/v1/solve", moving(samples=SAMPLES), {"Prefer": "wait=120"}, seconds=150)
            job, length = told.json(), len(told.body)
            if not c(job.get("status") == "done" and length > 20 << 20, "solved", told.body[:300]):
                return
            where = "/v1/jobs/" + job["id"]
            c(b.get(where).body == told.body and a.get(where).body == told.body, "both have all of it")
            c(sanitized(build) or all(peak(d) - m < length / 2 for d, m in zip((a, b), begin)), "both stay small", (begin, peak(a), peak(b), length))
            pieces = count()
            c(pieces >= length >> 21, "in pieces", pieces)
            c(server.sql("SELECT count(*), bool_and(r.bytes = length(r.result) + (SELECT sum(length(piece)) FROM sgad.pieces p WHERE p.id = r.id AND p.epoch = r.pieces))"
                         " FROM sgad.results r WHERE pieces > 0", "long") == [["1", "t"]], "its bytes are counted")
            for label, sql in (("changed", "UPDATE sgad.pieces SET piece = set_byte(piece, 5, 7) WHERE n = 2"), ("gone", "DELETE FROM sgad.pieces WHERE n = 3"),
                               ("longer", "UPDATE sgad.pieces SET piece = piece || piece WHERE n = 1"), ("all gone", "DELETE FROM sgad.pieces")):
                server.sql(sql, "long")
                c(essence(b.wait(job["id"], seconds=120)) == essence(job), f"a piece {label}: the same answer")
                c(count() == pieces, f"a piece {label}: as many as before", (count(), pieces))
            server.sql("INSERT INTO sgad.pieces(id, epoch, n, made, piece) SELECT 'nobody', 1, n, clock_timestamp() - interval '2 hours', 'x' FROM generate_series(1, 3) n", "long")
            c(until(lambda: count() == pieces), "pieces of nobody are swept", count())
            server.sql(f"DELETE FROM sgad.results WHERE id = '{job['id']}'", "long")
            c(count() == 0, "pieces go with their result", count())


class Relay:
    """Between daemons and the server, a socket that can stop passing anything on, and cut what passes."""

    def __init__(self, server):
        self.folder, self.to = tempfile.mkdtemp(prefix="sgad-relay-"), os.path.join(server.folder, ".s.PGSQL.5432")
        self.open, self.taking, self.pairs, self.server = threading.Event(), threading.Event(), [], socket.socket(socket.AF_UNIX)
        self.open.set()
        self.taking.set()
        self.server.bind(os.path.join(self.folder, ".s.PGSQL.5432"))
        self.server.listen(100)
        threading.Thread(target=self.accept, daemon=True).start()

    def accept(self):
        while True:
            try:
                near = self.server.accept()[0]
            except OSError:
                return
            if not self.taking.is_set():
                near.close()
                continue
            far = socket.socket(socket.AF_UNIX)
            try:
                far.connect(self.to)
            except OSError:               # the server is down
                near.close()
                continue
            self.pairs.append((near, far))
            for a, b in ((near, far), (far, near)):
                threading.Thread(target=self.carry, args=(a, b), daemon=True).start()

    def carry(self, a, b):
        try:
            while data := a.recv(1 << 16):
                self.open.wait()
                b.sendall(data)
        except OSError:
            pass
        for s in (a, b):
            try:
                s.shutdown(socket.SHUT_RDWR)
            except OSError:
                pass

    def cut(self):
        pairs, self.pairs = self.pairs, []
        for pair in pairs:
            for s in pair:
                try:
                    s.shutdown(socket.SHUT_RDWR)
                except OSError:
                    pass

    def close(self):
        self.open.set()
        self.server.close()
        self.cut()
        shutil.rmtree(self.folder, ignore_errors=True)


def shared_stalled(build, c):
    """A connection on which nothing comes any more: who asks is answered in bounded time, what needs no database at once."""
    with Cluster() as server:
        address = prepared(build, server, "stalled")
        relay = Relay(server)
        try:
            with Daemon(build, *flags(address.replace(server.folder, relay.folder))) as a:
                known = trivial()
                c(a.ask("POST", "/v1/solve", known).json()["status"] == "done", "through the relay")
                relay.open.clear()
                c(a.ask("POST", "/v1/solve", known).status == 200 and a.get("/healthz").status == 200, "memory and health")
                c.problem(a.ask("POST", "/v1/jobs", trivial(), seconds=60), 503, "store_failed", "a post while nothing comes")
                c(a.get("/healthz").status == 200 and a.get("/readyz").status == 503, "then it is not ready")
                relay.open.set()
                c(until(lambda: a.get("/readyz").status == 200), "ready once it passes on", [x for x in said(a).splitlines() if "request" not in x])
                c(a.ask("POST", "/v1/solve", trivial()).json()["status"] == "done", "and jobs run")
                for k in range(20):       # some fall on a connection that is just being made
                    relay.cut()
                    job = a.ask("POST", "/v1/solve", trivial()).json()
                    c(job["status"] == "done", f"also after {k + 1} cuts", job)
                relay.taking.clear()
                relay.cut()
                threading.Timer(0.6, relay.taking.set).start()
                job = a.ask("POST", "/v1/solve", trivial()).json()
                c(job["status"] == "done", "a post waits for a database that is back at once", job)
                c(a.stop() == 0, "it ends with 0", a.errors()[-500:])
        finally:
            relay.close()


class Deaf(Relay):
    """Passes on all but notifications (messages of type A of the protocol), and counts those."""

    missed = 0

    def carry(self, a, b):
        if all(a is not far for _, far in self.pairs):
            super().carry(a, b)
            return
        held = b""
        try:
            while data := a.recv(1 << 16):
                held, out = held + data, b""
                while len(held) >= 5 and len(held) > (n := int.from_bytes(held[1:5], "big")):
                    message, held = held[:1 + n], held[1 + n:]
                    self.missed += message[:1] == b"A"
                    out += b"" if message[:1] == b"A" else message
                b.sendall(out)
        except OSError:
            pass
        b.close()


def shared_deaf(build, c):
    """A notification is a hint and no more: a daemon that hears none claims, answers, watches and cancels all the same."""
    with Cluster() as server:
        address = prepared(build, server, "deaf")
        relay = Deaf(server)
        try:
            with Daemon(build, *flags(address)) as a, Daemon(build, *flags(address.replace(server.folder, relay.folder))) as b:
                for one, other in ((a, b), (b, a)):
                    ids = [one.ask("POST", "/v1/jobs", trivial()).json()["id"] for _ in range(6)]
                    ends = [other.ask("GET", "/v1/jobs/" + i, headers={"Prefer": "wait=60"}).json()["status"] for i in ids]
                    c(ends == ["done"] * 6, "posted to one, waited for at the other", ends)
                long = [a.ask("POST", "/v1/jobs", slow(60)).json()["id"] for _ in range(4)]
                c(until(lambda: all(status(b, i) == "running" for i in long)), "it claims what was posted to the other", [status(b, i) for i in long])
                waiting = []
                threads = [threading.Thread(target=lambda i=i: waiting.append(b.ask("GET", "/v1/jobs/" + i, headers={"Prefer": "wait=60"}).json()["status"])) for i in long]
                [t.start() for t in threads]
                for i in long:
                    c(a.ask("DELETE", "/v1/jobs/" + i).status in (200, 202), "cancelled at the other")
                [t.join() for t in threads]
                c(waiting == ["cancelled"] * 4, "its waiters are told", waiting)
                c(relay.missed > 0, "there were notifications, and it had none of them", relay.missed)
                c(b.stop() == 0 and a.stop() == 0, "both end with 0", b.errors()[-500:])
        finally:
            relay.close()


def shared_failover(build, c):
    """The server is lost with its disk while clients post, and its synchronous standby is promoted: what was accepted is there."""
    with Cluster() as first:
        address = prepared(build, first, "failover")
        second = first.standby()
        try:
            second.start()
            first.sql("ALTER SYSTEM SET synchronous_standby_names = '*'")
            first.sql("SELECT pg_reload_conf()")
            c(until(lambda: first.sql("SELECT sync_state FROM pg_stat_replication") == [["sync"]]), "a synchronous standby")
            with Daemon(build, *flags(f"{address},{second.folder}")) as a:
                c("no_synchronous_standby" not in said(a), "the start does not warn", said(a)[-500:])
                accepted = [a.ask("POST", "/v1/jobs", trivial()).json()["id"] for _ in range(20)]
                runs = a.ask("POST", "/v1/jobs", slow(3)).json()["id"]
                more = a.ask("POST", "/v1/jobs", trivial())
                c(more.status == 202, "accepted by both")
                first.stop(signal.SIGQUIT)
                shutil.rmtree(first.data)
                second.promote()
                c(until(lambda: a.get("/readyz").status == 200), "ready with the other server", said(a)[-500:])
                # nobody stands by the new one yet: who waits for that waits for ever
                second.sql("ALTER SYSTEM SET synchronous_standby_names = ''")
                second.sql("SELECT pg_reload_conf()")
                ends = {i: a.wait(i)["status"] for i in [*accepted, more.json()["id"], runs]}
                c([s for i, s in ends.items() if i != runs] == ["done"] * 21 and ends[runs] == "failed", "all that was accepted ends", ends)
                c(a.ask("POST", "/v1/solve", trivial()).json()["status"] == "done" and a.stop() == 0, "and it goes on")
        finally:
            second.__exit__()


ALL = [shared_answers, shared_killed, shared_away, shared_tenants, shared_turns, shared_versions, shared_long, shared_stalled, shared_deaf, shared_failover]
