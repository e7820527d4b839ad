"""Tables in double-double and in balls: tables_longer.py, a part of tables_check.py.

The interpolant as exact rational pieces by a route of its own (second derivatives at the knots, solved over the rationals), the
motion by Taylor series of 50 digits from knot to knot."""
import bisect
from fractions import Fraction

import mpmath as mp

import jets

DIGITS = 50


def exact(x):
    """What a sample means: text, or the decimal of a number."""
    return Fraction(x) if isinstance(x, str) else Fraction(repr(x))


def solve(rows, right):
    """Gauss elimination over the rationals."""
    work, n = [list(r) + [b] for r, b in zip(rows, right)], len(rows)
    for k in range(n):
        p = next(i for i in range(k, n) if work[i][k])
        work[k], work[p] = work[p], work[k]
        work[k] = [a / work[k][k] for a in work[k]]
        for i in range(n):
            if i != k and work[i][k]:
                work[i] = [a - work[i][k] * b for a, b in zip(work[i], work[k])]
    return [r[-1] for r in work]


def bends(t, y):
    """Second derivatives of the spline whose third ones do not jump at the second knot and the last but one."""
    n = len(t)
    h = [b - a for a, b in zip(t, t[1:])]
    chord = [(b - a) / s for a, b, s in zip(y, y[1:], h)]
    rows, right = [[Fraction(0)] * n for _ in range(n)], [Fraction(0)] * n
    if n == 2:
        return [Fraction(0)] * 2
    for i in range(1, n - 1):
        rows[i][i - 1:i + 2] = [h[i - 1] / 6, (h[i - 1] + h[i]) / 3, h[i] / 6]
        right[i] = chord[i] - chord[i - 1]
    if n == 3:
        rows[0][:2], rows[2][1:] = [Fraction(1), Fraction(-1)], [Fraction(1), Fraction(-1)]
    else:
        rows[0][:3] = [1 / h[0], -1 / h[0] - 1 / h[1], 1 / h[1]]
        rows[-1][-3:] = [1 / h[-2], -1 / h[-2] - 1 / h[-1], 1 / h[-1]]
    return solve(rows, right)


class Pieces:
    """Polynomials over intervals: (from, to, coefficients in the time since from)."""

    def __init__(self, given):
        t, y = [exact(x) for x in given["times"]], [exact(x) for x in given["values"]]
        cuts = [0] + [i for i in range(1, len(t)) if t[i] == t[i - 1]] + [len(t)]
        self.piece = []
        for a, b in zip(cuts, cuts[1:]):
            self.add(t[a:b], y[a:b], given.get("interpolation", "cubic") == "linear")

    def add(self, t, y, linear):
        m = [Fraction(0)] * len(t) if linear else bends(t, y)
        for k in range(len(t) - 1):
            h = t[k + 1] - t[k]
            slope = (y[k + 1] - y[k]) / h - h * (2 * m[k] + m[k + 1]) / 6
            self.piece.append((t[k], t[k + 1], [y[k], slope, m[k] / 2, (m[k + 1] - m[k]) / (6 * h)]))

    def at(self, t):
        """The later piece at a knot."""
        return self.piece[max(bisect.bisect_right([p[0] for p in self.piece], t) - 1, 0)]

    def value(self, order, t):
        a, _, c = self.at(t)
        for _ in range(order):
            c = [i * v for i, v in enumerate(c)][1:]
        return sum((v * (t - a) ** i for i, v in enumerate(c)), Fraction(0))


def number(q):
    return mp.mpf(q.numerator) / q.denominator


def follow(tables, field, x, start, samples):
    """The state at exact times, by series in each piece, either way. A field gets jets: time, state, and by table [u, u', u'']."""
    back = samples[-1] < start
    sign = -1 if back else 1
    knots = {sign * t for u in tables for p in u.piece for t in p[:2]}
    stops = sorted({k for k in knots if sign * start < k < sign * samples[-1]} | {sign * s for s in samples})
    now, known = sign * start, {start: [mp.mpf(v) for v in x]}
    for stop in stops:
        middle = sign * (now + stop) / 2

        def rates(s, y, now=now, middle=middle):
            u = []
            for table in tables:
                a, _, c = table.at(middle)
                since = s * sign + number(sign * now - a)          # s begins at 0
                d = [mp.mpf(1) * number(v) for v in c]
                u.append([d[0] + since * (d[1] + since * (d[2] + since * d[3])), d[1] + since * (2 * d[2] + since * (3 * d[3])), 2 * d[2] + since * (6 * d[3])])
            return [r * sign for r in field(y, u)]
        if stop > now and x:
            x = jets.taylor(rates, 0, x, [number(stop - now)], DIGITS)[0]
        now = stop
        known[sign * stop] = x
    return [known[s] for s in samples]


# variables, equations, field of the state, columns of the state and of the tables' values, start, initial values, kinds, where the
# tables may step
def pendulum(x, u):
    s, c = jets.sin_cos(x[0])
    return [x[1], s * -9 - u[0][2] * c]


SYSTEMS = [
    (["x", "y"], ["x' = u - x/2", "y = x + u^2"], lambda x, u: [u[0][0] - x[0] * mp.mpf("0.5")], lambda x, u: [x[0], x[0] + u[0][0] ** 2], 1, ("linear", "cubic"), False),
    (["x", "v"], ["x' = v", "v' = u - x^3 - v/4"], lambda x, u: [x[1], u[0][0] - x[0] ** 3 - x[1] * mp.mpf("0.25")], lambda x, u: x, 2, ("linear", "cubic"), True),
    (["x"], ["x' = u*x + w"], lambda x, u: [u[0][0] * x[0] + u[1][0]], lambda x, u: x, 1, ("linear", "cubic"), True),
    (["x", "y"], ["x' = y + u'", "y' = -4*x"], lambda x, u: [x[1] + u[0][1], x[0] * -4], lambda x, u: x, 2, ("linear", "cubic"), False),
    (["x", "s"], ["x' = s", "s = u - x"], lambda x, u: [u[0][0] - x[0]], lambda x, u: [x[0], u[0][0] - x[0]], 1, ("linear", "cubic"), True),
    (["x", "y"], ["x' = sin(y)", "y' = u - x"], lambda x, u: [jets.sin_cos(x[1])[0], u[0][0] - x[0]], lambda x, u: x, 2, ("linear", "cubic"), True),
    (["x", "y"], ["x' = -300*(x - u)", "y' = x - y"], lambda x, u: [(x[0] - u[0][0]) * -300, x[0] - x[1]], lambda x, u: x, 2, ("cubic",), False),
    (["a", "b", "c"], ["a' = b", "b' = c", "a = u"], lambda x, u: [], lambda x, u: [u[0][0], u[0][1], u[0][2]], 0, ("cubic",), False),
    (["x", "y", "l"], ["x'' = -l*(x - u)", "y'' = -l*y - 9", "(x - u)^2 + y^2 = 1"], pendulum,
     lambda x, u: [u[0][0] + mp.sin(x[0]), -mp.cos(x[0])], 2, ("cubic",), False),
]


class Longer:
    def __init__(self, tally, solver, rng):
        self.tally, self.solver, self.rng = tally, solver, rng
        self.held = self.values = self.given_up = 0

    def table(self, kinds, steps):
        """Samples as texts and as numbers, some of them a step."""
        rng = self.rng
        times = sorted(rng.sample(range(1, 60), rng.randint(1, 8)))
        times = ["0"] + [rng.choice([f"{t}/20", t / 20]) for t in times] + [3]
        for _ in range(rng.randint(0, 2) if steps else 0):
            k = rng.randrange(len(times))
            if 0 < k < len(times) - 1 and times.count(times[k]) == 1:
                times.insert(k, times[k])
        kind = rng.choice(kinds)
        return {"times": times, "values": [rng.choice([f"{rng.randint(-9, 9)}/7", round(rng.gauss(0, 0.6), 3)]) for _ in times], "interpolation": kind}

    def one(self, k):
        rng = self.rng
        variables, equations, field, columns, size, kinds, steps = rng.choice(SYSTEMS)
        given = {n: self.table(kinds, steps) for n in ("u", "w") if n == "u" or any("w" in e for e in equations)}
        tables = [Pieces(g) for g in given.values()]
        back = rng.random() < 0.25 and "l" not in variables and "-300" not in equations[0]
        start, stop = (Fraction(3), Fraction(0)) if back else (Fraction(0), Fraction(3))
        inner = [p[0] for u in tables for p in u.piece]
        samples = {Fraction(rng.randint(1, 299), 100) for _ in range(4)} | {rng.choice(inner)} | {stop}
        samples = sorted(samples - {start}, reverse=back)
        x = [mp.mpf(rng.randint(-2, 2)) for _ in range(size)]
        initial = {n: int(v) for n, v in zip(variables, x)}
        if "l" in variables:
            x = [mp.mpf(0), mp.mpf(0)]
            initial = {"x": str(tables[0].value(0, start)), "y": -1, "x'": str(tables[0].value(1, start)), "y'": 0}
        arithmetic = rng.choice(["double-double", "ball", "ball"])
        accuracy = {"arithmetic": arithmetic, "rtol": 10.0 ** -rng.randint(12, 26 if arithmetic == "ball" else 24)}
        accuracy["atol"] = accuracy["rtol"]
        if arithmetic == "double-double":
            accuracy["method"] = rng.choice(["auto", "taylor", "radau"])
        request = {"system": {"form": "equations", "variables": variables, "equations": equations, "tables": given}, "want": ["trajectory"], "accuracy": accuracy,
                   "trajectory": {"start": str(start), "times": [str(s) for s in samples], "initial": initial, "outputs": variables[:2] if "l" in variables else variables}}
        name = f"longer {k}: {equations} {[g['interpolation'] for g in given.values()]} {accuracy}{' back' if back else ''}"
        result, fault = self.solver.solve(request)
        with mp.workdps(DIGITS):
            self.compare(name, result, fault, samples, tables, columns, lambda: follow(tables, field, x, start, samples), accuracy)

    def compare(self, name, result, fault, samples, tables, columns, states, accuracy):
        if not self.tally.check(result, name, str(fault)):
            return
        t, ball = result["trajectory"], accuracy["arithmetic"] == "ball"
        self.tally.check(t["arithmetic"] == accuracy["arithmetic"] and len(t["rows"]) == len(samples), f"{name}: reached", str(t["ended"]))
        self.given_up += not t["accuracy_reached"]
        jumps = len(t["columns"]) == 3 and "s" in t["columns"]
        for row, bounds, s, x in zip(t["rows"], t.get("radii") or t["errors"], samples, states()):
            should = columns(x, [[number(u.value(i, s)) for i in range(3)] for u in tables])
            bounds = bounds if ball else [bounds] * len(should)
            for j, (a, b, r) in enumerate(zip(row[1:], should, bounds)):
                if jumps and j == 1 and any(s in p[:2] for u in tables for p in u.piece):
                    continue                          # it may jump there
                off = abs(mp.mpf(getattr(a, "text", repr(a))) - b)
                self.values += 1
                self.held += off <= r * (1 + mp.mpf(10) ** -10) + mp.mpf(10) ** -44
                if ball:
                    self.tally.check(off <= r * (1 + mp.mpf(10) ** -10) + mp.mpf(10) ** -44, f"{name}: encloses at {s}, {j}", f"off by {mp.nstr(off, 3)}, {r}")
                if t["accuracy_reached"]:
                    self.tally.check(off <= 1.01 * (accuracy["atol"] + accuracy["rtol"] * abs(b)), f"{name}: at {s}, {j}", f"off by {mp.nstr(off, 3)}")
