"""A bead on a curve and its derivatives, each variable, parameter and the time in units of its own: those of units of 1 come back (sensitivities_check.py)."""
import random

import sympy

x, v, y, w, l, k, c, t = sympy.symbols("x v y w l k c t")


def text(e):
    return sympy.sstr(sympy.sympify(e)).replace("**", "^")


class Bead:
    def __init__(self, rng):
        number = lambda a, b: sympy.Rational(rng.randint(a, b), rng.choice([3, 4, 5, 7]))
        self.form = rng.choice(["multipliers", "named", "reduced"])
        self.curve = rng.choice([x**2 / 3, sympy.sin(x), x / 2])
        self.slope, self.bend = sympy.diff(self.curve, x), sympy.diff(self.curve, x, 2)
        self.along, self.down = -k * x - c * v + number(1, 5) * sympy.cos(rng.randint(1, 3) * t), -number(2, 10)
        self.k, self.c = number(4, 20), number(1, 3) / 2
        self.wall, self.rest = rng.choice([1, -1]) * number(1, 4) / 4, number(1, 3) / 4 + sympy.Rational(1, 10)
        self.kicked, self.side = rng.random() < 0.4, rng.choice(["up", "down"])

    def request(self, unit):
        """unit: by symbol."""
        v_name = "x'" if self.form == "multipliers" else "v"
        names = {v: sympy.Symbol(v_name), w: w}
        put = {s: unit[s] * names.get(s, s) for s in (x, v, w, l, k, c, t)}
        put[y] = unit[x] * y
        to = lambda e: text(sympy.sympify(e).subs(put, simultaneous=True))
        rate, fall = (f"{text(unit[t] / unit[s])}*({to(e)})" for s, e in ((v, self.along + self.slope * l), (w, self.down - l)))
        surface = f"y = {to(self.curve / unit[x])}"
        speed = {s: text(unit[s] * unit[t] / unit[x]) for s in (v, w)}
        variables, equations = {
            "multipliers": (["x", "y", "l"], [f"x'' = {rate}", f"y'' = {fall}", surface]),
            "named": (["x", "v", "y", "l", "w"], [f"x' = {speed[v]}*v", f"v' = {rate}", f"y' = {speed[w]}*w", f"w' = {fall}", surface]),
            "reduced": (["x", "v"], [f"x' = {speed[v]}*v", f"v' = {text(unit[t] / unit[v])}*({to((self.along + self.slope * self.down - self.slope * self.bend * v**2) / (1 + self.slope**2))})"]),
        }[self.form]
        events = [{"name": "wall", "expression": f"x - ({text(self.wall / unit[x])})", "direction": self.side, "action": "set", "set": {v_name: f"-{self.rest}*{v_name}"}, "max": 3}]
        return {"system": {"form": "equations", "variables": variables, "equations": equations, "parameters": {"k": str(self.k / unit[k]), "c": str(self.c / unit[c])}},
                "want": ["trajectory"], "accuracy": {"rtol": 1e-9}, "limits": {"seconds": 120},
                "trajectory": {"stop": str(6 / unit[t]), "samples": 7, "initial": {"x": str(sympy.Rational(9, 10) / unit[x]), v_name: str(sympy.Rational(1, 5) / unit[v])}, "hold": ["x", v_name],
                               "outputs": ["x", v_name], "events": events if self.kicked else [], "sensitivities": {"parameters": ["k", "c"], "initial": ["x"]}}}

    def units(self, rng, most):
        ten = {s: sympy.Integer(10)**rng.randint(-most, most) for s in (x, v, w, l, k, c, t)}
        if self.form == "multipliers":
            ten[v] = ten[w] = ten[x] / ten[t]
        return ten


def check(tally, solver, first, count):
    for n in range(first, first + count):
        rng = random.Random(n)
        bead = Bead(rng)
        one, other = {s: sympy.Integer(1) for s in (x, v, w, l, k, c, t)}, bead.units(rng, 9)
        told = [solver.solve(bead.request(unit)) for unit in (one, other)]
        label = f"units {n}, {bead.form}"
        if not tally.check(all(answer for answer, _ in told), f"{label}: both are answered", str([problem for _, problem in told])):
            continue
        plain, scaled = (answer["trajectory"] for answer, _ in told)
        tally.check(plain["ended"] == scaled["ended"] is None, f"{label}: they end alike", f"{plain['ended']} {scaled['ended']}")
        back = [float(other[a] / other[d]) for a in (x, v) for d in (k, c, x)]
        for a, b in zip(plain["sensitivities"]["rows"], scaled["sensitivities"]["rows"]):
            if None not in a and None not in b:
                tally.check(all(abs(p - q * s) <= 1e-5 * (1 + abs(p)) for p, q, s in zip(a[1:], b[1:], back)), f"{label}: derivatives", f"{a} {b}")
