"""Symmetries by other routes: symmetry_check.py BUILD_DIR

Determining equations by SymPy for random polynomial fields on all of the space; flows of
found symmetries applied to trajectories, of all forms (symmetry_flow.py); dimensions under random linear changes
of variables. SGA_TEST_SEED repeats a run, SGA_TEST_SCALE makes it longer."""
import itertools
import random
import sys

import mpmath
import sympy

import symmetry_flow
from solver import Solver
from symmetry_case import Texts
from tally import Tally, build_folder, scaled, seed


def monomials(x, degree):
    return [sympy.Mul(*c) for d in range(degree + 1) for c in itertools.combinations_with_replacement(x, d)]


def equations_of(expressions, unknowns, x):
    """Coefficients of all monomials in x, as rows in the unknowns."""
    rows = []
    for e in expressions:
        for c in sympy.Poly(sympy.expand(e), *x).coeffs():
            rows.append([c.coeff(u) for u in unknowns])
    return rows


def nullity(rows, count):
    return count - (sympy.Matrix(rows).rank() if rows else 0)


def determining(X, x, degree, time=None):
    """Dimension of the polynomial symmetries of x' = X(x, t), with a time component where time is given."""
    y = x + ([time] if time else [])
    basis = monomials(y, degree)
    u = [[sympy.Symbol(f"u{i}_{k}") for k in range(len(basis))] for i in range(len(y))]
    D = [sum(c * b for c, b in zip(r, basis)) for r in u]
    flow = X + ([sympy.Integer(1)] if time else [])
    along = lambda F, f: sum(a * sympy.diff(f, v) for a, v in zip(F, y))
    slow = along(flow, D[-1]) if time else 0
    conditions = [along(D, X[i]) - along(flow, D[i]) + slow * X[i] for i in range(len(x))]
    unknowns = [c for r in u for c in r]
    return nullity(equations_of(conditions, unknowns, y), len(unknowns))


def integrals(X, x, degree):
    basis = monomials(x, degree)
    u = [sympy.Symbol(f"u{k}") for k in range(len(basis))]
    F = sum(c * b for c, b in zip(u, basis))
    e = sum(a * sympy.diff(F, v) for a, v in zip(X, x))
    return nullity(equations_of([e], u, x), len(u)) - 1      # constants


class Check:
    def __init__(self):
        self.tally, self.solver = Tally("symmetry"), Solver(build_folder())

    def ask(self, label, request):
        try:
            result, problem = self.solver.solve(request)
        except Exception as e:
            self.tally.check(False, label, str(e))
            return None
        return result if self.tally.check(result is not None, label, str(problem)) else None

    def same(self, label, is_, should):
        self.tally.check(is_ == should, label, f"is {is_}, should be {should}")

    def request(self, names, right, search, start=None):
        text = lambda e: str(e).replace("**", "^")
        r = {"system": {"form": "quasilinear", "variables": names, "A": [[int(i == j) for j in range(len(names))] for i in range(len(names))],
                        "alpha": [text(e) for e in right]}, "want": ["symmetries"], "symmetries": {"search": search}}
        if start:
            r["trajectory"] = {"initial": start}
        return r

    def random_fields(self, rng, count):
        """Sparse polynomial fields; most have few symmetries, built ones have more."""
        for k in range(count):
            n = rng.choice([2, 2, 3])
            x = list(sympy.symbols(f"x1:{n + 1}"))
            if rng.random() < 0.4:
                X = [sum(rng.choice([0, 0, 1, -1, 2]) * v for v in x) for _ in x]
            else:
                X = [sum(rng.choice([0, 0, 0, 1, -1]) * m for m in monomials(x, 2)) for _ in x]
            X = [sympy.sympify(e) for e in X]
            degree, time = rng.choice([1, 2]), rng.random() < 0.3
            degree = 1 if time else degree
            label = f"random {k}: {X}, degree {degree}, time {time}"
            result = self.ask(label, self.request([str(v) for v in x], X, {"degree": degree, "time": time}))
            if result is None:
                continue
            s = result["symmetries"]
            self.same(label, len(s["found"]), determining(X, x, degree, sympy.Symbol("t") if time else None))
            self.same(label + ": complete", s["search"]["fields"]["complete"], True)
            if not time:
                self.same(label + ": integrals", len(s["first_integrals"]), integrals(X, x, degree + 1))

    def changes(self, rng, count):
        """x = T y changes no dimension of fields of degree 1; constraints and gauge freedom take part."""
        systems = [(["x", "y", "z"], [["1", "0", "0"], ["0", "1", "0"], ["0", "0", "0"]], ["y", "-x", "x+y-z"]),
                   (["x", "y", "z"], [["0", "1", "0"], ["-1", "0", "0"], ["0", "0", "0"]], ["x", "y", "0"]),
                   (["x", "y", "z"], [["1", "0", "0"], ["0", "0", "0"], ["0", "0", "0"]], ["z*y", "x^2+y^2-1", "0"]),
                   (["x", "y", "z", "w"], [["1", "0", "0", "0"], ["0", "1", "0", "0"], ["0", "0", "0", "0"]], ["z", "w", "x*y-1"])]
        for names, A, alpha in systems:
            seen = set()
            for k in range(count + 1):
                n = len(names)
                T = sympy.eye(n)
                for _ in range(n if k else 0):
                    i, j = rng.sample(range(n), 2)
                    T[i, :] += rng.choice([-2, -1, 1, 2]) * T[j, :]
                x = sympy.symbols(names)
                there = dict(zip(x, T * sympy.Matrix(x)))
                M = sympy.Matrix(A).applyfunc(sympy.sympify).subs(there, simultaneous=True) * T
                a = [sympy.expand(sympy.sympify(e).subs(there, simultaneous=True)) for e in alpha]
                r = self.request(names, a, {"degree": 1})
                r["system"]["A"] = [[str(M[i, j]).replace("**", "^") for j in range(n)] for i in range(len(A))]
                result = self.ask(f"change {k} of {alpha}", r)
                if result:
                    s = result["symmetries"]
                    if not all(s["search"][part]["complete"] for part in ("fields", "integrals")):
                        self.tally.check(k > 0 and bool(s["search"]["fields"]["reason"]), f"change {k} of {alpha}: says why not", str(s["search"]))
                        continue
                    seen.add((len(s["found"]), sum(f["gauge"] for f in s["found"]), len(s["first_integrals"])))
            self.tally.check(len(seen) == 1, f"dimensions of {alpha} under changes of variables", str(seen))

    def flows(self, rng, count):
        """exp(s D) takes a trajectory to a solution: integrated by mpmath from the moved start, it meets the moved end."""
        systems = [(["x1", "x2"], ["x2", "-x1"]), (["x1", "x2"], ["x1*x2", "-x2^2"]), (["x1", "x2", "x3"], ["x2*x3", "-2*x1*x3", "x1*x2"]),
                   (["x1", "x2"], ["x2", "0"]), (["x1", "x2"], ["x1", "2*x2+x1^2"])]
        for names, right in systems:
            time = right == ["x2", "0"]
            result = self.ask(f"flow of {right}", self.request(names, right, {"degree": 2, "time": time}))
            if result is None:
                continue
            fields = result["symmetries"]["found"]
            for f in rng.sample(fields, min(count, len(fields))):
                self.one_flow(rng, names, right, f["field"])

    def one_flow(self, rng, names, right, field):
        text = Texts([*names, "t"])
        y = [text.symbol[n] for n in [*names, "t"]]
        X = sympy.lambdify(y, [text(e) for e in right] + [sympy.Integer(1)], "mpmath")
        D = sympy.lambdify(y, [text(field.get(n, "0")) for n in [*names, "t"]], "mpmath")
        s = mpmath.mpf(rng.randint(1, 9)) / 100
        start = [mpmath.mpf(rng.randint(-9, 9)) / 10 for _ in names] + [mpmath.mpf(0)]
        with mpmath.workdps(20):
            def go(F, z, span):
                return mpmath.odefun(lambda _, v: F(*v), 0, z)(span) if span >= 0 else mpmath.odefun(lambda _, v: [-a for a in F(*v)], 0, z)(-span)
            end = go(X, start, mpmath.mpf("0.3"))
            moved_start, moved_end = go(D, start, s), go(D, end, s)
            again = go(X, moved_start, moved_end[-1] - moved_start[-1])
            error = max(abs(a - b) for a, b in zip(again, moved_end))
        self.tally.check(error < mpmath.mpf(10) ** -12, f"flow of {field} on {right}", f"misses by {mpmath.nstr(error, 5)}")


def main():
    check = Check()
    rng = random.Random(seed(20260714))
    check.random_fields(rng, scaled(16))
    check.changes(rng, scaled(3))
    check.flows(rng, scaled(3))
    symmetry_flow.run(check.tally, check.solver, rng, scaled(2))
    return check.tally.end()


if __name__ == "__main__":
    sys.exit(main())
