"""SymPy's own reduction as a second opinion: sympy_check.py BUILD_DIR

Verdict, dimensions and gauge dimension must agree; the printed constraints must vanish
identically on SymPy's Pf; the printed field must differ from SymPy's by gauge fields only.
"""
import json
import sys

import sympy as sp

import cases
import sympy_sga
from identities import Answer
from problem import Problem
from solver import Solver
from tally import Tally, build_folder

# name of a case, and how SymPy simplifies there
CHOSEN = [("arm numeric", sp.cancel), ("arm symbolic", sp.cancel), ("pendulum first order", sp.simplify),
          ("pendulum symbolic", sp.simplify), ("2x2 option 1 symbolic", sp.cancel), ("Gear Petzold symbolic", sp.cancel),
          ("index 1 circuit symbolic", sp.cancel), ("integrator chain 5", sp.cancel), ("singular everywhere", sp.cancel),
          ("Dirac multiplier", sp.cancel), ("restrict circle", sp.simplify), ("diode circuit", sp.simplify),
          ("sliding not transversal", sp.simplify), ("squared velocity", sp.simplify), ("late contradiction", sp.cancel),
          ("control, relative degree 3", sp.cancel), ("control, vector relative degree (1, 3)", sp.cancel),
          ("linear general, situation 3b with a new constraint", sp.cancel), ("linear general, situation 2c(ii) then 2a", sp.cancel),
          ("Christ-Lee with second order", sp.cancel), ("Christ-Lee without second order", sp.cancel),
          ("three second class generations", sp.simplify), ("first and second class mixed, H continued otherwise", sp.cancel),
          ("presymplectic, two generations", sp.cancel), ("bead on the meeting of two surfaces", sp.cancel),
          ("highest derivatives in one combination", sp.cancel)]


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


def main():
    tally = Tally("sympy")
    solver = Solver(build_folder())
    wanted = dict(CHOSEN)
    for case in cases.load([]):
        if case["name"] not in wanted:
            continue
        simplify = wanted.pop(case["name"])
        try:
            result, problem = solver.solve(case["request"])
            if problem:
                tally.check(False, case["name"], json.dumps(problem))
            else:
                compare(tally, case["name"], case["request"], result, simplify)
        except Exception as e:
            tally.check(False, case["name"], f"{type(e).__name__}: {e}")
    tally.check(not wanted, "chosen cases exist", str(sorted(wanted)))
    return tally.end()


if __name__ == "__main__":
    sys.exit(main())
