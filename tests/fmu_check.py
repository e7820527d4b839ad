"""FMUs: fmu_check.py BUILD_DIR

Each request's FMU is made by `sga code`, unpacked, validated against the standard's schemas, compiled against its headers without a warning, and
driven through its C functions. Derivatives, outputs and event indicators are held against the answer's texts (the evaluator of export_check.py) to
1e-12 at random points and along a motion; an integrator here, with the FMU's projections, and the one inside the FMU must come where the
answer's motion comes. Wrong calls are refused. A C importer (tests/fmi/drive.c), linked by prefix, runs under valgrind."""
import ctypes
import json
import math
import os
import random
import subprocess
import tempfile
import xml.etree.ElementTree
import zipfile

import mpmath

from export_check import EXAMPLES, OWN, WITHIN, Oracle
from solver import Solver
from tally import ROOT, Tally, build_folder, scaled, seed

FMI = os.path.join(ROOT, "tests", "fmi")
OK, DISCARD, ERROR = 0, 2, 3
LOG = ctypes.CFUNCTYPE(None, ctypes.c_void_p, ctypes.c_int, ctypes.c_char_p, ctypes.c_char_p)
STRICT = ["gcc", "-std=c99", "-pedantic", "-Wall", "-Wextra", "-Werror", "-O1", "-I" + os.path.join(FMI, "headers")]
REQUESTS = dict(OWN)
JUMPING = REQUESTS.pop("functions")
REQUESTS["functions"] = json.loads(json.dumps(JUMPING).replace("- sign(x)*atan(y)", "- atan(y)"))
REQUESTS["definitions"] = {**json.loads(json.dumps(OWN["definitions"]).replace("(2 + sin(", "(1 + 1/5*sin(")), "trajectory": {"stop": 0.25, "samples": 3, "initial": {"x": 0.1, "y": 0.2}}}
REQUESTS["switches"] = {"system": {"form": "equations", "variables": ["x", "y", "z"], "equations": ["x' = -x + sign(sin(5*t + 1/3))", "y' = abs(x) - y + max(z, 0)", "z = x*y + min(y, 1/4)"]},
                        "trajectory": {"stop": 3, "samples": 13, "initial": {"x": 0.2, "y": 0.1}}}
REQUESTS["pendulum, long"] = {"system": {"form": "equations", "variables": ["x", "y", "lam"], "parameters": {"g": "9.81"}, "equations": ["x'' = -lam*x", "y'' = -lam*y - g", "x^2 + y^2 = 1"]},
                              "accuracy": {"rtol": 1e-9, "atol": 1e-9}, "trajectory": {"start": 1, "stop": 6, "samples": 11, "initial": {"x": 0.6, "y": 0.8}, "outputs": ["x", "y", "lam", "x'", "y'", "x^2 + y^2", "g*y + (x'^2 + y'^2)/2"]}}
REQUESTS["no constraint"] = {"system": {"form": "equations", "variables": ["u", "v"], "equations": ["u' = v", "v' = cos(t) - u^3"]},
                             "trajectory": {"times": [0.5, 1, 4], "initial": {"u": 1, "v": 0}}}
REQUESTS["want"] = {"want": ["index"], **REQUESTS["pendulum, long"]}


class Fmu:
    """The shared object of an FMU and what its description says."""

    def __init__(self, folder, name, tally, started=False):
        self.folder, self.said, self.started = folder, [], started
        root = xml.etree.ElementTree.parse(os.path.join(folder, "modelDescription.xml")).getroot()
        self.token, self.root = root.get("instantiationToken"), root
        self.variables = root.find("ModelVariables").findall("Float64")
        self.reference = {v.get("name"): int(v.get("valueReference")) for v in self.variables}
        tally.check(sorted(self.reference.values()) == list(range(len(self.variables))), f"{name}: a value reference for each name")
        rates = [v for v in self.variables if v.get("derivative")]
        by_reference = {int(v.get("valueReference")): v.get("name") for v in self.variables}
        self.states = [by_reference[int(v.get("derivative"))] for v in rates]
        listed = [by_reference[int(e.get("valueReference"))] for e in root.find("ModelStructure").findall("ContinuousStateDerivative")]
        tally.check(listed == [v.get("name") for v in rates] == [f"der({s})" for s in self.states], f"{name}: derivatives in the structure", listed)
        self.indicators = [int(e.get("valueReference")) for e in root.find("ModelStructure").findall("EventIndicator")]
        self.inputs = [v.get("name") for v in self.variables if v.get("causality") == "input"]
        self.parameters = [v.get("name") for v in self.variables if v.get("causality") == "parameter"]
        self.outputs = [v.get("name") for v in self.variables if v.get("causality") == "output" and v.get("name") not in self.states]
        made = os.path.join(folder, "model.so")
        run = subprocess.run([*STRICT, "-DFMI3_OVERRIDE_FUNCTION_PREFIX", "-shared", "-fPIC", "-o", made, os.path.join(folder, "sources", "sga_model.c"), "-lm"],
                             capture_output=True, text=True, check=False)
        self.lib = ctypes.CDLL(made) if tally.check(run.returncode == 0, f"{name}: compiles without a warning", run.stderr[:800]) else None
        if self.lib:
            self.log = LOG(lambda _, status, category, text: self.said.append((status, text.decode())))
            for f in ("fmi3InstantiateModelExchange", "fmi3InstantiateCoSimulation", "fmi3InstantiateScheduledExecution"):
                getattr(self.lib, f).restype = ctypes.c_void_p
            self.lib.fmi3GetVersion.restype = ctypes.c_char_p

    def exchange(self, token=None):
        made = self.lib.fmi3InstantiateModelExchange(b"one", (token or self.token).encode(), None, False, True, None, self.log)
        return Instance(self, made) if made else None

    def simulation(self, events=False):
        made = self.lib.fmi3InstantiateCoSimulation(b"two", self.token.encode(), None, False, True, events, False, None, ctypes.c_size_t(0), None, self.log, None)
        return Instance(self, made) if made else None


def doubles(values, n=0):
    return (ctypes.c_double * max(1, n, len(values)))(*values)


class Instance:
    def __init__(self, fmu, at):
        self.fmu, self.at, self.n = fmu, ctypes.c_void_p(at), len(fmu.states)

    def call(self, name, *arguments):
        return getattr(self.fmu.lib, "fmi3" + name)(self.at, *arguments)

    def free(self):
        self.fmu.lib.fmi3FreeInstance(self.at)

    def set(self, names, values):
        refs = (ctypes.c_uint32 * max(1, len(names)))(*[self.fmu.reference[n] for n in names])
        return self.call("SetFloat64", refs, ctypes.c_size_t(len(names)), doubles(values), ctypes.c_size_t(len(names)))

    def get(self, names):
        """(status, values)"""
        refs = (ctypes.c_uint32 * max(1, len(names)))(*[self.fmu.reference[n] for n in names])
        out = doubles([], len(names))
        return self.call("GetFloat64", refs, ctypes.c_size_t(len(names)), out, ctypes.c_size_t(len(names))), list(out[:len(names)])

    def enter(self, start=0.0, tolerance=None, stop=None):
        return self.call("EnterInitializationMode", tolerance is not None, ctypes.c_double(tolerance or 0), ctypes.c_double(start), stop is not None, ctypes.c_double(stop or 0))

    def vector(self, function, n):
        out = doubles([], n)
        return self.call(function, out, ctypes.c_size_t(n)), list(out[:n])

    def states(self):
        return self.vector("GetContinuousStates", self.n)

    def rates(self):
        return self.vector("GetContinuousStateDerivatives", self.n)

    def go(self, t, x):
        return self.call("SetTime", ctypes.c_double(t)) or self.call("SetContinuousStates", doubles(x), ctypes.c_size_t(self.n))

    def update(self):
        """(status, whether states changed)"""
        flags, time = [ctypes.c_bool() for _ in range(5)], ctypes.c_double()
        status = self.call("UpdateDiscreteStates", *[ctypes.byref(f) for f in flags], ctypes.byref(time))
        return status, flags[3].value

    def completed(self):
        event, end = ctypes.c_bool(), ctypes.c_bool()
        return self.call("CompletedIntegratorStep", True, ctypes.byref(event), ctypes.byref(end)), event.value

    def step(self, t, h):
        flags, last = [ctypes.c_bool() for _ in range(3)], ctypes.c_double()
        status = self.call("DoStep", ctypes.c_double(t), ctypes.c_double(h), True, *[ctypes.byref(f) for f in flags], ctypes.byref(last))
        return status, last.value


def made(build, folder, name, request, tally):
    """The folder of the unpacked FMU, or None."""
    path, archive = os.path.join(folder, "request.json"), os.path.join(folder, "made.fmu")
    with open(path, "w", encoding="utf-8") as f:
        json.dump(request, f)
    command = [os.path.join(build, "sga"), "code", path, "--language", "fmu"]
    run = subprocess.run([*command, "-o", archive], capture_output=True, text=True, check=False)
    if not tally.check(run.returncode == 0, f"{name}: an FMU", run.stderr):
        return None
    with open(archive, "rb") as f:
        tally.check(f.read() == subprocess.run(command, capture_output=True, check=False).stdout, f"{name}: twice the same")
    place = os.path.join(folder, "fmu_" + "".join(c if c.isalnum() else "_" for c in name))
    with zipfile.ZipFile(archive) as z:
        tally.check(z.testzip() is None and all(i.compress_type == zipfile.ZIP_DEFLATED for i in z.infolist()), f"{name}: the archive is whole")
        z.extractall(place)
    for schema, file in (("ModelDescription", "modelDescription.xml"), ("BuildDescription", "sources/buildDescription.xml")):
        run = subprocess.run(["xmllint", "--noout", "--nonet", "--schema", os.path.join(FMI, "schema", f"fmi3{schema}.xsd"), os.path.join(place, file)],
                             capture_output=True, text=True, check=False)
        tally.check(run.returncode == 0, f"{name}: {file} is valid", run.stderr[:800])
    return place


def close(got, true, scale=1.0):
    return len(got) == len(true) and all(abs(a - b) <= WITHIN * max(scale, abs(b)) for a, b in zip(got, true))


class Held:
    """An FMU beside the answer's texts."""

    def __init__(self, tally, name, fmu, oracle):
        self.tally, self.name, self.fmu, self.oracle = tally, name, fmu, oracle
        self.extra = [oracle.graph.parse(y) for y in fmu.outputs]

    def check(self, ok, label, detail=""):
        return self.tally.check(ok, f"{self.name}: {label}", detail)

    def at_point(self, m, t, x, f, p):
        """In continuous time; whether there is a value."""
        o = self.oracle
        try:
            value = o.at(t, x, p)
            env = {**o.fixed, o.time: mpmath.mpf(t), **{k: mpmath.mpf(v) for k, v in zip(o.arguments, p)}, **{k: mpmath.mpf(v) for k, v in zip(o.names, x)}}
            extra = o.graph.values(o.graph.cone(self.extra), env, o.number) if self.extra else {}
            true = [value[o.field[i]] + sum((f[k] * value[o.gauge[k][i]] for k in range(len(f))), mpmath.mpf(0)) for i in range(len(o.names))]
            size = [abs(value[o.field[i]]) + sum(abs(f[k] * value[o.gauge[k][i]]) for k in range(len(f))) for i in range(len(o.names))]
        except Exception:     # no value there
            return False
        self.check(m.set(self.fmu.inputs, f) == OK and m.go(t, x) == OK, "a point is taken")
        status, got = m.rates()
        self.check(status == OK and len(got) == len(true) and all(abs(a - b) <= WITHIN * (1 + s) * 10 for a, b, s in zip(got, true, size)), "derivatives", (t, x, got, [float(v) for v in true]))
        status, named = m.get([f"der({s})" for s in self.fmu.states])
        self.check(status == OK and named == got, "derivatives by reference", named)
        status, y = m.get(self.fmu.outputs)
        self.check(status == OK and all(abs(a - b) <= WITHIN * 10 * (1 + abs(b)) for a, b in zip(y, (extra[e] for e in self.extra))), "outputs", y)
        return True

    def motion(self, trajectory):
        """(columns of states, rows) of the answer's motion."""
        columns = trajectory["columns"]
        return [columns.index(s) for s in self.fmu.states if s in columns], [s for s in self.fmu.states if s in columns], trajectory["rows"]


# Where the answer has no start.
GUESS = [0.4, -0.7, 0.9, 0.3, -0.6]


def ready(m, parameters, start, tolerance=None):
    """In continuous time, from the start of the description, or from another where it has none."""
    guess = [] if m.fmu.started else m.fmu.states
    return (m.set([*parameters, *guess], [*parameters.values(), *(GUESS[i % 5] for i in range(len(guess)))]), m.enter(start, tolerance), m.call("ExitInitializationMode"), m.update()[0], m.call("EnterContinuousTimeMode"))


def runge_kutta(m, t, x, h):
    def rate(t, x):
        m.go(t, x)
        return m.rates()[1]
    k1 = rate(t, x)
    k2 = rate(t + h / 2, [a + h / 2 * b for a, b in zip(x, k1)])
    k3 = rate(t + h / 2, [a + h / 2 * b for a, b in zip(x, k2)])
    k4 = rate(t + h, [a + h * b for a, b in zip(x, k3)])
    return [a + h / 6 * (b + 2 * c + 2 * d + e) for a, b, c, d, e in zip(x, k1, k2, k3, k4)]


def indicators(m):
    return m.vector("GetEventIndicators", len(m.fmu.indicators))[1]


def one_step(m, t, x, h):
    """A step that no indicator changes its sign in, unless it is as short as can be: formulas switch at once. (t, x)."""
    m.go(t, x)
    before = indicators(m)
    while True:
        y = runge_kutta(m, t, x, h)
        m.go(t + h, y)
        if h <= 1e-12 or not any(a * b < 0 for a, b in zip(before, indicators(m))):
            return t + h, y
        h /= 2


def exchange_motion(held, m, trajectory, substeps):
    """Runge-Kutta here, Event Mode where the FMU asks for it; how often it asked."""
    places, names, rows = held.motion(trajectory)
    states = held.fmu.states
    (status, x), events = m.states(), 0
    t, worst = rows[0][0], 0.0
    for row in rows[1:]:
        h = (row[0] - t) / substeps
        while t < row[0] - 1e-12:
            m.go(t, x)
            t, x = one_step(m, t, x, min(h, row[0] - t))
            status, event = m.completed()
            if event:
                events += 1
                status = status or m.call("EnterEventMode") or m.update()[0] or m.call("EnterContinuousTimeMode")
                x = m.states()[1]
            if status != OK:
                held.check(False, "Model Exchange goes on", (t, status, held.fmu.said[-1:]))
                return events
        got = dict(zip(states, x))
        worst = max([worst] + [abs(got[s] - row[k]) / (1 + abs(row[k])) for k, s in zip(places, names)])
        held.at_point(m, t, x, [0.0] * len(held.fmu.inputs), [])
    held.check(worst < 2e-6, "Model Exchange comes where the answer's motion comes", worst)
    return events


def simulation_motion(held, parameters, trajectory, stop):
    places, names, rows = held.motion(trajectory)
    m, worst = held.fmu.simulation(), 0.0
    begun = (m.set([*parameters], [*parameters.values()]), m.enter(rows[0][0], 1e-9, stop), m.call("ExitInitializationMode"))
    held.check(begun == (OK, OK, OK), "Co-Simulation begins", (begun, held.fmu.said))
    t = rows[0][0]
    for row in rows:
        if row[0] > t:
            status, t = m.step(t, row[0] - t)
            if not held.check(status == OK and abs(t - row[0]) < 1e-9, "a step", (status, t, held.fmu.said[-1:])):
                break
        values = m.get(names)[1]
        worst = max([worst] + [abs(a - row[k]) / (1 + abs(row[k])) for a, k in zip(values, places)])
    held.check(worst < 2e-6, "Co-Simulation comes where the answer's motion comes", worst)
    values = m.get(held.fmu.states)[1]
    left = held.oracle.at(t, values, list(parameters.values()))
    residual = max([0.0] + [abs(float(left[c])) for c in held.oracle.constraints])
    held.check(residual < 1e-9, "Co-Simulation stays on the constraints", residual)
    m.free()


def wrong_calls(tally, name, fmu, parameters, start):
    def refused(status, label):
        tally.check(status == ERROR and fmu.said, f"{name}: {label} is refused", (status, fmu.said[-1:]))
        fmu.said.clear()
    tally.check(fmu.exchange("another token") is None, f"{name}: another token")
    tally.check(fmu.simulation(events=True) is None, f"{name}: there is no event mode in Co-Simulation")
    tally.check(not fmu.lib.fmi3InstantiateScheduledExecution(b"x", fmu.token.encode(), None, False, True, None, fmu.log, None, None, None), f"{name}: no scheduled execution")
    m = fmu.exchange()
    refused(m.rates()[0], "derivatives before the initialization")
    refused(m.call("SetTime", ctypes.c_double(0)), "time before the initialization")
    refused(m.step(0, 1)[0], "a step in Model Exchange")
    refused(m.call("ExitInitializationMode"), "an exit without entry")
    refused(m.enter(0, 2.0), "a tolerance of 2")
    refused(m.enter(math.nan), "no time")
    refused(m.set([fmu.states[0]], [math.nan]), "a state that is no number")
    refused(m.set([f"der({fmu.states[0]})"], [1.0]), "setting a derivative")
    refused(m.set([fmu.variables[0].get("name")], [1.0]), "setting the time")
    wrong = (ctypes.c_uint32 * 1)(len(fmu.variables))
    tally.check(ready(m, parameters, start) == (OK,) * 5, f"{name}: and goes on after refusals", fmu.said)
    fmu.said.clear()
    out = doubles([0.0])
    refused(m.call("GetFloat64", wrong, ctypes.c_size_t(1), out, ctypes.c_size_t(1)), "an unknown value reference")
    refused(m.call("GetFloat64", wrong, ctypes.c_size_t(1), out, ctypes.c_size_t(2)), "another number of values")
    refused(m.call("GetInt32", wrong, ctypes.c_size_t(1), out, ctypes.c_size_t(1)), "an integer")
    refused(m.set([fmu.states[0]], [1.0]), "a state by reference in continuous time")
    refused(m.call("SetContinuousStates", out, ctypes.c_size_t(len(fmu.states) + 1)), "too many states")
    refused(m.enter(), "a second initialization")
    refused(m.update()[0], "updates in continuous time")
    tally.check(m.call("GetInt32", None, ctypes.c_size_t(0), None, ctypes.c_size_t(0)) == OK, f"{name}: no integers is right")
    tally.check(m.call("Terminate") == OK, f"{name}: terminates")
    refused(m.call("Terminate"), "a second end")
    tally.check(m.call("Reset") == OK and ready(m, parameters, start) == (OK,) * 5, f"{name}: again after a reset", fmu.said)
    m.free()
    tally.check(fmu.lib.fmi3GetVersion() == b"3.0" and fmu.lib.fmi3Reset(None) == ERROR, f"{name}: version; no instance")


def kept_states(held, parameters, start):
    """A state that is kept and set again gives the same values."""
    m, kept = held.fmu.simulation(), ctypes.c_void_p()
    guess = [] if held.fmu.started else held.fmu.states
    m.set([*parameters, *guess], [*parameters.values(), *(GUESS[i % 5] for i in range(len(guess)))])
    m.enter(start)
    m.call("ExitInitializationMode")
    m.step(start, 0.1)
    held.check(m.call("GetFMUState", ctypes.byref(kept)) == OK, "a state is kept")
    first = (m.step(start + 0.1, 0.2), m.get(held.fmu.states))
    held.check(m.call("SetFMUState", kept) == OK, "a state is set again")
    held.check((m.step(start + 0.1, 0.2), m.get(held.fmu.states)) == first, "and gives the same", first)
    held.check(m.call("FreeFMUState", ctypes.byref(kept)) == OK and not kept.value, "a state is freed")
    m.free()


def without_parameters(held, start):
    m = held.fmu.exchange()
    m.enter(start)
    held.fmu.said.clear()
    held.check(m.call("ExitInitializationMode") == ERROR and "no value" in held.fmu.said[-1][1], "a parameter without a value is missed", held.fmu.said)
    m.free()


def valgrind(tally, name, fmu, start, stop, rows, places):
    program = os.path.join(fmu.folder, "drive")
    run = subprocess.run([*STRICT, "-g", "-o", program, os.path.join(FMI, "drive.c"), os.path.join(fmu.folder, "sources", "sga_model.c"), "-lm"], capture_output=True, text=True, check=False)
    if not tally.check(run.returncode == 0, f"{name}: links by prefix", run.stderr[:800]):
        return
    run = subprocess.run(["valgrind", "--quiet", "--error-exitcode=9", "--leak-check=full", "--show-leak-kinds=all", "--errors-for-leak-kinds=all", program, fmu.token,
                          repr(start), repr(stop), str(len(fmu.states))], capture_output=True, text=True, check=False)
    tally.check(run.returncode == 0, f"{name}: valgrind finds nothing", (run.returncode, run.stdout[:400], run.stderr[-1200:]))
    got = [float(v) for v in run.stdout.split()] if run.returncode == 0 else []
    if got and places is not None:
        tally.check(all(abs(got[i] - rows[-1][k]) < 1e-5 * (1 + abs(rows[-1][k])) for i, k in places), f"{name}: the C importer comes there", (got, rows[-1]))


def one(tally, build, folder, name, request, rng):
    solved = {**request, "want": ["constraints", "index", "vector_field", "gauge"] + ["trajectory"] * ("trajectory" in request)}
    result, problem = Solver(build).solve(solved)
    place = made(build, folder, name, request, tally)
    if not tally.check(result is not None, f"{name}: is solved", problem) or not place:
        return
    oracle, fmu = Oracle(request, result), Fmu(place, name, tally, "trajectory" in request)
    if not fmu.lib:
        return
    tally.check(fmu.states == oracle.names and fmu.parameters == oracle.arguments and len(fmu.inputs) == len(oracle.gauge), f"{name}: states, parameters and inputs",
                (fmu.states, fmu.parameters, fmu.inputs))
    held = Held(tally, name, fmu, oracle)
    trajectory = result.get("trajectory") or next((s for s in result.get("trajectories", []) if "rows" in s), None)
    start = trajectory["rows"][0][0] if trajectory else 0.0
    swept = (trajectory or {}).get("parameters", {})
    parameters = {k: float(swept.get(k, rng.uniform(0.5, 2))) for k in fmu.parameters}
    m = fmu.exchange()
    if not tally.check(ready(m, parameters, start, 1e-9) == (OK,) * 5, f"{name}: Model Exchange begins", fmu.said[-1:]):
        m.free()
        return
    status, x = m.states()
    value = oracle.at(start, x, list(parameters.values()))
    off = max([0.0] + [abs(float(value[c])) for c in oracle.constraints])
    tally.check(status == OK and off < 1e-10, f"{name}: the start is on the constraints", off)
    if trajectory:
        projected = trajectory["initial"]["projected"]
        tally.check(all(abs(v - projected.get(s, v)) <= 1e-9 * (1 + abs(v)) for s, v in zip(fmu.states, x)), f"{name}: the start is the answer's", (x, projected))
        description = fmu.root.find("DefaultExperiment")
        tally.check(float(description.get("startTime")) == start and (description.get("stopTime") is None or float(description.get("stopTime")) >= trajectory["rows"][-1][0]), f"{name}: the experiment")
    found = sum(held.at_point(m, rng.uniform(0, 2), [rng.uniform(-1, 1) for _ in fmu.states], [rng.uniform(-1, 1) for _ in fmu.inputs], list(parameters.values())) for _ in range(scaled(8)))
    tally.check(found > 0, f"{name}: points with values")
    m.free()
    if trajectory and not fmu.inputs and trajectory["ended"] is None:
        m = fmu.exchange()
        ready(m, parameters, start, 1e-9)
        # the answer's times are near enough for the texts at points along the motion: parameters are those of the set
        events = exchange_motion_with(held, m, trajectory, parameters)
        tally.check(events > 0 or name != "pendulum, long", f"{name}: projections were asked for", events)
        m.free()
        simulation_motion(held, parameters, trajectory, trajectory["rows"][-1][0])
    if parameters and not swept:
        without_parameters(held, start)
    wrong_calls(tally, name, fmu, parameters, start)
    kept_states(held, parameters, start)
    if not parameters and not fmu.inputs:
        rows = trajectory["rows"] if trajectory else None
        places = [(i, trajectory["columns"].index(s)) for i, s in enumerate(fmu.states) if s in trajectory["columns"]] if trajectory and trajectory["ended"] is None else None
        valgrind(tally, name, fmu, start, rows[-1][0] if rows else start + 0.5, rows, places)


def exchange_motion_with(held, m, trajectory, parameters):
    point = held.at_point
    held.at_point = lambda m, t, x, f, p: point(m, t, x, f, list(parameters.values()))
    try:
        return exchange_motion(held, m, trajectory, 100)
    finally:
        held.at_point = point


def switches(tally, build, folder):
    """The indicators are what the branches hang on; a constraint that jumps is refused."""
    place = made(build, folder, "indicators", {"system": {"form": "equations", "variables": ["x", "y"], "equations": ["x' = abs(y - 3) + sign(x*y - 1)", "y' = min(x, t) + max(2, y)"]}}, tally)
    fmu = Fmu(place, "indicators", tally)
    m = fmu.exchange()
    ready(m, {}, 0.0)
    x, y, t = 1.7, -0.3, 0.9
    m.go(t, [x, y])
    got, true = indicators(m), [y - 3, x * y - 1, x - t, 2 - y]
    tally.check(len(got) == 4 and all(any(abs(abs(a) - abs(b)) < 1e-14 for a in got) for b in true), "indicators", (got, true))
    m.free()
    path = os.path.join(folder, "jump.json")
    for request in (JUMPING, {"system": {"form": "equations", "variables": ["v", "i"], "equations": ["v' = i", "sign(t - 1) = v + i"]}}):
        with open(path, "w", encoding="utf-8") as f:
            json.dump(request, f)
        run = subprocess.run([os.path.join(build, "sga"), "code", path, "--language", "fmu"], capture_output=True, text=True, check=False)
        tally.check(run.returncode == 1 and "no_code" in run.stderr and "jumps" in run.stderr and not run.stdout, "a constraint that jumps", run.stderr)


def main():
    tally, build = Tally("fmu"), build_folder()
    rng = random.Random(seed(23))
    mpmath.mp.dps = 30
    for name in EXAMPLES:
        with open(os.path.join(ROOT, "etc", "examples", name + ".json"), encoding="utf-8") as f:
            REQUESTS[name] = json.load(f)
    with tempfile.TemporaryDirectory() as folder:
        for name, request in REQUESTS.items():
            try:
                one(tally, build, folder, name, request, rng)
            except Exception as e:    # an error in one is one failure; the others go on
                tally.check(False, name, f"{type(e).__name__}: {e}")
        switches(tally, build, folder)
    return tally.end()


if __name__ == "__main__":
    raise SystemExit(main())
