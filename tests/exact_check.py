"""Systems with constant coefficients against plain fractions: exact_check.py BUILD_DIR

Random systems A x' = B x + c(t) of any shape, as several forms, with redundant rows, restrictions, decimals,
huge and tiny factors, and right sides that are combinations of 1, t, sin t and cos t. Verdict, dimensions of each
generation and of the gauge come from an elimination in fractions over variables and these functions, which are
independent and closed under the derivative. Every answer's identities are checked too, and that rows and variables in
another order give the same numbers.
"""
import random
import sys
from fractions import Fraction

import linear
from case_check import CaseCheck
from solver import Solver
from tally import Tally, build_folder, scaled, seed

FUNCTIONS = ("t", "sin(t)", "cos(t)", "1")
RATE = ((0, 0, 0, 1), (0, 0, 1, 0), (0, -1, 0, 0), (0, 0, 0, 0))      # of each, by function


def rate(c):
    return [sum(Fraction(a) * r[k] for a, r in zip(c, RATE)) for k in range(4)]


def independent(rows, n):
    """Rows (x | functions) that are independent in x, and whether they contradict each other."""
    work, pivots = linear.eliminate([list(map(Fraction, r)) for r in rows], n)
    return work[:len(pivots)], any(any(r[n:]) for r in work[len(pivots):])


def reduce(A, right, restrict):
    """A x' = right (x | functions); the same for the zero set of restrict."""
    n = len(right[0]) - 4 if right else len(restrict[0]) - 4
    held, contradiction = independent(restrict, n)
    dims, first = [], True
    while not contradiction:
        rows = [list(map(Fraction, a)) for a in A]
        sides = [list(map(Fraction, r)) for r in right]
        if not first:
            rows += [r[:n] for r in held]
            sides += [[Fraction(0)] * n + [-v for v in rate(r[n:])] for r in held]
        new = [[sum(z[i] * sides[i][j] for i in range(len(rows))) for j in range(n + 4)] for z in linear.left_kernel(rows)] if rows else []
        before = len(held)
        held, contradiction = independent(held + new, n)
        if contradiction:
            break
        if len(held) > before or (first and restrict and held):
            dims.append(n - len(held))
        elif not first or not restrict:
            break
        first = False
    if contradiction:
        return {"verdict": "inconsistent"}
    rows = [list(map(Fraction, a)) for a in A] + [r[:n] for r in held]
    gauge, final = n - (linear.rank(rows) if rows else 0), n - len(held)
    timed = any(any(r[n:n + 3]) for r in held) or any(any(r[n:n + 3]) for r in right)
    verdict = "underdetermined" if gauge else "unique" if final or timed else "isolated"
    return {"verdict": verdict, "generations": dims, "final": final, "gauge": gauge}


def text(row, names):
    return "+".join(f"({v})*{x}" if x != "1" else f"({v})" for v, x in zip(row, names) if v) or "0"


class Sample:
    """One random system."""

    def __init__(self, rng):
        self.n, self.m = rng.randint(1, 7), rng.randint(0, 8)
        self.rng = rng
        timed, forced = rng.random() < 0.5, rng.random() < 0.6
        rank = rng.randint(0, min(self.n, self.m))
        left, mid = self.matrix(self.m, rank), self.matrix(rank, self.n)
        self.A = [[sum(a * b for a, b in zip(r, c)) for c in zip(*mid)] if rank else [0] * self.n for r in left] if self.m else []
        self.right = [[self.entry() for _ in range(self.n)] + self.functions(timed, forced) for _ in range(self.m)]
        self.restrict = [[self.entry() for _ in range(self.n)] + self.functions(timed, forced) for _ in range(rng.choice((0, 0, 0, 1, 2)))]
        if self.m > 1 and rng.random() < 0.4:        # a row that follows
            i, k = rng.sample(range(self.m), 2)
            f = rng.choice((1, -2, Fraction(1, 3)))
            self.A[i] = [f * a for a in self.A[k]]
            self.right[i] = [f * b for b in self.right[k]]
        self.far = rng.random() < 0.15
        if self.far:
            f = rng.choice((Fraction(10) ** 150, Fraction(1, 10 ** 150)))
            self.A = [[f * a for a in r] for r in self.A]
            self.right = [[f * a for a in r] for r in self.right]

    def entry(self):
        return self.rng.choice((0, 0, 0, 1, -1, 2, 3, Fraction(1, 2), Fraction(1, 10), Fraction(-2, 3)))

    def functions(self, timed, forced):
        return [self.entry() if timed else 0 for _ in range(3)] + [self.entry() if forced else 0]

    def matrix(self, m, n):
        return [[self.rng.choice((0, 0, 1, -1, 2)) for _ in range(n)] for _ in range(m)]

    def request(self, rows, columns):
        """With rows and columns in these orders."""
        names = [f"x{j}" for j in range(self.n)] + list(FUNCTIONS)
        A = [[str(self.A[i][j]) for j in columns] for i in rows]
        order = list(columns) + list(range(self.n, self.n + 4))
        side = [text([self.right[i][j] for j in order], [names[j] for j in order]) for i in rows]
        restrict = [text([r[j] for j in order], [names[j] for j in order]) for r in self.restrict]
        return {"system": {"form": "quasilinear", "variables": [names[j] for j in columns], "A": A, "alpha": side, "restrict": restrict}}

    def equations(self):
        names = [f"x{j}" for j in range(self.n)]
        rows = [text(a, [x + "'" for x in names]) + " = " + text(b, names + list(FUNCTIONS)) for a, b in zip(self.A, self.right)]
        return {"system": {"form": "equations", "variables": names, "equations": rows}}


def expectation(found, n):
    keys = ("verdict",) if found["verdict"] == "inconsistent" else ("verdict", "generations", "final", "gauge")
    return {"ambient": n, **{k: found[k] for k in keys}}


class Check(CaseCheck):
    def far(self, name, request, expect):
        """The numbers alone: the identities are looked at with a tolerance that would need to know how far."""
        result, problem = self.solver.solve(request)
        if problem:
            self.tally.check(False, name, f"refused: {problem}")
            return
        size = result["dimensions"]
        found = {"ambient": size["ambient"], "verdict": result["verdict"]}
        if "final" in expect:
            found.update(generations=size["generations"], final=size["final"], gauge=result["gauge"]["dimension"])
        self.same(name, "numbers", found, expect)


def main():
    tally = Tally("exact")
    check = Check(tally, Solver(build_folder()))
    start = seed(7)
    for k in range(scaled(150)):
        s = Sample(random.Random(start * 1000003 + k))
        if not s.m:
            continue
        found = reduce(s.A, s.right, s.restrict)
        expect = expectation(found, s.n)
        rows, columns = s.rng.sample(range(s.m), s.m), s.rng.sample(range(s.n), s.n)
        requests = {f"random {k}": s.request(range(s.m), range(s.n)), f"random {k} in another order": s.request(rows, columns)}
        if not s.restrict and k % 3 == 0:
            requests[f"random {k} as equations"] = s.equations()
        for name, request in requests.items():
            if s.far:
                check.far(name, request, expect)
            else:
                check.run({"name": name, "source": f"own: random, seed {start}", "request": request, "expect": expect})
    sys.exit(tally.end())


if __name__ == "__main__":
    main()
