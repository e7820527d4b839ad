"""Found symmetries move computed trajectories to solutions, for symmetry_check.py.

Every sample of a trajectory is moved along the flow of a random combination of the found fields (time too,
where the field has a component there). The moved curve must lie on the printed constraints, must be the trajectory that
is computed from its first point at its own times, or, where functions stay free, satisfy the equations by its own differences."""
import mpmath
import sympy

from expression import EXACT
from identities import Answer
from symmetry_case import Texts

# name, system, trajectory, search
SYSTEMS = [
    ("ring without gravity", {"form": "mechanical", "coordinates": ["x", "y"], "masses": [1, 1], "forces": [0, 0], "constraints": ["x^2+y^2-1"]},
     {"x": 1, "y": 0, "y'": 1}, {"degree": 1}),
    ("spherical pendulum", {"form": "mechanical", "coordinates": ["x", "y", "z"], "masses": [1, 1, 1], "forces": [0, 0, -9], "constraints": ["x^2+y^2+z^2-1"]},
     {"x": 1, "y": 0, "z": 0, "y'": 1}, {"degree": 1}),
    ("knife edge", {"form": "mechanical", "coordinates": ["x", "y", "th"], "masses": [1, 1, 1], "forces": [0, 0, 0], "constraints": ["x'*sin(th)-y'*cos(th)"]},
     {"x": 0, "th": "1/3", "x'": 1, "th'": 1}, {"degree": 1}),
    ("two oscillators", {"form": "hamiltonian", "variables": ["q1", "q2", "p1", "p2"], "hamiltonian": "(p1^2+p2^2+q1^2+q2^2)/2"},
     {"q1": 1, "q2": "1/2", "p1": "1/3"}, {"degree": 1}),
    ("Kepler", {"form": "lagrangian", "coordinates": ["x", "y"], "lagrangian": "(x'^2+y'^2)/2+1/sqrt(x^2+y^2)"},
     {"x": 1, "y'": 1, "x'": "1/5"}, {"degree": 1, "time": True}),
    ("particle on a sphere by its multiplier", {"form": "equations", "variables": ["x", "y", "z", "mu"],
      "equations": ["x''=mu*x", "y''=mu*y", "z''=mu*z", "x^2+y^2+z^2=1"]}, {"x": 1, "y'": 1, "z'": "1/2"}, {"degree": 1}),
    ("free particle with time", {"form": "quasilinear", "variables": ["x", "v"], "A": [[1, 0], [0, 1]], "alpha": ["v", "0"]},
     {"x": 1, "v": "1/2"}, {"degree": 2, "time": True}),
    ("descriptor", {"form": "linear", "variables": ["x", "y", "z"], "A": [[1, 0, 0], [0, 1, 0], [0, 0, 0]], "B": [[0, 1, 0], [-1, 0, 0], [1, 1, -1]]},
     {"x": 1, "y": "1/2"}, {"degree": 1}),
    ("two of three rates", {"form": "quasilinear", "variables": ["x", "y", "z"], "A": [[1, 0, 0], [0, 1, 0]], "alpha": ["y", "-x"]},
     {"x": 1, "y": 0, "z": 1}, {"degree": 1}),
    ("gauge freedom under a constraint", {"form": "quasilinear", "variables": ["x", "y", "z"], "A": [[1, 1, 0], [0, 0, 0]], "alpha": ["z", "z-x-y"]},
     {"x": 1, "y": 1}, {"degree": 1}),
]
SAMPLES, STOP = 13, 0.6


def flow(D, point, span):
    """exp(span D) of a point, by the Taylor method."""
    if all(d == 0 for d in D(*point)):
        return list(point)
    sign = 1 if span >= 0 else -1
    return mpmath.odefun(lambda _, v: [sign * d for d in D(*v)], 0, list(point), tol=mpmath.mpf(10) ** -16)(abs(span))


def moved(names, time, found, weights, span, rows):
    text = Texts([*names, time])
    y = [text.symbol[n] for n in [*names, time]]
    D = [sum((w * text(f["field"].get(n, "0")) for w, f in zip(weights, found)), sympy.Integer(0)) for n in [*names, time]]
    F = sympy.lambdify(y, D, "mpmath")
    out = []
    for r in rows:
        v = flow(F, [mpmath.mpf(a) for a in r[1:]] + [mpmath.mpf(r[0])], span)
        out.append([v[-1]] + v[:-1])
    return out


def on_constraints(tally, label, answer, names, rows):
    g = answer.graph
    for r in rows[::4]:
        env = dict(zip([answer.problem.time, *names], r))
        for _, e in answer.constraints:
            v = g.values(g.cone([e]), env, EXACT)
            size = 1 + max(abs(a) for a in v.values() if isinstance(a, (int, float, mpmath.mpf)))
            tally.check(abs(v[e]) < 1e-7 * size, f"{label}: stays on the final set", mpmath.nstr(v[e], 3))


def derivative(ts, xs, k):
    """Of the polynomial through all samples, at the k-th."""
    total = mpmath.mpf(0)
    n = len(ts)
    for j in range(n):
        if j == k:
            w = sum(1 / (ts[k] - ts[m]) for m in range(n) if m != k)
        else:
            w = 1 / (ts[j] - ts[k])
            for m in range(n):
                if m not in (j, k):
                    w *= (ts[k] - ts[m]) / (ts[j] - ts[m])
        total += w * xs[j]
    return total


def satisfies(tally, label, answer, names, rows):
    """The rows A x' - alpha at the middle, x' from the samples themselves."""
    p, g = answer.problem, answer.graph
    k = len(rows) // 2
    ts = [r[0] for r in rows]
    env = {p.time: ts[k], **dict(zip(names, rows[k][1:]))}
    for i, n in enumerate(names):
        env["@" + n] = derivative(ts, [r[i + 1] for r in rows], k)
    for row in p.rows:
        v = g.values(g.cone([row]), env, EXACT)
        size = 1 + max(abs(a) for a in v.values() if isinstance(a, (int, float, mpmath.mpf)))
        tally.check(abs(v[row]) < 1e-5 * size, f"{label}: satisfies the equations", mpmath.nstr(v[row], 3))


def one(tally, solver, rng, name, system, start, search):
    trajectory = {"start": 0, "stop": STOP, "samples": SAMPLES, "initial": start}
    request = {"system": system, "want": ["constraints", "vector_field", "gauge", "symmetries", "trajectory"], "symmetries": {"search": search},
               "trajectory": trajectory, "accuracy": {"rtol": 1e-11, "atol": 1e-12}}
    result, problem = solver.solve(request)
    if not tally.check(result, f"flow {name}", str(problem)):
        return 0
    found, names = result["symmetries"]["found"], result["trajectory"]["columns"][1:]
    time = result["trajectory"]["columns"][0]
    if not tally.check(found, f"flow {name}: symmetries are found"):
        return 0
    answer = Answer(request, result)
    weights = [rng.randint(-3, 3) for _ in found]
    if not any(weights):
        weights[0] = 1
    span = mpmath.mpf(rng.randint(2, 9)) / 40 / max(abs(w) for w in weights)
    label = f"flow {name}: {weights} by {mpmath.nstr(span, 3)}"
    with mpmath.workdps(20):
        rows = moved(names, time, found, weights, span, result["trajectory"]["rows"])
        on_constraints(tally, label, answer, names, rows)
        satisfies(tally, label, answer, names, rows)
        if result["verdict"] != "unique":
            return 1
        again = {"start": float(rows[0][0]), "times": [float(r[0]) for r in rows], "initial": {n: float(v) for n, v in zip(names, rows[0][1:])}}
        other, problem = solver.solve({**request, "want": ["trajectory"], "trajectory": again, "symmetries": {}})
        if tally.check(other, f"{label}: the moved start", str(problem)):
            gap = max(abs(a - b) / (1 + abs(a)) for r, s in zip(rows, other["trajectory"]["rows"]) for a, b in zip(r, s))
            tally.check(len(other["trajectory"]["rows"]) == len(rows) and gap < 1e-6, f"{label}: a trajectory again", mpmath.nstr(gap, 3))
    return 1


def run(tally, solver, rng, count):
    for name, system, start, search in SYSTEMS:
        for _ in range(count):
            one(tally, solver, rng, name, system, start, search)
