"""Large sparse motions beside IDA with KLU in the same run, at equal true error.

Ours: CPU of one solution, as the rows of a tradeoff have it. IDA: tests/bench/sparse.c, with its exact sparse Jacobian, the equations brought
to index 1 by hand. On both sides what is set up once and the consistent start are left out. Errors are those of 8 variables at the last time,
the largest, each over its size or 1, against IDA at 1e-12. A step beside its floor: one refactorization with a solve by KLU and one residual."""
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
SAMPLES, COMPARED = 10, 4     # the variables that sparse.c compares: so many points, two variables each
TOLERANCES = ["1e-4", "1e-5", "1e-6", "1e-7", "1e-8", "1e-9", "1e-10", "1e-11"]
REFERENCE = "1e-12"
DIGITS = (5, 7, 9)
STEP_AT = 1e-6


def web(n):
    asked, _ = large.web(n, want=("trajectory",), stop=0.005)     # the prey still grows then
    at = [(n * n - 1) * k // (COMPARED - 1) for k in range(COMPARED)]
    return asked, [f"{s}{k // n}_{k % n}" for k in at for s in "cp"]


def heat(n):
    asked, _ = large.heat(n, want=("trajectory",), spacing=1 / (n + 1))
    at = [1 + (n - 1) * k // (COMPARED - 1) for k in range(COMPARED)]
    return asked, [f"u{r}_{c}" for r in at for c in (1, (n + 1) // 2)]


def network(n):
    asked, _ = large.network(n, want=("trajectory",))
    at = [(n - 1) * k // (COMPARED - 1) for k in range(COMPARED)]
    return asked, [f"e{r}_{c}" for r in at for c in (1, 2)]


EVALUATIONS = {"radau": 1, "dop853": 12}     # of the field by a step: on its equations an implicit one has that at its end

# name: what it is, how it is asked for, method, n (with what a run of minutes has), most that ours may take in units of IDA's time
PROBLEMS = {
    "web": ("food web", web, "radau", (10, 20), 2),
    "heat": ("heat", heat, "radau", (30, 100), 1),
    "network": ("network", network, "dop853", (30, 60), 1),
}


def apart(values, exact):
    return max(abs(a - b) / max(abs(b), 1) for a, b in zip(values, exact))


def solve(build, asked):
    done = subprocess.run([os.path.join(build, "sga"), "solve", "-", "--json"], input=json.dumps(asked), capture_output=True, text=True, check=True, timeout=3600)
    return json.loads(done.stdout)


def curves(build, program, name, n):
    """Of ours, of IDA, and seconds of a step over its floor."""
    _, make, method, _, _ = PROBLEMS[name]
    asked, outputs = make(n)
    stop = asked["trajectory"]["stop"]
    lines = subprocess.run([program, name, str(n), str(stop), str(SAMPLES), "1", *TOLERANCES, REFERENCE],
                           capture_output=True, text=True, check=True, timeout=3600).stdout.split()
    found = [[float(v) for v in line.split(";")] for line in lines]
    exact, step = found.pop()[4:], None
    peer, ours = report.Curve(), report.Curve()
    for rtol, seconds, _, _, *values in found:
        if seconds > 0:
            peer.add(rtol, seconds, apart(values, exact))
    asked["trajectory"].update(samples=SAMPLES + 1, outputs=outputs)
    accuracy = {"rtol": 1e-6, "atol": 1e-6, "method": method, "arithmetic": "double"}
    for row in solve(build, {**asked, "want": ["tradeoff"], "accuracy": accuracy, "limits": {"seconds": 3000}})["tradeoff"]["rows"]:
        if "digits" in row and row.get("last"):
            ours.add(row["rtol"], row["seconds"], apart(row["last"], exact))
            if row["rtol"] == STEP_AT:
                step = row["seconds"] / row["evaluations"] * EVALUATIONS[method]
    return ours, peer, step, found[0][3]


def run(build, show, most=None):
    program = os.path.join(build, "bench", "sparse")
    subprocess.run([*shlex.split(os.environ.get("CC", "gcc")), "-std=gnu11", "-O2", "-Wall", "-Wextra", "-Werror", "-I/usr/include/suitesparse", "-o", program, os.path.join(HERE, "sparse.c"),
                    *"-lsundials_ida -lsundials_nvecserial -lsundials_sunmatrixsparse -lsundials_sunlinsolklu -lklu -lm".split()], check=True, timeout=120)
    for name, (text, _, method, sizes, target) in PROBLEMS.items():
        print(f"{text}, n x n points, by {method}, beside IDA with KLU")
        for n in sizes:
            ours, peer, step, floor = curves(build, program, name, n)
            for digits in DIGITS:
                a, b = ours.seconds(digits), peer.seconds(digits)
                what = f"{text}, {n} x {n}, {digits} digits: ours / IDA"
                if a is None or b is None:
                    show(what, "-", note=f"not reached by {'ours' if a is None else 'IDA'}")
                else:
                    show(what, f"{a / b:.2f}", f"<= {target}", a / b <= target, f"{1e3 * a:.1f} ms, {1e3 * b:.1f} ms")
            show(f"{text}, {n} x {n}: a step / a refactorization, solve and residual", f"{step / floor:.1f}", "<= 3", step / floor <= 3, f"{1e3 * step:.2f} ms, {1e3 * floor:.2f} ms")
