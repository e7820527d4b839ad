"""SymPy: objects against mpmath's values of the request, the corpus out and in again, refusals."""
import random

import mpmath
import sympy

from convert_modelica import corpus, jets, near, parameters_of, values_of
from expression import Syntax, Undefined

T = sympy.Symbol("t")


def point(rng, system, variables, time):
    """Values by name and, the same, for SymPy: functions and their derivatives."""
    e = {**jets(rng, system["variables"], 6), system.get("time", "t"): mpmath.mpf(rng.uniform(0, 1))}
    by_object = [(sympy.Derivative(f, (time, k)), e[n + "'" * k]) for k in range(6, 0, -1) for n, f in zip(system["variables"], variables)]
    return e, by_object + [(f, e[n]) for n, f in zip(system["variables"], variables)] + [(time, e[system.get("time", "t")])]


def sympy_value(expression, by_object, symbols):
    """By SymPy itself, in 30 digits."""
    dummies = [(o, sympy.Dummy(real=True)) for o, _ in by_object]
    put = expression.doit()
    for o, d in dummies:
        put = put.subs(o, d)
    return mpmath.mpmathify(put.subs(symbols).evalf(30, subs={d: v for (_, d), (_, v) in zip(dummies, by_object)}))


def there_and_back(tally, symbolic, error, name, request, rng):
    try:
        said = symbolic.equations(request)
    except error as e:
        return str(e)
    system = request["system"]
    e, by_object = point(rng, system, said.variables, said.time)
    free = {s: mpmath.mpf(rng.uniform(0.5, 1)) for s, v in said.parameters.items() if v is None}
    p = {**parameters_of({"parameters": system.get("parameters") or {}}), **{s.name: v for s, v in free.items()}}
    symbols = {s: sympy.Float(free[s], 30) if v is None else v for s, v in said.parameters.items()}
    try:
        want = values_of(system["equations"], {**e, **p}, True)
    except (Undefined, Syntax, KeyError, ValueError, ZeroDivisionError):
        return "no value"
    try:
        got = [sympy_value(q.lhs - q.rhs, by_object, symbols) for q in said.equations]
    except Exception as x:
        tally.check(False, f"sympy: {name}: has a value", f"{type(x).__name__}: {x}")
        return ""
    tally.check(all(near(a, b) for a, b in zip(got, want)), f"sympy: {name}: in SymPy", [(str(a), str(b)) for a, b in zip(got, want)][:3])
    try:
        back = symbolic.request(said.equations, said.variables, said.parameters, said.time)["system"]
    except error as x:
        return str(x)
    again = {k: values_of([v], {})[0] for k, v in back.get("parameters", {}).items() if v is not None}
    used = set(back.get("parameters", {}))
    tally.check(all(near(again[k], p[k]) for k in again) and used <= set(p), f"sympy: {name}: parameters", back.get("parameters"))
    got = values_of(back["equations"], {**e, **p}, True)
    tally.check(back["variables"] == list(system["variables"]) and all(near(a, b) for a, b in zip(got, want)), f"sympy: {name}: out and in", (back["equations"][:3], system["equations"][:3]))
    return ""


def by_hand(tally, symbolic, rng):
    """What mechanics' texts look like, held against SymPy's own values."""
    x, y, lam = (sympy.Function(n)(T) for n in ("x", "y", "lambda"))
    g, L, k = sympy.symbols("g L_0 k")
    sets = [[sympy.Eq(x.diff(T, 2), -lam * x), sympy.Eq(y.diff(T, 2), -lam * y - g), x**2 + y**2 - L**2],
            [sympy.Eq(sympy.exp(-x) * sympy.sqrt(2 + y) / k, sympy.Rational(-2, 3) * x**-2 + sympy.log(y, 10)), sympy.atan2(x, 1 + y) - sympy.Max(x, y, k) + sympy.Min(x, 2) - lam, (x * y).diff(T) - sympy.sec(x) * sympy.Abs(y - 2)],
            [sympy.Derivative(x * y, T) + x**sympy.Rational(1, 3) - 0.1 * sympy.pi * y**k - sympy.E ** T, -x / (y * -k) - (-x) ** 3 + sympy.Float("0.25") * -lam, lam - (x - y) - (-(x + y)) * 2 / (3 * k * g)]]
    for i, equations in enumerate(sets):
        system = symbolic.request(equations, [x, y, lam])["system"]
        tally.check(system["variables"] == ["x", "y", "lambda"] and set(system["parameters"]) <= {"g", "L_0", "k"} and all(v is None for v in system["parameters"].values()), f"sympy: set {i}", system)
        e, by_object = point(rng, system, [x, y, lam], T)
        p = {s: mpmath.mpf(rng.uniform(0.5, 1)) for s in (g, L, k)}
        want = [sympy_value(q.lhs - q.rhs if isinstance(q, sympy.Eq) else q, by_object, {s: sympy.Float(v, 30) for s, v in p.items()}) for q in equations]
        got = values_of(system["equations"], {**e, **{s.name: v for s, v in p.items()}}, True)
        tally.check(all(near(a, b) for a, b in zip(got, want)), f"sympy: set {i}: equations", (system["equations"], got, want))
    matrix = symbolic.request(sympy.Eq(sympy.Matrix([x.diff(T), y]), sympy.Matrix([-x, 2 * x])))["system"]
    tally.check(matrix["variables"] == ["x", "y"] and matrix["equations"] == ["x' = -x", "y = 2*x"], "sympy: a matrix", matrix)
    s = sympy.Symbol("s")
    other = symbolic.request([sympy.Function("x")(s).diff(s) - s], parameters={"g": 2}, want=["index"])
    tally.check(other == {"system": {"form": "equations", "variables": ["x"], "equations": ["-s + x' = 0"], "time": "s"}, "want": ["index"]}, "sympy: another time", other)
    valued = symbolic.request([x.diff(T) + g * x * k], parameters={g: "9.81", "k": sympy.Rational(1, 3)})["system"]["parameters"]
    tally.check(valued == {"g": "9.81", "k": "1/3"}, "sympy: values of parameters", valued)
    odd = symbolic.request([sympy.Function("\\theta_1")(T).diff(T) - sympy.Symbol("pi") * sympy.Symbol("a b") - sympy.Function("sin")(T)])["system"]
    tally.check(set(odd["variables"]) == {"theta_1", "sin_"} and set(odd["parameters"]) == {"pi_", "a_b"}, "sympy: names", odd)


def refusals(tally, symbolic, error):
    x, s = sympy.Function("x")(T), sympy.Symbol("s")
    for label, equations, word in (("a function of two", [sympy.Function("u")(T, s) - 1], "different arguments"), ("a piecewise", [x - sympy.Piecewise((1, T > 0), (2, True))], "Piecewise"), ("no equation", [x < 1], "no equation"),
                                   ("another function", [x - sympy.gamma(T)], "gamma"), ("False", [False], "False"), ("True", [sympy.Eq(x, x)], "True"), ("nothing of time", [s - 1], "no function of time"),
                                   ("a complex number", [x - sympy.I], "I"), ("an integral", [x - sympy.Integral(x, T)], "Integral"), ("a delay", [x - sympy.Function("x")(T - 1)], "different arguments"),
                                   ("no number", [x - sympy.nan], "nan"), ("a derivative by another", [x - sympy.Derivative(sympy.Function("u")(T) * s, s, evaluate=False).subs(s, s)], None)):
        try:
            got = symbolic.request(equations)
        except error as e:
            tally.check(word is None or word in str(e), f"sympy: refused: {label}", str(e))
        else:
            tally.check(word is None, f"sympy: refused: {label}", got)
    try:
        symbolic.request([x - sympy.Function("y")(T)], [x])
    except error as e:
        tally.check("y(t)" in str(e), "sympy: a variable that is not named", str(e))
    else:
        tally.check(False, "sympy: a variable that is not named")


def solved(tally, symbolic, solver):
    """A Lagrangian, and equations: the same system twice."""
    x, y, lam = (sympy.Function(n)(T) for n in ("x", "y", "lam"))
    g = sympy.Symbol("g")
    kinetic = (x.diff(T) ** 2 + y.diff(T) ** 2) / 2
    one = symbolic.lagrangian(kinetic - g * y, [x, y], [x**2 + y**2 - 1], parameters={g: "9.81"})
    two = symbolic.request([sympy.Eq(x.diff(T, 2), 2 * lam * x), sympy.Eq(y.diff(T, 2), 2 * lam * y - g), x**2 + y**2 - 1], parameters={g: "9.81"})
    a, b = (solver.solve(r)[0] for r in (one, two))
    tally.check(a and b and a["verdict"] == b["verdict"] == "unique" and a["dimensions"]["final"] == b["dimensions"]["final"] == 2, "sympy: a Lagrangian and its equations", (one, two))


def check(tally, solver, rng, count):
    from sga.convert import ConvertError, symbolic
    by_hand(tally, symbolic, rng)
    refusals(tally, symbolic, ConvertError)
    solved(tally, symbolic, solver)
    cases = [(n, r) for n, r in corpus() if len(str(r["system"])) < 1500]
    random.Random(2).shuffle(cases)
    left = [there_and_back(tally, symbolic, ConvertError, name, request, rng) for name, request in cases[:count]]
    written = sum(not r for r in left)
    tally.check(written > 0.6 * len(left), "sympy: most of the corpus goes out and in", (written, len(left), [r for r in left if r][:10]))
