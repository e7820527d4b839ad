"""What can be seen from outside, and what many or slow clients cannot do to the service."""
import glob
import json
import os
import pty
import re
import resource
import signal
import socket
import subprocess
import tempfile
import threading
import time

from access import bearer, new_token, until
from common import moving, slow, trivial
from daemon import Daemon
from tally import ROOT


def series(d, headers=None):
    """The metrics as {name{labels}: value}."""
    text = d.ask("GET", "/metrics", headers=headers).body.decode()
    return {line.rsplit(" ", 1)[0]: float(line.rsplit(" ", 1)[1]) for line in text.splitlines() if line and line[0] != "#"}


def stages(build, c):
    with Daemon(build, "--workers", "1") as d:
        d.ask("POST", "/v1/solve", moving())
        d.get("/nothing")
        m = series(d)
        for stage in ("queued", "running", "reduction", "witness", "trajectory", "writing"):
            label = f'{{stage="{stage}"}}'
            n = m.get("sgad_stage_duration_seconds_count" + label)
            c(n == 1, f"stage {stage}: one job", n)
            buckets = [v for k, v in m.items() if k.startswith(f'sgad_stage_duration_seconds_bucket{{stage="{stage}",')]
            c(buckets == sorted(buckets) and buckets[-1] == n, f"stage {stage}: buckets", buckets)
        total = sum(v for k, v in m.items() if k.startswith("sgad_stage_duration_seconds_sum"))
        c(total >= 0.5 * m["sgad_job_duration_seconds_sum"], "the stages make up the job", (total, m["sgad_job_duration_seconds_sum"]))
        c(all(v == 0 for k, v in m.items() if k.startswith("sgad_jobs_at_stage")), "no job is at a stage at rest")
        c(m.get('sgad_refusals_total{code="not_found"}') == 1, "refusals by code")
        ids = [d.ask("POST", "/v1/jobs", slow()).json()["id"] for _ in range(3)]
        c(until(lambda: series(d)['sgad_jobs_at_stage{stage="trajectory"}'] == 1), "a running job is at its stage")
        c(series(d)['sgad_jobs_at_stage{stage="queued"}'] == 2, "two are queued")
        for i in ids[::-1]:
            d.ask("DELETE", "/v1/jobs/" + i)
        c(until(lambda: all(v == 0 for k, v in series(d).items() if k.startswith("sgad_jobs_at_stage"))), "cancelled jobs leave their stages")


def measured(build, c):
    """What an administrator watches: ages, commits, the disk, the process, the version."""
    with Daemon(build, "--workers", "1") as d:
        d.ask("POST", "/v1/solve", trivial())
        m = series(d)
        c(m.get("sgad_queue_oldest_seconds") == 0, "nothing waits")
        version = d.get("/version").json()["version"]
        c(m.get(f'sgad_build_info{{version="{version}"}}') == 1, "build_info", version)
        c(m["sgad_store_commit_duration_seconds_count"] == m["sgad_store_commits_total"] + m["sgad_store_failures_total"] > 0, "commits are timed")
        room = os.statvfs(d.state)
        c(0.5 < m["sgad_state_free_bytes"] / (room.f_bavail * room.f_frsize) < 2, "free disk", m["sgad_state_free_bytes"])
        c(m["process_resident_memory_bytes"] > 1e6 and m["process_virtual_memory_bytes"] > m["process_resident_memory_bytes"], "memory")
        c(5 < m["process_open_fds"] < m["process_max_fds"] and m["process_threads"] > 4 and m["process_cpu_seconds_total"] >= 0, "descriptors, threads")
        c(abs(m["process_start_time_seconds"] - time.time()) < 600, "start", m["process_start_time_seconds"])
        pid = d.process.pid
        c(abs(m["process_open_fds"] - len(os.listdir(f"/proc/{pid}/fd"))) <= 3, "as /proc has it")
        ids = [d.ask("POST", "/v1/jobs", slow()).json()["id"] for _ in range(2)]
        c(until(lambda: series(d)["sgad_queue_oldest_seconds"] > 0.2), "a job that waits has an age")
        for i in ids[::-1]:
            d.ask("DELETE", "/v1/jobs/" + i)
        c(until(lambda: series(d)["sgad_queue_oldest_seconds"] == 0), "nothing waits any more")
        watched(c, d.ask("GET", "/metrics").body.decode())


def watched(c, text):
    """Alerts and dashboard ask for what there is, and each alert has its entry in the runbook."""
    # Of a daemon with TLS only.
    there = set(re.findall(r"^# TYPE (\S+)", text, re.M)) | {"sgad_certificate_expiry_timestamp_seconds"}
    with open(os.path.join(ROOT, "etc/prometheus/sgad.rules.yml"), encoding="utf-8") as f:
        rules = f.read()
    with open(os.path.join(ROOT, "etc/grafana/sgad.json"), encoding="utf-8") as f:
        panels = json.load(f)["panels"]
    with open(os.path.join(ROOT, "doc/operations.md"), encoding="utf-8") as f:
        runbook = f.read()
    asked = re.findall(r"^ +expr: (.*)$", rules, re.M) + [t["expr"] for p in panels for t in p["targets"]]
    names = {re.sub(r"_(bucket|sum|count)$", "", n) for e in asked for n in re.findall(r"\b(?:sgad|process)_\w+", e)}
    c(len(names) > 20 and names <= there, "alerts and dashboard ask for metrics that there are", names - there)
    alerts = re.findall(r"alert: (\w+)", rules)
    c(len(alerts) > 8 and all(f"| `{a}` |" in runbook for a in alerts), "each alert has its entry in the runbook", alerts)
    events = set()
    for place in glob.glob(os.path.join(ROOT, "server/**/*.c"), recursive=True):
        with open(place, encoding="utf-8") as f:
            for event in re.findall(r'LOG_L_(?:WARN|ERROR)(?: : LOG_L_\w+)?,\s*(?:\w+ \? )?((?:"[a-z_]+"(?: : )?)+)', f.read()):
                events |= set(re.findall(r'"([a-z_]+)"', event))
    c(len(events) > 25 and all(f"`{e}`" in runbook for e in events), "each warning and error of the log has its entry", [e for e in events if f"`{e}`" not in runbook])
    codes = set(re.findall(r'code=~"([^"]*)"', rules)[0].split("|"))
    with open(os.path.join(ROOT, "doc/parts/errors.json"), encoding="utf-8") as f:
        c(codes <= set(json.load(f)), "alerts name codes that there are", codes)


def supervised(build, c):
    """What a supervisor is told (sd_notify), on a named and on an abstract socket."""
    with tempfile.TemporaryDirectory() as folder:
        for name in (folder + "/notify", f"@sgad-test-{os.getpid()}"):
            with socket.socket(socket.AF_UNIX, socket.SOCK_DGRAM) as s:
                s.bind(name.replace("@", "\0"))
                s.settimeout(30)

                def heard(word, s=s):
                    """The next message with this word; signs of life may come before it."""
                    while True:
                        text = s.recv(4096).decode()
                        if word in text:
                            return text
                        if text != "WATCHDOG=1":
                            return "not " + text
                with Daemon(build, env={"NOTIFY_SOCKET": name, "WATCHDOG_USEC": "400000"}) as d:
                    text = heard("READY=1")
                    c(text == f"READY=1\nSTATUS=listening on {d.url()}", "supervisor: ready", text)
                    c([heard("WATCHDOG=1") for _ in range(3)] == 3 * ["WATCHDOG=1"], "supervisor: signs of life")
                    d.process.send_signal(signal.SIGHUP)
                    text = heard("RELOADING=1")
                    c(re.fullmatch(r"RELOADING=1\nMONOTONIC_USEC=\d+", text), "supervisor: reloading", text)
                    c(heard("READY=1") == "READY=1", "supervisor: ready again")
                    c(d.stop() == 0, "supervisor: ends")
                    text = heard("STOPPING=1")
                    c(re.fullmatch(r"STOPPING=1\nSTATUS=.*\nEXTEND_TIMEOUT_USEC=\d+000000", text), "supervisor: stopping, with the time it may take", text)
        for other in ("nothing", "", "@", "/nonexistent/socket"):
            with Daemon(build, env={"NOTIFY_SOCKET": other, "WATCHDOG_USEC": "400000", "WATCHDOG_PID": "1"}) as d:
                c(d.get("/healthz").status == 200 and d.stop() == 0, f"supervisor: {other!r} is nobody to tell")


def logs(build, c):
    with Daemon(build) as d:
        trace = "00-0af7651916cd43dd8448eb211c80319c-b7ad6b7169203331-01"
        a = d.ask("POST", "/v1/solve", trivial(), {"X-Request-Id": "ask-1", "traceparent": trace})
        c(a.headers.get("x-request-id") == "ask-1", "the request id comes back", a.headers)
        id_ = a.json()["id"]
        until(lambda: '"route":"/v1/solve"' in d.errors())
        entries = [json.loads(line) for line in d.errors().splitlines() if line.startswith("{")]
        ended = [e for e in entries if e["event"] == "job_ended" and e["job"] == id_]
        asked = [e for e in entries if e["event"] == "request" and e.get("request_id") == "ask-1"]
        c(len(ended) == 1 and ended[0].get("request_id") == "ask-1" and ended[0].get("traceparent") == trace, "job_ended names request and trace", ended)
        c(len(asked) == 1 and asked[0].get("traceparent") == trace and asked[0].get("job") == id_ and asked[0]["status"] == 200,
          "the request is logged with trace and job", asked)
        c(asked[0].get("peer") == "127.0.0.1" and "code" not in asked[0] and isinstance(asked[0]["seconds"], float), "... with who asked, and numbers", asked)
        c(ended[0]["outcome"] == "done" and isinstance(ended[0]["seconds"], float), "job_ended says how, and numbers", ended)
        d.get("/nothing", X_Request_Id="ask-2")
        until(lambda: '"ask-2"' in d.errors())
        refused = [e for e in map(json.loads, (line for line in d.errors().splitlines() if line.startswith("{"))) if e.get("request_id") == "ask-2"]
        c(len(refused) == 1 and refused[0].get("code") == "not_found" and refused[0]["status"] == 404, "a refusal is logged with its code", refused)
        for bad in ("a b", "x" * 65, 'quote"', ""):
            back = d.get("/healthz", X_Request_Id=bad).headers.get("x-request-id", "")
            c(back and back != bad, f"the id {bad[:8]!r} is not taken", back)
        state = os.path.join(d.state, "tty")
        ours, theirs = pty.openpty()
        p = subprocess.Popen([os.path.join(build, "sgad"), "--listen", "127.0.0.1:0", "--state", state], stdout=subprocess.PIPE, stderr=theirs)
        p.stdout.readline()
        p.send_signal(signal.SIGTERM)
        p.wait(30)
        p.stdout.close()
        os.close(theirs)
        text = os.read(ours, 65536).decode()
        os.close(ours)
        c(" info started " in text and "{" not in text, "text on a terminal", text)


def top(build, c):
    with Daemon(build, "--access", "tokens") as d:
        token = new_token(build, d, "one")
        c(until(lambda: d.ask("GET", "/v1/jobs", headers=bearer(token)).status == 200), "token")
        d.ask("POST", "/v1/solve", trivial(), bearer(token))
        command = [os.path.join(build, "sga"), "top", "--server", d.url(), "--once"]
        env = {k: v for k, v in os.environ.items() if k != "SGA_TOKEN"}
        run = subprocess.run(command, capture_output=True, timeout=30, check=False, text=True, env={**env, "SGA_TOKEN": token})
        c(run.returncode == 0 and "store healthy" in run.stdout and re.search(r"^ended +done 1$", run.stdout, re.M), "sga top", run)
        run = subprocess.run(command, capture_output=True, timeout=30, check=False, text=True, env=env)
        c(run.returncode == 1 and "SGA_TOKEN" in run.stderr, "sga top without a token", run)
        path = os.path.join(d.state, "r.json")
        with open(path, "w", encoding="utf-8") as f:
            json.dump(trivial(), f)
        solve = [os.path.join(build, "sga"), "solve", path, "--server", d.url(), "--json"]
        run = subprocess.run(solve, capture_output=True, timeout=60, check=False, text=True, env={**env, "SGA_TOKEN": token})
        c(run.returncode == 0 and json.loads(run.stdout)["verdict"], "sga solve with a token", run.stderr)
        run = subprocess.run(solve, capture_output=True, timeout=60, check=False, text=True, env=env)
        c(run.returncode == 1 and "unauthenticated" in run.stdout + run.stderr, "sga solve without a token", run)


def connect(d):
    return socket.create_connection(("127.0.0.1", d.port), timeout=40)


def slowly(build, c):
    """Clients that drip, stop reading, or hold on, and a stream watched over its whole life."""
    with Daemon(build, "--workers", "1", "--request-timeout", "2", "--send-timeout", "3", "--idle-timeout", "60") as d:
        def drip(text):
            with connect(d) as s:
                begun = time.monotonic()
                try:
                    for byte in text * 100:
                        s.sendall(bytes([byte]))
                        time.sleep(0.25)
                        if time.monotonic() - begun > 30:
                            return False
                except OSError:
                    return True
        gone = []
        post = b"POST /v1/jobs HTTP/1.1\r\nHost: localhost\r\nContent-Type: application/json\r\nContent-Length: 100000\r\n\r\n" + b" "
        threads = [threading.Thread(target=lambda t=t: gone.append(drip(t))) for t in (b"X-Header: a\r\n", b"GET /", post)]
        for t in threads:
            t.start()
        big = d.ask("POST", "/v1/solve", moving(samples=20000)).json()
        path = f"/v1/jobs/{big['id']}/trajectory?format=csv"
        whole = d.get(path)
        c(whole.status == 200 and whole.body.count(b"\n") == 20001, "a long trajectory as CSV", (whole.status, whole.body.count(b"\n")))
        c("content-length" not in whole.headers, "it is streamed")
        with connect(d) as s:                      # asks for much and reads nothing
            s.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, 4096)
            s.sendall((f"GET {path} HTTP/1.1\r\nHost: localhost\r\n\r\n" * 20).encode())
            c(until(lambda: series(d)["sgad_connections_reaped_total"] >= 4, 40), "who takes nothing is cut", series(d)["sgad_connections_reaped_total"])
        for t in threads:
            t.join(60)
        c(gone == [True] * 3, "who drips is cut", gone)
        c.status(d.get("/healthz"), 200, "alive")

        running = d.ask("POST", "/v1/jobs", slow()).json()["id"]
        id_ = d.ask("POST", "/v1/jobs", slow()).json()["id"]      # it waits: nothing is to be told of it
        with connect(d) as s:
            s.sendall(f"GET /v1/jobs/{id_}/events HTTP/1.1\r\nHost: localhost\r\n\r\n".encode())
            text = b""
            end = time.monotonic() + 40
            while b": still here" not in text and time.monotonic() < end:
                text += s.recv(65536)
            c(b": still here" in text, "an event stream shows that it lives", text[-200:])
            c(b"retry: " in text and b"X-Accel-Buffering: no" in text, "an event stream: retry, no buffering", text[:400])
            seen = re.findall(rb"^id: (\d+)\r?$", text, re.M)
            c(seen and [int(i) for i in seen] == sorted(int(i) for i in seen), "event ids grow", seen)
        last = seen[-1].decode()
        with connect(d) as s:                      # comes back: nothing that it has seen comes again
            s.sendall(f"GET /v1/jobs/{id_}/events HTTP/1.1\r\nHost: localhost\r\nLast-Event-ID: {last}\r\n\r\n".encode())
            time.sleep(0.5)
            for one in (id_, running):
                d.ask("DELETE", "/v1/jobs/" + one)
            text = b""
            while b"event: end" not in text:
                piece = s.recv(65536)
                if not piece:
                    break
                text += piece
            again = [i for i in re.findall(rb"^id: (\d+)\r?$", text, re.M) if int(i) <= int(last)]
            c(not again and b"event: end" in text and b"id: end" in text, "an event stream is taken up where it was left", text[-300:])


def many(build, c):
    """The limits on connections, waiters, streams and bodies."""
    with Daemon(build, "--workers", "1", "--connections", "40", "--waiters", "3", "--streams", "2", "--body-memory", "300000",
                "--body-limit", "200000", "--idle-timeout", "30", "--stream-timeout", "2") as d:
        id_ = d.ask("POST", "/v1/jobs", slow()).json()["id"]
        answers = []
        waiters = [threading.Thread(target=lambda: answers.append(d.get("/v1/jobs/" + id_, Prefer="wait=4"))) for _ in range(6)]
        begun = time.monotonic()
        for t in waiters:
            t.start()
        c(until(lambda: len(answers) >= 3, 3), "who finds no room to wait is answered at once", len(answers))
        for t in waiters:
            t.join(20)
        c([a.status for a in answers] == [200] * 6 and time.monotonic() - begun >= 3.5, "the others waited", [a.status for a in answers])
        silent = [connect(d) for _ in range(3)]
        for s in silent:
            s.sendall(f"GET /v1/jobs/{id_} HTTP/1.1\r\nHost: localhost\r\nPrefer: wait=30\r\n\r\n".encode())
        c(until(lambda: series(d)["sgad_waiters"] == 3), "three wait again")
        for s in silent:
            s.close()
        c(until(lambda: series(d)["sgad_waiters"] == 0, 10), "who hung up holds no place")
        streams = [connect(d) for _ in range(2)]
        for s in streams:
            s.sendall(f"GET /v1/jobs/{id_}/events HTTP/1.1\r\nHost: localhost\r\n\r\n".encode())
            s.recv(100)
        c(until(lambda: series(d)["sgad_event_streams"] == 2), "two event streams")
        a = d.get(f"/v1/jobs/{id_}/events")
        c.problem(a, 503, "queue_full", "a third event stream of two")
        c("retry-after" in a.headers, "event streams: Retry-After", a.headers)
        c(until(lambda: series(d)["sgad_connections_reaped_total"] >= 2), "an event stream ends in time")
        for s in streams:
            s.close()
        d.ask("DELETE", "/v1/jobs/" + id_)

        head = "POST /v1/jobs HTTP/1.1\r\nHost: localhost\r\nContent-Type: application/json\r\nContent-Length: 150000\r\n\r\n".encode()
        holders = [connect(d) for _ in range(3)]   # each sends most of a body and stops
        for s in holders:
            s.sendall(head + b" " * 130000)
        time.sleep(0.5)
        s = connect(d)
        s.sendall(head + b" " * 150000)
        out = s.recv(4096)
        c(out.startswith(b"HTTP/1.1 503") and b"Retry-After" in out and b'"busy"' in out, "bodies have a bound in all", out[:300])
        for h in holders + [s]:
            h.close()
        c(until(lambda: d.ask("POST", "/v1/jobs", trivial()).status in (200, 202)), "and room again when they are gone")
        c(until(lambda: d.ask("POST", "/v1/solve", json.dumps(trivial()) + " " * 150000).status == 200), "one large body is read, once all of them are")

        crowd = []
        for _ in range(60):
            try:
                crowd.append(connect(d))
            except OSError:
                break
        time.sleep(0.3)
        for s in crowd:
            s.close()
        c(until(lambda: d.get("/healthz").status == 200), "alive after more connections than it takes")


def crowded(build, c):
    """Hundreds of waiting requests and event streams at once (past the 128 at which epoll would go
    silent): none is lost, and who asks for something that is known is served beside them."""
    resource.setrlimit(resource.RLIMIT_NOFILE, (resource.getrlimit(resource.RLIMIT_NOFILE)[1],) * 2)
    with Daemon(build, "--workers", "1", "--log-level", "warn") as d:
        known = trivial()
        d.ask("POST", "/v1/solve", known)
        id_ = d.ask("POST", "/v1/jobs", slow()).json()["id"]
        waiters, streams, idle = ([connect(d) for _ in range(n)] for n in (400, 150, 100))
        for s in waiters:
            s.sendall(f"GET /v1/jobs/{id_} HTTP/1.1\r\nHost: localhost\r\nPrefer: wait=100\r\nConnection: close\r\n\r\n".encode())
        for s in streams:
            s.sendall(f"GET /v1/jobs/{id_}/events HTTP/1.1\r\nHost: localhost\r\n\r\n".encode())
        c(until(lambda: (series(d)["sgad_waiters"], series(d)["sgad_event_streams"]) == (400, 150), 30), "all of them wait",
          {k: v for k, v in series(d).items() if "wait" in k or "stream" in k})
        took = []
        for _ in range(50):
            begun = time.monotonic()
            c.status(d.ask("POST", "/v1/solve", known), 200, "a hit beside them")
            took.append(time.monotonic() - begun)
        c(sorted(took)[25] < 1, "a hit does not wait for them", took)
        d.ask("DELETE", "/v1/jobs/" + id_)

        def all_of(s):
            out = b""
            while True:
                piece = s.recv(65536)
                if not piece:
                    return out
                out += piece
        ends = [all_of(s) for s in waiters]
        c(all(e.startswith(b"HTTP/1.1 200") and e.endswith(b"}") and b'"cancelled"' in e for e in ends), "every waiter is answered",
          [e[:80] for e in ends if b'"cancelled"' not in e][:3])
        c(all(b"event: end" in s.recv(65536) or b"event: end" in s.recv(65536) for s in streams), "every stream tells the end")
        for s in idle:
            s.sendall(b"GET /healthz HTTP/1.1\r\nHost: localhost\r\n\r\n")
        c(all(s.recv(1000).startswith(b"HTTP/1.1 200") for s in idle), "connections that were silent meanwhile are served")
        for s in waiters + streams + idle:
            s.close()


def huge(build, c):
    """Large trajectories are sent as they lie, line by line; how many of them is bounded."""
    with Daemon(build, "--cache-memory", "0", "--reply-memory", "20000000", "--send-timeout", "60") as d:
        request = moving(samples=250000)
        request["limits"] = {"seconds": 100}
        job = d.ask("POST", "/v1/solve", request, {"Prefer": "wait=100"}).json()
        c(job["status"] == "done", "a large trajectory", job.get("error"))
        rows = job["result"]["trajectory"]["rows"]
        path = f"/v1/jobs/{job['id']}/trajectory"
        before = memory(d)
        text = d.get(path + "?format=csv").body.decode().splitlines()
        c(len(text) == 250001 and [float(x) for x in text[123456].split(",")] == rows[123455], "all rows as CSV", len(text))
        text = d.get(path + "?format=ndjson").body.decode().splitlines()
        c(len(text) == 250000 and list(json.loads(text[-1]).values()) == rows[-1], "all rows as NDJSON", len(text))
        readers = []
        for _ in range(12):                        # each asks, reads the head, and no more
            s = socket.socket()
            s.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, 4096)
            s.settimeout(40)
            s.connect(("127.0.0.1", d.port))
            s.sendall(f"GET {path} HTTP/1.1\r\nHost: localhost\r\n\r\n".encode())
            readers.append((s, s.recv(300)))
        first = [head.split(b" ")[1] for _, head in readers]
        c(first[0] == b"200" and b"503" in first, "some get it, the others are told to wait", first)
        c(all(b"Retry-After" in head for _, head in readers if b" 503 " in head), "503: Retry-After")
        size = len(json.dumps(job["result"])) >> 10
        c(memory(d) - before < 20000 + 6 * size or "-" in os.path.basename(os.path.normpath(build)), "their memory is bounded", (before, memory(d), size))
        c.status(d.get("/healthz"), 200, "alive")
        for s, _ in readers:
            s.close()
        c(until(lambda: d.get(path + "?format=csv").status == 200), "room again when they are gone")


def memory(d):
    """The most that the daemon has had in memory, in KiB."""
    with open(f"/proc/{d.process.pid}/status", encoding="ascii") as f:
        return next(int(line.split()[1]) for line in f if line.startswith("VmHWM:"))


def evicted(build, c):
    """Results beyond their share of the disk go, the least recently used first; none is wrong."""
    with Daemon(build, "--cache-memory", "0", "--cache-disk", "400000") as d:
        requests = [moving(samples=300) for _ in range(30)]
        done = [d.ask("POST", "/v1/solve", r).json() for r in requests[:8]]
        first = d.ask("POST", "/v1/solve", requests[0])
        c(first.json().get("cached") is True, "cached at first", first.json().get("cached"))
        for r in requests[8:]:
            done.append(d.ask("POST", "/v1/solve", r).json())
            d.get("/v1/jobs/" + done[0]["id"])     # used all the time
        c(all(j["status"] == "done" for j in done), "all are solved")
        c(until(lambda: series(d)["sgad_results_evicted_total"] > 0), "results are evicted")
        folder = os.path.join(d.state, "sgad")
        c(os.path.getsize(os.path.join(folder, "cache.db")) < 1200000, "the file stays small", os.path.getsize(os.path.join(folder, "cache.db")))
        c(d.ask("POST", "/v1/solve", requests[0]).json()["cached"] is True, "what is used stays")
        for j, r in list(zip(done, requests))[1:4]:
            again = d.ask("POST", "/v1/solve", r).json()
            c(again["id"] == j["id"] and again["result"]["trajectory"]["rows"] == j["result"]["trajectory"]["rows"], "what went is computed again, the same")


ALL = [stages, logs, top, slowly, many, crowded, huge, evicted, measured, supervised]
