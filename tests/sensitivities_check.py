"""Derivatives of motions by other routes: sensitivities_check.py BUILD_DIR

- closed forms, differentiated by SymPy: parameters, initial values, switches, starts that are nearest points;
- differences of motions in double-double, carried to a step of 0: every form, index 3, gauge choices, tables, kinks and jumps of field and constraints;
- the same through events that set variables, with tables, and through slides (saltation.py); requests with tables against the same written as expressions;
- double-double against double, where derivatives jump by other code; balls against closed forms, which they must hold, and against double-double;
- random systems with a multiplier; what does not depend on the order of equations; refusals, with code and place.

Differences are good to some 1e-9 in double (where motions jump or have tables), and to some 1e-13 else.
"""
import copy
import random
import sys

import mpmath as mp
import sympy

import saltation
import schemas
import slopes_at_roundings
import slopes_in_units
from solver import Solver
from tally import Tally, build_folder, scaled, seed

mp.mp.dps = 34


def system(form, **members):
    return {"form": form, **members}


def request(sys_, initial, stop, parameters=(), starts=(), accuracy=None, **trajectory):
    wanted = {k: list(v) for k, v in (("parameters", parameters), ("initial", starts)) if v}
    return {"system": sys_, "trajectory": {"stop": stop, "samples": 4, "initial": initial, "sensitivities": wanted, **trajectory},
            **({"accuracy": accuracy} if accuracy else {})}


def equations(variables, lines, parameters, **more):
    return system("equations", variables=variables, equations=lines, parameters=parameters, **more)


PENDULUM = equations(["x", "y", "lam"], ["x'' = -lam*x", "y'' = -lam*y - g", "x^2 + y^2 = L^2"], {"g": "9.81", "L": "1.2"})
RODS = equations(["x", "y", "u", "v", "p", "q"], ["x'' = -p*x - q*(x - u)", "y'' = -9.81 - p*y - q*(y - v)", "m*u'' = -q*(u - x)", "m*v'' = -m*9.81 - q*(v - y)", "x^2 + y^2 = L^2",
                                                 "(u - x)^2 + (v - y)^2 = K^2"], {"L": "1", "K": "0.8", "m": "1.5"})
DD = {"rtol": 1e-18, "arithmetic": "double-double"}
BALL = {"rtol": 1e-20, "arithmetic": "ball"}
KINKS = [["x' = v", "v' = -z", z] for z in ("z = k*x + abs(x)", "z + z^3/10 = k*x + abs(x)", "z + z^3/10 = k*sign(x)", "z = k*sign(x)")]

# label, request, whether motions of double-double can be differenced
DIFFERENCES = [
    ("index 3", request(PENDULUM, {"x": 1}, 2, ["g", "L"], ["x"]), True),
    ("index 3 in double-double", request(PENDULUM, {"x": 1}, 2, ["g", "L"], ["x"], accuracy=DD), True),
    ("index 3, fine", request(PENDULUM, {"x": 1}, 1, ["L"], accuracy={"rtol": 1e-14}), True),
    ("nearest point", request(PENDULUM, {"x": 1.1, "y": 0.2}, 2, ["L"], ["x", "y"]), True),
    ("nearest point, of which one coordinate is where it was by chance", request(PENDULUM, {"x": 1.1, "y": 0}, 1, ["L"], ["x", "y"]), True),
    ("two rods off their lengths", request(RODS, {"x": 0.8, "y": -0.5, "u": 1.5, "v": -0.8, "x'": 0.1, "y'": 0.2}, 1, ["L", "K", "m"], ["x", "v", "y'"]), True),
    ("nearest point, some of it held", request(RODS, {"x": 0.8, "y": -0.5, "u": 1.5, "v": -0.8}, 0.5, ["L", "K"], ["u", "v"], hold=["x"]), True),
    ("nearest point, given by parameters", request(RODS, {"x": "L/2", "y": "-K", "u": 1.5, "v": "-m/2"}, 0.5, ["L", "K", "m"], ["u"]), True),
    ("nearest point where a switch is", request(equations(["x", "v", "z"], ["x' = v + z", "v' = -z", "z + z^3/10 = k*x + abs(x)*v"], {"k": "1.3"}), {"x": 1, "v": 0.2, "z": 0.7}, 0.5,
                                                ["k"], ["x", "v", "z"]), False),
    ("nearest point on a surface that moves", request(equations(["x", "y", "l"], ["x' = y + x*l", "y' = -x*k + y*l", "x^2 + k*y^2 = 1 + t/10"], {"k": "1.5"}), {"x": 0.9, "y": 0.7}, 1,
                                                      ["k"], ["x", "y"]), True),
    ("a bound that the start lies on", request(PENDULUM, {"x": 1.1, "y": 0.4}, 1, ["L"], ["x"], bounds={"y": [None, "-0.3"]}), False),
    ("nearest point, fine", request(PENDULUM, {"x": 1.1, "y": 0.2}, 1, ["L"], ["x"], accuracy={"rtol": 1e-11}), True),
    ("values that are consistent, all given", request(PENDULUM, {"x": 1.2, "y": 0}, 2, ["g"], ["x", "y"]), True),
    ("initial value by a parameter", request(PENDULUM, {"x": "L/2", "x'": "g/10"}, 1, ["g", "L"]), True),
    ("lagrangian", request(system("lagrangian", coordinates=["q", "s"], parameters={"m": "1.5", "k": "2"},
                                  lagrangian="m*q'^2/2 + q'*s + s'*q^2/3 - k*q^2/2 - s^2"), {"q": 0.4}, 1, ["m", "k"], ["q"]), True),
    ("hamiltonian on a curve", request(system("hamiltonian", variables=["q1", "q2", "p1", "p2"], parameters={"k": "2"}, hamiltonian="(p1^2+p2^2)/2+k*q1^2/2+q2^4",
                                              restrict=["q1^2+k*q2^2-1"]), {"q1": 0.5, "p1": 0.3}, 1, ["k"], ["q1"]), True),
    ("mechanical, reactions", request(system("mechanical", coordinates=["x", "y"], parameters={"m": "2", "c": "0.3", "L": "1"}, masses=["m", "m"],
                                             forces=["-c*x'", "-m*9.81"], constraints=["x^2+y^2-L^2"]), {"x": 0.5}, 1, ["m", "c", "L"], ["x"],
                                      outputs=["x", "y", "reaction_x"]), True),
    ("descriptor", request(system("descriptor", states=["x", "z"], inputs=["u"], outputs=["y"], parameters={"k": "2"}, E=[[1, 0], [0, 0]], A=[["-k", 1], [1, "-k"]],
                                  B=[[1], [0]], C=[[1, 1]], D=[[0]]), {"x": 1, "u": 0.3}, 1, ["k"], ["x"], gauge={"rates": {"u": "-k*u"}}), True),
    ("least norm", request(equations(["x", "y", "z"], ["x' + k*y' = z", "z = x*y"], {"k": "1.3"}), {"x": 1, "y": 0.5}, 1, ["k"], ["x", "y"]), True),
    ("rates", request(equations(["x", "y", "z"], ["x' + k*y' = z", "z = x*y"], {"k": "1.3"}), {"x": 1, "y": 0.5}, 1, ["k"], ["x", "y"],
                      gauge={"rates": {"y": "k*t"}}), True),
    ("conditions", request(equations(["x", "y", "z"], ["x' + k*y' = z", "z = x*y"], {"k": "1.3"}), {"x": 1, "y": 0.5}, 1, ["k"], ["x"],
                           gauge={"conditions": ["y - k*x^2"]}), True),
    ("backwards", request(equations(["x", "v"], ["x' = v", "v' = -k*sin(x)"], {"k": "1.3"}), {"x": 1, "v": 0.5}, -2, ["k"], ["x", "v"]), True),
    ("stiff", request(equations(["a", "b", "c"], ["a'=-k1*a+k3*b*c", "b'=k1*a-k3*b*c-k2*b^2", "a+b+c=1"], {"k1": "0.04", "k2": "3e7", "k3": "1e4"}),
                      {"a": 1, "b": 0}, 40, ["k1", "k2", "k3"]), True),
    ("table", request(equations(["x", "z"], ["x'=-k*x+u*x^2", "z=u+k*x"], {"k": "2"}, tables={"u": {"times": [0, 1, 2, 3], "values": [0, 1, 0.5, 2]}}), {"x": 1}, 3,
                      ["k"], ["x"]), False),
    ("a step of a table beyond a switch", request(equations(["x"], ["x'=-k*x+if(u>c,1,x)"], {"k": "1", "c": "0.75"}, tables={"u": {
        "times": [0, 0.5, 1, 1, 1.5, 2], "values": [0, 1, 2, -1, 0, 1]}}), {"x": 0.5}, 2, ["k", "c"], ["x"]), False),
    ("a signal of steps", request(equations(["x"], ["x'=-k*x+if(u>0,c,x)"], {"k": "1", "c": "0.75"}, tables={"u": {
        "times": [0, 0.5, 0.5, 1, 1, 2], "values": [1, 1, 0, 0, 1, 1], "interpolation": "linear"}}), {"x": 0.5}, 2, ["k", "c"], ["x"]), False),
    ("a start in differences in double-double", request(equations(["x", "y"], ["x' = y", "x^2 + y^2 = k"], {"k": "2"}), {"x": 1, "y": 1}, 0.5, ["k"], ["x"], accuracy=DD), True),
    ("equations of the start in double-double", request(PENDULUM, {"x": "0.6", "y": -1}, 0.5, ["L", "g"], ["x"], hold=["x"], start_equations=["x*y' - y*x' = L"], accuracy=DD), True),
    ("the field jumps at a surface that moves", request(equations(["x", "v"], ["x' = v", "v' = -k*(1+x^2)*sign(x-a*cos(t))"], {"k": "1.3", "a": "0.3"}),
                                                        {"x": 1, "v": 0}, 3, ["k", "a"], ["x", "v"]), False),
    ("a constraint bends, and a force jumps", request(equations(["x", "v", "F"], ["x' = v", "v' = F - k*v", "v = 2*sin(t) + c*max(x, k)"], {"k": "0.5", "c": "0.3"}),
                                                      {"x": 0.2}, 1.5, ["k", "c"], ["x"]), False),
    ("two constraints bend", request(equations(["x", "v", "F"], ["x' = v", "v' = F - v", "v = 1 + c*abs(x - k) - min(k, 2*x)/4"], {"k": "0.5", "c": "0.3"}),
                                     {"x": -0.2}, 1.5, ["k", "c"], ["x"]), False),
    ("the field bends", request(equations(["x", "v"], ["x' = v", "v' = -k*abs(x)*x - max(x, v/2)"], {"k": "1.3"}), {"x": 1, "v": 0}, 5, ["k"], ["x"]), False),
] + [(f"a constraint with a switch {i}", request(equations(["x", "v", "z"], lines, {"k": "1.3"}), {"x": 1, "v": 0.2}, 5, ["k"], ["x", "v"]), False)
     for i, lines in enumerate(KINKS)]

T, K, A, B, L = sympy.symbols("t k a b L", positive=True)
# label, request, closed forms by output, values of k and of what is differentiated by initially
CLOSED = [
    ("decay", request(equations(["x"], ["x' = -k*x"], {"k": "0.7"}), {"x": 2}, 2, ["k"], ["x"]), [A * sympy.exp(-K * T)], {K: "0.7", A: 2}, [K, A]),
    ("logistic", request(equations(["x"], ["x' = k*x*(1-x)"], {"k": "1.7"}), {"x": 0.2}, 3, ["k"], ["x"]),
     [A * sympy.exp(K * T) / (1 - A + A * sympy.exp(K * T))], {K: "1.7", A: "0.2"}, [K, A]),
    ("oscillator on a line", request(equations(["x", "v", "z"], ["x' = v", "v' = -z", "z = k*x"], {"k": "2.5"}), {"x": 0.7, "v": -0.4}, 2, ["k"], ["x", "v"]),
     [A * sympy.cos(sympy.sqrt(K) * T) + B / sympy.sqrt(K) * sympy.sin(sympy.sqrt(K) * T),
      -A * sympy.sqrt(K) * sympy.sin(sympy.sqrt(K) * T) + B * sympy.cos(sympy.sqrt(K) * T),
      K * (A * sympy.cos(sympy.sqrt(K) * T) + B / sympy.sqrt(K) * sympy.sin(sympy.sqrt(K) * T))], {K: "2.5", A: "0.7", B: "-0.4"}, [K, A, B]),
    # from rest at a: x = 0 at t1 = sqrt(2 a/k) with v = -k t1, then up again: the field jumps there
    ("the field jumps", request(equations(["x", "v"], ["x' = v", "v' = -k*sign(x)"], {"k": "1.3"}), {"x": 1, "v": 0}, 2.4, ["k"], ["x"], outputs=["x"]),
     [sympy.Piecewise((A - K * T**2 / 2, T < sympy.sqrt(2 * A / K)),
                      (-K * sympy.sqrt(2 * A / K) * (T - sympy.sqrt(2 * A / K)) + K * (T - sympy.sqrt(2 * A / K))**2 / 2, True))], {K: "1.3", A: 1}, [K, A]),
    # the jump at t = a moves with the parameter alone
    ("a jump in time", request(equations(["x"], ["x' = 1 + 2*max(sign(t - k), 0)"], {"k": "0.9"}), {"x": 0}, 2, ["k"]),
     [T + 2 * sympy.Max(T - K, 0)], {K: "0.9"}, [K]),
    # a kink at the start that is left at once has a derivative
    ("a kink at the start", request(equations(["x"], ["x' = k + abs(x)"], {"k": "1.5"}), {"x": 0}, 1, ["k"], ["x"]), [(K + A) * sympy.exp(T) - K], {K: "1.5", A: 0}, [K, A]),
    ("conditions", request(equations(["x"], ["x' = if(t < k and x > 0, 1, -2)"], {"k": "0.9"}), {"x": 1}, 2, ["k"], ["x"]),
     [sympy.Piecewise((A + T, T < K), (A + K - 2 * (T - K), True))], {K: "0.9", A: 1}, [K, A]),
    # the start is the nearest point (a, b)/r * L, which turns with the unit speed
    ("a start that is a nearest point", request(equations(["x", "y"], ["x' = -y", "x^2 + y^2 = k^2"], {"k": "2"}), {"x": 3, "y": 1}, 1, ["k"], ["x", "y"]),
     [K * (A * sympy.cos(T) - B * sympy.sin(T)) / sympy.sqrt(A**2 + B**2), K * (A * sympy.sin(T) + B * sympy.cos(T)) / sympy.sqrt(A**2 + B**2)],
     {K: "2", A: 3, B: 1}, [K, A, B]),
    ("held, the rest follows", request(equations(["x", "y"], ["x' = -y", "x^2 + y^2 = k^2"], {"k": "2"}), {"x": "1.2", "y": 1}, 1, ["k"], ["x"], hold=["x"]),
     [A * sympy.cos(T) - sympy.sqrt(K**2 - A**2) * sympy.sin(T), A * sympy.sin(T) + sympy.sqrt(K**2 - A**2) * sympy.cos(T)], {K: "2", A: "1.2"}, [K, A]),
    ("a start in the steady state", request(equations(["x"], ["x' = 1 + 3*t - k*x"], {"k": "2"}), {}, 1, ["k"], start_equations=["x' = 0"]),
     [3 * T / K + 1 / K - 3 / K**2 + 3 / K**2 * sympy.exp(-K * T)], {K: "2"}, [K]),
    # the parameter is in the start alone
    ("a start with a speed, on a side", request(equations(["x", "y", "lam"], ["x'' = -lam*x", "y'' = -lam*y", "x^2 + y^2 = 1"], {"k": "2"}), {"x": "0.6", "y": "-0.8"}, 1, ["k"], ["x"],
                                                hold=["x"], outputs=["x", "y"], start_equations=["x*y' - y*x' = k"], bounds={"y": [0, None]}),
     [A * sympy.cos(K * T) - sympy.sqrt(1 - A**2) * sympy.sin(K * T), A * sympy.sin(K * T) + sympy.sqrt(1 - A**2) * sympy.cos(K * T)], {K: "2", A: "0.6"}, [K, A]),
]

NO_MOTION_IN_DD = ("a jump in time",)      # which ends there: no step is small enough for its tolerances
ALSO_IN_BALLS = ("index 3", "a bound that the start lies on", "two rods off their lengths", "nearest point, given by parameters", "nearest point on a surface that moves", "values that are consistent, all given",
                 "initial value by a parameter", "hamiltonian on a curve", "descriptor", "least norm", "conditions", "backwards", "table")
TURNING = equations(["x", "y", "l"], ["x' = -y + l*x", "y' = x + l*y", "x^2 + y^2 = k^2"], {"k": "2"})
ON_CIRCLE = [K * (A * sympy.cos(T) - B * sympy.sin(T)) / sympy.sqrt(A**2 + B**2), K * (A * sympy.sin(T) + B * sympy.cos(T)) / sympy.sqrt(A**2 + B**2)]
# as CLOSED; in balls, and each holds what it is said to hold
IN_BALLS = [case for case in CLOSED if case[0] in ("decay", "logistic", "oscillator on a line", "held, the rest follows", "a start in the steady state", "a start with a speed, on a side")] + [
    ("a nearest point", request(TURNING, {"x": "3", "y": "1"}, 1, ["k"], ["x", "y"], outputs=["x", "y"]), ON_CIRCLE, {K: "2", A: 3, B: 1}, [K, A, B]),
    ("a nearest point, one coordinate of which is where it was", request(TURNING, {"x": "3", "y": 0}, 1, ["k"], ["x", "y"], outputs=["x", "y"]), ON_CIRCLE, {K: "2", A: 3, B: 0}, [K, A, B]),
    ("a decimal that is not on the circle", request(TURNING, {"x": "1.2", "y": "1.6000000000000000000000000001"}, 1, ["k"], ["x", "y"], outputs=["x", "y"]), ON_CIRCLE,
     {K: "2", A: "1.2", B: "1.6000000000000000000000000001"}, [K, A, B]),
    ("a start on the circle", request(TURNING, {"x": "1.2", "y": "1.6"}, 1, ["k"], ["x"], outputs=["x", "y"]), ON_CIRCLE, {K: "2", A: "1.2", B: "1.6"}, [K, A]),
    ("a table that is a cubic", request(equations(["x"], ["x' = u - k*x"], {"k": "2"}, tables={"u": {"times": [0, 1, 2, 3], "values": [0, 1, 8, 27]}}), {"x": 1}, "5/2", ["k"], ["x"]),
     [(A + 6 / K**4) * sympy.exp(-K * T) + T**3 / K - 3 * T**2 / K**2 + 6 * T / K**3 - 6 / K**4], {K: "2", A: 1}, [K, A]),
]

CIRCLE = equations(["x", "y"], ["x' = -y", "x^2 + y^2 = k^2"], {"k": 2, "free": None})
PLAIN = equations(["x"], ["x' = -k*x"], {"k": 2, "free": None})
DECAY = equations(["x"], ["x' = -k*x"], {"k": 2})
REFUSED = [
    ("an unknown parameter", request(DECAY, {"x": 1}, 1, ["q"]), "unknown_name", "/trajectory/sensitivities/parameters/0"),
    ("a variable among the parameters", request(DECAY, {"x": 1}, 1, ["k", "x"]), "unknown_name", "/trajectory/sensitivities/parameters/1"),
    ("twice", request(DECAY, {"x": 1}, 1, ["k", "k"]), "duplicate_name", "/trajectory/sensitivities/parameters/1"),
    ("a start that is not given", request(CIRCLE | {"parameters": {"k": 2}}, {"x": 1}, 1, [], ["y"]), "missing_member", "/trajectory/sensitivities/initial/0"),
    ("an unknown variable", request(DECAY, {"x": 1}, 1, [], ["z"]), "unknown_name", "/trajectory/sensitivities/initial/0"),
    ("nothing", request(DECAY, {"x": 1}, 1), "empty_system", "/trajectory/sensitivities"),
    ("a special value", request(equations(["x", "z"], ["x' = z", "k*z = x"], {"k": 0}), {"x": 0, "z": 1}, 1, ["k"]), "not_supported", "/trajectory/sensitivities"),
    ("consistent at one value only", request(equations(["x", "y"], ["x' = y", "y = 1", "y = k"], {"k": 1}), {"x": 0}, 1, ["k"]), "no_motion", "/trajectory/sensitivities"),
    ("a start on a kink", request(equations(["x", "y"], ["x' = 1", "y = abs(x)"], {"k": 1}), {"x": 0, "y": 0}, 1, [], ["x"]), "inconsistent_initial", "/trajectory/initial"),
    ("a start where the field jumps", request(equations(["x"], ["x' = 1 + step(x)"], {"k": 1}), {"x": 0}, 1, [], ["x"]), "inconsistent_initial", "/trajectory/initial"),
    ("a start at rest on a kink", request(equations(["x"], ["x' = abs(x)"], {"k": 1}), {"x": 0}, 1, [], ["x"]), "inconsistent_initial", "/trajectory/initial"),
    ("a start at the middle of a circle", request(PENDULUM, {"x": 0, "y": 0}, 1, ["L"], ["x"]), "inconsistent_initial", "/trajectory/initial"),
]


def at(row, column):
    value = row[column]
    return None if value is None else mp.mpf(getattr(value, "text", repr(value)))


class Check:
    def __init__(self):
        self.tally, self.solver, self.schema = Tally("sensitivities"), Solver(build_folder()), schemas.validator("result")

    def motion(self, label, ask):
        result, problem = self.solver.solve(ask)
        if not self.tally.check(result is not None, label, str(problem)):
            return None
        fault = schemas.faults(self.schema, result)
        self.tally.check(not fault, f"{label}: schema", fault)
        return result["trajectory"]

    def compare(self, label, t, expected, own=0):
        """expected[row][column], columns of the sensitivities without time; own: what these may be off by."""
        s, worst, size = t["sensitivities"], mp.mpf(0), mp.mpf(0)
        if not self.tally.check(len(s["rows"]) == len(expected) and s["ended"] is None, f"{label}: rows", str(s["ended"])):
            return
        for row, right in zip(s["rows"], expected):
            for k, value in enumerate(right):
                off, told = abs(at(row, k + 1) - value), s["column_errors"][k]
                allowed = 8 * mp.mpf(told) + own * (1 + abs(value)) + mp.mpf(10)**-14 * (s["arithmetic"] == "double")
                self.tally.check(off <= allowed, f"{label}: {s['columns'][k + 1]} at {row[0]}", f"{mp.nstr(at(row, k + 1), 18)}, not {mp.nstr(value, 18)}: told {told}")
                worst, size = max(worst, off), max(size, abs(value))
        self.tally.check(worst <= mp.mpf("1e-5") * (1 + size), f"{label}: all in all", mp.nstr(worst, 5))

    def closed(self, label, ask, forms, values, by):
        t = self.motion(label, ask)
        if not t:
            return
        values = {k: sympy.Rational(str(v)) for k, v in values.items()}
        slopes = [sympy.diff(f, v).subs(values) for f in forms for v in by]
        stop, last = sympy.Rational(str(ask["trajectory"]["stop"])), ask["trajectory"]["samples"] - 1      # in longer numbers times are exact
        times = [stop * i / last if "accuracy" in ask else sympy.Rational(row[0]) for i, row in enumerate(t["sensitivities"]["rows"])]
        expected = [[mp.mpf(sympy.N(s.subs(T, time), 34)) for s in slopes] for time in times]
        self.compare(label, t, expected)

    def in_balls(self, label, ask, forms, values, by):
        t = self.motion(label, {**ask, "accuracy": BALL})
        if not t:
            return
        s, values = t["sensitivities"], {k: sympy.Rational(str(v)) for k, v in values.items()}
        slopes = [sympy.diff(f, v).subs(values) for f in forms for v in by]
        self.tally.check(s["arithmetic"] == "ball" and len(s["rows"]) == len(t["rows"]) == 4 and s["accuracy_reached"], f"{label}: all rows", str(s["ended"]))
        with mp.workdps(80):
            for row, radii, time in zip(s["rows"], s["radii"], (0, 1, 2, 3)):
                when = sympy.Rational(str(ask["trajectory"]["stop"])) * time / 3
                for k, f in enumerate(slopes):
                    off = abs(mp.mpf(getattr(row[k + 1], "text", repr(row[k + 1]))) - mp.mpf(sympy.N(f.subs(T, when), 80)))
                    self.tally.check(off <= radii[k], f"{label}: the ball of {s['columns'][k + 1]} at {row[0]}", f"{mp.nstr(off, 5)}, radius {radii[k]}")

    def moved(self, ask, kind, name, step):
        own = copy.deepcopy(ask)
        where = own["system"]["parameters"] if kind == "p" else own["trajectory"]["initial"]
        where[name] = mp.nstr(mp.mpf(str(where[name])) + step, 32)
        return self.solver.solve(own)[0]

    def differences(self, label, ask, longer, step="2e-3", own="3e-9"):
        t = self.motion(label, ask)
        if not t:
            return
        base, asked = copy.deepcopy(ask), ask["trajectory"]["sensitivities"]
        del base["trajectory"]["sensitivities"]
        base["accuracy"] = {"rtol": 1e-20, "arithmetic": "double-double"} if longer else {"rtol": 1e-13, "arithmetic": "double"}
        columns, names = len(t["columns"]) - 1, [("p", k) for k in asked.get("parameters", [])] + [("i", k) for k in asked.get("initial", [])]
        expected = [[None] * (columns * len(names)) for _ in t["rows"]]
        for d, (kind, name) in enumerate(names):
            value = mp.mpf(str((base["system"]["parameters"] if kind == "p" else base["trajectory"]["initial"])[name]))
            h = (mp.mpf("1e-5") if longer else mp.mpf(step)) * (abs(value) or 1)
            motions = [self.moved(base, kind, name, step * h) for step in (-2, -1, 1, 2)]
            if not self.tally.check(all(motions), f"{label}: motions beside it, by {name}"):
                return
            for i, rows in enumerate(zip(*(m["trajectory"]["rows"] for m in motions))):
                for k in range(columns):
                    a, b, c, e = (at(row, k + 1) for row in rows)
                    expected[i][k * len(names) + d] = (8 * (c - b) - (e - a)) / (12 * h)
        size = max(abs(v) for row in expected for v in row)
        self.compare(label, t, expected, mp.mpf("1e-11" if longer else own) * (1 + size))

    def same(self, label, one, two):
        """Two requests that say the same: columns of motion and derivatives agree to what is told of both."""
        one, two = (self.motion(label, {**ask, "limits": {"seconds": 300}}) for ask in (one, two))
        if not one or not two or not self.tally.check("sensitivities" in one and "sensitivities" in two, f"{label}: there are derivatives"):
            return
        parts = (("the motion", one, two), ("derivatives", one["sensitivities"], two["sensitivities"]))
        for what, a, b in parts:
            self.tally.check(len(a["rows"]) == len(b["rows"]) and (a["ended"] is None) == (b["ended"] is None), f"{label}: ends of {what}", f"{a['ended']}, {b['ended']}")
            for r, q, e, f in zip(a["rows"], b["rows"], a["errors"], b["errors"]):
                off = max(abs(at(r, k) - at(q, k)) / (1 + abs(at(q, k))) for k in range(len(r)))
                self.tally.check(off <= 4 * (e + f) + 1e-13, f"{label}: {what} at {r[0]}", f"{off}, told {e} and {f}")

    def order(self, label, ask):
        """The same in another order of equations and variables."""
        other = copy.deepcopy(ask)
        other["system"]["equations"].reverse()
        other["system"]["variables"].reverse()
        one, two = self.motion(label, ask), self.motion(label, other)
        if not one or not two:
            return
        one, two = one["sensitivities"], two["sensitivities"]
        for k, name in enumerate(one["columns"]):
            m = two["columns"].index(name)
            off = max(abs(a[k] - b[m]) for a, b in zip(one["rows"], two["rows"]))
            self.tally.check(k == 0 or off <= 10 * (one["column_errors"][k - 1] + two["column_errors"][m - 1]) + 1e-13, f"{label}: {name} in another order", str(off))

    def random(self, n):
        """x' = f(x) + J^T lam on a sphere of radius k."""
        rng = random.Random(n)
        names = [f"x{i}" for i in range(rng.randint(2, 4))]
        lines = []
        for i, x in enumerate(names):
            terms = [f"{rng.choice(['a', 'b', rng.randint(-3, 3)])}*{rng.choice(['sin', 'cos', 'exp', 'atan'])}({y}/2)" for y in rng.sample(names, 2)]
            lines.append(f"{x}' = {' + '.join(terms)} + {x}*lam")
        lines.append(" + ".join(f"{x}^2" for x in names) + " = k^2")
        start = {x: round(rng.uniform(0.2, 1), 3) for x in names}
        given = names if rng.random() < 0.3 else names[:-1]
        k = sum(v * v for v in start.values())**0.5 * (1 if len(given) < len(names) else 1.1)
        ask = request(equations(names + ["lam"], lines, {"a": "0.7", "b": "-1.2", "k": f"{k:.6f}"}), {x: start[x] for x in given}, 1, ["a", "k"], given[:1])
        self.differences(f"random {n}", ask, True)
        if n % 2:
            self.same(f"random {n}, balls and double-double", {**ask, "accuracy": BALL}, {**ask, "accuracy": DD})
        self.order(f"random {n}", ask)

    def random_rods(self, n):
        """A chain of rods from a start that is off their lengths: what is told of the start's own error is no more than it has."""
        rng = random.Random(n)
        points = [("0", "0")] + [(f"x{i}", f"y{i}") for i in range(rng.randint(1, 3))]
        force, mass = {}, {}
        for i, (x, y) in enumerate(points[1:]):
            mass[x] = mass[y] = rng.choice(["1", "m", "1/2"])
            force[x], force[y] = [f"-f{i}*({x} - {points[i][0]})"], ["-3", f"-f{i}*({y} - {points[i][1]})"]
            if i:
                force[points[i][0]].append(f"-f{i}*({points[i][0]} - {x})")
                force[points[i][1]].append(f"-f{i}*({points[i][1]} - {y})")
        lines = [f"{mass[c]}*{c}'' = {' '.join(f if f[0] == '-' else '+' + f for f in force[c])}" for c in force]
        lines += [f"({x} - {points[i][0]})^2 + ({y} - {points[i][1]})^2 = {rng.choice(['L', 'L*m', '1'])}^2" for i, (x, y) in enumerate(points[1:])]
        start, at = {}, [0.0, 0.0]
        for x, y in points[1:]:
            at = [at[0] + rng.uniform(0.3, 0.9), at[1] - rng.uniform(0.3, 0.9)]
            start |= {x: round(at[0], 3), y: round(at[1], 3)}
        start |= {f"{c}'": round(rng.uniform(-0.3, 0.3), 3) for c in rng.sample(list(start), rng.randint(0, len(start)))}
        ask = request(equations(list(force) + [f"f{i}" for i in range(len(points) - 1)], lines, {"L": "1.1", "m": "0.9"}), start, 0.6, ["L", "m"], rng.sample(list(start), 2), outputs=list(force))
        self.differences(f"rods {n}", ask, True)
        if n % 2 and len(points) < 4:
            self.same(f"rods {n}, balls and double-double", {**ask, "accuracy": BALL}, {**ask, "accuracy": DD})
        t = self.motion(f"rods {n}", ask)
        s = t["sensitivities"] if t else {"start": None, "column_errors": [0]}
        self.tally.check(s["start"] == "solved" and max(s["column_errors"]) < 1e-5, f"rods {n}: errors are small", str((s["start"], max(s["column_errors"]))))

    def ended(self, label, ask, when, words):
        """Derivatives end with their reason, and the motion goes on."""
        t = self.motion(label, ask)
        if not t:
            return
        s = t["sensitivities"]
        if words is None:
            self.tally.check(s["ended"] is None and len(s["rows"]) == len(t["rows"]) and all(v is not None for v in s["rows"][-1]), f"{label}: they do not end", str(s["ended"]))
        else:
            self.tally.check(s["ended"] and s["ended"]["reason"] == "not_smooth" and words in s["ended"]["detail"], f"{label}: the reason", str(s["ended"]))
            self.tally.check(s["ended"] and abs(s["ended"]["t"] - when) < 1e-6 and all(r[0] <= when for r in s["rows"]) and len(s["rows"]) < len(t["rows"]), f"{label}: when", str(s["ended"]))

    def random_jumps(self, n, what, draw):
        """Where an event, or an end of a slide, is too near to a sample for differences nothing is checked."""
        ask = draw(random.Random(n))
        result, problem = self.solver.solve(ask)
        t = result and result["trajectory"]
        if not self.tally.check(t, f"random {what} {n}", str(problem)):
            return
        s = t["sensitivities"]
        size = max([abs(float(v)) for r in s["rows"] for v in r if v is not None], default=0)
        times = [e["t"] for e in t.get("events", [])] + [w for s_ in t.get("slides", []) for w in (s_["from"], s_["to"]) if w is not None]
        near = min([abs(float(w) - float(r[0])) / (1 + size) for w in times for r in t["rows"]], default=1)
        if near > 1e-9:
            self.same(f"random {what} {n}, double-double against double", {**ask, "accuracy": DD}, ask)
        if s["ended"] is None and t["ended"] is None and near > 5e-4 and size < 1e4:
            self.differences(f"random {what} {n}", ask, False, "2e-4", "1e-6")

    def random_switches(self, n):
        """Fields, and constraints of index 1, with switches whose surfaces move: double-double against double, where derivatives jump by other code, and against differences."""
        rng = random.Random(n)
        p = {"k": f"{rng.uniform(0.8, 2):.3f}", "c": f"{rng.uniform(0.1, 0.4):.3f}", "a": f"{rng.uniform(-0.3, 0.3):.3f}"}
        surface = rng.choice(["x - a", "v - a", "x + v/3 - a*cos(t)", "x - a*t"])
        switch = rng.choice([f"c*sign({surface})", f"c*step({surface})*x", f"c*abs({surface})", f"max(c*({surface}), x/5)", f"if({surface} > 0, c, v/4)"])
        lines, variables = [f"x' = v", f"v' = -k*x - {switch} + sin(2*t)"], ["x", "v"]
        if rng.random() < 0.4:
            lines, variables = ["x' = v", "v' = -z + sin(2*t)", f"z + z^3/9 = k*x + {switch}"], ["x", "v", "z"]
        ask = request(equations(variables, lines, p), {"x": round(rng.uniform(0.5, 1), 3), "v": round(rng.uniform(0.2, 0.6), 3)}, round(rng.uniform(2, 4), 3), ["k", "c", "a"], ["x"])
        result, problem = self.solver.solve(ask)
        if not self.tally.check(result is not None, f"random switches {n}", str(problem)):
            return
        if result["trajectory"]["ended"] is None and result["trajectory"]["sensitivities"]["ended"] is None:      # it does not slide
            self.same(f"random switches {n}, double-double against double", {**ask, "accuracy": DD}, ask)
            if n % 3 == 0:
                self.differences(f"random switches {n}", ask, False, "5e-5", "1e-6")

    def refused(self, label, ask, code, pointer):
        result, problem = self.solver.solve(ask)
        self.tally.check(result is None and (problem["code"], problem.get("pointer")) == (code, pointer), f"{label}: refused", str(problem or "an answer"))


def main():
    check = Check()
    for case in CLOSED:
        check.closed(*case)
    for case in DIFFERENCES:
        check.differences(*case)
    for case in IN_BALLS:
        check.in_balls("balls: " + case[0], *case[1:])
    for label, ask, *rest in CLOSED:
        if label not in NO_MOTION_IN_DD:
            check.closed(f"{label}, in double-double", {**ask, "accuracy": DD}, *rest)
    for label, ask, longer in DIFFERENCES:
        if not longer:
            check.same(f"double-double against double: {label}", {**ask, "accuracy": DD}, ask)
    for label, ask, _ in DIFFERENCES:
        if label in ALSO_IN_BALLS:
            check.same(f"balls and double-double: {label}", {**ask, "accuracy": BALL}, {**ask, "accuracy": DD})
    for case in saltation.CLOSED + saltation.SLIDES_CLOSED:
        check.closed(*case)
    for label, ask, *rest in saltation.CLOSED:
        check.closed(f"{label}, in double-double", {**ask, "accuracy": DD}, *rest)
        check.closed(f"{label}, in balls", {**ask, "accuracy": BALL}, *rest)
    for label, ask in saltation.DIFFERENCES:
        ask = saltation.FINE_STARTS.get(label, ask)
        check.same(f"double-double against double: {label}", {**ask, "accuracy": DD}, ask)
        check.same(f"balls and double-double: {label}", {**ask, "accuracy": BALL}, {**ask, "accuracy": DD})
    for label, ask, *rest in saltation.SLIDES_CLOSED:
        check.closed(f"{label}, in double-double", {**ask, "accuracy": DD}, *rest)
        check.closed(f"{label}, in balls", {**ask, "accuracy": BALL}, *rest)
    for label, ask in saltation.SLIDES:
        check.same(f"double-double against double: {label}", {**ask, "accuracy": DD}, ask)
        check.same(f"balls and double-double: {label}", {**ask, "accuracy": BALL}, {**ask, "accuracy": DD})
    for label, ask in saltation.DIFFERENCES + saltation.SLIDES:
        check.differences(label, ask, False, "5e-4")
    for case in saltation.ENDED:
        check.ended(*case)
    for case in REFUSED + saltation.REFUSED + saltation.STUCK:
        check.refused(*case)
    first = seed(18)
    for n in range(scaled(8)):
        check.random(first + n)
        check.random_rods(first + n)
        check.random_switches(first + n)
    for n in range(scaled(16)):
        check.random_jumps(first + n, "jumps", saltation.random_case)
        check.random_jumps(first + n, "slides", saltation.random_slide)
        label, ask, _ = saltation.random_table(random.Random(first + n))
        check.same(f"{label} {first + n}, double-double against double", {**ask, "accuracy": DD}, ask)
        check.same(*(f"random tables {first + n}: {part}" if i == 0 else part for i, part in enumerate(saltation.random_table(random.Random(first + n)))))
    slopes_in_units.check(check.tally, check.solver, 125 + first, scaled(24))
    slopes_at_roundings.check(check.tally, check.solver)
    return check.tally.end()


if __name__ == "__main__":
    sys.exit(main())
