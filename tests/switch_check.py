"""Signals with names against signals put in: switch_check.py BUILD_DIR

Random piecewise systems (saturations, dead zones, rectifiers, minima and maxima, roots, jumps in time, loops), each as a chain of
named signals, in random orders of variables and equations, and as the ordinary differential equation that
is left when all of them are put in. The verdict is the same, each name adds one dimension of the ambient
space and none of the final set, and both motions are that of a Runge-Kutta integration with
small steps. Starts lie on both sides of switches and on them. What jumps in time is put into other switches, and into loops."""
import math
import random
import re
import sys

from jump_check import Jumps
from solver import Crash, Solver
from tally import Tally, build_folder, scaled, seed

STEP, STOP, ROWS = 1 / 2000, 3, 7
CLOSE = 1e-6                     # of the two motions, beside their rtol of 1e-9
REFERENCE = {"smooth": 2e-5, "root": 2e-3, "jump": 1e-4}


def sign(a):
    return (a > 0) - (a < 0)


NAMES = {"min": min, "max": max, "abs": abs, "sign": sign, "sin": math.sin, "cos": math.cos,
         "sqrt": lambda a: math.sqrt(max(a, 0)), "cbrt": lambda a: math.copysign(abs(a) ** (1 / 3), a)}


def function(text, names):
    code = compile(re.sub(r"\b(\d+)/(\d+)\b", r"(\1/\2)", text).replace("^", "**"), text, "eval")
    return lambda *values: eval(code, {**NAMES, **dict(zip(names, values))})     # texts are made here


class Chain:
    """States, and signals that are functions of states, time and earlier signals."""

    def __init__(self, rng):
        self.rng, self.kind = rng, "smooth"
        self.states = ["x", "v"][:rng.randint(1, 2)]
        self.signals = []        # (name, text, equation)
        self.used = set()
        for _ in range(rng.randint(1, 4)):
            self.signal()
        self.rates = {}
        outputs = [n for n, *_ in self.signals if n not in self.used] or [self.signals[-1][0]]
        for s in self.states:
            self.rates[s] = " + ".join([f"{self.number()}*{o}" for o in outputs] + [f"cos({rng.randint(1, 3)}*t)"])
        if self.kind == "root":      # they pull back: where they pushed, motions from 0 would not be unique
            self.rates = {s: f"cos(2*t) - {self.signals[-1][0]}" for s in self.states[:1]}
            self.rates.update({s: f"-{s}" for s in self.states[1:]})

    def number(self):
        return f"{self.rng.choice([-1, 1])}*{self.rng.randint(1, 6)}/{self.rng.randint(2, 5)}"

    def source(self):
        names = self.states + [n for n, *_ in self.signals]      # what jumps makes others jump, and turns their switches
        name = self.rng.choice(names)
        self.used.add(name)
        return self.rng.choice([name, f"({self.number()}*{name})", f"({name} - sin({self.rng.randint(1, 3)}*t))", f"(1/2 - {name})"])

    def add(self, text, equation=None):
        name = f"s{len(self.signals)}"
        forms = [f"{name} = {text}", f"0 = {text} - {name}", f"2*{name} - 2*({text}) = 0", f"({text})/3 = {name}/3"]
        self.signals.append((name, text, equation.replace("NAME", name) if equation else self.rng.choice(forms)))

    def signal(self):
        a, b = self.source(), self.source()
        which = self.rng.randint(0, 9)
        if which == 0:
            self.add(f"max(0, {a})")
        elif which == 1:
            self.add(f"min(1, max(-1, 2*{a}))")
        elif which == 2:
            self.add(f"(max({a} - 1/2, 0) + min({a} + 1/2, 0))")
        elif which == 3:
            self.add(f"abs({a})")
        elif which == 4:
            self.add(f"min({a}, {b})")
        elif which == 5:
            self.add(f"({a} + {b})/2")
        elif which == 6:             # a loop: s + max(0, s) = a
            self.add(f"(min({a}, 0) + max({a}, 0)/2)", f"NAME + max(0, NAME) = {a}")
        elif which == 7:             # the same with a root of an algebraic equation beside it
            self.add(f"(max({a}, 0) - {b})", f"(NAME - max({a}, 0) + {b})*(2 + sin(NAME)) = 0")
        elif which == 8 and self.kind == "smooth":
            self.kind = "jump"
            self.add(f"({a} + sign(cos(2*t)))")
        elif self.kind == "smooth" and not self.signals:
            self.kind = "root"
            text = self.rng.choice(["sign(x)*sqrt(abs(x))", "cbrt(x)", "sign(x)*sqrt(abs(x))/2"])
            self.add(f"({text})")
        else:
            self.add(f"max({a}, {b})")

    def inserted(self, text):
        for name, value, _ in reversed(self.signals):
            text = re.sub(rf"\b{name}\b", f"({value})", text)
        return text

    def start(self):
        return {s: self.rng.choice([0, 0, "1/2", "-1/2", 1, -1, f"{self.rng.randint(-20, 20)}/16"]) for s in self.states}

    def reference(self, initial):
        f = [function(self.inserted(self.rates[s]), ["t"] + self.states) for s in self.states]

        def rate(t, x):
            return [g(t, *x) for g in f]
        x, rows, steps = [float(eval(str(initial[s]))) for s in self.states], [], round(STOP / STEP)
        jumps = [math.pi / 4, 3 * math.pi / 4] if self.kind == "jump" else []         # of sign(cos(2*t)): steps end there
        times = sorted([k * STEP for k in range(steps + 1)] + jumps)
        for t, h in zip(times, [b - a for a, b in zip(times, times[1:])] + [0]):
            if t not in jumps and round(t / STEP) % (steps // (ROWS - 1)) == 0:
                rows.append([t] + x)
            first, last = t + 1e-9 * h, t + h - 1e-9 * h
            a = rate(first, x)
            b = rate(t + h / 2, [p + h / 2 * q for p, q in zip(x, a)])
            c = rate(t + h / 2, [p + h / 2 * q for p, q in zip(x, b)])
            d = rate(last, [p + h * q for p, q in zip(x, c)])
            x = [p + h / 6 * (q + 2 * r + 2 * s + u) for p, q, r, s, u in zip(x, a, b, c, d)]
        return rows


class Switches:
    def __init__(self, tally, solver):
        self.tally, self.solver = tally, solver

    def ask(self, label, variables, equations, initial, arithmetic="auto"):
        request = {"system": {"form": "equations", "variables": variables, "equations": equations},
                   "trajectory": {"stop": STOP, "samples": ROWS, "initial": initial}, "accuracy": {"rtol": 1e-9, "atol": 1e-9, "arithmetic": arithmetic}}
        try:
            result, problem = self.solver.solve(request)
        except Crash as e:
            result, problem = None, str(e)
        self.tally.check(result and not result["trajectory"]["ended"], label,
                         f"{equations} {variables} {initial}: {problem or result['trajectory']['ended']}")
        return result

    def gap(self, rows, columns, other, names):
        """Of the states, by the rows that both have."""
        place = [columns.index(n) for n in names]
        return max((abs(r[p] - q[1 + i]) / (1 + abs(q[1 + i])) for r, q in zip(rows, other) for i, p in enumerate(place)), default=math.inf)

    def signals(self, label, chain, trajectory):
        """Each signal at each row is what its definition makes of the states there; where it jumps, the time may be that of a jump."""
        columns = trajectory["columns"]
        for name, *_ in chain.signals:
            f = function(chain.inserted(name), ["t"] + chain.states)
            values = [(r[columns.index(name)], f(r[0], *[r[columns.index(s)] for s in chain.states])) for r in trajectory["rows"]]
            off = max(abs(a - b) / (1 + abs(b)) for a, b in values)
            self.tally.check(off <= 1e-7, f"{label}: {name} is what defines it", f"off by {off:.3g}")

    def one(self, k, rng):
        chain = Chain(rng)
        initial, n, s = chain.start(), len(chain.states), len(chain.signals)
        names = chain.states + [name for name, *_ in chain.signals]
        equations = [f"{x}' = {chain.rates[x]}" for x in chain.states] + [e for *_, e in chain.signals]
        put_in = self.ask(f"{k}: put in", chain.states, [f"{x}' = {chain.inserted(chain.rates[x])}" for x in chain.states], initial)
        reference = chain.reference(initial)
        for turn in range(2):
            rng.shuffle(names)
            rng.shuffle(equations)
            label = f"{k}, order {turn}"
            named = self.ask(f"{label}: named", list(names), list(equations), initial, ["auto", "double-double"][turn])
            if not named or not put_in:
                continue
            d = named["dimensions"]
            self.tally.check((named["verdict"], d["ambient"], d["final"], d["generations"]) == (put_in["verdict"], n + s, n, [n]),
                             f"{label}: verdict and dimensions", f"{named['verdict']} {d}: {equations}")
            self.tally.check(not named["evidence"].get("sides"), f"{label}: it holds on all sides", str(named["evidence"].get("sides")))
            t = named["trajectory"]
            gap = self.gap(t["rows"], t["columns"], put_in["trajectory"]["rows"], put_in["trajectory"]["columns"][1:])
            far = self.gap(t["rows"], t["columns"], reference, chain.states)
            self.tally.check(gap <= CLOSE, f"{label}: the motion put in", f"{gap:.3g}: {equations} {initial}")
            self.tally.check(far <= REFERENCE[chain.kind], f"{label}: the reference", f"{far:.3g}: {equations} {initial}")
            self.signals(label, chain, t)


def main():
    tally = Tally("switches")
    first = seed(20261122)
    solver = Solver(build_folder())
    switches, jumps = Switches(tally, solver), Jumps(tally, solver)
    for k in range(scaled(40)):
        switches.one(k, random.Random(first + k))
        jumps.one(k, random.Random(first + k))
    return tally.end()


if __name__ == "__main__":
    sys.exit(main())
