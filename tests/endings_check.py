"""Random motions end alike in any order of equations and variables: endings_check.py BUILD_DIR

Systems of index 0 to 2 with products, poles and coefficients that vanish on the way; a quarter of the motions ends. Asked in four orders,
each gives the same verdict, dimensions, reason and time of the end, or values within the estimates, or the same refusal. A start on a stratum may be refused in one
order and moved in another, and a motion that ends at its last time may be said to reach it: the seed is one without such. Folds beside what has grown, and poles beside a root,
in units: the reason is the same, and the time within its error. SGA_TEST_SEED repeats
a run, SGA_TEST_SCALE makes it longer."""
import json
import math
import random
import sys

import sympy as sp

from solver import Solver
from tally import Tally, build_folder, scaled, seed

SYSTEMS, ORDERS = 100, 4
TIME = 10       # tolerances by which times of an end may differ


def term(rng, over):
    m = sp.Rational(rng.choice([-2, -1, 1, 2, 3]), rng.choice([1, 1, 2]))
    for _ in range(rng.randint(0, 2)):
        m *= rng.choice(over)
    kind = rng.random()
    if kind < 0.12:
        return m * rng.choice([sp.sin, sp.cos])(rng.choice(over))
    if kind < 0.17:
        return m * sp.exp(rng.choice(over) / 2)
    return m / (rng.choice(over) - sp.Rational(5, 2)) if kind < 0.2 else m


def polynomial(rng, over):
    return sum(term(rng, over) for _ in range(rng.randint(1, 3)))


def through(f, place):
    """The same function less its value at the start."""
    return f - f.subs(place)


def system(rng):
    """Variables, equations, and a start that meets the equations without derivatives."""
    n = rng.randint(2, 4)
    x, rate = sp.symbols(f"x1:{n + 1}"), [sp.Symbol(f"x{i}_RATE") for i in range(1, n + 1)]
    place = {v: sp.Rational(rng.randint(-4, 4), 2) for v in x}
    equations = [rate[0] - polynomial(rng, x)]
    for i in range(1, n):
        kind = rng.choice(["differential", "algebraic", "algebraic", "hidden", "implicit"])
        others = [v for v in x if v != x[i]]
        if kind == "differential":
            equations.append(rate[i] - polynomial(rng, x))
        elif kind == "implicit":
            factor = rng.choice([x[i], 1 + x[i] * rng.choice(x), rng.choice(x)])
            equations.append(factor * rate[i] + rng.choice([0, 1]) * rng.choice(rate) - polynomial(rng, x))
        elif kind == "algebraic":
            equations.append(through(polynomial(rng, x) + rng.choice([x[i], x[i]**2, x[i]**3 - x[i]]), place))
        else:
            equations.append(through(polynomial(rng, others) + rng.choice(others), place))
    texts = [str(e).replace("_RATE", "'").replace("**", "^") + " = 0" for e in equations]
    return [str(v) for v in x], texts, {str(v): float(value) for v, value in place.items()}


def same(first, second, rtol):
    """What differs between two answers, each with its refusal or None; or None."""
    (a, refusal), (b, other) = first, second
    if a is None or b is None:
        codes = [p and p["code"] for p in (refusal, other)]
        return None if codes[0] == codes[1] else f"refusals: {codes}"
    if a["verdict"] != b["verdict"] or a["dimensions"] != b["dimensions"]:
        return "the analysis"
    one, two = a["trajectory"], b["trajectory"]
    if one["ended"] or two["ended"]:
        if not one["ended"] or not two["ended"] or one["ended"]["reason"] != two["ended"]["reason"]:
            return f"the ending: {one['ended']}, {two['ended']}"
        apart, size = abs(one["ended"]["t"] - two["ended"]["t"]), max(abs(one["ended"]["t"]), 1e-3)
        known = sum(e["ended"]["error"] or 0 for e in (one, two))
        return None if apart <= max(TIME * rtol * size, known) else f"its time: {one['ended']}, {two['ended']}"
    for name, v, w, e, f in zip(one["columns"][1:], one["rows"][-1][1:], two["rows"][-1][1:], one["column_errors"], two["column_errors"]):
        if a["verdict"] == "unique" and abs(v - w) > 3 * (e + f) + 1e-12 * (1 + abs(v)):
            return f"{name}: {v}, {w}, estimated {e}, {f}"
    return None


def in_units(rng):
    """A fold beside a variable that has grown, or one that grows without bound beside a root: the reason does not depend on the units."""
    rate, (x, y, z) = rng.choice([2, 4, 6, 8]), [10.0 ** rng.randint(-3, 3) for _ in range(3)]
    fold = rng.random() < 0.5
    equations = [f"{x}*x' = 1", f"{y}*y = exp({rate}*{x}*x)" if fold else f"{y}*y*(2 - {x}*x) = 1", f"({z}*z)^2 = {2 if fold else 3} - {x}*x"]
    return ("stratum" if fold else "blow_up"), {
        "system": {"form": "equations", "variables": ["x", "y", "z"], "equations": equations}, "want": ["trajectory"], "trajectory": {"stop": 3, "samples": 2, "initial": {"x": 0, "z": 1.4 / z}},
        "accuracy": rng.choice([{"rtol": 1e-4}, {"rtol": 1e-6}, {"rtol": 1e-8}, {"rtol": 1e-11}, {"method": "radau"}, {"rtol": 1e-8, "method": "dop853"}])}


def units(tally, solver, first):
    for number in range(scaled(20)):
        reason, request = in_units(random.Random(f"{first} units {number}"))
        answer, refusal = solver.solve(request)
        end = answer and answer["trajectory"]["ended"]
        tally.check(end and end["reason"] == reason and abs(end["t"] - 2) <= 3 * (end["error"] or 0) + 1e-9, f"units {number}: {reason} at 2", f"{refusal or end}: {json.dumps(request)}")


def between_branches(tally, solver, rng):
    """A hidden constraint is a product, y (w exp(y/2) - 1/2), from a start on neither: the branch does not depend on the form in which a factor is left by elimination."""
    x, w = rng.choice([0.25, 0.5, 0.75]), rng.choice([1.5, 2, 2.5])
    names, equations, told = ["x", "y", "z", "w"], ["x + y - 2 = 0", "-x/2 + y' + 1 = 0", "x' - y*w*exp(y/2) = 0", "-2*x*z + z^2 + y/(2*(x - 5/2)) + w^2/2 - 19/8 = 0"], []
    for _ in range(6):
        rng.shuffle(names)
        rng.shuffle(equations)
        answer, refusal = solver.solve({"system": {"form": "equations", "variables": names, "equations": equations}, "want": ["index", "trajectory"],
                                        "trajectory": {"stop": 1, "samples": 3, "initial": {"x": x, "z": -0.5, "y": 2 - x, "w": w}}, "accuracy": {"rtol": 1e-6}})
        told.append(refusal["code"] if refusal else answer["verdict"])
    tally.check(len(set(told)) == 1, f"between branches, {x}, {w}", told)


WAYS = [{}, {"method": "taylor"}, {"method": "dop853"}, {"method": "tsit5"}, {"method": "radau"}, {"arithmetic": "double-double", "rtol": 1e-16, "atol": 1e-16},
        {"arithmetic": "double-double", "rtol": 1e-16, "atol": 1e-16, "method": "radau"}]


def slow_manifolds(tally, solver, rng):
    """A slow manifold runs into a fold where it grows without bound, at x = 0: explicit steps are given up far before it, implicit ones a little. The time is within its error."""
    b, c = rng.randint(1, 8) / 2, rng.randint(1, 6) / 2
    part, y = rng.choice([(p, y) for p in (2, 4, 6, 8) for y in (-1, 1, 2, 4, 5) if b * p / 10 * y > 1] or [(None, None)])
    if part is None:
        return
    x, end = -b * part / 10, math.log(10 / (10 - part))
    equations = [f"x' = x + {b}", f"x' + y'*(x*y + 1) + {c} = 0"]
    rng.shuffle(equations)
    for way in rng.sample(WAYS, 3):
        tol = 10.0 ** rng.randint(-11, -5)
        request = {"system": {"form": "equations", "variables": ["x", "y"], "equations": equations}, "want": ["trajectory"], "accuracy": {"rtol": tol, "atol": tol, **way},
                   "trajectory": {"stop": end + 1, "samples": 3, "initial": {"x": x, "y": y}}}
        answer, refusal = solver.solve(request)
        ended = answer and answer["trajectory"]["ended"]
        named = ended and ended["reason"] in ("stratum", "blow_up", "step_limit")
        tally.check(named and abs(ended["t"] - end) <= (0.05 * end if ended["error"] is None else ended["error"]), f"a slow manifold, {json.dumps(way)}", f"{refusal or ended}, not {end}: {json.dumps(request)}")


def off_the_constraints(tally, solver, rng):
    """Constraints that contradict each other at index 3, beside a start that is far from those before: the same refusal in any order."""
    a, b, c = rng.choice(["3/2", "5/2", "7/2"]), rng.choice(["1/3", "2/5"]), rng.choice(["3/2", "2"])
    names, equations = ["x", "y", "z", "w"], [f"x/(x - {a}) + y + {b} = 0", "y' + 2*z - 3 = 0", f"x' - x*y - {c}*x = 0", "z - 2 = 0"]
    codes = []
    for _ in range(6):
        rng.shuffle(names)
        rng.shuffle(equations)
        answer, refusal = solver.solve({"system": {"form": "equations", "variables": names, "equations": equations}, "want": ["index", "trajectory"],
                                        "trajectory": {"stop": 1, "samples": 3, "initial": {"x": -0.5, "w": 2, "y": -0.5, "z": 2}}, "accuracy": {"rtol": 1e-4}})
        codes.append(refusal["code"] if refusal else answer["verdict"])
    tally.check(set(codes) == {"no_motion"}, f"constraints off the start, {a}, {b}, {c}", codes)


def main():
    tally, solver = Tally("endings"), Solver(build_folder())
    first, ended, answered = seed(20261129), 0, 0
    for number in range(scaled(SYSTEMS)):
        rng = random.Random(f"{first} {number}")
        names, texts, start = system(rng)
        rtol, base = rng.choice([1e-4, 1e-6, 1e-8, 1e-10]), None
        for order in range(ORDERS):
            variables, equations = names[:], texts[:]
            if order:
                rng.shuffle(variables)
                rng.shuffle(equations)
            request = {"system": {"form": "equations", "variables": variables, "equations": equations}, "want": ["index", "trajectory"],
                       "trajectory": {"stop": 1, "samples": 3, "initial": start, "outputs": names}, "accuracy": {"rtol": rtol, "atol": rtol}}
            answer, refusal = solver.solve(request)
            if order == 0:
                base = answer, refusal
                answered += answer is not None
                ended += bool(answer and answer["trajectory"]["ended"])
                continue
            why = same(base, (answer, refusal), rtol)
            tally.check(why is None, f"{number} in order {order}", f"{why}: {json.dumps(request)}")
    if scaled(SYSTEMS) >= 20:         # of a few there may be none
        tally.check(answered >= 0.7 * scaled(SYSTEMS), "answers", f"only {answered} are answered")
        tally.check(ended >= 0.1 * scaled(SYSTEMS), "endings", f"only {ended} motions end")
    units(tally, solver, first)
    for number in range(scaled(8)):
        between_branches(tally, solver, random.Random(f"{first} between {number}"))
        off_the_constraints(tally, solver, random.Random(f"{first} off {number}"))
    for number in range(scaled(16)):
        slow_manifolds(tally, solver, random.Random(f"{first} slow {number}"))
    return tally.end()


if __name__ == "__main__":
    sys.exit(main())
