"""Relays with hysteresis: relay_check.py BUILD_DIR

s = sign(x + h s) has both values where |x| < h: the one that it has stays until x comes to h on the other side, and jumps there. Between jumps the motions have closed
forms. By every method and arithmetic, as Filippov systems (which do not slide there) and without; with the threshold named or put in, as a sign or as a condition;
in any order and unit. SGA_TEST_SEED, SGA_TEST_SCALE as everywhere."""
import math
import random
import sys

from solver import Solver
from tally import Tally, build_folder, scaled, seed

RUNS = 60
STOP, ROWS = 6, 13
STEP = 1e-6                      # of h, for derivatives of closed forms
WAYS = [{"method": m} for m in ("auto", "dop853", "tsit5", "radau", "taylor")] + [{"arithmetic": "double-double"}, {"arithmetic": "double-double", "method": "radau"}]


def decay(a, b, h, x, s):
    """x' = -a x - b s: the value after a time, and the time of the next jump."""
    level = -b * s / a if a else None

    def at(t):
        return level + (x - level) * math.exp(-a * t) if a else x - b * s * t
    if not a:
        return at, (x * s + h) / b
    return at, math.log((level - x) / (level + s * h)) / a if abs(level) > h else math.inf


def arc(b, h, x, v, s):
    """x'' = -b s."""
    def at(t):
        return x + v * t - b * s * t * t / 2, v - b * s * t
    p, q = s * v, s * x + h          # until s x + h is 0: q + p t - b t^2/2
    return at, (p + math.sqrt(p * p + 2 * b * q)) / b


def closed(first, again, x, s, times):
    """Rows (x, ..., s) at these times, and how far each is from a jump."""
    at, until = first(x, s)
    since, rows = 0, []
    for t in times:
        while t > since + until:
            x = at(until)
            since, s = since + until, -s
            at, until = again(x, s)
        rows.append((at(t - since), s, min(abs(t - since - until), t - since if since else math.inf)))
    return rows


def relay(rng):
    """Equations of s = sign(x + k s), and its names that are not x or s."""
    form = rng.choice(["sign", "named", "if", "level"])
    w = "x + k*s"
    if form == "sign":
        return [], [f"s = sign({w})"]
    if form == "named":
        return ["w"], [f"w = {w}", "s = sign(w)"]
    if form == "if":
        return [], [f"s = if({w} > 0, 1, -1)"]
    return ["l", "q"], ["l = -k*s", "q = if(x > l, 1, 0)", "s = 2*q - 1"]


def case(rng):
    """Names, equations, the parameter k, initial values, the unit of x, and rows: time, values, their derivatives by k, and how far the next jump is."""
    h, b, u = rng.choice([0.25, 0.5, 1]), rng.choice([0.5, 1, 2]), rng.choice([1, 1, 1e-6, 1e4])
    s, x = rng.choice([-1, 1]), rng.choice([0.03, 0.31, 0.93, 1.47])
    names, equations = relay(rng)
    times = [STOP * k / (ROWS - 1) for k in range(ROWS)]
    names += ["x", "s"]
    initial = {"x": s * x * u, "s": s}
    if rng.random() < 0.6:
        a = rng.choice([0, 0.5, 1])
        equations.append(f"x' = -{a}*x - {b * u!r}*s")

        def rows(h):
            return [{"x": r, "s": k, "far": far} for r, k, far in closed(*[lambda x, s: decay(a, b, h, x, s)] * 2, s * x, s, times)]
    else:
        names.append("v")
        equations += ["x' = v", f"v' = -{b * u!r}*s"]
        initial["v"] = 0

        def rows(h):
            return [{"x": r[0], "v": r[1], "s": k, "far": far} for r, k, far in closed(*[lambda x, s: arc(b, h, *x, s)] * 2, (s * x, 0), s, times)]
    rng.shuffle(names)
    rng.shuffle(equations)
    found = []
    for time, now, less, more in zip(times, rows(h), rows(h - STEP), rows(h + STEP)):
        units = {n: 1 if n == "s" else u for n in now if n != "far"}
        slope = {n: units[n] * (more[n] - less[n]) / (2 * STEP * u) for n in units}
        found.append((time, {n: units[n] * now[n] for n in units}, slope, min(r["far"] for r in (now, less, more))))
    return names, equations, h * u, initial, u, found


def one(solver, tally, run, rng):
    names, equations, k, initial, u, rows = case(rng)
    tolerance = rng.choice([1e-5, 1e-7, 1e-9])
    request = {"system": {"form": "equations", "variables": names, "equations": equations, "parameters": {"k": k}},
               "trajectory": {"stop": STOP, "samples": ROWS, "initial": initial},
               "accuracy": {"rtol": tolerance, "atol": tolerance * u, **rng.choice(WAYS)}}
    if rng.random() < 0.3:
        request["trajectory"]["sliding"] = True
        request["accuracy"] = rng.choice([request["accuracy"], {"rtol": 1e-9, "atol": 1e-9 * u, "arithmetic": "ball"}])
    elif rng.random() < 0.4:
        request["trajectory"]["sensitivities"] = {"parameters": ["k"]}
    label = f"relay {run} {equations} {names} {k} {initial} {request['accuracy']} {request['trajectory'].get('sliding')}"
    result, problem = solver.solve(request)
    t = result and result["trajectory"]
    if not tally.check(t and not t["ended"] and len(t["rows"]) == ROWS, f"{label}: all rows", str(problem or t["ended"])):
        return
    for row, error, (time, values, _, far) in zip(t["rows"], t["errors"], rows):
        got = dict(zip(t["columns"], row))
        if request["accuracy"].get("arithmetic") == "ball" and None in row:      # what is not proved
            continue
        if far < 1e-3 or not tally.check(all(got[k] is not None for k in values), f"{label}: values at {time}", str(row)) or error is None:
            continue
        off = max(abs(got[k] - v) for k, v in values.items())
        tally.check(off <= 3 * error + 1e-12 * (u + 1), f"{label}: at {time}", f"off by {off:.3g}, told {error:.3g}")
    slopes = t.get("sensitivities")
    if not slopes or not tally.check(not slopes["ended"], f"{label}: derivatives", str(slopes and slopes["ended"])):
        return
    for row, (time, _, slope, far) in zip(slopes["rows"], rows):
        got = dict(zip(slopes["columns"], row))
        off = max(abs(got[f"d({n})/d(k)"] - v) / (1 + abs(v)) for n, v in slope.items())
        tally.check(far < 1e-3 or off <= 1e-4, f"{label}: derivatives at {time}", f"off by {off:.3g}: {got} {slope}")


def main():
    tally = Tally("relays")
    first = seed(20261130)
    solver = Solver(build_folder())
    for run in range(scaled(RUNS)):
        one(solver, tally, run, random.Random(first + run))
    return tally.end()


if __name__ == "__main__":
    sys.exit(main())
