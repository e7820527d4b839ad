"""Irregular constraints and zero identities, by a second route: hard_sets.py BUILD_DIR

- every claim of tests/cases/zero_identities.json by mpmath, with far more digits than the
  claim needs;
- identities composed at random (sums of products of listed ones, arguments replaced),
  exact and with a tiny number added: never decided wrongly;
- regular functions hidden at random in irregular ones: the zeros that are printed are
  those of the functions that were hidden, at random points on and off them;
- systems with variables and rows multiplied by powers of ten.
"""
import json
import os
import random
import re
import sys

import mpmath

from expression import EXACT, Graph, Undefined, evaluate
from solver import Solver
from tally import ROOT, Tally, build_folder, scaled, seed

POINT = {"x": "7/10", "y": "2/5", "z": "3/10"}


def listed():
    path = os.path.join(ROOT, "tests", "cases", "zero_identities.json")
    with open(path, encoding="utf-8") as f:
        return [c["name"].split(": ", 1) for c in json.load(f) if c["name"].startswith(("zero: ", "not zero: "))]


def value(text, digits, env):
    with mpmath.workdps(digits):
        return evaluate(text, {k: evaluate(v) for k, v in env.items()})


def claims(tally):
    """The lists themselves."""
    for kind, text in listed():
        if kind == "zero":
            for env in (POINT, {"x": "9/10", "y": "3/10", "z": "1/2"}):
                v = value(text, 60, env)
                tally.check(abs(v) < mpmath.mpf(10) ** -45, f"{text} is 0", mpmath.nstr(v, 5))
        else:
            v = value(text, 6000, POINT)
            tally.check(abs(v) > mpmath.mpf(10) ** -5900, f"{text} is not 0")


def verdict(solver, system, near=True):
    request = {"system": system, "want": ["constraints", "index"]}
    if near:
        request["trajectory"] = {"start": 0, "stop": 1, "samples": 2, "initial": POINT}
    result, problem = solver.solve(request)
    if problem:
        return problem["code"], problem.get("detail", "")
    return result["verdict"], result["dimensions"]["final"]


def compose(rng, zeros):
    """A function that is 0 near POINT, made of listed ones."""
    first, second = rng.sample(zeros, 2)
    argument = rng.choice(["x", "y", "(x + y)/2", "sqrt(x*y)", "x^2"])
    first = re.sub(r"\bx\b", f"({argument})", first)
    factor = rng.choice(["y + 2", "exp(x)", "cos(x - y)", "1/(1 + x^2)", "3", "sqrt(x)"])
    other = rng.choice(["z", "x - 1", "log(y)", "1/7", "cosh(z)"])
    return f"({factor})*({first}) + ({other})*({second})"


def identities(tally, solver, rng):
    """Zero as an entry of A, as a right side, as part of a constraint; and nearly zero."""
    zeros = [t for kind, t in listed() if kind == "zero" and re.search(r"\bx\b", t) and "tan" not in t]
    undecided = 0
    for _ in range(scaled(30)):
        f = compose(rng, zeros)
        try:
            if abs(value(f, 60, POINT)) > mpmath.mpf(10) ** -40:
                continue                   # the argument left the side on which it holds
        except Undefined:
            continue
        role = rng.randrange(4)
        if role == 0:
            system, want = {"A": [["1", 0, 0], [0, 0, f]], "alpha": ["1", "z"]}, ("underdetermined", 2)
        elif role == 1:
            system, want = {"A": [[0, 0, 0]], "alpha": [f]}, ("underdetermined", 3)
        elif role == 2:
            system, want = {"A": [[0, 0, 0]], "alpha": [f"z - y + {f}"]}, ("underdetermined", 2)
        else:
            tiny = f"{f} + 1e-{rng.choice([40, 200, 700])}"
            system, want = {"A": [[1, 0, 0], [0, 0, tiny]], "alpha": ["1", "z"]}, ("underdetermined", 3)
        got = verdict(solver, {"form": "quasilinear", "variables": ["x", "y", "z"], **system})
        refused = got[0] in ("undecided", "reducible_constraints", "no_real_point", "time_limit")
        undecided += refused
        tally.check(got == want or refused, f"{f} (role {role})", f"is {got}, should be {want}")
    tally.check(undecided <= scaled(30) // 5, "few undecided", str(undecided))


# g -> a function that vanishes just where g does, and not regularly or not plainly
HIDE = ["({g})^2", "1 - cos(({g})/9)", "cosh({g}) - 1", "exp(({g})^2) - 1", "sqrt(1 + ({g})^2) - 1", "atan(({g})^2)",
        "log(1 + ({g})^2)", "abs({g})", "({g})^4*(1 + x^2)", "tanh({g})^2", "exp({g}) - 1", "sinh({g})", "cbrt({g})",
        "({g})^3*exp(y)", "({g})/(1 + z^2)", "sin({g})/2 - ({g})/2", "exp({g}) - 1 - ({g})", "1 - 1/cosh({g})", "sqrt(abs({g}))",
        "asinh({g})^2", "1 - exp(-({g})^2)", "({g})*abs({g})", "max(({g})^2, abs({g}))", "acosh(1 + ({g})^2)"]
NOT_EVEN = ("exp({g}) - 1", "sinh({g})", "cbrt({g})", "({g})^3*exp(y)", "({g})/(1 + z^2)", "sin({g})/2 - ({g})/2", "({g})*abs({g})")
EVEN = [h for h in HIDE if h not in NOT_EVEN]     # never negative: two of them vanish together
# graphs: variable and what it equals
GRAPH = [("x", "y^2 - z"), ("x", "sin(y)"), ("y", "2*x - z + 1"), ("z", "x*y"), ("z", "1/2"), ("y", "cos(z)"), ("x", "-3*z")]


def hidden(rng):
    """(text, list of (variable, right side)): one function, or two that vanish together."""
    name, right = rng.choice(GRAPH)
    g = f"{name} - ({right})"
    if rng.random() < 0.5:
        return rng.choice(HIDE).format(g=g), [(name, right)]
    other = rng.choice([q for q in GRAPH if q[0] != name and not re.search(rf"\b{name}\b", q[1])
                        and not re.search(rf"\b{q[0]}\b", right)] or [None])
    if other is None:
        return rng.choice(HIDE).format(g=g), [(name, right)]
    h = f"{other[0]} - ({other[1]})"
    weight = rng.choice(["", "3*", "1/7*"])
    return f"{rng.choice(EVEN).format(g=g)} + {weight}({rng.choice(EVEN).format(g=h)})", [(name, right), other]


def printed_at(graph, roots, env):
    cone = graph.cone(roots)
    v = graph.values(cone, env, EXACT)
    return [abs(v[r]) for r in roots]


def irregular(tally, solver, rng):
    refused = 0
    for _ in range(scaled(60)):
        text, graphs = hidden(rng)
        result, problem = solver.solve({"system": {"form": "quasilinear", "variables": ["x", "y", "z"], "A": [[0, 0, 0]],
                                                   "alpha": [text]}, "want": ["constraints", "index"]})
        if problem:
            refused += 1
            tally.check(problem["code"] in ("irregular_constraint", "undecided", "no_real_point", "reducible_constraints"), text, str(problem))
            continue
        tally.check(result["dimensions"]["final"] == 3 - len(graphs), f"{text}: final dimension", str(result["dimensions"]))
        with mpmath.workdps(50):
            graph = Graph()
            roots = [graph.parse(c["expression"]) for c in result["constraints"]]
            for _ in range(3):
                env = {n: mpmath.mpf(rng.randint(-800, 800)) / 1000 for n in ("x", "y", "z")}
                off = {**env}
                for name, right in graphs:
                    env[name] = evaluate(right, env)
                for name, right in graphs:     # of two, the second may be used by the first
                    env[name] = evaluate(right, env)
                tally.check(max(printed_at(graph, roots, env)) < mpmath.mpf(10) ** -20, f"{text}: vanishes on its zeros",
                            str([c["expression"] for c in result["constraints"]]))
                tally.check(max(printed_at(graph, roots, off)) > mpmath.mpf(10) ** -20, f"{text}: does not elsewhere",
                            str([c["expression"] for c in result["constraints"]]))
    tally.check(refused <= scaled(60) // 6, "few refused", str(refused))


def main():
    tally = Tally("hard")
    rng = random.Random(seed(20261121))
    solver = Solver(build_folder())
    claims(tally)
    identities(tally, solver, rng)
    irregular(tally, solver, rng)
    return tally.end()


if __name__ == "__main__":
    sys.exit(main())
