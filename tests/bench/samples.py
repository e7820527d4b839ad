"""1,001 samples of 7 columns: what they take to leave the daemon, against what printf takes to
format their numbers."""
import array
import http.client
import json
import os
import subprocess
import time

SAMPLES = 1001


def request(samples, amplitude):
    identity = [[int(i == j) for j in range(6)] for i in range(6)]
    return {"system": {"form": "quasilinear", "variables": ["a", "b", "c", "d", "e", "f"], "A": identity,
                       "alpha": ["b", "-a", "d", "-2*c", "f", "-3*e"]},
            "want": ["trajectory"], "trajectory": {"stop": 10, "samples": samples, "initial": {"a": amplitude, "c": 0.5, "e": 0.25}}}


def solve(connection, body):
    begun = time.perf_counter()
    connection.request("POST", "/v1/solve", json.dumps(body), {"Content-Type": "application/json"})
    reply = connection.getresponse()
    text = reply.read()
    took = time.perf_counter() - begun
    job = json.loads(text)
    if reply.status != 200 or job["status"] != "done":
        raise RuntimeError(text[:300].decode())
    return took, job


def fetch(connection, job, form):
    begun = time.perf_counter()
    connection.request("GET", f"/v1/jobs/{job['id']}/trajectory?format={form}")
    reply = connection.getresponse()
    text = reply.read()
    took = time.perf_counter() - begun
    if reply.status != 200 or len(text) < SAMPLES * 7 * 2:
        raise RuntimeError(text[:300].decode())
    return took


def formatting(folder, job):
    path = os.path.join(folder, "numbers.bin")
    values = array.array("d", (v for row in job["result"]["trajectory"]["rows"] for v in row))
    with open(path, "wb") as f:
        values.tofile(f)
    run = subprocess.run([os.path.join(folder, "numbers"), path], capture_output=True, text=True, timeout=600, check=True)
    return json.loads(run.stdout)


def run(daemon, folder, show):
    print("1,001 samples of 7 columns")
    connection = http.client.HTTPConnection("127.0.0.1", daemon.port, timeout=60)
    job = solve(connection, request(SAMPLES, 1))[1]
    cost = formatting(folder, job)
    show("printf / writer of results, per number", f"{cost['printf'] / cost['writer']:.1f}", "> 1", cost["printf"] > cost["writer"],
         f"{1e9 * cost['printf'] / cost['count']:.0f} ns, {1e9 * cost['writer'] / cost['count']:.0f} ns")
    for form in ("json", "csv", "ndjson"):
        took = min(fetch(connection, job, form) for _ in range(100))
        show(f"printf / the samples as {form}, request to reply", f"{cost['printf'] / took:.1f}", "> 1", cost["printf"] > took,
             f"{1e3 * cost['printf']:.2f} ms, {1e3 * took:.2f} ms")
    many, few = (min(solve(connection, request(samples, 1 + k / 1000))[0] for k in range(1, 41)) for samples in (SAMPLES, 2))
    show("printf / what 999 more samples add to a job", f"{cost['printf'] / (many - few):.1f}", "> 1", cost["printf"] > many - few,
         f"{1e3 * (many - few):.2f} ms, of which the integrator's dense output is a part")
    connection.close()
