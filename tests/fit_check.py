"""Fits by other routes: fit_check.py BUILD_DIR

- nonlinear reference problems of NIST's Statistical Reference Datasets (StRD, https://www.itl.nist.gov/div898/strd/) with their certified values, written as
  equations and as differential equations, from both of NIST's starts: a fit that says it converged has NIST's values (or says which it does not tell);
- SciPy's least_squares on solve_ivp: experiments of their own starts, weights, missing data, bounds, unknown initial values;
- data over the bounces of a ball, and over the modes of a converter; over the slides of a mass with dry friction (the closed form, until it sticks), of two experiments at once;
- a pendulum with a multiplier: g and its length from positions; what data cannot tell; refusals, with code and place.
"""
import json
import math
import random
import sys

import numpy as np
import sympy
from scipy.integrate import solve_ivp
from scipy.optimize import least_squares

import saltation
import schemas
from solver import Solver
from tally import Tally, build_folder, seed

MISRA = dict(y=[10.07,14.73,17.94,23.93,29.61,35.18,40.02,44.82,50.76,55.05,61.01,66.40,75.47,81.78],x=[77.6,114.9,141.1,190.8,239.9,289.0,332.8,378.4,434.8,477.3,536.8,593.1,689.1,760.0])
NIST = {
"Misra1a":dict(MISRA, f="b1*(1-exp(-b2*t))",s=[[500,1e-4],[250,5e-4]],b=[2.3894212918E+02,5.5015643181E-04],e=[2.7070075241E+00,7.2668688436E-06],r=1.2455138894E-01),
"Misra1b":dict(MISRA, f="b1*(1-(1+b2*t/2)^(-2))",s=[[500,1e-4],[300,2e-4]],b=[3.3799746163E+02,3.9039091287E-04],e=[3.1643950207E+00,4.2547321834E-06],r=7.5464681533E-02),
"Misra1c":dict(MISRA, f="b1*(1-(1+2*b2*t)^(-1/2))",s=[[500,1e-4],[600,2e-4]],b=[6.3642725809E+02,2.0813627256E-04],e=[4.6638326572E+00,1.7728423155E-06],r=4.0966836971E-02),
"Misra1d":dict(MISRA, f="b1*b2*t/(1+b2*t)",s=[[500,1e-4],[450,3e-4]],b=[4.3736970754E+02,3.0227324449E-04],e=[3.6489174345E+00,2.9334354479E-06],r=5.6419295283E-02),
"BoxBOD":dict(x=[1,2,3,5,7,10],y=[109,149,149,191,213,224],f="b1*(1-exp(-b2*t))",s=[[1,1],[100,0.75]],b=[2.1380940889E+02,5.4723748542E-01],e=[1.2354515176E+01,1.0455993237E-01],r=1.1680088766E+03),
"Rat42":dict(y=[8.930,10.800,18.590,22.330,39.350,56.110,61.730,64.620,67.080],x=[9,14,21,28,42,57,63,70,79],f="b1/(1+exp(b2-b3*t))",s=[[100,1,0.1],[75,2.5,0.07]],b=[7.2462237576E+01,2.6180768402E+00,6.7359200066E-02],e=[1.7340283401E+00,8.8295217536E-02,3.4465663377E-03],r=8.0565229338E+00),
"DanWood":dict(x=[1.309,1.471,1.490,1.565,1.611,1.680],y=[2.138,3.421,3.597,4.340,4.882,5.660],f="b1*t^b2",s=[[1,5],[0.7,4]],b=[7.6886226176E-01,3.8604055871E+00],e=[1.8281973860E-02,5.1726610913E-02],r=4.3173084083E-03),
"Eckerle4":dict(y=[0.0001575,0.0001699,0.0002350,0.0003102,0.0004917,0.0008710,0.0017418,0.0046400,0.0065895,0.0097302,0.0149002,0.0237310,0.0401683,0.0712559,0.1264458,0.2073413,0.2902366,0.3445623,0.3698049,0.3668534,0.3106727,0.2078154,0.1164354,0.0616764,0.0337200,0.0194023,0.0117831,0.0074357,0.0022732,0.0008800,0.0004579,0.0002345,0.0001586,0.0001143,0.0000710],
 x=[400,405,410,415,420,425,430,435,436.5,438,439.5,441,442.5,444,445.5,447,448.5,450,451.5,453,454.5,456,457.5,459,460.5,462,463.5,465,470,475,480,485,490,495,500],f="b1/b2*exp(-((t-b3)/b2)^2/2)",s=[[1,10,500],[1.5,5,450]],b=[1.5543827178E+00,4.0888321754E+00,4.5154121844E+02],e=[1.5408051163E-02,4.6803020753E-02,4.6800518816E-02],r=1.4635887487E-03),
"Rat43":dict(x=list(range(1,16)),y=[16.08,33.83,65.80,97.20,191.55,326.20,386.87,520.53,590.03,651.92,724.93,699.56,689.96,637.56,717.41],f="b1/(1+exp(b2-b3*t))^(1/b4)",s=[[100,10,1,1],[700,5,0.75,1.3]],b=[6.9964151270E+02,5.2771253025E+00,7.5962938329E-01,1.2792483859E+00],e=[1.6302297817E+01,2.0828735829E+00,1.9566123451E-01,6.8761936385E-01],r=8.7864049080E+03),
"MGH09":dict(x=[4,2,1,.5,.25,.167,.125,.1,.0833,.0714,.0625],y=[.1957,.1947,.1735,.16,.0844,.0627,.0456,.0342,.0323,.0235,.0246],f="b1*(t^2+t*b2)/(t^2+t*b3+b4)",s=[[25,39,41.5,39],[0.25,0.39,0.415,0.39]],b=[1.9280693458E-01,1.9128232873E-01,1.2305650693E-01,1.3606233068E-01],e=[1.1435312227E-02,1.9633220911E-01,8.0842031232E-02,9.0025542308E-02],r=3.0750560385E-04),
"MGH10":dict(x=list(range(50,130,5)),y=[34780,28610,23650,19630,16370,13720,11540,9744,8261,7030,6005,5147,4427,3820,3307,2872],f="b1*exp(b2/(t+b3))",s=[[2,400000,25000],[0.02,4000,250]],b=[5.6096364710E-03,6.1813463463E+03,3.4522363462E+02],e=[1.5687892471E-04,2.3309021107E+01,7.8486103508E-01],r=8.7945855171E+01),
"MGH17":dict(x=list(range(0,330,10)),y=[0.844,0.908,0.932,0.936,0.925,0.908,0.881,0.850,0.818,0.784,0.751,0.718,0.685,0.658,0.628,0.603,0.580,0.558,0.538,0.522,0.506,0.490,0.478,0.467,0.457,0.448,0.438,0.431,0.424,0.420,0.414,0.411,0.406],f="b1+b2*exp(-t*b4)+b3*exp(-t*b5)",s=[[50,150,-100,1,2],[0.5,1.5,-1,0.01,0.02]],b=[3.7541005211E-01,1.9358469127E+00,-1.4646871366E+00,1.2867534640E-02,2.2122699662E-02],e=[2.0723153551E-03,2.2031669222E-01,2.2175707739E-01,4.4861358114E-04,8.9471996575E-04],r=5.4648946975E-05),
"Thurber":dict(y=[80.574,84.248,87.264,87.195,89.076,89.608,89.868,90.101,92.405,95.854,100.696,101.060,401.672,390.724,567.534,635.316,733.054,759.087,894.206,990.785,1090.109,1080.914,1122.643,1178.351,1260.531,1273.514,1288.339,1327.543,1353.863,1414.509,1425.208,1421.384,1442.962,1464.350,1468.705,1447.894,1457.628],x=[-3.067,-2.981,-2.921,-2.912,-2.840,-2.797,-2.702,-2.699,-2.633,-2.481,-2.363,-2.322,-1.501,-1.460,-1.274,-1.212,-1.100,-1.046,-0.915,-0.714,-0.566,-0.545,-0.400,-0.309,-0.109,-0.103,0.010,0.119,0.377,0.790,0.963,1.006,1.115,1.572,1.841,2.047,2.200],f="(b1+b2*t+b3*t^2+b4*t^3)/(1+b5*t+b6*t^2+b7*t^3)",s=[[1000,1000,400,40,0.7,0.3,0.03],[1300,1500,500,75,1,0.4,0.05]],b=[1.2881396800E+03,1.4910792535E+03,5.8323836877E+02,7.5416644291E+01,9.6629502864E-01,3.9797285797E-01,4.9727297349E-02],e=[4.6647963344E+00,3.9571156086E+01,2.8698696102E+01,5.5675370270E+00,3.1333340687E-02,1.4984928198E-02,6.5842344623E-03],r=5.6427082397E+03),
}

# The same models as differential equations: variables, equations, initial values at `start`
ODES = {
    "Misra1a": (["y"], ["y' = b2*(b1 - y)"], {"y": 0}, 0),
    "BoxBOD": (["y"], ["y' = b2*(b1 - y)"], {"y": 0}, 0),
    "Rat42": (["y"], ["y' = b3*y*(1 - y/b1)"], {"y": "b1/(1 + exp(b2))"}, 0),
    "DanWood": (["y"], ["t*y' = b2*y"], {"y": "b1"}, 1),
    "MGH17": (["y", "u", "v"], ["u' = -b4*u", "v' = -b5*v", "y = b1 + u + v"], {"u": "b2", "v": "b3"}, 0),
    "Misra1d": (["y", "s"], ["y' = b1*b2/s^2", "s = 1 + b2*t"], {"y": 0}, 0),
}


def equations(variables, lines, parameters):
    return {"form": "equations", "variables": variables, "equations": lines, "parameters": parameters}


DECAY = equations(["x"], ["x' = -k*x"], {"k": None})
DATA = {"times": [1, 2], "columns": {"x": [0.5, 0.2]}}


def ask(fit, system=DECAY, trajectory=None, **more):
    return {"system": system, "trajectory": trajectory or {"initial": {"x": 1}}, "fit": fit, **more}


REFUSED = [
    ("unknown parameter", ask({"parameters": {"q": 1}, "data": DATA}), "unknown_name", "/fit/parameters/q"),
    ("no guess", ask({"parameters": {"k": {}}, "data": DATA}), "missing_member", "/fit/parameters/k"),
    ("a guess outside", ask({"parameters": {"k": {"guess": 3, "bounds": [0, 2]}}, "data": DATA}), "invalid_request", "/fit/parameters/k"),
    ("bounds the wrong way", ask({"parameters": {"k": {"guess": 3, "bounds": [4, 2]}}, "data": DATA}), "invalid_request", "/fit/parameters/k/bounds"),
    ("nothing to find", ask({"data": DATA}), "empty_system", "/fit"),
    ("no data", ask({"parameters": {"k": 1}}), "missing_member", "/fit"),
    ("an output that is no expression", ask({"parameters": {"k": 1}, "data": {"times": [1], "columns": {"x+": [1]}}}), "expression_syntax", "/fit/data/columns/x+"),
    ("an unknown output", ask({"parameters": {"k": 1}, "data": {"times": [1], "columns": {"z": [1]}}}), "unknown_name", "/fit/data/columns/z"),
    ("too few values", ask({"parameters": {"k": 1}, "data": {"times": [1, 2], "columns": {"x": [1]}}}), "invalid_request", "/fit/data/columns/x"),
    ("both sides of the start", ask({"parameters": {"k": 1}, "data": {"times": [1, -1], "columns": {"x": [1, 2]}}}), "invalid_request", "/fit/data/times/1"),
    ("all missing", ask({"parameters": {"k": 1}, "data": {"times": [1], "columns": {"x": [None]}}}), "invalid_request", "/fit/data"),
    ("a weight of no data", ask({"parameters": {"k": 1}, "data": DATA, "weights": {"y": 2}}), "unknown_name", "/fit/weights/y"),
    ("a negative weight", ask({"parameters": {"k": 1}, "data": DATA, "weights": {"x": -2}}), "invalid_request", "/fit/weights/x"),
    ("no guess of an initial value", ask({"initial": ["x"], "data": DATA}, equations(["x"], ["x' = -x"], {}), {"start": 0}), "missing_member", "/fit/data"),
    ("data beyond the motion", ask({"parameters": {"k": 1}, "data": {"times": [0.5, 3], "columns": {"x": [2, 3]}}}, equations(["x"], ["x' = k*x^2"], {"k": None})), "no_motion", "/fit/data"),
    ("an output that is not determined", ask({"parameters": {"k": 1}, "data": DATA}, equations(["x", "u"], ["x' = -k*x + u"], {"k": None})), "inputs_mismatch", "/fit/data"),
    ("inconsistent", ask({"parameters": {"k": 1}, "data": DATA}, equations(["x"], ["x' = 1", "x = k"], {"k": None})), "no_motion", "/fit/parameters"),
    ("wanted and not said", {"system": equations(["x"], ["x' = -x"], {}), "want": ["fit"]}, "missing_member", ""),
    ("a trajectory without values", ask({"parameters": {"k": 1}, "data": DATA}, trajectory={"stop": 1, "initial": {"x": 1}}, want=["fit", "trajectory"]), "invalid_request", "/system/parameters/k"),
    ("balls", ask({"parameters": {"k": 1}, "data": DATA}, accuracy={"arithmetic": "ball"}), "not_supported", "/accuracy/arithmetic"),
]


class Check:
    def __init__(self):
        self.tally, self.solver, self.schema = Tally("fit"), Solver(build_folder(), number=float), schemas.validator("result")

    def fit(self, label, request):
        result, problem = self.solver.solve(request)
        if not self.tally.check(result is not None, label, str(problem)):
            return None
        fault = schemas.faults(self.schema, result)
        self.tally.check(not fault, f"{label}: schema", fault)
        return result["fit"]

    def near(self, label, got, right, within):
        self.tally.check(got is not None and abs(got - right) <= within * abs(right), label, f"{got}, not {right}")

    def certified(self, label, f, p, within=1e-7):
        for k, (b, e) in enumerate(zip(p["b"], p["e"])):
            one = f["parameters"][f"b{k + 1}"]
            self.near(f"{label}: b{k + 1}", one["value"], b, within)
            self.near(f"{label}: its standard error", one["standard_error"], e, 10 * within)
        self.near(f"{label}: residual", f["residual"], p["r"], within)
        self.near(f"{label}: standard deviation", f["residual_standard_deviation"], math.sqrt(p["r"] / (len(p["x"]) - len(p["b"]))), within)

    def nist(self, name, p):
        # NIST's certified values are those that another implementation finds in the data as they stand here
        b = sympy.symbols([f"b{i + 1}" for i in range(len(p["b"]))])
        t = sympy.Symbol("t")
        model = sympy.sympify(p["f"].replace("^", "**"), locals={str(s): s for s in b} | {"t": t})
        value, slopes, x = sympy.lambdify([t] + b, model), [sympy.lambdify([t] + b, model.diff(s)) for s in b], np.array(p["x"], float)
        own = least_squares(lambda v: value(x, *v) - np.array(p["y"]), p["s"][1], jac=lambda v: np.array([np.broadcast_to(g(x, *v), x.shape) for g in slopes]).T,
                            method="lm", x_scale="jac", xtol=1e-15, ftol=1e-15, gtol=1e-15, max_nfev=10000)
        self.tally.check(max(abs(own.x / p["b"] - 1)) < 1e-7 and abs(2 * own.cost / p["r"] - 1) < 1e-9, f"{name}: the data are NIST's", str(own.x))
        names = [str(s) for s in b]
        forms = [("equation", (["y"], ["y = " + p["f"]], {}, min(p["x"])))] + ([("differential equation", ODES[name])] if name in ODES else [])
        for what, (variables, lines, initial, start) in forms:
            for i, guess in enumerate(p["s"]):
                label = f"{name}, {what}, start {i + 1}"
                f = self.fit(label, {"system": equations(variables, lines, dict.fromkeys(names)), "trajectory": {"start": start, "initial": initial},
                                     "fit": {"parameters": dict(zip(names, ({"guess": g} for g in guess))), "data": {"times": p["x"], "columns": {"y": p["y"]}}}})
                if not f:
                    continue
                self.tally.check(f["observations"] == len(x) and len(f["trajectory"]["rows"]) == len(x), f"{label}: rows")
                if f["converged"] and len(f["identifiable"]) == len(names):
                    self.certified(label, f, p)
                else:       # the first starts are far, some of them too far
                    self.tally.check(i == 0 and name in {"BoxBOD", "MGH10", "MGH17"} and any(v["value"] is None for v in f["parameters"].values()), f"{label}: found", json.dumps(f)[:600])

    def scipy(self, n):
        """Two experiments with starts of their own, one of them unknown, weights, missing values, a parameter in an algebraic equation."""
        rng = random.Random(n)
        a, c, starts = 0.8, 0.3, [(1.0, 0.5), (0.4, 1.2)]
        rates = lambda t, s, p: [s[0] * (p[0] - s[1]), s[1] * (p[1] * s[0] - 1)]
        times = [[round(0.4 * i + 0.1 * e, 3) for i in range(1, 11)] for e in range(2)]
        run = lambda s, p, ts: solve_ivp(rates, (0, max(ts)), s, t_eval=ts, args=(p,), rtol=1e-11, atol=1e-12, method="DOP853").y
        y = [[[v + rng.gauss(0, 0.02) for v in row] for row in run(s, (a, c), ts)] for s, ts in zip(starts, times)]
        weights = [[round(rng.uniform(0.5, 3), 2) for _ in range(10)] for _ in range(2)]
        y[0][0][3] = y[1][1][7] = None
        low = 0.9 if n % 3 == 0 else -math.inf      # sometimes the bound counts
        request = {"system": equations(["u", "v", "w"], ["u' = u*(a - v)", "v' = v*(w - 1)", "w = c*u"], {"a": 1, "c": None}),
                   "trajectory": {"initial": {"v": 0.5}},
                   "fit": {"parameters": {"a": {"guess": 1, "bounds": [None if low < 0 else low, None]}, "c": {"guess": 0.4}}, "initial": ["u"],
                           "weights": {"u": 1, "w/c": 2},
                           "data": [{"times": times[e], "columns": {"u": y[e][0], "w/c": y[e][0], "v": y[e][1]}, "initial": {"u": 0.7} | ({"v": 1.2} if e else {}),
                                     "weights": {"u": 0, "w/c": weights[e], "v": 2}} for e in range(2)]}}
        f = self.fit(f"experiments {n}", request)
        if not f:
            return

        def residual(p):
            r = []
            for e in range(2):
                u, v = run((p[2 + e], starts[e][1]), p[:2], times[e])
                for row, data, w in ((u, y[e][0], weights[e]), (v, y[e][1], [2] * 10)):
                    r += [math.sqrt(w[i]) * (row[i] - data[i]) if data[i] is not None else 0 for i in range(10)]
            return r
        best = least_squares(residual, [1, 0.4, 0.7, 0.7], bounds=([low, -np.inf, -np.inf, -np.inf], np.inf), xtol=1e-14, ftol=1e-14, gtol=1e-14, jac="3-point")
        got = [f["parameters"]["a"], f["parameters"]["c"], f["initial_values"][0]["u"], f["initial_values"][1]["u"]]
        for k, one in enumerate(got):
            self.near(f"experiments {n}: {f['names'][k]}", one["value"], best.x[k], 2e-6)
        self.near(f"experiments {n}: residual", f["residual"], 2 * best.cost, 1e-8)
        free = [k for k in range(4) if not got[k]["at_bound"]]
        self.tally.check(got[0]["at_bound"] == (best.x[0] <= low * (1 + 1e-9)), f"experiments {n}: the bound")
        J = best.jac[:, free]
        errors = np.sqrt(np.diag(np.linalg.inv(J.T @ J)) * 2 * best.cost / (38 - len(free)))
        for k, e in zip(free, errors):
            self.near(f"experiments {n}: standard error of {f['names'][k]}", got[k]["standard_error"], e, 1e-4)
        self.tally.check(f["observations"] == 38, f"experiments {n}: observations", str(f["observations"]))

    def pendulum(self):
        system = equations(["x", "y", "lam"], ["x'' = -lam*x", "y'' = -lam*y - g", "x^2 + y^2 = L^2"], {"g": "9.81", "L": "1.2"})
        truth, problem = self.solver.solve({"system": system, "trajectory": {"stop": 2, "samples": 21, "initial": {"x": "L/2"}}, "accuracy": {"rtol": 1e-13}})
        if not self.tally.check(truth, "pendulum", str(problem)):
            return
        rows = truth["trajectory"]["rows"][1:]
        data = {"times": [r[0] for r in rows], "columns": {"x": [r[1] for r in rows], "y": [r[2] for r in rows]}}
        trajectory = {"initial": {"x": "L/2"}}
        f = self.fit("pendulum", {"system": system, "trajectory": trajectory, "fit": {"parameters": {"g": {"guess": 9}, "L": {"guess": 1.1}}, "data": data}})
        if f and self.tally.check(f["converged"], "pendulum: converged", str(f.get("reason"))):
            self.near("pendulum: g", f["parameters"]["g"]["value"], 9.81, 1e-8)
            self.near("pendulum: L", f["parameters"]["L"]["value"], 1.2, 1e-8)
        # the period alone tells g/L, not both: angles do
        angle = {"times": data["times"], "columns": {"x/L": [r[1] / 1.2 for r in rows]}}
        f = self.fit("pendulum, angles", {"system": system, "trajectory": trajectory, "fit": {"parameters": {"g": {"guess": 9}, "L": {"guess": 1.1}}, "data": angle}})
        if f:
            self.tally.check(f["identifiable"] == [] and len(f["not_identifiable"]) == 1, "pendulum: what angles do not tell", json.dumps(f["not_identifiable"]))
            self.tally.check(all(v["value"] is None and v["standard_error"] is None for v in f["parameters"].values()), "pendulum: no value is given")
            self.near("pendulum: the quotient that they tell", f["parameters"]["g"]["last"] / f["parameters"]["L"]["last"], 9.81 / 1.2, 1e-6)
            signs = list(f["not_identifiable"][0]["combination"].values())
            self.tally.check(len(signs) == 2 and abs(abs(signs[0]) - abs(signs[1])) < 1e-4, "pendulum: the combination", str(signs))

    def starts(self):
        """A guess far off, from which steps lead to another place, and further guesses within bounds."""
        p = NIST["BoxBOD"]
        f = self.fit("starts", {"system": equations(["y"], ["y' = b2*(b1 - y)"], {"b1": None, "b2": None}), "trajectory": {"initial": {"y": 0}},
                                "fit": {"parameters": {"b1": {"guess": 1, "bounds": [1, 1000]}, "b2": {"guess": 1, "bounds": [1e-3, 100]}}, "starts": 20,
                                        "data": {"times": p["x"], "columns": {"y": p["y"]}}}})
        if f:
            self.certified("starts", f, p)
            self.tally.check(f["starts"]["tried"] == 21 and f["starts"]["same"] >= 3, "starts: counted", str(f["starts"]))

    def bounces(self):
        """A ball after its bounces: gravity, restitution and the height it falls from, by SciPy on the closed form. Then modes: a converter, from its own motion."""
        def height(p, t):
            g, e, h = p
            speed = math.sqrt(2 * g * h)
            at, x = speed / g, h - g * t * t / 2
            while t > at:
                speed *= e
                x, at = speed * (t - at) - g * (t - at)**2 / 2, at + 2 * speed / g
            return x
        rng, times = random.Random(5), [0.05 * k for k in range(1, 45)]
        data = [height((9.81, 0.8, 1.3), t) + rng.gauss(0, 0.004) for t in times]
        right = least_squares(lambda p: [height(p, t) - v for t, v in zip(times, data)], [9.8, 0.8, 1.3], x_scale=[10, 1, 1], jac="3-point", xtol=1e-14, ftol=1e-14, gtol=1e-14)
        errors = np.sqrt(np.diag(np.linalg.inv(right.jac.T @ right.jac)) * 2 * right.cost / (len(data) - 3))
        ball = equations(["x", "v"], ["x' = v", "v' = -g"], {"g": None, "e": None, "h": None})
        f = self.fit("a ball that bounces", ask({"parameters": {"g": {"guess": 9.7}, "e": {"guess": 0.79}, "h": {"guess": 1.28}}, "data": {"times": times, "columns": {"x": data}}}, ball,
                                                {"initial": {"x": "h", "v": 0}, "events": saltation.events(saltation.GROUND)}))
        for k, name in enumerate(("g", "e", "h") if f else ()):
            got = f["parameters"][name]
            self.tally.check(f["converged"] and got["value"] is not None and abs(got["value"] - right.x[k]) <= 1e-4 * errors[k], f"a ball that bounces: {name}", f"{got}, not {right.x[k]}")
            self.tally.check(abs((got["standard_error"] or 0) - errors[k]) <= 1e-4 * errors[k], f"a ball that bounces: error of {name}", f"{got}, not {errors[k]}")
        choke = {**equations(["i", "v"], ["if(s == 2, i, L*i' - if(s == 1, 12, 0) + v) = 0", "v' = i - v/R"], {"L": "1.05", "R": "1.1"}), "modes": saltation.modes(s=([0, 1, 2], 1))}
        motion = {"initial": {"i": 0, "v": 0}, "events": saltation.events(("t - 0.52", "any", {"s": "0"}), ("i", "down", {"s": "2"}))}
        own = self.solver.solve({"system": choke, "trajectory": {"stop": 3, "samples": 31, **motion}})[0]["trajectory"]["rows"][1:]
        f = self.fit("a converter", ask({"parameters": {"L": {"guess": 1}, "R": {"guess": 1}}, "data": {"times": [float(r[0]) for r in own], "columns": {"v": [float(r[2]) for r in own]}}},
                                        {**choke, "parameters": {"L": None, "R": None}}, motion))
        for name, value in (("L", 1.05), ("R", 1.1)) if f else ():
            self.near(f"a converter: {name}", f["parameters"][name]["value"], value, 1e-9)

    def slides(self):
        """Dry friction: half swings about +- mu/k until the mass sticks; two experiments, with noise, by SciPy on the closed form. Then a relay that holds a state on its surface."""
        def place(k, mu, x, t):
            w, c = math.sqrt(k), mu / k
            while abs(x) > c:
                middle = math.copysign(c, x)
                if t < math.pi / w:
                    return (x - middle) * math.cos(w * t) + middle
                x, t = 2 * middle - x, t - math.pi / w
            return x
        rng, times, starts = random.Random(11), [0.21 * i for i in range(1, 31)], (1.0, -1.7)
        data = [[place(4, 0.6, a, t) + rng.gauss(0, 0.003) for t in times] for a in starts]
        right = least_squares(lambda p: [place(*p, a, t) - v for a, values in zip(starts, data) for t, v in zip(times, values)], [4, 0.6], jac="3-point", xtol=1e-15, ftol=1e-15, gtol=1e-15)
        errors = np.sqrt(np.diag(np.linalg.inv(right.jac.T @ right.jac)) * 2 * right.cost / (2 * len(times) - 2))
        mass = equations(["x", "v"], ["x' = v", "v' = -k*x - mu*sign(v)"], {"k": None, "mu": None})
        f = self.fit("dry friction", ask({"parameters": {"k": {"guess": 3.8}, "mu": {"guess": 0.55}}, "data": [{"initial": {"x": a}, "times": times, "columns": {"x": values}} for a, values in zip(starts, data)]},
                                         mass, {"initial": {"x": 1, "v": 0}, "sliding": True}))
        for k, name in enumerate(("k", "mu") if f else ()):
            got = f["parameters"][name]
            self.tally.check(f["converged"] and got["value"] is not None and abs(got["value"] - right.x[k]) <= 1e-3 * errors[k], f"dry friction: {name}", f"{got}, not {right.x[k]}")
            self.tally.check(abs((got["standard_error"] or 0) - errors[k]) <= 1e-3 * errors[k], f"dry friction: error of {name}", f"{got}, not {errors[k]}")
        # x comes to 0 at c, y grows by the equivalent control b there: y' = x + b*sign(x), on the surface sign(x) = a cos(t)/c
        relay = equations(["x", "y"], ["x' = a*cos(t) - c*sign(x)", "y' = b*sign(x)"], {"a": None, "b": None, "c": "2"})
        own = self.solver.solve({"system": {**relay, "parameters": {"a": "0.7", "b": "1.3", "c": "2"}}, "trajectory": {"stop": 4, "samples": 41, "initial": {"x": 1, "y": 0}, "sliding": True}})[0]["trajectory"]
        self.tally.check(len(own["slides"]) > 0, "a relay slides")
        f = self.fit("a relay", ask({"parameters": {"a": {"guess": 0.6}, "b": {"guess": 1}}, "data": {"times": [float(r[0]) for r in own["rows"][1:]], "columns": {"y": [float(r[2]) for r in own["rows"][1:]]}}},
                                    relay, {"initial": {"x": 1, "y": 0}, "sliding": True}))
        for name, value in (("a", 0.7), ("b", 1.3)) if f else ():
            self.near(f"a relay: {name}", f["parameters"][name]["value"], value, 1e-8)

    def untold(self):
        f = self.fit("a parameter without influence", ask({"parameters": {"k": 1, "q": 2}, "data": DATA}, equations(["x", "z"], ["x' = -k*x", "z' = q"], {"k": None, "q": 1}),
                                                           {"initial": {"x": 1, "z": 0}}))
        if f:
            self.tally.check(f["identifiable"] == ["k"] and f["not_identifiable"][0]["combination"] == {"q": 1}, "without influence", json.dumps(f["not_identifiable"]))
            self.tally.check(f["parameters"]["q"] == {"value": None, "last": 2, "standard_error": None, "at_bound": False}, "without influence: no value", str(f["parameters"]["q"]))

    def near_0(self):
        """The data are on a line through 0: its constant is told, though its value is as good as 0."""
        ask_ = ask({"parameters": {"a": 0, "b": 0}, "data": {"times": [1, 2, 3], "columns": {"y": [1, 2, 3]}}}, equations(["y"], ["y = a + b*t"], {"a": None, "b": None}), {"initial": {}})
        f = self.fit("a value near 0", ask_)
        if f:
            self.tally.check(f["identifiable"] == ["a", "b"] and abs(f["parameters"]["a"]["value"]) < 1e-9, "a value near 0 is told", json.dumps(f)[:600])

    def errors(self):
        """What multiplies b is 0, but for errors of the motion."""
        f = self.fit("a column of errors", ask({"parameters": {"a": 1, "b": 1}, "data": {"times": [0.5, 1, 2, 3], "columns": {"y": [0.61, 0.365, 0.13, 0.052]}}},
                                               equations(["u", "w", "y"], ["u' = -u", "w' = w", "y' = -a*y + b*(u*w - 1)"], {"a": None, "b": None}),
                                               {"initial": {"u": 1, "w": 1, "y": 1}}))
        if f:
            self.tally.check(f["converged"] and f["identifiable"] == ["a"] and f["parameters"]["b"]["value"] is None, "a column of errors tells nothing", json.dumps(f)[:600])

    def refused(self, label, request, code, pointer):
        result, problem = self.solver.solve(request)
        self.tally.check(result is None and (problem["code"], problem.get("pointer") or "") == (code, pointer), f"{label}: refused", str(problem or result)[:400])


def main():
    check = Check()
    for case in REFUSED:
        check.refused(*case)
    for name, p in NIST.items():
        check.nist(name, p)
    check.pendulum()
    check.starts()
    check.bounces()
    check.slides()
    check.untold()
    check.near_0()
    check.errors()
    first = seed(3)
    for n in range(4):
        check.scipy(first + n)
    return check.tally.end()


if __name__ == "__main__":
    sys.exit(main())
