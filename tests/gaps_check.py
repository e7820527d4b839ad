"""What lies within a step: gaps_check.py BUILD_DIR

Functions that are 0 at several places close together on a motion's way, far closer than steps are long: as arguments of roots, logarithms and arcs, whose
domains have gaps there; as denominators; as arguments of switches; as events; and as what looks like one of these and ends nothing. Each is known in closed form.
By every method, in double and double-double, at several tolerances. SGA_TEST_SEED, SGA_TEST_SCALE as everywhere."""
import math
import random
import sys

from solver import Solver
from tally import Tally, build_folder, scaled, seed

RUNS = 300


def polynomial(zeros):
    """Coefficients of the product of (s - zero), by rising powers."""
    p = [1.0]
    for z in zeros:
        p = [(p[i - 1] if i else 0) - (z * p[i] if i < len(p) else 0) for i in range(len(p) + 1)]
    return p


def integral(zeros):
    """Of the negative part of the product, from below all zeros to above them, taken about their middle."""
    middle = (zeros[0] + zeros[-1]) / 2
    p, sum = polynomial([z - middle for z in zeros]), 0.0
    for low, high in zip(zeros[::2], zeros[1::2]):
        sum -= math.fsum(c / (k + 1) * ((high - middle) ** (k + 1) - (low - middle) ** (k + 1)) for k, c in enumerate(p))
    return sum


def drawn(rng, tolerance):
    """Name, variables, equations, start, events; when it ends (None: it does not) and by which reasons; what z is at the end; how many events."""
    width = 10 ** rng.uniform(max(-5, math.log10(300 * tolerance)), -2)
    at, pairs = round(rng.uniform(0.2, 0.8), 3), rng.choice([1, 1, 2])
    zeros = [at + width * k * rng.uniform(0.8, 1) for k in range(2 * pairs)]
    way = rng.choice(["time", "line", "swing"])
    s = "t" if way == "time" else "x"
    when = zeros[0] if way != "swing" else math.asin(zeros[0])
    p = "*".join(f"({s} - {z!r})" for z in zeros)
    least, gone, pole = width ** (2 * pairs), ("left_domain",), ("blow_up",)
    base = {"time": ([], []), "line": (["x"], ["x' = 1"]), "swing": (["x", "v"], ["x' = v", "v' = -x"])}[way]
    start = {"x": 0, "z": 0, **({"v": 1} if way == "swing" else {})} if way != "time" else {"z": 0}
    total, speed = integral(zeros), "v" if way == "swing" else "1"
    name, extra, variable, end, reasons, value, events = rng.choice([
        ("sqrt", f"y = sqrt({p})", "y", when, gone, 0, []),
        ("power", f"y = ({p})^(3/2)", "y", when, gone, 0, []),
        ("acos", f"y = acos(1 - {p})" if least > 1e-13 else f"y = cbrt({p})", "y", when if least > 1e-13 else None, gone, 0, []),
        ("log", f"y = log({p})", "y", when, gone + pole, 0, []),
        ("root in the field", f"z' = sqrt({p})", None, when, gone, None, []),
        ("pole", f"z' = {least!r}/({p})", None, when, pole, None, []),
        ("weak pole", f"z' = {1e-3 * least!r}/({p})", None, when, pole, None, []),
        ("switch", f"z' = {speed}*max(0, -({p}))*{0.1 / total!r}", None, None, None, 0.1, []),
        ("nearly a gap", f"z' = sqrt(({p})^2 + {(0.01 * least) ** 2!r})", None, None, None, None, []),
        ("square", f"y = sqrt(({p})^2)", "y", None, None, 0, []),
        ("no pole", f"z' = sin({p})/({p})", None, None, None, None, []),
        ("no gap", f"z' = sqrt(max(0, {p}))", None, None, None, None, []),
        ("root begins", f"z' = sqrt(max(0, {s} - {zeros[0]!r}))", None, None, None, None if way == "swing" else 2 / 3 * (1.1 - zeros[0]) ** 1.5, []),
        ("event", "", None, None, None, 0, [{"name": "zero", "expression": p, "action": "record"}]),
    ])
    variables = base[0] + ["z"] + ([variable] if variable else [])
    equations = base[1] + ([extra] if extra else []) + ([] if "z'" in extra else ["z' = 0"])
    return f"{name} {way} {width:.1g} x{2 * pairs}", variables, equations, start, events, end, reasons, value, 2 * pairs


def accuracy_of(rng):
    tolerance = rng.choice([1e-4, 1e-6, 1e-8, 1e-10])
    accuracy = {"rtol": tolerance, "atol": tolerance}
    if rng.random() < 0.2 and tolerance < 1e-7:
        accuracy.update({"arithmetic": "double-double", **rng.choice([{}, {"method": "radau"}])})
    elif rng.random() < 0.5:
        accuracy["method"] = rng.choice(["dop853", "radau", "taylor", "tsit5"])
    return accuracy


def large(solver, tally):
    """Beside a network of 80 variables, half of them algebraic, which is solved as it stands."""
    n = 40
    variables = [f"x{i}" for i in range(n)] + [f"y{i}" for i in range(n)] + ["w"]
    network = [f"x{i}' = y{i} - x{i}" for i in range(n)] + [f"y{i}*(2 + x{i}^2) + sin(y{i}) = x{(i + 1) % n} + y{(i + 1) % n}/10" for i in range(n)]
    for gap, reason in (("w = sqrt((t - 0.3)*(t - 0.3003))", "left_domain"), ("w = 1e-6/((t - 0.3)*(t - 0.3003))", "blow_up"),
                        ("w = log((t - 0.3)*(t - 0.3003) + 1e-7)", None), ("w = cbrt((t - 0.3)*(t - 0.3003))", None)):
        for method in ("auto", "radau"):
            request = {"system": {"form": "equations", "variables": variables, "equations": [*network, gap]}, "want": ["trajectory"],
                       "accuracy": {"rtol": 1e-7, "atol": 1e-7, "method": method},
                       "trajectory": {"stop": 0.5, "samples": 2, "initial": {f"x{i}": 0.3 + 0.01 * i for i in range(n)}}}
            answer, problem = solver.solve(request)
            label = f"large, {gap}, {method}"
            if not tally.check(answer and "trajectory" in answer, f"{label}: an answer", problem):
                continue
            ended = answer["trajectory"]["ended"]
            if reason:
                tally.check(ended and ended["reason"] == reason and abs(ended["t"] - 0.3) < 1e-6, f"{label}: it ends", ended)
            else:
                tally.check(not ended, f"{label}: it goes on", ended)


def main():
    solver, tally = Solver(build_folder()), Tally("gaps")
    rng = random.Random(seed(20261130))
    for run in range(scaled(RUNS)):
        accuracy = accuracy_of(rng)
        tolerance = accuracy["rtol"]
        name, variables, equations, start, events, end, reasons, value, zeros = drawn(rng, tolerance)
        request = {"system": {"form": "equations", "variables": variables, "equations": equations}, "want": ["trajectory"], "accuracy": accuracy,
                   "trajectory": {"stop": 1.1, "samples": 3, "initial": start, **({"events": events} if events else {})}}
        answer, problem = solver.solve(request)
        label = f"{run}: {name} {accuracy}"
        if not tally.check(answer and "trajectory" in answer, f"{label}: an answer", problem):
            continue
        t = answer["trajectory"]
        ended = t["ended"]
        if end is not None:
            tally.check(ended and ended["reason"] in reasons and abs(ended["t"] - end) < 1e-3 * end, f"{label}: it ends at {end:.9g}", ended)
            continue
        tally.check(not ended, f"{label}: it goes on", ended)
        if not ended and value is not None:
            z = t["rows"][-1][t["columns"].index("z")]
            tally.check(abs(z - value) < max(100 * tolerance, 1e-9), f"{label}: z is {value}", z)
        if not ended and events:
            tally.check(len(t["events"]) == zeros, f"{label}: each zero is an event", len(t["events"]))
    large(solver, tally)
    return tally.end()


if __name__ == "__main__":
    sys.exit(main())
