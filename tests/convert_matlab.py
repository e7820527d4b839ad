"""MATLAB's symbolic text: by hand, the corpus out and in at random points, refusals by line."""
import random
import warnings

import mpmath

from convert_modelica import corpus, jets, near, parameters_of, values_of
from expression import Syntax, Undefined

# statements, and what the equations' left minus right are
TEXTS = [("syms x(t) y(t) k\ndiff(x, 2) == -k*x^2\ny == diff(x(t), t)*2", lambda e: [e["x''"] + e["k"] * e["x"] ** 2, e["y"] - 2 * e["x'"]]),
         ("syms x(t) y(t)\n[x == -y^2, y - 2*-x == 2^-1*x + x^2^3]", lambda e: [e["x"] + e["y"] ** 2, e["y"] + 2 * e["x"] - e["x"] / 2 - e["x"] ** 6]),
         ("syms x(t) y(t)\nr = sqrt(x^2 + y^2);\nf(t) = 2*r;\neqns = [r == 1 % one\n f + r/2 == y ...\n - 3];", lambda e: [mpmath.hypot(e["x"], e["y"]) - 1, 2.5 * mpmath.hypot(e["x"], e["y"]) - e["y"] + 3]),
         ("[diff(x(t), t, t) == y(t), log10(y(t)) + pi == exp(-x(t))*a]", lambda e: [e["x''"] - e["y"], mpmath.log10(e["y"]) + mpmath.pi - mpmath.exp(-e["x"]) * e["a"]]),
         ("syms x(t) y(t) a\nx.*y./a == nthroot(x, 3) + sym('1/3')*abs(x - y) + sym(2)/3\natan2(x, y) + sec(x) - sign(x - 9) == log2(y)",
          lambda e: [e["x"] * e["y"] / e["a"] - mpmath.cbrt(e["x"]) - abs(e["x"] - e["y"]) / 3 - mpmath.mpf(2) / 3, mpmath.atan2(e["x"], e["y"]) + mpmath.sec(e["x"]) + 1 - mpmath.log(e["y"], 2)])]
REFUSED = [("syms x(t)\nx == q", 2, "q is not declared"), ("syms x(t) y(s)", 1, "others are of t"), ("syms x(t)\nx(t-1) == 2", 2, "no delays"), ("syms x(t)\nx(0) == 1", 2, "no values"), ("syms x(t)\nfor k = 1:3\nend", 2, "programs"),
           ("syms x(t)\nx = 2", 2, "function of time already"), ("syms x(t)\nx(t) < 2", 2, "=="), ("syms x(t)\nx == gamma(x)", 2, "gamma"), ("syms x(t)\nx == 1i", 2, "understood"), ("syms x(t) a\ndiff(x, a) == 1", 2, "by time"),
           ("syms x(t)\nx == (1", 2, ") is missing"), ("syms x(t)\n[x == 1", 2, "] is missing"), ("syms x(t)", None, "no equations"), ("syms x\nx == 2", None, "no function of time"), ("syms x(t)\nx' == 2", 2, "transpose"),
           ("syms x(t,s)", 1, "one variable"), ("syms x(t)\nx == 1 2", 2, "too much"), ("syms x(t)\nx == " + "(" * 100 + "1" + ")" * 100, 2, "nested"), ("syms x(t)\nx == i", 2, "i has no place"), ("", None, "no function")]


def by_hand(tally, matlab, rng):
    for text, true in TEXTS:
        try:
            system = matlab.request(text)["system"]
        except ValueError as x:
            tally.check(False, f"matlab: {text[:50]!r}", str(x))
            continue
        e = {**jets(rng, ["x", "y"]), "k": mpmath.mpf("0.7"), "a": mpmath.mpf("0.6"), "t": mpmath.mpf("0.2")}
        got = values_of(system["equations"], e, True)
        want = true(e)
        tally.check(len(got) == len(want) and all(near(a, b) for a, b in zip(got, want)) and system["variables"] == ["x", "y"], f"matlab: {text[:50]!r}", (system, got, want))
    guide = """clear; clc
syms x(t) y(t) T(t) m r g
eqn1 = m*diff(x(t), 2) == T(t)/r*x(t);
eqn2 = m*diff(y(t), 2) == T(t)/r*y(t) - m*g;
eqn3 = x(t)^2 + y(t)^2 == r^2;
m = 2/4; r = 1; g = 2*m*9.81
eqns = [eqn1 eqn2, eqn3]
"""
    try:
        matlab.request(guide)
    except ValueError as x:
        tally.check("comma" in str(x), "matlab: a list without a comma", str(x))
    guide = guide.replace("eqn1 eqn2", "eqn1, eqn2") + "vars = [y(t); x(t); T(t)];\n[eqns, vars] = reduceDifferentialOrder(eqns, vars);\n[A,b] = massMatrixForm(eqns, vars)\npars = symvar(eqns);\n"
    with warnings.catch_warnings(record=True) as said:
        warnings.simplefilter("always")
        try:
            system = matlab.request(guide.replace("pars = symvar(eqns);\n", ""))["system"]
        except ValueError as x:
            tally.check(False, "matlab: the guide", str(x))
            return
    tally.check(system["variables"] == ["y", "x", "T"] and len(system["equations"]) == 3 and parameters_of(system) == {"m": 0.5, "r": 1, "g": mpmath.mpf("9.81")}, "matlab: the guide", system)
    tally.check(len(said) == 4, "matlab: what is left out", [str(w.message) for w in said])


def refusals(tally, matlab, error):
    for text, line, word in REFUSED:
        try:
            got = matlab.request(text)
        except error as e:
            tally.check(e.line == line and word in str(e), f"matlab: refused {text[:40]!r}", (e.line, str(e)))
        else:
            tally.check(False, f"matlab: refused {text[:40]!r}", got)


def there_and_back(tally, matlab, error, name, request, rng):
    try:
        text = matlab.text(request)
    except error as e:
        return str(e)
    try:
        back = matlab.request(text)["system"]
    except error as e:
        tally.check(False, f"matlab: {name}: is read again", (str(e), text[:1000]))
        return ""
    system = request["system"]
    e = {**jets(rng, system["variables"], 6), system.get("time", "t"): mpmath.mpf(rng.uniform(0, 1))}
    p = {k: mpmath.mpf(rng.uniform(0.5, 1)) for k, v in (system.get("parameters") or {}).items() if v is None}
    p.update(parameters_of({"parameters": system.get("parameters") or {}}))
    try:
        want = values_of(system["equations"], {**e, **p}, True)
    except (Undefined, Syntax, KeyError, ValueError, ZeroDivisionError):
        return "no value"
    env = {back.get("time", "t"): e[system.get("time", "t")]}
    if set(back["variables"]) != set(system["variables"]) or not set(back.get("parameters", {})) <= set(p):
        return "other names"
    env.update({n: v for n, v in e.items()})
    env.update(p)
    again = parameters_of(back)
    tally.check(all(near(again[k], p[k]) for k in again), f"matlab: {name}: parameters", back.get("parameters"))
    got = values_of(back["equations"], env, True)
    tally.check(len(got) == len(want) and all(near(a, b) for a, b in zip(got, want)), f"matlab: {name}: out and in", (text[:800], [(str(a), str(b)) for a, b in zip(got, want)][:3]))
    return ""


def check(tally, solver, rng, count):
    from sga.convert import ConvertError, matlab
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        by_hand(tally, matlab, rng)
        refusals(tally, matlab, ConvertError)
        cases = list(corpus())
        random.Random(3).shuffle(cases)
        left = [there_and_back(tally, matlab, ConvertError, name, request, rng) for name, request in cases[:count]]
    written = sum(not r for r in left)
    tally.check(written > 0.6 * len(left), "matlab: most of the corpus is written", (written, len(left), [r for r in left if r][:10]))
