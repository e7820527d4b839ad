"""The checkers themselves: a right answer must pass, a spoilt one must not. self_check.py BUILD_DIR

The answers are made by the SymPy reduction, so nothing of the C code runs here.
"""
import copy
import glob
import os
import random
import re
import subprocess
import sys
from fractions import Fraction

import mpmath
import sympy as sp

import cases
import linear
import linear_oracle
import sympy_check
from combination import Combinations
from expression import EXACT, FLOAT, Graph, Syntax, Undefined, evaluate
from identities import Answer, Broken
from tally import ROOT, Tally

# By hand, for SymPy's way leads over a square root.
PENDULUM = {"constraints": ["x^2 + y^2 - 4", "x*u + y*v", "u^2 + v^2 - 10*y - 4*lambda"],
            "field": ["u", "v", "-lambda*x", "-lambda*y - 10", "-15*v/2"]}
CHOSEN = [("arm numeric", sp.cancel), ("pendulum first order", sp.simplify), ("Gear Petzold 2", sp.cancel),
          ("2x2 option 2b(i) coincident", sp.cancel), ("restrict and compatibility", sp.cancel),
          ("product of velocities", sp.simplify)]
VALUES = [("-x^2", -4), ("2^-3", .125), ("2^3^2", 512), ("-2^-2", -.25), ("x*-3", -6), ("6/2/3", 1), ("1-2-3", -4),
          ("min(3, x, 1)", 1), ("max(3, x)", 3), ("1.5e-3", .0015), ("der(y, 2) + der(y)", 30), ("y''", 20), ("cbrt(-8)", -2),
          ("atan2(1, 1)*4 - pi", 0), ("x**2", 4), ("(1 + x)*(2 - x)/-3", 0), ("2*-x^2", -8), ("abs(-x)/sign(-x)", -2),
          ("+x - -x", 4), ("2^-x^2", 1 / 16)]


def text(e):
    return str(e).replace("**", "^")


def made(case, simplify):
    """A result in the schema's shape from SymPy's answer, or by hand."""
    if case["name"] == "pendulum first order":
        names = case["request"]["system"]["variables"]
        return {"verdict": "unique", "variables": [{"name": n, "role": "variable"} for n in names],
                "dimensions": {"ambient": 5, "generations": [4, 3, 2], "final": 2},
                "index": {"generations": 3, "differentiation": 3, "seed": 2},
                "constraints": [{"generation": k, "expression": e} for k, e in enumerate(PENDULUM["constraints"], 1)],
                "vector_field": {"components": dict(zip(names, PENDULUM["field"])), "free": []},
                "gauge": {"dimension": 0, "fields": []}}
    other, symbols = sympy_check.reduce(case["request"], case["expect"].get("variables"), simplify)
    from problem import Problem
    names = Problem(case["request"], case["expect"].get("variables")).names
    dims = other["generations"]
    free = [f"f{k + 1}" for k in range(len(other["gauge"]))]
    return {"verdict": other["verdict"], "variables": [{"name": n, "role": "variable"} for n in names],
            "dimensions": {"ambient": len(names), "generations": dims, "final": other["final"]},
            "index": {"generations": len(dims), "differentiation": None, "seed": max(0, len(dims) - 1)},
            "constraints": [{"generation": k, "expression": text(e)} for k, e in other["manifold"].constraints],
            "vector_field": {"components": {n: text(e) for n, e in zip(names, other["X"])}, "free": free},
            "gauge": {"dimension": len(free), "fields": [{n: text(z[i]) for i, n in enumerate(names)} for z in other["gauge"]]}}


def spoilt(result):
    """Wrong variants, each with what is wrong."""
    def variant(change):
        r = copy.deepcopy(result)
        change(r)
        return r

    def drop(r):
        r["constraints"].pop()
        r["dimensions"]["generations"] = r["dimensions"]["generations"][:-1]
        r["dimensions"]["final"] = (r["dimensions"]["generations"] or [r["dimensions"]["ambient"]])[-1]
        r["index"]["generations"] -= 1
        r["index"]["seed"] = max(0, r["index"]["generations"] - 1)

    def surplus(r):
        if r["dimensions"]["final"] == 0:
            r["constraints"][0]["expression"] += " + 1/3"
            return
        name = r["variables"][0]["name"]
        r["constraints"].append({"generation": len(r["dimensions"]["generations"]) + 1, "expression": f"{name} - 1/3"})
        r["dimensions"]["final"] -= 1
        r["dimensions"]["generations"].append(r["dimensions"]["final"])
        r["index"]["generations"] += 1
        r["index"]["seed"] += 1

    def component(r):
        c = r["vector_field"]["components"]
        name = list(c)[0]
        c[name] = f"({c[name]}) + 1/1000000"

    def shifted(r):
        c = r["constraints"][-1]
        c["expression"] = f"({c['expression']}) + 1/1000"

    yield "a constraint is missing", variant(drop)
    yield "a constraint too many", variant(surplus)
    yield "a component is wrong", variant(component)
    yield "a constraint is shifted", variant(shifted)
    if result["gauge"]["fields"]:
        def no_gauge(r):
            r["gauge"] = {"dimension": 0, "fields": []}
            r["vector_field"]["free"] = []
            r["verdict"] = "unique"

        def bent(r):
            z = r["gauge"]["fields"][0]
            name = [n for n in z if z[n] == "0"][0]
            z[name] = "1/7"
        yield "the gauge field is left out", variant(no_gauge)
        yield "the gauge field is wrong", variant(bent)


def check_identities(tally):
    wanted = dict(CHOSEN)
    for case in cases.load([]):
        if case["name"] not in wanted:
            continue
        good = made(case, wanted.pop(case["name"]))
        try:
            Answer(case["request"], good).check()
            tally.check(True, case["name"])
        except Broken as e:
            tally.check(False, f"{case['name']}: a right answer passes", str(e))
        for what, bad in spoilt(good):
            try:
                Answer(case["request"], bad).check()
                tally.check(False, f"{case['name']}: {what}: is found")
            except (Broken, Undefined):
                tally.check(True, what)
    tally.check(not wanted, "chosen cases exist", str(wanted))


# x1' = 0, x2' = x4, 0 = x1 + x3, 0 = x2 + 2 x3: then x4 = 0 from the second tangency minus twice the first.
COMBINED = {"system": {"form": "quasilinear", "variables": ["x1", "x2", "x3", "x4"],
                       "A": [[1, 0, 0, 0], [0, 1, 0, 0], [0, 0, 0, 0], [0, 0, 0, 0]], "alpha": ["0", "x4", "x1 + x3", "x2 + 2*x3"]}}


def combined(third="-2", row="row 2", contradiction=None, tangency=1, first="-1"):
    names = COMBINED["system"]["variables"]
    parts = [[{"equation": row, "factor": first}], [{"equation": "row 3", "factor": "-1"}],
             [{"tangency_of": 1, "factor": "1"}, {"tangency_of": 0, "factor": third}]]
    evidence = {"constraints": [{"generation": g, "from": "combination", "combination": p} for g, p in zip((1, 1, 2), parts)]}
    if contradiction:
        evidence["contradiction"] = {"expression": contradiction, "combination": [{"tangency_of": 1, "factor": "1"}, {"tangency_of": tangency, "factor": "-2"}]}
        evidence["constraints"].pop()
    expressions = ["x1 + x3", "x2 + 2*x3", "x4"][:len(evidence["constraints"])]
    return {"verdict": "inconsistent" if contradiction else "unique", "variables": [{"name": n, "role": "variable"} for n in names],
            "constraints": [{"generation": g, "expression": e} for g, e in zip((1, 1, 2), expressions)], "evidence": evidence}


def check_combinations(tally):
    against = {"system": {**COMBINED["system"], "alpha": ["0", "1", "x1 + x3", "x2 + 2*x3"]}}
    trials = [("right", COMBINED, combined(), True), ("a wrong factor", COMBINED, combined(third="-3"), False),
              ("a multiple", COMBINED, combined(first="-2"), False), ("the other sign", COMBINED, combined(first="1"), False),
              ("a factor with a variable", COMBINED, combined(third="-2 + x1"), False), ("a wrong equation", COMBINED, combined(row="row 1"), False),
              ("another constraint's equation", COMBINED, combined(row="row 3"), False),
              ("a right contradiction", against, combined(contradiction="1", tangency=0), True),
              ("a contradiction that vanishes", against, combined(contradiction="x1 + x3", tangency=0), False),
              ("a contradiction from nothing", COMBINED, combined(contradiction="1", tangency=1), False)]
    for what, request, result, right in trials:
        done, wrong = Combinations(Answer(request, result)).check()
        tally.check(done == len(result["evidence"]["constraints"]) + ("contradiction" in result["evidence"]), f"{what}: all are looked at")
        tally.check(right == (not wrong), f"combinations: {what}", str(wrong))


def check_expressions(tally):
    env = {"x": 2, "y'": 10, "y''": 20}
    for t, value in VALUES:
        for number, kind in ((EXACT, mpmath.mpf), (FLOAT, float)):
            got = evaluate(t, {k: kind(v) for k, v in env.items()}, number)
            tally.check(abs(got - value) < 1e-12, t, f"{got}, should be {value}")
    for t in ("1 +", "(x", "x)", "1 2", "sin()", "x $ y", "* x", "sin x"):
        try:
            Graph().parse(t)
            tally.check(False, f"{t} is refused")
        except Syntax:
            tally.check(True, t)
    for t in ("1/(x - 2)", "log(-x)", "sqrt(-x)", "acos(x)", "(-x)^(1/2)"):
        try:
            evaluate(t, {"x": mpmath.mpf(2)})
            tally.check(False, f"{t} has no value")
        except Undefined:
            tally.check(True, t)
    for f in ("sin cos tan asin acos atan sinh cosh tanh asinh acosh atanh exp log sqrt cbrt abs").split():
        g = Graph()
        e = g.parse(f"x*{f}(x*y + c)^2/y")
        cone = g.cone([e])
        point = {"x": mpmath.mpf("0.7"), "y": mpmath.mpf("0.9"), "c": mpmath.mpf(1 if f == "acosh" else 0)}
        with mpmath.workdps(40):
            slope = g.gradient(e, g.values(cone, point, EXACT), EXACT)
            h = mpmath.mpf(10) ** -13
            for n in "xy":
                side = [g.values(cone, {**point, n: point[n] + s * h}, EXACT)[e] for s in (1, -1)]
                tally.check(abs((side[0] - side[1]) / (2 * h) - slope[n]) < 1e-12, f"derivative of {f}")


def check_linear(tally):
    rng = random.Random(7)
    for _ in range(20):
        m, n = rng.randint(1, 4), rng.randint(1, 4)
        rows = [[Fraction(rng.randint(-2, 2)) for _ in range(n)] for _ in range(m)]
        rank = sp.Matrix(rows).rank()
        tally.check(linear.rank(rows) == rank, "exact rank")
        tally.check(len(linear.left_kernel(rows)) == m - rank, "left kernel")
        floats = [[mpmath.mpf(int(a)) for a in r] for r in rows]
        tally.check(linear.rank(floats, mpmath.mpf(10) ** -10) == rank, "numeric rank")
        x = [Fraction(rng.randint(-3, 3)) for _ in range(n)]
        b = [sum(a * c for a, c in zip(r, x)) for r in rows]
        y = linear.least_norm(rows, b)
        tally.check([sum(a * c for a, c in zip(r, y)) for r in rows] == b, "solution")
        tally.check(sum(a * a for a in y) <= sum(a * a for a in x), "least norm")
    options = [((1, 2, 3, 4, 5, 6), "unique"), ((1, 2, 3, 0, 0, 0), "underdetermined"), ((1, 2, 3, 0, 0, 1), "inconsistent"),
               ((1, 0, 3, 2, 0, 1), "inconsistent"), ((2, 0, 3, 4, 0, 6), "underdetermined"), ((1, 2, 3, 4, 0, 5), "isolated")]
    for (a11, a12, u1, a21, a22, u2), verdict in options:
        got = linear_oracle.reduce([[1, 0], [0, 0]], [[a11, a12], [a21, a22]], [u1, u2])
        tally.check(got["verdict"] == verdict, "the options of the 2x2 system", str(got))


# What cuts a search, a list or a number of tries is called so.
CUTS = set("MOST MAX LIMIT TRIES ROUNDS DEPTH ATTEMPTS STARTS DRAWS PASSES SWEEPS LARGEST LONGEST FAILURES RESEEDS WAYS TERMS DEGREE PARTS "
           "BYTES MEGABYTES CONE VISITS CANDIDATES DIRECTIONS WORK DEEPER PIECES".split())
NUMBER = re.compile(r"(?:#define\s+([A-Z][A-Z0-9_]*)\s+|\b([A-Z][A-Z0-9_]*)\s*=\s*)[-(]*[0-9]")


def looks_like_cap(name):
    words = set(name.split("_"))
    return words & CUTS or (name.endswith("_BITS") and words & {"MOST", "MAX", "WORK"})


def numbers_of(lib):
    """Constants that look like caps and are numbers: {file: names}."""
    found = {}
    for folder, _, files in os.walk(lib):
        for name in files:
            if name.endswith((".c", ".h")):
                path = os.path.join(folder, name)
                with open(path, encoding="utf-8") as f:
                    text = re.sub(r"/\*.*?\*/", "", f.read(), flags=re.S)
                names = {a or b for a, b in NUMBER.findall(text) if looks_like_cap(a or b)}
                if names:
                    found["lib/" + os.path.relpath(path, lib)] = names
    return found


def not_caps(path):
    """The list beside this test: {file: {name: why}}."""
    said = {}
    with open(path, encoding="utf-8") as f:
        for line in f:
            if line.strip() and not line.startswith("#"):
                what, _, why = line.partition("|")
                file, *names = what.split()
                for name in names:
                    said.setdefault(file, {})[name] = why.strip()
    return said


def check_caps(tally):
    """No silent caps: a constant that cuts something stands in limits.def and raises its warning, or is listed with a reason."""
    here = os.path.dirname(os.path.abspath(__file__))
    lib = os.path.join(os.path.dirname(here), "lib")
    found, said = numbers_of(lib), not_caps(os.path.join(here, "not_caps.txt"))
    for file, names in sorted(found.items()):
        for name in sorted(names):
            tally.check(said.get(file, {}).get(name), f"{file}: {name} is a cap that no table speaks of",
                        "put it into lib/base/limits.def and raise it, or say in tests/not_caps.txt why it is none")
    for file, names in sorted(said.items()):
        for name in sorted(names):
            tally.check(name in found.get(file, ()), f"not_caps.txt speaks of {name}, which {file} does not have")
    with open(os.path.join(lib, "base", "limits.def"), encoding="utf-8") as f:
        rows = re.findall(r"^X\((\w+), (\d+), (\w+),", f.read(), flags=re.M)
    code = ""
    for folder, _, files in os.walk(lib):
        for name in files:
            if name.endswith((".c", ".h")):
                with open(os.path.join(folder, name), encoding="utf-8") as f:
                    code += f.read()
    for name, _, _ in rows:
        tally.check(f"SGA_LIMIT_{name}" in code and f"SGA_MOST_{name}" in code, f"limits.def: {name} is used and raised")
    tally.check(looks_like_cap("MOST_WAYS") and not looks_like_cap("STALLED"), "what looks like a cap")


def check_headers(tally):
    """A header's name tells which one is meant: no two of the product have the same."""
    root = os.path.dirname(os.path.dirname(os.path.abspath(__file__)))
    where = {}
    for top in ("lib", "server", "clients"):
        for folder, _, files in os.walk(os.path.join(root, top)):
            for name in files:
                if name.endswith(".h"):
                    where.setdefault(name, []).append(os.path.relpath(folder, root))
    twice = {name: folders for name, folders in where.items() if len(folders) > 1}
    tally.check(len(where) > 200 and not twice, f"headers with the same name: {twice}")


def early_ends(text):
    """Names that end with their block of code, where a way out comes before what sets them: their end would read what was never written."""
    lines = text.split("\n")
    for n, line in enumerate(lines):
        declared = re.match(r"\s+SGA_(?:ENDS\(\w+\)|FREED) (?:const |unsigned |struct )*\w+ (.*);$", line)
        for name in re.split(r",\s*", declared.group(1)) if declared and "=" not in line else ():
            name = name.strip().lstrip("*").split("[")[0]
            for later in lines[n + 1:]:
                if re.search(rf"\b{name}\b", later):
                    break
                if re.search(r"\b(return|continue|break|goto)\b", later) or later == "}":
                    yield n + 1, name
                    break


def check_ends(tally):
    sample = "void f(void)\n{\n    SGA_ENDS(x_clear) struct x %s;\n    if (g())\n        return;\n    x_init(&a);\n}\n"
    tally.check(list(early_ends(sample % "a")) == [(3, "a")] and not list(early_ends(sample % "a = { 0 }")), "a way out before the start is seen")
    for path in glob.glob(os.path.join(ROOT, "lib", "**", "*.c"), recursive=True):
        with open(path, encoding="utf-8") as source:
            early = list(early_ends(source.read()))
        tally.check(not early, f"{os.path.relpath(path, ROOT)}: may end before it is set: {early}")


# Folders of server/ with state that several threads change.
STATES = ("jobs", "store", "net", "exchange", "framing")


def check_assertions(tally):
    """Five invariants in a thousand lines where state lives, in the code that is shipped."""
    for folder in STATES:
        text = ""
        for path in glob.glob(os.path.join(ROOT, "server", folder, "*.c")):
            with open(path, encoding="utf-8") as source:
                text += source.read()
        lines, stated = text.count("\n"), [a for a in re.findall(r"^\s+assert\((.*)\);", text, re.M) if not re.fullmatch(r"!?\w+( != NULL)?", a)]
        tally.check(lines > 300 and 1000 * len(stated) >= 5 * lines, f"server/{folder}: {len(stated)} invariants in {lines} lines")


BENCHES = {"tests/bench/run": "tests/bench/*.c", "tests/bench/ode/build.sh": "tests/bench/ode/*.c"}    # by the script that builds them


def check_benches(tally):
    """The programs of the benchmarks, which no other test builds, are read by the compiler as their scripts have them built."""
    for script, sources in BENCHES.items():
        with open(os.path.join(ROOT, script), encoding="utf-8") as f:
            told = f.read()
        folders = ["lib/" + name for names in re.findall(r"for floor in ([^;]*);", told) for name in names.split()] + re.findall(r"-iquote ([a-z/]+)(?=\s)", told)
        tally.check(len(folders) > 10, script, f"folders of headers: {folders}")
        for path in sorted(glob.glob(os.path.join(ROOT, sources))):
            name = os.path.relpath(path, ROOT)
            with open(path, encoding="utf-8") as f:
                if "include <sun" in f.read() and not os.path.exists("/usr/include/sundials"):      # a package of the benchmarks alone
                    continue
            run = subprocess.run(["gcc", "-std=gnu11", "-fsyntax-only", "-I/usr/include/suitesparse", *(word for folder in folders for word in ("-iquote", folder)), name],
                                 cwd=ROOT, capture_output=True, text=True)
            tally.check(run.returncode == 0, name, run.stderr[:1000])


def main():
    tally = Tally("self")
    check_benches(tally)
    check_assertions(tally)
    check_caps(tally)
    check_ends(tally)
    check_headers(tally)
    check_expressions(tally)
    check_linear(tally)
    check_identities(tally)
    check_combinations(tally)
    return tally.end()


if __name__ == "__main__":
    sys.exit(main())
