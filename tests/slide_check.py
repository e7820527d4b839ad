"""Slides against a peer: slide_check.py BUILD_DIR

Random systems of two to four variables with one or two relays, linear between them and driven, by a sine or by tables (in the field, with steps, and in
the relays' arguments). The motion along surfaces is held against SciPy's Radau on the same system with each relay as a steep tanh: in the limit that is
Filippov's motion (along one surface; along two it is that of the relays as unknowns). Each is asked for again with its relays spelt otherwise, and those
that differ in their start only, or in a parameter, as the sets of one sweep. Chains of blocks with dry friction that are at rest begin on four to eight
surfaces at once, with mass matrices. Some are asked for in double-double, and again tighter. SGA_TEST_SEED, SGA_TEST_SCALE."""
import random
import sys
from fractions import Fraction

import numpy as np
from scipy.integrate import solve_ivp

from solver import Solver
from tally import Tally, build_folder, scaled, seed

STEEP = 1e-7          # width of a tanh: the motions differ by some times as much
SPELT = ["sign({0})", "if({0} > 0, 1, -1)", "(2*step({0}) - 1)", "-sign(-2*({0}))"]


class Relays:
    def __init__(self, rng):
        self.n, m = rng.choice([2, 3, 4]), rng.choice([1, 1, 2])
        def draw(a, b, *shape):
            return np.reshape([round(rng.uniform(a, b), 2) for _ in range(int(np.prod(shape)))], shape)
        self.A, self.b, self.c, self.d = draw(-1.5, 1, self.n, self.n), draw(-2, 2, m, self.n), draw(-1, 1, m, self.n), draw(-0.5, 0.5, self.n)
        self.offset, self.start = draw(-0.3, 0.3, m), draw(-1, 1, self.n)
        self.tables = rng.random() < 0.5
        self.knots, self.level, self.aim = [0, 0.4, 1, 1.7, 2.2, 3], draw(-2, 2, 6), draw(-0.6, 0.6, 6)
        self.aimed, self.backwards = draw(-1, 1, m), rng.random() < 0.25

    def request(self, spelling):
        names = [f"x{k}" for k in range(self.n)]
        aim = [f" + ({a})*aim" if self.tables else "" for a in self.aimed]
        relay = [spelling.format(" + ".join(f"({c})*{v}" for c, v in zip(row, names)) + f" + ({o})" + a) for row, o, a in zip(self.c, self.offset, aim)]
        drive = "level" if self.tables else "sin(3*t)"
        equations = [f"{v}' = " + " + ".join(f"({a})*{u}" for a, u in zip(row, names)) + "".join(f" + ({b})*{r}" for b, r in zip(self.b[:, i], relay)) + f" + ({self.d[i]})*{drive}"
                     for i, (v, row) in enumerate(zip(names, self.A))]
        # values jump at the second knot and at the last but one
        steps = sorted(self.knots + [self.knots[1], self.knots[-2]])
        tables = {"tables": {"aim": {"times": self.knots, "values": list(self.aim), "interpolation": "linear"},
                             "level": {"times": steps, "values": [self.level[0], self.level[0], *self.level[1:5], self.level[5], self.level[5]], "interpolation": "linear"}}}
        return {"system": {"form": "equations", "variables": names, "equations": equations, **(tables if self.tables else {})}, "want": ["trajectory"], "limits": {"seconds": 60},
                "trajectory": {"start": 3 * self.backwards, "stop": 3 * (not self.backwards), "samples": 4, "initial": dict(zip(names, self.start)), "sliding": True}, "accuracy": {"rtol": 1e-8}}

    def driven(self, t, inside):
        """The drive and what is added to the arguments at a time, by the piece that `inside` lies in."""
        if not self.tables:
            return np.sin(3 * t), 0
        k = max(i for i in range(5) if self.knots[i] <= inside)
        part = (t - self.knots[k]) / (self.knots[k + 1] - self.knots[k])
        from_, to = [*self.level[:4], self.level[5]][k], [self.level[0], *self.level[2:5], self.level[5]][k]
        return from_ + part * (to - from_), self.aimed * (self.aim[k] + part * (self.aim[k + 1] - self.aim[k]))

    def peer(self):
        """Rows at 0, 1, 2, 3, or the other way round, piece by piece."""
        rows, x = {3 * self.backwards: self.start}, self.start
        ends = sorted({*self.knots, 1, 2} if self.tables else {0, 1, 2, 3}, reverse=self.backwards)
        for a, b in zip(ends, ends[1:]):
            def field(t, x, inside=(a + b) / 2):
                drive, aim = self.driven(t, inside)
                return self.A @ x + np.tanh((self.c @ x + self.offset + aim) / STEEP) @ self.b + self.d * drive

            def slope(t, x, inside=(a + b) / 2):
                g = self.c @ x + self.offset + self.driven(t, inside)[1]
                return self.A + self.b.T @ (self.c / STEEP / np.cosh(np.minimum(np.abs(g / STEEP), 300))[:, None] ** 2)
            x = rows[b] = solve_ivp(field, [a, b], x, method="Radau", jac=slope, rtol=1e-9, atol=1e-11).y[:, -1]
        return np.array([rows[3 - k if self.backwards else k] for k in range(4)])


class Blocks:
    """Masses at rest with springs, dampers and dry friction, coupled by a mass matrix, and driven."""

    def __init__(self, rng):
        n = self.n = rng.choice([4, 5, 6, 8])
        self.K = np.array([[round(rng.uniform(1.5, 3), 2) if i == k else -round(rng.uniform(0, 1), 2) if abs(i - k) == 1 else 0 for k in range(n)] for i in range(n)])
        self.M = np.array([[round(rng.uniform(1, 2), 2) if i == k else 0.2 if abs(i - k) == 1 and rng.random() < 0.5 else 0 for k in range(n)] for i in range(n)])
        self.M = np.maximum(self.M, self.M.T)
        self.mu, self.force = ([round(rng.uniform(a, b), 2) for _ in range(n)] for a, b in ((0.3, 1.5), (-4, 4)))
        self.start, self.backwards = np.zeros(2 * n), False

    def request(self, spelling):
        x, v = ([f"{name}{k}" for k in range(self.n)] for name in "xv")
        def row(entries, names):
            return " + ".join(f"({e})*{u}" for e, u in zip(entries, names) if e)
        equations = [f"{a}' = {b}" for a, b in zip(x, v)]
        equations += [f"{row(self.M[k], [u + chr(39) for u in v])} = ({self.force[k]})*sin(2*t) - ({row(self.K[k], x)}) - 0.1*{v[k]} - ({self.mu[k]})*" + spelling.format(v[k]) for k in range(self.n)]
        return {"system": {"form": "equations", "variables": x + v, "equations": equations}, "want": ["trajectory"], "limits": {"seconds": 60},
                "trajectory": {"stop": 3, "samples": 4, "initial": {u: 0 for u in x + v}, "sliding": True}, "accuracy": {"rtol": 1e-8}}

    def peer(self):
        n, inverse = self.n, np.linalg.inv(self.M)

        def field(t, z):
            x, v = z[:n], z[n:]
            return np.concatenate([v, inverse @ (np.array(self.force) * np.sin(2 * t) - self.K @ x - 0.1 * v - self.mu * np.tanh(v / STEEP))])

        def slope(_, z):
            steep = 0.1 + np.array(self.mu) / STEEP / np.cosh(np.minimum(np.abs(z[n:] / STEEP), 300)) ** 2
            return np.block([[np.zeros((n, n)), np.eye(n)], [-inverse @ self.K, -inverse @ np.diag(steep)]])
        return solve_ivp(field, [0, 3], self.start, method="Radau", jac=slope, rtol=1e-9, atol=1e-11, t_eval=[0, 1, 2, 3]).y.T


def one(tally, solver, label, relays, spelling):
    """The rows, and how many slides, of a motion that is the peer's."""
    result, wrong = solver.solve(relays.request(spelling))
    t = result and result["trajectory"]
    if t and t["ended"] and t["ended"]["reason"] == "accumulation":       # switches turn ever faster towards where two surfaces meet
        return None
    if not tally.check(t and t["ended"] is None and t["accuracy_reached"], f"{label}: reaches its end", wrong or t["ended"]):
        return None
    rows, peer = np.array(t["rows"])[:, 1:], relays.peer()
    off = np.abs(rows - peer).max() / max(1, np.abs(peer).max())
    tally.check(off < 300 * STEEP, f"{label}: the peer's motion", (off, relays.request(spelling)))
    for s in t["slides"]:
        tally.check(all(abs(v) <= 1 + 1e-6 for v in s["switch"]), f"{label}: the switch lies between its values", s)
    return rows, np.array(t["column_errors"]), len(t["slides"])


def swept(tally, solver, label, relays, rng):
    """Starts and a parameter as sets of one sweep, against requests of their own."""
    def alike(a, b):
        return len(a["rows"]) == len(b["rows"]) and len(a["slides"]) == len(b["slides"]) and np.allclose(a["rows"], b["rows"], rtol=1e-6, atol=1e-6) and np.allclose(
            [s["from"] for s in a["slides"]], [s["from"] for s in b["slides"]], atol=1e-6)
    request = relays.request(SPELT[0])
    request["system"]["parameters"] = {"gain": 1}
    request["system"]["equations"] = [e + " + (gain - 1)*x0" for e in request["system"]["equations"]]
    for sets in ([{"initial": {v: round(x + rng.uniform(-0.5, 0.5), 2) for v, x in request["trajectory"]["initial"].items()}} for _ in range(2)],
                 [{"parameters": {"gain": round(rng.uniform(0.5, 1.5), 2)}} for _ in range(2)]):
        answer, wrong = solver.solve({**request, "sweep": sets})
        for n, one in enumerate(sets):
            own = {**request, "system": {**request["system"], "parameters": one.get("parameters", {"gain": 1})},
                   "trajectory": {**request["trajectory"], "initial": one.get("initial", request["trajectory"]["initial"])}}
            result, refused = solver.solve(own)
            a, b = answer and answer["trajectories"][n], result and result["trajectory"]
            tally.check(a and b and "rows" in a and alike(a, b),
                        f"{label}: a set of a sweep is what it is alone", (request, sets, wrong or a, refused or b))


def fine(tally, solver, label, relays, double):
    """Double-double against double, and against itself at tighter tolerances."""
    rows = []
    for tol in (1e-17, 1e-21):
        result, wrong = solver.solve({**relays.request(SPELT[0]), "accuracy": {"rtol": tol, "atol": tol, "arithmetic": "double-double"}})
        t = result and result["trajectory"]
        if not tally.check(t and t["ended"] is None and t["arithmetic"] == "double-double", f"{label}: in double-double", wrong or t["ended"]):
            return 0
        rows.append(([[Fraction(getattr(v, "text", str(v))) for v in row[1:]] for row in t["rows"]], t["errors"], len(t["slides"])))
    apart = [max(float(abs(a - b)) for a, b in zip(p, q)) for p, q in zip(rows[0][0], rows[1][0])]
    tally.check((np.abs(np.array(rows[1][0], dtype=float) - double[0]) <= 2 * double[1] + 1e-12).all() and double[2] == rows[0][2] == rows[1][2], f"{label}: as in double", (rows[1][0], double))
    boxed(tally, solver, label, relays, rows[1])
    return sum(a <= e for a, e in zip(apart, rows[0][1])) / len(apart)


def boxed(tally, solver, label, relays, fine):
    """Balls hold what double-double has, to its errors, with the slides at the same times; they may end where more surfaces than one are met at once."""
    result, wrong = solver.solve({**relays.request(SPELT[0]), "accuracy": {"rtol": 1e-21, "atol": 1e-21, "arithmetic": "ball"}})
    t = result and result["trajectory"]
    if not tally.check(t and (t["ended"] is None or t["ended"]["reason"] == "not_enclosed"), f"{label}: in balls", wrong or t["ended"]):
        return
    tally.boxed += 1
    tally.boxed_whole += t["ended"] is None
    rows = [[Fraction(getattr(v, "text", str(v))) for v in row[1:]] for row in t["rows"]]
    off = [float(abs(a - b)) for p, q, radii, e in zip(rows, fine[0], t["radii"], fine[1]) for a, b, r in zip(p, q, radii) if abs(a - b) > r + 8 * e + 1e-25]
    tally.check(not off and (t["ended"] or len(t["slides"]) == fine[2]), f"{label}: balls hold double-double", (off, t["slides"], fine[2]))
    tally.check(all(s["error"] < 1e-14 for s in t["slides"]), f"{label}: slides at times that are known", t["slides"])


def main():
    tally, solver, slides, held = Tally("slides"), Solver(build_folder()), 0, []
    tally.boxed = tally.boxed_whole = 0
    rng = random.Random(seed(20261125))
    for n in range(scaled(40)):
        relays = Relays(rng)
        a = one(tally, solver, f"relays {n}", relays, SPELT[0])
        b = one(tally, solver, f"relays {n}, spelt otherwise", relays, rng.choice(SPELT[1:]))
        if n % 4 == 0:
            swept(tally, solver, f"relays {n}", relays, rng)
        if a and n % 4 == 1:
            held.append(fine(tally, solver, f"relays {n}", relays, a))
        if a and b:
            slides += a[2]
            tally.check(a[2] == b[2] and (np.abs(a[0] - b[0]).max(axis=0) <= 2 * (a[1] + b[1]) + 1e-9).all(), f"relays {n}: the same however spelt", (a, b))
    tally.check(sum(held) >= 0.9 * len(held), "errors in double-double hold", held)
    tally.check(tally.boxed_whole >= 0.6 * tally.boxed, "most are enclosed to the end", (tally.boxed_whole, tally.boxed))
    for n in range(scaled(8)):
        a = one(tally, solver, f"blocks {n}", Blocks(rng), SPELT[0])
        tally.check(a and a[2] >= 4, f"blocks {n}: they stick at first", a)
    if scaled(6) > 1:                 # of a few there may be none
        tally.check(slides >= scaled(6), "some of them slide", slides)
    return tally.end()


if __name__ == "__main__":
    sys.exit(main())
