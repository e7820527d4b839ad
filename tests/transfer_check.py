"""Transfer matrices by other routes: transfer_check.py BUILD_DIR

- every case of tests/cases/transfer.json, and random descriptor systems (singular E, improper, not square), against C (s E - A)^-1 B + D in rational
  arithmetic at random s;
- poles, zeros and their multiplicities of matrices that were built from chosen Smith-McMillan forms;
- the response against the same expression at i omega in 40 digits;
- systems whose coefficients move with time: the fraction of operators against the derivatives of outputs along motions, in rational arithmetic, and the same
  for mixed equations, other coordinates, and with modes that no input reaches;
- nonlinear systems at an equilibrium: the response against an answer's own linearization.
"""
import json
import os
import random
import subprocess
import sys

import mpmath
import sympy

import schemas
from descriptor import as_linear
from solver import Solver
from tally import ROOT, Tally, build_folder, scaled, seed

mpmath.mp.dps = 40
S = sympy.Symbol("s")


def exact(rows):
    return sympy.Matrix(len(rows), len(rows[0]) if rows else 0, [sympy.Rational(str(x)) for row in rows for x in row])


def given(system):
    """E, A, B, C, D of form descriptor as rational matrices."""
    linear = as_linear(system)
    n, rows = len(linear["variables"]), len(linear["B"])
    E, A, B, C = exact(linear["A"]), exact(linear["B"]), exact(linear["C"]), exact(system["C"])
    D = exact(system["D"]) if "D" in system else sympy.zeros(C.rows, B.cols)
    assert E.shape == (rows, n) and A.shape == (rows, n)
    return E, A, B, C, D


def at(forms, s):
    """G(s), or None where the equations do not determine it there."""
    E, A, B, C, D = forms
    M = s * E - A
    if M.rank() < M.cols:
        return None
    return C * (M.T * M).LUsolve(M.T * B) + D if M.rows != M.cols else C * M.LUsolve(B) + D


class Check:
    def __init__(self):
        self.tally, self.solver, self.schema = Tally("transfer"), Solver(build_folder(), number=float), schemas.validator("result")

    def solve(self, label, request):
        result, problem = self.solver.solve(request)
        if not self.tally.check(result is not None, label, str(problem)):
            return None
        fault = schemas.faults(self.schema, result)
        self.tally.check(not fault, f"{label}: schema", fault)
        return result["transfer"]

    def values(self, label, t, forms):
        G = sympy.Matrix([[sympy.sympify(x.replace("^", "**"), rational=True) for x in row] for row in t["matrix"]])
        for _ in range(3):
            s = sympy.Rational(random.randint(-900, 900), 31) + sympy.Rational(1, 37)
            expected = at(forms, s)
            if expected is not None:
                self.tally.check(G.subs(S, s) == expected, f"{label}: at {s}", f"{G.subs(S, s)}, {expected}")
        limit = all(sympy.degree(sympy.numer(sympy.together(x)), S) <= sympy.degree(sympy.denom(sympy.together(x)), S) for x in G)
        self.tally.check(t["proper"] == limit, f"{label}: proper", str(t["matrix"]))
        self.form(label, t, G)

    def form(self, label, t, G):
        """The Smith-McMillan form by minors: poles are roots of the least common denominator of all minors, zeros of the greatest common
        divisor of the largest minors' numerators over that denominator (MacFarlane & Karcanias, Int. J. Control 24 (1976) 33)."""
        p, m = G.shape
        if max(p, m) > 3:
            return
        minors = {}
        for k in range(1, min(p, m) + 1):
            minors[k] = [sympy.cancel(G.extract(list(r), list(c)).det()) for r in sympy.utilities.iterables.subsets(range(p), k)
                         for c in sympy.utilities.iterables.subsets(range(m), k)]
        minors = {k: [x for x in v if x != 0] for k, v in minors.items()}
        minors = {k: v for k, v in minors.items() if v}
        poles = sympy.Integer(1)
        for v in minors.values():
            for x in v:
                poles = sympy.lcm(poles, sympy.denom(x))
        zeros = sympy.Integer(1)
        if minors:
            zeros = sympy.Integer(0)
            for x in minors[max(minors)]:
                zeros = sympy.gcd(zeros, sympy.cancel(x * poles))
        for member, polynomial in (("poles", poles), ("zeros", zeros)):
            polynomial = sympy.Poly(polynomial, S)
            total = sum(e[2] for e in t[member])
            self.tally.check(total == max(polynomial.degree(), 0), f"{label}: how many {member}", f"{t[member]}, {polynomial}")
            for re, im, k in t[member]:
                z = mpmath.mpc(re, im)
                for order in range(k + 1):
                    d = polynomial.diff((S, order)) if order else polynomial
                    size = sum(abs(mpmath.mpf(int(sympy.numer(c))) / int(sympy.denom(c))) * abs(z) ** i for i, c in enumerate(reversed(d.all_coeffs())))
                    v = abs(mpmath.polyval([mpmath.mpf(int(sympy.numer(c))) / int(sympy.denom(c)) for c in d.all_coeffs()], z))
                    small = v <= 1e-13 * size if order < k else v > 1e-11 * size
                    self.tally.check(small or not size, f"{label}: {member} {order}", f"{re}, {im}, {k}: {v}")

    def response(self, label, t, forms):
        r = t["response"]
        E, A, B, C, D = [mpmath.matrix(M.rows, M.cols) if 0 in M.shape else mpmath.matrix([[mpmath.mpf(int(x.p)) / int(x.q) for x in M.row(i)] for i in range(M.rows)]) for M in forms]
        for row in r["rows"]:
            w, got = mpmath.mpc(0, row[0]), row[1:]
            M = w * E - A
            singular = abs(sympy.Matrix(M.tolist()).det()) < 1e-25
            if any(x is None for x in got) or singular:     # a pole, or one of a mode that inputs do not reach
                here = sympy.Rational(row[0]) * sympy.I
                for x, text in zip(got[::2], [text for line in t["matrix"] for text in line]):
                    den = sympy.denom(sympy.together(sympy.sympify(text.replace("^", "**"), rational=True)))
                    self.tally.check(singular and (x is None) == (sympy.expand(den.subs(S, here)) == 0), f"{label}: {text} at {row[0]}", str(got))
                continue
            G = C * (mpmath.inverse(M) * B) + D
            k = 0
            for i in range(G.rows):
                for j in range(G.cols):
                    value = mpmath.mpc(got[k], got[k + 1])
                    self.tally.check(abs(value - G[i, j]) <= (r["relative_error"] + mpmath.mpf(10) ** -25) * abs(G[i, j]) + mpmath.mpf(10) ** -30,
                                     f"{label}: response at {row[0]}", f"{value}, {mpmath.nstr(G[i, j], 20)}")
                    k += 2

    def case(self, case):
        label, request = case["name"], case["request"]
        t = self.solve(label, request)
        if t is None:
            return
        for path, value in case["expect"]["transfer"].items():
            here = t
            for key in path.split("."):
                here = here[int(key) if key.isdigit() else key]
            self.tally.check(here == value, f"{label}: {path}", f"is {here!r}, should be {value!r}")
        if t["matrix"] is not None and request["system"]["form"] == "descriptor" and "parameters" not in request["system"] and "inputs" not in request.get("transfer", {}) \
                and "outputs" not in request.get("transfer", {}):
            forms = given(request["system"])
            if t["matrix"] is not None:
                self.values(label, t, forms)
            if "response" in t and forms[0].rows == forms[0].cols:
                self.response(label, t, forms)

    def built(self, k):
        """Random equations: E of any rank, some with more rows (sums of others, or outputs that hold)."""
        n, m, p = random.randint(1, 4), random.randint(1, 2), random.randint(1, 2)

        def matrix(rows, cols, most=3):
            return [[random.choice([0, random.randint(-most, most)]) for _ in range(cols)] for _ in range(rows)]
        E, A, B, C, D = matrix(n, n), matrix(n, n), matrix(n, m), matrix(p, n), matrix(p, m)
        for i in range(n):
            if random.random() < 0.4:
                E[i] = [0] * n
        if random.random() < 0.3:                    # one more row, which follows from the others
            w = [random.randint(-2, 2) for _ in range(n)]
            for M in (E, A, B):
                M.append([sum(a * M[i][j] for i, a in enumerate(w)) for j in range(len(M[0]))])
        system = {"form": "descriptor", "states": [f"x{i}" for i in range(n)], "inputs": [f"u{i}" for i in range(m)], "outputs": [f"y{i}" for i in range(p)],
                  "E": E, "A": A, "B": B, "C": C, "D": D}
        forms = given(system)
        pencil = S * forms[0] - forms[1]
        whole = pencil.row_join(forms[2])
        if pencil.rank(simplify=True) < n or whole.rank(simplify=True) > n:
            result, problem = self.solver.solve({"system": system, "want": ["transfer"]})
            determined = pencil.col_join(forms[3]).rank(simplify=True) == pencil.rank(simplify=True)
            bound = whole.rank(simplify=True) > pencil.rank(simplify=True)
            if bound or not determined:
                self.tally.check(result is None and problem["code"] == "inputs_mismatch", f"built {k}: no transfer matrix", str(problem or result))
            return
        t = self.solve(f"built {k}", {"system": system, "want": ["transfer"], "transfer": {"frequencies": [0, "1/3", 1, 250]}})
        if t is not None:
            self.values(f"built {k}", t, forms)
            if pencil.rows == n:
                self.response(f"built {k}", t, forms)

    def equilibrium(self):
        """A nonlinear system at rest: rational there (exact), and at a point that no rational number is (response only)."""
        pendulum = {"form": "equations", "variables": ["a", "w", "u"], "equations": ["a' = w", "w' = -3*sin(a) - w/2 + u"]}
        t = self.solve("pendulum", {"system": pendulum, "want": ["transfer"], "trajectory": {"initial": {"a": 0, "w": 0, "u": 0}},
                                    "transfer": {"inputs": ["u"], "outputs": ["a"], "frequencies": [0, 2]}})
        if t is not None:
            self.tally.check(t["matrix"] == [["2/(2*s^2 + s + 6)"]] and t["evidence"]["from"] == "linearization", "pendulum: matrix", str(t))
        t = self.solve("pendulum held aside", {"system": pendulum, "want": ["transfer"], "trajectory": {"initial": {"a": 0.5, "w": 0, "u": 1.438276615812609}},
                                               "transfer": {"inputs": ["u"], "outputs": ["a"], "frequencies": [0.7]}})
        if t is not None:
            expected = 1 / (mpmath.mpc(0, mpmath.mpf("0.7")) ** 2 + mpmath.mpc(0, mpmath.mpf("0.35")) + 3 * mpmath.cos(mpmath.mpf("0.5")))
            row = t["response"]["rows"][0]
            self.tally.check(t["matrix"] is None and abs(mpmath.mpc(row[1], row[2]) - expected) <= (t["response"]["relative_error"] + 1e-14) * abs(expected),
                             "pendulum held aside: response", str(t))

    def moving(self, k):
        """x' = F x + G u, y = C x + D u over Q[t], z = H x + K u beside it, in equations mixed by a regular matrix."""
        t, T = sympy.Symbol("t"), range
        n, m, p = random.randint(1, 3), random.randint(1, 2), random.randint(1, 2)
        dead = random.randint(0, 1) if n > 1 else 0         # the last states are reached by no input, nor by the others

        def entry(degree=1):
            return sum(sympy.Rational(random.randint(-2, 2)) * t**i for i in T(degree + 1))

        def matrix(rows, cols, degree=1):
            return sympy.Matrix(rows, cols, [entry(degree) for _ in T(rows * cols)])
        F, G, C, D, H, K = matrix(n, n), matrix(n, m), matrix(p, n), matrix(p, m, 0), matrix(1, n), matrix(1, m)
        for i in T(n - dead, n):
            G[i, :] = sympy.zeros(1, m)
            for j in T(n - dead):
                F[i, j] = 0
        x, u = [f"x{i}" for i in T(n)], [f"u{i}" for i in T(m)]

        def row(M, i, names, tail=""):
            return " + ".join(f"({str(M[i, j]).replace('**', '^')})*{name}{tail}" for j, name in enumerate(names))
        plain = [f"x{i}' - ({row(F, i, x)}) - ({row(G, i, u)})" for i in T(n)] + [f"z - ({row(H, 0, x)}) - ({row(K, 0, u)})"]
        mixed = [f"({e}) + ({random.randint(-2, 2)} + t)*({plain[(i + 1) % len(plain)]})" if i < len(plain) - 1 else f"({e})*(t^2 + 1)" for i, e in enumerate(plain)]
        outputs = [f"{row(C, i, x)} + {row(D, i, u)}" for i in T(p)]
        answers = []
        for label, equations in (("plain", plain), ("mixed", mixed)):
            names = [*x, "z", *u]
            random.shuffle(names)
            got = self.solve(f"moving {k}, {label}", {"system": {"form": "equations", "variables": names, "equations": [f"{e} = 0" for e in equations]}, "want": ["transfer"],
                                                      "transfer": {"inputs": u, "outputs": outputs}})
            if got is None:
                return
            answers.append(got)
        if "fraction" not in answers[0]:                    # it was constant after all
            return
        self.tally.check(answers[0]["fraction"] == answers[1]["fraction"], f"moving {k}: the same however mixed", f"{answers[0]} {answers[1]}")
        left, right = ([[[sympy.sympify(c.replace("^", "**"), rational=True) for c in e] for e in r] for r in answers[0]["fraction"][key]] for key in ("left", "right"))
        order = max([len(e) for r in left + right for e in r] + [1])
        signal = sympy.Matrix(m, 1, [entry(3) for _ in T(m)])
        reach, step = G, G
        for _ in T(n - 1):
            step = F * step - step.diff(t)
            reach = reach.row_join(step)
        reached = reach.rank(simplify=True)                 # states that are not reached stay at 0; else any start does
        start = sympy.Matrix(n, 1, [sympy.Rational(random.randint(-5, 5)) if reached == n - dead and i < n - dead else 0 for i in T(n)])
        derived, M, r = [], C, D * signal
        for _ in T(order):                                   # y^(i) = M x + r
            derived.append((M, r))
            M, r = (M.diff(t) + M * F).applyfunc(sympy.expand), (r.diff(t) + M * G * signal).applyfunc(sympy.expand)
        at = sympy.Rational(random.randint(20, 90), 37)
        y = [(M * start + r).subs(t, at) for M, r in derived]
        v = [signal.diff(t, i).subs(t, at) if i else signal.subs(t, at) for i in T(order)]
        for i in T(p):
            total = sum(c.subs(t, at) * y[d][j] for j in T(p) for d, c in enumerate(left[i][j])) - sum(c.subs(t, at) * v[d][j] for j in T(m) for d, c in enumerate(right[i][j]))
            self.tally.check(total == 0, f"moving {k}: row {i}", f"{answers[0]['fraction']} {F} {G} {C} {D}")
        orders = [max(len(e) for e in r) for r in left]
        self.tally.check(answers[0]["proper"] and answers[0]["strictly_proper"] == all(len(e) < orders[i] for i, r in enumerate(right) for e in r), f"moving {k}: proper", str(answers[0]))
        self.tally.check(sum(orders) - p <= reached, f"moving {k}: no more modes than inputs reach", f"{left} {n} {dead}")

    def moving_refused(self):
        cases = [("frequencies", ["x' = t*x + u"], {"inputs": ["u"], "outputs": ["x"], "frequencies": [1]}, "not_supported", "/transfer/frequencies"),
                 ("inputs bound", ["x' = t*x + u", "u = t"], {"inputs": ["u"], "outputs": ["x"]}, "inputs_mismatch", "/transfer/inputs"),
                 ("an output left open", ["x' = t*w + u"], {"inputs": ["u"], "outputs": ["x"]}, "inputs_mismatch", "/transfer/outputs"),
                 ("no rational function", ["x' = sin(t)*x + u"], {"inputs": ["u"], "outputs": ["x"]}, "not_supported", "/want"),
                 ("no linear system", ["x' = t*x^2 + u"], {"inputs": ["u"], "outputs": ["x"]}, "not_supported", "/want")]
        for label, equations, ask, code, place in cases:
            names = ["x", "u"] + (["w"] if "w" in equations[0] else [])
            result, problem = self.solver.solve({"system": {"form": "equations", "variables": names, "equations": equations}, "want": ["transfer"], "transfer": ask,
                                                 "trajectory": {"initial": {"x": 0, "u": 0}}})
            self.tally.check(result is None and problem["code"] == code and problem["pointer"] == place, f"moving, refused: {label}", str(problem or result))

    def text(self):
        """sga solve --text shows every member of the result, or says which it leaves out."""
        request = {"system": {"form": "descriptor", "states": ["x"], "inputs": ["u"], "outputs": ["y"], "A": [[-1]], "B": [[1]], "C": [[1]]},
                   "want": ["constraints", "index", "vector_field", "gauge", "structure", "symmetries", "transfer", "linearization"],
                   "symmetries": {"check": [{"name": "time", "field": {"x": "0"}}]}}
        program = os.path.join(ROOT, build_folder(), "sga")
        said, result = (subprocess.run([program, "solve", "-", how], input=json.dumps(request), capture_output=True, text=True, check=False) for how in ("--text", "--json"))
        if self.tally.check(said.returncode == 0 and result.returncode == 0, "text: solved", said.stderr + result.stderr):
            words = {"dimensions": "dimensions:", "index": "index:", "vector_field": "reduced vector field", "gauge": "gauge freedom"}
            for member, value in json.loads(result.stdout).items():
                self.tally.check(words.get(member, member) in said.stdout or value == [], f"text: {member} is shown", said.stdout)
            self.tally.check("1/(s + 1)" in said.stdout, "text: the transfer matrix", said.stdout)

    def run(self):
        random.seed(seed(19))
        with open(os.path.join(ROOT, "tests", "cases", "transfer.json"), encoding="utf-8") as f:
            cases = json.load(f)
        for case in cases:
            if "transfer" in case["expect"]:
                self.case(case)
        for k in range(scaled(60)):
            self.built(k)
        self.equilibrium()
        self.text()
        for k in range(scaled(40)):
            self.moving(k)
        self.moving_refused()
        return self.tally.end()


sys.exit(Check().run())
