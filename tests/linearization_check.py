"""Linearizations by other routes: linearization_check.py BUILD_DIR

- every case of tests/cases/linearization.json: about an equilibrium, or where all is constant, the state form and the given equations have one
  transfer matrix at random s, and their finite eigenvalues are the same in number and place; elsewhere A and B are difference quotients of
  the reduced field at consistent starts beside the point;
- random descriptor systems that were built from their modes: eigenvalues, what inputs reach and outputs show, and transfer matrices in
  rational arithmetic;
- computed motions beside an equilibrium against exp(A t);
- symbolic linearizations, at random places: the given equations' matrices against the numeric linearization there, the state form's against difference
  quotients of the reduced field in its own coordinates;
- places where pivots vanish: chains of rods at right angles;
- freedom that is taken of least norm: random constant systems in rational arithmetic, and a nonlinear one against difference quotients;
Refusals are cases as others are.
"""
import json
import os
import random
import sys
from fractions import Fraction

import mpmath
import sympy

import schemas
import start_check
from solver import Solver
from tally import ROOT, Tally, build_folder, scaled, seed

mpmath.mp.dps = 30


def numbers(M, cols):
    """Exact texts as fractions, doubles as they are; a matrix of SymPy, which has a shape without rows or columns too."""
    return sympy.Matrix(len(M), cols, [sympy.Rational(x) if isinstance(x, str) else sympy.Float(repr(float(x)), 30) for row in M for x in row])


class Form:
    def __init__(self, item, member):
        form, n, m = item[member], len(item[member]["names"]), len(item["inputs"])
        self.A, self.B = numbers(form["A"], n), numbers(form["B"], m)
        self.C, self.D = numbers(form["C"], n), numbers(form["D"], m)
        self.E = numbers(form["E"], n) if "E" in form else sympy.eye(n)
        self.exact = all(isinstance(x, str) for k in "EABCD" if k in form for row in form[k] for x in row)

    def transfer(self, s):
        """C (s E - A)^-1 B + D; None: there is none, or more than one."""
        M, n = s * self.E - self.A, self.A.cols
        if M.rows != n:
            if not self.exact or M.rank() < n:
                return None
            solution = (M.T * M).LUsolve(M.T * self.B)
        elif n == 0:
            return self.D
        else:
            solution = M.LUsolve(self.B) if self.B.cols else self.B
        return self.C * solution + self.D


def close(a, b, tolerance):
    return all(abs(x - y) <= tolerance * (1 + abs(x)) for x, y in zip(a, b))


class Check:
    def __init__(self):
        self.tally, self.solver, self.schema = Tally("linearization"), Solver(build_folder(), number=float), schemas.validator("result")

    def solve(self, label, request):
        result, problem = self.solver.solve(request)
        if not self.tally.check(result is not None, label, str(problem)):
            return None
        fault = schemas.faults(self.schema, result)
        self.tally.check(not fault, f"{label}: schema", fault)
        return result

    def eigenvalues(self, label, item, given):
        """det(s E - A) has as many roots as there are states, and vanishes at each."""
        if given.A.rows != given.A.cols or not given.exact or not given.A.rows:
            return
        s = sympy.Symbol("s")
        det = sympy.Poly((s * given.E - given.A).det(method="berkowitz"), s)
        total = sum(e[2] for e in item["eigenvalues"])
        self.tally.check(det.degree() == total == len(item["state"]["names"]), f"{label}: how many eigenvalues", f"{det.degree()}, {total}")
        roots = [r for r, k in sympy.roots(det, multiple=False).items() for _ in range(k)] if det.degree() <= 2 else \
            [r for f, k in det.factor_list()[1] for r in sympy.Poly(f, s).nroots(n=25, maxsteps=200) for _ in range(k)]
        mine = sorted([complex(*e[:2]) for e in item["eigenvalues"] for _ in range(e[2])], key=lambda z: (round(z.real, 8), round(z.imag, 8)))
        theirs = sorted([complex(r) for r in roots], key=lambda z: (round(z.real, 8), round(z.imag, 8)))
        self.tally.check(close(mine, theirs, 1e-12), f"{label}: eigenvalues", f"{mine}, {theirs}")

    def one_transfer(self, label, item):
        state, given = Form(item, "state"), Form(item, "descriptor")
        for _ in range(2):
            s = sympy.Rational(random.randint(1, 500), 23) + sympy.Rational(1, 29)    # no eigenvalue of a small matrix of small numbers
            a, b = state.transfer(s), given.transfer(s)
            if b is None:
                return
            exact = state.exact and given.exact
            same = a == b if exact else close(a, b, 1e-11)
            self.tally.check(same, f"{label}: transfer matrix at {s}", f"{a}, {b}")
        if label.startswith("linearization"):    # of what was built they are known
            self.eigenvalues(label, item, given)

    def quotients(self, label, request, item):
        """A, B as difference quotients of the reduced field at starts where states and inputs are held."""
        names, inputs = item["state"]["names"], [u for u in item["inputs"] if u in item["point"]]
        h = 1e-5
        for col, name in enumerate(names + inputs):
            rates = []
            for sign in (1, -1):
                start = {**item["point"], name: item["point"][name] + sign * h}
                side = {"system": request["system"], "want": ["consistent_initial"],
                        "trajectory": {"start": item["t"], "initial": start, "hold": names + inputs}}
                result = self.solve(f"{label}: beside", side)
                if result is None:
                    return
                rates.append(result["consistent_initial"]["derivatives"])
            form = item["state"]["A"] if col < len(names) else item["state"]["B"]
            k = col if col < len(names) else item["inputs"].index(name)
            for row, z in enumerate(names):
                expected = (rates[0][z] - rates[1][z]) / (2 * h)
                value = float(Fraction(form[row][k])) if isinstance(form[row][k], str) else form[row][k]
                self.tally.check(abs(value - expected) <= 1e-6 * (1 + abs(value)), f"{label}: d({z}')/d({name})", f"{value}, {expected}")

    def case(self, case):
        name, request = case["name"], case["request"]
        result = self.solve(name, request)
        if result is None:
            return
        for k, item in enumerate(result["linearization"]):
            label = f"{name} [{k}]"
            self.tally.check(len(item["state"]["names"]) == result["dimensions"]["final"] - sum(u in [v["name"] for v in result["variables"]] for u in item["inputs"]),
                             f"{label}: states")
            if item["evidence"]["constant"] or item["evidence"]["equilibrium"]:
                self.one_transfer(label, item)
            if item["point"] is not None:
                self.quotients(label, request, item)
            for path, value in case["expect"]["linearization"].items():
                at = item
                for key in path.split("."):
                    at = at[key]
                self.tally.check(at == value, f"{label}: {path}", f"is {at!r}, should be {value!r}")
        if "along" in case["expect"]:
            self.along(name, result["linearization"], case["expect"]["along"])
        if case["expect"].get("linear_motion"):
            self.motion(name, request, result["linearization"][0])

    def along(self, name, items, expect):
        """Closed forms, place by place: exact where a motion is, within its error where it was computed."""
        self.tally.check(len(items) == len(expect), f"{name}: places", str(len(items)))
        for k, (item, should) in enumerate(zip(items, expect)):
            for path, matrix in should.items():
                form, letter = path.split(".")
                got = [float(Fraction(x)) if isinstance(x, str) else x for row in item[form][letter] for x in row]
                values = [float(sympy.sympify(x, rational=True)) for row in matrix for x in row]
                self.tally.check(len(got) == len(values) and close(got, values, 1e-9), f"{name} [{k}]: {path}", f"{got}, {values}")

    def built(self, k):
        """A descriptor system of known modes: P diag(I, N) Q x' = P diag(J, I) Q x + P [B1; B2] u with N B2 = 0, so that it is proper."""
        n, fast, m, p = random.randint(1, 4), random.randint(0, 3), random.randint(1, 2), random.randint(1, 2)
        size = n + fast
        modes = [random.randint(-4, 3) for _ in range(n)]
        J = sympy.diag(*modes)
        N = sympy.zeros(fast, fast)
        for i in range(fast - 1):
            N[i, i + 1] = random.choice([0, 1])
        B1 = sympy.Matrix(n, m, lambda *_: random.randint(-2, 2))
        B2 = sympy.Matrix(fast, m, lambda i, j: 0 if i and N[i - 1, i] else random.randint(-2, 2))
        C = sympy.Matrix(p, n, lambda *_: random.randint(-2, 2))
        C2 = sympy.Matrix(p, fast, lambda *_: random.randint(-2, 2))
        while True:
            P, Q = (sympy.Matrix(size, size, lambda *_: random.randint(-2, 2)) for _ in range(2))
            if P.det() and Q.det():
                break
        E, A, B = P * sympy.diag(sympy.eye(n), N) * Q, P * sympy.diag(J, sympy.eye(fast)) * Q, P * B1.col_join(B2)
        out = C.row_join(C2) * Q
        names, inputs = [f"x{i}" for i in range(size)], [f"u{i}" for i in range(m)]
        request = {"system": {"form": "linear", "variables": names, "A": [[str(x) for x in E.row(i)] for i in range(size)],
                              "B": [[str(x) for x in A.row(i)] for i in range(size)], "C": [[str(x) for x in B.row(i)] for i in range(size)], "inputs": inputs},
                   "want": ["linearization"],
                   "linearization": {"outputs": [" + ".join(f"({out[i, j]})*x{j}" for j in range(size)) for i in range(p)]}}
        label = f"built {k}"
        result = self.solve(label, request)
        if result is None:
            return
        item = result["linearization"][0]
        expected = sorted([e, 0, modes.count(e)] for e in set(modes))
        self.tally.check(item["eigenvalues"] == expected, f"{label}: modes", f"{item['eigenvalues']}, {expected}")
        self.one_transfer(label, item)
        for member, part, M in (("controllable", "uncontrollable", B1), ("observable", "unobservable", C.T)):
            missed = []
            for e in sorted(set(modes)):
                rows = M.extract([i for i in range(n) if modes[i] == e], list(range(M.cols)))
                left = rows.rows - rows.rank()
                if left:
                    missed.append([e, 0, left])
            got = item[member]
            self.tally.check(got["dimension"] == n - sum(x[2] for x in missed) and got[part] == missed, f"{label}: {member}", f"{got}, {missed}")
        stability = "unstable" if max(modes) > 0 else "asymptotic" if max(modes) < 0 else "marginal"
        self.tally.check(item["stability"] == stability and item["stable"] == (stability != "unstable"), f"{label}: stability", str(item["stability"]))

    def motion(self, name, request, item):
        """A motion from beside the equilibrium is exp(A t) of the deviation, to second order."""
        names, d, stop = item["state"]["names"], 1e-5, 0.7
        start = {**item["point"], names[0]: item["point"][names[0]] + d}
        result = self.solve(f"{name}: motion", {"system": request["system"], "want": ["trajectory"], "accuracy": {"rtol": 1e-12},
                                                "trajectory": {"stop": stop, "samples": 2, "initial": start, "hold": names, "outputs": names}})
        if result is None:
            return
        A = mpmath.matrix([[mpmath.mpf(Fraction(x).numerator) / Fraction(x).denominator if isinstance(x, str) else x for x in row] for row in item["state"]["A"]])
        column = mpmath.expm(A * stop)[:, 0]
        for k, z in enumerate(names):
            moved = (result["trajectory"]["rows"][-1][k + 1] - item["point"][z]) / d
            self.tally.check(abs(moved - column[k]) < 1e-3, f"{name}: exp(A t) for {z}", f"{moved}, {column[k]}")

    def at_place(self, M, env):
        """Expressions of an answer as numbers."""
        def value(text):
            plain = text.replace("'", "_rate_").replace("^", "**")
            return float(sympy.sympify(plain, locals={k.replace("'", "_rate_"): sympy.Symbol(k.replace("'", "_rate_")) for k in env}).subs({k.replace("'", "_rate_"): v for k, v in env.items()}))
        return [[value(x) for x in row] for row in M]

    def symbolic(self, label, system, ask, values, near):
        request = {"system": {**system, "parameters": {k: None for k in values}}, "want": ["linearization"], "linearization": {**ask, "symbolic": True}}
        result = self.solve(f"{label}: symbolic", request)
        if result is None:
            return
        (item,) = result["linearization"]
        numeric = {"system": {**system, "parameters": values}, "want": ["linearization"], "linearization": {k: v for k, v in ask.items() if k != "symbolic"},
                   "trajectory": {"start": 0.3, "initial": {k: v + random.uniform(-0.2, 0.2) for k, v in near.items()}}}
        result = self.solve(f"{label}: numeric", numeric)
        if result is None:
            return
        (place,) = result["linearization"]
        env = {**{k: float(Fraction(v)) for k, v in values.items()}, **place["point"], "t": place["t"]}
        for member in ("state", "descriptor"):
            item[member].update({k: self.at_place(item[member][k], env) for k in "EFABCD" if k in item[member]})
        for k in "EFABCD":
            if k in place["descriptor"]:
                same = [float(Fraction(x)) if isinstance(x, str) else x for row in place["descriptor"][k] for x in row]
                self.tally.check(close([x for row in item["descriptor"][k] for x in row], same, 1e-9), f"{label}: descriptor {k}", f"{item['descriptor'][k]}, {same}")
        item.update(point=place["point"], t=place["t"])
        self.quotients(label, numeric, item)
        if item["state"]["names"] == place["state"]["names"]:
            for k in "ABCD":
                same = [float(Fraction(x)) if isinstance(x, str) else x for row in place["state"][k] for x in row]
                self.tally.check(close([x for row in item["state"][k] for x in row], same, 1e-9), f"{label}: state {k}", f"{item['state'][k]}, {same}")

    def symbolics(self):
        pendulum = {"form": "equations", "variables": ["x", "y", "lam", "u"], "equations": ["x'' = -lam*x + u*y", "y'' = -lam*y - g", "x^2 + y^2 = L^2"]}
        self.symbolic("pendulum", pendulum, {"inputs": ["u"], "outputs": ["lam", "x*u"]}, {"g": "9.81", "L": "3/2"}, {"x": 0.9, "y": -1.2, "x'": 0.4, "u": 0.3})
        loop = {"form": "equations", "variables": ["a", "b", "w", "u", "v"], "equations": ["a' = -k*a^2 + u*b", "b' = sin(a) - b + v", "w^3 + w = a*b + c*t*u"]}
        self.symbolic("algebraic", loop, {"inputs": ["u", "v"], "outputs": ["w", "a*w + u"]}, {"k": "2", "c": "1/3"}, {"a": 0.5, "b": -0.4, "u": 0.2, "v": 1.1})
        scaled_rates = {"form": "equations", "variables": ["p", "q", "u"], "equations": ["(1 + p^2)*p' + q*q' = u - m*p", "q' - p*p' = p*q"]}
        self.symbolic("coefficients", scaled_rates, {"inputs": ["u"], "outputs": ["p*q"]}, {"m": "3"}, {"p": 0.6, "q": 0.3, "u": -0.7})
        self.symbolic("control", {"form": "control", "variables": ["x", "y"], "inputs": ["u"], "F": ["y^2", "-k*x"], "G": [["0", "1 + x^2"]], "constraints": []}, {"outputs": ["x*y"]}, {"k": "1/2"},
                      {"x": 0.4, "y": 0.7, "u": 0.1})
        self.symbolic("rod", {"form": "lagrangian", "coordinates": ["x", "y"], "lagrangian": "m*(x'^2 + y'^2)/2 - m*g*y", "holonomic": ["x^2 + 2*y^2 - 1"]}, {"outputs": ["lambda1"]},
                      {"m": "2", "g": "3"}, {"x": 0.5, "y": -0.6, "x'": 0.2})
        for label, system, ask, code, place in [
                ("freedom", {"form": "equations", "variables": ["x", "u"], "equations": ["x' = u"]}, {}, "inputs_mismatch", "/linearization/inputs"),
                ("determined", {"form": "equations", "variables": ["x", "u"], "equations": ["x' = u", "u = x"]}, {"inputs": ["u"]}, "inputs_mismatch", "/linearization/inputs"),
                ("differentiated", {"form": "equations", "variables": ["x", "z", "u"], "equations": ["z' = x", "x = u^2"]}, {"inputs": ["u"], "outputs": ["x'"]}, "derivative_not_allowed", "/linearization/outputs/0"),
                ("a place", {"form": "equations", "variables": ["x"], "equations": ["x' = -x"]}, {"at": "start"}, "invalid_request", "/linearization/at"),
                ("no truth", {"form": "equations", "variables": ["x"], "equations": ["x' = -x"]}, {"symbolic": 1}, "invalid_request", "/linearization/symbolic")]:
            result, problem = self.solver.solve({"system": system, "want": ["linearization"], "linearization": {"symbolic": True, **ask}})
            self.tally.check(result is None and problem["code"] == code and problem["pointer"] == place, f"symbolic, refused: {label}", str(problem or result))

    def least_norm(self, k):
        """P x' = Q x, C x = 0, of full rank together, with rows for the inputs' rates: velocities by the normal equations, in rational arithmetic."""
        n = random.randint(3, 6)
        c, p = random.randint(0, 1), random.randint(1, n - 2)
        m = random.randint(0, n - c - p)

        def entries(rows, cols):
            return sympy.Matrix(rows, cols, [sympy.Rational(random.randint(-3, 3), random.randint(1, 2)) for _ in range(rows * cols)])
        P, Q, C = entries(p, n), entries(p, n), entries(c, n)
        inputs = sorted(random.sample(range(n), m))
        K = sympy.Matrix.vstack(P, C, sympy.Matrix(m, n, lambda i, j: int(inputs[i] == j)))
        if K.rank() < K.rows or (c and sympy.Matrix([[C[0, j] for j in range(n) if j not in inputs]]).is_zero_matrix):
            return
        names = [f"x{j}" for j in range(n)]

        def text(row, tail=""):
            return " + ".join(f"({v})*{names[j]}{tail}" for j, v in enumerate(row)) or "0"
        request = {"system": {"form": "equations", "variables": names, "equations": [f"{text(P.row(i), chr(39))} = {text(Q.row(i))}" for i in range(p)] + [f"{text(C.row(i))} = 0" for i in range(c)]},
                   "want": ["linearization", "index"], "linearization": {"gauge": "least norm", "inputs": [names[j] for j in inputs]}}
        result = self.solve(f"least norm {k}", request)
        if result is None:
            return
        (item,) = result["linearization"]
        state = [names.index(z) for z in item["state"]["names"]]
        solve = K.T * (K * K.T).inv()
        rate, moved = solve[:, :p] * Q, solve[:, p + c:]
        # x by the states and inputs, from C x = 0
        chosen = state + inputs
        follow = [j for j in range(n) if j not in chosen]
        phi = sympy.zeros(n, len(chosen))
        for i, j in enumerate(chosen):
            phi[j, i] = 1
        if follow:
            phi[follow[0], :] = -C.extract([0], chosen) / C[0, follow[0]]
        full, b = rate.extract(state, list(range(n))) * phi, moved.extract(state, list(range(m)))
        A, B = full[:, :len(state)], full[:, len(state):]
        self.tally.check((item.get("gauge") == "least norm") == (K.rows < n), f"least norm {k}: is said", f"{item.get('gauge')}, {K.rows} of {n}")
        shift = numbers(item["state"]["shift"], m) if "shift" in item["state"] else sympy.zeros(len(state), m)
        self.tally.check(len(state) == n - c - m and numbers(item["state"]["A"], len(state)) == A and shift == b and numbers(item["state"]["B"], m) == B + A * b, f"least norm {k}",
                         f"{request} {item['state']} {A} {B} {b}")

    def least_norm_along(self):
        """A nonlinear system: the field of least norm at places of its set, differentiated there; the symbolic form too."""
        names = ["x", "y", "z", "w"]
        system = {"form": "equations", "variables": names, "equations": ["x' + y*z' = y + w", "y' - x*z' + w' = sin(x)", "z = x*y"]}

        def velocity(v):
            K = mpmath.matrix([[1, 0, v["y"], 0], [0, 1, -v["x"], 1], [-v["y"], -v["x"], 1, 0]])
            return K.T * mpmath.lu_solve(K * K.T, mpmath.matrix([v["y"] + v["w"], mpmath.sin(v["x"]), 0]))
        places = [{"x": 0.4, "y": -0.7, "w": 0.2}, {"x": -1.1, "y": 0.3, "w": 0.9}]
        ask = {"gauge": "least norm", "outputs": ["z*w"]}
        result = self.solve("least norm along", {"system": system, "want": ["linearization"], "linearization": {**ask, "at": [{"values": v} for v in places]}})
        written = self.solve("least norm, symbolic", {"system": system, "want": ["linearization"], "linearization": {**ask, "symbolic": True}})
        if result is None or written is None:
            return
        for item in result["linearization"]:
            for state, given in ((item["state"], item["state"]["A"]), (written["linearization"][0]["state"], None)):
                free = state["names"]
                if given is None:
                    given = self.at_place(state["A"], {**item["point"], "t": 0})

                def along(name, h):
                    v = {k: mpmath.mpf(item["point"][k]) for k in names}
                    v[name] += h
                    follow = next(k for k in names if k not in free)
                    v[follow] = {"z": lambda: v["x"] * v["y"], "x": lambda: v["z"] / v["y"], "y": lambda: v["z"] / v["x"]}[follow]()
                    return [velocity(v)[names.index(k)] for k in free]
                for col, name in enumerate(free):
                    h = mpmath.mpf(10) ** -8
                    slope = [(a - b) / (2 * h) for a, b in zip(along(name, h), along(name, -h))]
                    self.tally.check(close(slope, [mpmath.mpf(row[col]) for row in given], 1e-7), f"least norm along {free}", f"{name}: {slope} {given}")

    def least_norms(self):
        for k in range(scaled(40)):
            self.least_norm(k)
        self.least_norm_along()
        for label, ask, code, place in [("a choice of another name", {"gauge": "least"}, "invalid_request", "/linearization/gauge"),
                                        ("a determined input", {"gauge": "least norm", "inputs": ["s"]}, "inputs_mismatch", "/linearization/inputs"),
                                        ("inputs that depend on each other", {"gauge": "least norm", "inputs": ["p", "q"]}, "inputs_mismatch", "/linearization/inputs"),
                                        ("no choice", {"inputs": ["p"]}, "inputs_mismatch", "/linearization/inputs")]:
            request = {"system": {"form": "equations", "variables": ["p", "q", "r", "s"], "equations": ["p' = q' + r", "s' = -s"]}, "want": ["linearization"], "linearization": ask}
            result, problem = self.solver.solve(request)
            self.tally.check(result is None and problem["code"] == code and problem["pointer"] == place, f"least norm, refused: {label}", str(problem or result))

    def hung(self, k):
        """A chain of rods at right angles, pushed by an input: at such places pivots of the general reduction vanish. At zeros it is what it is at places
        beside them, as characteristic polynomials see it (in one choice of states, on which it depends where nothing is at rest)."""
        request, zeros, _ = start_check.hung(random)
        system = request["system"]
        system["equations"] = [e + " + F" if e.startswith("x0''") else e for e in system["equations"]]
        system["variables"].append("F")
        beside = {name: v for name, v in request["trajectory"]["initial"].items()}
        found, states, told = [], [], True
        for initial in (zeros, beside):
            result, problem = self.solver.solve({"system": system, "want": ["linearization"], "trajectory": {"initial": {**initial, "F": 0}}, "linearization": {"inputs": ["F"]}})
            if not self.tally.check(result is not None, f"hung {k}: {system['equations']}, {initial}", str(problem)):
                return
            states.append(sorted(result["linearization"][0]["state"]["names"]))
            found.append([complex(re, im) for re, im, times in result["linearization"][0]["eigenvalues"] for _ in range(times)])
            error = result["linearization"][0]["evidence"].get("eigenvalue_error", 0)
            told = told and error < 1e-6
            self.tally.check(error <= 0.1 * max([1] + [abs(v) for v in found[-1]]), f"hung {k}: {system['equations']}, {initial}", f"eigenvalues to {error}: {found[-1]}")
        if states[0] != states[1] or not told:
            return
        size = max([1] + [abs(v) for v in found[0]])
        one, other = (sympy.Poly(sympy.prod([sympy.Symbol("s") - v / size for v in of]), sympy.Symbol("s")).all_coeffs() for of in found)
        off = max(abs(complex(a - b)) for a, b in zip(one, other)) if len(one) == len(other) else mpmath.inf
        self.tally.check(off < 1e-9, f"hung {k}: {system['equations']}, {zeros}", f"off by {off}: {found}")

    def run(self):
        random.seed(seed(18))
        with open(os.path.join(ROOT, "tests", "cases", "linearization.json"), encoding="utf-8") as f:
            cases = json.load(f)
        for case in cases:
            if "error" not in case["expect"]:
                self.case(case)
        for k in range(scaled(25)):
            self.built(k)
        self.symbolics()
        self.least_norms()
        for k in range(scaled(20)):
            self.hung(k)
        return self.tally.end()


sys.exit(Check().run())
