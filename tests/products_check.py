"""Events that are products, clusters and touches along x = sin(t), v = cos(t), against the zeros of their factors: products_check.py BUILD_DIR

A factor x - c or v - c has its zeros at arcs of c, and so has any product of factors; a square is touched. Factors are drawn
near 1 and -1 too, where two zeros of one factor are close, and near each other. Each is asked by several methods and tolerances."""
import math
import random
import sys

from solver import Solver
from tally import Tally, build_folder, scaled, seed

STOP = 20
METHODS = ("auto", "dop853", "taylor", "radau", "tsit5")
TOLERANCES = (1e-8, 1e-10, 1e-12)
LEVELS = (0.999, -0.999, 0.9999, -0.9999, -0.9995, 0.3, 0.3001, 0)
APART, NEAR = 2e-5, 1e-6    # zeros that are closer are not asked for; two times are the same


def draw(rng):
    """[(name, level, power)]: no two levels of a name are as close as tolerances."""
    factors = []
    for _ in range(rng.randint(2, 5)):
        name, level = rng.choice("xv"), round(rng.choice([rng.uniform(-1, 1), rng.choice(LEVELS)]), 4)
        if abs(level) < 1 and all(f[0] != name or abs(f[1] - level) >= APART for f in factors):
            factors.append((name, level, rng.choice((1, 1, 1, 2))))
    return factors


def zeros(factors):
    """[(t, power)], ascending, between 0 and STOP."""
    found = []
    for name, level, power in factors:
        arc = math.asin(level) if name == "x" else math.acos(level)
        for other in (arc, math.pi - arc if name == "x" else -arc):
            found += [(other + 2 * math.pi * k, power) for k in range(-1, 5) if 0 < other + 2 * math.pi * k < STOP]
    return sorted(found)


def request(factors, method, tolerance):
    product = "*".join(f"({name} - ({level}))^{power}" for name, level, power in factors)
    return {"system": {"form": "equations", "variables": ["x", "v"], "equations": ["x' = v", "v' = -x"]}, "want": ["trajectory"],
            "accuracy": {"rtol": tolerance, "atol": tolerance, **({} if method == "auto" else {"method": method})},
            "trajectory": {"times": [0, STOP], "initial": {"x": 0, "v": 1}, "events": [{"name": "product", "expression": product}]}}


def sign_after(factors, t):
    """Of the product, shortly after a zero."""
    x = {"x": math.sin(t + APART / 4), "v": math.cos(t + APART / 4)}
    return math.prod((x[name] - level) ** power for name, level, power in factors) > 0


def main():
    tally, solver = Tally("products"), Solver(build_folder())
    rng = random.Random(seed(5))
    done, wanted = 0, scaled(120)
    while done < wanted:
        factors = draw(rng)
        at = zeros(factors)
        if not at or at[0][0] < APART or any(b[0] - a[0] < APART for a, b in zip(at, at[1:])):
            continue
        done += 1
        method, tolerance = rng.choice(METHODS), rng.choice(TOLERANCES)
        if method == "tsit5":
            tolerance = max(tolerance, 1e-9)
        asked = request(factors, method, tolerance)
        name = f"{asked['trajectory']['events'][0]['expression']}, {method} at {tolerance:g}"
        result, problem = solver.solve(asked)
        if not tally.check(result and not result["trajectory"]["ended"], name, str(problem or result["trajectory"]["ended"])):
            continue
        should = [(t, "touch" if power == 2 else "up" if sign_after(factors, t) else "down") for t, power in at]
        is_ = [(e["t"], e["direction"]) for e in result["trajectory"]["events"]]
        tally.check(len(is_) == len(should) and all(abs(a[0] - b[0]) < NEAR and a[1] == b[1] for a, b in zip(is_, should)), f"{name}: events",
                    f"only here {[e for e in is_ if all(abs(e[0] - s[0]) >= NEAR for s in should)]}, "
                    f"missing {[s for s in should if all(abs(e[0] - s[0]) >= NEAR for e in is_)]}, {len(is_)} of {len(should)}")
    return tally.end()


if __name__ == "__main__":
    sys.exit(main())
