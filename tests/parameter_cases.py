"""Cases of symbolic parameters against values that are given: parameter_cases.py BUILD_DIR

Random systems, linear and polynomial, with 1 to 3 symbolic parameters are answered once with their strata solved. Then the
parameters get values: general ones, ones on each condition that is listed, and small whole numbers, which often fulfil conditions
that a list may have forgotten. What the service says of the system with these values must be what the list says in every case
that the values belong to.
"""
import itertools
import random
import re
import sys
from fractions import Fraction

import sympy

from solver import Crash, Solver
from tally import Tally, build_folder, scaled, seed

SMALL = [Fraction(v) for v in (0, 1, -1, 2, -2, 3)]
WANT = ["constraints", "index", "gauge"]
SPARSE = ["0", "0", "0", "1", "1", "-1", "2"]
WITH = ["k", "m", "p", "k-1", "m+2", "k+m", "k*m", "k-m", "p-k", "k^2-1", "p^2-2", "k*m-p", "2*k", "k^2+m^2"]


def names_of(text):
    return set(re.findall(r"[A-Za-z_]\w*", text))


def evaluated(text, values):
    """The exact value of a text where it is rational, otherwise to 40 digits; None where it has none."""
    v = sympy.sympify(text.replace("^", "**").replace("cbrt(", "cbrt("), locals={k: sympy.Rational(v.numerator, v.denominator) for k, v in values.items()},
                      rational=True)
    if v.has(sympy.zoo, sympy.nan, sympy.oo):
        return None
    return v if v.is_Rational else v.evalf(40)


def vanishes(text, values):
    v = evaluated(text, values)
    return v is not None and bool(abs(v) < sympy.Rational(1, 10 ** 25))


def belongs(case, values):
    """Whether the values of the parameters fulfil the conditions of a case, and are the ones put in there."""
    if not all(vanishes(w, values) for w in case["where"]):
        return False
    return all(vanishes(f"{n}-({v})", values) for n, v in case.get("substituted", {}).items())


class Said(Exception):
    """The list says that it does not cover these values."""


def answers(result, values):
    """What the list says of these values: one answer for each most special case that holds them."""
    cases = [s for s in result["strata"] if s["kind"] == "parameter" and belongs(s, values)]
    for s in cases:
        if "problem" in s:
            raise Said(s["problem"]["code"])
        if "same_as" in s:
            raise Said("same_as")
    inner = [a for s in cases if "result" in s for a in answers(s["result"], {k: v for k, v in values.items() if k not in s["substituted"]})]
    if cases:
        return inner
    for a in result.get("assumptions", []):
        if a["kind"] == "not_zero":
            if names_of(a["expression"]) <= set(values) and vanishes(a["expression"], values):
                raise KeyError(f"{a['expression']} is assumed not to vanish, and no case has it")
        else:
            raise Said(a["kind"])
    return [result]


def shape(r):
    if r["verdict"] == "inconsistent":      # which contradiction is met first is a matter of the branch that is tried first
        return ("inconsistent",)
    return (r["verdict"], tuple(r["dimensions"]["generations"]), r["dimensions"]["final"], r["index"]["generations"],
            r.get("gauge", {}).get("dimension"))


def entry(rng, parameters, share):
    if rng.random() < share:
        usable = [w for w in WITH if names_of(w) <= set(parameters)]
        return rng.choice(usable)
    return rng.choice(SPARSE)


def linear_system(rng, parameters):
    n, rows = rng.randint(1, 4), 0
    rows = n + rng.choice([0, 0, 0, 1, 1, -1 if n > 1 else 0])
    rank = rng.randint(0, min(n, rows))
    names = ["x", "y", "z", "w"][:n]
    A = [[entry(rng, parameters, 0.25) if i < rank else "0" for _ in names] for i in range(rows)]
    alpha = []
    for _ in range(rows):
        terms = [f"({entry(rng, parameters, 0.35)})*{v}" for v in names]
        if rng.random() < 0.3:
            terms.append(f"({entry(rng, parameters, 0.5)})")
        alpha.append("+".join(terms))
    return {"form": "quasilinear", "variables": names, "A": A, "alpha": alpha}


def polynomial_system(rng, parameters):
    n = rng.randint(2, 3)
    names = ["x", "y", "z"][:n]

    def p(q=None):
        return entry(rng, parameters, 0.6 if q is None else q)

    def v():
        return rng.choice(names)
    shapes = [
        lambda: f"({p()})*{v()}*{v()}-({p()})", lambda: f"{v()}^2+({p()})*{v()}", lambda: f"{v()}-({p()})*{v()}^2",
        lambda: f"({p()})*{v()}+({p()})*{v()}-({p()})*{v()}^2", lambda: f"({v()}-({p()}))*({v()}+({p()})*{v()})",
        lambda: f"({p()})*({v()}+{v()}*{v()})", lambda: f"{v()}+({p()})*{v()}", lambda: f"({p()})*{v()}-({p()})",
        lambda: f"{v()}^2+{v()}^2-({p()})", lambda: f"{v()}*{v()}+({p()})*{v()}+({p()})",
    ]
    equations = [f"{x}' = {rng.choice(shapes)() if rng.random() < 0.4 else f'({p(0.3)})*{v()}+({p(0.3)})'}" for x in names[:rng.randint(1, n)]]
    equations += [f"{rng.choice(shapes)()} = 0" for _ in range(rng.randint(1, 2))]
    return {"form": "equations", "variables": names, "equations": equations}


def used(system, parameters):
    text = " ".join(str(system[k]) for k in ("A", "alpha", "equations") if k in system)
    return [p for p in parameters if p in names_of(text)]


def conditions(result):
    for s in result["strata"]:
        if s["kind"] == "parameter":
            yield s
            if "result" in s:
                yield from ({**c, "under": s} for c in conditions(s["result"]))


def on_case(rng, case, parameters):
    """Values on a case, where they can be rational: free ones at random."""
    values = {p: Fraction(rng.randint(-9, 9), rng.randint(1, 4)) for p in parameters}
    chain, at = [], case
    while at:
        chain.append(at)
        at = at.get("under")
    for s in chain:         # the innermost first: outer values may need it
        for name, text in s.get("substituted", {}).items():
            v = evaluated(text, {k: w for k, w in values.items() if k != name})
            if v is None or not v.is_Rational:
                return None
            values[name] = Fraction(int(v.p), int(v.q))
    return values


def draws(rng, result, parameters, most):
    wide = [{p: Fraction(rng.randint(-60, 60), rng.randint(7, 11)) for p in parameters} for _ in range(2)]
    small = [dict(zip(parameters, c)) for c in itertools.product(SMALL, repeat=len(parameters))]
    rng.shuffle(small)
    listed = [on_case(rng, c, parameters) for c in conditions(result)]
    rng.shuffle(listed)
    all_of = wide + [v for v in listed if v][:most] + small[:most]
    return [dict(t) for t in {tuple(sorted(v.items())) for v in all_of}]


def given(solver, system, values):
    return solver.solve({"system": {**system, "parameters": {k: str(v) for k, v in values.items()}}, "want": WANT})


def compare(tally, count, solver, system, result, values):
    label = f"{system} at { {k: str(v) for k, v in values.items()} }"
    there, problem = given(solver, system, values)
    if problem:
        count["refused"] += 1
        return
    try:
        cases = answers(result, values)
    except Said as e:
        count[f"said {e}"] = count.get(f"said {e}", 0) + 1
        return
    except KeyError as e:
        tally.check(False, label, str(e))
        return
    got = {shape(a) for a in cases}
    tally.check(got == {shape(there)}, label, f"listed {got}, given {shape(there)}")


def main():
    rng = random.Random(seed(13))
    tally, solver = Tally("parameters"), Solver(build_folder())
    count = {"systems": 0, "undecided": 0, "refused": 0}
    for i in range(scaled(24)):
        parameters = ["k", "m", "p"][:rng.choice([1, 1, 2, 2, 3])]
        system = (linear_system if rng.random() < 0.6 else polynomial_system)(rng, parameters)
        parameters = used(system, parameters)
        if not parameters:
            continue
        try:
            result, problem = solver.solve({"system": {**system, "parameters": dict.fromkeys(parameters)}, "want": WANT, "strata": "solve"})
        except Crash as e:
            tally.check(False, f"{system}", str(e))
            continue
        count["systems"] += 1
        if problem:
            count["undecided"] += 1
            continue
        for values in draws(rng, result, parameters, 8):
            compare(tally, count, solver, system, result, values)
    print(", ".join(f"{v} {k}" for k, v in count.items()))
    return tally.end()


if __name__ == "__main__":
    sys.exit(main())
