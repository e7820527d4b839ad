"""Functions given by samples, and sweeps, by two routes: tables_check.py BUILD_DIR

Samples of polynomials that the interpolation reproduces, against the same request with the polynomial
written out; random signals, against Taylor series of 30 digits from knot to knot; signals of steps in
conditions; and sweeps of parameters against a request for each set."""
import random
import sys
from fractions import Fraction

import mpmath as mp

import jets
from solver import Solver
from table import Table
from tables_longer import Longer
from tally import Tally, build_folder, scaled, seed


def shown(x):
    return f"{x.numerator}/{x.denominator}"


class Twins:
    """A request with a table u of polynomial values, and the same with the polynomial."""

    # equations with U, dU, ddU for the function and its derivatives; initial values; derivatives that must not jump
    SYSTEMS = [
        (["x", "y"], ["x' = U - x*y", "y = x + U"], {"x": "1/2"}, 0),
        (["x", "y"], ["x' = y", "y = U*x - x^3"], {"x": 1}, 0),
        (["x", "y", "l"], ["x'' = -l*(x - U)", "y'' = -l*y - 9", "(x - U)^2 + y^2 = 1"], {"x": "U", "y": -1, "x'": "dU", "y'": 0}, 2),
        (["x", "w"], ["x' = x*w + dU", "x^2 = (2 + U^2)^2"], {"x": 3}, 2),
        (["x", "y"], ["x' = sin(x) + dU*y", "y' = -y + U^2"], {"x": 1, "y": 1}, 0),
        (["x", "y", "z"], ["x = U + y", "y' = z - dU", "z' = -y"], {"y": 1}, 0),
        (["a", "b", "c"], ["a' = b", "b' = c", "a = U"], {}, 2),
        (["x", "y"], ["der(U*x) = y", "y' = -x"], {"x": 1, "y": 0}, 0),
    ]

    def __init__(self, tally, solver, rng):
        self.tally, self.solver, self.rng = tally, solver, rng

    def one(self, k):
        rng = self.rng
        variables, equations, initial, smooth = rng.choice(self.SYSTEMS)
        linear = smooth == 0 and rng.random() < 0.4
        degree = 1 if linear else 3
        c = [Fraction(rng.randint(2, 6))] + [Fraction(rng.randint(-9, 9), 10) for _ in range(degree)]
        knots = sorted(rng.sample(range(1, 200), rng.randint(degree + 1, 14)))
        times = [Fraction(0)] + [Fraction(x, 100) for x in knots] + [Fraction(2)]
        table = {"times": [shown(t) for t in times], "values": [shown(sum(a * t ** i for i, a in enumerate(c))) for t in times],
                 "interpolation": "linear" if linear else "cubic"}
        poly = [" + ".join(f"({shown(a)})*t^{i}" if i else f"({shown(a)})" for i, a in enumerate(d)) for d in derivatives(c)]
        back = rng.random() < 0.2
        there = [sum(a * Fraction(2 * back) ** i for i, a in enumerate(d)) for d in derivatives(c)]
        initial = {n: shown(there[("U", "dU").index(v)]) if v in ("U", "dU") else v for n, v in initial.items()}
        base = {"want": ["constraints", "index", "gauge", "trajectory"], "accuracy": {"rtol": 1e-9, "atol": 1e-11, "method": rng.choice(["auto", "auto", "taylor"])},
                "trajectory": {"start": 2 if back else 0, "stop": 0 if back else 2, "samples": 9, "initial": initial}}
        answers = []
        for names in (["u", "u'", "u''"], [f"({p})" for p in poly]):
            texts = [e.replace("ddU", names[2]).replace("dU", names[1]).replace("U", names[0]) for e in equations]
            system = {"form": "equations", "variables": variables, "equations": texts}
            if names[0] == "u":
                system["tables"] = {"u": table}
            answers.append(self.solver.solve({**base, "system": system}))
        self.compare(f"twin {k}: {equations} {table['interpolation']}{' back' if back else ''}", *answers)

    def compare(self, name, one, other):
        (a, fault), (b, other_fault) = one, other
        if fault or other_fault:
            self.tally.check((fault or {}).get("code") == (other_fault or {}).get("code"), name, f"{fault} {other_fault}")
            return
        for key in ("verdict", "dimensions", "index"):
            self.tally.check(a[key] == b[key], f"{name}: {key}", f"{a[key]} {b[key]}")
        self.tally.check([c["generation"] for c in a["constraints"]] == [c["generation"] for c in b["constraints"]], f"{name}: constraints")
        s, t = a["trajectory"], b["trajectory"]
        self.tally.check((s["ended"] or {}).get("reason") == (t["ended"] or {}).get("reason"), f"{name}: ended", f"{s['ended']} {t['ended']}")
        for r, q, e, f in zip(s["rows"], t["rows"], s["errors"], t["errors"]):
            off = max(abs(x - y) for x, y in zip(r, q))
            size = 1 + max(abs(x) for x in q)
            self.tally.check(off <= 2e-9 * size, f"{name}: at {r[0]}", f"differ by {off:.3g}, errors {e} {f}")


def derivatives(c):
    out = [c]
    for _ in range(2):
        c = [i * a for i, a in enumerate(c)][1:] or [Fraction(0)]
        out.append(c)
    return out


class Signals:
    """Random samples: Taylor series from knot to knot."""

    def __init__(self, tally, solver, rng):
        self.tally, self.solver, self.rng = tally, solver, rng
        self.held = self.samples = self.given_up = 0

    # equations, columns from the reduced state, reduced field (jets: time, state, u with derivatives), start
    def systems(self):
        def pendulum(t, x, u):
            s, c = jets.sin_cos(x[0])
            return [x[1], -9 * s - u[2] * c]

        def seen(x, u):
            return [u[0] + mp.sin(x[0]), -mp.cos(x[0])]
        yield (["x", "y"], ["x' = -x^3/4 + u - y", "y = x*u"], lambda t, x, u: [-x[0] ** 3 * mp.mpf("0.25") + u[0] - x[0] * u[0]],
               lambda x, u: [x[0], x[0] * u[0]], [1], {"x": 1}, ("linear", "cubic"), ["x", "y"])
        yield (["x", "y", "l"], ["x'' = -l*(x - u)", "y'' = -l*y - 9", "(x - u)^2 + y^2 = 1"], pendulum, seen, None, None, ("cubic",), ["x", "y"])
        yield (["x", "y"], ["x' = y + u'", "y' = -4*x"], lambda t, x, u: [x[1] + u[1], -4 * x[0]],
               lambda x, u: x, [1, 0], {"x": 1, "y": 0}, ("linear", "cubic"), ["x", "y"])

    def one(self, k):
        rng = self.rng
        variables, equations, field, columns, start, initial, kinds, outputs = rng.choice(list(self.systems()))
        n = rng.randint(4, 12)
        times = [0.0] + sorted(rng.uniform(0.05, 2.95) for _ in range(n)) + [3.0]
        given = {"times": times, "values": [round(rng.gauss(0, 0.3), 3) for _ in times], "interpolation": rng.choice(kinds)}
        u = Table(given)
        if start is None:       # the pendulum hangs at rest, its pivot moves
            start = [mp.mpf(0), mp.mpf(0)]
            initial = {"x": given["values"][0], "y": -1, "x'": repr(float(u.value(1, 0))), "y'": 0}
        samples = sorted(rng.uniform(0, 3) for _ in range(7)) + [3.0]
        if "l" in variables:    # theta' = (x' - u') / cos theta: the start is a double, theta' is not quite 0
            start = [mp.mpf(0), mp.mpf(initial["x'"]) - u.value(1, 0)]
        accuracy = {"rtol": 10.0 ** -rng.randint(5, 11)}
        accuracy["atol"] = accuracy["rtol"]
        accuracy["method"] = rng.choice(["auto", "taylor", "taylor", "radau"])
        result, fault = self.solver.solve({"system": {"form": "equations", "variables": variables, "equations": equations, "tables": {"u": given}},
                                           "want": ["trajectory"], "accuracy": accuracy,
                                           "trajectory": {"start": 0, "times": samples, "initial": initial, "outputs": outputs}})
        name = f"signal {k}: {equations} {given['interpolation']} {accuracy['method']} {accuracy['rtol']}"
        if not self.tally.check(result, name, str(fault)):
            return
        t = result["trajectory"]
        self.tally.check(len(t["rows"]) == len(samples), f"{name}: reached", str(t["ended"]))
        if not t["accuracy_reached"]:       # a pendulum that is shaken to rounding level
            self.given_up += 1
        for row, estimate, x in zip(t["rows"], t["errors"], self.reference(u, field, start, samples)):
            should = columns(x, [u.value(i, row[0]) for i in range(3)])
            worst = max(abs(mp.mpf(a) - b) for a, b in zip(row[1:], should))
            self.samples += 1
            self.held += worst <= estimate
            allowed = max(accuracy["atol"] + accuracy["rtol"] * abs(b) for b in should)
            self.tally.check(worst <= allowed or not t["accuracy_reached"], f"{name}: at {row[0]}", f"off by {mp.nstr(worst, 3)}, {mp.nstr(allowed, 3)} allowed")

    @staticmethod
    def reference(u, field, x, samples):
        stops = sorted(set([float(t) for t in u.t[1:]] + samples))
        at, known = mp.mpf(0), {}
        for stop in stops:
            # the polynomial of this piece, around its middle
            mid = (at + mp.mpf(stop)) / 2
            c = [u.value(i, mid) / mp.factorial(i) for i in range(4)]

            def rates(t, y, c=c, mid=mid):
                s = t - mid
                return field(t, y, [c[0] + s * (c[1] + s * (c[2] + s * c[3])), c[1] + s * (2 * c[2] + s * 3 * c[3]), 2 * c[2] + s * 6 * c[3]])
            if stop > at:
                x = jets.taylor(rates, at, x, [stop], 25)[0]
            at = mp.mpf(stop)
            known[stop] = x
        return [known[s] for s in samples]


class Sweeps:
    """Sweeps of parameters, special values among them, against a request for each set."""

    # variables, equations, parameters (all swept), initial values, rates
    SYSTEMS = [
        (["x", "y"], ["p*x' + q*y' = -x", "q*x' + p*y' = -y"], "pq", {"x": 1, "y": 2}, {}),
        (["x", "y", "z"], ["x' = p*y + q*z", "y' = -x", "r*z = x - p*y"], "pqr", {"x": 1, "y": 1}, {}),
        (["x", "y", "l"], ["x'' = -l*x + q", "y'' = -l*y - p", "x^2 + r*y^2 = 1"], "pqr", {"x": 1, "y": 0}, {}),
        (["x", "y"], ["p*x' = x - q*y", "y' = r*y - x"], "pqr", {"x": 1, "y": 1}, {}),
        (["x", "y", "w"], ["x' = w + p*x", "q*w + r*w^3 = y", "y' = -y"], "pqr", {"x": 1, "y": "1/2"}, {}),
        (["x", "y", "z"], ["x' = y + p*z", "x = q*t", "z' = r*z - 1"], "pqr", {"z": 1}, {}),
        (["x", "y"], ["x' + p*y' = q*x"], "pq", {"x": 1, "y": 0}, {"y": "q"}),
        (["x", "y"], ["p*x = q", "y' = x + r"], "pqr", {"y": 1}, {}),
        (["x", "y", "z"], ["p*x' = y", "q*y' = z", "x - r*z = 1"], "pqr", {"x": 1}, {}),
        (["x", "y"], ["exp(p*x) * x' = y", "y' + q*x' = r*x"], "pqr", {"x": 1, "y": 1}, {}),
        (["x", "y", "z"], ["x*y = p", "x' + y' = q*z", "z' = r"], "pqr", {"x": 1, "y": 1}, {}),
        (["x", "y", "z"], ["x^2 + p*y^2 = q", "z' = x + r", "y' = 1"], "pqr", {"x": 1, "y": 0}, {}),
        (["a", "b", "c", "d"], ["a' = b", "b' = p*c + q*d", "a = sin(t)", "c = r*d"], "pqr", {}, {}),
    ]
    VALUES = ["-1", "0", "1", "1/2", "2", "-3/4", "0"]

    def __init__(self, tally, solver, rng):
        self.tally, self.solver, self.rng = tally, solver, rng
        self.analyses = {"own": 0, "shared": 0}

    def one(self, k):
        rng = self.rng
        variables, equations, names, initial, rates = rng.choice(self.SYSTEMS)
        sets = [{n: rng.choice(self.VALUES) for n in names} for _ in range(5)]
        system = {"form": "equations", "variables": variables, "equations": equations, "parameters": dict.fromkeys(names)}
        trajectory = {"start": 0, "stop": 1, "samples": 4, "initial": initial}
        if rates:
            trajectory["gauge"] = {"rates": rates}
        base = {"system": system, "want": ["trajectory"], "trajectory": trajectory}
        name = f"sweep {k}: {equations}"
        result, fault = self.solver.solve({**base, "sweep": [{"parameters": s} for s in sets]})
        if not result:
            self.tally.check(fault["code"] in ("not_supported", "undecided"), name, str(fault))
            return
        for s, one in zip(sets, result["trajectories"]):
            alone, problem = self.solver.solve({**base, "system": {**system, "parameters": s}})
            self.compare(f"{name} at {s}", one, alone and alone["trajectory"], problem)

    def compare(self, label, one, other, problem):
        if "error" in one or problem:
            code, should = one.get("error", {}).get("code"), (problem or {}).get("code")
            self.tally.check(code == should, label, f"{one.get('error')} {problem}")
            return
        self.analyses[one["analysis"]] += 1
        self.tally.check(one["gauge"] == other["gauge"], f"{label}: gauge", f"{one['gauge']} {other['gauge']}")
        ends = [(t["ended"] or {}).get("reason") for t in (one, other)]
        self.tally.check(ends[0] == ends[1] and len(one["rows"]) == len(other["rows"]), f"{label}: ended", str(ends))
        for r, q in zip(one["rows"], other["rows"]):
            off = max(abs(x - y) / (1e-10 + 1e-8 * abs(y)) for x, y in zip(r, q))
            self.tally.check(off <= 2, f"{label}: at {r[0]} ({one['analysis']})", f"{r} {q}")


class Digital:
    """Signals that are constant between steps, also on the very edge of a condition, against the sum over the pieces."""

    CONDITIONS = {"u > {c}": lambda u, c: u > c, "u >= {c}": lambda u, c: u >= c, "not u > {c}": lambda u, c: u <= c, "u == {c}": lambda u, c: u == c,
                  "u != {c}": lambda u, c: u != c, "{c} < u or u == 0": lambda u, c: u > c or u == 0, "u <= {c} and u > 0": lambda u, c: 0 < u <= c}

    def __init__(self, tally, solver, rng):
        self.tally, self.solver, self.rng = tally, solver, rng

    def one(self, k):
        rng = self.rng
        levels = [rng.randint(0, 2)]
        for _ in range(rng.randint(1, 6)):
            levels.append(rng.choice([v for v in (0, 1, 2) if v != levels[-1]]))
        stops = list(range(len(levels) + 1))
        times, values = [0], [levels[0]]
        for i, level in enumerate(levels[1:], 1):
            times += [i, i]
            values += [levels[i - 1], level]
        text, holds = rng.choice(list(self.CONDITIONS.items()))
        c, yes, no = rng.randint(0, 2), rng.choice(["1", "sqrt(u + 1)"]), rng.choice(["2", "log(3 - u)", "-1"])
        value = {"1": lambda u: 1, "2": lambda u: 2, "-1": lambda u: -1, "sqrt(u + 1)": lambda u: mp.sqrt(u + 1), "log(3 - u)": lambda u: mp.log(3 - u)}
        condition = text.format(c=c)
        back = rng.random() < 0.3
        rates = [value[yes if holds(u, c) else no](u) for u in levels]
        if back:
            stops.reverse()
            rates = [-r for r in reversed(rates)]
        times, values = times + [len(levels)], values + [levels[-1]]
        name = f"digital {k}: if({condition}, {yes}, {no}) of {levels}{' back' if back else ''}"
        result, fault = self.solver.solve({
            "system": {"form": "equations", "variables": ["x"], "equations": [f"x' = if({condition}, {yes}, {no})"],
                       "tables": {"u": {"times": times, "values": values, "interpolation": rng.choice(["linear", "cubic"])}}},
            "want": ["trajectory"], "trajectory": {"start": stops[0], "stop": stops[-1], "samples": len(stops), "initial": {"x": 0}}})
        if not self.tally.check(result, name, str(fault)):
            return
        t, x = result["trajectory"], mp.mpf(0)
        self.tally.check(t["ended"] is None and len(t["rows"]) == len(stops), f"{name}: reached", str(t["ended"]))
        for row, rate in zip(t["rows"], [0] + rates):
            x += rate
            self.tally.check(abs(row[1] - x) <= 1e-7, f"{name}: at {row[0]}", f"{row[1]} {mp.nstr(x, 12)}")


def long_table(tally, solver):
    """As many knots as are allowed."""
    n = 100000
    rng = random.Random(3)
    table = {"times": [i / 1000 for i in range(n)], "values": [round(rng.gauss(0, 1), 3) for _ in range(n)], "interpolation": "linear"}
    u = Table(table)
    result, fault = solver.solve({"system": {"form": "equations", "variables": ["x"], "tables": {"u": table}, "equations": ["x' = u'"]},
                                  "want": ["trajectory"], "trajectory": {"start": 0, "stop": 99.999, "samples": 1001, "initial": {"x": repr(table["values"][0])}}})
    tally.check(result, "long table", str(fault))
    if result:
        t = result["trajectory"]
        off = max(abs(r[1] - float(u.value(0, r[0]))) for r in t["rows"])
        tally.check(len(t["rows"]) == 1001 and off <= max(t["errors"]) <= 1e-8, "long table: x = u", f"off by {off:.3g}, {max(t['errors']):.3g}")


def main():
    tally = Tally("tables")
    solver = Solver(build_folder())
    rng = random.Random(seed(20261121))
    twins, signals = Twins(tally, solver, rng), Signals(tally, solver, rng)
    for k in range(scaled(60)):
        twins.one(k)
    for k in range(scaled(25)):
        signals.one(k)
    tally.check(signals.held >= 0.95 * signals.samples, "estimates of signals hold", f"{signals.held} of {signals.samples}")
    tally.check(signals.given_up <= 0.1 * scaled(25), "accuracy of signals", f"{signals.given_up} times not reached")
    sweeps = Sweeps(tally, solver, rng)
    for k in range(scaled(40)):
        sweeps.one(k)
    tally.check(min(sweeps.analyses.values()) > 0 or scaled(40) < 40, "both kinds of sets", str(sweeps.analyses))
    digital = Digital(tally, solver, rng)
    for k in range(scaled(60)):
        digital.one(k)
    longer = Longer(tally, solver, rng)
    for k in range(scaled(40)):
        longer.one(k)
    tally.check(longer.held >= 0.98 * longer.values, "estimates in longer numbers hold", f"{longer.held} of {longer.values}")
    tally.check(longer.given_up <= 0.1 * scaled(40), "accuracy in longer numbers", f"{longer.given_up} times not reached")
    long_table(tally, solver)
    return tally.end()


if __name__ == "__main__":
    sys.exit(main())
