"""Trajectories in ball arithmetic against solutions known by other ways: enclosures.py BUILD_DIR [NAME...]

Every number of an answer comes with a radius, and the true value must be that near: no exception is allowed. The truth:
the references of tests/cases/trajectory_reference.json, closed forms to 50 digits, and Taylor series (jets.py) of random
systems. Where no proof is possible the answer must end or be refused."""
import json
import os
import random
import sys

import mpmath as mp

import jets
from enclosures_events import backwards, random_events, touches
from enclosures_sets import known_sets, random_bounces, samples_at_events
from enclosures_sides import random_air, random_fields, random_friction, side_of_abs, sides_not_taken, sides_swept
from enclosures_starts import known_starts, random_starts
from solver import Solver
from tally import ROOT, Tally, build_folder, scaled, seed

DIGITS = 50
# explicit steps are as short as the fastest rate asks: of these only the first times are reached soon
STIFF = {"reference: stiff linear": 2, "reference: prothero and robinson": 1, "reference: nonlinear prothero and robinson": 0,
         "reference: kaps": 0, "reference: robertson": 0}


def outside(t, rows, slack=0):
    """The first place where the truth is not inside: (row, column, distance / radius), or None. slack: error of the
    truth itself, relative."""
    for i, (got, radii, should) in enumerate(zip(t["rows"], t["radii"], rows)):
        for k, (x, r, s) in enumerate(zip(got[1:], radii, should)):
            far = abs(mp.mpf(str(x)) - mp.mpf(s))
            if not far <= mp.mpf(str(r)) + slack * abs(mp.mpf(s)):
                return i, k, mp.nstr(far, 3), str(r)
    return None


class Enclosures:
    def __init__(self, tally, patterns):
        self.tally, self.patterns = tally, patterns
        self.compared = self.ended_early = 0
        self.solver = Solver(build_folder(), number=mp.mpf)

    def wanted(self, name):
        return not self.patterns or any(p in name for p in self.patterns)

    def solve(self, name, system, trajectory, rtol, limits=None):
        request = {"system": system, "want": ["trajectory"], "trajectory": trajectory,
                   "accuracy": {"rtol": rtol, "atol": rtol, "arithmetic": "ball"}, **({"limits": limits} if limits else {})}
        result, problem = self.solver.solve(request)
        if not self.tally.check(result is not None, name, json.dumps(problem)):
            return None
        return result["trajectory"]

    def hold(self, name, t, rows, rtol, slack=0):
        """All rows are there, as narrow as asked, and hold the truth."""
        if t is None:
            return
        self.tally.check(t["ended"] is None and len(t["rows"]) == len(rows), f"{name}: all rows", str(t["ended"]))
        self.tally.check(t["arithmetic"] == "ball" and t["method"] == "taylor", f"{name}: method")
        self.tally.check(t["accuracy_reached"], f"{name}: accuracy", str(t.get("accuracy_shortfall")))
        for row, radii, error in zip(t["rows"], t["radii"], t["errors"]):
            self.tally.check(all(r <= mp.mpf(rtol) * (1 + abs(x)) * mp.mpf("1.2") for x, r in zip(row[1:], radii)), f"{name}: radii at {row[0]}",
                             f"{max(radii)}")
            self.tally.check(error == max(radii), f"{name}: error of a row is its largest radius")
        self.tally.check(outside(t, rows, slack) is None, f"{name}: holds the truth", str(outside(t, rows, slack)))

    def known(self):
        with open(os.path.join(ROOT, "tests", "cases", "trajectory_reference.json"), encoding="utf-8") as f:
            cases = json.load(f)
        for case in cases:
            name, rows = case["name"], case["expect"]["trajectory"]["reference"]
            count = STIFF.get(name, len(rows))
            if not count or not self.wanted(name):
                continue
            request = {**case["request"]["trajectory"]}
            request["times"] = request["times"][:count]
            t = self.solve(name, case["request"]["system"], request, 1e-13)
            self.hold(name, t, rows[:count], 1e-13, mp.mpf(10) ** -24)

    def closed(self, name, system, times, initial, columns, function, rtol, **more):
        if not self.wanted(name):
            return
        t = self.solve(name, system, {"start": 0, "times": times, "initial": initial, "outputs": columns, **more}, rtol)
        with mp.workdps(DIGITS + 20):
            rows = [function(mp.mpf(text_value(s))) for s in times]
        self.hold(name, t, rows, rtol)

    def series(self, name, system, field, x, names, times, rtol, **more):
        if not self.wanted(name):
            return
        start = {v: str(a) for v, a in zip(names, x)}
        t = self.solve(name, system, {"start": 0, "times": times, "initial": start, "outputs": names, **more}, rtol)
        self.hold(name, t, jets.taylor(field, 0, x, times, 45), rtol, mp.mpf(10) ** -42)

    def refused(self, name, system, trajectory, code, rtol=1e-8, limits=None, **accuracy):
        if not self.wanted(name):
            return
        request = {"system": system, "want": ["trajectory"], "trajectory": trajectory,
                   "accuracy": {"rtol": rtol, "atol": rtol, "arithmetic": "ball", **accuracy}, **({"limits": limits} if limits else {})}
        result, problem = self.solver.solve(request)
        self.tally.check(problem and problem["code"] == code, name, json.dumps(problem or str(result["trajectory"]["ended"])))

    def ends(self, name, system, trajectory, low, high, rows, **more):
        """No proof beyond some time: ended there, with the samples before."""
        if not self.wanted(name):
            return
        t = self.solve(name, system, trajectory, 1e-8, **more)
        if t is None:
            return
        ended = t["ended"]
        ok = ended and ended["reason"] == "not_enclosed" and low <= ended["t"] <= high
        self.tally.check(ok, f"{name}: ends", str(ended))
        self.tally.check(ended and all(r[0] <= ended["t"] for r in t["rows"]) and len(t["rows"]) == len(rows), f"{name}: rows", str(len(t["rows"])))
        self.tally.check(outside(t, rows) is None, f"{name}: rows hold the truth", str(outside(t, rows)))


def text_value(s):
    if "/" in s:
        a, b = s.split("/")
        return mp.mpf(a) / mp.mpf(b)
    return mp.mpf(s)


def explicit(names, rates, **more):
    return {"form": "equations", "variables": names, "equations": [f"{v}' = {r}" for v, r in zip(names, rates)], **more}


def pendulum(t):
    k2 = mp.mpf(1) / 2
    theta = 2 * mp.asin(mp.sqrt(k2) * mp.ellipfun("cd", t, m=k2))
    return [mp.sin(theta), -mp.cos(theta), 3 * mp.cos(theta)]


def kepler(t):
    e = mp.mpf(3) / 5
    E = mp.findroot(lambda E: E - e * mp.sin(E) - t, t)
    return [mp.cos(E) - e, mp.sqrt(1 - e * e) * mp.sin(E)]


def closed_forms(c):
    c.closed("growth", explicit(["x"], ["x"]), ["1", "2", "22/7"], {"x": "1/3"}, ["x"], lambda t: [mp.exp(t) / 3], 1e-40)
    c.closed("backwards", explicit(["x"], ["t*x"]), ["-1", "-2"], {"x": "1"}, ["x"], lambda t: [mp.exp(t * t / 2)], 1e-40)
    c.closed("oscillator", explicit(["x", "v"], ["v", "-x"]), ["1", "10", "30"], {"x": 1, "v": 0}, ["x", "v", "x^2 + v^2"],
             lambda t: [mp.cos(t), -mp.sin(t), mp.mpf(1)], 1e-40)
    c.closed("Riccati", explicit(["x"], ["1 + x^2"]), ["0.5", "1", "1.5"], {"x": 0}, ["x"], lambda t: [mp.tan(t)], 1e-40)
    c.closed("pendulum, index 3", {"form": "equations", "variables": ["x", "y", "l"],
             "equations": ["x'' = -l*x", "y'' = -l*y - 1", "x^2 + y^2 = 1"]}, ["1", "3"],
             {"x": 1, "y": 0, "x'": 0, "y'": 0}, ["x", "y", "l"], pendulum, 1e-40)
    c.closed("Kepler", explicit(["x", "y", "u", "v"], ["u", "v", "-x/(x^2 + y^2)^(3/2)", "-y/(x^2 + y^2)^(3/2)"]), ["1", "4"],
             {"x": "2/5", "y": 0, "u": 0, "v": 2}, ["x", "y"], kepler, 1e-40)
    c.closed("a start that is not given in full", {"form": "equations", "variables": ["x", "y"], "equations": ["x' = -x", "y^2 = 1 + x^2"]},
             ["1", "2"], {"x": "0.1"}, ["x", "abs(y)"], lambda t: [mp.exp(-t) / 10, mp.sqrt(1 + mp.exp(-2 * t) / 100)], 1e-40)
    line = {"form": "equations", "variables": ["x", "y"], "equations": ["x' = 1", "x + 2*y = 3"]}
    c.closed("an algebraic value that is given follows", line, ["1"], {"x": "1", "y": "1/3"}, ["x", "y"],
             lambda t: [1 + t, 1 - t / 2], 1e-40)
    c.closed("given values that miss by less than a rounding", line, ["1"], {"x": "1.00000000000000000003", "y": "1"}, ["x"],
             lambda t: [1 + t + mp.mpf("3e-20")], 1e-40)       # y is algebraic, and adapts
    circle = {"form": "equations", "variables": ["x", "y"], "equations": ["x' = y", "y' = -x", "x^2 + y^2 = 1"]}
    c.closed("nearest on a circle", circle, ["1"], {"x": "3", "y": "4"}, ["x", "y"],
             lambda t: [(3 * mp.cos(t) + 4 * mp.sin(t)) / 5, (4 * mp.cos(t) - 3 * mp.sin(t)) / 5], 1e-40)
    c.closed("start at a time and a value that are not rational", explicit(["x"], ["x*cos(t)"]), ["5"], {"x": "sqrt(2)"}, ["x"],
             lambda t: [mp.sqrt(2) * mp.exp(mp.sin(t))], 1e-40)
    c.closed("functions", explicit(["x", "y"], ["1/(1 + tan(x)^2) - sin(y)/cosh(y)*0", "2*atan2(sin(t), cos(t))*cbrt(y)/y^(1/3)"]),
             ["1/2", "1"], {"x": 0, "y": 1}, ["x", "y"], lambda t: [mp.atan(t), 1 + t * t], 1e-30)
    c.closed("branches that do not change", explicit(["x", "y"], ["abs(x) + max(x, -1) + 0*min(y, 2)", "sign(y)*abs(-y)"]), ["1"],
             {"x": 1, "y": -1}, ["x", "y"], lambda t: [mp.exp(2 * t), -mp.exp(t)], 1e-30)
    under = {"form": "quasilinear", "variables": ["x", "y"], "A": [[1, "1 + t"]], "alpha": [1]}
    c.closed("least norm", under, ["1", "3"], {"x": 0, "y": 0}, ["x", "y"], lambda t: [mp.atan(1 + t) - mp.pi / 4, mp.log((1 + (1 + t) ** 2) / 2) / 2], 1e-30)
    c.closed("rates", under, ["1", "3"], {"x": 0, "y": 0}, ["x", "y"], lambda t: [t - (1 + t) * mp.sin(t) - mp.cos(t) + 1, mp.sin(t)], 1e-30,
             gauge={"rates": {"y": "cos(t)"}})
    c.closed("a condition, the rest least norm", {"form": "quasilinear", "variables": ["x", "y", "z"], "A": [[1, 1, 1]], "alpha": [3]}, ["2"],
             {"x": 0, "y": 0, "z": 0}, ["x", "y", "z"], lambda t: [mp.mpf(1) / 2 * t, t / 2, 2 * t], 1e-30, gauge={"conditions": ["z - 2*t"]})
    three = {"form": "quasilinear", "variables": ["x", "y", "z"], "A": [[1, 1, 1]], "alpha": [0]}
    c.closed("one rate, the rest least norm", three, ["2"], {"x": 0, "y": 0, "z": 0}, ["x", "y", "z"], lambda t: [2 * t, -t, -t], 1e-30,
             gauge={"rates": {"x": "2"}})


def random_systems(c):
    rng = random.Random(seed(1987))
    for k in range(scaled(6)):
        n = rng.randint(1, 3)
        names = ["x", "y", "z"][:n]
        rows = []
        for _ in range(n):
            rows.append([(rng.randint(-4, 4), rng.randrange(n), rng.randrange(n)) for _ in range(2)] + [(rng.randint(-2, 2), rng.randrange(n), None)])
        text = [" + ".join(f"({a}/4)*{names[i]}" + (f"*sin({names[j]})" if j is not None else "") for a, i, j in r) + " + cos(t)/3" for r in rows]

        def field(t, v, rows=rows):
            return [sum((v[i] * (jets.sin_cos(v[j])[0] if j is not None else 1) * (mp.mpf(a) / 4) for a, i, j in r), jets.sin_cos(t)[1] * (mp.mpf(1) / 3))
                    for r in rows]
        x = [mp.mpf(rng.randint(-8, 8)) / 8 for _ in range(n)]
        c.series(f"random {k}: {text}", explicit(names, text), field, x, names, ["0.5", "2"], 1e-30)


def random_quotients(c):
    rng = random.Random(seed(1988))
    for k in range(scaled(4)):
        a = [mp.mpf(rng.choice([-3, -2, -1, 1, 2, 3])) / 2 for _ in range(6)]
        q = [mp.nstr(v, 5) for v in a]
        text = [f"({q[0]}*y + {q[1]}*t)/(1 + x^2 + y^2/4) + {q[2]}/4*sqrt(2 + x*y + x^2 + y^2)", f"{q[3]}*exp(-x^2)*y + {q[4]}*x/(2 + sin(y)) + {q[5]}/3"]

        def field(t, v, a=a):
            x, y = v
            xx, yy = x * x, y * y
            return [(y * a[0] + t * a[1]) / (1 + xx + yy * (mp.mpf(1) / 4)) + jets.sqrt(x * y + xx + yy + 2) * (a[2] / 4),
                    jets.exp(-xx) * y * a[3] + x * a[4] / (jets.sin_cos(y)[0] + 2) + a[5] / 3]
        x = [mp.mpf(rng.randint(-8, 8)) / 8 for _ in range(2)]
        c.series(f"random quotients {k}: {text}", explicit(["x", "y"], text), field, x, ["x", "y"], ["0.5", "1.5"], 1e-30)


def no_proof(c):
    c.ends("a pole", explicit(["x"], ["1 + x^2"]), {"start": 0, "times": ["1", "1.5", "1.6"], "initial": {"x": 0}}, 1.5, 1.5708,
           [[mp.tan(1)], [mp.tan(mp.mpf("1.5"))]])
    c.ends("abs that touches 0", explicit(["x"], ["abs((t - 1)^3)^(1/3)"]), {"start": 0, "times": ["0.25", "4"], "initial": {"x": "1/2"}}, 0.9, 1.0001, [[mp.mpf("1/2") + mp.mpf("7/32")]])
    c.ends("the edge of sqrt", explicit(["x", "y"], ["-1", "sqrt(x)"]), {"start": 0, "times": ["0.5", "2"], "initial": {"x": 1, "y": 0}}, 0.9, 1.0001,
           [[mp.mpf("0.5"), mp.mpf(2) / 3 * (1 - mp.mpf("0.5") ** 1.5)]])
    c.ends("a pivot that vanishes", {"form": "quasilinear", "variables": ["x", "y"], "A": [[1, 0], [0, "x"]], "alpha": [-1, "x"]},
           {"start": 0, "times": ["0.5", "2"], "initial": {"x": 1, "y": 0}}, 0.9, 1.0001, [[mp.mpf("0.5"), mp.mpf("0.5")]])
    lorenz = explicit(["x", "y", "z"], ["10*(y - x)", "x*(28 - z) - y", "x*y - 8*z/3"])
    c.refused("chaos for a long time", lorenz, {"start": 0, "times": ["1000"], "initial": {"x": 1, "y": 1, "z": 20}}, "time_limit", limits={"seconds": 2})
    c.refused("a method without balls", explicit(["x"], ["x"]), {"start": 0, "stop": 1, "initial": {"x": 1}}, "not_supported", method="dop853")
    c.refused("no constraint at the start", {"form": "equations", "variables": ["x", "y"], "equations": ["x' = 1", "y^2 = 1 - x^2"]},
              {"start": 0, "stop": 1, "initial": {"x": 3}, "hold": ["x"]}, "inconsistent_initial")


def can_fail(c):
    """The check itself: a truth that is off by twice the radius is not inside, nor one of a start that is off."""
    if not c.wanted("can fail"):
        return
    t = c.solve("can fail", explicit(["x"], ["x"]), {"start": 0, "times": ["1", "2"], "initial": {"x": "1/3"}}, 1e-20)
    truth = [[mp.e / 3], [mp.e ** 2 / 3]]
    c.tally.check(outside(t, truth) is None, "can fail: the truth is inside")
    for row in range(2):
        for sign in (1, -1):
            spoilt = [list(r) for r in truth]
            spoilt[row][0] += sign * 2 * t["radii"][row][0]
            c.tally.check(outside(t, spoilt) is not None, "can fail: what is off by two radii is outside")
    c.tally.check(outside(t, [[mp.mpf("0.333333333333333333333") * mp.e], truth[1]]) is not None, "can fail: another start is outside")


def main():
    mp.mp.dps = DIGITS + 10
    tally = Tally("enclosures")
    c = Enclosures(tally, sys.argv[2:])
    closed_forms(c)
    no_proof(c)
    can_fail(c)
    random_systems(c)
    random_quotients(c)
    rng = random.Random(seed(20261125))
    random_events(c, rng, scaled(40))
    backwards(c, rng, scaled(8))
    touches(c)
    known_starts(c)
    random_starts(c, rng, scaled(30))
    random_bounces(c, rng, scaled(40))
    known_sets(c)
    samples_at_events(c)
    random_friction(c, rng, scaled(30))
    random_air(c, rng, scaled(12))
    random_fields(c, rng, scaled(60))
    side_of_abs(c)
    sides_swept(c)
    sides_not_taken(c)
    if not c.patterns:
        tally.check(c.compared > scaled(30) and c.ended_early < c.compared / 10, "motions through switches were compared", f"{c.compared} {c.ended_early}")
    c.known()
    return tally.end()


if __name__ == "__main__":
    sys.exit(main())
