"""Masses on surfaces, at rest, in several forms and units: rest_check.py BUILD_DIR

Coordinates that are functions of others, as constraints with multipliers: mixed equations, constraints in disguise, first order with named velocities, masses; each variable
and the time in units of its own, up to twelve powers of ten. Equilibria are those of the reduced equations in few coordinates, which are written down here; what is
linearized there has their eigenvalues and transfer function."""
import random
import sys

import numpy
import sympy

from solver import Crash, Solver
from tally import Tally, build_folder, scaled, seed

x, w, y, z, u = sympy.symbols("x w y z u")


def text(e):
    return sympy.sstr(sympy.sympify(e)).replace("**", "^")


def rate(a):
    return sympy.Symbol(a.name + "'")


def push(a):
    return sympy.Symbol("l" + a.name)


class Masses:
    """Forces on masses at `base` and at what follows from it; y = phi(x, w), z = phi(x)."""
    def __init__(self, rng):
        self.rng = rng
        self.base, self.follow = rng.choice([([x], [y]), ([x], [y, z]), ([x, w], [y])])
        self.all = self.base + self.follow
        self.phi = {a: self.graph() for a in self.follow}
        self.mass = {a: abs(self.number()) for a in self.all}
        self.force = {a: -abs(self.number()) * a - abs(self.number()) * rate(a) / 3 + (self.number() if rng.random() < 0.4 else 0)
                      + (self.number() * rng.choice(self.all) * rng.choice(self.all) / 4 if rng.random() < 0.3 else 0) for a in self.all}
        self.force[x] += u
        self.gap = {a: a - self.phi[a] for a in self.follow}
        self.pushed = {a: self.force[a] + sum(push(b) * sympy.diff(self.gap[b], a) for b in self.follow) for a in self.all}

    def number(self):
        return sympy.Rational(self.rng.choice([n for n in range(-6, 7) if n]), self.rng.choice([1, 1, 2, 3]))

    def graph(self):
        a, b, n = self.rng.choice(self.base), self.base[-1], self.number
        return self.rng.choice([n() * a**2 / 2 + n() * b, n() * a / 2 + n(), n() * a**3 / 4 + n() * b / 3, n() * x * b / 2])

    def reduced(self):
        """M and f of M base'' = f."""
        J = {a: [sympy.diff(self.phi.get(a, a), b) for b in self.base] for a in self.all}
        speed = {a: sum(j * rate(b) for j, b in zip(J[a], self.base)) for a in self.all}
        bent = {a: sum(sympy.diff(self.phi.get(a, a), b, c) * rate(b) * rate(c) for b in self.base for c in self.base) for a in self.all}
        force = {a: self.force[a].subs({rate(b): speed[b] for b in self.all}, simultaneous=True).subs(self.phi) for a in self.all}
        n = range(len(self.base))
        M = sympy.Matrix(len(self.base), len(self.base), lambda i, k: sum(self.mass[a] * J[a][i] * J[a][k] for a in self.all))
        return M, sympy.Matrix([sum(J[a][i] * (force[a] - self.mass[a] * bent[a]) for a in self.all) for i in n])

    def plain(self):
        names = [a.name for a in self.all] + [push(a).name for a in self.follow] + ["u"]
        return {"form": "equations", "variables": names, "equations": [f"{self.mass[a]}*{a}'' = {text(self.pushed[a])}" for a in self.all] + [text(self.gap[a]) + " = 0" for a in self.follow]}

    def disguised(self):
        rng, lines = self.rng, []
        for a, b in zip(self.all, self.all[1:]):
            f = rng.choice([1, 2, -1, sympy.Rational(1, 2)])
            lines.append(f"{self.mass[a]}*{a}'' + {f * self.mass[b]}*{b}'' = {text(self.pushed[a] + f * self.pushed[b])}")
        a = self.all[-1]
        lines.append(f"{self.mass[a]}*{a}'' = {text(self.pushed[a])}")
        for a in self.follow:
            c = text(self.gap[a])
            lines.append(rng.choice([f"exp(x)*({c}) = 0", f"({c})*(1 + {a}^2) = 0", f"sinh({c}) = 0", f"atan({c}) = 0", f"{c} + ({c})^3 = 0"]))
        names = self.plain()["variables"]
        return {"form": "equations", "variables": rng.sample(names, len(names)), "equations": rng.sample(lines, len(lines))}

    def masses(self):
        return {"form": "mechanical", "coordinates": [a.name for a in self.all], "masses": [str(self.mass[a]) for a in self.all], "forces": [text(self.force[a]) for a in self.all],
                "constraints": [text(self.gap[a]) for a in self.follow], "parameters": {"u": 0}}

    def in_units(self, most, first):
        """The system, units by coordinate, and that of time; first: of first order, with velocities of units of their own."""
        ten = lambda k: sympy.Integer(10)**self.rng.randint(-k, k)
        unit, time = {a: ten(most) for a in self.all}, ten(most // 2)
        speed, row = {a: ten(most) if first else unit[a] / time for a in self.all}, {a: ten(most) for a in self.all}
        v = {a: sympy.Symbol("v" + a.name) if first else rate(a) for a in self.all}
        put = {**{a: unit[a] * a for a in self.all}, **{rate(a): speed[a] * v[a] for a in self.all}, **{push(a): ten(most) * push(a) for a in self.follow}, u: ten(most) * u}
        names, lines = self.plain()["variables"], []
        for a in self.all:
            lines.append(f"{text(self.mass[a] * speed[a] / time * row[a])}*{a.name + chr(39) * 2 if not first else v[a].name + chr(39)} = "
                         + text(sympy.expand(row[a] * self.pushed[a].subs(put, simultaneous=True))))
            lines += [f"{a}' = {text(speed[a] * time / unit[a])}*{v[a]}"] if first else []
        lines += [text(sympy.expand(self.gap[a].subs(put, simultaneous=True) / unit[a])) + " = 0" for a in self.follow]
        names = names + ([v[a].name for a in self.all] if first else [])
        return {"form": "equations", "variables": self.rng.sample(names, len(names)), "equations": self.rng.sample(lines, len(lines))}, unit, time


def numbers(matrix):
    return numpy.array([[float(sympy.Rational(str(e))) if isinstance(e, str) else float(e) for e in row] for row in matrix], float)


class Check:
    def __init__(self):
        self.tally, self.solver = Tally("rest"), Solver(build_folder(), 300)
        self.linearized = self.points = 0

    def ask(self, request, label):
        try:
            answer, problem = self.solver.solve({**request, "limits": {"seconds": 120}})
        except Crash as crash:
            answer, problem = None, crash
        self.tally.check(answer is not None, label, str(problem)[:400])
        return answer

    def at(self, masses, place):
        """A and B of the reduced equations at a place, and the second output's slope."""
        M, f = masses.reduced()
        there = {**dict(zip(masses.base, place)), **{rate(a): 0 for a in masses.base}, u: 0}
        n = len(masses.base)
        value = lambda m: numpy.array(sympy.Matrix(m).subs(there).evalf(30).tolist(), float)
        inverse = numpy.linalg.inv(value(M))
        A = numpy.block([[numpy.zeros((n, n)), numpy.eye(n)], [inverse @ value(f.jacobian(masses.base)), inverse @ value(f.jacobian([rate(a) for a in masses.base]))]])
        last = masses.phi[masses.follow[-1]]
        return A, numpy.vstack([numpy.zeros((n, 1)), inverse @ value(f.jacobian([u]))]), numpy.array([float(sympy.diff(last, a).subs(there)) for a in masses.base])

    def linearize(self, masses, system, point, unit, time, label):
        place = [float(point["values"][a.name]) * float(unit[a]) for a in masses.base]
        start = {name: value for name, value in point["values"].items() if name in system["variables"]}
        outputs = [x.name, masses.follow[-1].name]
        answer = self.ask({"system": system, "want": ["linearization"], "trajectory": {"initial": {**start, "u": 0}}, "linearization": {"inputs": ["u"], "outputs": outputs}}, f"{label}: linearized")
        if not answer:
            return
        self.linearized += 1
        told = answer["linearization"][0]
        A, B, slope = self.at(masses, place)
        order = lambda e: (round(e.real, 4), e.imag)
        ours = sorted((complex(e[0], e[1]) / float(time) for e in told["eigenvalues"] for _ in range(e[2])), key=order)
        theirs = sorted(numpy.linalg.eigvals(A), key=order)
        self.tally.check(len(ours) == len(theirs) and all(abs(p - q) <= 1e-4 * (1 + abs(q)) for p, q in zip(ours, theirs)), f"{label}: eigenvalues", f"{ours} {theirs}")
        if time != 1 or any(unit[a] != 1 for a in masses.all):
            return
        a, b, c, d = (numbers(told["state"][m]) for m in "ABCD")
        s = 0.7 + 1.3j
        n = len(masses.base)
        C = numpy.zeros((2, 2 * n))
        C[0, 0], C[1, :n] = 1, slope
        G, H = (p @ numpy.linalg.solve(s * numpy.eye(2 * n) - m, q) + r for m, q, p, r in ((A, B, C, 0), (a, b, c, d)))
        self.tally.check(numpy.max(numpy.abs(G - H)) <= 1e-6 * (1 + numpy.max(numpy.abs(G))), f"{label}: transfer function", f"{G.tolist()} {H.tolist()}")

    def form(self, masses, system, unit, time, label, linearize):
        """Places of equilibria, and whether they are all."""
        inputs = {} if system["form"] == "mechanical" else {"equilibria": {"hold": {"u": 0}}}
        answer = self.ask({"system": system, "want": ["equilibria"], **inputs}, label)
        if not answer:
            return None
        found = [p for p in answer["equilibria"]["points"] if p["certified"]]
        f = masses.reduced()[1].subs({u: 0, **{rate(a): 0 for a in masses.base}})
        places = [[float(p["values"][a.name]) * float(unit[a]) for a in masses.base] for p in found]
        for p, place in zip(found, places):
            self.points += 1
            there = dict(zip(masses.base, place))
            for e in f:
                size = 1e-12 + sum(abs(float(part.subs(there))) for part in sympy.Add.make_args(sympy.expand(e)))
                self.tally.check(abs(float(e.subs(there))) <= 1e-9 * size, f"{label}: nothing moves", f"{place}: {e.subs(there)}")
            self.tally.check(all(v == 0 for name, v in p["values"].items() if name.startswith("v") or name.endswith("'")), f"{label}: velocities are 0", str(p["values"]))
            if linearize:
                self.linearize(masses, system, p, unit, time, label)
        return places, answer["equilibria"]["complete"]

    def one(self, k, rng):
        masses, one = Masses(rng), {a: 1 for a in (x, w, y, z)}
        all_forms = [("plain", masses.plain(), one, 1), ("disguised", masses.disguised(), one, 1), ("masses", masses.masses(), one, 1), ("first order", *masses.in_units(0, True))]
        most = rng.choice([4, 8, 12])
        all_forms += [(f"units of 1e{most}", *masses.in_units(most, False)), (f"first order, units of 1e{most}", *masses.in_units(most, True))]
        told = [self.form(masses, system, unit, time, f"{k}, {name}", name != "masses") for name, system, unit, time in all_forms]
        for (name, *_), here in zip(all_forms, told):
            for other in told:
                if not here or not other or not here[1]:
                    continue
                missed = [p for p in other[0] if not any(all(abs(i - j) <= 1e-6 * (1e-3 + abs(i)) for i, j in zip(p, q)) for q in here[0])]
                self.tally.check(not missed, f"{k}, {name}: all are found", f"{missed} beside {here[0]}")

    def run(self):
        rng = random.Random(seed(41))
        for k in range(scaled(14)):
            self.one(k, rng)
        self.tally.check(self.linearized >= self.points // 2 > 0, "equilibria were linearized", f"{self.linearized} of {self.points}")
        return self.tally.end()


sys.exit(Check().run())
