"""Linkages through their change-over points, against mpmath: change_over_check.py BUILD_DIR

Random four-bars whose shortest and longest links are together as long as the others: once in a turn all lie on a line, where another branch begins. Crank by an equation, or
by a rate that is asked for; in double and in double-double, forwards and backwards. Positions after it are held against the zero of the closure equations in
40 digits next to the answer, which must be the same branch: on the analytic curve the coupler comes to the other side of the diagonal. A motion may also end there, and say why, but
no more than one in ten. Events change nothing of that, and are told at the times that the crank's angle says: at the place itself, on both sides of it, in pairs, and where they only touch; what the constraints keep at 0 is none.
SGA_TEST_SEED, SGA_TEST_SCALE."""
import cmath
import math
import random
import sys

import mpmath as mp

from solver import Solver
from tally import Tally, build_folder, scaled, seed


class FourBar:
    def __init__(self, rng, units):
        self.units = [rng.choice([1, 1e-3, 1e3, 1e-2, 100]) for _ in range(3)] if units else [1, 1, 1]
        while True:
            a, b, c = round(rng.uniform(0.5, 1.2), 2), round(rng.uniform(1.5, 3), 2), round(rng.uniform(1.2, 2.5), 2)
            folds = rng.random() < 0.5
            d = round(b + c - a if folds else a + b - c, 2)
            z = d - a * cmath.exp(1j)
            if d > 0 and abs(b - c) < abs(z) < b + c:
                break
        self.lengths = (a, b, c, d)
        turn = math.acos((b * b + abs(z) ** 2 - c * c) / (2 * b * abs(z))) * rng.choice([1, -1])
        self.B = cmath.phase(z) + turn
        self.C = cmath.phase(a * cmath.exp(1j) + b * cmath.exp(1j * self.B) - d)
        self.rows, self.sense = rng.choice([(1, 0, 0, 1), (0.6, 0.8, -0.8, 0.6), (1, 2, 3, 4)]), rng.choice([1, 1, -1])
        self.place = {(1, True): math.pi, (1, False): 2 * math.pi, (-1, True): -math.pi, (-1, False): 0}[self.sense, folds]

    def events(self, rng):
        """By name: the function of the crank's angle in radians, and when it is 0."""
        p, q = self.place + rng.uniform(-0.02, 0.02), self.place + rng.uniform(-0.3, 0.3)
        k, shift = rng.randint(3, 9), round(rng.uniform(0, 1), 2)
        low, high = sorted((1, self.place + 1.1 * self.sense))
        waves = [(math.pi * i + shift) / k for i in range(-60, 60)]
        return {"place": (f"{{}} - {self.place!r}", [self.place]), "pair": (f"({{}} - {p!r})*({{}} - {self.place + self.sense * 0.01!r})", [p, self.place + self.sense * 0.01]),
                "touch": (f"({{}} - {q!r})^2", [q]), "waves": (f"sin({k}*{{}} - {shift})", [t for t in waves if low < t < high])}

    def request(self, rate, events=()):
        a, b, c, d = self.lengths
        A, B, C = (f"{u}*{v}" if u != 1 else v for u, v in zip(self.units, "ABC"))
        closure = f"({a}*cos({A}) + {b}*cos({B}) - {d} - {c}*cos({C}))", f"({a}*sin({A}) + {b}*sin({B}) - {c}*sin({C}))"
        u, v, w = self.units
        equations = [f"({p})*{closure[0]} + ({q})*{closure[1]} = 0" for p, q in (self.rows[:2], self.rows[2:])]
        times = [1, 1 + 0.5 * self.sense] + [round(self.place + self.sense * v, 2) for v in (0.3, 0.7, 1.1)]
        happens = [{"name": name, "expression": f.replace("{}", A), "action": "record"} for name, (f, _) in dict(events).items()]
        happens += [{"name": "kept", "expression": f"3*{closure[1]} - {closure[0]}", "action": "record"}] * bool(happens)
        return {"system": {"form": "equations", "variables": ["A", "B", "C"], "equations": ([] if rate else [f"A' = 1/{u}"]) + equations}, "want": ["trajectory"], "limits": {"seconds": 60},
                "trajectory": {"start": 1, "times": times, "initial": {"A": 1 / u, "B": self.B / v, "C": self.C / w}, "hold": ["A"], **({"events": happens} if happens else {}), **({"gauge": {"rates": {"A": f"1/{u}"}}} if rate else {})}}

    def exact(self, A, B, C):
        """The position at A nearest to B, C."""
        a, b, c, d = (mp.mpf(str(v)) for v in self.lengths)
        return mp.findroot(lambda p, q: (a * mp.cos(A) + b * mp.cos(p) - d - c * mp.cos(q), a * mp.sin(A) + b * mp.sin(p) - c * mp.sin(q)), (B, C))

    def follows(self, row):
        """Of the two positions at A that of the motion's side: the coupler keeps its sense against the diagonal, but for each pass, where it changes."""
        a, b, _, d = self.lengths
        return math.sin(row[2] - cmath.phase(d - a * cmath.exp(1j * row[1])))


def happened(tally, label, t, events, fine):
    """What is told of the events is what happens; how many errors of their times hold, and how many there are."""
    last, told, held = float(t["rows"][-1][0]), {name: sorted(float(e["t"]) for e in t["events"] if e["name"] == name) for name in events}, []
    sense = 1 if last > float(t["rows"][0][0]) else -1
    for name, (_, times) in events.items():
        times = sorted(x for x in times if sense * (last - x) > 1e-6)
        near = 1e-6 if name == "touch" else 1e-12 if fine else 1e-4
        tally.check(len(told[name]) == len(times) and all(abs(x - y) < near for x, y in zip(told[name], times)), f"{label}: event {name}", (told[name], times))
        senses = {e["direction"] for e in t["events"] if e["name"] == name}
        tally.check(senses <= {"touch"} if name == "touch" else "touch" not in senses if name != "place" else senses <= {"up"}, f"{label}: the sense of {name}", senses)
        for e in [e for e in t["events"] if e["name"] == name and e["error"] is not None and times]:
            held.append(min(abs(float(e["t"]) - x) for x in times) <= e["error"] + 4e-16 * abs(float(e["t"])))
    kept = [e for e in t.get("events", []) if e["name"] == "kept"]
    tally.check(not kept, f"{label}: what the constraints keep at 0 is no event", kept[:2])
    return sum(held), len(held)


def check(tally, solver, label, bar, rate, accuracy, events):
    """How many errors there were, and how many were told."""
    answer, wrong = solver.solve({**bar.request(rate, events), "accuracy": accuracy})
    t = answer and answer["trajectory"]
    end = t and t["ended"]
    if not tally.check(t and (end is None and len(t.get("passed", [])) == 1 or end and end["reason"] in ("stratum", "gauge_contradiction") and abs(end["t"] - bar.place) < 1e-4),
                       f"{label}: passes its change-over point and says so, or ends there", wrong or (end, t.get("passed"), bar.request(rate))) or end:
        return 0, 0
    held = 0
    tally.times.append(happened(tally, label, t, events, accuracy["rtol"] < 1e-12))
    for row, told in zip(t["rows"], t["errors"]):
        u = [1] + [mp.mpf(str(k)) for k in bar.units]
        v = [mp.mpf(getattr(x, "text", str(x))) * k for x, k in zip(row, u)]
        B, C = bar.exact(v[0], v[2], v[3])
        held += max(abs(v[1] - v[0]) / u[1], abs(v[2] - B) / u[2], abs(v[3] - C) / u[3]) <= (0 if told is None else told)
    side = [bar.follows([float(x) * k for x, k in zip(row, [1] + bar.units)]) for row in t["rows"]]
    tally.check(side[0] * side[1] > 0 > side[0] * side[2] and side[2] * side[3] > 0, f"{label}: its own curve, which leaves the line on the other side", (side, bar.request(rate)))
    return held, len(t["rows"])


def main():
    mp.mp.dps = 40
    tally, solver, rng, held, rows, asked = Tally("change-over points"), Solver(build_folder()), random.Random(seed(20261126)), 0, 0, 0
    tally.times = []
    for n in range(max(8, scaled(24))):       # fewer say nothing of how often errors hold
        bar = FourBar(rng, n % 2)
        for rate in (False, True):
            for accuracy in ({"rtol": rng.choice([1e-6, 1e-9])}, {"rtol": rng.choice([1e-6, 1e-9]), "method": rng.choice(["taylor", "dop853", "tsit5", "radau"])},
                             {"rtol": 1e-16, "atol": 1e-16, "arithmetic": "double-double"}):
                asked += 5
                h, r = check(tally, solver, f"four-bar {n}, {'rate, ' if rate else ''}{accuracy}", bar, rate, accuracy, bar.events(rng) if rng.random() < 0.5 else {})
                held, rows = held + h, rows + r
    tally.check(held >= 0.95 * rows, "errors hold", (held, rows))
    tally.check(sum(h for h, _ in tally.times) >= 0.9 * sum(k for _, k in tally.times), "errors of events hold, of which those of a motion have the same cause", [sum(x) for x in zip(*tally.times)])
    tally.check(rows >= 0.9 * asked, "nearly all pass", (rows, asked))
    print(f"{rows} positions, errors hold for {held}")
    return tally.end()


if __name__ == "__main__":
    sys.exit(main())
