"""A consistent start against the answer's own constraints: on Pf, nothing held or given moves without need, the nearest
point where that is asked, velocities that solve the equations, and coordinates that determine the rest."""
import math
import re

import linear
from expression import FLOAT, evaluate


def exact(x):
    return float(evaluate(x if isinstance(x, str) else repr(x)))


class ConsistentCheck:
    def __init__(self, tally, name, request, result, answer):
        self.tally, self.name, self.request, self.answer = tally, name, request, answer
        self.c = result["consistent_initial"]
        self.constraints = result.get("constraints")
        self.final = result["dimensions"]["final"]
        self.spec = request["trajectory"]
        self.start = exact(self.spec.get("start", 0))
        self.x = self.c["projected"]

    def check(self, ok, what, detail=""):
        self.tally.check(ok, f"{self.name}: start: {what}", detail)

    def environment(self):
        env = {k: exact(v) for k, v in (self.request["system"].get("parameters") or {}).items() if v is not None}
        return {**env, **self.x, self.answer.problem.time: self.start}

    def rows(self):
        """Values of the constraints and their differentials."""
        g, env = self.answer.graph, self.environment()
        out = []
        for _, e in self.answer.constraints:
            value = g.values(g.cone([e]), env, FLOAT)
            d = g.gradient(e, value, FLOAT)
            out.append((value[e], [d.get(n, 0.0) for n in self.answer.names]))
        return out

    def run(self, expect):
        names = self.answer.names
        initial = {k: exact(v) for k, v in self.spec.get("initial", {}).items()}
        self.check(set(self.x) == set(names) == set(self.c["derivatives"]), "every variable")
        for n in self.spec.get("hold", []):
            self.check(self.x[n] == initial.get(n, 0), f"{n} is held", self.x[n])
        units = {n: exact(v) for n, v in expect.get("units", {}).items()}     # natural sizes far from 1
        moved = math.sqrt(sum(((self.x[n] - v) / max(units.get(n, 1), abs(v) / 100)) ** 2 for n, v in initial.items()))
        self.check(abs(moved - self.c["moved"]) <= 1e-9 * (1 + moved), "moved", (moved, self.c["moved"]))
        self.check(all(abs(v) <= 1e-9 * (1 + max(map(abs, self.x.values()))) for v in self.c["residuals"] if v is not None), "residuals are small", self.c["residuals"])
        if "moved" in expect:
            self.check(abs(moved - exact(expect["moved"])) < 1e-7, "moved as far as it must", moved)
        for n, v in expect.get("derivatives", {}).items():
            self.check(abs(self.c["derivatives"][n] - exact(v)) <= 1e-7 * (1 + abs(exact(v))), f"derivative of {n}", self.c["derivatives"][n])
        if "free" in expect:
            self.check(self.c["free"] == expect["free"], "free", self.c["free"])
        self.relations()
        if self.constraints is not None:
            self.geometry(initial, expect)

    def relations(self):
        """The start's equations by the derivatives that the answer gives, and the bounds."""
        given = self.spec.get("start_equations", [])
        given = given if isinstance(given, list) else [given]
        self.check(len(given) == len(self.c.get("start_equations", [])), "a residual for each of the start's equations", self.c.get("start_equations"))
        env = {**self.environment(), **{n + "'": v for n, v in self.c["derivatives"].items() if n + "'" not in self.x}}
        for text, told in zip(given, self.c.get("start_equations", [])):
            left, right = [self.side(s, env) for s in text.split("=")]
            size = 1e-9 * (1 + abs(left) + abs(right))
            self.check(abs(left - right) <= size and abs(told) <= size, f"{text} holds", (left, right, told))
        for n, (low, high) in self.spec.get("bounds", {}).items():
            self.check((low is None or self.x[n] >= exact(low) - 1e-9) and (high is None or self.x[n] <= exact(high) + 1e-9), f"{n} within its bounds", self.x[n])

    def side(self, text, env):
        g = self.answer.graph
        e = g.parse(re.sub(r"\bder\((\w+)\)", r"\1'", text))
        return g.values(g.cone([e]), env, FLOAT)[e]

    def geometry(self, initial, expect):
        names, rows = self.answer.names, self.rows()
        self.check(len(rows) == len(self.c["residuals"]), "a residual for each constraint")
        sizes = [max(map(abs, d)) or 1 for _, d in rows]
        self.check(all(abs(v) / s < 1e-9 * (1 + max(map(abs, self.x.values()))) for (v, _), s in zip(rows, sizes)), "lies on Pf", [v for v, _ in rows])
        free = set(self.c["free"])
        self.check(free <= set(names) and len(free) == self.final, "as many free ones as Pf has dimensions", self.c["free"])
        rest = [[v / s for v, n in zip(d, names) if n not in free] for (_, d), s in zip(rows, sizes)]
        self.check(not rows or linear.rank(rest, 1e-9) == len(rows), "the free ones determine the others", self.c["free"])
        v = self.answer.motion({k: x for k, x in self.environment().items()}, self.rates())
        if "conditions" not in self.spec.get("gauge", {}):
            off = v and max(abs(float(a) - self.c["derivatives"][n]) / (1 + abs(float(a))) for a, n in zip(v, names))
            self.check(v and off < 1e-6, "derivatives", off)
        if self.c["moved"] > 0 and expect.get("nearest", True):
            # the way back is orthogonal to Pf, as far as values were given and count
            held, counted = set(self.spec.get("hold", [])), set(initial)
            follows = {n for n in initial if n in self.follows()}
            if all(self.x[n] == v for n, v in initial.items() if n not in follows):
                held |= counted - follows
            else:
                counted -= {n for n in follows if self.follows()[n]}
            back = [(self.x[n] - initial[n]) / max(1, abs(initial[n]) / 100) ** 2 if n in counted else 0.0 for n in names]
            columns = [i for i, n in enumerate(names) if n not in held]
            J = [[d[i] / s for i in columns] for (_, d), s in zip(rows, sizes)]
            b = [back[i] for i in columns]
            normal = [[sum(p * q for p, q in zip(r, t)) for t in J] for r in J]
            y = linear.least_norm(normal, [sum(p * q for p, q in zip(r, b)) for r in J], 1e-12)
            left = y and max(abs(b[i] - sum(y[k] * J[k][i] for k in range(len(J)))) for i in range(len(b)))
            self.check(y is not None and left < 1e-6 * (1 + max(map(abs, b))), "nearest to what was given", left)

    def follows(self):
        """Variables whose derivative no equation has: whether they are met beside derivatives only."""
        def has(e, pattern):
            return re.search(pattern, e) is not None
        lists = self.request["system"].get("equations", [])
        out = {}
        for n in self.answer.names:
            derivative = rf"\b{re.escape(n)}'|der\(\s*{re.escape(n)}\b"
            if lists and not n.endswith("'") and not any(has(e, derivative) for e in lists):
                out[n] = all(has(e, r"'|\bder\(") for e in lists if has(e, rf"\b{re.escape(n)}\b"))
        return out

    def rates(self):
        return {n: self.answer.graph.parse(e) for n, e in self.spec.get("gauge", {}).get("rates", {}).items()}
