"""Singular's own reduction as a third opinion: singular_check.py BUILD_DIR [NAME...]

For systems of polynomials and rational functions (functions of time alone become variables
with their differential equations). P_k is kept as a prime ideal over Q. The next generation
is the closure of the projection of (S intersected with the tangent spaces): the velocities are
eliminated, denominators saturated, the radical taken apart into primes, and the one goes on
that contains the printed constraints up to that generation. Compared are the dimension of each
generation, that the printed constraints lie in its ideal, and that nothing new follows in the
end. Both sets then share a component: the constraints are independent, so an ideal of the same
dimension above them is one of its components. Sets over the complex numbers cannot show
that there is no real point; such cases and those that take too long are counted and skipped.
"""
import os
import signal
import subprocess
import sys
import time
from fractions import Fraction

import sympy as sp

import cases
from expression import EXACT, Undefined
from identities import Answer
from solver import Solver
from tally import Tally, build_folder

SECONDS = 2       # of CPU, for SymPy's part and for Singular's, each
COMPARED = 150    # cases at the least
LARGEST = 12      # variables


# Sets that have fewer real points than complex ones; the second has a component 1 + x2^2 = 0. The third has another component,
# l1 = l2 = 0, where all printed constraints vanish too: the start tells which one is meant, which it does in irrational numbers.
BEYOND = {"sum of squares of velocities", "control, transversality condition", "published: catalyst mixing, on the singular arc"}


class Cannot(Exception):
    """Singular cannot follow: functions of the state, or not a polynomial."""


class Algebra:
    """Expressions of one answer as polynomials in names that Singular reads."""

    def __init__(self, answer):
        p = self.problem = answer.problem
        self.answer = answer
        self.x = {n: sp.Symbol(f"x{i}") for i, n in enumerate(answer.names)}
        self.v = {"@" + n: sp.Symbol(f"v{i}") for i, n in enumerate(answer.names)}
        self.parameters = {n: sp.Symbol(f"a{i}") for i, n in enumerate(p.parameters)}
        self.t = sp.Symbol("t")
        self.symbols = {**self.x, **self.v, **self.parameters, p.time: self.t}
        self.new, self.rates, self.base = {}, {self.t: sp.Integer(1)}, []
        self.angle = self.power = None

    def function(self, f):
        """A function of time alone as a variable."""
        u = f.args[0]
        if f.func not in (sp.sin, sp.cos, sp.exp) or u.free_symbols - {self.t} or not u.is_polynomial(self.t) or not u.has(self.t):
            raise Cannot("functions")
        s, c, e = sp.symbols("s c e")
        if f.func is sp.exp:
            if self.power not in (None, u):
                raise Cannot("two exponentials")
            self.power = u
            self.rates[e] = e * sp.diff(u, self.t)
            return e
        if self.angle not in (None, u):
            raise Cannot("two angles")
        if self.angle is None:
            self.base.append(s**2 + c**2 - 1)
        self.angle = u
        self.rates[s], self.rates[c] = c * sp.diff(u, self.t), -s * sp.diff(u, self.t)
        return s if f.func is sp.sin else c

    def fraction(self, node):
        """Numerator and denominator with integer coefficients, each up to a factor."""
        e = self.answer.graph.sympy(node, self.symbols)
        e = e.xreplace({f: self.function(f) for f in e.atoms(sp.Function)} | {f: self.function(f) for f in e.atoms(sp.exp)})
        if e.atoms(sp.Function) or e.has(sp.pi):
            raise Cannot("functions")
        top, bottom = sp.fraction(sp.together(e))
        names = sorted({*self.symbols.values(), *self.rates}, key=str)
        try:
            return [sp.Poly(part, *names, domain="QQ").clear_denoms()[1].as_expr() for part in (top, bottom)]
        except (sp.PolynomialError, sp.polys.polyerrors.CoercionFailed) as e:
            raise Cannot("not a polynomial") from e


def written(e):
    return sp.sstr(e).replace("**", "^")


def everywhere(answer, text):
    """Does a function vanish at points of the printed set?"""
    node = answer.graph.parse(text)
    for env in answer.sample([e for _, e in answer.constraints], 1):
        try:
            return abs(answer.graph.values(answer.graph.cone([node]), env, EXACT)[node]) < 1e-20
        except Undefined:
            pass
    return False


def points_elsewhere(a, result):
    """Points of the parts of the set that are not the one that was solved, as rational numbers."""
    return [[f"{v.numerator}/{v.denominator}" for v in (Fraction(s["point"][n]) for n in a.x)]
            for s in result.get("strata", []) if s["kind"] == "branch" and s.get("point")]


def script(answer, result):
    a = Algebra(answer)
    rows = [a.fraction(r) for r in a.problem.rows]
    restrict = [a.fraction(r)[0] for r in a.problem.restrict]
    constraints = [(g, *a.fraction(e)) for g, e in answer.constraints]
    avoided = []    # where it is not: the printed strata of one function
    for stratum in result.get("strata", []):
        if len(stratum.get("where", [])) == 1 and stratum.get("kind") != "side" and not everywhere(answer, stratum["where"][0]):
            try:
                avoided.append(written(a.fraction(answer.graph.parse(stratum["where"][0]))[0]))
            except Cannot:
                pass
    elsewhere = points_elsewhere(a, result) if not a.rates.keys() - {a.t} and not a.parameters else []
    below = sorted({written(sp.factor_list(b)[1][i][0]) for _, b in rows for i in range(len(sp.factor_list(b)[1]))})
    if "e" in map(str, a.rates):
        below.append("e")
    clock = [str(n) for n in a.rates] if any(r.free_symbols & set(a.rates) for r, _ in rows) or restrict or a.base else []
    state, speed = [str(s) for s in a.x.values()], [str(s) for s in a.v.values()]
    ring = f"(0,{','.join(map(str, a.parameters.values()))})" if a.parameters else "0"
    tangent = " + ".join([f"diff(g,{x})*{v}" for x, v in zip(state, speed)] + [f"diff(g,{n})*({written(a.rates[sp.Symbol(n)])})" for n in clock])
    last = max([g for g, *_ in constraints], default=0)
    empty = result["verdict"] == "inconsistent"
    lines = ['LIB "primdec.lib";', "option(noredefine);", f"ring R = {ring},({','.join(state + clock + speed)}),dp;",
             f"ideal B = {', '.join(map(written, a.base)) or '0'};", f"ideal S = {', '.join(written(r) for r, _ in rows) or '0'};",
             f"ideal M = {', '.join(map(written, restrict)) or '0'};", f"poly W = {'*'.join(f'({b})' for b in below) or '1'};",
             f"poly V = {'*'.join(speed)};",
             f"proc along(poly g) {{ return({tangent}); }}",
             "proc next(ideal P, int tangency) { int i; ideal Q = P + S; P = interred(P);",
             "  if (tangency) { for (i = 1; i <= ncols(P); i++) { Q = Q + ideal(along(P[i])); } }",
             "  if (deg(W) > 0) { Q = sat(Q, ideal(W))[1]; } return(std(eliminate(Q, V))); }",
             f"list E = {', '.join(avoided) or '1'};",
             "proc outside(ideal Q) { int i; for (i = 1; i <= size(E); i++) { if (reduce(E[i], Q) == 0) { return(0); } } return(1); }",
             "proc near(poly g) { number n = leadcoef(g); if (n < 0) { n = -n; } return(g == 0 or n < 1/100000000); }",
             "proc through(ideal Q, ideal at) { int i; for (i = 1; i <= ncols(Q); i++) { if (not near(subst_all(Q[i], at))) { return(0); } } return(1); }",
             f"proc subst_all(poly g, ideal at) {{ {' '.join(f'g = subst(g, {x}, at[{i + 1}]);' for i, x in enumerate(state))} return(g); }}",
             *(f"ideal at{k} = {', '.join(p)};" for k, p in enumerate(elsewhere)),
             f"proc met(ideal Q) {{ {' '.join(f'if (through(Q, at{k})) {{ return(0); }}' for k in range(len(elsewhere)))} return(1); }}",
             "proc pick(ideal P, ideal C, int d) { int i; int s; int most; ideal Q; list L; if (P[1] == 1) { return(P); } L = minAssGTZ(P); ideal best = 1;",
             "  for (i = 1; i <= size(L); i++) { Q = std(L[i]); if (size(reduce(C, Q)) == 0 and outside(Q))",
             "    { s = 1 + 2 * (dim(Q) == d) + met(Q); if (s >= most) { best = Q; most = s; } } } return(best); }",
             f"int off = {len(speed)}; ideal P = std(B + M); ideal C; int k; int d;"]
    shift = len(speed) + len(clock) - len(a.base)    # what dim counts beside the state
    if empty:
        lines += ["for (k = 1; k <= 40; k++) { ideal Q = next(P, k > 1); if (Q[1] == 1) { \"EMPTY\"; quit; }",
                  "  Q = std(radical(Q)); if (k > 1 and size(reduce(Q, P)) == 0) { \"STABLE\"; quit; } P = Q; }"]
    else:
        for k in range(1, last + 1):
            c = ", ".join(written(t) for g, t, _ in constraints if g <= k)
            d = result["dimensions"]["generations"][k - 1]
            lines += [f"C = {c};", f"P = pick(next(P, {int(k > 1)}), C, {d + shift}); \"GENERATION {k}\", dim(P) - {shift};"]
        lines += [f"ideal F = next(P, {int(last > 0)}); \"END\", size(reduce(F, P)), F[1] == 1;"]
        if not last:
            lines[-1] = "ideal F = next(P, 0); \"END\", size(reduce(F, P)), F[1] == 1;"
        lines += [f"ideal T = P + S; ideal G = interred(P); for (k = 1; k <= ncols(G); k++) {{ T = T + ideal(along(G[k])); }}",
                  f"if (deg(W) > 0) {{ T = sat(T, ideal(W))[1]; }} \"FIBRE\", dim(std(T)) - (dim(P) - {len(speed)});"]
    return "\n".join(lines + ["quit;"]) + "\n"


def ask(text):
    run = subprocess.run(["sh", "-c", f"ulimit -t {SECONDS}; exec Singular -q --no-warn --no-rc"], input=text, capture_output=True, text=True, check=False)
    if run.returncode < 0:
        raise Cannot("takes too long")
    said = {}
    for line in run.stdout.splitlines():
        word, *rest = line.split()[:3] or [""]
        said.setdefault(word, []).append(rest)
    if "?" in said or "END" not in said and "EMPTY" not in said and "STABLE" not in said:
        raise RuntimeError(run.stdout[-600:])
    return said


def late(*_):
    raise Cannot("takes too long")


def compare(tally, name, answer, result):
    signal.setitimer(signal.ITIMER_VIRTUAL, SECONDS)
    try:
        text = script(answer, result)
    finally:
        signal.setitimer(signal.ITIMER_VIRTUAL, 0)
    said = ask(text)
    if result["verdict"] == "inconsistent":
        if "EMPTY" not in said:
            raise Cannot("no real point, which is not seen over the complex numbers")
        tally.check(True, name)
        return
    dims = [int(d) for _, d in said.get("GENERATION", [])]
    tally.check(dims == result["dimensions"]["generations"], f"{name}: dimensions", f"{result['dimensions']['generations']}, Singular {dims}")
    left, empty = said["END"][0]
    tally.check(left == "0" and empty == "0", f"{name}: stable", f"{left} more constraints follow, empty: {empty}")
    fibre = int(said["FIBRE"][0][0])
    tally.check(fibre >= result["gauge"]["dimension"], f"{name}: gauge", f"{result['gauge']['dimension']}, Singular {fibre}")


def main():
    signal.signal(signal.SIGVTALRM, late)
    tally = Tally("singular")
    solver = Solver(build_folder())
    compared, skipped = 0, {}
    for case in cases.reduced(sys.argv[2:]):
        name = case["name"]
        begun = time.time()
        if name in BEYOND:
            skipped.setdefault("real points", []).append(name)
            continue
        try:
            request = {k: v for k, v in case["request"].items() if k in ("system", "limits")}
            request["want"] = ["constraints", "index", "vector_field", "gauge"]
            if "initial" in case["request"].get("trajectory", {}):
                request["trajectory"] = case["request"]["trajectory"]
            result, problem = solver.solve(request)
            if problem or result["dimensions"]["ambient"] > LARGEST:
                raise Cannot("refused or large")
            if case["request"]["system"].get("tables"):
                raise Cannot("tables")
            if case["request"]["system"].get("modes"):
                raise Cannot("modes")         # mode_check.py sends each as a system of its own
            compare(tally, name, Answer(request, result), result)
            compared += 1
        except Cannot as e:
            skipped.setdefault(str(e)[:40], []).append(name)
        except Exception as e:
            tally.check(False, name, f"{type(e).__name__}: {e}")
        if os.environ.get("SGA_TEST_VERBOSE"):
            print(f"# {name}: {time.time() - begun:.2f} s", flush=True)
    print(f"{compared} compared, {sum(map(len, skipped.values()))} skipped: " + ", ".join(f"{len(n)} {why}" for why, n in sorted(skipped.items())))
    tally.check(bool(sys.argv[2:]) or compared >= COMPARED, "enough cases are compared", f"{compared}, should be {COMPARED} at least")
    return tally.end()


if __name__ == "__main__":
    sys.exit(main())
