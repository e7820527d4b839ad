"""Systems whose answer must not change when they are said in other words: invariance.py BUILD_DIR [NAME...]

Random ones first: linear ones with constant coefficients against exact elimination, polynomial
ones built with a known answer, each also in disguise, with the identities checked on every
answer. Then every case of the corpus (invariant_corpus.py). SGA_TEST_SEED repeats a run,
SGA_TEST_SCALE makes it longer; names choose cases of the corpus.
"""
import json
import random
import sys
from fractions import Fraction

import disguise
import linear_oracle
from disguise import System
from identities import Answer, Broken
from invariant_corpus import Corpus
from solver import Solver
from tally import Tally, build_folder, scaled, seed


REFUSED = []    # labels of what was refused
DISGUISES = [disguise.mix_rows, disguise.repeat_row, disguise.change_linear, disguise.reorder]


def names_for(rng, n):
    pool = ["x", "y", "z", "a1", "b_2", "Omega", "lambda", "_u", "w9", "e", "i", "D"]
    return rng.sample(pool + [f"q{k}" for k in range(max(0, n - 8))], n)


def random_linear(rng):
    n, m = rng.randint(2, 5), rng.randint(1, 5)
    rank = rng.randint(0, min(n, m))
    left = [[rng.randint(-2, 2) for _ in range(rank)] for _ in range(m)]
    right = [[rng.randint(-2, 2) for _ in range(n)] for _ in range(rank)]
    A = [[sum(left[i][k] * right[k][j] for k in range(rank)) for j in range(n)] for i in range(m)]
    B = [[rng.choice([0, 0, 1, -1, 2]) for _ in range(n)] for _ in range(m)]
    if rng.random() < 0.5:
        c = [0] * m    # through the origin, so that it is consistent
    else:
        c = [rng.randint(-2, 2) for _ in range(m)]
    scale = [Fraction(1, rng.choice([1, 1, 2, 3, 10])) for _ in range(m)]
    A = [[s * a for a in r] for s, r in zip(scale, A)]
    alpha = [" + ".join(f"{b}*{{{j}}}" for j, b in enumerate(r) if b) + (f" + {k}" if k else "") for r, k in zip(B, c)]
    alpha = [a.strip(" +") or "0" for a in alpha]
    return System([[str(a) for a in r] for r in A], alpha, n), linear_oracle.reduce(A, B, c)


def polynomial(rng, over):
    """A small polynomial in the variables of these indices."""
    terms = [str(rng.choice([-1, 0, 1, 2]))]
    for _ in range(rng.randint(1, 2)):
        if over:
            i, j = rng.choice(over), rng.choice(over)
            terms.append(f"{rng.choice([-1, 1, 2])}*{{{i}}}" + rng.choice(["", f"*{{{j}}}", "^2"]))
    return " + ".join(terms)


def random_polynomial(rng):
    """c_i' = c_(i+1) + q_i(c_1..c_i, y), 0 = c_1 - h(y), y' = f(y): index = length of the chain;
    variables w without equations are gauge freedom."""
    k = rng.randint(0, 3)
    d = rng.randint(0 if k else 1, min(3, 5 - k))
    g = rng.randint(0, min(1, 5 - k - d))
    n = k + d + g
    ys = list(range(k, k + d))
    A, alpha = [], []

    def unit(j):
        return ["1" if i == j else "0" for i in range(n)]
    for i in range(k - 1):
        A.append(unit(i))
        alpha.append(f"{{{i + 1}}} + {polynomial(rng, list(range(i + 1)) + ys)}")
    if k:
        A.append(["0"] * n)
        alpha.append(f"{{0}} - ({polynomial(rng, ys)})")
    for j in ys:
        A.append(unit(j))
        alpha.append(polynomial(rng, ys))
    if k and d and g:    # w may drive a y that the chain does not see
        free = [a for a in ys if not any(f"{{{a}}}" in t for t in alpha)]
        if free:
            alpha[A.index(unit(free[0]))] += f" + {{{n - 1}}}"
    dims = [n - i for i in range(1, k + 1)]
    final = n - k
    verdict = "underdetermined" if g else "unique" if final else "isolated"
    return System(A, alpha, n), {"verdict": verdict, "generations": dims, "final": final, "gauge": g}


def same(tally, label, request, result, expect):
    dims = result["dimensions"]
    tally.check(result["verdict"] == expect["verdict"], f"{label}: verdict",
                f"{result['verdict']}, should be {expect['verdict']}: {json.dumps(request)}")
    if expect["verdict"] == "inconsistent" or result["verdict"] != expect["verdict"]:
        return
    got = {"generations": dims["generations"], "final": dims["final"], "gauge": result["gauge"]["dimension"]}
    should = {k: expect[k] for k in got}
    tally.check(got == should, f"{label}: dimensions", f"{got}, should be {should}: {json.dumps(request)}")
    tally.check(result["index"]["generations"] == len(should["generations"]), f"{label}: index", json.dumps(request))


def examine(tally, solver, label, request, expect, number):
    try:
        result, problem = solver.solve(request)
        if problem and problem["code"] == "no_real_point":    # a search that gave up is said, and counted
            REFUSED.append(label)
            return
        if problem:
            tally.check(False, label, f"{problem['code']}: {problem['detail']}: {json.dumps(request)}")
            return
        same(tally, label, request, result, expect)
        Answer(request, result, seed=number, digits=40, points=1).check()
        tally.check(True, label)
    except Broken as e:
        tally.check(False, f"{label}: identities", f"{e}: {json.dumps(request)}")
    except Exception as e:
        tally.check(False, label, f"{type(e).__name__}: {e}: {json.dumps(request)}")


def generated(tally, solver, first):
    for kind, make, count in (("linear", random_linear, 40), ("polynomial", random_polynomial, 20)):
        for number in range(scaled(count)):
            rng = random.Random(f"{first} {kind} {number}")
            system, expect = make(rng)
            examine(tally, solver, f"{kind} {number}", system.request(names_for(rng, system.n)), expect, number)
            for change in DISGUISES if kind == "polynomial" else [rng.choice(DISGUISES)]:
                other = change(rng, system)[0]
                examine(tally, solver, f"{kind} {number} {change.__name__}", other.request(names_for(rng, system.n)), expect, number)
            whole = system
            for change in DISGUISES:
                whole = change(rng, whole)[0]
            examine(tally, solver, f"{kind} {number} all", whole.request(names_for(rng, system.n)), expect, number)


def main():
    tally = Tally("invariance")
    solver = Solver(build_folder())
    first = seed(20260101)
    generated(tally, solver, first)
    for label in REFUSED:
        print(f"refused: {label}: no_real_point")
    tally.check(len(REFUSED) <= 1 + tally.passed // 200, "few generated systems are refused", str(len(REFUSED)))
    Corpus(tally, solver, first).run(sys.argv[2:])
    return tally.end()


if __name__ == "__main__":
    sys.exit(main())
