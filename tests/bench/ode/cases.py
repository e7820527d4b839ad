"""The systems of the integrators' benchmark: cases.py BUILD_DIR OUT_DIR

The references of tests/cases/trajectory_reference.json, and published stiff problems. The peers get the reduction by
hand: for each system the reduced field and its Jacobian, as libsga prints them, are written as C (common parts shared,
small powers multiplied out) into OUT_DIR/fields.c, with the consistent start and the reference solution. What ours
gets is the request, one file for each system. tests/trajectory_reference.py says how the references were made."""
import json
import os
import re
import subprocess
import sys

import sympy
from sympy.printing.c import C99CodePrinter

HERE = os.path.dirname(os.path.abspath(__file__))
ROOT = os.path.dirname(os.path.dirname(os.path.dirname(HERE)))
STIFF = ("stiff", "prothero", "kaps", "robertson")
NOT_STIFF = ("kaps, index 1",)     # its limit has nothing fast left


def published():
    """F. Mazzia and C. Magherini, Test Set for Initial Value Problem Solvers, release 2.4 (2008); Hairer, Wanner,
    Solving Ordinary Differential Equations II, IV.10; the last one has a closed form (Lambert)."""
    def case(name, variables, rates, initial, stop, end, atol):
        equations = [f"{v}' = {r}" for v, r in zip(variables, rates)]
        return {"name": name, "request": {
            "system": {"form": "equations", "variables": variables, "equations": equations},
            "accuracy": {"rtol": 1e-8, "atol": 1e-8 * atol},
            "trajectory": {"start": 0, "times": [stop], "initial": dict(zip(variables, initial)), "outputs": variables}},
            "expect": {"trajectory": {"reference": [end]}}}
    y = [f"y{i}" for i in range(1, 9)]
    return [
        case("stiff van der pol", ["x", "y"], ["y", "((1 - x^2)*y - x)*10^6"], ["2", "0"], "2",
             ["1.706167732170483", "-0.8928097010247975"], 1),
        case("stiff hires", y,
             ["-1.71*y1 + 0.43*y2 + 8.32*y3 + 0.0007", "1.71*y1 - 8.75*y2", "-10.03*y3 + 0.43*y4 + 0.035*y5",
              "8.32*y2 + 1.71*y3 - 1.12*y4", "-1.745*y5 + 0.43*(y6 + y7)",
              "-280*y6*y8 + 0.69*y4 + 1.71*y5 - 0.43*y6 + 0.69*y7", "280*y6*y8 - 1.81*y7", "-280*y6*y8 + 1.81*y7"],
             ["1", "0", "0", "0", "0", "0", "0", "0.0057"], "321.8122",
             ["0.7371312573325668e-3", "0.1442485726316185e-3", "0.5888729740967575e-4", "0.1175651343283149e-2",
              "0.2386356198831331e-2", "0.6238968252742796e-2", "0.2849998395185769e-2", "0.2850001604814231e-2"], 1e-3),
        case("stiff orego", ["x", "y", "z"],
             ["77.27*(y + x*(1 - 0.000008375*x - y))", "(z - (1 + x)*y)/77.27", "0.161*(x - z)"], ["1", "2", "3"], "360",
             ["1.000814870318523", "1228.178521549917", "132.0554942846706"], 1e-3),
        case("stiff rotating", ["x", "y", "z"],
             ["-1000*(x - cos(t)) + 1000*(y - sin(t)) - sin(t)", "-1000*(x - cos(t)) - 1000*(y - sin(t)) + cos(t)",
              "-z + x - cos(t)"], ["2", "0", "1"], "3",
             ["-0.98999249660044545727", "0.14112000805986722210", "0.04981196188958866"], 1),
    ]


def systems():
    with open(os.path.join(ROOT, "tests", "cases", "trajectory_reference.json"), encoding="utf-8") as f:
        found = json.load(f)
    for case in found:
        case["name"] = case["name"].replace("reference: ", "")
    for case in found + published():
        case["stiff"] = any(w in case["name"] for w in STIFF) and case["name"] not in NOT_STIFF
        yield case


class Printer(C99CodePrinter):
    def _print_Pow(self, e):
        base, power = self.parenthesize(e.base, 1000), e.exp
        if power.is_Integer and 0 < abs(power) <= 8:
            product = "*".join([base] * abs(int(power)))
            return f"({product})" if power > 0 else f"(1.0/({product}))"
        if power.is_Rational and power.q == 2 and abs(power.p) <= 9:
            whole = (abs(power.p) - 1) // 2
            product = "*".join([f"sqrt({self._print(e.base)})"] + [base] * whole)
            return f"({product})" if power > 0 else f"(1.0/({product}))"
        return super()._print_Pow(e)


def reduced(build, case):
    """Names, projected start, and the field as SymPy expressions in x0, x1, ... and t."""
    request = {**case["request"], "want": ["vector_field", "consistent_initial"]}
    run = subprocess.run([os.path.join(build, "sga"), "solve", "/dev/stdin"], input=json.dumps(request), capture_output=True,
                         text=True, timeout=120, check=False)
    if run.returncode:
        raise RuntimeError(f"{case['name']}: {run.stdout}")
    result = json.loads(run.stdout)
    names = [v["name"] for v in result["variables"]]
    symbol = {n: sympy.Symbol(f"x[{i}]", real=True) for i, n in enumerate(names)}
    symbol["t"] = sympy.Symbol("t", real=True)

    def read(text):
        words, local = re.sub(r"[A-Za-z_][A-Za-z_0-9]*'*", lambda m: f"_{list(symbol).index(m[0])}_" if m[0] in symbol else m[0], text), {}
        for i, n in enumerate(symbol):
            local[f"_{i}_"] = symbol[n]
        return sympy.parse_expr(words.replace("^", "**"), local_dict=local, transformations=(sympy.parsing.sympy_parser.rationalize,)
                                + sympy.parsing.sympy_parser.standard_transformations)
    for n, v in (request["system"].get("parameters") or {}).items():      # the answer has them by name
        symbol[n] = read(str(v))
    for d in result.get("definitions") or []:
        symbol[d["name"]] = read(d["expression"])
    field = [read(result["vector_field"]["components"][n]) for n in names]
    start = [result["consistent_initial"]["projected"][n] for n in names]
    return names, start, field


def body(values, target):
    shared, values = sympy.cse(values, symbols=sympy.numbered_symbols("s"), optimizations="basic")
    printer = Printer()
    lines = [f"    double {s} = {printer.doprint(v)};" for s, v in shared]
    return lines + [f"    {target}[{i}] = {printer.doprint(v)};" for i, v in enumerate(values)]


def main():
    build, out = sys.argv[1:]
    text = ['/* Written by cases.py. */', '#include <math.h>', '#include "problem.h"', ""]
    table, index = [], []
    for k, case in enumerate(systems()):
        names, start, field = reduced(build, case)
        n = len(names)
        x = [sympy.Symbol(f"x[{i}]", real=True) for i in range(n)]
        slope = [sympy.diff(f, v) for f in field for v in x]
        text += [f"static void field{k}(double t, const double *x, double *dx)", "{", "    (void)t, (void)x;", *body(field, "dx"), "}", "",
                 f"static void slope{k}(double t, const double *x, double *J)", "{", "    (void)t, (void)x;", *body(slope, "J"), "}", ""]
        motion = case["request"]["trajectory"]
        reference, columns = case["expect"]["trajectory"]["reference"], motion["outputs"]
        accuracy = case["request"]["accuracy"]
        text += [f"static const double start{k}[] = {{{', '.join(map(repr, start))}}}, times{k}[] = {{{', '.join(map(str, motion['times']))}}};",
                 f"static const double reference{k}[] = {{{', '.join(repr(float(v)) for row in reference for v in row)}}};",
                 f"static const int column{k}[] = {{{', '.join(str(names.index(c)) for c in columns)}}};", ""]
        table.append(f'    {{"{case["name"]}", {int(case["stiff"])}, {n}, {len(reference)}, {len(columns)}, field{k}, slope{k}, start{k}, times{k}, '
                     f'reference{k}, column{k}, {accuracy["atol"] / accuracy["rtol"]!r}}},')
        with open(os.path.join(out, f"ode{k}.json"), "w", encoding="utf-8") as f:
            json.dump({**case["request"], "want": ["trajectory"]}, f)
        index.append(case["name"])
    text += ["const struct problem problems[] = {", *table, "};", f"const int problem_count = {len(table)};"]
    with open(os.path.join(out, "fields.c"), "w", encoding="utf-8") as f:
        f.write("\n".join(text) + "\n")


if __name__ == "__main__":
    main()
