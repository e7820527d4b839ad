"""Error estimates of trajectories against references of 20 digits and more: trajectory_errors.py BUILD_DIR

Every case of tests/cases/trajectory_reference.json and trajectory_reference_models.json is solved at several tolerances, by each method that fits; those of
double_double.json and double_double_stiff.json at tolerances that need longer numbers. Over all samples together the true error must lie below the estimate in 95 % of them, and the estimate must not be more than 100
times too large in the median, in double and in double-double arithmetic. Where an answer says that the accuracy asked for was reached, it must be so."""
import json
import os
import sys

import mpmath

from solver import Solver
from tally import ROOT, Tally, build_folder

TOLERANCES = [1e-2, 1e-3, 1e-4, 1e-6, 1e-8, 1e-10, 1e-12]
FINE = [1e-15, 1e-19, 1e-23, 1e-26, 1e-28]
FINE_STIFF = [1e-14, 1e-18, 1e-20, 1e-22, 1e-25, 1e-28]
STIFF = ("stiff", "prothero", "kaps", "robertson", "mu 10^6", "hires", "akzo", "amplifier")
HELD, TOO_LARGE = 0.95, 100


def runs(case):
    yield from ((tol, None) for tol in TOLERANCES)
    yield 1e-6, "radau"
    yield 1e-9, "radau"
    if not any(word in case["name"] for word in STIFF):
        yield 1e-7, "dop853"
        yield from ((tol, "taylor") for tol in (1e-5, 1e-9, 1e-13))
        yield 1e-5, "tsit5"


def miss(x, r):
    return float(abs(mpmath.mpf(getattr(x, "text", x)) - mpmath.mpf(r)))


class Corpus:
    def __init__(self, tally, name):
        self.tally, self.name = tally, name
        self.held = self.samples = self.promised = self.kept = 0
        self.ratio = []

    def add(self, name, reference, t, accuracy):
        """One answer: the error of each row against its estimate, and against what was asked for."""
        held = 0
        for row, should, estimate in zip(t["rows"], reference, t["errors"]):
            errors = [miss(x, r) for x, r in zip(row[1:], should)]
            estimate = float("inf") if estimate is None else estimate
            held += max(errors) <= estimate
            self.ratio.append(estimate / max(max(errors), 1e-300))
            if t["accuracy_reached"]:
                self.promised += 1
                allowed = (accuracy["atol"] + accuracy["rtol"] * abs(float(mpmath.mpf(r))) for r in should)
                self.kept += all(e <= a for e, a in zip(errors, allowed))
        self.held += held
        self.samples += len(t["rows"])
        # of one answer, not more than half of the samples may be wrong
        self.tally.check(held >= 0.5 * len(t["rows"]), f"{name}: estimates", f"{held} of {len(t['rows'])} hold")

    def end(self):
        self.ratio.sort()
        median = self.ratio[len(self.ratio) // 2]
        print(f"{self.name}: {self.samples} samples: the estimate holds in {100 * self.held / self.samples:.1f} %, is {median:.1f} times "
              f"the error in the median; the accuracy said to be reached was reached in {self.kept} of {self.promised}")
        self.tally.check(self.held >= HELD * self.samples, f"{self.name}: estimates hold", f"{self.held} of {self.samples}")
        self.tally.check(median <= TOO_LARGE, f"{self.name}: estimates are not too large", f"median {median}")
        self.tally.check(self.kept >= HELD * self.promised, f"{self.name}: accuracy is kept", f"{self.kept} of {self.promised}")


def load(name):
    with open(os.path.join(ROOT, "tests", "cases", name), encoding="utf-8") as f:
        return json.load(f)


def run(tally, solver, corpus, case, accuracy, name):
    result, problem = solver.solve({**case["request"], "accuracy": accuracy})
    t = result and result["trajectory"]
    if not t or t["ended"] or t["arithmetic"] != accuracy.get("arithmetic", t["arithmetic"]):
        tally.check(False, name, json.dumps(problem or t["ended"] or t["arithmetic"]))
        return
    reference = case["expect"]["trajectory"]["reference"]
    corpus.add(name, reference, t, accuracy)
    if os.environ.get("SGA_TEST_VERBOSE"):
        worst = max(miss(x, r) for row, should in zip(t["rows"], reference) for x, r in zip(row[1:], should))
        print(f"# {name}: {t['method']}, {t['arithmetic']}, error {worst:.2g}, estimate {t['error_estimate']}, {t['accuracy_reached']}, "
              f"{result['work'].get('evaluations')}", t.get("accuracy_shortfall", ""))


def switches(case):
    """Implicit steps in double-double are refused beside these."""
    return any(f in json.dumps(case["request"]["system"]) for f in ("abs(", "sign(", "min(", "max("))


def main():
    mpmath.mp.dps = 50
    tally, solver = Tally("trajectory errors"), Solver(build_folder())
    double, longer, implicit = Corpus(tally, "double"), Corpus(tally, "double-double"), Corpus(tally, "double-double, stiff")
    for case in load("trajectory_reference.json") + load("trajectory_reference_models.json"):
        given = case["request"]["accuracy"]
        for tol, method in runs(case):
            accuracy = {"rtol": tol, "atol": tol * given["atol"] / given["rtol"], "arithmetic": "double", **({"method": method} if method else {})}
            run(tally, solver, double, case, accuracy, f"{case['name']} at {tol:g}{', ' + method if method else ''}")
    for case in load("double_double.json"):
        for tol in FINE:
            run(tally, solver, longer, case, {"rtol": tol, "atol": tol, "arithmetic": "double-double"}, f"{case['name']} at {tol:g}")
        if not switches(case):
            run(tally, solver, longer, case, {"rtol": 1e-20, "atol": 1e-20, "arithmetic": "double-double", "method": "radau"},
                f"{case['name']}, radau")
    for case in load("double_double_stiff.json"):
        given = case["request"]["accuracy"]
        for tol, method in [(t, None) for t in FINE_STIFF] + ([] if switches(case) else [(1e-16, "radau"), (1e-24, "radau")]):
            accuracy = {"rtol": tol, "atol": tol * given["atol"] / given["rtol"], "arithmetic": "double-double", **({"method": method} if method else {})}
            run(tally, solver, implicit, case, accuracy, f"{case['name']} at {tol:g}{', ' + method if method else ''}")
    double.end()
    longer.end()
    implicit.end()
    return tally.end()


if __name__ == "__main__":
    sys.exit(main())
