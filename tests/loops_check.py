"""Ranges and loops by another route: loops_check.py BUILD_DIR

- each request against the same written out by this file's own reader: with indices (x[1]), and with plain names (x_1); answers are equal but
  for the names and for what `work` says; some against closed forms;
- random loops over two names, against lists of names made here;
- requests that are refused, with code, place, and what is said of the pass;
- sizes that may not be written out are refused at once, whatever they would make;
- long lists of answers that say once what repeats (families.py);
- exports in each language, also where names would fall together; C is compiled, Python is run.
"""
import itertools
import json
import math
import os
import random
import re
import subprocess
import sys
import tempfile

import families
import schemas
from solver import Solver
from tally import Tally, build_folder, scaled, seed

INDEXED = re.compile(r"([A-Za-z_]\w*)\[([^\[\]]*)\]")
WORD = re.compile(r"(?<![\w.])[A-Za-z_]\w*")


def whole(text, env):
    return eval(text.replace("/", "//"), {"__builtins__": {}}, env)      # the tests' own quotients are whole


def parts(text):
    """What commas outside of brackets part, and the text behind the ) that ends it."""
    depth, found, last = 0, [], 0
    for at, c in enumerate(text):
        if c == ")" and depth == 0:
            return found + [text[last:at]], text[at + 1:]
        depth += (c in "([") - (c in ")]")
        if c == "," and depth == 0:
            found.append(text[last:at])
            last = at + 1
    raise ValueError(text)


def add_up(text, env):
    """The first sum of a text, term by term, its names as numbers."""
    before, inside = re.split(r"\bsum\(", text, maxsplit=1)
    found, rest = parts(inside)
    loops = [p for p in found if re.match(r"\s*[A-Za-z_]\w*\s*=", p)]
    terms = ["(" + put(",".join(found[len(loops):]).strip(), inner) + ")" for _, inner in passes(dims_of(",".join(loops)), env)]
    return before + "(" + (" + ".join(terms) or "0") + ")" + rest


def put(text, env):
    """Sums as terms, indices worked out, names in place of numbers; x[1] is held apart so that its parts are not words again."""
    while re.search(r"\bsum\(\s*[A-Za-z_]\w*\s*=", text):
        text = add_up(text, env)
    text = INDEXED.sub(lambda m: m[1] + "[" + ",".join(str(whole(e, env)) for e in m[2].split(",")) + "]", text)
    return WORD.sub(lambda m: f"({env[m[0]]})" if env.get(m[0], 0) < 0 else str(env.get(m[0], m[0])), text)


def passes(dims, env):
    """dims: (name or None, low, high)."""
    if not dims:
        yield (), env
        return
    name, low, high = dims[0]
    for v in range(whole(low, env), whole(high, env) + 1):
        for rest, inner in passes(dims[1:], {**env, **({name: v} if name else {})}):
            yield (v,) + rest, inner


def dims_of(text):
    dims = []
    for part in text.split(","):
        name, _, bounds = part.rpartition("=")
        low, _, high = bounds.partition(":")
        dims.append((name.strip() or None, low, high or low))
    return dims


def names(text, env):
    m = INDEXED.match(text)
    for values, inner in passes(dims_of(m[2]), env):
        yield m[1] + "[" + ",".join(map(str, values)) + "]" + text[m.end():], inner


def ranged(v):
    return isinstance(v, str) and INDEXED.fullmatch(v.rstrip("'")) and ":" in v


def out(v, env):
    if ranged(v) or (isinstance(v, dict) and "for" in v):
        return out([v], env)
    if isinstance(v, str):
        return put(v, env)
    if isinstance(v, list):
        made = []
        for e in v:
            if ranged(e):
                made += [n for n, _ in names(e, env)]
            elif isinstance(e, dict) and "for" in e:
                made += [put(e.get("equation", e.get("expression")), inner) for _, inner in passes(dims_of(e["for"]), env)]
            else:
                made.append(out(e, env))
        return made
    if isinstance(v, dict):
        made = {}
        for key, e in v.items():
            if key in ("name", "form", "time"):
                made[key] = e
            elif ranged(key):
                for i, (n, inner) in enumerate(names(key, env)):
                    made[n] = out(e[i] if isinstance(e, list) else e, inner)
            else:
                made[put(key, env) if "[" in key else key] = out(e, env)
        return made
    return v


def written_out(request):
    env = dict(request["system"].get("sizes", {}))
    request = {k: out(v, env) if k != "want" else v for k, v in request.items()}
    request["system"].pop("sizes", None)
    return request


def plain(value):
    """x[2,13] as x_2_13."""
    text = json.dumps(value)
    return json.loads(re.sub(r"([A-Za-z_]\w*)\[(\d+(?:,\d+)*)\]", lambda m: m[1] + "_" + m[2].replace(",", "_"), text))


PENDULA = {
    "system": {
        "form": "equations", "sizes": {"n": 3}, "parameters": {"g": "9.81", "L[1:n]": [1, "1/2", "3/4"]},
        "variables": ["x[0:n]", "y[0:n]", "s[1:n]"],
        "equations": [
            "x[0] = 0", "y[0] = 0",
            {"for": "i = 1:n-1", "equation": "x[i]'' = -s[i]*(x[i] - x[i-1]) + s[i+1]*(x[i+1] - x[i])"},
            {"for": "i = 1:n-1", "equation": "y[i]'' = -s[i]*(y[i] - y[i-1]) + s[i+1]*(y[i+1] - y[i]) - g"},
            "x[n]'' = -s[n]*(x[n] - x[n-1])", "y[n]'' = -s[n]*(y[n] - y[n-1]) - g",
            {"for": "i = 1:n", "equation": "(x[i] - x[i-1])^2 + (y[i] - y[i-1])^2 = L[i]^2"}]},
    "trajectory": {"stop": "1/4", "samples": 3, "initial": {"x[i = 1:n]": "i/10", "y[1:n]": [-1, "-3/2", -2.2], "x[1:n]'": 0, "y[1:n]'": 0}, "outputs": ["x[1:n]", "y[n]", "s[1]"]}}
LADDER = {
    "system": {
        "form": "equations", "sizes": {"n": 6, "m": 2}, "parameters": {"R": 1, "C[1:n]": 2}, "variables": ["v[0:n]", "i[1:n]"],
        "equations": ["v[0] = sin(t)", {"for": "k = 1:n", "equation": "v[k-1] - v[k] = R*i[k] + i[k]^3/m"},
                      {"for": "k = 1:n-1", "equation": "C[k]*v[k]' = i[k] - i[k+1]"}, "C[n]*v[n]' = i[n]"]},
    "trajectory": {"stop": 1, "samples": 3, "initial": {"v[1:n]": 0}, "hold": ["v[1:n]"], "outputs": ["v[m:n-1]", {"for": "k = 1:2, j = k:2", "expression": "i[k]*i[j]"}]}}
HEAT = {
    "system": {
        "form": "equations", "sizes": {"n": 4}, "parameters": {"h": "1/(n+1)"}, "variables": ["u[0:n+1,0:n+1]"],
        "equations": [
            {"for": "i = 1:n, j = 1:n", "equation": "u[i,j]' = (u[i-1,j] + u[i+1,j] + u[i,j-1] + u[i,j+1] - 4*u[i,j])/h^2"},
            {"for": "i = 0:n+1", "equation": "u[i,0] = 0"}, {"for": "i = 0:n+1", "equation": "u[i,n+1] = 0"},
            {"for": "j = 1:n", "equation": "u[0,j] = 0"}, {"for": "j = 1:n", "equation": "u[n+1,j] = 0"}]},
    "trajectory": {"stop": "1/20", "samples": 2, "initial": {"u[i = 1:n, j = 1:n]": "sin(pi*i*h)*sin(2*pi*j*h)"}, "outputs": ["u[2,1]"]}}
EQUAL = {
    "pendula": PENDULA,
    "pendula, structure and derivation": {"system": PENDULA["system"], "want": ["constraints", "index", "structure", "derivation"]},
    "ladder": LADDER,
    "heat": HEAT,
    "springs, lagrangian": {
        "system": {
            "form": "lagrangian", "sizes": {"n": 3}, "parameters": {"k[1:n-1]": None}, "coordinates": ["q[1:n]", "w"],
            "lagrangian": "(q[1]'^2 + q[n-1]'^2 + q[n]'^2)/2 - k[1]*(q[1] - q[2])^2 - k[2]*(q[2] - q[3])^2",
            "holonomic": {"for": "i = 1:n-1", "expression": "q[i+1] - q[i] - w"}},
        "want": ["constraints", "index", "vector_field", "gauge", "dirac"]},
    "rods, mechanical": {
        "system": {
            "form": "mechanical", "sizes": {"n": 3}, "coordinates": ["x[1:n]"], "masses": [{"for": "i = 1:n", "expression": "1 + (i - 1)/2"}],
            "forces": ["-x[1]", {"for": "i = 2:n", "expression": "-10*i"}], "constraints": [{"for": "i = 2:n", "expression": "x[i]' - i*x[i-1]'"}]}},
    "control": {
        "system": {"form": "control", "variables": ["x[1:3]"], "inputs": ["u[1:2]"], "F": ["x[2]", "0", "0"], "G": [[0, 1, 0], [0, 0, 1]], "constraints": ["x[1:2]"]}},
    "descriptor with inputs": {
        "system": {"form": "descriptor", "states": ["x[1:2]"], "inputs": ["u[1:2]"], "outputs": ["y[1:2]"], "E": [[1, 0], [0, 0]], "A": [[-1, 1], [0, 1]],
                   "B": [[1, 0], [0, 1]], "C": [[1, 0], [0, 1]]},
        "want": ["transfer", "linearization"], "trajectory": {"initial": {"x[1:2]": 0, "u[1:2]": 0}}},
    "quasilinear, swept": {
        "system": {"form": "quasilinear", "sizes": {"n": 2}, "variables": ["x[1:n]"], "parameters": {"a[1:n]": [1, 2]}, "A": [[1, 0], [0, 1]], "alpha": {"for": "i = 1:n", "expression": "-a[i]*x[i]"}},
        "trajectory": {"stop": 1, "samples": 2, "initial": {"x[1:n]": "n/2"}, "events": [{"name": "n[1:2]", "expression": "x[1] - 1/n"}], "integrals": ["x[1]^2/x[2]"],
                       "sensitivities": {"parameters": ["a[1:n]"], "initial": ["x[1:n]"]}}, "sweep": [{"parameters": {"a[1:n]": [1, 3]}}, {"initial": {"x[2]": "n+1"}}]},
    "a hub, by sums": {
        "system": {
            "form": "equations", "sizes": {"n": 3}, "parameters": {"R[1:n]": [1, 2, "1/2"]}, "variables": ["v[1:n]", "hub", "q"],
            "equations": [{"for": "i = 1:n", "equation": "i*v[i]' = (hub - v[i])/R[i] + sum(j = 1:i-1, v[j])/10"},
                          "sum(i = 1:n, (v[i] - hub)/R[i]) + sin(t) = 0", "q = sum(i = 1:n, j = i:n, v[i]*v[j]) - 2*sum( k = 1 : 2, sum(l = 1:k, l*v[k]) )"]},
        "trajectory": {"stop": 1, "samples": 3, "initial": {"v[i = 1:n]": "sum(j = 1:i, 1/j)"}, "outputs": ["sum(k = 1:n, v[k])", "q", {"for": "m = 1:n", "expression": "sum(k = m:n, v[k])"}],
                       "events": [{"name": "half", "expression": "sum(k = 1:n, v[k]) - 3"}]}},
    "equilibria": {"system": {"form": "equations", "variables": ["x[1:2]", "u[1]"], "equations": [{"for": "i = 1:2", "equation": "x[i]' = u[1] - i*x[i]"}]},
                   "want": ["equilibria"], "equilibria": {"hold": {"u[1:1]": 2}}},
}
del EQUAL["quasilinear, swept"]["trajectory"]["sensitivities"]     # they go with one trajectory
EQUAL["sensitivities"] = json.loads(json.dumps(EQUAL["quasilinear, swept"]))
del EQUAL["sensitivities"]["sweep"]
EQUAL["sensitivities"]["trajectory"]["sensitivities"] = {"parameters": ["a[1:n]"], "initial": ["x[1:n]"]}


SAME = ("verdict", "variables", "dimensions", "index")


def alike(a, b):
    """Equal, numbers nearly; what is printed of expressions, and estimates of errors, are left out."""
    if isinstance(a, (int, float)) and isinstance(b, (int, float)):
        return abs(a - b) <= 1e-7 * (1 + abs(a))
    if isinstance(a, list) and isinstance(b, list):
        return len(a) == len(b) and all(map(alike, a, b))
    if isinstance(a, dict) and isinstance(b, dict):
        return a.keys() == b.keys() and all(alike(a[k], b[k]) for k in a if k in ("columns", "rows", "projected", "initial", "poles", "values", "points", "sensitivities", "parameters", "events"))
    return a == b


class Check:
    def __init__(self):
        self.tally, self.solver, self.schema, self.asked = Tally("loops"), Solver(build_folder(), number=float), schemas.validator("result"), schemas.validator("request")
        self.program = os.path.join(build_folder(), "sga")

    def solve(self, label, request, quiet=False):
        fault = schemas.faults(self.asked, request)
        self.tally.check(not fault, f"{label}: the request's schema", fault)
        result, problem = self.solver.solve(request)
        if not self.tally.check(result is not None, label, str(problem)):
            return None
        fault = schemas.faults(self.schema, result)
        self.tally.check(not fault, f"{label}: schema", fault)
        result.pop("work", None)
        return result

    def equal(self, label, request):
        given = self.solve(label, request)
        long = written_out(request)
        for how, other in (("written out", long), ("with plain names", plain(long))):
            answer = self.solve(f"{label}, {how}", other)
            if given and answer:
                one, two = plain(given), plain(answer)
                if other is long:
                    wrong = [k for k in one.keys() | two.keys() if one.get(k) != two.get(k)]
                else:                # terms are printed in an order of names
                    wrong = [k for k in SAME if one.get(k) != two.get(k)] + [k for k in ("trajectory", "trajectories", "transfer", "equilibria") if not alike(one.get(k), two.get(k))]
                self.tally.check(not wrong, f"{label}: the same answer, {how}", f"{wrong}: {[(one.get(k), two.get(k)) for k in wrong][:1]}"[:1500])
        return given

    def refused(self, label, request, code, pointer, says):
        result, problem = self.solver.solve(request)
        good = problem is not None and problem.get("code") == code and problem.get("pointer", "") == pointer and says in problem.get("detail", "")
        self.tally.check(good, f"refused: {label}", f"{problem}, not {code} at {pointer}: {says}")

    def code(self, label, request, language):
        run = subprocess.run([self.program, "code", "--language", language, "-"], input=json.dumps(request), capture_output=True, text=True, timeout=120)
        self.tally.check(run.returncode == 0 and run.stdout, f"{label}: export to {language}", run.stderr)
        return run.stdout


def with_equation(loop):
    request = json.loads(json.dumps(LADDER))
    request["system"]["equations"][1] = loop
    return request


def changed(path, value, base=LADDER):
    request = json.loads(json.dumps(base))
    at = request
    for key in path[:-1]:
        at = at[key]
    if isinstance(at, list) and path[-1] == len(at):
        at.append(value)
    else:
        at[path[-1]] = value
    return request


def refusals(c):
    place, equations = "/system/equations/1", "/system/equations/1/equation"

    def loop(label, text, code, where, says, body="v[k-1] - v[k] = R*i[k]"):
        c.refused(label, with_equation({"for": text, "equation": body}), code, place + "/" + where, says)
    loop("past the last index", "k = 1:n+1", "unknown_name", "equation", "'v[7]'; there are 7, from v[0] to v[6] (where k = 7: v[6] - v[7] = R*i[7])")
    loop("below 0", "k = 0:n", "unknown_name", "equation", "below 0; raise")
    loop("empty", "k = n:1", "wrong_shape", "for", "range 6:1")
    loop("empty in each pass", "k = 1:2, j = k:0", "wrong_shape", "for", "no pass")
    loop("unknown bound", "k = 1:q", "unknown_name", "for", "'q'")
    loop("a fraction", "k = 1:n/4", "undefined_expression", "for", "whole")
    loop("a fraction in a pass", "k = 2:3, j = 1:n/(k-1)*0 + 6/(k*k-4)", "undefined_expression", "for", "division by 0 in an index; choose other bounds (k = 2)")
    loop("no bounds", "k = 1", "expression_syntax", "for", "bounds")
    loop("no equality", "k in 1:n", "expression_syntax", "for", "written")
    loop("steps", "k = 1:2:n", "expression_syntax", "for", "steps of 1")
    loop("twice", "k = 1:2, k = 1:2", "duplicate_name", "for", "already")
    loop("a size", "n = 1:2", "duplicate_name", "for", "already")
    loop("a name of the system", "R = 1:2", "duplicate_name", "for", "of the system")
    loop("a family of the system", "i = 1:2", "duplicate_name", "for", "of the system")
    loop("time", "t = 1:2", "duplicate_name", "for", "of the system")
    loop("a function", "sin = 1:2", "bad_name", "for", "grammar")
    loop("if", "if = 1:2", "bad_name", "for", "grammar")
    loop("too large", "k = 1:4000001", "too_many_variables", "for", "left")
    loop("far too large", "k = 1:999999999, j = 1:999999999", "too_many_variables", "for", "left")
    loop("too large a number", "k = 1:999999999*999999999", "too_many_variables", "for", "999999999")
    loop("empty without end", "k = 1:999999999, j = k+1:k", "too_many_variables", "for", "empty")
    loop("nine names", ", ".join(f"k{i} = 1:1" for i in range(9)), "wrong_shape", "for", "more than 8")
    loop("a sum that ends", "k = 1:2", "expression_syntax", "equation", "(where k = 1: v[1] +)", "v[k] +")
    loop("a range inside", "k = 1:2", "expression_syntax", "equation", "range", "v[1:2] = k")
    loop("not closed", "k = 1:2", "expression_syntax", "equation", "]", "v[k = k")
    loop("a function's bracket", "k = 1:2", "unknown_name", "equation", "( )", "sin[k] = 0")
    loop("nested", "k = 1:2", "expression_too_deep", "equation", "32", f"v[{'(' * 40}k{')' * 40}] = 0")
    loop("another index", "k = 1:2", "unknown_name", "equation", "from v[0] to v[6]", "v[k,k] = 0")
    loop("no index", "k = 1:2", "unknown_name", "equation", "from v[0] to v[6]", "v*k = 0")
    loop("an index of a parameter", "k = 1:2", "unknown_name", "equation", "R has no index", "R[k] = 0")
    c.refused("texts that are too long", with_equation({"for": "k = 1:3999900", "equation": "v[k] = " + "0 + " * 100 + "0"}), "too_many_variables", place + "/for", "bytes")
    c.refused("no body", with_equation({"for": "k = 1:2"}), "missing_member", place, "expression")
    c.refused("two bodies", with_equation({"for": "k = 1:2", "equation": "v[k] = 0", "expression": "1"}), "invalid_request", place, "one body")
    c.refused("another member", with_equation({"for": "k = 1:2", "equation": "v[k] = 0", "step": 2}), "unknown_member", place + "/step", "step")
    c.refused("bounds that are no text", with_equation({"for": 3, "equation": "v[k] = 0"}), "invalid_request", place + "/for", "string")
    c.refused("an element behind a loop", changed(["system", "equations", 3], "C[n]*v[n]' = i[n+1]"), "unknown_name", "/system/equations/3", "'i[7]'")
    c.refused("a fault behind two loops, its column", changed(["system", "equations", 4], "v[n-1] = v[n-2] + zz"), "unknown_name", "/system/equations/4", "zz")
    c.refused("given twice", changed(["system", "variables", 2], "v[3:3]"), "duplicate_name", "/system/variables/2", "(v[3])")
    c.refused("too many variables", changed(["system", "variables", 2], "w[1:400000]"), "too_many_variables", "/system/variables", "400000")
    c.refused("a function's name", changed(["system", "variables", 2], "sin[1:2]"), "bad_name", "/system/variables/2", "grammar")
    c.refused("a size that is a variable", changed(["system", "variables", 2], "n"), "duplicate_name", "/system/sizes/n", "of the system")
    c.refused("a size that is a parameter", changed(["system", "sizes", "R"], 3), "duplicate_name", "/system/sizes/R", "of the system")
    c.refused("a size that is no whole number", changed(["system", "sizes", "m"], 2.5), "invalid_request", "/system/sizes/m", "whole")
    c.refused("a size below 0", changed(["system", "sizes", "m"], "n - 7"), "invalid_request", "/system/sizes/m", "from 0")
    c.refused("sizes in a circle", changed(["system", "sizes", "m"], "k + 1", changed(["system", "sizes", "k"], "m + 1")), "unknown_name", "/system/sizes/m", "'k'")
    c.refused("sizes that are a list", changed(["system", "sizes"], [1]), "invalid_request", "/system/sizes", "object")
    c.refused("an index of time", changed(["system", "time"], "s[1]"), "bad_name", "/system/time", "index")
    c.refused("a start that is not there", changed(["trajectory", "initial", "v[6:7]"], 1), "duplicate_name", "/trajectory/initial/v[6:7]", "v[6]")
    c.refused("another start that is not there", changed(["trajectory", "initial", "v[7:8]"], 1), "unknown_name", "/trajectory/initial/v[7:8]", "from v[0] to v[6] (v[7])")
    c.refused("too few values", changed(["trajectory", "initial", "i[1:3]"], [1, 2]), "wrong_shape", "/trajectory/initial/i[1:3]", "2 values")
    c.refused("hold", changed(["trajectory", "hold", 1], "v[9]"), "unknown_name", "/trajectory/hold/1", "from v[0]")
    c.refused("outputs", changed(["trajectory", "outputs", 0], "v[5:8]"), "unknown_name", "/trajectory/outputs/0", "(v[7])")
    c.refused("a range in an expression", changed(["trajectory", "outputs", 0], "v[1:2]^2"), "expression_syntax", "/trajectory/outputs/0", "part of an expression")

    def sums(label, text, code, says, column=None):
        where = "/system/equations/4"
        c.refused(f"sum: {label}", changed(["system", "equations", 4], text), code, where, says)
        if column:
            _, told = c.solver.solve(changed(["system", "equations", 4], text))
            c.tally.check(told and told.get("column") == column, f"sum: {label}: column {column}", str(told))
    sums("no term", "v[0] = sum(k = 1:3)", "expression_syntax", "sum(i = 1:3, x[i])", 8)
    sums("nothing behind the comma", "v[0] = sum(k = 1:3, )", "expression_syntax", "sum(i = 1:3, x[i])")
    sums("not closed", "v[0] = 1 + sum(k = 1:3, (v[k])", "expression_syntax", "a ) is missing", 12)
    sums("empty", "v[0] = sum(k = 3:1, v[k])", "wrong_shape", "range 3:1", 16)
    sums("no bounds", "v[0] = sum(k = 1, v[k])", "expression_syntax", "bounds")
    sums("a name of the system", "v[0] = sum(R = 1:n, v[R])", "duplicate_name", "take another for the sum", 12)
    sums("a name of the loop around", "v[0] = sum(k = 1:n, sum(k = 1:2, v[k]))", "duplicate_name", "already", 25)
    sums("an index past the last", "v[0] = sum(k = 1:n+1, v[k])", "unknown_name", "'v[7]'; there are 7", 23)
    sums("an index below 0", "v[0] = sum(k = 0:n, v[k-1])", "unknown_name", "below 0", 23)
    sums("an unknown name in it", "v[0] = sum(k = 1:n, sum(j = 1:k, v[j]*zz)) + 1", "unknown_name", "'zz'", 39)
    sums("an unknown name behind it", "v[0] = sum(k = 1:n, v[k]) + zz", "unknown_name", "'zz'", 29)
    sums("an unknown bound", "v[0] = sum(k = 1:w, v[k])", "unknown_name", "'w'", 18)
    sums("too many terms", "v[0] = sum(k = 1:999999999, v[0])", "too_many_variables", "4000000 terms")
    sums("too many terms of sums", "v[0] = sum(k = 1:3000, j = 1:3000, v[0])", "too_many_variables", "4000000 terms")
    sums("bounds without end, and no term", "v[0] = sum(k = 1:4000, sum(j = 1:900000, l = j+1:j, v[0]))", "too_many_variables", "4000000 terms")
    sums("too much of a text", "v[0] = sum(k = 1:3999000, " + "v[0] + " * 20 + "0)", "too_many_variables", "bytes")
    sums("as others write it", "v[0] = sum(v[k] for k in 1:3)", "unknown_name", "'k' is no loop name and no size of system.sizes; a sum is written sum(i = 1:3, x[i])", 14)
    sums("of a name", "v[0] = sum(R)", "unknown_name", "unknown function 'sum'; a sum is written sum(i = 1:3, x[i])", 8)
    sums("a range", "v[0] = sum(v[1:n])", "expression_syntax", "adds terms up")
    lists = {"system": {"form": "equations", "variables": ["x[1:2]"], "equations": [{"for": "i = 1:2", "equation": "x[i]' = -x[i]"}]},
             "trajectory": {"stop": 1, "samples": 2, "initial": {"x[1:2]": [["x[1+1]"], ["0"]]}}}
    c.refused("lists for names of a range", lists, "invalid_request", "/trajectory/initial/x[1:2]", "found an array (x[1])")
    # line and column are those of the text as it was sent
    _, problem = c.solver.solve(with_equation({"for": "k = 1:n", "equation": "v[k-1] - v[k] = R*i[k+0*n]*zz"}))
    c.tally.check(problem and problem.get("column") == 28, "the column is that of the text that was sent", str(problem))


def all_faults(c):
    """A check lists each fault of a loop once, and those beside it."""
    request = with_equation({"for": "k = 1:n", "equation": "v[k-1] - v[k] = R*i[k+n]"})
    request["system"]["equations"][3] = "C[n]*v[n]' = zz"
    run = subprocess.run([c.program, "check", "-", "--json"], input=json.dumps(request), capture_output=True, text=True, timeout=60)
    said = json.loads(run.stdout or run.stderr)
    places = [p["pointer"] for p in said.get("problems", [])]
    c.tally.check(places == ["/system/equations/1/equation", "/system/equations/3"], "all faults, each once", str(said)[:600])


def random_loops(c):
    """Sums over random index sets, as equations x[i,j] = value: what is printed says which there were."""
    rng = random.Random(seed(1))
    for turn in range(max(3, scaled(12))):
        n, m, low = rng.randint(1, 5), rng.randint(1, 4), rng.randint(0, 3)
        bounds = rng.choice([f"{low}:{low}+m-1", f"{low}:i+{low}", f"i:i*{rng.randint(1, 3)}"])
        text = f"i = {low}:n+{low}-1, j = {bounds}"
        shift, factor = rng.randint(0, 3), rng.randint(1, 3)
        request = {"system": {"form": "equations", "sizes": {"n": n, "m": m}, "variables": ["z"], "equations": ["z' = 1"]},
                   "trajectory": {"stop": 1, "samples": 2, "initial": {"z": 0}, "outputs": [{"for": text, "expression": f"z + i*{factor} - j/(i+n) - {shift}"}]}}
        cells = [inner for _, inner in passes(dims_of(text), {"n": n, "m": m})]
        if not cells:
            continue
        result = c.solve(f"random loop {turn}", request)
        if result:
            row = result["trajectory"]["rows"][0][1:]
            should = [e["i"] * factor - e["j"] / (e["i"] + n) - shift for e in cells]
            c.tally.check(len(row) == len(should) and all(abs(a - b) < 1e-12 for a, b in zip(row, should)), f"random loop {turn}: {text}", f"{row}, not {should}")


def exports(c):
    request = {"system": {"form": "equations", "parameters": {"k[1:2]": [2.5, 3.5], "k_1": 70.5, "a": None}, "variables": ["x[1:2]", "x_1", "w[2,13]"],
                          "equations": ["x[1]' = k[1]*x[1] + a", "x[2]' = k[2]*x[2] + k_1", "x_1' = k_1*x_1", "w[2,13] = x[1] + x_1"]}}
    text = {language: c.code("names", request, language) for language in ("c", "python", "julia", "matlab", "casadi", "modelica", "latex", "mathml")}
    for language in ("c", "python", "julia", "matlab", "casadi", "modelica"):
        code = "\n".join(line for line in text[language].splitlines() if "P_" in line)
        said = set(re.findall(r"\bP_\w+", code))
        c.tally.check(not re.search(r"P_\w*\[", code), f"{language}: no index in an identifier", code)
        c.tally.check(not said or len(said) >= 3, f"{language}: no two parameters fall together", str(said))
    c.tally.check("x_{1}" in text["latex"] and "w_{2,13}" in text["latex"], "latex: indices are subscripts", text["latex"][:800])
    with tempfile.TemporaryDirectory() as folder:
        file = os.path.join(folder, "model.c")
        with open(file, "w", encoding="utf-8") as f:
            f.write(text["c"])
        run = subprocess.run(["gcc", "-std=c99", "-Wall", "-Werror", "-fsyntax-only", file], capture_output=True, text=True)
        c.tally.check(run.returncode == 0, "c: it compiles", run.stderr)
    try:
        compile(text["python"], "model.py", "exec")
        good = True
    except SyntaxError as e:
        good = str(e)
    c.tally.check(good is True, "python: it compiles", str(good))
    c.tally.check(c.code("sizes", HEAT, "c") != "", "c: parameters of sizes")


def bounds(c):
    """One pair for all names of a range, or a pair for each: y = 0.8 or -0.8 where x = 0.6."""
    for given, should in (({"y[1:n]": [0, None]}, [0.8, 0.8]), ({"y[1:n]": [[0, "n"], [None, 0]]}, [0.8, -0.8]), ({"y[1:1]": [0, "n"], "y[2:n]": [None, 0]}, [0.8, -0.8]),
                          ({"y[i = 1:n]": ["5 - 5*i", "10 - 5*i"]}, [0.8, -0.8]), ({"y[i = 1:n]": [["0*i", "n"], ["-n", "i - 2"]]}, [0.8, -0.8])):
        request = {"system": {"form": "equations", "sizes": {"n": 2}, "variables": ["x[1:n]", "y[1:n]"],
                              "equations": [{"for": "i = 1:n", "equation": "x[i]' = -y[i]"}, {"for": "i = 1:n", "equation": "x[i]^2 + y[i]^2 = 1"}]},
                   "want": ["consistent_initial"], "trajectory": {"initial": {"x[1:n]": "0.6", "y[1:n]": "-0.8"}, "hold": ["x[1:n]"], "bounds": given}}
        result = c.solve(f"bounds {given}", request)
        got = [result["consistent_initial"]["projected"][f"y[{i}]"] for i in (1, 2)] if result else []
        c.tally.check(result and all(abs(p - q) < 1e-12 for p, q in zip(got, should)), f"bounds {given}", str(got))


def main():
    c = Check()
    bounds(c)
    for label, request in EQUAL.items():
        c.equal(label, request)
    heat = c.solve("heat, closed form", HEAT)
    if heat:
        n, h = 4, 1 / 5
        rate = -4 / h**2 * (math.sin(math.pi * h / 2)**2 + math.sin(math.pi * h)**2)
        should = math.sin(2 * math.pi * h) * math.sin(2 * math.pi * h) * math.exp(rate / 20)
        c.tally.check(abs(heat["trajectory"]["rows"][1][1] - should) < 1e-8, "heat: the closed form", f"{heat['trajectory']['rows'][1]}, {should}")
        c.tally.check(heat["dimensions"]["final"] == n * n, "heat: the inner nodes are free", str(heat["dimensions"]))
    refusals(c)
    all_faults(c)
    random_loops(c)
    exports(c)
    families.check(c, sys.modules[__name__], EQUAL)
    return c.tally.end()


if __name__ == "__main__":
    sys.exit(main())
