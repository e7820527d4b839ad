"""The service beside what would stop it, and on PostgreSQL: parts of bench.py.

service.py flood PORT CLIENTS SECONDS: so many clients post bodies that are short and costly to check."""
import http.client
import json
import os
import re
import statistics
import subprocess
import sys
import threading
import time

HERE = os.path.dirname(os.path.abspath(__file__))
ROWS = int(os.environ.get("SGA_BENCH_ROWS", "1000000"))
JOB = "INSERT INTO sgad.jobs(id, owner, version, status, created, started, finished, seconds, bytes, name, form, request, sum) SELECT lpad(to_hex(k), 32, '0')," \
      " 'token ' || k % 100, 'bench', {status}, 1.7e12 + k, {ended}, {ended}, 60, 100, 'made', 'quasilinear', decode(repeat('7b', 100), 'hex')," \
      " decode(repeat('00', 32), 'hex') FROM generate_series({first}, {last}) AS k"


def flood(port, clients, seconds):
    until = time.time() + seconds

    def one(n):
        k, c = 0, http.client.HTTPConnection("127.0.0.1", port, timeout=120)
        while time.time() < until:
            k += 1
            system = {"form": "equations", "variables": ["x"], "name": f"{n}-{k}", "equations": ["der(sin(cos(x^9*t))/exp(x*t), 30) = 0"]}
            try:
                c.request("POST", "/v1/jobs", json.dumps({"system": system}), {"Content-Type": "application/json"})
                c.getresponse().read()
            except (OSError, http.client.HTTPException):
                c.close()
    threads = [threading.Thread(target=one, args=(n,), daemon=True) for n in range(clients)]
    for t in threads:
        t.start()
    time.sleep(max(0, until - time.time()))
    print(flush=True)
    os._exit(0)


def hostile(daemon, client, timed, show):
    """daemon(*flags): one that is started; client, timed: of bench.py."""
    print("30 clients whose bodies are short and costly to check")
    with daemon("--workers", "2", "--log-level", "warn") as d:
        health = f"GET /healthz HTTP/1.1\r\nHost: 127.0.0.1:{d.port}\r\n\r\n".encode()
        crowd = subprocess.Popen(["/usr/bin/python3", os.path.abspath(__file__), "flood", str(d.port), "30", "15"], stdout=subprocess.DEVNULL)
        try:
            time.sleep(2)
            c, took = client(d.port), []
            while crowd.poll() is None and len(took) < 1000:
                took.append(timed(c, health)[0])
                time.sleep(0.01)
            c.close()
        finally:
            crowd.kill()
            crowd.wait()
        took.sort()
        late = took[len(took) * 99 // 100]
        show("a health check beside them, 99 %", f"{1e3 * late:.1f} ms", "<= 100 ms", late <= 0.1,
             f"{len(took)} of them, median {1e3 * statistics.median(took):.2f} ms, longest {1e3 * took[-1]:.1f} ms, load {os.getloadavg()[0]:.1f}")


def prepared(build, server, name):
    address = server.database(name)
    subprocess.run([os.path.join(build, "sgad"), "migrate", "--store", address], check=True, capture_output=True, timeout=60)
    return address


def backends(server, cpu):
    """CPU seconds of the server's processes so far."""
    with open(f"/proc/{server.process.pid}/task/{server.process.pid}/children", encoding="ascii") as f:
        return sum(cpu(pid) for pid in [server.process.pid, *map(int, f.read().split())])


def hits(build, server, daemon, client, trivial, cpu, show):
    """From memory, and from the store; the database's own work counts."""
    found = {}
    for name, flags in (("SQLite", ()), ("PostgreSQL", ("--store", prepared(build, server, "hits")))):
        for memory in ("from memory", "from the store"):
            with daemon("--workers", "1", "--log-level", "warn", *flags, *(() if memory == "from memory" else ("--cache-memory", "0"))) as d:
                c = client(d.port)
                post = c.prepare(trivial(77))
                job = json.loads(c.send(post))["id"]
                ask = post if memory == "from memory" else f"GET /v1/jobs/{job} HTTP/1.1\r\nHost: 127.0.0.1:{d.port}\r\n\r\n".encode()
                best = []
                for _ in range(5):
                    before = cpu(d.process.pid) + (backends(server, cpu) if flags else 0)
                    for _ in range(1000):
                        c.send(ask)
                    best.append((cpu(d.process.pid) + (backends(server, cpu) if flags else 0) - before) / 1000)
                found[name, memory] = min(best)
                c.close()
    for memory in ("from memory", "from the store"):
        ours, theirs = found["PostgreSQL", memory], found["SQLite", memory]
        show(f"a hit by PostgreSQL / by SQLite, {memory}", f"{ours / theirs:.2f}", "<= 2", ours <= 2 * theirs,
             f"{1e6 * ours:.1f} us, {1e6 * theirs:.1f} us of CPU, the database's included")


def plans(server, database):
    """Of the statements of a claim, as the server runs them: scans of a whole table."""
    server.sql("ANALYZE", database)
    text = "\n".join(row[0] for row in server.sql(
        "SET search_path = sgad; LOAD 'auto_explain'; SET auto_explain.log_min_duration = 0; SET auto_explain.log_nested_statements = on;"
        "SET client_min_messages = log; SELECT id FROM claim_1('plans', 'bench', 15, 100)", database))
    with open(os.path.join(server.folder, "log"), encoding="utf-8") as f:
        text += f.read()
    return text.count("using jobs_waiting"), len(re.findall(r"Seq Scan on (?:jobs|interests|results)\\b", text))


def claims(build, server, show):
    """Rows that wait and rows that have ended, half and half, of 100 tokens."""
    prepared(build, server, "claims")
    for status, ended, first, last in ((0, "0", 1, ROWS // 2), (2, "1.7e12 + k", ROWS // 2 + 1, ROWS)):
        server.sql("SET synchronous_commit = off; " + JOB.format(status=status, ended=ended, first=first, last=last), "claims")
    server.sql("INSERT INTO sgad.interests(id, owner, status) SELECT id, owner, status FROM sgad.jobs ORDER BY seq", "claims")
    server.sql("INSERT INTO sgad.turns SELECT 'token ' || k, 0 FROM generate_series(0, 99) AS k", "claims")
    by_index, whole = plans(server, "claims")
    script = os.path.join(server.folder, "claim.sql")
    with open(script, "w", encoding="ascii") as f:
        f.write("SELECT id AS job, epoch AS run FROM sgad.claim_1('bench', 'bench', 15, 100) \\gset\n"
                "SELECT sgad.end_1(:job, :run, 2, 1, 2, NULL, 'unique', 'bench', '{}', '\\x00');\n")
    os.chmod(script, 0o644)
    rate = {}
    for n in (1, 4):
        out = server.run("pgbench", "-n", "-M", "prepared", "-h", server.folder, "-U", server.user, "-f", script, "-c", str(n), "-j", "1", "-T", "5", "claims",
                         env={**os.environ, "PGOPTIONS": "-c search_path=sgad"}).stdout
        rate[n] = float(re.search(r"tps = ([\d.]+)", out)[1])
    show(f"claims and ends a second at {ROWS} rows, 1 and 4 at once", f"{rate[1]:.0f}, {rate[4]:.0f}", note="each claim and each end a transaction that is synced")
    show("statements of a claim by the index of what waits; scans of a table", f"{by_index}; {whole}", "no scan", by_index > 0 and whole == 0)


def two_daemons(build, server, daemon, heavy, own_speedup, folder, show):
    """Of one worker each."""
    took, own = [[], []], []
    flags = ("--store", prepared(build, server, "two"), "--workers", "1", "--log-level", "warn")
    for turn in range(2):
        for n in (1, 2):
            daemons = [daemon(*flags) for _ in range(n)]
            try:
                for d in daemons:
                    d.__enter__()
                begun = time.perf_counter()
                ids = [daemons[k % n].ask("POST", "/v1/jobs", heavy(30000 + 1000 * n + 100 * turn + k)).json()["id"] for k in range(12)]
                for i in ids:
                    job = daemons[0].ask("GET", "/v1/jobs/" + i, headers={"Prefer": "wait=100"}).json()
                    if job["status"] != "done":
                        raise RuntimeError(str(job)[:300])
                took[n - 1].append(time.perf_counter() - begun)
            finally:
                for d in daemons:
                    d.__exit__()
        own.append(own_speedup(folder))
    ratio, machine = min(took[0]) / min(took[1]), statistics.median(own)
    show("two daemons / one, jobs a second", f"{ratio:.2f}", ">= 1.9", ratio >= 1.9, f"12 jobs in {min(took[0]):.2f} s, {min(took[1]):.2f} s")
    show("that / what two processes alone gain", f"{ratio / machine:.2f}", ">= 0.95", ratio >= 0.95 * machine,
         f"they gain {machine:.2f} at this moment; load {os.getloadavg()[0]:.1f}")


if __name__ == "__main__":
    if sys.argv[1:2] != ["flood"]:
        sys.exit(__doc__)
    flood(int(sys.argv[2]), int(sys.argv[3]), float(sys.argv[4]))
