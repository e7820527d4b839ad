"""Motions at coarse and at fine tolerances say the same: coarse_check.py BUILD_DIR

Samples at the very times of events, switches and impacts have the values before them, by every method; a motion does not end at a tolerance at which
steps alone go astray; events of a motion far smaller than `atol` are found; what is set by constraints after an event is no event again; estimates hold where all solutions begin with one short step.
SGA_TEST_SEED, SGA_TEST_SCALE as everywhere."""
import math
import random
import sys

from solver import Solver
from tally import Tally, build_folder, scaled, seed

TOLERANCES = (3e-3, 4.1e-4, 5.7e-5, 9e-6, 1.3e-6, 2.2e-7, 3.1e-8, 4e-9, 6.3e-10, 7e-11)
RUNS = 60


def accuracy_of(rng):
    tolerance = rng.choice(TOLERANCES) * rng.uniform(0.7, 1.4)
    accuracy = {"rtol": tolerance, "atol": tolerance}
    if rng.random() < 0.5:
        accuracy["method"] = rng.choice(["dop853", "radau", "taylor", "tsit5"])
    return accuracy


def bounces(rng):
    """Falls from rest that end at whole seconds: x = h, 0, h, 0, ... with velocities before the bounces."""
    c, height = rng.choice([(2, 1), (8, 4), (1, "1/2"), (4, 2)])
    system = {"form": "equations", "variables": ["x", "v"], "equations": ["x' = v", f"v' = -{c}"]}
    events = [{"name": "ground", "expression": "x", "direction": "down", "action": "set", "set": {"v": "-v"}}]
    h = c / 2
    closed = [[k, h if k % 2 == 0 else 0, 0 if k % 2 == 0 else -c] for k in range(6)]
    return system, {"stop": 5, "samples": 6, "initial": {"x": height, "v": 0}, "events": events}, closed


def ramps(rng):
    """The rate of a ramp that begins and ends at samples: the values before, there."""
    begin, end, slope = 1, rng.choice([2, 3]), rng.choice([1, 2, 3])
    system = {"form": "equations", "variables": ["x", "y", "z"],
              "equations": ["x' = z", f"y = {slope}*(max(0, t - {begin}) - max(0, t - {end}))", "y' = z"]}
    closed = []
    for k in range(5):
        y = slope * (max(0, k - begin) - max(0, k - end))
        closed.append([k, y, y, slope if begin < k <= end else 0])
    return system, {"stop": 4, "samples": 5, "initial": {"x": 0}}, closed


def rates(rng):
    """t x' = y' with y' = t: x' = 1, but free at the start."""
    a = rng.choice([1, 2, 3])
    return ({"form": "quasilinear", "variables": ["x", "y"], "A": [["t", "-1"]], "alpha": ["0"]},
            {"stop": 2, "samples": 5, "initial": {"x": 0, "y": 0}, "gauge": {"rates": {"y": f"{a}*t"}}},
            [[k / 2, a * k / 2, a * k * k / 8] for k in range(5)])


def beside(row, closed):
    return max(abs(a - b) for a, b in zip(row, closed))


def closed_forms(solver, tally, rng):
    for run in range(scaled(RUNS)):
        draw = rng.choice([bounces, ramps, rates])
        system, motion, closed = draw(rng)
        accuracy = accuracy_of(rng)
        if draw is rates and accuracy.get("method") == "taylor":      # there are no series
            del accuracy["method"]
        label = f"{run}: {draw.__name__} {system['equations'] if 'equations' in system else motion['gauge']} {accuracy}"
        answer, problem = solver.solve({"system": system, "want": ["trajectory"], "accuracy": accuracy, "trajectory": motion})
        if not tally.check(answer and answer["trajectory"]["ended"] is None, f"{label}: it goes on", problem or answer["trajectory"]["ended"]):
            continue
        found = answer["trajectory"]
        off = max(beside(row, exact) for row, exact in zip(found["rows"], closed))
        tally.check(len(found["rows"]) == len(closed) and off <= 100 * accuracy["rtol"], f"{label}: rows", (off, found["rows"]))
        tally.check(found["error_estimate"] is not None and off <= found["error_estimate"] + 1e-12, f"{label}: what is told of errors", (off, found["error_estimate"]))


def goes_on(solver, tally):
    kinetics = {"form": "equations", "variables": ["a", "b", "c"], "equations": ["a' = -0.04*a + 1e4*b*c", "b' = 0.04*a - 1e4*b*c - 3e7*b^2", "a + b + c = 1"]}
    rod = {"form": "mechanical", "coordinates": ["x", "y", "th"], "modes": {"stuck": {"values": [0, 1], "start": 0}}, "masses": [1, 1, "1/3"], "forces": ["0", "-10", "0"],
           "constraints": ["stuck*(y - sin(th))"]}
    tip = [{"name": "tip", "expression": "y - sin(th)", "direction": "down", "action": "set", "set": {"stuck": 1}}]
    motions = [("kinetics", kinetics, {"stop": "4e4", "samples": 11, "initial": {"a": 1, "b": 0, "c": 0}}, 0),
               ("rod", rod, {"stop": 1.1, "samples": 3, "initial": {"x": 0, "y": "28/5", "th": "asin(3/5)"}, "outputs": ["y", "th"], "events": tip}, 1)]
    for name, system, motion, events in motions:
        for tolerance in TOLERANCES:
            answer, problem = solver.solve({"system": system, "want": ["trajectory"], "accuracy": {"rtol": tolerance, "atol": tolerance}, "trajectory": motion})
            label = f"{name} at {tolerance}"
            if tally.check(answer is not None, f"{label}: solved", problem):
                found = answer["trajectory"]
                tally.check(found["ended"] is None and found["error_estimate"] is not None, f"{label}: it goes on, with an estimate", (found["ended"], found["error_estimate"]))
                tally.check(len(found.get("events", [])) == events, f"{label}: events", found.get("events"))


def decay(solver, tally, rng):
    """E5 of the DETEST set (Enright, Hull, 1976) with other rates: it decays. Concentrations of 1e-12 that errors make negative run away, and that is no blow-up of the motion;
    nor does a solution that is tighter say so of one that is."""
    for run in range(scaled(12)):
        k = [r * 10 ** rng.uniform(-0.5, 0.5) for r in (7.89e-10, 1.1e7, 1.13e9, 1130)]
        a, b, c = f"{k[0]!r}*a", f"{k[1]!r}*a*c", f"{k[2]!r}*b*c"
        system = {"form": "equations", "variables": ["a", "b", "c", "d"],
                  "equations": [f"a' = -{a} - {b}", f"b' = {a} - {c}", f"c' = {a} - {b} - {c} + {k[3]!r}*d", f"d' = {b} - {k[3]!r}*d"]}
        tolerance, method = rng.choice(TOLERANCES), rng.choice(["auto", "radau"])
        answer, problem = solver.solve({"system": system, "want": ["trajectory"], "accuracy": {"rtol": tolerance, "atol": tolerance, "method": method, "arithmetic": "double"},
                                        "trajectory": {"stop": 10 ** rng.uniform(5, 11), "samples": 4, "initial": {"a": 0.00176, "b": 0, "c": 0, "d": 0}}})
        ended = answer["trajectory"]["ended"] if answer else problem
        tally.check(answer and (not ended or ended["reason"] in ("tolerance", "step_limit", "time_limit")), f"decay {run} {k} at {tolerance}, {method}", ended)
    for run in range(scaled(8)):
        rate, start, tolerance = rng.uniform(0.5, 3), rng.uniform(0.2, 2), rng.choice(TOLERANCES)
        answer, problem = solver.solve({"system": {"form": "equations", "variables": ["x"], "equations": [f"x' = {rate!r}*x^2"]}, "want": ["trajectory"],
                                        "accuracy": {"rtol": tolerance, "atol": tolerance, "method": rng.choice(["auto", "radau", "tsit5"])},
                                        "trajectory": {"stop": 20, "samples": 4, "initial": {"x": start}}})
        ended = answer["trajectory"]["ended"] if answer else problem
        tally.check(answer and ended and ended["reason"] == "blow_up" and abs(ended["t"] - 1 / (rate * start)) <= ended["error"], f"blow-up {run} at {tolerance}", ended)


def tiny(solver, tally):
    """x = a cos t with a far below an `atol` that was given: its events are there all the same."""
    for size in (1e-3, 1e-6, 1e-9):
        for tolerance in (1e-3, 1e-6, 1e-9):
            for method in ("auto", "dop853", "radau", "taylor"):
                answer, problem = solver.solve({
                    "system": {"form": "equations", "variables": ["x", "v"], "equations": ["x' = v", "v' = -x"]}, "want": ["trajectory"],
                    "accuracy": {"rtol": tolerance, "atol": tolerance, "method": method},
                    "trajectory": {"stop": "10*pi", "samples": 3, "initial": {"x": size, "v": 0}, "events": [{"name": "down", "expression": "x", "direction": "down"}]}})
                events = answer["trajectory"]["events"] if answer else problem
                tally.check(answer and len(events) == 5, f"an oscillation of {size} at {tolerance}, {method}: its events", events)
                if answer and len(events) == 5:
                    off = max(abs(e["t"] - (2 * k + 0.5) * math.pi) for k, e in enumerate(events))
                    told = max(e["error"] for e in events)
                    tally.check(off <= told <= 0.1, f"an oscillation of {size} at {tolerance}, {method}: times", (off, told))


def main():
    solver, tally = Solver(build_folder()), Tally("coarse")
    closed_forms(solver, tally, random.Random(seed(20261130)))
    goes_on(solver, tally)
    tiny(solver, tally)
    decay(solver, tally, random.Random(seed(20261130)))
    return tally.end()


if __name__ == "__main__":
    sys.exit(main())
