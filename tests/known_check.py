"""Systems that are made from their solutions: known_check.py BUILD_DIR

A solution is chosen (functions of time, some with a parameter), equations are made that it satisfies, of index 0 to 3, and then disguised: the variables are changed,
equations are added to others with factors that may vanish on the way, and everything is put in another order. The index and the number of motions are what they were
made to be, no motion ends, and samples, times of events and derivatives by the parameter are beside mpmath's: an estimate holds for 98.5 % of all numbers, and no error
is ten times as large. SGA_TEST_SEED repeats a run, SGA_TEST_SCALE makes it longer."""
import json
import random
import sys

import mpmath
import sympy as sp

from solver import Solver
from tally import Tally, build_folder, scaled, seed

SYSTEMS = 90
T, P, P_VALUE = sp.Symbol("t"), sp.Symbol("p"), sp.Rational(3, 2)
KINDS = ["double"] * 3 + ["events"] * 3 + ["sensitivities", "double-double", "ball"]
ROUNDINGS = {"double-double": 1e-30, "ball": 1e-30}
STOP = {"ball": 1}
MOST_STEPS = 20000      # of motions that are smooth over the time that they take; most need some dozens
AXIS = 400      # places where an event's function is looked at for its zeros


def function(rng):
    a, c = sp.Rational(rng.randint(1, 6), 2), sp.Rational(rng.randint(-4, 4), 2)
    return rng.choice([sp.sin(a * T + c), sp.cos(a * T), sp.exp(-a * T / 2), T**2 / 4 - T + c, 1 / (2 + a * T), sp.sqrt(1 + a * T),
                       sp.log(2 + T), sp.tanh(T - a / 2), a, sp.exp(-(T - 1)**2 * a)])


def of_parameter(rng):
    return rng.choice([sp.sin(P * T), sp.cos(P * T), sp.exp(-P * T / 2), P * T**2 / 4 - T, 1 / (2 + P * T), sp.sqrt(1 + P * T), sp.log(2 + T) * P])


def small(rng, over):
    """A function of some of these variables."""
    if not over:
        return sp.Integer(0)
    x, y, c = rng.choice(over), rng.choice(over), sp.Rational(rng.choice([-2, -1, 1, 2, 3]), rng.choice([1, 2]))
    return rng.choice([sp.Integer(0), c * x, c * x * y / 2, c * sp.sin(x), c * x**2 / 2])


class Known:
    """Equations in the variables x (texts), their solution (expressions), and the index."""

    def __init__(self, rng, kind):
        self.rng, self.n = rng, rng.randint(2, 6)
        self.z, self.dz = sp.symbols(f"z1:{self.n + 1}"), sp.symbols(f"d1:{self.n + 1}")
        self.g = [of_parameter(rng) if kind == "sensitivities" and rng.random() < 0.6 else function(rng) for _ in range(self.n)]
        self.equations, self.index = [], 0
        pinned = ["algebraic", "pair", "chain"]      # by time: no value at the start has a part in the derivatives by a parameter
        self.plain(pinned if kind == "sensitivities" else ["free", "free", *pinned])
        self.change_variables()
        self.mix_rows()

    def plain(self, kinds):
        i, z, dz, g = 0, self.z, self.dz, self.g
        while i < self.n:
            kind = self.rng.choice(kinds)
            if kind == "free":
                rate = self.rng.choice([0, -1, -2, sp.Rational(1, 2), 0, -30])
                self.equations.append(dz[i] - sp.diff(g[i], T) - rate * (z[i] - g[i]))
                i += 1
            elif kind == "algebraic":
                self.equations.append(z[i] - g[i])
                self.index = max(self.index, 1)
                i += 1
            elif kind == "pair" and i + 1 < self.n:
                h = small(self.rng, [z[i]])
                g[i + 1] = sp.diff(g[i], T) - h.subs(z[i], g[i])
                self.equations += [dz[i] - z[i + 1] - h, z[i] - g[i]]
                self.index = max(self.index, 2)
                i += 2
            elif kind == "chain" and i + 2 < self.n:
                h, k = small(self.rng, [z[i]]), small(self.rng, [z[i], z[i + 1]])
                g[i + 1] = sp.diff(g[i], T) - h.subs(z[i], g[i])
                g[i + 2] = sp.diff(g[i + 1], T) - k.subs({z[i]: g[i], z[i + 1]: g[i + 1]}, simultaneous=True)
                self.equations += [dz[i] - z[i + 1] - h, dz[i + 1] - z[i + 2] - k, z[i] - g[i]]
                self.index = 3
                i += 3

    def change_variables(self):
        """x_m = z_m + a function of those before it in some order."""
        self.x, rate = sp.symbols(f"x1:{self.n + 1}"), sp.symbols(f"r1:{self.n + 1}")
        back, self.solution, order = {}, [None] * self.n, list(range(self.n))
        self.rng.shuffle(order)
        for k, m in enumerate(order):
            f = small(self.rng, [self.z[q] for q in order[:k]])
            self.solution[m] = self.g[m] + f.subs({self.z[q]: self.g[q] for q in order[:k]}, simultaneous=True)
            back[self.z[m]] = self.x[m] - f.subs(back, simultaneous=True)
        rates = {self.dz[m]: sum(sp.diff(back[self.z[m]], x) * r for x, r in zip(self.x, rate)) for m in range(self.n)}
        named = {r: sp.Symbol(f"{x}_RATE") for x, r in zip(self.x, rate)}
        self.equations = [e.subs(rates, simultaneous=True).subs(back, simultaneous=True).subs(named) for e in self.equations]

    def mix_rows(self):
        rng = self.rng
        for _ in range(rng.randint(0, self.n)):
            i, k = rng.sample(range(self.n), 2)
            by = rng.choice([1, -1, 2, rng.choice(self.x), sp.cos(T), 1 + rng.choice(self.x)**2])
            self.equations[i] += by * self.equations[k]
        rng.shuffle(self.equations)
        order = list(range(self.n))
        rng.shuffle(order)
        self.x, self.solution = [self.x[m] for m in order], [self.solution[m] for m in order]

    def system(self):
        texts = [str(e).replace("_RATE", "'").replace("**", "^") + " = 0" for e in self.equations]
        return {"form": "equations", "variables": [str(x) for x in self.x], "equations": texts}


def zeros(f, level, stop):
    place = [mpmath.mpf(k) * stop / AXIS for k in range(AXIS + 1)]
    value = [f(t) - level for t in place]
    return [mpmath.findroot(lambda t: f(t) - level, (place[k], place[k + 1]), solver="anderson", tol=1e-28)
            for k in range(AXIS) if value[k] * value[k + 1] < 0]


class Check:
    def __init__(self, tally, solver):
        self.tally, self.solver, self.numbers, self.held, self.asked = tally, solver, 0, 0, 0

    def number(self, label, value, truth, estimate, rounding):
        off = abs(mpmath.mpf(getattr(value, "text", value)) - truth)
        self.numbers += 1
        self.held += off <= estimate + rounding * (1 + abs(truth))
        self.tally.check(off <= 10 * estimate + rounding * (1 + abs(truth)), label, f"{value} is off by {mpmath.nstr(off, 3)}, estimated {estimate:.3g}")

    def one(self, number, rng):
        kind = rng.choice(KINDS)
        known = Known(rng, kind)
        try:
            at = [sp.lambdify(T, e.subs(P, P_VALUE), "mpmath") for e in known.solution]
            stop = mpmath.mpf(STOP.get(kind, 2))
            truth = [f(stop) for f in at]
        except (ValueError, ZeroDivisionError):
            return
        names, digits = [str(x) for x in known.x], kind in ROUNDINGS
        start = {name: mpmath.nstr(f(mpmath.mpf(0)), 40) if digits else float(f(mpmath.mpf(0))) for name, f in zip(names, at)}
        request = {"system": known.system(), "want": ["index", "trajectory"], "limits": {"seconds": 60},
                   "trajectory": {"stop": float(stop), "samples": 3, "initial": start}, "accuracy": {"rtol": rng.choice([1e-4, 1e-6, 1e-8, 1e-10])}}
        if digits:
            request["accuracy"] = {"rtol": 1e-18, "atol": 1e-18, "arithmetic": kind}
        expected = []
        if kind == "events":
            which = rng.randrange(known.n)
            level = round(float(at[which](stop * rng.uniform(0.2, 0.8))), 3) + 0.0004
            request["trajectory"]["events"] = [{"name": "level", "expression": f"{names[which]} - ({level!r})"}]
            expected = zeros(at[which], level, stop)
        if kind == "sensitivities":
            request["system"]["parameters"] = {"p": float(P_VALUE)}
            request["trajectory"]["sensitivities"] = {"parameters": ["p"]}
        label = f"{kind} {number}"
        self.asked += 1
        answer, problem = self.solver.solve(request)
        if not self.tally.check(answer is not None, label, f"{problem}: {json.dumps(request)}"):
            return
        self.compare(label, known, answer, truth, expected, ROUNDINGS.get(kind, 1e-13), request)
        if kind == "sensitivities":
            self.derivatives(label, known, answer["trajectory"], stop, request)

    def compare(self, label, known, answer, truth, expected, rounding, request):
        said = json.dumps(request)
        check = self.tally.check
        check(answer["verdict"] in ("unique", "isolated"), f"{label}: verdict", f"{answer['verdict']}: {said}")
        check(len(answer["dimensions"]["generations"]) == known.index, f"{label}: index", f"{answer['dimensions']}, should be {known.index}: {said}")
        motion = answer["trajectory"]
        if not check(motion["ended"] is None, f"{label}: it ends", f"{motion['ended']}: {said}"):
            return
        check(answer["work"].get("steps", 0) <= MOST_STEPS, f"{label}: steps", f"{answer['work']}: {said}")
        check(motion["accuracy_reached"], f"{label}: accuracy", f"{motion.get('accuracy_shortfall')}: {said}")
        for x, value, true, estimate in zip(motion["columns"][1:], motion["rows"][-1][1:], truth, motion["column_errors"]):
            self.number(f"{label}: {x} of {said}", value, true, estimate, rounding)
        happened = motion.get("events", [])
        if check(len(happened) == len(expected), f"{label}: events", f"{happened}, should be at {expected}: {said}"):
            for event, true in zip(happened, expected):
                self.number(f"{label}: time of {said}", event["t"], true, event["error"], rounding)

    def derivatives(self, label, known, motion, stop, request):
        told = motion["sensitivities"]
        for x, f in zip(known.x, known.solution):
            k = told["columns"].index(f"d({x})/d(p)")
            true = sp.lambdify(T, sp.diff(f, P).subs(P, P_VALUE), "mpmath")(stop)
            self.number(f"{label}: d({x})/d(p) of {json.dumps(request)}", told["rows"][-1][k], true, told["column_errors"][k - 1], 1e-12)


def main():
    tally = Tally("known")
    check, first = Check(tally, Solver(build_folder())), seed(20261128)
    mpmath.mp.dps = 45
    systems = scaled(SYSTEMS)
    for number in range(systems):
        check.one(number, random.Random(f"{first} {number}"))
    tally.check(check.asked >= 0.9 * systems, "systems", f"{check.asked} of {systems} have a solution with values")
    tally.check(check.held >= 0.985 * check.numbers, "estimates", f"{check.held} of {check.numbers} hold")
    print(f"{check.held} of {check.numbers} estimates hold")
    return tally.end()


if __name__ == "__main__":
    sys.exit(main())
