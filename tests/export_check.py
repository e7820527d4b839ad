"""Exports as source: export_check.py BUILD_DIR

Each request's sources are made by `sga code`, the C is compiled without a warning, and both are run at random points and at the samples of
the answer's motion. What they give is held against the answer's texts, read by an evaluator that shares nothing with the library
(expression.py, in mpmath): constraints, their gradients, the field, the gauge fields. Constraints must vanish at the samples, the field of
the source must be tangent there, and a point that was moved off must come back."""
import ctypes
import importlib.util
import json
import os
import random
import subprocess
import tempfile

import mpmath

from expression import Arithmetic, Graph, Undefined
from solver import Solver
from tally import ROOT, Tally, build_folder, scaled, seed

WITHIN = 1e-12
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
            self.back(t, x, [], rng)


def code(build, path, language):
    return subprocess.run([os.path.join(build, "sga"), "code", path, "--language", language], capture_output=True, text=True, check=False)


def one(tally, build, folder, name, request, rng):
    request = {**request, "want": WANT if "trajectory" in request else WANT[:-1]}
    path = os.path.join(folder, "request.json")
    with open(path, "w", encoding="utf-8") as f:
        json.dump(request, f)
    result, problem = Solver(build).solve(request)
    if not tally.check(result is not None, f"{name}: is solved", problem):
        return
    texts = {l: code(build, path, l) for l in ("c", "python")}
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
    held = One(tally, name, oracle, {"C": c, "Python": python})
    found = sum(held.at_point(rng.uniform(0, 2), [rng.uniform(-1, 1) for _ in oracle.names], [rng.uniform(-1, 1) for _ in oracle.gauge],
                              [rng.uniform(0.5, 2) for _ in oracle.arguments]) for _ in range(scaled(6)))
    tally.check(found > 0, f"{name}: has points with values")
    if "trajectory" in result:
        held.motion(result["trajectory"], rng)


def no_number(tally, build, folder):
    """Where a part has no value the field has none: C says NaN, Python raises."""
    request = {"system": {"form": "equations", "variables": ["x", "y"], "equations": ["x' = min(log(x), 1) + max(2, sqrt(x))", "y' = max(x^y, 0)"]}}
    path = os.path.join(folder, "none.json")
    with open(path, "w", encoding="utf-8") as f:
        json.dump(request, f)
    c = CSource(folder, "none", code(build, path, "c").stdout, (2, 0, 0, 0))
    dx = c.field(0.0, [-1.0, 0.5], [], [])
    tally.check(all(v != v for v in dx), "C: no value where there is none", dx)
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
    refused("no field", {"system": plain, "want": ["constraints"]}, 1, "no_code")
    refused("a table", {"system": {**plain, "equations": ["x' = u"], "tables": {"u": {"times": [0, 1], "values": [0, 1]}}}}, 1, "no_code")
    refused("a number beyond the doubles", {"system": {**plain, "equations": ["x' = -x + 1e400"]}}, 1, "no_code")
    refused("a wrong request", {"system": {**plain, "equations": ["x' = -q"]}}, 1, "unknown_name")
    path = os.path.join(ROOT, "etc", "examples", "pendulum.json")
    tally.check(code(build, path, "cobol").returncode == 2, "refused: another language")


def main():
    tally, build = Tally("export"), build_folder()
    rng = random.Random(seed(17))
    mpmath.mp.dps = 30
    requests = dict(OWN)
    for name in EXAMPLES:
        with open(os.path.join(ROOT, "etc", "examples", name + ".json"), encoding="utf-8") as f:
            requests[name] = json.load(f)
    with tempfile.TemporaryDirectory() as folder:
        for name, request in requests.items():
            try:
                one(tally, build, folder, name, request, rng)
            except Exception as e:    # an error in one is one failure; the others go on
                tally.check(False, name, f"{type(e).__name__}: {e}")
        no_number(tally, build, folder)
        refusals(tally, build, folder)
    return tally.end()


if __name__ == "__main__":
    raise SystemExit(main())
