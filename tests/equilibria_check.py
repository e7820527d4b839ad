"""Equilibria by other routes: equilibria_check.py BUILD_DIR

- every case of tests/cases/equilibria.json: the points against closed forms; all given equations with derivatives 0 vanish there; of polynomial
  systems SymPy's real solutions of these equations are the same points, each once;
- eigenvalues against the finite roots of det(s E - A) of the given equations, which are linearized by SymPy at the closed form;
- polynomial systems that were built from chosen equilibria, on a sphere with a multiplier and without;
- random polynomial systems, with algebraic variables and on a circle: as many points as SymPy's real roots of a separating form, called complete,
  with bounds too; where an equation is a product nothing is called complete that lies on one part alone;
- families that were built in, as common factors beside an isolated point, and as zeros of two factors together: one point of each, its dimension, complete;
- zeros of roots (sqrt, cbrt, abs) that were built in, those at which there is no derivative too: all of them, complete;
- points where abs has its kink; outputs that are held; searches without an end: warnings with their place;
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
        """Of polynomials alone, and without bounds: as many as SymPy counts."""
        f, names, rates = given(request)
        f = [g for g in f.subs({r: 0 for r in rates}) if g != 0] + [sympy.Symbol(k) - sympy.Rational(str(v)) for k, v in held.items()]
        if not all(g.is_polynomial(*names) for g in f) or request.get("equilibria", {}).get("bounds"):
            return
        should = self.real_zeros(f, names)
        if should is not None:
            self.tally.check(len(points) == should, f"{label}: all solutions", f"{len(points)}, {should}")

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
        if e["complete"]:
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
        self.tally.check(e is None or e["complete"], f"built {k}: complete", str(e and e["reason"]))

    def real_zeros(self, f, z):
        """How many real common zeros, by SymPy: None where they are no finite set, or no form that is tried tells them from each other."""
        basis = sympy.groebner(f, *z, order="grevlex")
        if basis.exprs == [1]:
            return 0
        if not basis.is_zero_dimensional:
            return None
        c = sympy.Symbol("c_")
        lex = sympy.groebner(list(f) + [c - sum(w * x for w, x in zip((3, 7, 13, 29, 53, 97), z))], *z, c, order="grevlex").fglm("lex")
        if any(sympy.Poly(g, *z).total_degree() != 1 or g.free_symbols & set(z) == set() for g in lex.exprs[:-1]) or len(lex.exprs) != len(z) + 1:
            return None
        last = sympy.Poly(lex.exprs[-1], c)
        return last.count_roots() if last.is_sqf else None      # of a zero that is a double one nothing is proved

    def drawn(self, k):
        """A random polynomial system: the points are as many as SymPy counts, and called complete; bounds leave those within."""
        def text(e):
            return str(e).replace("**", "^")

        def polynomial(variables, degree, terms):
            return sum((random.randint(-3, 3) * sympy.prod([random.choice(variables) for _ in range(random.randint(0, degree))]) for _ in range(terms)), sympy.Integer(0))
        if k % 3:
            z = list(sympy.symbols(f"x1:{random.randint(1, 3) + 1}"))
            f = [polynomial(z, 3 if len(z) < 3 else 2, random.randint(2, 4)) for _ in z]
            g, at = polynomial(z, 2, 2), random.randrange(len(z))
            equations = [f"{x}' = {text(e)}" + (f" + y - ({text(g)})" if i == at else "") for i, (x, e) in enumerate(zip(z, f))] + [f"y = {text(g)}"]
            names = [str(x) for x in z] + ["y"]
        else:
            x, y, lam = z = list(sympy.symbols("x y lam"))
            force = [polynomial([x, y], 2, 3) for _ in "xy"]
            f = [force[0] + x * lam, force[1] + y * lam, x ** 2 + y ** 2 - 1]
            equations = ["x' = vx", "y' = vy", f"vx' = {text(force[0])} - vx + x*lam", f"vy' = {text(force[1])} - vy + y*lam", "x^2 + y^2 = 1"]
            names = ["x", "y", "vx", "vy", "lam"]
        if any(e == 0 for e in f):
            return
        should = self.real_zeros(f, z)
        request = {"system": {"form": "equations", "variables": names, "equations": equations}, "want": ["equilibria"]}
        e = self.solve(f"drawn {k}", request)
        if e is None or should is None:
            return
        self.tally.check(len(e["points"]) == should and e["complete"], f"drawn {k}: all of them", f"{equations}: {len(e['points'])} of {should}; {e['reason']}")
        if e["points"]:
            low = sorted(p["values"][names[0]] for p in e["points"])[len(e["points"]) // 2] - 1e-3
            some = self.solve(f"drawn {k} within", {**request, "equilibria": {"bounds": {names[0]: [low, None]}, "starts": 5}})
            within = [p for p in e["points"] if p["values"][names[0]] >= low]
            if some is not None:
                self.tally.check(len(some["points"]) == len(within) and some["complete"], f"drawn {k}: within bounds", f"{equations}: {len(some['points'])} of {len(within)}; {some['reason']}")

    def parts(self):
        """An equation that is a product: its other factor's points are no reason to call these complete."""
        for label, variables, equations, on in [("two values", ["x", "y"], ["x = 1", "y^2 = x"], 1), ("two branches", ["x", "y"], ["x' = y - x", "0 = x*(1 - x)"], 1),
                                                ("one of them without", ["x", "y"], ["x' = y - x", "0 = x*(1 + x^2)"], 1)]:
            e = self.solve(label, {"system": {"form": "equations", "variables": variables, "equations": equations}, "want": ["equilibria"]})
            if e is not None:
                complete = label == "one of them without"
                self.tally.check(len(e["points"]) == on and e["complete"] is complete and (complete or "other parts" in e["reason"]), f"parts: {label}", str(e))

    def kinks(self):
        """Quadratic drag is at rest where abs has its kink: there is a point, exact, and no spectrum."""
        for equations, point in ((["x' = v", "v' = -abs(v)*v - x + 1"], {"x": 1, "v": 0}), (["x' = v", "v' = min(0, 2 - x) - v"], None), (["x' = v - x", "v' = abs(v - 2)"], {"x": 2, "v": 2})):
            e = self.solve(f"kink {equations}", {"system": {"form": "equations", "variables": ["x", "v"], "equations": equations}, "want": ["equilibria"]})
            if e is None:
                continue
            for p in e["points"]:
                self.tally.check(p["certified"] or p["isolated"] is None, f"kink {equations}: certified", str(p))
            if point:
                self.tally.check(len(e["points"]) == 1 and e["points"][0]["values"] == point and e["points"][0]["certified"] and e["points"][0]["eigenvalues"] is None
                                 and e["points"][0]["evidence"]["point"] == "exact" and e["complete"] and e["points"][0]["isolated"], f"kink {equations}", str(e["points"]))

    def families(self, k):
        """(c h_1, .., c h_n) mixed by a matrix, c a product of irreducible factors with powers, h affine with one zero off them; in space also (a b, a c, ..)."""
        n = random.choice([2, 2, 3])
        names = sympy.symbols("x y z")[:n]
        shapes = [names[0]**2 + names[1]**2 - random.choice([1, 3, 4]), names[0] - random.randint(-2, 2), names[1] - names[0]**2, names[-1] + 2*names[0] - 1, names[0]*names[1] - 2]
        chosen = random.sample(shapes, random.randint(1, 2))
        at = [sympy.Rational(random.randint(5, 9)) + sympy.Rational(1, 3) * i for i in range(n)]
        h = [v - a for v, a in zip(names, at)]
        curve = n == 3 and random.random() < 0.5
        if curve:                                            # the zeros of h_1 and h_2 together are a line of equilibria
            h[2] = h[0] + h[1]
        M = sympy.Matrix(n, n, lambda i, j: random.randint(-2, 2))
        while M.det() == 0:
            M = sympy.Matrix(n, n, lambda i, j: random.randint(-2, 2))
        h = list(M * sympy.Matrix(h))
        c = sympy.prod(f**random.choice([1, 1, 2]) for f in chosen)
        extra = random.random() < 0.5
        f = [sympy.expand(c * v * (names[0]**2 + 1 if extra and i == 0 else 1)) for i, v in enumerate(h)]
        result = self.solve(f"families {k}", {"system": {"form": "equations", "variables": [str(v) for v in names], "equations": [f"{v}' = {str(e).replace('**', '^')}" for v, e in zip(names, f)]},
                                              "want": ["equilibria"]})
        if result is None:
            return
        label = f"families {k}: {chosen} {at} {curve}"
        seen = {g: 0 for g in chosen}
        isolated = line = 0
        for p in result["points"]:
            v = {s: p["values"][str(s)] for s in names}
            self.tally.check(p["certified"] and all(abs(e.subs(v)) <= 1e-7 * (1 + max(abs(x) for x in v.values()))**8 for e in f), f"{label}: is one", str(p))
            on = [g for g in chosen if abs(g.subs(v)) < 1e-9]
            beside = all(abs(e.subs(v)) < 1e-9 for e in h)
            if p["isolated"]:
                isolated += 1
                self.tally.check(p["family_dimension"] == 0 and beside and not on and not curve, f"{label}: isolated", str(p))
            elif p["family_dimension"] is None:
                self.tally.check(p["isolated"] is False and len(on) + beside > 1, f"{label}: where families meet", str(p))
            elif p["family_dimension"] == n - 1:
                self.tally.check(len(on) == 1 and not beside, f"{label}: of one family", str(p))
                for g in on:
                    seen[g] += 1
            else:
                line += 1
                self.tally.check(curve and beside and p["family_dimension"] == 1, f"{label}: on the line", str(p))
        self.tally.check(set(seen.values()) == {1} and isolated == (not curve) and line == curve and result["complete"], f"{label}: each once, and all", f"{seen} {isolated} {line} {result['complete']} {result['reason']} {f}")

    def roots(self, k):
        """A polynomial in w = cbrt(x - a), sqrt(x - a) or abs(x - a) with chosen zeros, with another equation behind."""
        kind, a = random.choice(["cbrt", "sqrt", "abs"]), random.randint(-3, 3)
        w, x, y = sympy.symbols("w x y")
        zeros = sorted(random.sample([sympy.Rational(i, 2) for i in range(-4, 5)], random.randint(2, 3)))
        g = sympy.Poly(sympy.prod(w - z for z in zeros), w).as_expr()
        text = str(sympy.expand(g)).replace("**", "^").replace("w", f"{kind}(x - ({a}))")
        request = {"system": {"form": "equations", "variables": ["x", "y"], "equations": [f"x' = {text}", "y' = x + y - 1"]}, "want": ["equilibria"]}
        result = self.solve(f"roots {k}", request)
        if result is None:
            return
        real = [z for z in zeros if kind == "cbrt" or z >= 0]
        places = {a + z**3 for z in real} if kind == "cbrt" else {a + z**2 for z in real} if kind == "sqrt" else {a + z for z in real} | {a - z for z in real}
        got = sorted(p["values"]["x"] for p in result["points"] if p["certified"] and p["isolated"] and p["family_dimension"] == 0)
        self.tally.check(len(got) == len(result["points"]) == len(places) and all(near(b, float(q)) for b, q in zip(got, sorted(places))) and result["complete"],
                         f"roots {k}: {kind} {a} {zeros}", str(result)[:600])

    def outputs(self):
        """Outputs of a descriptor system are held while inputs are free: y = x1 + 2 u = 3 with x1 = u/2."""
        system = {"form": "descriptor", "states": ["a", "b"], "inputs": ["u"], "outputs": ["y"], "A": [[0, 1], [-2, -3]], "B": [[0], [1]], "C": [[1, 0]], "D": [[2]]}
        e = self.solve("held output", {"system": system, "want": ["equilibria"], "equilibria": {"hold": {"y": "3"}, "free": "u"}})
        if e is not None:
            self.tally.check([p["values"] for p in e["points"]] == [{"a": 0.6, "b": 0, "u": 1.2}] and e["complete"], "held output", str(e["points"]))
        servo = {"form": "control", "variables": ["x", "y", "z"], "inputs": ["u"], "F": ["y", "-x", "-3*z + x*u"], "G": [["0", "1", "0"]], "constraints": ["x - 1"]}
        e = self.solve("servo constraint", {"system": servo, "want": ["equilibria"]})    # it determines the input: u = x = 1, and z = 1/3 is left to move
        if e is not None:
            self.tally.check(e["complete"] and len(e["points"]) == 1 and near(e["points"][0]["values"]["z"], 1 / 3) and e["points"][0]["values"]["u"] == 1
                             and e["points"][0]["eigenvalues"] == [[-3, 0, 1]], "servo constraint", str(e["points"]))

    def none(self):
        """Nothing found: a warning with the place, and what to change."""
        for equations, ask, place, said in [(["x' = x^2 + 1"], {}, "/equilibria", "there is no equilibrium"), (["x' = exp(x)"], {}, "/equilibria", "no equilibrium was proved"),
                                            (["x' = x^2 - 4"], {"bounds": {"x": [5, None]}}, "/equilibria/bounds", "within the bounds")]:
            result, problem = self.solver.solve({"system": {"form": "equations", "variables": ["x"], "equations": equations}, "want": ["equilibria"], "equilibria": ask})
            told = [w for w in result["warnings"] if w["code"] == "no_equilibrium"] if result else []
            self.tally.check(len(told) == 1 and told[0]["pointer"] == place and said in told[0]["detail"], f"none: {equations}", str(problem or result["warnings"]))

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
                if not sys.argv[2:] or any(p in case["name"] for p in sys.argv[2:]):
                    self.case(case)
        if sys.argv[2:]:
            return self.tally.end()
        for k in range(scaled(20)):
            self.built(k)
        for k in range(scaled(40)):
            self.drawn(k)
        for k in range(scaled(40)):
            self.families(k)
            self.roots(k)
        self.parts()
        self.kinks()
        self.outputs()
        self.none()
        self.refused()
        return self.tally.end()


sys.exit(Check().run())
