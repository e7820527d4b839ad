"""SymPy's own reduction as a second opinion: sympy_check.py BUILD_DIR [NAME...]

Verdict, dimensions and gauge dimension must agree; the printed constraints must vanish
identically on SymPy's Pf; the printed field must differ from SymPy's by gauge fields only. Every case of the corpus is
tried for a short time; what SymPy cannot follow is counted.
"""
import json
import os
import signal
import sys
import time

import sympy as sp

import cases
import sympy_sga
from identities import Answer
from problem import Problem
from solver import Solver
from tally import Tally, build_folder

# Cases that SymPy must do, however slow, and how it simplifies there
CHOSEN = {"arm numeric": sp.cancel, "arm symbolic": sp.cancel, "pendulum first order": sp.simplify, "diode circuit": sp.simplify,
          "restrict circle": sp.simplify, "sliding not transversal": sp.simplify, "squared velocity": sp.simplify}
# Where the plain reduction in SymPy is known to go wrong, and why
NOT_REAL = "SymPy's sets are complex"
DEPEND = "the checkers' equations vanish where restrictions depend"
BEYOND = {"the other root of a square": "one root is taken, whatever follows", "one root of a square": "one root is taken, whatever follows",
          "a square of a root": NOT_REAL, "no real circle": NOT_REAL, "exponential never vanishes": NOT_REAL,
          "a parameter dropped from a square": "no regular form", "one minus cosine": "no regular form", "one minus squared cosine": "no regular form",
          "irregular on the others": "no regular form", "nested radicals": "zeros are not found", "addition theorem": "zeros are not found",
          "sum of squares of velocities": NOT_REAL, "velocity without a real value": NOT_REAL,
          "restriction without a real zero": NOT_REAL, "constraint without a real point": NOT_REAL,
          "restrictions of which two follow": DEPEND, "restriction at an instant": "a contradiction in time is not looked for",
          "empty in general, not where a pivot vanishes": "strata are not looked at",
          "hamiltonian form, redundant restrictions": DEPEND}
SECONDS = 0.3     # of CPU, for each of the others
COMPARED = 120    # cases at the least
LARGEST = 8       # variables


class Late(Exception):
    """SymPy takes too long."""


def late(*_):
    raise Late


def symbolic(problem):
    """A, alpha, restrict and the symbols of a problem, in SymPy."""
    g = problem.graph
    names = set().union(*[g.names([e]) for e in problem.rows + problem.restrict])
    symbols = {n: sp.Symbol(n, positive=True) if n in problem.parameters else sp.Symbol(n)
               for n in names | set(problem.names) | set(problem.parameters) | {problem.time}
               | {"@" + n for n in problem.names}}
    speed = [symbols["@" + n] for n in problem.names]
    rows = [g.sympy(e, symbols) for e in problem.rows]
    still = {v: 0 for v in speed}
    A = [[sp.diff(r, v) for v in speed] for r in rows]
    alpha = [-r.subs(still) for r in rows]
    return A, alpha, [g.sympy(e, symbols) for e in problem.restrict], symbols


def reduce(request, names, simplify):
    problem = Problem(request, names)
    A, alpha, restrict, symbols = symbolic(problem)
    answer = sympy_sga.reduce(A, alpha, [symbols[n] for n in problem.names], restrict, symbols[problem.time], simplify)
    return answer, symbols


def compare(tally, name, request, result, simplify):
    names = [v["name"] for v in result["variables"]] if request["system"]["form"] == "equations" else None
    other, symbols = reduce(request, names, simplify)
    dims = result["dimensions"]
    tally.check(result["verdict"] == other["verdict"], f"{name}: verdict", f"{result['verdict']}, SymPy {other['verdict']}")
    if other["verdict"] == "inconsistent":
        return
    tally.check(dims["generations"] == other["generations"], f"{name}: dimensions", f"{dims}, SymPy {other['generations']}")
    tally.check(result["gauge"]["dimension"] == len(other["gauge"]), f"{name}: gauge dimension")
    answer = Answer(request, result)
    on = other["manifold"].on
    for (_, e), c in zip(answer.constraints, result["constraints"]):
        rest = sp.simplify(on(answer.graph.sympy(e, symbols)))
        tally.check(rest == 0, f"{name}: {c['expression']} vanishes on Pf", str(rest))
    for f in result["vector_field"]["free"]:
        symbols.setdefault(f, sp.Symbol(f))
    zero = {symbols[f]: 0 for f in result["vector_field"]["free"]}
    X = [on(answer.graph.sympy(answer.field[n], symbols).subs(zero)) for n in answer.names]
    gap = sp.Matrix([sp.simplify(a - b) for a, b in zip(X, other["X"])])
    if other["gauge"]:
        Z = sp.Matrix.hstack(*other["gauge"])
        ok = sp.Matrix.hstack(Z, gap).rank(simplify=True) == Z.cols
    else:
        ok = all(g == 0 for g in gap)
    tally.check(ok, f"{name}: vector field", str(list(gap)))


def one(tally, solver, case):
    """Whether SymPy could follow."""
    name, must = case["name"], case["name"] in CHOSEN
    request = {"system": case["request"]["system"], "want": ["constraints", "index", "vector_field", "gauge"]}
    result, problem = solver.solve(request)
    if problem:
        tally.check(not must, name, json.dumps(problem))
        return False
    branches = any(s.get("kind") == "branch" for s in result.get("strata", []))
    if not must and (branches or result["dimensions"]["ambient"] > LARGEST):
        return False    # which branch SymPy takes is chance
    trial = Tally("sympy")
    signal.setitimer(signal.ITIMER_VIRTUAL, 120 if must else SECONDS)
    try:
        compare(trial, name, request, result, CHOSEN.get(name, sp.cancel))
    except (Late, sympy_sga.Undecided, NotImplementedError, sp.PolynomialError):
        tally.check(not must, name, "SymPy cannot follow")
        return False
    finally:
        signal.setitimer(signal.ITIMER_VIRTUAL, 0)
    tally.passed, tally.failed = tally.passed + trial.passed, tally.failed + trial.failed
    return True


def main():
    signal.signal(signal.SIGVTALRM, late)
    tally = Tally("sympy")
    solver = Solver(build_folder())
    seen, compared = set(), 0
    for case in cases.reduced(sys.argv[2:]):
        if case["name"] in BEYOND:
            continue
        seen.add(case["name"])
        begun = time.time()
        try:
            compared += one(tally, solver, case)
        except Exception as e:
            tally.check(False, case["name"], f"{type(e).__name__}: {e}")
        if os.environ.get("SGA_TEST_VERBOSE"):
            print(f"# {case['name']}: {time.time() - begun:.2f} s", flush=True)
    print(f"{compared} compared, {len(seen) - compared} skipped")
    if not sys.argv[2:]:
        tally.check(set(CHOSEN) <= seen, "chosen cases exist", str(sorted(set(CHOSEN) - seen)))
        tally.check(compared >= COMPARED, "enough cases are compared", f"{compared}, should be {COMPARED} at least")
    return tally.end()


if __name__ == "__main__":
    sys.exit(main())
