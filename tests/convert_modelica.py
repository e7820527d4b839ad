"""Modelica: texts against formulas by hand, the corpus out and in again at random points, motions, refusals by line."""
import glob
import json
import os
import random
import warnings

import mpmath

from expression import Arithmetic, Graph, Syntax, Undefined
from tally import ROOT


def values_of(texts, env, equations=False):
    graph, number = Graph(), Arithmetic(mpmath.mp)
    roots = [graph.equation(t) if equations and "=" in t else graph.parse(t) for t in texts]
    value = graph.values(graph.cone(roots), env, number)
    return [value[r] for r in roots]


def parameters_of(system):
    return {k: values_of([str(v)], {})[0] for k, v in system.get("parameters", {}).items() if v is not None}


def jets(rng, names, orders=4):
    return {n + "'" * k: mpmath.mpf(rng.uniform(0.2, 1)) for n in names for k in range(orders + 1)}


def near(a, b, size=1):
    return abs(a - b) <= 1e-12 * (size + abs(a) + abs(b))


def crane(tally, modelica, rng):
    with open(os.path.join(ROOT, "etc", "examples", "crane.mo"), encoding="utf-8") as f:
        request = modelica.request(f.read())
    system = request["system"]
    e = jets(rng, system["variables"])
    p = parameters_of(system)
    tally.check(p == {"M": 2, "m": 0.5, "L": 1.5, "g": mpmath.mpf("9.81")}, "modelica: parameters", p)
    s, v, x, y, u, w, lam, force = (e[n] for n in ("s", "v", "x", "y", "u", "w", "lambda", "F"))
    true = [e["s'"] - v, 2 * e["v'"] - force - lam * (x - s), e["x'"] - u, e["y'"] - w, e["u'"] / 2 + lam * (x - s), e["w'"] / 2 + lam * y + p["g"] / 2, (x - s) ** 2 + y ** 2 - 2.25, force]
    got = values_of(system["equations"], {**e, **p, "time": mpmath.mpf(0)}, True)
    tally.check(len(got) == len(true) and all(near(a, b) for a, b in zip(got, true)), "modelica: equations", got)
    tally.check(request["trajectory"] == {"start": "0", "stop": "3", "samples": 31, "initial": {"s": "0", "x": "0.5", "y": "-1.4"}, "hold": ["s"]}, "modelica: the experiment", request["trajectory"])


# a model's declarations and equations, and what an equation's left minus right is
FORMULAS = [("Real a, b;", "a = -b^2", lambda e: e["a"] + e["b"] ** 2), ("Real a, b;", "a = 2*-b", lambda e: e["a"] + 2 * e["b"]), ("Real a, b;", "a = (-b)^2*3", lambda e: e["a"] - 3 * e["b"] ** 2),
            ("Real a, b;", "a/b/2 = b - (a - b)", lambda e: e["a"] / e["b"] / 2 - e["b"] + e["a"] - e["b"]), ("Real a, b;", "a = -b*2 + a", lambda e: 2 * e["b"]),
            ("Real a, b;", "a = log10(b)", lambda e: e["a"] - mpmath.log10(e["b"])), ("Real a, b;", "der(a) = noEvent(abs(b))", lambda e: e["a'"] - abs(e["b"])),
            ("Real a, b;", "a = smooth(1, b) + homotopy(actual = a, simplified = 0)", lambda e: -e["b"]), ("Real a, b;", "a = Modelica.Math.sin(time)*Modelica.Constants.pi", lambda e: e["a"] - mpmath.sin(e["time"]) * mpmath.pi),
            ("Real a, b;", "a = atan2(b, 2) + min(a, b) - max(1, b)", lambda e: e["a"] - mpmath.atan2(e["b"], 2) - min(e["a"], e["b"]) + max(1, e["b"])),
            ("Real a, b;", "a = b^(1/2)*exp(-b)", lambda e: e["a"] - mpmath.sqrt(e["b"]) * mpmath.exp(-e["b"])), ("Real a, b;", "der(a*b) = 1.5e-3 + 2e1", lambda e: e["a'"] * e["b"] + e["a"] * e["b'"] - mpmath.mpf("20.0015"))]


def formulas(tally, modelica, rng):
    for declared, equation, true in FORMULAS:
        text = f"model A\n {declared}\nequation\n {equation};\nend A;\n"
        try:
            system = modelica.request(text)["system"]
        except ValueError as e:
            tally.check(true is None, f"modelica: {equation}", e)
            continue
        if "der(a*b)" in equation:        # the request's own matter
            tally.check(system["equations"] == ["der(a*b) = 1.5e-3 + 2e1"], f"modelica: {equation}", system)
            continue
        e = {**jets(rng, ["a", "b"]), "time": mpmath.mpf("0.3")}
        got = values_of(system["equations"], e, True)[0]
        tally.check(true is not None and near(got, true(e)), f"modelica: {equation}", (got, system["equations"]))


def names(tally, modelica):
    text = """model 'odd names'
      Real R1.i(start = 1), x[1], x[2], x_1, 'a b' "text" , pi, cbrt;
      parameter Real p.q = 2*k, k = 1/3, free;
    protected
      SI.Voltage u "one", w = 3;
    equation
      R1.i = x[1] + x[2] + x_1 + 'a b' + p.q; der(x[1]) = pi; der(x[2]) = cbrt; x_1 = free; 'a b' = u "said" annotation(Line(points = {{0, 0}, {1, 1}}));
      u = 2; pi = 4; cbrt = 5;
    end 'odd names';"""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        system = modelica.request(text)["system"]
    tally.check(system["variables"] == ["R1_i", "x_1", "x_2", "x_1_", "a_b", "pi_", "cbrt_", "u", "w"] and system["parameters"] == {"p_q": "2*(1/3)", "k": "1/3", "free": None}
                and system["equations"][0] == "R1_i = x_1 + x_2 + x_1_ + a_b + p_q" and system["equations"][-1] == "w = 3" and system["name"] == "odd names", "modelica: names", system)


# text, line, a word
REFUSED = [("model A\n Real x;\nequation\n when x > 1 then\n end when;\nend A;", 4, "when"), ("model A\n Real x;\nequation\n x = y;\nend A;", 4, "y is not declared"),
           ("model A\n Real x;\nequation\n x = if x > 1 then 2 else 3;\nend A;", 4, "if expression"), ("model A\n Boolean b;\nend A;", 2, "Boolean"), ("model A\n Resistor R;\nend A;", 2, "Resistor"),
           ("model A\n Real x\nequation\n x = 1;\nend A;", 3, "; is missing"), ("model A\n Real x, x;\nend A;", 2, "twice"), ("model A\n Real x[n];\nend A;", 2, "write arrays out"),
           ("model A\n Real x;\nequation\n x = foo(2);\nend A;", 4, "foo"), ("model A\n Real x;\nalgorithm\n x := 1;\nend A;", 3, "algorithm"), ("model A\n Real x;\nequation\n connect(x, x);\nend A;", 4, "connections"),
           ("model A\n parameter Real a = b, b = a;\n Real x;\nequation\n x = a;\nend A;", 2, "itself"), ("model A\n parameter Real a = x;\n Real x;\nequation\n x = a;\nend A;", 2, "a variable"),
           ("function f\nend f;", 1, "function"), ("model A\n Real x;\nequation\n x = (1;\nend A;", 4, ") is missing"), ("model A\n Real x;\nequation\n x = 1 ? 2;\nend A;", 4, "'?'"),
           ("model A\n Real x;\nequation\n x = 1;\n", 5, "`end` is missing"), ("model A\n Real x;\ninitial equation\n x^2 = 1;\nequation\n x = 1;\nend A;", 4, "initial"),
           ("model A\n discrete Real x;\nend A;", 2, "discrete"), ("model A\n Real x;\nequation\n x = " + "(" * 100 + "1" + ")" * 100 + ";\nend A;", 4, "nested"), ("model A\nend A;", None, "no variables"),
           ("model A\n Real x;\nequation\n x = sin(1, 2);\nend A;", 4, "1 argument"), ("", 1, "begins with"), ("model A\n Real x(start = 2*y), y;\nequation\n x = 1; y = 2;\n annotation(experiment(StopTime = 1));\nend A;", None, "start of x")]


def refusals(tally, modelica, error):
    for text, line, word in REFUSED:
        try:
            got = modelica.request(text)
        except error as e:
            tally.check(e.line == line and word in str(e), f"modelica: refused {text[8:60]!r}", (e.line, str(e)))
        else:
            tally.check(False, f"modelica: refused {text[8:60]!r}", got)
    for request, word in (({"system": {"form": "linear", "variables": ["x"]}}, "linear"), ({"system": {"form": "equations", "variables": ["x"], "equations": ["x = u"], "tables": {"u": {}}}}, "tables"),
                          ({"system": {"form": "equations", "variables": ["x"], "equations": ["x = q"]}}, "q is"), ({"system": {"form": "equations", "variables": ["x"], "equations": ["x = 1 +"]}}, "missing")):
        try:
            got = modelica.model(request)
        except error as e:
            tally.check(word in str(e), f"modelica: not written: {word}", str(e))
        else:
            tally.check(False, f"modelica: not written: {word}", got)


def corpus():
    """Requests of the form equations, by name."""
    for path in sorted(glob.glob(os.path.join(ROOT, "tests", "cases", "*.json"))):
        with open(path, encoding="utf-8") as f:
            for case in json.load(f):
                system = case.get("request", {}).get("system", {}) if isinstance(case.get("request"), dict) else {}
                if system.get("form") == "equations" and isinstance(system.get("variables"), list) and isinstance(system.get("equations"), list) and "error" not in case.get("expect", {}):
                    yield case["name"], case["request"]


def there_and_back(tally, modelica, error, name, request, rng):
    """The model read again has the same residuals, and the equations of its own variables hold. Whether it could be written."""
    try:
        text = modelica.model(request)
    except error as e:
        return str(e)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        try:
            again = modelica.request(text)
        except error as e:
            tally.check(False, f"modelica: {name}: is read again", (str(e), text[:1500]))
            return ""
    system, back = request["system"], again["system"]
    own = len(back["equations"]) - len(system["equations"])
    e = {**jets(rng, system["variables"], 6), system.get("time", "t"): mpmath.mpf(rng.uniform(0, 1))}
    p = {**{k: mpmath.mpf(rng.uniform(0.5, 1)) for k, v in (system.get("parameters") or {}).items() if v is None}}
    p.update(parameters_of({"parameters": system.get("parameters") or {}}))
    there = dict(zip(back.get("parameters", {}), (p[k] for k in system.get("parameters") or {})))
    for k, v in parameters_of(back).items():
        tally.check(near(v, there[k]), f"modelica: {name}: the parameter {k}", v)
    env = {back["time"]: e[system.get("time", "t")], **there}
    extra = [n for n in back["variables"][len(system["variables"]):]]
    for mine, theirs in zip(system["variables"], back["variables"]):
        env.update({theirs + "'" * k: e[mine + "'" * k] for k in range(7)})
    for left, made in (q.split(" = ") for q in back["equations"][:own]):      # der(above) = made
        above = left[4:-1]
        env.update({made + "'" * k: env[above + "'" * (k + 1)] for k in range(6) if above + "'" * (k + 1) in env})
        if made not in extra:
            tally.check(False, f"modelica: {name}: variables of its own", made)
            return ""
    try:
        want = values_of(system["equations"], {**e, **p}, True)
    except (Undefined, Syntax, KeyError, ValueError, ZeroDivisionError):
        return "no value"
    try:
        got = values_of(back["equations"], env, True)
    except Exception as x:
        tally.check(False, f"modelica: {name}: has a value", f"{type(x).__name__}: {x}: {text[:1500]}")
        return ""
    tally.check(all(near(v, 0) for v in got[:own]) and len(got) == own + len(want) and all(near(a, b) for a, b in zip(got[own:], want)), f"modelica: {name}: out and in",
                ([(str(a), str(b)) for a, b in zip(got[own:], want)][:3], text[:1500]))
    return ""


def motions(tally, modelica, solver):
    """The same motion, out and in again."""
    request = {"system": {"form": "equations", "variables": ["x", "y", "lam"], "parameters": {"g": "9.81"}, "equations": ["x'' = -lam*x", "y'' = -lam*y - g", "x^2 + y^2 = 1"]},
               "trajectory": {"stop": 2, "samples": 9, "initial": {"x": "0.6", "y": "-0.8", "x'": 0.5}, "hold": ["x"]}}
    again = modelica.request(modelica.model(request, "Pendulum"))
    first, second = (solver.solve(r) for r in (request, again))
    if not tally.check(first[0] is not None and second[0] is not None, "modelica: solved", (first[1], second[1])):
        return
    a, b = first[0]["trajectory"], second[0]["trajectory"]
    columns = [(a["columns"].index(n), b["columns"].index(m)) for n, m in (("x", "x"), ("y", "y"), ("lam", "lam"), ("x'", "x_d1"), ("y'", "y_d1"))]
    worst = max(abs(p[i] - q[j]) for p, q in zip(a["rows"], b["rows"]) for i, j in columns)
    tally.check(len(a["rows"]) == len(b["rows"]) == 9 and worst < 1e-6, "modelica: the same motion", worst)


def check(tally, solver, rng, count):
    from sga.convert import ConvertError, modelica
    crane(tally, modelica, rng)
    formulas(tally, modelica, rng)
    names(tally, modelica)
    refusals(tally, modelica, ConvertError)
    motions(tally, modelica, solver)
    cases = list(corpus())
    random.Random(1).shuffle(cases)
    left = [there_and_back(tally, modelica, ConvertError, name, request, rng) for name, request in cases[:count]]
    written = sum(not r for r in left)
    tally.check(written > 0.6 * len(left), "modelica: most of the corpus is written", (written, len(left), [r for r in left if r][:10]))
