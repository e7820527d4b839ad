"""Error estimates of samples inside steps: inside_check.py BUILD_DIR

Motions with references, asked for at random times, most of which no step ends at, and at tolerances for 4, 8 and 12 digits, by several methods. They
are held against the same motions in double-double, which the suite `errors` holds against references of its own. 98 % of all estimates must hold, 97 % of those
at each tolerance, whose median must not be more than 60 times the error. SGA_TEST_SEED, SGA_TEST_SCALE: the part of the motions."""
import random
import sys

import mpmath

from solver import Solver
from tally import Tally, build_folder, scale, seed
from trajectory_errors import STIFF, load, miss

TOLERANCES, SAMPLES = (1e-4, 1e-8, 1e-12), 30
HELD, HELD_AT_EACH, TOO_LARGE = 0.98, 0.97, 60
FILES = ("trajectory_reference.json", "trajectory_reference_models.json", "double_double.json", "kinks.json")


def request(case, times, accuracy):
    given = case["request"]["trajectory"]
    t = {k: v for k, v in given.items() if k not in ("stop", "samples")}
    return {**case["request"], "want": ["trajectory"], "trajectory": {**t, "times": times}, "accuracy": accuracy, "limits": {"seconds": 20}}


def motions(rng):
    """Cases with references that go on to their last time, with times on the way."""
    for case in [c for name in FILES for c in load(name)]:
        expect, given = case["expect"].get("trajectory", {}), case["request"].get("trajectory", {})
        if "reference" not in expect or "times" not in given or rng.random() > scale():
            continue
        start, stop = (float(mpmath.mpf(str(v).partition("/")[0])) / float(str(v).partition("/")[2] or 1) for v in (given.get("start", 0), given["times"][-1]))
        yield case, sorted((round(rng.uniform(start, stop), 12) for _ in range(SAMPLES)), reverse=stop < start)


def runs(case, tol, rng):
    yield None
    methods = ["radau"] if any(word in case["name"] for word in STIFF) else ["radau", "taylor", "dop853"] + ["tsit5"] * (tol > 1e-7)
    yield rng.choice(methods)


def main():
    tally, solver, rng = Tally("inside steps"), Solver(build_folder()), random.Random(seed(20261126))
    found = {tol: [] for tol in TOLERANCES}
    for case, times in motions(rng):
        given = case["request"].get("accuracy", {})
        part = given.get("atol", 1) / given.get("rtol", 1)
        exact, _ = solver.solve(request(case, times, {"rtol": 1e-20, "atol": 1e-20 * part, "arithmetic": "double-double"}))
        if not exact or exact["trajectory"]["ended"] or not exact["trajectory"]["accuracy_reached"]:
            continue
        for tol in TOLERANCES:
            for method in runs(case, tol, rng):
                answer, wrong = solver.solve(request(case, times, {"rtol": tol, "atol": tol * part, "arithmetic": "double", **({"method": method} if method else {})}))
                t = answer and answer["trajectory"]
                if not tally.check(t and not t["ended"], f"{case['name']} at {tol:g}, {method}", wrong or (t and t["ended"])):
                    continue
                for row, should, estimate in zip(t["rows"], exact["trajectory"]["rows"], t["errors"]):
                    found[tol].append((max(miss(x, getattr(r, "text", r)) for x, r in zip(row[1:], should[1:])), float("inf") if estimate is None else estimate))
    for tol, list_ in found.items():
        held, ratio = sum(e <= told for e, told in list_), sorted(told / max(e, 1e-300) for e, told in list_)
        print(f"at {tol:g}: {len(list_)} samples, the estimate holds in {100 * held / len(list_):.1f} %, is {ratio[len(list_) // 2]:.1f} times the error in the median")
        tally.check(held >= HELD_AT_EACH * len(list_), f"estimates at {tol:g} hold", f"{held} of {len(list_)}")
        tally.check(ratio[len(list_) // 2] <= TOO_LARGE, f"estimates at {tol:g} are not too large", ratio[len(list_) // 2])
    everything = [pair for list_ in found.values() for pair in list_]
    tally.check(sum(e <= told for e, told in everything) >= HELD * len(everything), "estimates hold", len(everything))
    return tally.end()


if __name__ == "__main__":
    sys.exit(main())
