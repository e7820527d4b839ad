"""Modes in the answers of cases: each reduction is that of the system with the mode's value as a parameter, which is another request;
the samples of each piece satisfy the constraints of its mode; pieces and impulses are those of closed forms."""
from expression import FLOAT, Graph, evaluate


def with_values(request, values):
    """The same request without modes: parameters in their place."""
    system = {k: v for k, v in request["system"].items() if k != "modes"}
    system["parameters"] = {**system.get("parameters", {}), **values}
    return {**request, "system": system}


def at_start(request):
    modes = request["system"].get("modes")
    return with_values(request, {n: m["start"] for n, m in modes.items()}) if modes else request


class ModeCheck:
    def __init__(self, tally, name, solver, request, result):
        self.tally, self.name, self.solver, self.request, self.result = tally, name, solver, request, result
        self.t = result.get("trajectory", {})

    def check(self, ok, what, detail=""):
        self.tally.check(ok, f"{self.name}: modes: {what}", detail)

    def run(self, expect):
        if "modes" in self.request["system"]:
            self.reductions()
            self.samples()
        if "entered" in expect:
            got = [[m["values"], len(m["entered"])] for m in self.result["modes"]]
            self.check(got == expect["entered"], "those reached, and how often", str(got))
        if "pieces" in expect:
            self.pieces(expect["pieces"])

    def reductions(self):
        for m in self.result["modes"]:
            alone = with_values({"system": self.request["system"]}, m["values"])
            plain, problem = self.solver.solve({"system": alone["system"], "want": ["constraints", "index"]})
            self.check(problem is None, f"{m['values']} alone", str(problem))
            for member in ("verdict", "dimensions"):
                self.check(problem is None and m["reduction"][member] == plain[member], f"{m['values']}: {member}", f"{m['reduction'][member]}, alone {plain and plain[member]}")
            self.check(problem is None and m["reduction"]["index"] == plain["index"], f"{m['values']}: index", str(m["reduction"]["index"]))
        first = self.result["modes"][0]["reduction"]
        self.check(first["dimensions"] == self.result["dimensions"], "the first is the answer's")

    def samples(self):
        """The values before an event are those of the piece before it."""
        if not self.t or "constraints" not in self.result:
            return
        modes = {str(m["values"]): m for m in self.result["modes"]}
        for row in self.t["rows"]:
            all_pieces = self.t.get("pieces") or [{"t": row[0], "mode": self.result["modes"][0]["values"]}]
            before = [p for p in all_pieces if p["t"] < row[0] - 1e-12 * abs(row[0])] or all_pieces[:1]
            mode = modes[str(before[-1]["mode"])]
            g = Graph()
            for n, v in {**self.request["system"].get("parameters", {}), **mode["values"]}.items():
                g.define(n, v)
            for d in mode["reduction"].get("definitions", []):
                g.define(d["name"], d["expression"])
            env = dict(zip(self.t["columns"], row))
            for c in mode["reduction"]["constraints"]:
                try:
                    e = g.parse(c["expression"])
                    value = g.values(g.cone([e]), env, FLOAT)
                except KeyError:         # not all variables are columns
                    continue
                size = 1 + max([abs(v) for v in value.values() if isinstance(v, (int, float))])
                self.check(abs(value[e]) <= 1e-8 * size, f"{c['expression']} at {row[0]}", f"{value[e]}")

    def pieces(self, expect):
        """[time, how it starts, impulse by coordinate or null]"""
        got = self.t["pieces"][1:]
        self.check([p["start"] for p in got] == [e[1] for e in expect], "how pieces start", str([[p["t"], p["start"]] for p in got]))
        for p, (t, _, impulse) in zip(got, expect):
            self.check(abs(p["t"] - float(evaluate(t))) <= 1e-7, f"the piece at {t}", str(p["t"]))
            size = max([abs(float(evaluate(v))) for v in (impulse or {}).values()] or [0]) or 1      # whatever the units
            for n, v in (impulse or {}).items():
                v = float(evaluate(v))
                self.check(abs(p["impulse"][n] - v) <= 1e-6 * size, f"the impulse on {n} at {t}", f"{p['impulse'][n]}, should be {v}")
