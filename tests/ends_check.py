"""Times at which motions end, against closed forms, and the errors that are given with them: ends_check.py BUILD_DIR

Blow-ups, impasses, ends of a domain, poles, events that stop, ends after events that set; by every method, in double and double-double, at
tolerances from 1e-4 to 1e-12. SGA_TEST_SEED, SGA_TEST_SCALE as everywhere."""
import math
import random
import sys

from solver import Solver
from tally import Tally, build_folder, scaled, seed

RUNS = 240
HELD = 0.97           # of the estimates
NEGATIVE = {"sqrt": "x", "acos": "1 - x", "power": "x - 1/4"}     # beyond the end of a domain


def bouncing(height, part):
    """A ball that falls from a height and keeps a part of its speed at each bounce comes to rest then."""
    return math.sqrt(2 * height / 9.81) * (1 + 2 * part / (1 - part))


def stopped(height, part):
    """Its second bounce."""
    return math.sqrt(2 * height / 9.81) * (1 + 2 * part)


def drawn(rng):
    """Name, variables, equations, start, events, when it ends, by which reasons."""
    a, b, c = (round(rng.uniform(0.3, 3), 4), round(rng.uniform(0.3, 3), 4), round(rng.uniform(0.5, 2), 4))
    blow, lost, rank = ("blow_up",), ("left_domain", "blow_up"), ("stratum",)
    fall = {"expression": "x", "direction": "down"}
    return rng.choice([
        ("x^2", ["x"], ["x' = x^2"], {"x": a}, [], 1 / a, blow),
        ("1 + x^2", ["x"], ["x' = 1 + x^2"], {"x": a - 1.5}, [], math.pi / 2 - math.atan(a - 1.5), blow),
        ("x^3", ["x"], ["x' = x^3"], {"x": a}, [], 1 / (2 * a * a), blow),
        ("exp", ["x"], ["x' = exp(x)"], {"x": a - 1}, [], math.exp(1 - a), blow),
        ("impasse", ["x"], ["x*x' = -1"], {"x": a}, [], a * a / 2, rank),
        ("fold", ["x", "y"], ["x' = y", f"y^2 = {b} - x"], {"x": 0, "y": math.sqrt(b)}, [], 2 * math.sqrt(b), rank),
        ("sqrt", ["x"], [f"x' = -sqrt(x) - {c}"], {"x": a}, [], 2 * math.sqrt(a) - 2 * c * math.log((math.sqrt(a) + c) / c), lost),
        ("acos", ["x", "y"], [f"x' = {c}", "y' = y - acos(x)/10"], {"x": 1 - a, "y": b} if a < 1.9 else {"x": 0, "y": b}, [], (a if a < 1.9 else 1) / c, lost),
        ("power", ["x", "z"], [f"x' = -{c}", "z' = (x - 1/4)^(5/2)"], {"x": 0.25 + a, "z": 0}, [], a / c, lost),
        ("pole", ["x", "u"], [f"x' = -{c}", "u*(x - 1/2) = 1"], {"x": 0.5 + a}, [], a / c, blow),
        ("log", ["x", "y"], ["x' = -1", "y = log(x)"], {"x": a}, [], a, lost),
        ("event", ["x", "v"], ["x' = v", f"v' = -{c}"], {"x": a, "v": b}, [{"name": "ground", "action": "stop", **fall}], (b + math.sqrt(b * b + 2 * c * a)) / c, ("event",)),
        ("rest", ["x", "v"], ["x' = v", "v' = -9.81"], {"x": a, "v": 0}, [{"name": "bounce", "action": "set", "set": {"v": "-v*0.8"}, **fall}], bouncing(a, 0.8), ("accumulation",)),
        ("bounce", ["x", "v", "n"], ["x' = v", "v' = -9.81", "n' = 0"], {"x": a, "v": 0, "n": 0},
         [{"name": "bounce", "action": "set", "set": {"v": "-v*0.8", "n": "n + 1"}, **fall}, {"name": "again", "expression": "x + 100*(1 - n)", "direction": "down", "action": "stop"}],
         stopped(a, 0.8), ("event",)),
    ])


def accuracy_of(rng):
    tolerance = rng.choice([1e-4, 1e-6, 1e-8, 1e-10, 1e-12])
    accuracy = {"rtol": tolerance, "atol": tolerance}
    if rng.random() < 0.2 and tolerance < 1e-7:
        accuracy.update({"arithmetic": "double-double", **rng.choice([{}, {"method": "radau"}])})
    elif rng.random() < 0.3:
        accuracy["method"] = rng.choice(["dop853", "radau", "taylor"])
    return accuracy


def main():
    solver, tally = Solver(build_folder()), Tally("ends")
    rng = random.Random(seed(20261129))
    known = held = 0
    for run in range(scaled(RUNS)):
        name, variables, equations, initial, events, t, reasons = drawn(rng)
        accuracy = accuracy_of(rng)
        request = {"system": {"form": "equations", "variables": variables, "equations": equations}, "want": ["trajectory"], "accuracy": accuracy,
                   "trajectory": {"stop": 100, "samples": 5, "initial": initial, **({"events": events} if events else {})}}
        answer, problem = solver.solve(request)
        label = f"{run}: {name} {accuracy}"
        if not tally.check(answer and answer["trajectory"]["ended"], f"{label}: it ends", problem):
            continue
        ended = answer["trajectory"]["ended"]
        if ended["reason"] == "step_limit":        # of double-doubles where a step shrinks to nothing
            tally.check(ended["error"] is None, f"{label}: a limit of work has no error", ended)
            continue
        tally.check(ended["reason"] in reasons, f"{label}: why", ended)
        if ended["reason"] == "left_domain" and name in NEGATIVE:
            tally.check(f"{NEGATIVE[name]} is negative" in ended["detail"], f"{label}: what has no value beyond", ended)
        if accuracy.get("arithmetic") and ended["error"] is None and ended["reason"] == "left_domain":       # beside one whose steps ended
            continue
        tally.check(ended["error"] is not None and ended["error"] < max(1e-5, 100 * accuracy["rtol"]) * max(1, t), f"{label}: an error that says something", ended)
        known += ended["error"] is not None
        held += ended["error"] is not None and abs(ended["t"] - t) <= ended["error"] + 1e-15 * t
    print(f"{held} of {known} errors of ends hold")
    tally.check(held >= HELD * known, "the errors of ends hold", (held, known))
    return tally.end()


if __name__ == "__main__":
    sys.exit(main())
