"""Want `dirac` by other routes: dirac_check.py BUILD_DIR [NAME...]

For every case of tests/cases/dirac.json with an answer:
- the published set, counts, degrees of freedom and orders of derivatives; published brackets on the set;
- Legendre's map by SymPy: the momenta are dL/dv, the primary constraints vanish and H is v dL/dv - L along them, the rank is that of the Hessian;
- at random points of the set (Newton's method of our own, 40 digits): brackets of the first class with all constraints vanish, those of the second class
  are regular; Dirac's bracket by an inverse of our own, and it annihilates the second class; constraints are preserved with the multipliers as given;
- the generator: for any epsilon(t) the change it makes solves the linearized equations for some change of the multipliers, at points of the set;
- whole motions (mpmath's Taylor integration, multipliers that vary) are moved: what is left of the equations and the constraints falls with the
  square of the size of the move.
Spoilt answers must be seen. Random bent coordinates are put into plain systems: the counts stay, and there is a generator.
"""
import copy
import json
import os
import random
import sys

import mpmath
import sympy

import linear
import schemas
from solver import Solver
from tally import ROOT, Tally, build_folder, scaled, seed

T = sympy.Symbol("t")
DIGITS = 40
TINY = mpmath.mpf(10) ** -24


class Wrong(Exception):
    pass


def parse(text, names):
    local = {n: sympy.Symbol(n) for n in names} | {"t": T}
    return sympy.sympify(text.replace("'", "_rate_").replace("^", "**"), locals=local, rational=True)


class Theory:
    """The answer as functions of SymPy."""

    def __init__(self, request, answer):
        self.request, self.a, self.system = request, answer, request["system"]
        self.names = answer["variables"]
        self.n = len(self.names) // 2
        self.parameters = {sympy.Symbol(k): sympy.Rational(str(v)) for k, v in self.system.get("parameters", {}).items()}
        self.x = [sympy.Symbol(n) for n in self.names]
        self.tables = dict(self.table_rates())
        self.H = self.read(answer["hamiltonian"])
        self.primary = [self.read(e) for e in answer["primary"]]
        self.chi = self.primary + [self.read(e["expression"]) for e in answer["secondary"]]
        self.first = [self.read(e["expression"]) for e in answer["first_class"]]
        self.second = [self.read(e) for e in answer["second_class"]]
        self.compiled = {}

    def table_rates(self):
        """A table of four samples or fewer is one polynomial: it and its derivatives, by symbol."""
        for name, table in self.system.get("tables", {}).items():
            u = sympy.interpolate([(sympy.Rational(str(a)), sympy.Rational(str(b))) for a, b in zip(table["times"], table["values"])], T)
            for order in range(10):
                yield sympy.Symbol(name + order * "_rate_"), sympy.diff(u, T, order)

    def given(self, text, names):
        """Numbers for parameters, polynomials for tables."""
        return parse(text, names).subs(self.parameters).subs(self.tables)

    def read(self, text):
        return self.given(text, self.names + self.a["multipliers"]["names"])

    def bracket(self, f, g):
        q, p = self.x[:self.n], self.x[self.n:]
        return sum(sympy.diff(f, a) * sympy.diff(g, b) - sympy.diff(f, b) * sympy.diff(g, a) for a, b in zip(q, p))

    def at(self, e, env):
        if e not in self.compiled:
            free = sorted(sympy.sympify(e).free_symbols, key=str)
            self.compiled[e] = (free, sympy.lambdify(free, e, "mpmath"))
        free, f = self.compiled[e]
        return mpmath.mpf(f(*[env[s] for s in free]))

    def point(self, rng, near):
        """A random point of the set, by Newton's steps of least norm."""
        for _ in range(200):
            env = {s: mpmath.mpf(rng.randint(-999, 999)) / 700 for s in self.x}
            env.update({sympy.Symbol(k): mpmath.mpf(v) + mpmath.mpf(rng.randint(-99, 99)) / 400 for k, v in near.items()})
            env[T] = mpmath.mpf(rng.randint(-999, 999)) / 800
            try:
                for _ in range(60):
                    rows = [[self.at(sympy.diff(c, s), env) for s in self.x] for c in self.chi]
                    values = [self.at(c, env) for c in self.chi]
                    if not values or max(abs(v) for v in values) < mpmath.mpf(10) ** (-DIGITS + 4):
                        return env
                    move = linear.least_norm(rows, [-v for v in values], mpmath.mpf(10) ** -15)
                    if move is None or max(abs(m) for m in move) > 50:
                        break
                    env.update({s: env[s] + m for s, m in zip(self.x, move)})
            except (ZeroDivisionError, TypeError, ValueError):
                continue
        raise Wrong("no point of the set was found")


def near_zero(v, size=1):
    return abs(v) <= TINY * (1 + abs(size))


def legendre(th):
    """The map of the Lagrangian, at random velocities."""
    system, a = th.system, th.a
    if system["form"] != "lagrangian":
        if a["legendre"] is not None:
            raise Wrong("a Hamiltonian has no Legendre map")
        return
    q = system["coordinates"]
    extra = [n for n in th.names[:th.n] if n not in q]
    rates = [sympy.Symbol(n + "_rate_") for n in q]
    L = th.given(system["lagrangian"], q)
    for lam, g in zip(extra, system.get("holonomic", [])):
        L += sympy.Symbol(lam) * th.given(g, q)
    rng = random.Random(7)
    v = rates + [sympy.Symbol(n + "_rate_") for n in extra]
    momenta = [sympy.diff(L, s) for s in v]
    for s, name in zip(momenta, th.names[th.n:]):
        if sympy.simplify(th.given(a["legendre"]["momenta"][name], th.names) - s) != 0:
            raise Wrong(f"{name} is not dL/dv")
    compared = 0
    for _ in range(40):
        env = {s: mpmath.mpf(rng.randint(-999, 999)) / 700 for s in th.x[:th.n]} | {s: mpmath.mpf(rng.randint(-400, 400)) / 1000 for s in v} | {T: mpmath.mpf("0.37")}
        env.update({s: mpmath.mpf(2) + mpmath.mpf(rng.randint(0, 99)) / 100 for s in v if str(s) == "q0_rate_"})
        try:
            env.update({th.x[th.n + i]: th.at(m, env) for i, m in enumerate(momenta)})
            if any(not near_zero(th.at(c, env)) for c in th.primary):
                raise Wrong("a primary constraint does not vanish on the momenta")
            H = sum(env[s] * env[th.x[th.n + i]] for i, s in enumerate(v)) - th.at(L, env)
            if not near_zero(th.at(th.H, env) - H, H):
                raise Wrong("H is not v dL/dv - L")
            W = [[th.at(sympy.diff(m, s), env) for s in v] for m in momenta]
            if linear.rank(W, TINY) != a["legendre"]["rank"] or len(th.primary) != th.n - a["legendre"]["rank"]:
                raise Wrong("the rank is not that of the Hessian")
            compared += 1
        except (TypeError, ZeroDivisionError, ValueError):
            continue
    if not compared:
        raise Wrong("no point to look at Legendre's map")


def multiplier_values(th, env):
    """By primary constraint: given or fixed."""
    out = []
    for name in th.a["multipliers"]["names"]:
        text = th.a["multipliers"]["fixed"].get(name)
        out.append(env[sympy.Symbol(name)] if text is None else th.at(th.read(text), env))
    return out


def classes(th, env):
    chi, m = th.chi, len(th.chi)
    for f in th.first:
        if not near_zero(th.at(f, env)):
            raise Wrong("a constraint of the first class does not vanish on the set")
        if any(not near_zero(th.at(th.bracket(f, c), env)) for c in chi):
            raise Wrong("a constraint of the first class has a bracket that does not vanish")
    delta = [[th.at(th.bracket(a, b), env) for b in th.second] for a in th.second]
    if th.second and linear.rank(delta, TINY) != len(th.second):
        raise Wrong("the brackets of the second class are not regular")
    if len(th.first) + len(th.second) != m or (m and linear.rank([[th.at(th.bracket(a, b), env) for b in chi] for a in chi], TINY) != len(th.second)):
        raise Wrong("the classes are not as many as the rank says")
    rows = [[th.at(sympy.diff(f, s), env) for s in th.x] for f in th.first + th.second]
    if rows and linear.rank(rows, TINY) != m:
        raise Wrong("the classes are not independent")
    if th.a["degrees_of_freedom"] * 2 != 2 * th.n - 2 * len(th.first) - len(th.second):
        raise Wrong("degrees of freedom")
    inverse = mpmath.inverse(mpmath.matrix(delta)).tolist() if delta else []
    grad = [[th.at(th.bracket(x, c), env) for c in th.second] for x in th.x]
    for i, x in enumerate(th.x):
        for k, y in enumerate(th.x):
            plain = (k == i + th.n) - (i == k + th.n)
            if th.a["bracket"][i][k] is None:                       # too long to be written
                continue
            own = plain + sum(grad[i][a] * inverse[a][b] * grad[k][b] for a in range(len(delta)) for b in range(len(delta)))
            if not near_zero(th.at(th.read(th.a["bracket"][i][k]), env) - own, own):
                raise Wrong(f"the bracket of {x} and {y} is not {mpmath.nstr(own, 8)}")
    if None in th.a["multipliers"]["fixed"].values():               # too long, too
        return
    u = multiplier_values(th, env)
    for c in chi:
        parts = [th.at(th.bracket(c, th.H), env), th.at(sympy.diff(c, T), env)] + [w * th.at(th.bracket(c, f), env) for w, f in zip(u, th.primary)]
        if not near_zero(sum(parts), max(abs(x) for x in parts)):
            raise Wrong("a constraint is not preserved with these multipliers")


def total_field(th):
    """x' with the multipliers put in; the free ones are symbols."""
    field = [th.bracket(s, th.H) for s in th.x]
    for name, f in zip(th.a["multipliers"]["names"], th.primary):
        text = th.a["multipliers"]["fixed"].get(name)
        u = sympy.Symbol(name) if text is None else th.read(text)
        field = [v + u * th.bracket(s, f) for v, s in zip(field, th.x)]
    return field


def generator(th, env, rng):
    """dx = sum of epsilon^(k) {x, G_k}: d(dx)/dt - DX dx is made of the primary first class, for any values of the derivatives of epsilon."""
    if th.a["gauge_generator"] is None:
        raise Wrong("there is no generator: " + th.a["no_generator"])
    if len(th.a["gauge_generator"]) != len(th.a["multipliers"]["free"]):
        raise Wrong("there are not as many parameters as free multipliers")
    X = total_field(th)
    free = [th.bracket(s, f) for f in th.primary for s in th.x]
    allowed = [[th.at(free[k * len(th.x) + i], env) for i in range(len(th.x))] for k in range(len(th.primary))]
    moved = []
    for g in th.a["gauge_generator"]:
        order = max(t["derivative"] for t in g["terms"]) + 2
        eps = sympy.symbols(f"epsilon_0:{order + 1}")
        here = env | {e: mpmath.mpf(rng.randint(-999, 999)) / 300 for e in eps}
        change = [sum(eps[t["derivative"]] * th.bracket(s, th.read(t["expression"])) for t in g["terms"]) for s in th.x]
        for s, c in zip(th.x, change):
            told = sum(eps[t["derivative"]] * th.read(t["moves"].get(str(s), "0")) for t in g["terms"])
            if not near_zero(th.at(told - c, here)):
                raise Wrong("moves are not the brackets with the term")
        moved.append([th.at(c, here) for c in change])
        left = []
        for i in range(len(th.x)):
            rate = sum(sympy.diff(change[i], s) * v for s, v in zip(th.x, X)) + sympy.diff(change[i], T) + sum(sympy.diff(change[i], eps[k]) * eps[k + 1] for k in range(order))
            left.append(th.at(rate - sum(sympy.diff(X[i], s) * c for s, c in zip(th.x, change)), here))
        if max(abs(v) for v in left) > TINY * 1e6 and (not allowed or linear.solve([[a[i] for a in allowed] for i in range(len(left))], left, TINY) is None):
            raise Wrong("a motion that is moved by the generator is none")
        if max(abs(v) for v in moved[-1]) <= TINY:
            raise Wrong("the generator moves nothing")
    if moved and linear.rank(moved, TINY) != len(moved):
        raise Wrong("the parameters are not independent")


def move_motion(th, env):
    """A motion with multipliers that vary, moved by h and by h/16: what is left falls with the square."""
    X = total_field(th)
    u = [sympy.Symbol(n) for n in th.a["multipliers"]["free"]]
    wave = {s: sympy.sin(T + k) / 3 + sympy.Rational(1, 5) for k, s in enumerate(u)}
    f = sympy.lambdify([T] + th.x, [e.subs(wave) for e in map(sympy.sympify, X)], "mpmath")
    g = th.a["gauge_generator"][-1]
    eps = sympy.cos(2 * T) + T ** 2 / 3
    change = sympy.lambdify([T] + th.x, [sum(sympy.diff(eps, T, t["derivative"]) * th.bracket(s, th.read(t["expression"])) for t in g["terms"]) for s in th.x], "mpmath")
    drift = sympy.lambdify([T] + th.x, [th.bracket(s, th.H) for s in th.x], "mpmath")
    push = sympy.lambdify([T] + th.x, [[th.bracket(s, c) for s in th.x] for c in th.primary], "mpmath")
    chi = sympy.lambdify([T] + th.x, th.chi, "mpmath")
    with mpmath.workdps(20):
        t0 = mpmath.mpf(env[T])
        motion = mpmath.odefun(lambda t, x: f(t, *x), t0, [env[s] for s in th.x])
        at = t0 + mpmath.mpf("0.21")
        size = []
        for h in (mpmath.mpf("0.01"), mpmath.mpf("0.01") / 16):
            def path(t):
                x = motion(t)
                return [a + h * c for a, c in zip(x, change(t, *x))]
            y = path(at)
            rate = [mpmath.diff(lambda t, i=i: path(t)[i], at, h=mpmath.mpf("1e-6")) for i in range(len(y))]
            left = [r - d for r, d in zip(rate, drift(at, *y))]
            a = push(at, *y)
            gram = [[sum(p * q for p, q in zip(b, c)) for c in a] for b in a]
            w = linear.solve(gram, [sum(p * q for p, q in zip(b, left)) for b in a], mpmath.mpf(10) ** -12)[0]
            rest = [v - sum(k * b[i] for k, b in zip(w, a)) for i, v in enumerate(left)]
            size.append(max([abs(v) for v in rest] + [abs(v) for v in chi(at, *y)]))
        if size[1] > size[0] / 100 + mpmath.mpf("1e-9"):
            raise Wrong(f"a motion that was moved leaves {mpmath.nstr(size[0], 3)} and {mpmath.nstr(size[1], 3)}, which does not fall with the square")


def published(th, expect, rng, near):
    a = th.a
    counts = {"primary": len(a["primary"]), "first": len(a["first_class"]), "second": len(a["second_class"]), "freedom": a["degrees_of_freedom"],
              "idle": sum(not f["generates"] for f in a["first_class"])}
    for k, v in counts.items():
        if v != expect[k]:
            raise Wrong(f"{k} is {v}, not {expect[k]}")
    if a["gauge_generator"] is None:
        raise Wrong("there is no generator: " + a["no_generator"])
    orders = sorted(max(t["derivative"] for t in g["terms"]) for g in a["gauge_generator"])
    if orders != expect["derivatives"]:
        raise Wrong(f"the generator has derivatives {orders}, not {expect['derivatives']}")
    should = [th.read(e) for e in expect["set"]]
    if len(should) != len(th.chi):
        raise Wrong("another number of constraints")
    for _ in range(2):
        env = th.point(rng, near)
        if any(not near_zero(th.at(e, env)) for e in should):
            raise Wrong("the published constraints do not vanish on the set")
        for x, y, value in expect.get("bracket", []):
            got = th.read(a["bracket"][th.names.index(x)][th.names.index(y)])
            if not near_zero(th.at(got - th.read(value), env)):
                raise Wrong(f"the bracket of {x} and {y} is not {value}")
    if "hamiltonian" in expect and sympy.simplify(th.H - th.read(expect["hamiltonian"])) != 0:
        raise Wrong("another Hamiltonian")


def faults(request, answer, expect, moves=True):
    """What is wrong with an answer, or None."""
    rng = random.Random(11)
    near = expect.get("near", {})
    try:
        with mpmath.workdps(DIGITS):
            th = Theory(request, answer)
            published(th, expect, rng, near)
            legendre(th)
            for k in range(2):
                env = th.point(rng, near)
                env.update({sympy.Symbol(n): mpmath.mpf(rng.randint(-999, 999)) / 500 for n in answer["multipliers"]["names"]})
                classes(th, env)
                generator(th, env, rng)
                if k == 0 and moves and answer["gauge_generator"]:
                    move_motion(th, env)
    except Wrong as e:
        return str(e)
    return None


def spoilt(answer):
    """(what, answer) with one thing wrong in each."""
    def change(what, f):
        a = copy.deepcopy(answer)
        f(a)
        return what, a
    if answer["bracket"]:
        yield change("bracket", lambda a: a["bracket"][0].__setitem__(1, f"({a['bracket'][0][1]}) + 1/7"))
    if answer["first_class"]:
        yield change("class", lambda a: a["second_class"].append(a["first_class"].pop()["expression"]))
        if answer["gauge_generator"][0]["terms"][0]["moves"]:
            yield change("moves", lambda a: a["gauge_generator"][0]["terms"][0].update(expression=f"3*({a['gauge_generator'][0]['terms'][0]['expression']}) + {a['variables'][0]}"))
    if answer["multipliers"]["fixed"]:
        name = next(iter(answer["multipliers"]["fixed"]))
        yield change("multiplier", lambda a: a["multipliers"]["fixed"].update({name: f"({a['multipliers']['fixed'][name]}) + 1/3"}))
    if answer["legendre"]:
        yield change("hamiltonian", lambda a: a.update(hamiltonian=f"({a['hamiltonian']}) + {a['variables'][0]}/5"))
    yield change("freedom", lambda a: a.update(degrees_of_freedom=a["degrees_of_freedom"] + 1))


# Systems whose theory is plain: D0 is the rate of z0.
PLAIN = ("(D0 - z1)^2/2", "(D0 - z1)^2/2 + D2^2/2 - z2^2/2", "(D0 - z1)^2/2 + (D1 - z2)^2/2", "D0*z1 - z1^2/2 - z0^2/2", "D0^2/2 + z1*(D0 - z2)", "D0^2/2 - z0*z1",
         "(D0 - z2)^2/2 + (D1 - z2)^2/2", "(D0 + D1)^2/2 - (z0 + z1)^2", "(D0 - z1)^2/2 + (D2 - z1)^2/2", "(D0 - z2)^2/2 + (D1 - z3)^2/2", "D0*z1*z2")


def bent(rng, plain):
    """The same Lagrangian in coordinates that polynomials bend, as a request; and the plain one."""
    n = max(int(c) for c in "0123" if "z" + c in plain or "D" + c in plain) + 1
    names = "abcd"[:n]
    x = sympy.symbols(list(names))
    v = sympy.symbols([a + "_v" for a in names])
    z = list(x)
    for _ in range(rng.randint(1, 2)):
        i = rng.randrange(n)
        k = rng.choice([j for j in range(n) if j != i])
        image = dict(zip(x, x)) | {x[i]: rng.choice([1, 2, -1]) * x[i] + rng.choice([1, -1, 2]) * rng.choice([x[k] ** 2, x[k] ** 3 / 3, x[k] * (1 + x[k])])}
        z = [e.subs(image, simultaneous=True) for e in z]
    put = {sympy.Symbol(f"z{i}"): e for i, e in enumerate(z)} | {sympy.Symbol(f"D{i}"): sum(sympy.diff(e, a) * b for a, b in zip(x, v)) for i, e in enumerate(z)}
    text = str(sympy.sympify(plain.replace("^", "**"), rational=True).subs(put, simultaneous=True)).replace("**", "^").replace("_v", "'")
    for i in range(4):
        plain = plain.replace(f"D{i}", f"z{i}'")
    return [{"system": {"form": "lagrangian", "coordinates": c, "lagrangian": L}, "want": ["dirac"]} for c, L in ((list(names), text), ([f"z{i}" for i in range(n)], plain))]


def counted(a):
    orders = a["gauge_generator"] and sorted(max(t["derivative"] for t in g["terms"]) for g in a["gauge_generator"])
    return len(a["primary"]), len(a["secondary"]), len(a["first_class"]), len(a["second_class"]), a["degrees_of_freedom"], orders


def draw_bent(tally, solver, k, rng):
    (request, plain) = bent(rng, rng.choice(PLAIN))
    label = f"bent {k}: {request['system']['lagrangian']}"
    (result, problem), (flat, _) = solver.solve(request), solver.solve(plain)
    if not tally.check(result is not None, label, str(problem)):
        return
    a = result["dirac"]
    tally.check(counted(a) == counted(flat["dirac"]), label, f"{counted(a)}, {counted(flat['dirac'])} in plain coordinates; {a.get('no_generator')}")
    try:
        with mpmath.workdps(DIGITS):
            th = Theory(request, a)
            legendre(th)
            env = th.point(rng, {})
            env.update({sympy.Symbol(n): mpmath.mpf(rng.randint(-999, 999)) / 500 for n in a["multipliers"]["names"]})
            classes(th, env)
            generator(th, env, rng)
    except Wrong as e:
        tally.check(False, label, str(e))


def main():
    tally, solver, schema = Tally("dirac"), Solver(build_folder(), number=float), schemas.validator("result")
    rng = random.Random(seed(1))
    with open(os.path.join(ROOT, "tests", "cases", "dirac.json"), encoding="utf-8") as f:
        cases = [c for c in json.load(f) if "dirac" in c["expect"] and (not sys.argv[2:] or any(p in c["name"] for p in sys.argv[2:]))]
    cases = cases[::int(os.environ.get("SGA_TEST_EVERY", "1"))]
    seen = set()
    for case in cases:
        name, expect = case["name"], case["expect"]["dirac"]
        result, problem = solver.solve(case["request"])
        if not tally.check(result is not None, name, str(problem)):
            continue
        fault = schemas.faults(schema, result)
        tally.check(not fault, f"{name}: schema", fault)
        found = faults(case["request"], result["dirac"], expect)
        tally.check(found is None, name, found)
        if found is None and len(result["dirac"]["variables"]) <= 8:
            for what, bad in spoilt(result["dirac"]):
                if what not in seen or len(seen) < 6:
                    tally.check(faults(case["request"], bad, expect, False) is not None, f"{name}: a spoilt {what}", "is not seen")
                    seen.add(what)
    for k in range(0 if sys.argv[2:] else scaled(12)):
        draw_bent(tally, solver, k, rng)
    if not sys.argv[2:]:
        tally.check(len(seen) == 6 or "SGA_TEST_EVERY" in os.environ, "spoilt answers", f"{sorted(seen)}")
    return tally.end()


if __name__ == "__main__":
    sys.exit(main())
