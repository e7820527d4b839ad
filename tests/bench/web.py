"""The food web of SUNDIALS' examples beside IDA with KLU in the same run, at equal true error.

Ours: CPU of one solution by implicit steps, as the rows of a tradeoff have it. IDA: tests/bench/web.c, with the exact sparse Jacobian. On
both sides what is set up once and the consistent start are left out. Errors are relative, the largest of 8 species at the last time, against
IDA at 1e-12."""
import json
import os
import shlex
import subprocess
import sys

sys.path.insert(0, os.path.dirname(os.path.abspath(__file__)))
sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), "ode"))
import large  # noqa: E402
import report  # noqa: E402

HERE = os.path.dirname(os.path.abspath(__file__))
STOP, SAMPLES, POINTS = 0.005, 10, 4     # the prey still grows then
TOLERANCES = ["1e-4", "1e-5", "1e-6", "1e-7", "1e-8", "1e-9", "1e-10"]
REFERENCE = "1e-12"
TARGET = 2


def request(n):
    asked, _ = large.web(n, want=("trajectory",), stop=STOP)
    at = [(n * n - 1) * k // (POINTS - 1) for k in range(POINTS)]
    asked["trajectory"].update(samples=SAMPLES + 1, outputs=[f"{s}{k // n}_{k % n}" for k in at for s in "cp"])
    return {**asked, "want": ["tradeoff"], "accuracy": {"rtol": 1e-6, "atol": 1e-6, "method": "radau", "arithmetic": "double"}, "limits": {"seconds": 600}}


def apart(values, exact):
    return max(abs(a - b) / abs(b) for a, b in zip(values, exact))


def curves(build, program, n):
    lines = subprocess.run([program, str(n), str(STOP), str(SAMPLES), *TOLERANCES, REFERENCE], capture_output=True, text=True, check=True, timeout=600).stdout.split()
    found = [[float(v) for v in line.split(";")] for line in lines]
    exact = found.pop()[3:]
    peer, ours = report.Curve(), report.Curve()
    for rtol, seconds, _, *values in found:
        if seconds > 0:
            peer.add(rtol, seconds, apart(values, exact))
    done = subprocess.run([os.path.join(build, "sga"), "solve", "-", "--json"], input=json.dumps(request(n)), capture_output=True, text=True, check=True, timeout=900)
    for row in json.loads(done.stdout)["tradeoff"]["rows"]:
        if "digits" in row:
            ours.add(row["rtol"], row["seconds"], apart(row["last"], exact))
    return ours, peer


def run(build, show):
    print("the food web on n x n points by implicit steps, beside IDA with KLU")
    program = os.path.join(build, "bench", "web")
    subprocess.run([*shlex.split(os.environ.get("CC", "gcc")), "-std=gnu11", "-O2", "-Wall", "-Wextra", "-Werror", "-I/usr/include/suitesparse", "-o", program, os.path.join(HERE, "web.c"),
                    *"-lsundials_ida -lsundials_nvecserial -lsundials_sunmatrixsparse -lsundials_sunlinsolklu -lklu -lm".split()], check=True, timeout=120)
    for n in (10, 20):
        ours, peer = curves(build, program, n)
        for digits in (5, 7, 9):
            a, b = ours.seconds(digits), peer.seconds(digits)
            what = f"{n} x {n} points, {digits} digits: ours / IDA"
            if a is None or b is None:
                show(what, "-", note=f"not reached by {'ours' if a is None else 'IDA'}")
            else:
                show(what, f"{a / b:.2f}", f"<= {TARGET}", a / b <= TARGET, f"{1e3 * a:.1f} ms, {1e3 * b:.1f} ms")
