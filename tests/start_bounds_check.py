"""Starts that are chosen, against searches of their own: start_bounds_check.py BUILD_DIR

Quadrics with bounds: the start is the nearest point within, as far as all sets of active bounds tell, each searched from many places by Newton's method
on Lagrange's conditions. Double pendulums whose velocities are met by equations at the start: the velocities that are left are the smallest ones, in any
order of equations. Equations whose slopes are 0 at the guess: the nearest root. SGA_TEST_SEED repeats a run, SGA_TEST_SCALE makes it longer."""
import itertools
import random
import sys

import numpy as np

from solver import Solver
from start_check import Quadrics
from tally import Tally, build_folder, scaled, seed

STARTS = 40


def towards(q, x, free, steps=40):
    """Newton's method of least steps onto the quadrics, by the free coordinates. Whether it came there."""
    for _ in range(steps):
        values, slopes = quadrics_at(q, x)
        d = np.linalg.lstsq(slopes[:, free], -values, rcond=None)[0]
        x[free] += d
        if np.abs(d).max() < 1e-12:
            return np.abs(quadrics_at(q, x)[0]).max() < 1e-9
    return False


def quadrics_at(q, x):
    at = list(x)
    return (np.array([q.value(s, l, at) - r for s, l, r in zip(q.S, q.l, q.r)]), np.array([q.gradient(k, at) for k in range(len(q.S))]))


def nearest(q, x, guess, free, steps=50):
    """From a point of the quadrics to a stationary one of the distance. Whether it came to one."""
    m, f = len(q.S), len(free)
    slopes = quadrics_at(q, x)[1][:, free]
    lam = np.linalg.lstsq(slopes.T, -(x - guess)[free], rcond=None)[0]
    for _ in range(steps):
        values, slopes = quadrics_at(q, x)
        slopes = slopes[:, free]
        H = np.eye(f) + sum(lam[k] * 2 * np.array(q.S[k], float)[np.ix_(free, free)] for k in range(m))
        try:
            d = np.linalg.solve(np.block([[H, slopes.T], [slopes, np.zeros((m, m))]]), -np.concatenate([(x - guess)[free] + slopes.T @ lam, values]))
        except np.linalg.LinAlgError:
            return False
        part = min(1, 1 / (np.abs(d).max() + 1e-300))
        x[free] += part * d[:f]
        lam += part * d[f:]
        if np.abs(d).max() < 1e-11:
            return np.abs(quadrics_at(q, x)[0]).max() < 1e-9
    return False


def searched(q, guess, low, high, rng):
    """The least distance of points within the bounds that are found; None: none is."""
    best = None
    for active in itertools.product(*[[0] + [-1] * bool(np.isfinite(a)) + [1] * bool(np.isfinite(b)) for a, b in zip(low, high)]):
        free = [i for i in range(q.n) if not active[i]]
        if len(free) < len(q.S):
            continue
        at = np.array([low[i] if s < 0 else high[i] if s else 0 for i, s in enumerate(active)], float)
        for k in range(STARTS):
            x = at.copy()
            for i in free:
                x[i] = guess[i] + rng.uniform(-1, 1) * (0, 1, 3, 6)[k % 4]
            if towards(q, x, free) and nearest(q, x, guess, free) and (x > low - 1e-9).all() and (x < high + 1e-9).all():
                far = np.linalg.norm(x - guess)
                best = far if best is None else min(best, far)
    return best


def within(rng, solver, number):
    """What is wrong with the start of random quadrics within random bounds; None: nothing."""
    n = rng.randint(2, 4)
    q = Quadrics(rng, n, rng.randint(1, n - 1))
    guess = np.array([rng.randint(-6, 6) / 2 for _ in range(n)])
    low, high = np.full(n, -np.inf), np.full(n, np.inf)
    for j in range(n):
        a = rng.randint(-4, 4) / 2
        low[j], high[j] = rng.choice([(-np.inf, np.inf), (a, np.inf), (-np.inf, a), (a, a + rng.randint(1, 4) / 2)])
    request = {"system": {"form": "equations", "variables": q.names, "equations": [f"{v}' = 0" for v in q.names]}, "want": ["consistent_initial"],
               "trajectory": {"initial": dict(zip(q.names, guess.tolist())), "start_equations": [f"{q.text(k)} = {r}" for k, r in enumerate(q.r)],
                              "bounds": {v: [x if np.isfinite(x) else None for x in pair] for v, *pair in zip(q.names, low.tolist(), high.tolist())}}}
    result, problem = solver.solve(request)
    least = searched(q, guess, low, high, rng)
    label = f"within {number}: {request['trajectory']}"
    if result is None:
        return least is not None and f"{label}: refused, and a point is {least} away: {problem}"
    far = np.linalg.norm(np.array([result["consistent_initial"]["projected"][v] for v in q.names]) - guess)
    return (least is None or far > least * (1 + 1e-6) + 1e-7) and f"{label}: {far} away, and a point is {least}"


def velocities(tally, rng, solver, number):
    """Two rods of length 1, in gravity of 10 and others: natural velocities are half a decade, from which roundings to powers of ten go either way."""
    gravity, length = rng.choice([(10, 1), (9.81, 1), (1, 10), (1000, 0.1), (1.6, 1.6)])
    equations = ["x'' = -p*x + q*(a - x)", f"y'' = -p*y + q*(b - y) - {gravity}", "a'' = -q*(a - x)", f"b'' = -q*(b - y) - {gravity}",
                 f"x^2 + y^2 = {length}^2", f"(a - x)^2 + (b - y)^2 = {length}^2"]
    angle, other, speed = rng.uniform(-3, 3), rng.uniform(-3, 3), rng.choice([1, -2, 3.5])
    at = dict(zip("xyab", [length * v for v in (np.sin(angle), -np.cos(angle), np.sin(angle) + np.sin(other), -np.cos(angle) - np.cos(other))]))
    rate = {"x": [1, 0, 0, 0], "a": [0, 0, 1, 0], "b": [0, 0, 0, 1]}
    moved = rng.choice(list(rate))
    rods = np.array([[at["x"], at["y"], 0, 0], [at["x"] - at["a"], at["y"] - at["b"], at["a"] - at["x"], at["b"] - at["y"]], rate[moved]])
    if np.linalg.svd(rods)[1][-1] < 0.05 * length:
        return
    least = np.linalg.lstsq(rods, np.array([0, 0, speed]), rcond=None)[0]
    label = f"velocities {number}: gravity {gravity}, length {length}, {moved}' = {speed}, {at}"
    for turn in range(4):
        system = {"form": "equations", "variables": rng.sample("xyabpq", 6), "equations": rng.sample(equations, 6)}
        scale = rng.choice([1, -3, 1e3, 1e-4])
        result, problem = solver.solve({"system": system, "want": ["consistent_initial"],
                                        "trajectory": {"initial": at, "start_equations": [f"{scale}*{moved}' = {scale}*{speed}"]}})
        if tally.check(result is not None, label, str(problem)):
            found = [result["consistent_initial"]["projected"][v + "'"] for v in "xyab"]
            off = np.abs(np.array(found) - least).max()
            tally.check(off < 1e-6 * (1 + np.abs(least).max()), label, f"order {turn}: {found}, and the least {least}")


def flat(rng, solver, number):
    """What is wrong with the start of an algebraic variable whose equation has no slope, or a small one, at the guess; None: nothing."""
    guess, state = rng.randint(-4, 4) / 2, rng.randint(-2, 2)
    powers = [rng.choice([-1, 1]) * rng.randint(1, 12) / 8, rng.choice([0, 0, 0, 1, -0.5])] + [rng.randint(-4, 4) / 2 for _ in range(rng.randint(0, 3))] + [rng.choice([1, -2])]
    polynomial = sum((c * np.poly1d([1, -guess]) ** k for k, c in enumerate(powers)), np.poly1d([0]))
    roots = [r.real for r in polynomial.roots if abs(r.imag) < 1e-9]
    text = " + ".join(f"({c!r})*z^{polynomial.order - k}" for k, c in enumerate(polynomial.coeffs.tolist()))
    scale = rng.choice([1, 2, -3, 1e3, 1e-4])
    result, problem = solver.solve({"system": {"form": "equations", "variables": rng.sample("xz", 2), "equations": ["x' = z - x", f"{scale}*({text} + x) = {scale}*({state})"]},
                                    "want": ["consistent_initial"], "trajectory": {"initial": {"x": state, "z": guess}}})
    label = f"flat {number}: {text} = 0 beside {guess}, roots {roots}"
    if result is None:
        return roots and f"{label}: {problem}"
    found = result["consistent_initial"]["projected"]
    least = min((abs(r - guess) for r in roots), default=None)
    return roots and not (abs(found["x"] - state) < 1e-9 and abs(found["z"] - guess) <= least * (1 + 1e-6) + 1e-9) and f"{label}: {found}"


def nearly_all(tally, name, wrong, count):
    """A search may miss a point: one of fifty, and each is told."""
    wrong = [w for w in wrong if w]
    tally.check(len(wrong) <= max(1, count // 50), f"{name}: {len(wrong)} of {count}", "; ".join(wrong[:3]))


def main():
    tally = Tally("starts that are chosen")
    rng = random.Random(seed(20261130))
    solver = Solver(build_folder())
    count = scaled(40)
    nearly_all(tally, "nearest within bounds", [within(rng, solver, k) for k in range(count)], count)
    for number in range(scaled(15)):
        velocities(tally, rng, solver, number)
    count = scaled(80)
    nearly_all(tally, "nearest root", [flat(rng, solver, k) for k in range(count)], count)
    return tally.end()


if __name__ == "__main__":
    sys.exit(main())
