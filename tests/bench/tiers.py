"""What a tier of accuracy costs.

Over the references that are not stiff: the time of a trajectory by Taylor series in double-double over that in double at
the same tolerance, and at finer ones; over the stiff ones, of one by implicit steps; and of a motion kept on its first integral over the same motion left alone. Each
time is the least of several; ratios are geometric means."""
import json
import math
import os
import sys

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), ".."))
from solver import Solver    # noqa: E402

TURNS = 9
STIFF = ("stiff", "prothero", "kaps", "robertson")
NOT_COMPARED = ("decay", "slope", "small units", "e5")    # other things than steps decide there
HELD = [("x^2 + v^2 - 1", ["x", "v"], ["v", "-x"], {"x": 1, "v": 0}),
        ("x*v - y*u - 4/5", ["x", "y", "u", "v"], ["u", "v", "-x/(x^2 + y^2)^(3/2)", "-y/(x^2 + y^2)^(3/2)"], {"x": "0.4", "y": 0, "u": 0, "v": 2}),
        ("a^2 + b^2 - 1", ["a", "b", "c"], ["b*c", "-a*c", "-0.51*a*b"], {"a": 0, "b": 1, "c": 1})]


def seconds(solver, request):
    return min(solver.solve(request)[0]["work"]["seconds"]["trajectory"] for _ in range(TURNS))


def mean(values):
    return math.exp(sum(math.log(v) for v in values) / len(values))


def longer(solver, cases, tolerance, base, method="taylor"):
    ratios = []
    for case in cases:
        given = case["request"]["accuracy"]
        ratio = 1 if method == "taylor" else given["atol"] / given["rtol"]
        plain = {**case["request"], "accuracy": {"rtol": base, "atol": base * ratio, "method": method, "arithmetic": "double"}}
        fine = {**case["request"], "accuracy": {"rtol": tolerance, "atol": tolerance * ratio, "arithmetic": "double-double"}}
        ratios.append(seconds(solver, fine) / seconds(solver, plain))
    return mean(ratios)


def projection(solver, accuracy):
    ratios = []
    for held, names, alpha, start in HELD:
        system = {"form": "quasilinear", "variables": names, "alpha": alpha,
                  "A": [[int(i == j) for j in range(len(names))] for i in range(len(names))]}
        motion = {"start": 0, "times": [20], "initial": start}
        alone = {"system": system, "accuracy": accuracy, "trajectory": motion}
        ratios.append(seconds(solver, {**alone, "system": {**system, "restrict": [held]}}) / seconds(solver, alone))
    return mean(ratios)


def load(name):
    path = os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "cases", name)
    with open(path, encoding="utf-8") as f:
        return json.load(f)


def run(build, show):
    print("double-double beside double, and projections")
    solver = Solver(build)
    cases = [c for c in load("trajectory_reference.json") if not any(word in c["name"] for word in STIFF)]
    show("double-double / double, taylor at 1e-10", f"{longer(solver, cases, 1e-10, 1e-10):.1f}")
    for tolerance in (1e-16, 1e-20, 1e-28):
        show(f"double-double at {tolerance:g} / double at 1e-10", f"{longer(solver, cases, tolerance, 1e-10):.1f}")
    stiff = [c for c in load("double_double_stiff.json") if not any(word in c["name"] for word in NOT_COMPARED)]
    for tolerance in (1e-16, 1e-20, 1e-28):
        show(f"stiff: double-double at {tolerance:g} / double at 1e-10", f"{longer(solver, stiff, tolerance, 1e-10, 'auto'):.1f}")
    for accuracy in ({"rtol": 1e-8, "atol": 1e-8, "method": "dop853"}, {"rtol": 1e-11, "atol": 1e-11, "method": "taylor"},
                     {"rtol": 1e-20, "atol": 1e-20, "arithmetic": "double-double"}):
        show(f"projected on one constraint / left alone, {accuracy.get('method', accuracy.get('arithmetic'))} at {accuracy['rtol']:g}",
             f"{projection(solver, accuracy):.2f}")
