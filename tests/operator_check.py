"""The form `operator`, multiplied out by a second implementation: operator_check.py BUILD_DIR

U P V = diag with both inverses; the state form by substitution; P times the Laurent series;
both indices; the reduction's differentiation index of the same system with polynomial
sources; invariance under changes of unknowns and of equations; closed forms; trajectories against the
printed state form, integrated by mpmath, and their ends against the singular times; the nilpotency of planted
Weierstrass forms. Seeded.
"""
import json
import random
import sys

import operator_motion
import ore
from ore import K
from solver import Solver
from tally import Tally, build_folder, scaled, seed

MULTIPLIED_BYTES = 5000   # SymPy needs minutes for more; the daemon itself multiplies out all of them

CLOSED = [   # name, coefficients, order of the last invariant factor, index, nu0, real singular times
    ("example 3.2 of the source", [[["1", "-t"], ["0", "0"]], [["0", "0"], ["1", "-t"]]], 0, 2, -1, []),
    ("explicit of order 2", [[["t"]], [["0"]], [["1"]]], 2, 0, 2, []),
    ("algebraic", [[["1", "t"], ["0", "1"]]], 0, 1, 0, []),
    ("Euler", [[["-1"]], [["t"]]], 1, 0, 1, [0.0]),
    ("quadratic pole", [[["1"]], [["t^2 - 2"]]], 1, 0, 1, [-(2 ** 0.5), 2 ** 0.5]),
    ("two oscillators", [[["1", "0"], ["0", "1"]], [["0", "0"], ["0", "0"]], [["1", "0"], ["0", "1"]]], 4, 0, 2, []),
    ("nilpotent of order 3", [[["1", "0", "0"], ["0", "1", "0"], ["0", "0", "1"]],
                              [["0", "1", "0"], ["0", "0", "1"], ["0", "0", "0"]]], 0, 3, -2, []),
    ("two decoupled D", [[["0", "0"], ["0", "0"]], [["1", "0"], ["0", "1"]]], 2, 0, 1, []),
    ("algebraic pole", [[["t - 3"]]], 0, 1, 0, [3.0]),
]


def shape(x, rows, cols):
    """A matrix over Q(t) whose empty sizes JSON cannot tell."""
    return ore.plain(x) if rows and cols else ore.zeros(rows, cols)


def check_jacobson(tally, name, P, result, rank):
    n = len(P)
    if result["invariant_factors"] is None:
        tally.check(result["jacobson"].get("code"), f"{name}: says why there is no Jacobson form")
        return False
    factors = [ore.trim([ore.number(c) for c in f]) for f in result["invariant_factors"]]
    tally.check(len(factors) == rank and all(f == [K.one] for f in factors[:-1]), f"{name}: all factors but the last are 1")
    if "U" not in result["jacobson"] or len(json.dumps(result["jacobson"])) > MULTIPLIED_BYTES:
        return False
    U, V, Ui, Vi = (ore.read(result["jacobson"][k]) for k in ("U", "V", "U_inverse", "V_inverse"))
    diagonal = [[factors[i] if i == j and i < rank else [] for j in range(n)] for i in range(n)]
    tally.check(ore.product(ore.product(U, P), V) == diagonal, f"{name}: U P V is the diagonal")
    for a, b in ((U, Ui), (Ui, U), (V, Vi), (Vi, V)):
        tally.check(ore.product(a, b) == ore.identity(n), f"{name}: unimodular")
    return True


def check_state(tally, name, A, B, state):
    """sum A_i y^(i) = B e with y = H x + sum J_v e^(v), x' = F x + G e."""
    p, q, n = len(B), len(B[0]) if B else 0, state["dimension"]
    F, G, H = shape(state["F"], n, n), shape(state["G"], n, q), shape(state["H"], p, n)
    J = [ore.plain(m) for m in state["J"]]
    total, sums = ore.zeros(p, n), {}
    for i, Ai in enumerate(A):
        total = ore.plus(total, ore.times(Ai, H) if n else ore.zeros(p, 0))
        for v, m in enumerate(J):
            sums[v] = ore.plus(sums.get(v, ore.zeros(p, q)), ore.times(Ai, m))
        nextJ = [ore.derived(m) for m in J] + [ore.zeros(p, q)]
        for v, m in enumerate(J):
            nextJ[v + 1] = ore.plus(nextJ[v + 1], m)
        if n:
            nextJ[0] = ore.plus(nextJ[0], ore.times(H, G))
            H = ore.plus(ore.derived(H), ore.times(H, F))
        J = nextJ
    tally.check(all(not x for r in total for x in r), f"{name}: the state form solves the homogeneous system")
    want = {v: B if v == 0 else ore.zeros(p, q) for v in set(sums) | {0}}
    tally.check(all(sums.get(v, ore.zeros(p, q)) == m for v, m in want.items()), f"{name}: the state form solves the system")


def binomial(m, k):
    out = 1
    for i in range(k):
        out = out * (m - i) // (i + 1)
    return out


def check_transfer(tally, name, A, B, transfer):
    """P times sum c_k s^{-first-k}, as far as the terms go."""
    first, c = transfer["first"], [ore.plain(m) for m in transfer["coefficients"]]
    order, p, q = len(A) - 1, len(B), len(B[0])
    tally.check(any(x for r in c[0] for x in r), f"{name}: the leading coefficient is not 0")
    for place in range(len(c)):
        total = ore.zeros(p, q)
        for i, Ai in enumerate(A):
            for j, m in enumerate(c):
                k = place - (order - i) - j
                for _ in range(max(k, 0)):
                    m = ore.derived(m)
                if k >= 0:
                    f = K(binomial(i, k))
                    total = ore.plus(total, [[f * x for x in r] for r in ore.times(Ai, m)])
        want = B if order - first == place else ore.zeros(p, q)
        tally.check(total == want, f"{name}: P times the series at place {place}")


def sources(rng, count):
    return [" + ".join(f"{rng.randint(1, 9)}*t^{k}" for k in range(9)) for _ in range(count)]


def companion(coefficients):
    """y' = v, A2 v' + A1 v + A0 y = e."""
    p = len(coefficients[0])
    one = [["1" if i == j else "0" for j in range(p)] for i in range(p)]
    minus = [["-1" if i == j else "0" for j in range(p)] for i in range(p)]
    none = [["0"] * p for _ in range(p)]
    A0, A1, A2 = coefficients
    lower = [none[i] + minus[i] for i in range(p)] + [A0[i] + A1[i] for i in range(p)]
    upper = [one[i] + none[i] for i in range(p)] + [none[i] + A2[i] for i in range(p)]
    return [lower, upper]


def check_reduction(tally, solver, name, system, index, rng):
    """Of order 1, with B the identity: the index is the reduction's differentiation index. (A system of
    higher order has a derivative of y as a variable of its own, which may need more.)"""
    given = dict(system, sources=sources(rng, len(system["unknowns"])))
    other, problem = solver.solve({"system": given, "want": ["index"]})
    tally.check(other and other["index"]["differentiation"] == index, f"{name}: differentiation index of the reduction",
                f"{other and other.get('index') or problem} against {index}: {system}")


def check_one(tally, solver, name, coefficients, rng, B=None):
    p = len(coefficients[0])
    system = {"form": "operator", "unknowns": [f"y{i + 1}" for i in range(p)], "coefficients": coefficients}
    if B:
        system["B"] = B
    result, problem = solver.solve({"system": system})
    if not tally.check(result, f"{name}: answered", str(problem)):
        return None
    A = [ore.plain(m) for m in coefficients]
    rhs = ore.plain(B) if B else [[K.one if i == j else K.zero for j in range(p)] for i in range(p)]
    P = ore.of_system(coefficients)
    rank = result["rank"]
    tally.check(result["solvable"] == (rank == p), f"{name}: solvable is full rank")
    result["multiplied"] = check_jacobson(tally, name, P, result, rank)
    index = result["index"]["operator"]
    if not result["solvable"]:
        tally.check(index is None, f"{name}: no index without full rank")
        return result
    check_state(tally, name, A, rhs, result["state"])
    nu0, J = result["transfer_leading_order"], result["state"]["J"]
    if nu0 is not None:
        check_transfer(tally, name, A, rhs, result["transfer"])
        tally.check(index == max(0, 1 - nu0), f"{name}: index by the transfer matrix")
    tally.check(index == len(J), f"{name}: index by the state form")
    if B is None and len(coefficients) == 2:
        check_reduction(tally, solver, name, system, index, rng)
    if B is None and len(coefficients) == 3 and p <= 2:
        first = dict(system, unknowns=system["unknowns"] + [f"v{i + 1}" for i in range(p)], coefficients=companion(coefficients))
        answer, problem = solver.solve({"system": first})
        if tally.check(answer, f"{name}: answered as a first-order system", str(problem)):
            check_reduction(tally, solver, f"{name}, first order", first, answer["index"]["operator"], rng)
    tally.check(result["dimensions"]["final"] == result["state"]["dimension"], f"{name}: dim Pf is the dimension of the state")
    return result


def polynomial(rng, degree):
    return " + ".join(f"({rng.randint(-3, 3)})*t^{k}" for k in range(degree + 1))


def random_system(rng, p, order):
    density = rng.choice([0.3, 0.5, 0.8])
    return [[[polynomial(rng, rng.randint(0, 1)) if rng.random() < density / (2 * k + 1) else "0" for _ in range(p)]
             for _ in range(p)] for k in range(order + 1)]


def planted(rng):
    """A chain of equations y_i + y_i+1' = e_i, last y_n = e_n, in other unknowns and equations: index n."""
    p = rng.randint(2, 3)
    one = [["1" if i == j else "0" for j in range(p)] for i in range(p)]
    chain = [["1" if j == i + 1 else "0" for j in range(p)] for i in range(p)]
    return moved(rng, [one, chain])


def moved(rng, coefficients):
    """The same system in other unknowns y = T z, other equations S P T, S and T triangular with ones."""
    p = len(coefficients[0])
    T = [[[K.one] if i == j else ore.trim([ore.number(polynomial(rng, 1))]) if j < i else [] for j in range(p)] for i in range(p)]
    S = [[[K.one] if i == j else ore.trim([ore.number(polynomial(rng, 1))]) if j > i else [] for j in range(p)] for i in range(p)]
    P = ore.product(ore.product(S, ore.of_system(coefficients)), T)
    top = max((len(x) for r in P for x in r), default=1) or 1
    return [[[str((x[k] if k < len(x) else K.zero).as_expr()).replace("**", "^") for x in r] for r in P] for k in range(top)]


def main():
    tally = Tally("operator")
    solver = Solver(build_folder())
    rng = random.Random(seed(2026))
    for name, coefficients, order, index, nu0, times in CLOSED:
        r = check_one(tally, solver, name, coefficients, rng)
        if not r:
            continue
        tally.check(len(r["invariant_factors"][-1]) == order + 1, f"{name}: order of the last invariant factor")
        tally.check(r["index"]["operator"] == index and r["transfer_leading_order"] == nu0, f"{name}: index and leading order")
        tally.check([s["t"] for s in r["singular_times"]] == times, f"{name}: singular times", str(r["singular_times"]))
    operator_motion.run(tally, solver, rng)
    full = high = lower = multiplied = 0
    for k in range(scaled(60)):
        p, order = rng.randint(1, 4), rng.randint(1, 2)
        system = random_system(rng, p, order) if k % 6 else planted(rng)
        p = len(system[0])
        B = [[polynomial(rng, 1) for _ in range(2)] for _ in range(p)] if k % 3 == 0 else None
        r = check_one(tally, solver, f"random {k}", system, rng, B)
        if not r:
            continue
        full += r["solvable"]
        multiplied += bool(r["multiplied"])
        high += (r["index"]["operator"] or 0) >= 2
        lower += not r["solvable"]
        if B is None and p <= 3:
            other, problem = solver.solve({"system": {"form": "operator", "unknowns": [f"z{i}" for i in range(p)],
                                                      "coefficients": moved(rng, system)}})
            if not tally.check(other, f"random {k}: moved and answered", str(problem)):
                continue
            for key in ("solvable", "rank"):
                tally.check(other.get(key) == r[key], f"random {k}: {key} is invariant")
            tally.check(other.get("index", {}).get("operator") == r["index"]["operator"], f"random {k}: the index is invariant")
            tally.check(other["dimensions"]["final"] == r["dimensions"]["final"] or not r["solvable"], f"random {k}: the state's dimension is invariant")
    tally.check(scaled(60) < 60 or (full > 20 and high > 5 and lower > 5 and multiplied > 30), "the random systems are of many kinds", f"{full} {high} {lower} {multiplied}")
    return tally.end()


if __name__ == "__main__":
    sys.exit(main())
