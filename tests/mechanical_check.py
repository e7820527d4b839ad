"""The form `mechanical` against other formulations: mechanical_check.py BUILD_DIR

 * SymPy's KanesMethod (linear constraints, holonomic ones with dependent coordinates) and, for constraints that are not
   linear, Jourdain's principle with a kernel that SymPy works out: accelerations at random points of W;
 * the same system in the forms `equations` (with multipliers) and `lagrangian`: dimensions, index, fields, trajectories;
 * the chain of N links in angles, N up to 10;
 * redundant constraints added at random, columns and rows permuted;
 * three parallel cranks, one of them redundant, against KanesMethod in their angle;
 * reactions and their power along trajectories: M xi - F at the samples, power 0 where perfect constraints are homogeneous
   in the velocities, and the balance of energy for all. Seeded.
"""
import random
import sys

import mpmath
import sympy as sp
from sympy.physics.mechanics import KanesMethod, Particle, Point, ReferenceFrame, dynamicsymbols

from expression import EXACT, Graph
from identities import Answer
from solver import Solver
from tally import Tally, build_folder, scaled, seed

DIGITS = 30

# name, coordinates, masses, forces, constraints, near
SYSTEMS = [
    ("knife edge", "x y th", "2 2 3", ["4", "0", "0"], ["x'*sin(th)-y'*cos(th)"], {}),
    ("rolling disc", "x y th ph", "2 2 1/3 3", ["1", "0", "ph", "0"], ["x'-ph'*cos(th)*5/4", "y'-ph'*sin(th)*5/4"], {}),
    ("Chaplygin sleigh", "x y th", "2 2 3", ["0", "0", "1/5"], ["-x'*sin(th)+y'*cos(th)-th'/2"], {}),
    ("skate with drag", "x y th", "1 1 1/2", ["2-x'", "-y'", "-th'"], ["x'*sin(th)-y'*cos(th)"], {}),
    ("slider-crank", "th ph x", "1 2 3", ["1", "0", "-x'"], ["sin(th)-2*sin(ph)", "x-cos(th)-2*cos(ph)"], {"x": "3"}),
    ("slider-crank at its dead centre", "th ph x", "1 2 3", ["1", "0", "0"], ["sin(th)-2*sin(ph)", "x-cos(th)-2*cos(ph)"],
     {"th": "0", "ph": "0", "x": "3", "th'": "1", "ph'": "1/2"}),
    ("four-bar", "x1 y1 x2 y2", "1 1 2 2", ["0", "-9", "0", "-18"],
     ["x1^2+y1^2-1", "(x2-x1)^2+(y2-y1)^2-9", "(x2-2)^2+y2^2-25/4"], {"x1": "0", "y1": "1", "x2": "5/2", "y2": "12/5"}),
    ("Appell-Hamel", "x y z", "2 2 1", ["0", "0", "-9"], ["x'^2+y'^2-9/4*z'^2"], {"x'": "3", "z'": "2"}),
    ("parallel velocities", "x1 y1 x2 y2", "1 1 2 2", ["0", "-9", "x1", "0"], ["x1'*y2'-x2'*y1'"], {"x1'": "1", "x2'": "2"}),
    ("constant speed", "x y", "1 2", ["-y", "x"], ["x'^2+y'^2-1"], {}),
    ("source's example", "x1 x2", "1 3", ["0", "0"], ["(x1'+x2'-1/2)^3-x1"], {"x1": "1"}),
    ("servo", "x y", "2 1", ["-y", "x-y"], ["x-sin(t)"], {}),
]
HOLONOMIC = [   # coordinates, masses, potential, constraints, start
    ("pendulum", "x y", "2 2", "18*y", ["x^2+y^2-1"], {"x": 1, "y'": "1/2"}),
    ("slider-crank", "th ph x", "1 2 3", "x^2/2", ["sin(th)-2*sin(ph)", "x-cos(th)-2*cos(ph)"], {"th'": 1, "ph'": "1/2", "x": 3}),
    ("spherical pendulum", "x y z", "1 1 1", "9*z", ["x^2+y^2+z^2-4"], {"x": 2, "y'": 1}),
    ("bead on a moving wire", "x y", "1 1", "9*y", ["y-x^2-sin(t)"], {"x": 1, "y": 1}),
]


def request(system, **more):
    return {"system": {"form": "mechanical", **system}, **more}


def describe(q, m, F, h):
    return {"coordinates": q.split(), "masses": m.split(), "forces": F, "constraints": h}


class Symbols:
    """q and u of a system in SymPy, and the texts in them."""

    def __init__(self, q):
        self.names = q
        self.t = dynamicsymbols._t
        self.q = dynamicsymbols(["q_" + n for n in q]) if len(q) > 1 else [dynamicsymbols("q_" + q[0])]
        self.u = dynamicsymbols(["u_" + n for n in q]) if len(q) > 1 else [dynamicsymbols("u_" + q[0])]
        self.map = {n: s for n, s in zip(q, self.q)}
        self.map.update({n + "'": s for n, s in zip(q, self.u)})
        self.map["t"] = self.t

    def read(self, text):
        g = Graph()
        return g.sympy(g.parse(text), self.map)

    def values(self, env):
        out = [(s, env[n]) for n, s in self.map.items() if n != "t"]
        return out + [(self.t, env["t"])]

    def at(self, e, env):
        """Derivatives first: what stands alone is replaced last."""
        pairs = self.values(env)
        plain = {s: sp.Symbol(f"v{k}") for k, (s, _) in enumerate(pairs)}
        e = sp.sympify(e).subs({s: plain[s] for s, _ in pairs[:-1]}).subs(self.t, plain[self.t])
        return sp.lambdify([plain[s] for s, _ in pairs], e, "mpmath")(*[v for _, v in pairs])


def kane(s, m, F, h):
    """u' as a function of a point, from KanesMethod; None where the constraints are not linear in u."""
    n = len(s.q)
    conf = [e for e in h if not e.has(*s.u)]
    still = dict(zip([x.diff(s.t) for x in s.q], s.u))
    speed = [e.diff(s.t).subs(still) if e in conf else e for e in h]
    if any(sp.diff(e, a, b) != 0 for e in speed for a in s.u for b in s.u):
        return None
    N, O = ReferenceFrame("N"), Point("O")
    O.set_vel(N, 0)
    bodies, loads = [], []
    for i in range(n):
        P = Point(f"P{i}")
        P.set_vel(N, s.u[i] * N.x)
        bodies.append(Particle(f"B{i}", P, m[i]))
        loads.append((P, F[i] * N.x))

    def solve(env):
        J = sp.Matrix([[sp.diff(e, u) for u in s.u] for e in speed])
        values = mpmath.matrix([[s.at(J[i, j], env) for j in range(n)] for i in range(J.rows)])
        dependent = pivots(values)
        C = conf_columns(conf, s, env)
        order = [i for i in range(n) if i not in dependent] + dependent
        free_q = [i for i in range(n) if i not in C] + C
        k = KanesMethod(N, [s.q[i] for i in free_q[:n - len(C)]], [s.u[i] for i in order[:n - len(dependent)]],
                        kd_eqs=[a.diff(s.t) - b for a, b in zip(s.q, s.u)],
                        q_dependent=[s.q[i] for i in C], configuration_constraints=conf,
                        u_dependent=[s.u[i] for i in dependent], velocity_constraints=speed)
        k.kanes_equations(bodies, loads)
        M, f = k.mass_matrix, k.forcing
        M = mpmath.matrix([[s.at(M[i, j], env) for j in range(n)] for i in range(n)])
        f = mpmath.matrix([s.at(sp.sympify(f[i]).subs(still), env) for i in range(n)])
        x = mpmath.lu_solve(M, f)
        out = [None] * n
        for place, i in enumerate(order):
            out[i] = x[place]
        return out
    return solve


def pivots(J):
    """Columns that elimination with full pivoting solves for."""
    A, chosen = J.copy(), []
    rows = list(range(A.rows))
    while rows:
        i, j = max(((i, j) for i in rows for j in range(A.cols) if j not in chosen), key=lambda p: abs(A[p[0], p[1]]))
        chosen.append(j)
        rows.remove(i)
        for k in rows:
            f = A[k, j] / A[i, j]
            for c in range(A.cols):
                A[k, c] -= f * A[i, c]
    return sorted(chosen)


def conf_columns(conf, s, env):
    if not conf:
        return []
    return pivots(mpmath.matrix([[s.at(sp.diff(e, x), env) for x in s.q] for e in conf]))


def jourdain(s, m, F, h):
    """Any constraints: N^T (M xi - F) = 0 with the columns of N spanning ker d h/d u, and d h/dt = 0."""
    still = dict(zip([x.diff(s.t) for x in s.q], s.u))
    speed = [e if e.has(*s.u) else e.diff(s.t).subs(still) for e in h]
    H = sp.Matrix([[sp.diff(e, u) for u in s.u] for e in speed])
    drift = [sum((sp.diff(e, q) * u for q, u in zip(s.q, s.u)), d) for e, d in zip(speed, explicit(speed, s))]
    kernel = H.nullspace()

    def solve(env):
        n = len(s.q)
        rows, right = [], []
        for v in kernel:
            v = [s.at(a, env) for a in v]
            rows.append([a * s.at(b, env) for a, b in zip(v, m)])
            right.append(sum((a * s.at(b, env) for a, b in zip(v, F)), mpmath.mpf(0)))
        for i in range(H.rows):
            rows.append([s.at(H[i, j], env) for j in range(n)])
            right.append(-s.at(drift[i], env))
        return list(mpmath.lu_solve(mpmath.matrix(rows), mpmath.matrix(right)))
    return solve


def saddle(s, m, F, h):
    """Any constraints, without a basis of ker H: M xi - H^T lambda = F and H xi = -drift in one."""
    still = dict(zip([x.diff(s.t) for x in s.q], s.u))
    speed = [e if e.has(*s.u) else e.diff(s.t).subs(still) for e in h]
    H = [[sp.diff(e, u) for u in s.u] for e in speed]
    drift = [sum((sp.diff(e, q) * u for q, u in zip(s.q, s.u)), d) for e, d in zip(speed, explicit(speed, s))]

    def solve(env):
        n, c = len(s.q), len(H)
        A, b = mpmath.zeros(n + c), mpmath.zeros(n + c, 1)
        for i in range(n):
            A[i, i], b[i] = s.at(m[i], env), s.at(F[i], env)
        for k in range(c):
            b[n + k] = -s.at(drift[k], env)
            for j in range(n):
                A[n + k, j] = s.at(H[k][j], env)
                A[j, n + k] = -A[n + k, j]
        return list(mpmath.lu_solve(A, b))[:n]
    return solve


def explicit(speed, s):
    """d/dt of what depends on t itself."""
    plain = {x: sp.Symbol(f"p{k}") for k, x in enumerate(list(s.q) + list(s.u))}
    back = {v: k for k, v in plain.items()}
    return [sp.diff(e.subs(plain), s.t).subs(back) for e in speed]


def compare(tally, name, result, req, near, methods, s):
    with mpmath.workdps(DIGITS + 15):
        answer = Answer(req, result, digits=DIGITS, near=near)
        points = answer.sample([e for _, e in answer.constraints], 2)
        tally.check(len(points) == 2, f"{name}: points of W")
        for env in points:
            env = {**{"t": mpmath.mpf(0)}, **env}
            xi = [answer.graph.values(answer.graph.cone([e]), env, EXACT)[e] for e in answer.motions["total"]]
            for method, solve in methods:
                other = solve(env)
                gap = max(abs(a - b) / (1 + abs(a)) for a, b in zip(xi, other))
                tally.check(gap < 1e-12, f"{name}: {method}", f"differs by {mpmath.nstr(gap, 3)}")


def kane_systems(tally, solver):
    for name, q, m, F, h, near in SYSTEMS:
        system = describe(q, m, F, h)
        req = request(system)
        if near:
            req["trajectory"] = {"start": 0, "initial": near}
            req["want"] = ["constraints", "index", "vector_field", "gauge"]
        result, problem = solver.solve(req)
        if problem:
            tally.check(False, name, str(problem))
            continue
        s = Symbols(q.split())
        M, force, con = ([s.read(e) for e in x] for x in (m.split(), F, h))
        methods = [("Jourdain", jourdain(s, M, force, con))]
        linear = kane(s, M, force, con)
        if linear:
            methods.append(("Kane", linear))
        compare(tally, name, result, req, near, methods, s)


def with_multipliers(system):
    """The same in the form `equations`."""
    q, n = system["coordinates"], len(system["coordinates"])
    names = {x: sp.Symbol(x) for x in q}
    names.update({x + "'": sp.Symbol("u_" + x) for x in q})
    names["t"] = sp.Symbol("t")
    lam = [sp.Symbol(f"lambda{k + 1}") for k in range(len(system["constraints"]))]
    right = [g.sympy(g.parse(f), names) for g, f in ((Graph(), f) for f in system["forces"])]
    for l, h in zip(lam, system["constraints"]):
        g = Graph()
        e = g.sympy(g.parse(h), names)
        by = [names[x + "'"] for x in q]
        by = by if any(e.has(u) for u in by) else [names[x] for x in q]
        right = [r + l * sp.diff(e, u) for r, u in zip(right, by)]

    def text(e):
        out = sp.sstr(e).replace("**", "^")
        for x in q:
            out = out.replace("u_" + x, x + "'")
        return out
    eqs = [f"({m})*{x}'' = {text(r)}" for m, x, r in zip(system["masses"], q, right)]
    return {"form": "equations", "variables": q + [str(l) for l in lam], "equations": eqs + [f"{h} = 0" for h in system["constraints"]]}, n


def fields_agree(tally, name, req, a, b):
    with mpmath.workdps(DIGITS + 15):
        first = Answer(req, a, digits=DIGITS)
        g = first.graph
        near = first.sample([e for _, e in first.constraints], 2)
        for k, d in enumerate(b.get("definitions", [])):
            g.define(d["name"] + "_other", d["expression"])
        texts = {n: g.parse(e) for n, e in b["vector_field"]["components"].items()} if not b.get("definitions") else None
        tally.check(near, f"{name}: points")
        for env in near:
            for n, e in first.field.items():
                if texts is None or n.startswith("lambda"):
                    continue
                x, y = (g.values(g.cone([k]), env, EXACT)[k] for k in (e, texts[n]))
                tally.check(abs(x - y) <= 1e-10 * (1 + abs(x)), f"{name}: field of {n}", f"{mpmath.nstr(x, 8)}, {mpmath.nstr(y, 8)}")


def other_forms(tally, solver):
    for name, q, m, F, h, near in SYSTEMS:
        system = describe(q, m, F, h)
        motion = {"start": 0, "stop": "1/4", "samples": 3, "initial": near, "outputs": q.split()}
        req = request(system, trajectory=motion)
        a, pa = solver.solve(req)
        other, _ = with_multipliers(system)
        b, pb = solver.solve({"system": other, "trajectory": motion})
        if not tally.check(a and b, f"{name}: both forms", str(pa or pb)):
            continue
        for key in ("verdict", "dimensions", "index"):
            tally.check(a[key] == b[key], f"{name}: {key} with multipliers", f"{a[key]}, {b[key]}")
        fields_agree(tally, name, req, a, b)
        last = [(x, y) for x, y in zip(a["trajectory"]["rows"][-1], b["trajectory"]["rows"][-1])]
        tally.check(all(abs(x - y) < 1e-6 for x, y in last), f"{name}: trajectories", str(last))
    for name, q, m, V, h, start in HOLONOMIC:
        names = q.split()
        potential = sp.sympify(V)
        forces = [sp.sstr(-sp.diff(potential, sp.Symbol(x))).replace("**", "^") for x in names]
        motion = {"start": 0, "stop": 1, "samples": 5, "initial": start}
        L = "+".join(f"({k})/2*{x}'^2" for k, x in zip(m.split(), names)) + f"-({V})"
        a, pa = solver.solve(request(describe(q, m, forces, h), trajectory=motion))
        b, pb = solver.solve({"system": {"form": "lagrangian", "coordinates": names, "lagrangian": L, "holonomic": h},
                              "trajectory": motion})
        if not tally.check(a and b, f"lagrangian {name}: both forms", str(pa or pb)):
            continue
        for key in ("verdict", "dimensions", "index"):
            tally.check(a[key] == b[key], f"lagrangian {name}: {key}", f"{a[key]}, {b[key]}")
        tally.check(a["regular"] is True, f"lagrangian {name}: holonomic systems are regular")
        gap = max(abs(x - y) for r, s in zip(a["trajectory"]["rows"], b["trajectory"]["rows"]) for x, y in zip(r, s))
        tally.check(gap < 1e-5, f"lagrangian {name}: trajectories", f"differ by {gap}")


def chain(tally, solver, n, rng):
    """Point masses on rods: accelerations of the angles, from the matrix of the Lagrangian in them."""
    names = [c + str(i + 1) for i in range(n) for c in "xy"]
    h = ["x1^2+y1^2-1"] + [f"(x{i + 1}-x{i})^2+(y{i + 1}-y{i})^2-1" for i in range(1, n)]
    system = {"coordinates": names, "masses": [1] * (2 * n), "forces": [0, -9] * n, "constraints": h}
    a = [rng.uniform(-1.4, 1.4) for _ in range(n)]
    w = [rng.uniform(-1, 1) for _ in range(n)]
    start, x, y, u, v = {}, 0.0, 0.0, 0.0, 0.0
    for i in range(n):
        x, y = x + mpmath.sin(a[i]), y - mpmath.cos(a[i])
        u, v = u + w[i] * mpmath.cos(a[i]), v + w[i] * mpmath.sin(a[i])
        start.update({f"x{i + 1}": float(x), f"y{i + 1}": float(y), f"x{i + 1}'": float(u), f"y{i + 1}'": float(v)})
    req = request(system, want=["index", "consistent_initial"], trajectory={"start": 0, "initial": start})
    result, problem = solver.solve(req)
    if not tally.check(result, f"chain of {n}", str(problem)):
        return
    tally.check(result["dimensions"]["final"] == 2 * n and result["index"]["differentiation"] == 3, f"chain of {n}: dimensions")
    tally.check(result["regular"] is True, f"chain of {n}: regular")
    M = mpmath.matrix(n, n)
    f = mpmath.matrix(n, 1)
    for i in range(n):
        f[i] = -9 * (n - i) * mpmath.sin(a[i])
        for j in range(n):
            mass = n - max(i, j)
            M[i, j] = mass * mpmath.cos(a[i] - a[j])
            f[i] -= mass * mpmath.sin(a[i] - a[j]) * w[j] ** 2
    b = mpmath.lu_solve(M, f)
    got = result["consistent_initial"]["derivatives"]
    X, Y = mpmath.mpf(0), mpmath.mpf(0)
    for i in range(n):
        X += b[i] * mpmath.cos(a[i]) - w[i] ** 2 * mpmath.sin(a[i])
        Y += b[i] * mpmath.sin(a[i]) + w[i] ** 2 * mpmath.cos(a[i])
        for key, should in ((f"x{i + 1}'", X), (f"y{i + 1}'", Y)):
            tally.check(abs(got[key] - should) < 1e-8 * (1 + abs(should)), f"chain of {n}: {key}", f"{got[key]}, {should}")


def chain_angles(tally, solver, n, rng):
    """The chain beside the form `lagrangian` in its angles, along a trajectory."""
    names = [c + str(i + 1) for i in range(n) for c in "xy"]
    h = ["x1^2+y1^2-1"] + [f"(x{i + 1}-x{i})^2+(y{i + 1}-y{i})^2-1" for i in range(1, n)]
    a = [rng.uniform(-1, 1) for _ in range(n)]
    start = {}
    for i in range(n):
        start[f"x{i + 1}"] = float(sum(mpmath.sin(b) for b in a[:i + 1]))
        start[f"y{i + 1}"] = float(-sum(mpmath.cos(b) for b in a[:i + 1]))
    place = [("+".join(f"sin(a{k + 1})" for k in range(i + 1)), "-(" + "+".join(f"cos(a{k + 1})" for k in range(i + 1)) + ")") for i in range(n)]
    energy = [f"{n - max(i, j)}/2*cos(a{i + 1}-a{j + 1})*a{i + 1}'*a{j + 1}'" for i in range(n) for j in range(n)]
    L = "+".join(energy) + "+" + "+".join(f"{9 * (n - i)}*cos(a{i + 1})" for i in range(n))
    motion = {"start": 0, "stop": 1, "samples": 6}
    system = {"coordinates": names, "masses": [1] * (2 * n), "forces": [0, -9] * n, "constraints": h}
    one, p1 = solver.solve(request(system, trajectory={**motion, "initial": start, "outputs": names}, accuracy={"rtol": 1e-10, "atol": 1e-10}))
    two, p2 = solver.solve({"system": {"form": "lagrangian", "coordinates": [f"a{i + 1}" for i in range(n)], "lagrangian": L},
                            "trajectory": {**motion, "initial": {f"a{i + 1}": b for i, b in enumerate(a)}, "outputs": [e for p in place for e in p]},
                            "accuracy": {"rtol": 1e-10, "atol": 1e-10}})
    if not tally.check(one and two, f"chain of {n} in angles", str(p1 or p2)):
        return
    gap = max(abs(x - y) for r, s in zip(one["trajectory"]["rows"], two["trajectory"]["rows"]) for x, y in zip(r, s))
    tally.check(gap < 1e-6, f"chain of {n}: trajectory in angles", f"differs by {gap}")
    tally.check(one["dimensions"]["final"] == two["dimensions"]["final"] == 2 * n, f"chain of {n}: dimensions in both forms")


def cranks(tally, solver, rng):
    """Three parallel cranks of length 1 and their coupler: P1, P2, and P3 in their middle. The third crank is redundant."""
    m = [rng.randint(1, 5) for _ in range(3)]
    F = [rng.randint(-9, 9) for _ in range(6)]
    names = ["x1", "y1", "x2", "y2", "x3", "y3"]
    h = ["x1^2+y1^2-1", "(x2-4)^2+y2^2-1", "(x2-x1)^2+(y2-y1)^2-16", "x3-(x1+x2)/2", "y3-(y1+y2)/2", "(x3-2)^2+y3^2-1"]
    phi, w = rng.uniform(0.3, 1.2), rng.uniform(-2, 2)
    c, s = float(mpmath.cos(phi)), float(mpmath.sin(phi))
    start = {}
    for k, base in enumerate((0, 4, 2)):
        start.update({f"x{k + 1}": base + c, f"y{k + 1}": s, f"x{k + 1}'": -w * s, f"y{k + 1}'": w * c})
    system = {"coordinates": names, "masses": [m[k // 2] for k in range(6)], "forces": F, "constraints": h}
    result, problem = solver.solve(request(system, want=["index", "constraints", "consistent_initial"], trajectory={"start": 0, "initial": start}))
    if not tally.check(result, "three cranks", str(problem)):
        return
    tally.check(result["dimensions"]["final"] == 2, "three cranks: one angle", str(result["dimensions"]))
    tally.check(result["verdict"] == "unique" and len(result["regularity"]["redundant"]) == 1, "three cranks: one redundant", str(result["regularity"]))
    q, u = dynamicsymbols("q u")
    N, O = ReferenceFrame("N"), Point("O")
    O.set_vel(N, 0)
    bodies, loads = [], []
    for k in range(3):
        P = Point(f"P{k}")
        P.set_vel(N, u * (-sp.sin(q) * N.x + sp.cos(q) * N.y))
        bodies.append(Particle(f"B{k}", P, m[k]))
        loads.append((P, F[2 * k] * N.x + F[2 * k + 1] * N.y))
    method = KanesMethod(N, [q], [u], kd_eqs=[q.diff() - u])
    method.kanes_equations(bodies, loads)
    at = {q: phi, u: w}
    b = float((method.forcing[0] / method.mass_matrix[0, 0]).subs(at))
    for k in range(3):
        for name, should in ((f"x{k + 1}'", -b * s - w * w * c), (f"y{k + 1}'", b * c - w * w * s)):
            got = result["consistent_initial"]["derivatives"][name]
            tally.check(abs(got - should) < 1e-7 * (1 + abs(should)), f"three cranks: {name}", f"{got}, {should}")


HOMOGENEOUS = ("knife edge", "rolling disc", "Chaplygin sleigh", "skate with drag", "slider-crank", "four-bar", "Appell-Hamel", "parallel velocities")


def powers(tally, solver):
    """M xi - F at the samples, reaction_power = R v, and T(end) - T(start) = the integral of F v + R v by Simpson's rule."""
    for name, q, m, F, h, near in SYSTEMS:
        names, samples = q.split(), 41
        outputs = names + [n + "'" for n in names] + ["reaction_" + n for n in names] + ["reaction_power"]
        result, problem = solver.solve(request(describe(q, m, F, h), accuracy={"rtol": 1e-10, "atol": 1e-11},
                                               trajectory={"start": 0, "stop": "1/4", "samples": samples, "initial": near, "outputs": outputs}))
        if not tally.check(result, f"power {name}", str(problem)):
            continue
        s = Symbols(names)
        M, force, con = ([s.read(e) for e in x] for x in (m.split(), F, h))
        acceleration = saddle(s, M, force, con)
        work, energy, size, n = [], [], mpmath.mpf(1), len(names)
        for r in result["trajectory"]["rows"]:
            env = {**dict(zip(names + [a + "'" for a in names], map(mpmath.mpf, r[1:2 * n + 1]))), "t": mpmath.mpf(r[0])}
            v, R, power = r[n + 1:2 * n + 1], r[2 * n + 1:3 * n + 1], r[3 * n + 1]
            mass, f = [s.at(e, env) for e in M], [s.at(e, env) for e in force]
            if len(work) % 10 == 0:
                should = [a * b - c for a, b, c in zip(mass, acceleration(env), f)]
                gap = max(abs(a - b) / (1 + abs(a)) for a, b in zip(R, should))
                tally.check(gap < 1e-7, f"power {name}: reactions at t = {r[0]:.3g}", f"differ by {mpmath.nstr(gap, 3)}")
            tally.check(abs(power - sum(a * b for a, b in zip(R, v))) <= 1e-9 * (1 + abs(power)), f"power {name}: R v at t = {r[0]:.3g}")
            size = max([size] + [abs(a * b) for a, b in zip(R, v)])
            if name in HOMOGENEOUS or "dead centre" in name:
                tally.check(abs(power) <= 1e-7 * size, f"power {name}: perfect constraints do no work", f"{power} at {r[0]}")
            work.append(sum(a * b for a, b in zip(f, v)) + power)
            energy.append(sum(a * b * b for a, b in zip(mass, v)) / 2)
        step = mpmath.mpf(1) / 4 / (samples - 1)
        rule = step / 3 * sum(w * (1 if k in (0, samples - 1) else 4 if k % 2 else 2) for k, w in enumerate(work))
        gap = abs(energy[-1] - energy[0] - rule)
        tally.check(gap <= 1e-7 * (1 + abs(energy[0])), f"power {name}: balance of energy", mpmath.nstr(gap, 3))


def redundant(tally, solver, rng):
    """Combinations and consequences of the constraints, in any order: same motion, same reaction."""
    for name, q, m, F, h, near in SYSTEMS[:9]:
        if "dead centre" in name:
            continue
        a = rng.randint(2, 5)
        more = h + [f"{a}*({h[-1]})", f"({h[0]})*(1+x_^2)".replace("x_", q.split()[0])]
        rng.shuffle(more)
        base, p0 = solver.solve(request(describe(q, m, F, h), trajectory={"start": 0, "initial": near}, want=["vector_field"]))
        result, p1 = solver.solve(request(describe(q, m, F, more), trajectory={"start": 0, "initial": near}, want=["vector_field"]))
        if not tally.check(base and result, f"redundant {name}", str(p0 or p1)):
            continue
        tally.check(result["verdict"] == "unique" and len(result["regularity"]["redundant"]) == 2
                    and result["dimensions"]["final"] == base["dimensions"]["final"], f"redundant {name}: counted",
                    str((result["verdict"], result["regularity"])))
        with mpmath.workdps(DIGITS + 15):
            both = [Answer(request(describe(q, m, F, c)), {**r, "constraints": []}, digits=DIGITS)
                    for c, r in ((h, base), (more, result))]
            full, _ = solver.solve(request(describe(q, m, F, h), trajectory={"start": 0, "initial": near},
                                           want=["constraints"]))
            sampler = Answer(request(describe(q, m, F, h)), full, digits=DIGITS, near=near)
            for env in sampler.sample([e for _, e in sampler.constraints], 2):
                for part in ("total", "tangent", "orthogonal", "reaction"):
                    values = [[k.graph.values(k.graph.cone([e]), env, EXACT)[e] for e in k.motions[part]] for k in both]
                    gap = max(abs(x - y) / (1 + abs(x)) for x, y in zip(*values))
                    tally.check(gap < 1e-12, f"redundant {name}: {part}", mpmath.nstr(gap, 3))


# Masses, forces, constraints, a start, the event's function, the coordinate whose velocity is set, and its factor.
IMPULSES = [
    ("bead on a parabola", ["x", "y"], [1, 2], ["0", "-3"], ["x - y^2/2"], {"x": "1/2", "y": 1}, {}, "y - 1/2", "y", "-1/2"),
    ("rod that strikes", ["x", "y", "u", "v"], [1, 1, 2, 2], ["0", "-10", "0", "-20"], ["(x - u)^2 + (y - v)^2 - 1"], {"x": 0, "y": "1/5", "u": "3/5", "v": 1}, {"x'": "1/3", "u'": "1/3"},
     "y", "y", "-4/5"),
    ("two rods", ["x", "y", "u", "v"], [3, 1, 1, 2], ["x", "-9", "v", "-5"], ["x^2 + y^2 - 4", "(u - x)^2 + (v - y)^2 - 1"], {"x": "6/5", "y": "-8/5", "u": "9/5", "v": "-12/5"}, {"x'": "1/2", "y'": "3/8"},
     "v + 11/4", "u", "-2/3"),
]


def impulses(tally, solver):
    """Motions with an impulse in double-double and in balls, against Taylor series in 40 digits of the equations with multipliers, and the impulse's own equations."""
    old, mpmath.mp.dps = mpmath.mp.dps, 40
    for name, q, m, F, h, start, rates, event, struck, factor in IMPULSES:
        S = sp.symbols(q)
        n, at = len(q), {str(v): v for v in S}
        V = sp.symbols([v + "_d" for v in q])
        H = sp.Matrix([sp.sympify(e.replace("^", "**"), locals=at, rational=True) for e in h])
        J = H.jacobian(S)
        G = (J * sp.Matrix(V)).jacobian(S) * sp.Matrix(V)
        parts = [sp.lambdify([*S, *V], e, "mpmath") for e in (J, G, sp.Matrix([sp.sympify(f, locals=at, rational=True) for f in F]))]
        g = sp.lambdify([*S], sp.sympify(event.replace("^", "**"), locals=at, rational=True), "mpmath")
        M = mpmath.diag(m)

        def solve(K, force, right):
            """M a - K^T mu = force, K a = right."""
            c = K.rows
            A = mpmath.zeros(n + c)
            for i in range(n):
                A[i, i] = M[i, i]
                for k in range(c):
                    A[i, n + k], A[n + k, i] = -K[k, i], K[k, i]
            return list(mpmath.lu_solve(A, mpmath.matrix([*force, *right])))[:n]

        def field(_, z):
            K, G0, F0 = (mpmath.matrix(p(*z)) for p in parts)
            return [*z[n:], *solve(K, list(F0), [-v for v in G0])]
        z = [mpmath.mpf(sp.Rational(str(start[v])).p) / sp.Rational(str(start[v])).q for v in q]
        speeds = {k: sp.Rational(str(v)) for k, v in rates.items()}
        z += [mpmath.mpf(speeds.get(v + "'", 0).p if v + "'" in speeds else 0) / (speeds[v + "'"].q if v + "'" in speeds else 1) for v in q]
        motion = mpmath.odefun(field, 0, z, tol=mpmath.mpf(10)**-34)
        # the first change of sign
        t, step = mpmath.mpf(0), mpmath.mpf(1) / 16
        while g(*motion(t + step)[:n]) * g(*motion(mpmath.mpf(1) / 1000)[:n]) > 0:
            t += step
        hit = mpmath.findroot(lambda s: g(*motion(s)[:n]), (t, t + step), solver="anderson", tol=mpmath.mpf(10)**-60, verify=False)
        before = list(motion(hit))
        K = mpmath.matrix(parts[0](*before))
        k = q.index(struck)
        c = mpmath.mpf(sp.Rational(factor).p) / sp.Rational(factor).q
        v0 = [*before[n:]]
        v0[k] *= c
        rows = K.rows
        A, b = mpmath.zeros(n + rows), mpmath.zeros(n + rows, 1)
        for i in range(n):
            A[i, i] = 1 if i == k else M[i, i]
            b[i] = v0[i] * A[i, i]
            for j in range(rows):
                A[n + j, i] = K[j, i]
                if i != k:
                    A[i, n + j] = -K[j, i]
        after = list(mpmath.lu_solve(A, b))[:n]
        on = mpmath.odefun(field, hit, [*before[:n], *after], tol=mpmath.mpf(10)**-34)
        stop = hit + mpmath.mpf(1) / 8
        times = [str(sp.Rational(int(hit * 64), 64)), str(sp.Rational(int(stop * 64), 64))]
        for arithmetic, allowed in (("double-double", mpmath.mpf(10)**-17), ("ball", mpmath.mpf(10)**-20)):
            label = f"impulse {name}, {arithmetic}"
            result, problem = solver.solve({"system": {"form": "mechanical", "coordinates": q, "masses": m, "forces": F, "constraints": h}, "want": ["trajectory"],
                                            "accuracy": {"arithmetic": arithmetic, "rtol": 1e-22, "atol": 1e-22},
                                            "trajectory": {"times": [0, *times], "initial": {**start, **{v + "'": rates.get(v + "'", 0) for v in q}}, "outputs": q + [v + "'" for v in q],
                                                           "events": [{"name": "hit", "expression": event, "action": "set", "set": {struck + "'": f"({factor})*{struck}'"}, "max": 1}]}})
            if not tally.check(result is not None, label, str(problem)):
                continue
            trajectory = result["trajectory"]
            when = trajectory["events"][0]["t"]
            told = trajectory["events"][0]["error"] + mpmath.mpf(10)**-30
            gap = abs(mpmath.mpf(getattr(when, "text", repr(when))) - hit)
            tally.check(gap <= told and told < 1e-18, f"{label}: when", f"{mpmath.nstr(gap, 3)}, told {told}")
            for row, moved in zip(trajectory["rows"][1:], (motion, on)):
                s = mpmath.mpf(sp.Rational(times[0] if moved is motion else times[1]).p) / sp.Rational(times[0] if moved is motion else times[1]).q
                right = moved(s)
                gap = max(abs(mpmath.mpf(getattr(a, "text", repr(a))) - e) for a, e in zip(row[1:], right))
                tally.check(gap <= trajectory["error_estimate"] + mpmath.mpf(10)**-30 and trajectory["error_estimate"] < allowed, f"{label}: {'before' if moved is motion else 'after'}",
                            f"{mpmath.nstr(gap, 3)}, told {trajectory['error_estimate']}")
    mpmath.mp.dps = old


def main():
    tally = Tally("mechanical")
    solver = Solver(build_folder())
    rng = random.Random(seed(2026))
    kane_systems(tally, solver)
    other_forms(tally, solver)
    for n in (1, 2, 3, 5, 10):
        for _ in range(scaled(1)):
            chain(tally, solver, n, rng)
    for n in (1, 2, 3):
        chain_angles(tally, solver, n, rng)
    cranks(tally, solver, rng)
    powers(tally, solver)
    redundant(tally, solver, rng)
    impulses(tally, solver)
    return tally.end()


if __name__ == "__main__":
    sys.exit(main())
