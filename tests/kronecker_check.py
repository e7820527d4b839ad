"""The Kronecker structure by other routes: kronecker_check.py BUILD_DIR

- every case: what the pencil says about generations, gauge and dimension is what the reduction found;
- random small pencils: indices from exact ranks of expanded (Toeplitz) matrices, the characteristic
  polynomial from determinants in SymPy, eigenvalues from mpmath's roots;
- extremes, whose structure is known because they were built from it.
"""
import random
import sys
from fractions import Fraction

import mpmath
import sympy

import linear
import schemas
from cases import load
from solver import Solver
from tally import Tally, build_folder, scaled, seed


def request(A, B, **more):
    n = len(A[0])
    return {"system": {"form": "linear", "variables": [f"x{i}" for i in range(n)],
                       "A": [[str(a) for a in r] for r in A], "B": [[str(b) for b in r] for r in B]},
            "want": ["structure", "index", "gauge"], **more}


def transposed(M):
    return [list(c) for c in zip(*M)]


def nullity(rows, n):
    return n - (linear.rank(rows) if rows else 0)


def expanded(A, B, count, closed):
    """A x_1 = 0, A x_(j+1) = B x_j for `count` vectors; closed: and B x_count = 0."""
    n = len(A[0])
    rows = []
    for j in range(count + closed):
        for a, b in zip(A, B):
            row = [Fraction(0)] * (n * count)
            for c in range(n):
                if j < count:
                    row[j * n + c] = Fraction(a[c])
                if j:
                    row[(j - 1) * n + c] = -Fraction(b[c])
            rows.append(row)
    return nullity(rows, n * count)


def minimal_indices(A, B):
    """#(index k) is the second difference of the dimensions of polynomial kernels of degree k."""
    found, dims, n = [], [0, 0], len(A[0])
    for k in range(n + 1):
        dims.append(expanded(A, B, k + 1, True))
        found += [k] * (dims[-1] - 2 * dims[-2] + dims[-3])
    return found


def infinite_blocks(A, B, rights):
    """Chains of length k: min(k, size) for each block, and k for each right index."""
    at_least, before = [], 0
    while True:
        now = expanded(A, B, len(at_least) + 1, False)
        if now - before == rights:
            break
        at_least.append(now - before - rights)
        before = now
    return [sum(1 for a in at_least if a > i) for i in range(at_least[0] if at_least else 0)]


class Check:
    def __init__(self):
        self.tally = Tally("kronecker")
        self.solver = Solver(build_folder())
        self.schema = schemas.validator("result")

    def same(self, label, what, is_, should):
        self.tally.check(is_ == should, f"{label}: {what}", f"is {is_!r}, should be {should!r}")

    def ask(self, label, body):
        result, problem = self.solver.solve(body)
        if problem:
            self.tally.check(False, label, str(problem))
            return None, None
        fault = schemas.faults(self.schema, result)
        self.tally.check(not fault, f"{label}: schema", fault)
        return result, result["structure"]["kronecker"]

    def relations(self, label, result, k):
        """Generations, gauge and dimension of the constraint set."""
        rows_rank = sum(k["right"]) + sum(k["left"]) + sum(k["infinite"]) + k["finite"]
        self.same(label, "rank", k["normal_rank"], rows_rank)
        if k["eigenvalues"] is not None:
            self.same(label, "eigenvalues", sum(e[2] for e in k["eigenvalues"]), k["finite"])
            self.same(label, "blocks", [sum(b) for b in k["jordan"]], [e[2] for e in k["eigenvalues"]])
        if result["verdict"] == "inconsistent":
            return
        self.same(label, "generations", result["index"]["generations"], max([k["nilpotency"]] + k["left"]))
        self.same(label, "gauge", result["gauge"]["dimension"], len(k["right"]))
        self.same(label, "dimension", result["dimensions"]["final"], k["finite"] + sum(e + 1 for e in k["right"]))

    def cases(self):
        linear_ones = 0
        for case in load([]):
            if "error" in case["expect"] or "body" in case or case["request"].get("trajectory"):
                continue
            body = {**case["request"], "want": ["structure", "index", "gauge"], "limits": {"seconds": 300, **case["request"].get("limits", {})}}      # on a busy machine too
            body.pop("symmetries", None)
            result, problem = self.solver.solve(body)
            if problem:
                self.tally.check(False, case["name"], str(problem))
                continue
            k = result["structure"]["kronecker"]
            self.tally.check(result.get("kronecker", {"reason": k.get("reason")}) == k, case["name"])
            if "regular" in k:
                linear_ones += 1
                self.relations(case["name"], result, k)
            elif case["request"]["system"]["form"] == "linear":
                self.tally.check(False, case["name"], k["reason"])
        self.tally.check(linear_ones >= 20, "linear cases", str(linear_ones))

    def polynomial(self, label, A, B, k):
        """det(s A - B) and the product of the factors are proportional; its roots are the eigenvalues."""
        s = sympy.Symbol("s")
        det = sympy.Poly(sympy.expand((s * sympy.Matrix(A) - sympy.Matrix(B)).det(method="berkowitz")), s)
        ours, last = sympy.Poly(1, s), sympy.Poly(1, s)
        for f in k["factors"]:
            p = sympy.Poly([sympy.Integer(c) for c in reversed(f["polynomial"])], s)
            ours *= p ** f["multiplicity"]
            last *= p ** f["blocks"][0]
            if p.degree() == 1:
                at = [[Fraction(int(-p.nth(0)), int(p.nth(1))) * Fraction(a) - Fraction(b) for a, b in zip(x, y)]
                      for x, y in zip(A, B)]
                self.same(label, "nullity at an eigenvalue", nullity(at, len(A)), len(f["blocks"]))
        self.same(label, "characteristic polynomial", ours.monic(), det.monic())
        factors = [sympy.Poly([sympy.Integer(c) for c in reversed(f)], s) for f in k["invariant_factors"]]
        if factors:
            self.same(label, "minimal polynomial", factors[-1].monic(), last.monic())
            self.tally.check(all(b.rem(a).is_zero for a, b in zip(factors, factors[1:])), f"{label}: divisors")
        self.roots(label, k)

    def roots(self, label, k):
        should = []
        with mpmath.workdps(60):
            for f in k["factors"]:
                found = mpmath.polyroots([mpmath.mpf(int(c)) for c in reversed(f["polynomial"])], maxsteps=500, extraprec=400)
                should += [tuple(float(x) if abs(x) > mpmath.mpf(10) ** -50 else 0.0 for x in (r.real, r.imag)) for r in map(mpmath.mpc, found)]
        self.same(label, "eigenvalues", sorted((float(a), float(b)) for a, b, _ in k["eigenvalues"]), sorted(should))

    def random_pencils(self, rng):
        for i in range(scaled(60)):
            m, n = rng.randint(1, 4), rng.randint(1, 4)
            n = m if i % 2 else n
            entry = lambda: Fraction(rng.choice([0, 0, 0, 1, -1, 2, 3]), rng.choice([1, 1, 3]))
            A, B = ([[entry() for _ in range(n)] for _ in range(m)] for _ in range(2))
            label = f"random {A} {B}"
            result, k = self.ask(label, request(A, B))
            if not k:
                continue
            self.same(label, "right", k["right"], minimal_indices(A, B))
            self.same(label, "left", k["left"], minimal_indices(transposed(A), transposed(B)))
            self.same(label, "infinite", k["infinite"], infinite_blocks(A, B, len(k["right"])))
            self.same(label, "basis", k["basis"], "proved")
            self.relations(label, result, k)
            self.same(label, "regular", k["regular"], m == n and not k["right"])
            if k["regular"]:
                self.polynomial(label, A, B, k)

    def expect(self, label, A, B, should, relations=True, **more):
        result, k = self.ask(label, request(A, B, **more))
        if not k:
            return None
        for key, value in should.items():
            self.same(label, key, k[key], value)
        if relations:
            self.relations(label, result, k)
        return k

    def extremes(self, rng):
        n = 60
        shift = [[int(j == i - 1) for j in range(n)] for i in range(n)]
        one = [[int(i == j) for j in range(n)] for i in range(n)]
        self.expect("index 60", shift, one, {"infinite": [60], "nilpotency": 60, "finite": 0, "eigenvalues": [], "regular": True})
        sizes = [5, 4, 2, 1]
        J = [[0] * 12 for _ in range(12)]
        at = 0
        for s in sizes:
            for i in range(s):
                J[at + i][at + i] = Fraction(-1, 3)
                if i + 1 < s:
                    J[at + i][at + i + 1] = 1
            at += s
        A, B = self.mixed(rng, [[int(i == j) for j in range(12)] for i in range(12)], J)
        self.expect("twelvefold", A, B, {"eigenvalues": [[-1 / 3, 0, 12]], "jordan": [sizes],
                                          "factors": [{"polynomial": ["1", "3"], "multiplicity": 12, "blocks": sizes}]})
        near = [Fraction(1), 1 + Fraction(1, 10 ** 30), Fraction(1)]
        A, B = self.mixed(rng, [[int(i == j) for j in range(3)] for i in range(3)],
                          [[near[i] if i == j else int((i, j) == (0, 2)) for j in range(3)] for i in range(3)])
        k = self.expect("equal to 30 digits", A, B, {"jordan": [[2], [1]]})
        if k:
            self.same("equal to 30 digits", "multiplicities", [e[2] for e in k["eigenvalues"]], [2, 1])
        tiny = [[1, 1, 0], [1, 1 + Fraction(1, 10 ** 14), 0], [0, 0, 0]]
        self.expect("a pivot of 1e-14", tiny, [[1, 0, 0], [0, 1, 0], [0, 0, 1]], {"finite": 2, "infinite": [1]})
        big, small = Fraction(10) ** 150, Fraction(1, 10 ** 150)
        A = [[1, 2, 0, 1], [0, 1, 1, 0], [1, 3, 1, 1], [0, 0, 0, 0]]
        B = [[2, 0, 1, 0], [1, 1, 0, 3], [0, 1, 0, 2], [1, 0, 0, 1]]
        plain = self.expect("plain", A, B, {"regular": True})
        r, c = [big, small, 1, small], [1, small, big, 3 * big]
        scale = lambda M: [[M[i][j] * r[i] * c[j] for j in range(4)] for i in range(4)]
        k = self.expect("scaled by 1e300", scale(A), scale(B), {"basis": "proved"})
        self.same("scaled by 1e300", "structure", k, plain)
        slow = self.expect("units of time", [[big * a for a in x] for x in A[:3]] + [A[3]], B, {})
        if slow and plain:
            for key in ("finite", "infinite", "nilpotency", "right", "left"):
                self.same("units of time", key, slow[key], plain[key])
        k = self.expect("thirty digits", [[1, 0], [0, 1]], [[0, 1], [2, 0]], {}, accuracy={"rtol": 1e-14})
        if k:
            self.same("sqrt 2", "eigenvalues", k["eigenvalues"], [[-2 ** 0.5, 0, 1], [2 ** 0.5, 0, 1]])

    def operators(self, rng):
        """A1 y' + A0 y = e: the operator index is the nilpotency."""
        for i in range(scaled(12)):
            n = rng.randint(2, 4)
            A0, A1 = ([[rng.choice([0, 0, 1, -1, 2]) for _ in range(n)] for _ in range(n)] for _ in range(2))
            body = {"system": {"form": "operator", "unknowns": [f"y{j}" for j in range(n)], "coefficients": [A0, A1]}}
            label = f"operator {A0} {A1}"
            result, problem = self.solver.solve(body)
            if problem:
                self.tally.check(False, label, str(problem))
                continue
            k = result["kronecker"]
            self.same(label, "full rank", k["regular"], result["solvable"])
            self.same(label, "rank", k["normal_rank"], result["rank"])
            _, other = self.ask(label, request(A1, [[-a for a in r] for r in A0]))
            self.same(label, "as a linear system", k, other)
            if k["regular"]:
                self.same(label, "index", result["index"]["operator"], k["nilpotency"])
                self.same(label, "state", result["state"]["dimension"], k["finite"])

    @staticmethod
    def mixed(rng, A, B):
        """The same pencil in other bases."""
        n = len(A)
        while True:
            P, Q = ([[Fraction(rng.randint(-2, 2)) for _ in range(n)] for _ in range(n)] for _ in range(2))
            if linear.rank(P) == n == linear.rank(Q):
                break
        mul = lambda X, Y: [[sum(a * b for a, b in zip(x, y)) for y in zip(*Y)] for x in X]
        return mul(mul(P, A), Q), mul(mul(P, B), Q)

    def forms(self):
        """What is linear in other forms, and what is not."""
        def kind(system, **parameters):
            system = {**system, "parameters": parameters} if parameters else system
            return self.ask(str(system)[:200], {"system": system, "want": ["structure", "index", "gauge"]})
        result, k = kind({"form": "equations", "variables": ["x", "y"], "equations": ["x'' = -x + y", "0 = x - sin(t)"]})
        self.same("second order", "infinite", k.get("infinite"), [3])
        result, k = kind({"form": "equations", "variables": ["x", "y"], "equations": ["x' = r*y", "0 = r*x - y"]}, r=None)
        self.same("symbolic", "basis", k.get("basis"), "generic")
        self.same("symbolic", "eigenvalues", k.get("eigenvalues", 0), None)
        self.same("symbolic", "finite", k.get("finite"), 1)
        result, k = kind({"form": "lagrangian", "coordinates": ["q"], "lagrangian": "q'^2/2 - q^2/2"})
        self.same("oscillator", "eigenvalues", k.get("eigenvalues"), [[0, -1, 1], [0, 1, 1]])
        for text, word in [("x' = -x^2", "not linear"), ("x' = t*x", "constant coefficients"), ("x' = sign(x)", "linear"),
                           ("x' = atan(x) + atan(1/x)", "linear"), ("x' = cos(1)*x", "rational"), ("t*x' = x", "time"),
                           ("x' = sqrt(2)*x", "rational")]:
            result, k = kind({"form": "equations", "variables": ["x"], "equations": [text]})
            self.tally.check(k is not None and "regular" not in k and word in k["reason"], text, str(k))
        many = [f"x{i}" for i in range(2001)]
        result, k = kind({"form": "quasilinear", "variables": many, "A": {"rows": 1, "cols": 2001, "entries": [[0, 0, 1]]}, "alpha": ["x1"]})
        self.tally.check(k is not None and "2000" in k.get("reason", ""), "a large pencil", str(k)[:300])
        for text in ("x' = (x + 1)^2 - x^2 - 1", "x' = x + sin(x)^2 + cos(x)^2", "x' = 2*x*(sin(t)^2 + cos(t)^2) + exp(t)", "2*x' = 4*x + cos(1)"):
            result, k = kind({"form": "equations", "variables": ["x"], "equations": [text]})
            self.tally.check(k is not None and "regular" in k, text, str(k))


def main():
    check = Check()
    rng = random.Random(seed(20260402))
    check.forms()
    check.extremes(rng)
    check.random_pencils(rng)
    check.operators(rng)
    check.cases()
    return check.tally.end()


if __name__ == "__main__":
    sys.exit(main())
