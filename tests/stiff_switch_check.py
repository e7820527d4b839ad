"""Stiff motions with switches in double-double: stiff_switch_check.py BUILD_DIR

x' = -k (x - u(t)) with u a sum of kinks has a closed form, up to k = 10^9, where no explicit step goes on; also named as a signal, with a relay beside it that
turns by x, and in other units. Random systems with switches that turn by their states are solved by implicit steps, by those that are chosen, at other
tolerances and, where they are not stiff, by Taylor series: the same ends, and differences within the errors told. Roots of sizes are gone through where they
are 0, which has a closed form too. SGA_TEST_SEED, SGA_TEST_SCALE as everywhere."""
import random
import sys

import mpmath

from solver import Crash, Solver
from tally import Tally, build_folder, scaled, seed

KNOWN, RANDOM = 40, 40
ROWS, HOLDS = 7, 0.97
mpmath.mp.dps = 60


def exact(number):
    return mpmath.mpf(getattr(number, "text", number))


class Kinks:
    """u = sum of m |t - a|, and the x that follows it from x0 at 0."""

    def __init__(self, rng):
        self.k, self.x0, self.scale = 10 ** rng.randint(0, 9), rng.choice([0, 1, -2]), rng.choice([1, 1, 1000])
        self.terms = [(rng.choice([1, -1, 2, "1/2"]), rng.randint(1, 11)) for _ in range(rng.randint(1, 4))]

    @staticmethod
    def number(m):
        return mpmath.mpf(1) / 2 if m == "1/2" else mpmath.mpf(m)

    def follower(self, m, a, t):
        """For one term, from 0 at 0: x' = -k (x - m |t - a/4|)."""
        k, a = mpmath.mpf(self.k), mpmath.mpf(a) / 4

        def before(s):
            return m * (a - s) + m / k - (m * a + m / k) * mpmath.exp(-k * s)
        return before(t) if t <= a else m * (t - a) - m / k + (before(a) + m / k) * mpmath.exp(-k * (t - a))

    def x(self, t):
        parts = [self.follower(self.number(m), a, t) for m, a in self.terms]
        return self.scale * (self.x0 * mpmath.exp(-self.k * t) + mpmath.fsum(parts))

    def request(self, rng, method, tolerance):
        u = " + ".join(f"({m})*{rng.choice(['abs(t - {0}/4)', 'max(t - {0}/4, {0}/4 - t)', '-min(t - {0}/4, {0}/4 - t)']).format(a)}" for m, a in self.terms)
        variables, equations = ["x"], [f"x' = -{self.k}*(x - {self.scale}*({u}))"]
        if rng.random() < 0.5:
            variables, equations = ["x", "w"], [f"w = {u}", f"x' = -{self.k}*(x - {self.scale}*w)"]
        if rng.random() < 0.4:
            variables, equations = [*variables, "y"], [*equations, f"y' = if(x > {self.scale}/3, 1, -1) + abs(x)/{self.scale}"]
        order = rng.sample(range(len(variables)), len(variables))
        return {"system": {"form": "equations", "variables": [variables[i] for i in order], "equations": [equations[i] for i in order]}, "want": ["trajectory"],
                "accuracy": {"rtol": tolerance, "atol": tolerance, "arithmetic": "double-double", **method},
                "trajectory": {"start": 0, "stop": 3, "samples": ROWS, "initial": {"x": self.x0 * self.scale, **({"y": 1} if "y" in variables else {})}}}


def known(solver, tally, rng):
    held = []
    for n in range(scaled(KNOWN)):
        q, method, tolerance = Kinks(rng), rng.choice([{}, {}, {"method": "radau"}]), rng.choice([1e-16, 1e-18, 1e-21])
        request = q.request(rng, method, tolerance)
        try:
            answer, problem = solver.solve(request)
        except Crash as e:
            answer, problem = None, e
        label = f"kinks {n}, k = {q.k} {method} {tolerance}"
        t = answer and answer.get("trajectory")
        if not tally.check(t and not t["ended"] and len(t["rows"]) == ROWS, f"{label}: to its end", problem or t and t["ended"]):
            continue
        at = t["columns"].index("x")
        off = [abs(exact(row[at]) - q.x(exact(row[0]))) for row in t["rows"]]
        size = max(abs(q.x(exact(row[0]))) for row in t["rows"])
        tally.check(max(off) <= 20 * tolerance * max(size, 1), f"{label}: the closed form", [float(o) for o in off])
        held += [o <= e + 1e-31 * size for o, e in zip(off, t["errors"])]
    tally.check(sum(held) >= HOLDS * len(held), "errors hold", (sum(held), len(held)))


def signal(rng, names):
    a = f"({rng.choice(names)} - {rng.choice(['3/10', '1/2', '(-1/5)', 'sin(2*t)', 'cos(t)'])})"
    return rng.choice(["abs({0})", "max({0}, 0)", "min({0}, 2/5)", "abs(abs({0}) - 1/2)", "sign({0})*{0}^2", "if({0} > 0, {0}, -2*{0})"]).format(a)


def system(rng):
    names, k = ["x", "y", "z"][:rng.randint(1, 3)], rng.choice([1, 1, 10**3, 10**5, 10**7])
    equations = [f"x' = -{k}*(x - 7/10*sin({rng.randint(1, 4)}*t)) + {rng.choice(['1', str(k)])}*{signal(rng, names + ['t'])}"]
    equations += [f"{v}' = -{v} + {rng.choice(['1', '1/2', '(-1)'])}*{signal(rng, names + ['t'])} + cos({rng.randint(1, 4)}*t)/5" for v in names[1:]]
    return k, names, equations


def same(solver, tally, rng):
    """By two routes each."""
    held = []
    for n in range(scaled(RANDOM)):
        k, names, equations = system(rng)
        start, found = {v: rng.choice([0.25, 0.75, 1]) for v in names}, []
        ways = [({"method": "radau"}, 1e-25), ({"method": "radau"}, 1e-18), ({}, 1e-17)] + [({"method": "taylor"}, 1e-21)] * (k == 1)
        for method, tolerance in ways:
            try:
                answer, problem = solver.solve({
                    "system": {"form": "equations", "variables": names, "equations": equations}, "want": ["trajectory"],
                    "accuracy": {"rtol": tolerance, "atol": tolerance / 100, "arithmetic": "double-double", **method},
                    "trajectory": {"start": 0, "stop": 4, "samples": ROWS, "initial": start}})
            except Crash as e:
                answer, problem = None, e
            found.append((problem and str(problem), answer and answer.get("trajectory")))
        label = f"random {n}: {equations}"
        ends = [t and (t["ended"] or {}).get("reason") for _, t in found]
        if not tally.check(all(t for _, t in found) and len(set(ends)) == 1, f"{label}: the same end", [p for p, _ in found] + ends):
            continue
        fine = found[0][1]
        for (_, t), (_, tolerance) in zip(found[1:], ways[1:]):
            off = [(abs(exact(a) - exact(b)), e + f) for p, q, e, f in zip(fine["rows"], t["rows"], fine["errors"], t["errors"]) for a, b in zip(p[1:], q[1:])]
            held += [d <= 2 * e + 1e-30 for d, e in off]
            size = max(abs(x) for row in fine["rows"] for x in row[1:])
            tally.check(all(d <= 100 * tolerance * max(size, 1) for d, _ in off), f"{label}: within tolerances at {tolerance}", max(float(d) for d, _ in off))
    tally.check(sum(held) >= HOLDS * len(held), "errors of both ways hold", (sum(held), len(held)))


def roots(solver, tally, rng):
    """u' = -sqrt(|u|) - b comes to u = 0, where the field is continuous and has no derivative, at the time 2 r - 2 b log(1 + r/b), r = sqrt(u), and leaves it as it came."""
    for n in range(scaled(9)):
        a, b, u0, stiff = rng.choice(["1/2", "t/3"]), rng.choice([1, 2, 4]), mpmath.mpf(1) / rng.choice([2, 4, 10]), n % 3 == 2
        method = [{"method": "taylor"}, {"method": "radau"}, {}][n % 3]
        drift = 0 if a == "1/2" else mpmath.mpf(1) / 3
        start = u0 + (mpmath.mpf(1) / 2 if a == "1/2" else 0)
        equations = [f"x' = -sqrt(abs(x - {a})) - {b}" + (" + 1/3" if drift else "")] + ["z' = -10^5*(z - max(x, -1/5))"] * stiff
        answer, problem = solver.solve({
            "system": {"form": "equations", "variables": ["x", "z"][:1 + stiff], "equations": equations}, "want": ["trajectory"],
            "accuracy": {"rtol": 1e-17, "atol": 1e-19, "arithmetic": "double-double", **method},
            "trajectory": {"start": 0, "stop": 2, "samples": 9, "initial": {"x": mpmath.nstr(start, 40), **({"z": 0} if stiff else {})}}})
        t = answer and answer.get("trajectory")
        label = f"roots {n}: {equations} {method}"
        if not tally.check(t and not t["ended"], f"{label}: to its end", problem or t and t["ended"]):
            continue

        def way(u):
            r = mpmath.sqrt(abs(u))
            return 2 * r - 2 * b * mpmath.log(1 + r / b)
        at, off = t["columns"].index("x"), []
        for row in t["rows"]:
            time = exact(row[0])
            u = exact(row[at]) - (time / 3 if drift else mpmath.mpf(1) / 2)
            passed = way(u0) - way(u) if u > 0 else way(u0) + way(u)
            off.append(abs(passed - time) * (mpmath.sqrt(abs(u)) + b))      # of time: of u by its rate
        tally.check(max(off) < 1e-15, f"{label}: the closed form", [float(o) for o in off])


def main():
    tally, solver, rng = Tally("stiff_switches"), Solver(build_folder()), random.Random(seed(20261130))
    known(solver, tally, rng)
    same(solver, tally, rng)
    roots(solver, tally, rng)
    return tally.end()


if __name__ == "__main__":
    sys.exit(main())
