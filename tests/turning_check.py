"""Motions whose pivots come to 0 while the rank stays, against closed forms: turning_check.py BUILD_DIR

Random linear systems E x' + A x = f with E = P N Q, A = P (R Q + N Q') (Kunkel & Mehrmann, Differential-Algebraic Equations, 2006, chapter 3): N of index 2 to 4 beside a part that
moves, P and Q products of plane rotations whose angles are functions of time, so that each entry passes 0 again and again. Solutions are written down first; sympy makes the equations.
None may end early, at any tolerance, and the errors told hold. Beside them a four-bar driven by what equations give late: pivots that come with a later generation. SGA_TEST_SEED,
SGA_TEST_SCALE."""
import random
import sys

import mpmath as mp
import sympy as sp

from solver import Solver
from tally import Tally, build_folder, scaled, seed

T = sp.Symbol("t")
SAMPLES = 7
ACCURACY = [{"rtol": 1e-6, "atol": 1e-6}, {"rtol": 1e-9, "atol": 1e-9}, {"rtol": 1e-12, "atol": 1e-12}, {"rtol": 1e-14, "atol": 1e-14, "arithmetic": "double-double"}]


def turning(n, rng):
    m = sp.eye(n)
    for _ in range(rng.randint(1, n)):
        i, j = rng.sample(range(n), 2)
        angle, plane = rng.choice([T, 2 * T, T / 2, T + 1, 3 * T / 2, 1 - T, T * T / 4]), sp.eye(n)
        plane[i, i] = plane[j, j] = sp.cos(angle)
        plane[i, j], plane[j, i] = -sp.sin(angle), sp.sin(angle)
        m = m * plane
    return m


def system(rng):
    """A request, and the solution by variable."""
    index, moving = rng.randint(2, 4), rng.randint(0, 1)
    n = index + moving
    N, R, y = sp.zeros(n, n), sp.eye(n), [None] * n
    right = [rng.choice([sp.sin(T) + 2, sp.cos(2 * T) - 3, sp.sin(3 * T) + 1, sp.exp(-T / 2), T * sp.cos(T) + 2]) for _ in range(n)]
    for i in reversed(range(index)):
        if i + 1 < index:
            N[i, i + 1] = 1
        y[i] = right[i] - (sp.diff(y[i + 1], T) if i + 1 < index else 0)
    for i in range(index, n):
        N[i, i], R[i, i], y[i] = 1, sp.Rational(1, 2), sp.exp(-T / 2) * rng.randint(1, 3) + sp.sin(T)
        right[i] = sp.diff(y[i], T) + y[i] / 2
    P, Q = turning(n, rng), turning(n, rng)
    x, E, A, f = Q.T * sp.Matrix(y), P * N * Q, P * (R * Q + N * sp.diff(Q, T)), P * sp.Matrix(right)

    def text(e):
        return str(e).replace("**", "^")
    equations = [" + ".join([f"({text(E[i, j])})*x{j}'" for j in range(n) if E[i, j] != 0] + [f"({text(A[i, j])})*x{j}" for j in range(n) if A[i, j] != 0]) + " = " + text(f[i])
                 for i in range(n)]
    names = [f"x{j}" for j in range(n)]
    rng.shuffle(equations)
    rng.shuffle(names)
    true = {f"x{j}": sp.lambdify(T, x[j], "mpmath") for j in range(n)}
    return {"form": "equations", "variables": names, "equations": equations}, true


def errors(t, true, stop):
    """Rows whose error is larger than told, and than a rounding of what is there; and rows."""
    beyond = 0
    for k, (row, told) in enumerate(zip(t["rows"], t["errors"])):
        at = mp.mpf(stop) * k / (SAMPLES - 1)
        exact = [true[c](at) if c in true else None for c in t["columns"][1:]]
        off = max(abs(mp.mpf(getattr(v, "text", str(v))) - e) for v, e in zip(row[1:], exact) if e is not None)
        beyond += told is None or off > told + mp.mpf(2) ** -52 * (1 + max(abs(e) for e in exact if e is not None))
    return beyond, len(t["rows"])


def four_bar(rng):
    """Driven by b1, which b1' = c1 - a1, a1' = b1 and a1 = sin(w t) give one after the other; cos(b1) passes 0."""
    w = rng.randint(2, 4)
    s = {"form": "equations", "variables": ["a1", "b1", "c1", "a3", "b3", "c3"],
         "equations": ["b1' = c1 - a1", f"a1 = sin({w}*t)", "cos(a3) + 2*cos(b3) = 2 + 3*sin(b1)/20", "c3 = a3''", "sin(a3) + 2*sin(b3) = 1", "a1' = b1"]}
    rng.shuffle(s["equations"])
    return s, {"a1": lambda t: mp.sin(w * t), "b1": lambda t: w * mp.cos(w * t), "c1": lambda t: (1 - w * w) * mp.sin(w * t)}


def check(tally, solver, label, made, stop, accuracy):
    s, true = made
    start = {v: float(true[v](mp.mpf(0))) for v in s["variables"] if v in true} if len(true) == len(s["variables"]) else {}
    answer, wrong = solver.solve({"system": s, "want": ["trajectory"], "accuracy": accuracy, "limits": {"seconds": 120},
                                  "trajectory": {"stop": stop, "samples": SAMPLES, "initial": start}})
    t = answer and answer["trajectory"]
    if not tally.check(t and t["ended"] is None, f"{label}: comes to its end", wrong or (t["ended"], s)):
        return 0, 0
    return errors(t, true, stop)


def main():
    mp.mp.dps = 40
    tally, solver, rng, beyond, rows = Tally("turning"), Solver(build_folder()), random.Random(seed(20261126)), 0, 0
    for k in range(max(3, scaled(5))):
        made, bar = system(rng), four_bar(rng)
        for accuracy in ACCURACY:
            for name, m, stop in (("turning coefficients", made, 6), ("four-bar", bar, 1)):
                b, r = check(tally, solver, f"{name} {k}, {accuracy}", m, stop, accuracy)
                beyond, rows = beyond + b, rows + r
    tally.check(beyond <= rows / 50, "errors hold", (beyond, rows))
    print(f"{rows} rows, {beyond} beyond their error")
    return tally.end()


if __name__ == "__main__":
    sys.exit(main())
