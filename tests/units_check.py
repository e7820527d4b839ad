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
    if check.runs and not part:
        tally.check(check.held >= 0.95 * check.values, "estimates by column hold", f"{check.held} of {check.values}")
        tally.check(check.refused <= 0.03 * check.runs, "hardly any is refused", f"{check.refused} beside {check.runs}")
        tally.check(check.reached >= 0.9 * check.runs, "accuracies are reached", f"{check.reached} of {check.runs}")
    print(f"estimates by column hold in {check.held} of {check.values} values; accuracy reached in {check.reached} of {check.runs} runs; {check.refused} refused")
    return tally.end()


if __name__ == "__main__":
    sys.exit(main())
