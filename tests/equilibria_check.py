"""Equilibria by other routes: equilibria_check.py BUILD_DIR

- every case of tests/cases/equilibria.json: the points against closed forms; all given equations with derivatives 0 vanish there; of polynomial
  systems SymPy's real solutions of these equations are the same points, each once;
- eigenvalues against the finite roots of det(s E - A) of the given equations, which are linearized by SymPy at the closed form;
- polynomial systems that were built from chosen equilibria, on a sphere with a multiplier and without;
- requests that are refused, with code and place.
"""
import functools
import itertools
import json
import os
import random
import sys

import mpmath
import sympy

import schemas
from solver import Solver
from tally import ROOT, Tally, build_folder, scaled, seed

S = sympy.Symbol("s")


def given(request):
    """Functions that vanish, variables, derivatives of a first-order system."""
    system = request["system"]
    if system["form"] == "control":
        names = system["variables"] + system["inputs"]
        text = [f"{x}' = {f}" + "".join(f" + ({g[k]})*{u}" for u, g in zip(system["inputs"], system["G"]))
                for k, (x, f) in enumerate(zip(system["variables"], system["F"]))]
    else:
        names, text = system["variables"], system["equations"]
    local = {n: sympy.Symbol(n) for n in names} | {n + "_d": sympy.Symbol(n + "_d") for n in names}
    f = []
    for line in text:
        left, right = (sympy.sympify(side.replace("'", "_d").replace("^", "**"), locals=local, rational=True) for side in line.split("="))
        f.append(left - right)
    return sympy.Matrix(f), [local[n] for n in names], [local[n + "_d"] for n in names]


def near(a, b, within=1e-9):
    return abs(a - b) <= within * (1 + abs(b))


class Check:
    def __init__(self):
        self.tally, self.solver, self.schema = Tally("equilibria"), Solver(build_folder(), number=float), schemas.validator("result")

    def solve(self, label, request):
        result, problem = self.solver.solve(request)
        if not self.tally.check(result is not None, label, str(problem)):
            return None
        fault = schemas.faults(self.schema, result)
        self.tally.check(not fault, f"{label}: schema", fault)
        return result["equilibria"]

    def match(self, label, points, expected):
        """Each of the expected points stands for one that was found; returned in that order, or None."""
        left, order = list(points), []
        for x in expected:
            found = [p for p in left if all(near(v, float(y)) for v, y in zip(p["values"].values(), x))]
            if not self.tally.check(len(found) == 1, f"{label}: {x}", str([p["values"] for p in points])):
                return None
            order.append(found[0])
            left.remove(found[0])
        return order if self.tally.check(not left, f"{label}: no others", str([p["values"] for p in left])) else None

    def spectrum(self, label, point, request, x, held):
        """The pencil of the given equations, inputs held."""
        f, names, rates = given(request)
        moving = [k for k, n in enumerate(names) if str(n) not in held]
        at = dict(zip(names, x)) | {r: 0 for r in rates}
        E, A = (f.jacobian([v[k] for k in moving]).subs(at) for v in (rates, names))
        pencil, size = S * E + A, len(moving)     # more rows than columns: the divisor of all minors
        minors = [pencil[list(rows), :].det() for rows in itertools.combinations(range(pencil.rows), size)]
        common = functools.reduce(sympy.gcd, minors)
        roots = mpmath.polyroots([mpmath.mpmathify(sympy.N(c, 30)) for c in sympy.Poly(common, S).all_coeffs()], maxsteps=500, extraprec=500)
        found = [complex(re, im) for re, im, count in point["eigenvalues"] for _ in range(count)]
        self.tally.check(len(found) == len(roots), f"{label}: eigenvalues", f"{found}, {roots}")
        for r in roots:
            best = min(found, key=lambda z, r=r: abs(z - complex(r)), default=None)
            if self.tally.check(best is not None and near(best, complex(r)), f"{label}: eigenvalue", f"{found}, {r}"):
                found.remove(best)

    def solutions(self, label, points, request, held):
        """Of polynomials alone, and without bounds."""
        f, names, rates = given(request)
        f = list(f.subs({r: 0 for r in rates})) + [sympy.Symbol(k) - sympy.Rational(str(v)) for k, v in held.items()]
        if not all(g.is_polynomial(*names) for g in f):
            return
        real = [[s[n] for n in names] for s in sympy.solve(f, names, dict=True) if all(s[n].is_real for n in names)]
        self.match(f"{label}: all solutions", points, real)

    def case(self, case):
        name, request, expect = case["name"], case["request"], case["expect"]["equilibria"]
        e = self.solve(name, request)
        if e is None:
            return
        self.tally.check(e["complete"] == expect.get("complete", False), f"{name}: complete", str(e["reason"]))
        if expect.get("degenerate"):
            self.tally.check(e["points"] and all(p["certified"] and p["family_dimension"] is None and p["isolated"] is expect["isolated"] and p["evidence"]["point"] == "exact"
                                                 and expect["degenerate"].items() <= p["values"].items() for p in e["points"]), f"{name}: exact", str(e["points"]))
            return
        self.tally.check(all(p["certified"] and p["family_dimension"] == expect.get("family", 0) and p["isolated"] == ("family" not in expect) for p in e["points"]),
                         f"{name}: certified", str(e["points"]))
        if "family" in expect:
            self.tally.check(len(e["points"]) == 1, f"{name}: one of the family", str(e["points"]))
            return
        hold = request.get("equilibria", {}).get("hold", {})
        held = {"u": 0} if "u" in [v for v in request["system"]["variables"] + request["system"].get("inputs", [])] else {}
        points = [[sympy.sympify(v, rational=True) for v in x] for x in expect["points"]]
        order = self.match(name, e["points"], points)
        self.solutions(name, e["points"], request, hold)
        for p, x, stable in zip(order or [], points, expect["stable"]):
            self.tally.check(p["stable"] is stable, f"{name}: {x} stable", str(p))
            self.spectrum(f"{name} at {x}", p, request, x, held)

    def built(self, k):
        """x_i' = polynomials with chosen simple zeros, seen through y = a linear map of x that is given as constraints."""
        zeros = [sorted(random.sample(range(-4, 5), random.randint(1, 3))) for _ in range(2)]
        slope = [random.choice([-1, 1]) for _ in zeros]
        a, b = random.randint(-3, 3), random.choice([-2, -1, 1, 2])
        f = ["*".join([str(s)] + [f"({v} - {r})" for r in z]) for s, v, z in zip(slope, ("x", f"(z - {a}*x)"), zeros)]
        request = {"system": {"form": "equations", "variables": ["x", "y", "z"], "equations": [f"x' = {f[0]}", f"{b}*y' = {f[1]}", f"z = {a}*x + {b}*y"]},
                   "want": ["equilibria"], "equilibria": {"starts": 200}}
        e = self.solve(f"built {k}", request)
        expected = [[r, sympy.Rational(q, b), a * r + q] for r in zeros[0] for q in zeros[1]]
        for p, x in zip(self.match(f"built {k}", e["points"], expected) or [], expected) if e else []:
            self.spectrum(f"built {k} at {x}", p, request, x, {})
            rates = [sympy.prod([v - r for r in z if r != v]) * s for v, z, s in zip((x[0], x[2] - a * x[0]), zeros, slope)]
            self.tally.check(p["certified"] and p["stable"] is (max(rates) < 0), f"built {k} at {x}: stable", f"{p}, {rates}")

    def refused(self):
        free = {"form": "equations", "variables": ["x", "v", "u"], "equations": ["x' = v", "v' = u - x"]}
        control = {"form": "control", "variables": ["x"], "inputs": ["u"], "F": ["-x"], "G": [["1"]], "constraints": []}
        plain = {"form": "equations", "variables": ["x"], "equations": ["x' = -x"]}
        for label, system, ask, code, place in [
                ("freedom without a name", free, {}, "inputs_mismatch", "/equilibria"),
                ("an input that is neither held nor free", control, {}, "missing_member", "/equilibria"),
                ("too much held", control, {"hold": {"u": 0, "x": 1}}, "inputs_mismatch", "/equilibria/hold"),
                ("what is determined is called free", plain, {"free": ["x"]}, "inputs_mismatch", "/equilibria"),
                ("a name that is none", plain, {"hold": {"q": 1}}, "unknown_name", "/equilibria/hold/q"),
                ("held and free", control, {"hold": {"u": 0}, "free": ["u"]}, "duplicate_name", "/equilibria/free/0"),
                ("bounds in the wrong order", plain, {"bounds": {"x": [1, 0]}}, "invalid_request", "/equilibria/bounds/x"),
                ("one bound", plain, {"bounds": {"x": [1]}}, "invalid_request", "/equilibria/bounds/x"),
                ("no starts", plain, {"starts": 0}, "invalid_request", "/equilibria/starts"),
                ("an unknown member", plain, {"start": 1}, "unknown_member", "/equilibria/start"),
                ("time", {"form": "equations", "variables": ["x"], "equations": ["x' = sin(t) - x"]}, {}, "not_supported", "/want"),
                ("a contradiction", {"form": "equations", "variables": ["x"], "equations": ["x' = x", "x = 1"]}, {}, "no_motion", "/want"),
                ("a symbol", {**plain, "parameters": {"k": None}, "equations": ["x' = -k*x"]}, {}, "invalid_request", "/system/parameters/k")]:
            result, problem = self.solver.solve({"system": system, "want": ["equilibria"], "equilibria": ask})
            self.tally.check(result is None and problem["code"] == code and problem.get("pointer", "") == place, f"refused: {label}",
                             str(problem or result["equilibria"]))

    def run(self):
        random.seed(seed(23))
        with open(os.path.join(ROOT, "tests", "cases", "equilibria.json"), encoding="utf-8") as f:
            for case in json.load(f):
                self.case(case)
        for k in range(scaled(20)):
            self.built(k)
        self.refused()
        return self.tally.end()


sys.exit(Check().run())
