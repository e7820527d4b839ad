"""Trajectories in other units: units_check.py BUILD_DIR [NAMEPART]

The references of 20 digits with each variable in a unit of its own, 10^-40 to 10^40, all in one small or large unit, and time
in another. Absolute tolerances are left open. A few of the farthest may be refused (undecided); every other answer says accuracy_reached, or why not; where it does, each column is right to
rtol of its largest value; and estimates by column hold in 95 % of the values."""
import json
import os
import random
import re
import sys
from decimal import Decimal

import mpmath as mp

from solver import Solver
from tally import Tally, build_folder, scaled, seed

mp.mp.dps = 40
HERE = os.path.dirname(os.path.abspath(__file__))
FILES = ["trajectory_reference", "trajectory_reference_models"]
WORD = re.compile(r"\b([A-Za-z_]\w*)('*)(?!\s*\()")
# A column may be small by cancellation, which no size of terms shows: then it is right to this part of what it is made of
SMALL_BY_CANCELLATION = {"reference: robertson", "reference: van der pol, mu 10^6"}
# minutes of explicit steps in double-double
LONG = {"reference: van der pol, mu 10^6"}


def exact(x):
    """A decimal as an exact text."""
    return f"{x:e}".replace("e+", "e")


class Disguise:
    """x = c X for each variable, t = s T."""

    def __init__(self, variables, unit, time):
        self.unit, self.time = unit, time
        assert set(unit) == set(variables)

    def text(self, e):
        def word(m):
            name, primes = m.groups()
            if name in self.unit:
                return f"({exact(self.unit[name] / self.time ** len(primes))}*{name}{primes})"
            return f"({exact(self.time)}*t)" if name == "t" else name + primes
        return WORD.sub(word, e)

    def value(self, name, v):
        bare = name.rstrip("'")
        return f"({v})*({exact(self.time ** (len(name) - len(bare)) / self.unit[bare])})"

    def request(self, request):
        s, t = dict(request["system"]), dict(request["trajectory"])
        s["equations"] = [self.text(e) for e in s["equations"]]
        t["initial"] = {n: self.value(n, v) for n, v in t["initial"].items()}
        t["start"] = f"({t['start']})/({exact(self.time)})"
        t["times"] = [f"({x})/({exact(self.time)})" for x in t["times"]]
        return s, t


def units(rng, variables, kind):
    if kind == "uniform":
        c = Decimal(10) ** rng.choice([-40, -20, -9, 9, 20, 40])
        return {v: c for v in variables}
    return {v: Decimal(10) ** rng.randint(-40, 40) for v in variables}


class Check:
    def __init__(self, tally, solver):
        self.tally, self.solver = tally, solver
        self.held = self.values = self.reached = self.runs = self.refused = 0

    def one(self, case, kind, rng):
        variables = case["request"]["system"]["variables"]
        time = Decimal(10) ** rng.choice([-12, -6, 0, 0, 6, 12])
        d = Disguise(variables, units(rng, variables, kind), time)
        system, trajectory = d.request(case["request"])
        outputs = trajectory.pop("outputs")
        if set(outputs) != set(variables) or rng.random() < 0.5:
            trajectory["outputs"] = outputs
        longer = rng.random() < 0.2 and case["name"] not in LONG
        rtol = 1e-15 if longer else rng.choice([1e-5, 1e-8, 1e-10])
        label = f"{case['name']}, {kind}, units {' '.join(exact(c) for c in d.unit.values())}, time {exact(time)}, rtol {rtol}"
        request = {"system": system, "want": ["trajectory"], "trajectory": trajectory, "accuracy": {"rtol": rtol, "arithmetic": "double-double" if longer else "auto"}}
        result, problem = self.solver.solve(request)
        if result is None and problem["code"] in ("undecided", "irregular_constraint", "reducible_constraints"):
            self.refused += 1
            return
        if not self.tally.check(result is not None, f"{label}: solved", str(problem)):
            return
        t = result["trajectory"]
        self.tally.check(t["ended"] is None, f"{label}: reaches its end", str(t["ended"]))
        if t["ended"]:
            return
        self.compare(case, d, t, outputs, rtol, label)

    def compare(self, case, d, t, outputs, rtol, label):
        rows = case["expect"]["trajectory"]["reference"]
        self.runs += 1
        self.reached += t["accuracy_reached"]
        self.tally.check(t["accuracy_reached"] or t["accuracy_shortfall"], f"{label}: says why the accuracy was not reached")
        for j, name in enumerate(outputs):
            bare = name.rstrip("'")
            if bare not in d.unit:
                continue
            unit = mp.mpf(str(d.unit[bare] / d.time ** (len(name) - len(bare))))
            place = t["columns"].index(name)
            true = [mp.mpf(r[j]) / unit for r in rows]
            off = [abs(mp.mpf(getattr(r[place], "text", r[place])) - x) for r, x in zip(t["rows"], true)]
            size = max(abs(x) for x in true)
            self.values += len(off)
            self.held += sum(e <= t["column_errors"][place - 1] for e in off)
            if t["accuracy_reached"] and case["name"] not in SMALL_BY_CANCELLATION:
                most = rtol if rtol > 1e-12 else 8 * rtol        # atol is rtol then, in a unit that is guessed to a few bits
                self.tally.check(max(off) <= most * size, f"{label}: {name} to rtol of its size", f"{mp.nstr(max(off) / size, 3)}")

    def solved(self, label, system, trajectory, accuracy=None, want="trajectory"):
        result, problem = self.solver.solve({"system": system, "want": [want], "trajectory": trajectory, "accuracy": accuracy or {}})
        self.tally.check(result is not None, f"{label}: solved", str(problem))
        return result and result[want]

    def circuit(self):
        """A charge of a femtocoulomb in a resonant circuit, in SI units: i'' + (R/L) i' + i/(LC) = 0."""
        L, C, R, q = mp.mpf("1e-9"), mp.mpf("1e-12"), 5, mp.mpf("1e-15")
        system = {"form": "equations", "variables": ["q", "i"], "equations": ["q' = i", "1e-9*i' = -q/1e-12 - 5*i"]}
        t = self.solved("circuit", system, {"start": 0, "stop": "1e-9", "samples": 11, "initial": {"q": "1e-15", "i": 0}})
        if not t:
            return
        a, w = R / (2 * L), mp.sqrt(1 / (L * C) - (R / (2 * L)) ** 2)
        for row in t["rows"]:
            s = mp.mpf(row[0])
            true = [q * mp.exp(-a * s) * (mp.cos(w * s) + a / w * mp.sin(w * s)), -q / (L * C * w) * mp.exp(-a * s) * mp.sin(w * s)]
            for name, got, value, size, error in zip("qi", row[1:], true, [q, q * w], t["column_errors"]):
                self.tally.check(abs(mp.mpf(got) - value) <= min(1e-8 * size, error), f"circuit: {name} at {row[0]}", f"{got}, {mp.nstr(value, 12)}")

    def pendulum(self):
        """Of length 1e-20, from beside its circle: the start lies on it, and the motion keeps its energy."""
        system = {"form": "equations", "variables": ["x", "y", "p", "q", "l"],
                  "equations": ["x' = p", "y' = q", "p' = -l*x", "q' = -l*y - 10*10^-20", "x^2 + y^2 = 10^-40"]}
        trajectory = {"start": 0, "stop": 5, "samples": 6, "initial": {"x": "0.61e-20", "y": "-0.8e-20", "p": "0.1e-20", "q": 0}}
        start = self.solved("pendulum", system, trajectory, want="consistent_initial")
        t = self.solved("pendulum", system, trajectory)
        if not start or not t:
            return
        s = {n: mp.mpf(v) * mp.mpf(10) ** 20 for n, v in start["projected"].items()}
        self.tally.check(abs(s["x"] ** 2 + s["y"] ** 2 - 1) < 1e-12 and abs(s["x"] * s["p"] + s["y"] * s["q"]) < 1e-12, "pendulum: the start is consistent", str(s))
        self.tally.check(start["moved"] > 1e-3 and abs(s["x"] - 0.61) < 0.05, "pendulum: and near", str(start))
        energy = [(mp.mpf(r[3]) ** 2 + mp.mpf(r[4]) ** 2) * mp.mpf(10) ** 40 / 2 + 10 * mp.mpf(r[2]) * mp.mpf(10) ** 20 for r in t["rows"]]
        self.tally.check(max(abs(e - energy[0]) for e in energy) < 1e-7, "pendulum: energy", str(energy))

    def own_atol(self):
        """An absolute tolerance that is given is meant as it is."""
        system = {"form": "equations", "variables": ["x", "v"], "equations": ["x' = v", "v' = -x"]}
        trajectory = {"start": 0, "stop": 10, "samples": 3, "initial": {"x": "1e-20", "v": 0}}
        loose = self.solved("atol given", system, trajectory, {"rtol": 1e-8, "atol": 1e-10})
        tight = self.solved("atol left open", system, trajectory, {"rtol": 1e-8})
        if loose and tight:
            self.tally.check("units" not in loose and len(tight["units"]) == 2, "units only where atol is left open", str(tight.get("units")))
            for row in tight["rows"]:
                self.tally.check(abs(row[1] - 1e-20 * float(mp.cos(row[0]))) < 1e-28, f"oscillator of 1e-20 at {row[0]}", str(row))


def main():
    part = sys.argv[2] if len(sys.argv) > 2 else ""
    tally, rng = Tally("units"), random.Random(seed(20261121))
    check = Check(tally, Solver(build_folder()))
    for f in FILES:
        with open(os.path.join(HERE, "cases", f + ".json"), encoding="utf-8") as file:
            for case in json.load(file):
                if part in case["name"] and case["request"]["system"]["form"] == "equations":
                    for k in range(scaled(6)):
                        check.one(case, "uniform" if k % 3 == 0 else "each", rng)
    if not part:
        check.circuit()
        check.pendulum()
        check.own_atol()
    if check.runs and not part:
        tally.check(check.held >= 0.95 * check.values, "estimates by column hold", f"{check.held} of {check.values}")
        tally.check(check.refused <= 0.03 * check.runs, "hardly any is refused", f"{check.refused} beside {check.runs}")
        tally.check(check.reached >= 0.9 * check.runs, "accuracies are reached", f"{check.reached} of {check.runs}")
    print(f"estimates by column hold in {check.held} of {check.values} values; accuracy reached in {check.reached} of {check.runs} runs; {check.refused} refused")
    return tally.end()


if __name__ == "__main__":
    sys.exit(main())
