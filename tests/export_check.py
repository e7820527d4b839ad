"""Exports as source: export_check.py BUILD_DIR

Each request's sources are made by `sga code`. The C is compiled without a warning, Python and Octave run theirs, CasADi's formulas are run
over a stand-in of its functions, and the statements of Julia and Modelica by an interpreter of this script, at random points and at the
samples of the answer's motion. What they give is held against the answer's texts, read by an evaluator that shares nothing with the library
(expression.py, in mpmath): constraints, their gradients, the field, the gauge fields. Constraints must vanish at the samples, the field of
the source must be tangent there (and a source with a spoilt component must be seen not to be), and a point that was moved off must come
back. LaTeX and MathML are well-formed, name every variable, and have golden rows."""
import ctypes
import importlib.util
import json
import math
import os
import random
import re
import subprocess
import sys
import tempfile
import types
import xml.etree.ElementTree

import mpmath

from expression import Arithmetic, Graph, Undefined
from print_reader import Latex, Mathml, Unreadable
from solver import Solver
from tally import ROOT, Tally, build_folder, scaled, seed

WITHIN = 1e-12
LANGUAGES = ("c", "python", "matlab", "julia", "casadi", "modelica", "latex", "mathml")
WANT = ["constraints", "index", "vector_field", "gauge", "trajectory"]
OWN = {
    "functions": {"system": {"form": "equations", "variables": ["x", "y", "z", "w"], "parameters": {"k": None, "a": "1/3", "b": "2.5e-7"},
                             "equations": ["x' = sin(y) - a*tanh(x*k) + cbrt(y) + atan2(x, 2 + y^2) + b", "y' = cos(x)/(2 + y^2) + sqrt(3 + x^2) - cosh(y/4)",
                                           "z = exp(-x^2) + asinh(y) + abs(x - 3)*k^2 + min(x, y) + max(y, k) - sign(x)*atan(y)",
                                           "w = (2 + x^2)^(y/5) + log(2 + y^2) - 1/(1 + y^2)^3 + sinh(x/5)*tan(x/9) + asin(sin(x)/2) + acos(sin(y)/2) + acosh(2 + x^2) + atanh(y/99) + pi"]}},
    "free parameter": {"system": {"form": "equations", "variables": ["x", "y", "lam"], "parameters": {"g": "9.81", "L": None},
                                  "equations": ["x'' = -lam*x", "y'' = -lam*y - g", "x^2 + y^2 = L^2"]}},
    "another time": {"system": {"form": "equations", "variables": ["t", "u"], "time": "s", "equations": ["t' = u", "t = sin(s)/3"]}},
}
# Shared parts with names, and a parameter that a sweep varies.
TURNS = "*".join(f"(2 + sin(x + {k}*y))" for k in range(1, 9))
OWN["definitions"] = {"system": {"form": "equations", "variables": ["x", "y", "z"],
                                 "equations": [f"x' = y + ({TURNS})*z", f"y' = ({TURNS})^2 - z*({TURNS})", f"z*({TURNS}) = x + ({TURNS})^3"]}}
OWN["sweep"] = {**OWN["free parameter"], "sweep": [{"parameters": {"g": 1}}, {"parameters": {"g": 2}}], "trajectory": {"stop": 1, "initial": {"x": 1, "y": 0}}}
OWN["sweep"]["system"] = {**OWN["sweep"]["system"], "parameters": {"g": "9.81", "L": "2"}}
EXAMPLES = ("arm", "bead", "circuit", "pendulum", "sleigh", "sliding", "cawley", "ladder")


class CSource:
    """The shared object that gcc makes of a source."""

    def __init__(self, folder, name, text, shape):
        self.n, self.m, self.g, self.arguments = shape
        source, made = os.path.join(folder, name + ".c"), os.path.join(folder, name + ".so")
        with open(source, "w", encoding="utf-8") as f:
            f.write(text)
        run = subprocess.run(["gcc", "-std=c99", "-Wall", "-Wextra", "-Werror", "-pedantic", "-O1", "-shared", "-fPIC", "-o", made, source, "-lm"],
                             capture_output=True, text=True, check=False)
        self.said = run.stderr[:800]
        self.lib = ctypes.CDLL(made) if run.returncode == 0 else None

    @staticmethod
    def array(values, n=0):
        return (ctypes.c_double * max(1, n, len(values)))(*values)

    def rows(self, function, t, x, p, rows):
        out = self.array([], rows * self.n)
        getattr(self.lib, function)(ctypes.c_double(t), self.array(x), self.array(p), out)
        return [list(out[i * self.n:(i + 1) * self.n]) for i in range(rows)]

    def constraints(self, t, x, p):
        out = self.array([], self.m)
        self.lib.sga_constraints(ctypes.c_double(t), self.array(x), self.array(p), out)
        return list(out[:self.m])

    def jacobian(self, t, x, p):
        return self.rows("sga_jacobian", t, x, p, self.m)

    def gauge_fields(self, t, x, p):
        return self.rows("sga_gauge_fields", t, x, p, self.g)

    def field(self, t, x, f, p):
        out = self.array([], self.n)
        self.lib.sga_field(ctypes.c_double(t), self.array(x), self.array(f), self.array(p), out)
        return list(out[:self.n])

    def project(self, t, x, p):
        at, work = self.array(x), self.array([], self.m * self.n + self.n + 2 * self.m + 1)
        steps = self.lib.sga_project(ctypes.c_double(t), at, self.array(p), ctypes.c_double(1e-13), work)
        return list(at[:self.n]) if steps > 0 else None


class Octave:
    """One process of Octave for all sources: its start takes longer than all that it has to do."""

    def __init__(self, folder):
        self.folder, self.count = folder, 0
        self.process = subprocess.Popen(["octave-cli", "--quiet", "--norc", "--no-history"], stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True)
        self.tell(f"warning('off', 'all'); addpath('{folder}');")

    def tell(self, statement):
        self.process.stdin.write(statement + "\n")
        self.process.stdin.flush()

    def ask(self, expression):
        """The numbers of an array by rows, and its shape; or what was said of it."""
        self.tell(f"try, v = {expression}; printf('%d ', size(v)); printf('%.17g ', double(v).'); printf('\\n'); "
                  "catch e, printf('error %s\\n', strrep(e.message, \"\\n\", ' ')); end, fflush(stdout);")
        words = self.process.stdout.readline().split()
        if not words or words[0] == "error":
            raise ArithmeticError(" ".join(words))
        return (int(words[0]), int(words[1])), [float(w) for w in words[2:]]

    def load(self, text):
        self.count += 1
        name = f"model_{self.count}"
        with open(os.path.join(self.folder, name + ".m"), "w", encoding="utf-8") as f:
            f.write(text)
        self.tell(f"rehash; m{self.count} = {name}();")
        return OctaveSource(self, f"m{self.count}")

    def end(self):
        self.process.stdin.close()
        self.process.stdout.close()
        return self.process.wait()


def column(values):
    return "[" + "; ".join(repr(float(v)) for v in values) + "]"


class OctaveSource:
    def __init__(self, octave, name):
        self.octave, self.name = octave, name
        self.n = int(octave.ask(f"numel({name}.variables)")[1][0])

    def ask(self, function, *arguments):
        return self.octave.ask(f"{self.name}.{function}({', '.join(arguments)})")

    def rows(self, function, t, x, p):
        (rows, columns), values = self.ask(function, repr(t), column(x), column(p))
        assert columns == self.n
        return [values[i * columns:(i + 1) * columns] for i in range(rows)]

    def constraints(self, t, x, p):
        return self.ask("constraints", repr(t), column(x), column(p))[1]

    def jacobian(self, t, x, p):
        return self.rows("jacobian", t, x, p)

    def gauge_fields(self, t, x, p):
        return self.rows("gauge_fields", t, x, p)

    def field(self, t, x, f, p):
        return self.ask("field", repr(t), column(x), column(f), column(p))[1]

    def project(self, t, x, p):
        return self.ask("project", repr(t), column(x), column(p))[1]


def power(a, b):
    if a < 0:
        raise ValueError("a real power of a negative number")
    return a ** b


class TextSource:
    """The statements of Julia or Modelica, line by line: with ** for ^ they are Python's, over arrays that count from 1."""
    ARRAYS = {"constraints": "c", "jacobian": "J", "gauge_fields": "G", "gaugeFields": "G", "field": "dx"}
    project = None

    def __init__(self, text, shape):
        self.n, self.m, self.g, self.arguments = shape
        self.base = {"__builtins__": {}, "abs": abs, "min": min, "max": max, "Float64": float, "pi": math.pi, "sign": lambda a: (a > 0) - (a < 0),
                     "atan2": math.atan2, "atan": lambda *a: math.atan2(*a) if len(a) == 2 else math.atan(*a),
                     **{k: getattr(math, k) for k in ("sin", "cos", "tan", "asin", "acos", "sinh", "cosh", "tanh", "exp", "log", "sqrt")}}
        julia = "module SgaModel" in text
        if julia:
            self.base |= {"_power": power, "cbrt": lambda a: math.copysign(abs(a) ** (1 / 3), a), **{k: getattr(math, k) for k in ("asinh", "acosh", "atanh")}}
        else:
            self.base["power"] = power
            for name, body in re.findall(r"function (area\w+|cubeRoot)\n.*?y := (.*?);\n", text, re.S):
                body = re.sub(r"if (.*?) then (.*?) else (.*?)(\)?)$", r"((\2) if (\1) else (\3))\4", body).replace("^", "**")
                self.base[name] = eval("lambda a: " + body, self.base)
        for name, value in re.findall(r"(P_\w+) = (.*?);?\n", text):
            self.base[name] = eval(value.replace("^", "**"), self.base)
        self.code = {}
        for head in re.finditer(r"^ *function (\w+)(.*?)\n *end\b", text, re.S | re.M):
            if head[1] in self.ARRAYS:
                lines = re.findall(r"^    ((?:w\d+|\w+\[[\d, ]+\])) :?= (.*?);?$", head[2], re.M)
                self.code[self.ARRAYS[head[1]]] = compile("\n".join(f"{a} = {b}" for a, b in lines).replace("^", "**"), head[1], "exec")

    def run(self, array, t, x, p, f=()):
        env = {**self.base, "t": t, array: {}, "w": {}, **{k: dict(enumerate(v, 1)) for k, v in (("x", x), ("p", p), ("f", f))}}
        exec(self.code[array], env)
        return env[array]

    def grid(self, array, t, x, p, rows):
        made = self.run(array, t, x, p)
        return [[made.get((i + 1, j + 1), 0.0) for j in range(self.n)] for i in range(rows)]

    def constraints(self, t, x, p):
        made = self.run("c", t, x, p)
        return [made[i + 1] for i in range(self.m)]

    def jacobian(self, t, x, p):
        return self.grid("J", t, x, p, self.m)

    def gauge_fields(self, t, x, p):
        return self.grid("G", t, x, p, self.g)

    def field(self, t, x, f, p):
        made = self.run("dx", t, x, p, f)
        return [made[i + 1] for i in range(self.n)]


class Symbol:
    """What CasADi's symbols are to a source: anything calculates with them."""
    T = property(lambda self: self)

    def same(self, *_):
        return self
    __add__ = __radd__ = __sub__ = __rsub__ = __mul__ = __rmul__ = __truediv__ = __rtruediv__ = __pow__ = __rpow__ = __neg__ = __lt__ = __getitem__ = same


def stand_in():
    def either(f):
        return lambda *a: a[0] if isinstance(a[0], Symbol) else a[-1] if isinstance(a[-1], Symbol) else f(*a)
    names = "sin cos tan asin acos atan atan2 sinh cosh tanh asinh acosh atanh exp log sqrt fabs".split()
    made = {**{k: getattr(math, k) for k in names}, "power": pow, "fmin": min, "fmax": max, "sign": lambda a: (a > 0) - (a < 0),
            "if_else": lambda c, a, b: a if c else b}
    casadi = types.ModuleType("casadi")
    casadi.__dict__.update({k: either(f) for k, f in made.items()})
    symbol = Symbol()
    casadi.SX = types.SimpleNamespace(sym=lambda name, n=1: symbol)
    casadi.vertcat, casadi.reshape, casadi.Function = (lambda *a: symbol), (lambda a, *_: a), (lambda *a: a)
    return casadi


class CasadiSource:
    project = None

    def __init__(self, folder, name, text):
        sys.modules["casadi"] = stand_in()
        try:
            self.module = python_source(folder, name + "_casadi", text)
        finally:
            del sys.modules["casadi"]
        self.n = len(self.module.VARIABLES)

    def rows(self, flat_rows):
        return [flat_rows[i:i + self.n] for i in range(0, len(flat_rows), self.n)]

    def constraints(self, t, x, p):
        return self.module._constraints(t, x, p)

    def jacobian(self, t, x, p):
        return self.rows(self.module._jacobian(t, x, p))

    def gauge_fields(self, t, x, p):
        return self.rows(self.module._gauge_fields(t, x, p))

    def field(self, t, x, f, p):
        return self.module._field(t, x, f, p)


def python_source(folder, name, text):
    path = os.path.join(folder, name.replace(" ", "_") + ".py")
    with open(path, "w", encoding="utf-8") as f:
        f.write(text)
    spec = importlib.util.spec_from_file_location("exported", path)
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


class Oracle:
    """The answer's texts in mpmath."""

    def __init__(self, request, result):
        self.graph, self.number = Graph(), Arithmetic(mpmath.mp)
        self.names = [v["name"] for v in result["variables"]]
        self.time = request["system"].get("time", "t")
        parameters = request["system"].get("parameters", {})
        self.arguments = [k for k, v in parameters.items() if v is None or any(k in s.get("parameters", {}) for s in request.get("sweep", []))]
        self.fixed = {k: self.value_of(v) for k, v in parameters.items() if k not in self.arguments}
        for d in result.get("definitions", []):
            self.graph.define(d["name"], d["expression"])
        self.constraints = [self.graph.parse(c["expression"]) for c in result["constraints"]]
        self.field = [self.graph.parse(result["vector_field"]["components"].get(v, "0")) for v in self.names]
        self.gauge = [[self.graph.parse(f.get(v, "0")) for v in self.names] for f in result["gauge"]["fields"]]

    def value_of(self, text):
        g = Graph()
        e = g.parse(text)
        return g.values(g.cone([e]), {}, self.number)[e]

    def at(self, t, x, p):
        env = {**self.fixed, self.time: mpmath.mpf(t), **{k: mpmath.mpf(v) for k, v in zip(self.arguments, p)},
               **{k: mpmath.mpf(v) for k, v in zip(self.names, x)}}
        roots = self.constraints + self.field + [e for row in self.gauge for e in row]
        return self.graph.values(self.graph.cone(roots), env, self.number)

    def jacobian(self, value):
        rows = []
        for e in self.constraints:
            g = self.graph.gradient(e, value, self.number)
            rows.append([g.get(v, 0) for v in self.names])
        return rows


    def leaving(self, t, x, p, dx):
        """The largest rate at which a constraint leaves 0 along dx, over the size of what it is summed of."""
        value, worst = self.at(t, x, p), 0.0
        for e in self.constraints:
            g = self.graph.gradient(e, value, self.number)
            parts = [g.get(self.time, 0)] + [g.get(v, 0) * d for v, d in zip(self.names, dx)]
            worst = max(worst, abs(sum(parts)) / (1 + sum(abs(v) for v in parts)))
        return worst


def near(got, true, scale=1.0):
    return len(got) == len(true) and all(abs(a - b) <= WITHIN * max(scale, abs(b)) for a, b in zip(got, true))


def flat(rows):
    return [v for row in rows for v in row]


class One:
    def __init__(self, tally, name, oracle, sources):
        self.tally, self.name, self.oracle, self.sources = tally, name, oracle, sources

    def check(self, ok, what, detail=""):
        self.tally.check(ok, f"{self.name}: {what}", detail)

    def at_point(self, t, x, f, p):
        """False: the formulas have no value here."""
        o = self.oracle
        try:
            value = o.at(t, x, p)
            jacobian = flat(o.jacobian(value))
        except Undefined:
            return False
        gauge = [[value[e] for e in row] for row in o.gauge]
        field = [value[e] + sum(f[k] * gauge[k][i] for k in range(len(f))) for i, e in enumerate(o.field)]
        scale = max([1.0] + [abs(v) for v in x] + [abs(v) for v in field] + [abs(v) for v in jacobian])
        for label, s in self.sources.items():
            self.check(near(s.constraints(t, x, p), [value[e] for e in o.constraints], scale), f"{label}: constraints", x)
            self.check(near(flat(s.jacobian(t, x, p)), jacobian, scale), f"{label}: Jacobian", x)
            self.check(near(flat(s.gauge_fields(t, x, p)), flat(gauge), scale), f"{label}: gauge fields", x)
            self.check(near(s.field(t, x, f, p), field, scale), f"{label}: field", x)
        return True

    def back(self, t, x, p, rng):
        moved = [v + rng.uniform(-1e-3, 1e-3) for v in x]
        for label, s in self.sources.items():
            if not s.project:
                continue
            try:
                y = s.project(t, moved, p)
            except ArithmeticError:
                y = None
            size = max([1.0] + [abs(v) for v in x])
            self.check(y is not None and all(abs(c) <= 1e-10 * size for c in s.constraints(t, y, p)), f"{label}: a moved point comes back", (x, y))
            self.check(y is not None and max(abs(a - b) for a, b in zip(x, y)) <= 0.5 * size, f"{label}: it comes back near", (x, y))

    def motion(self, trajectory, rng):
        columns = trajectory["columns"]
        place = [columns.index(v) for v in self.oracle.names] if set(self.oracle.names) <= set(columns) else None
        if place is None:
            return
        for row in trajectory["rows"][::max(1, len(trajectory["rows"]) // 5)]:
            t, x = row[0], [row[i] for i in place]
            size = max([1.0] + [abs(v) for v in x])
            for label, s in self.sources.items():
                self.check(all(abs(c) <= 1e-10 * size ** 2 for c in s.constraints(t, x, [])), f"{label}: constraints vanish on the motion", row)
            self.at_point(t, x, [rng.uniform(-1, 1) for _ in self.oracle.gauge], [])
            self.tangent(t, x, [rng.uniform(-1, 1) for _ in self.oracle.gauge])
            self.back(t, x, [], rng)

    def tangent(self, t, x, f):
        """A component that is off by a thousandth of the field has to be seen, wherever a constraint depends on its variable."""
        o = self.oracle
        slopes = o.jacobian(o.at(t, x, []))
        for label, s in self.sources.items():
            dx = s.field(t, x, f, [])
            self.check(o.leaving(t, x, [], dx) <= 1e-8, f"{label}: the field is tangent on the motion", (t, x))
            size = 1 + max(abs(v) for v in dx)
            for i, name in enumerate(o.names):
                if any(abs(row[i]) > 1e-2 for row in slopes):
                    spoilt = [v + 1e-3 * size * (k == i) for k, v in enumerate(dx)]
                    self.check(o.leaving(t, x, [], spoilt) > 1e-8, f"{label}: a spoilt component {name} is seen", (t, x))


def code(build, path, language):
    return subprocess.run([os.path.join(build, "sga"), "code", path, "--language", language], capture_output=True, text=True, check=False)


def one(tally, build, folder, octave, name, request, rng):
    request = {**request, "want": WANT if "trajectory" in request else WANT[:-1]}
    path = os.path.join(folder, "request.json")
    with open(path, "w", encoding="utf-8") as f:
        json.dump(request, f)
    result, problem = Solver(build).solve(request)
    if not tally.check(result is not None, f"{name}: is solved", problem):
        return
    texts = {l: code(build, path, l) for l in LANGUAGES}
    if not tally.check(all(r.returncode == 0 for r in texts.values()), f"{name}: is exported", [r.stderr for r in texts.values()]):
        return
    oracle = Oracle(request, result)
    shape = len(oracle.names), len(oracle.constraints), len(oracle.gauge), len(oracle.arguments)
    c = CSource(folder, name, texts["c"].stdout, shape)
    if not tally.check(c.lib is not None, f"{name}: C compiles", c.said):
        return
    python = python_source(folder, name, texts["python"].stdout)
    tally.check(python.VARIABLES == oracle.names and python.GENERATIONS == [k["generation"] for k in result["constraints"]]
                and python.ARGUMENTS == oracle.arguments and python.GAUGE == shape[2], f"{name}: Python's names")
    held = One(tally, name, oracle, {"C": c, "Python": python, "Octave": octave.load(texts["matlab"].stdout), "Julia": TextSource(texts["julia"].stdout, shape),
                                     "CasADi": CasadiSource(folder, name, texts["casadi"].stdout), "Modelica": TextSource(texts["modelica"].stdout, shape)})
    printed(tally, name, oracle, texts["latex"].stdout, texts["mathml"].stdout)
    print_values(tally, name, oracle, texts["latex"].stdout, texts["mathml"].stdout, rng)
    found = sum(held.at_point(rng.uniform(0, 2), [rng.uniform(-1, 1) for _ in oracle.names], [rng.uniform(-1, 1) for _ in oracle.gauge],
                              [rng.uniform(0.5, 2) for _ in oracle.arguments]) for _ in range(scaled(6)))
    tally.check(found > 0, f"{name}: has points with values")
    if "trajectory" in result:
        held.motion(result["trajectory"], rng)


def braces(text):
    """Whether braces, and \\left with \\right, are balanced."""
    depth = 0
    for c in re.sub(r"\\[{}]", "", text):
        depth += (c == "{") - (c == "}")
        if depth < 0:
            return False
    return depth == 0 and text.count("\\left") == text.count("\\right") and text.count("\\begin{") == text.count("\\end{")


def printed(tally, name, oracle, latex, mathml):
    """Well-formed, with a row for each rate and each constraint, and each name with its symbol in the head."""
    body = latex.split("amsmath.", 1)[1]
    symbols = dict(reversed(re.fullmatch(r"% (.*): (.*)", line).groups()) for line in latex.splitlines() if re.fullmatch(r"% (.*): ([A-Za-z_]\S*)", line))
    tally.check(braces(body), f"{name}: LaTeX's braces are balanced")
    rates = re.findall(r"\\frac{\\mathrm{d} (.*)}{\\mathrm{d} (.*)} &=", body)
    tally.check(rates == [(symbols.get(v), symbols.get(oracle.time)) for v in oracle.names], f"{name}: LaTeX has the rate of each variable", rates)
    tally.check(len(set(symbols.values())) == len(symbols), f"{name}: LaTeX's symbols differ", symbols)
    tally.check(body.count("\n  \\mathcal{C}_") == len(oracle.constraints), f"{name}: LaTeX has each constraint")
    try:
        root = xml.etree.ElementTree.fromstring(mathml)
    except xml.etree.ElementTree.ParseError as e:
        tally.check(False, f"{name}: MathML is well-formed", e)
        return
    ns = "{http://www.w3.org/1998/Math/MathML}"
    heads = {v: s for s, v in re.findall(r"^  (<m.*>): (\S+)$", mathml, re.M)}
    tally.check(root.tag == ns + "math" and all(f"<mi mathvariant=\"normal\">d</mi>{heads.get(v)}</mrow>" in mathml for v in oracle.names),
                f"{name}: MathML has the rate of each variable", heads)
    arity = {"mfrac": 2, "msup": 2, "msub": 2, "mroot": 2}
    wrong = [e.tag for e in root.iter() if len(e) != arity.get(e.tag.removeprefix(ns), len(e))]
    tally.check(not wrong, f"{name}: MathML's elements have their parts", wrong)
    rows = [r for r in root.iter(ns + "mtr") if len(r) == 3]
    tally.check(len(rows) >= len(oracle.names) + len(oracle.constraints), f"{name}: MathML has all rows", len(rows))


PRINT_WITHIN = mpmath.mpf(10) ** -20


class Print:
    """The rows of a print, as values at points."""

    def __init__(self, reader, text):
        self.graph, self.number, self.nodes, self.constants = Graph(), Arithmetic(mpmath.mp), {}, {}
        for what, text in reader(text).rows:
            if what[0] == "part":
                self.graph.alias[f"W__{what[1]}"] = self.graph.parse(text)
            elif what[0] == "value":
                self.constants[what[1]] = self.graph.parse(text)
            else:
                self.nodes[what] = self.graph.parse(text)

    def values(self, env):
        return self.graph.values(self.graph.cone(list(self.nodes.values())), env, self.number)

    def value_of(self, e):
        return self.graph.values(self.graph.cone([e]), {}, self.number)[e]


def print_is(tally, name, label, oracle, said, point):
    """Whether each row has the value that the oracle has at a point; None: no value there."""
    t, x, f, p = point
    env = {**oracle.fixed, oracle.time: mpmath.mpf(t), **{k: mpmath.mpf(v) for k, v in zip(oracle.arguments + oracle.names, p + x)}}
    try:
        value = oracle.at(t, x, p)
        jacobian = oracle.jacobian(value)
        got = said.values({**env, **{f"F__{k + 1}": mpmath.mpf(v) for k, v in enumerate(f)}})
    except Undefined:
        return None
    true = {("constraint", i + 1): value[c] for i, c in enumerate(oracle.constraints)}
    true |= {("slope", i + 1, v): row[j] for i, row in enumerate(jacobian) for j, v in enumerate(oracle.names) if ("slope", i + 1, v) in said.nodes or row[j] != 0}
    true |= {("gauge", k + 1, v): value[row[j]] for k, row in enumerate(oracle.gauge) for j, v in enumerate(oracle.names) if ("gauge", k + 1, v) in said.nodes or value[row[j]] != 0}
    true |= {("rate", v): value[oracle.field[j]] + sum((mpmath.mpf(f[k]) * value[row[j]] for k, row in enumerate(oracle.gauge)), mpmath.mpf(0)) for j, v in enumerate(oracle.names)}
    if not tally.check(set(true) == set(said.nodes), f"{name}: {label} has the rows that there are", set(true) ^ set(said.nodes)):
        return False
    wrong = [(what, got[said.nodes[what]], v) for what, v in true.items() if abs(got[said.nodes[what]] - v) > PRINT_WITHIN * (1 + abs(v)) * 1000]
    return tally.check(not wrong, f"{name}: {label}'s formulas", wrong[:2])


def print_values(tally, name, oracle, latex, mathml, rng):
    for label, reader, text in (("LaTeX", Latex, latex), ("MathML", Mathml, mathml)):
        try:
            said = Print(reader, text)
        except (Unreadable, KeyError, ValueError) as e:
            tally.check(False, f"{name}: {label} is read", f"{type(e).__name__}: {e}"[:300])
            continue
        tally.check(said.constants.keys() == oracle.fixed.keys() and all(said.value_of(e) == oracle.fixed[k] for k, e in said.constants.items()), f"{name}: {label}'s parameters")
        found = [print_is(tally, name, label, oracle, said, (rng.uniform(0, 2), [rng.uniform(-1, 1) for _ in oracle.names], [rng.uniform(-1, 1) for _ in oracle.gauge],
                                                             [rng.uniform(0.5, 2) for _ in oracle.arguments])) for _ in range(scaled(6))]
        tally.check(any(r is not None for r in found), f"{name}: {label} at points with values")


def print_is_held(tally, build, folder, rng):
    """A print with one sign changed is seen."""
    request = OWN["free parameter"]
    path = os.path.join(folder, "sign.json")
    with open(path, "w", encoding="utf-8") as f:
        json.dump(request, f)
    result, _ = Solver(build).solve(request)
    oracle = Oracle(request, result)
    for label, reader, minus, plus in (("latex", Latex, " - ", " + "), ("mathml", Mathml, "<mo>-</mo>", "<mo>+</mo>")):
        text = code(build, path, label).stdout
        at = text.rindex(minus)
        said = Print(reader, text[:at] + plus + text[at + len(minus):])
        quiet = Tally("export")
        quiet.check = lambda ok, *_: ok
        point = 0.3, [rng.uniform(0.1, 1) for _ in oracle.names], [], [1.3]
        tally.check(print_is(quiet, "sign", label, oracle, said, point) is False, f"{label}: a changed sign is seen")


def goldens(tally, build, folder):
    """Rows as they should be: brackets, signs, fractions, powers, functions, names that would look the same."""
    request = {"system": {"form": "equations", "variables": ["omega", "x_1", "x1", "lam"], "parameters": {"k": "2/3", "mass": "0.0625"},
                          "equations": ["omega' = -k*(x1 - x_1)", "x_1' = (omega + 1)^2/(mass*x1)", "x1' = exp(-omega)*sqrt(1 + x1^2)", "lam = abs(omega)^(1/3)"]}}
    path = os.path.join(folder, "golden.json")
    with open(path, "w", encoding="utf-8") as f:
        json.dump(request, f)
    for language in ("latex", "mathml"):
        text = code(build, path, language).stdout
        with open(os.path.join(ROOT, "tests", "export_golden." + ("tex" if language == "latex" else "xml")), encoding="utf-8") as f:
            golden = f.read()
        tally.check(text.split("\n", 2 if language == "mathml" else 1)[-1] == golden, f"golden: {language}", text)


def no_number(tally, build, folder, octave):
    """Where a part has no value the field has none: C and MATLAB say NaN, Python raises."""
    request = {"system": {"form": "equations", "variables": ["x", "y"], "equations": ["x' = min(log(x), 1) + max(2, sqrt(x))", "y' = max(x^y, 0)"]}}
    path = os.path.join(folder, "none.json")
    with open(path, "w", encoding="utf-8") as f:
        json.dump(request, f)
    c = CSource(folder, "none", code(build, path, "c").stdout, (2, 0, 0, 0))
    dx = c.field(0.0, [-1.0, 0.5], [], [])
    tally.check(all(v != v for v in dx), "C: no value where there is none", dx)
    dx = octave.load(code(build, path, "matlab").stdout).field(0.0, [-1.0, 0.5], [], [])
    tally.check(len(dx) == 2 and all(v != v for v in dx), "Octave: no value where there is none", dx)
    try:
        said = python_source(folder, "none", code(build, path, "python").stdout).field(0.0, [-1.0, 0.5])
    except ValueError:
        said = None
    tally.check(said is None, "Python: no value where there is none", said)


def refusals(tally, build, folder):
    def refused(name, request, status, word):
        path = os.path.join(folder, "refused.json")
        with open(path, "w", encoding="utf-8") as f:
            json.dump(request, f)
        r = code(build, path, "c")
        tally.check(r.returncode == status and word in r.stderr and not r.stdout, f"refused: {name}", r.stderr[:300])
    plain = {"form": "equations", "variables": ["x"], "equations": ["x' = -x"]}
    refused("no field", {"system": {**plain, "equations": ["x' = -x", "0 = 1"]}}, 1, "no_code")
    refused("a table", {"system": {**plain, "equations": ["x' = u"], "tables": {"u": {"times": [0, 1], "values": [0, 1]}}}}, 1, "no_code")
    refused("a number beyond the doubles", {"system": {**plain, "equations": ["x' = -x + 1e400"]}}, 1, "no_code")
    refused("a wrong request", {"system": {**plain, "equations": ["x' = -q"]}}, 1, "unknown_name")
    path = os.path.join(ROOT, "etc", "examples", "pendulum.json")
    tally.check(code(build, path, "cobol").returncode == 2, "refused: another language")


def asked_for(tally, build, folder):
    """The command asks for what an export needs, however `want` is written; what is no request stays the error that it is."""
    with open(os.path.join(ROOT, "etc", "examples", "pendulum.json"), encoding="utf-8") as f:
        request = json.load(f)
    path = os.path.join(folder, "asked.json")

    def said(text):
        with open(path, "w", encoding="utf-8") as f:
            f.write(text)
        return code(build, path, "c")
    whole = said(json.dumps({**request, "want": ["constraints", "vector_field", "gauge"]})).stdout
    tally.check("field" in whole, "asked for: the whole", whole)
    for want in ("index", "constraints", ["index"], ["gauge", "index"], ["vector_field"]):
        run = said(json.dumps({"want": want, **{k: v for k, v in request.items() if k != "want"}}))
        tally.check(run.stdout == whole, f"asked for: want {want}", run.stdout + run.stderr)
    for text, error in (("", "json_syntax"), ('{"want": ["index"', "json_syntax"), (json.dumps({**request, "want": "colour"}), "/want"),
                        (json.dumps({**request, "want": 3}), "/want")):
        run = said(text)
        tally.check(run.returncode == 1 and run.stdout == "" and error in run.stderr, f"no request: {text}: {error}", run.stdout + run.stderr)


def main():
    tally, build = Tally("export"), build_folder()
    rng = random.Random(seed(17))
    mpmath.mp.dps = 30
    requests = dict(OWN)
    for name in EXAMPLES:
        with open(os.path.join(ROOT, "etc", "examples", name + ".json"), encoding="utf-8") as f:
            requests[name] = json.load(f)
    with tempfile.TemporaryDirectory() as folder:
        octave = Octave(folder)
        for name, request in requests.items():
            try:
                one(tally, build, folder, octave, name, request, rng)
            except Exception as e:    # an error in one is one failure; the others go on
                tally.check(False, name, f"{type(e).__name__}: {e}")
        no_number(tally, build, folder, octave)
        goldens(tally, build, folder)
        print_is_held(tally, build, folder, rng)
        refusals(tally, build, folder)
        asked_for(tally, build, folder)
        tally.check(octave.end() == 0, "Octave ends well")
    return tally.end()


if __name__ == "__main__":
    raise SystemExit(main())
