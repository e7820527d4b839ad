"""Motions of the form `operator`, for operator_check.py: samples against the printed state form
x' = F x + G e, y = H x + sum J_v e^(v), integrated by mpmath; ends against the roots of what the leading transfer coefficient
has below or above; and planted Weierstrass forms, whose nilpotency is the index (proposition 3)."""
import mpmath
import sympy

from tally import scaled

T = sympy.Symbol("t")
SOURCES = ["sin(t)", "t^2-1", "exp(-t)", "cos(2*t)"]


def function(text):
    return sympy.lambdify(T, sympy.sympify(text.replace("^", "**"), rational=True), "mpmath")


def matrix(texts):
    rows = [[function(c) for c in r] for r in texts]
    return lambda t: [[f(t) for f in r] for r in rows]


def times(A, v):
    return [sum((a * b for a, b in zip(r, v)), mpmath.mpf(0)) for r in A]


def derivatives(source, count):
    e = sympy.sympify(source.replace("^", "**"), rational=True)
    return [sympy.lambdify(T, sympy.diff(e, T, k), "mpmath") for k in range(count)]


class State:
    def __init__(self, state, sources, rows):
        self.n, self.F, self.G, self.H = state["dimension"], matrix(state["F"]), matrix(state["G"]), matrix(state["H"])
        self.J = [matrix(m) for m in state["J"]]
        self.e = [derivatives(s, len(self.J) + 1) for s in sources]
        self.components, self.rows = state["components"], rows

    def direct(self, t):
        out = [mpmath.mpf(0)] * self.rows
        for v, m in enumerate(self.J):
            out = [a + b for a, b in zip(out, times(m(t), [e[v](t) for e in self.e]))]
        return out

    def y(self, t, x):
        return [a + b for a, b in zip(times(self.H(t), x) if self.n else [0] * self.rows, self.direct(t))]

    def field(self, t, x):
        e = [s[0](t) for s in self.e]
        return [a + b for a, b in zip(times(self.F(t), x), times(self.G(t), e))]

    def start(self, t, names, y):
        """x from y: its components are unknowns less terms in e (order 1)."""
        d = self.direct(t)
        return [mpmath.mpf(y[names.index(c)]) - d[names.index(c)] for c in self.components]


def motion(tally, solver, name, system, start, stop):
    """Whether the samples were compared."""
    names = system["unknowns"]
    spec = {"start": start, "stop": stop, "samples": 5, "initial": {n: 1 + i for i, n in enumerate(names)}}
    result, problem = solver.solve({"system": system, "trajectory": spec, "accuracy": {"rtol": 1e-10, "atol": 1e-12}})
    if problem and problem["code"] in ("no_motion", "inconsistent_initial"):
        return False
    if not tally.check(result, f"{name}: answered", str(problem)):
        return False
    ended = result["trajectory"]["ended"]
    ahead = [s["t"] for s in result["singular_times"] if start < s["t"] <= stop]
    if ahead:
        tally.check(ended and ended["t"] <= ahead[0], f"{name}: ends at {ahead[0]} at the latest", str(ended))
        tally.check(not ended or ended["reason"] != "singular_time" or ended["t"] == ahead[0], f"{name}: ends at its time", str(ended))
    elif ended:
        return False       # a pole behind the leading coefficient; the cases have such
    rows = result["trajectory"]["rows"]
    if len(rows) < 2:
        return False
    state = State(result["state"], system["sources"], len(names))
    try:
        state.field(mpmath.mpf(start), [0] * state.n)
        state.direct(mpmath.mpf(start))
    except ZeroDivisionError:
        return False       # a pole of the state form's basis alone
    with mpmath.workdps(18):
        x = state.start(mpmath.mpf(rows[0][0]), names, rows[0][1:])
        solution = mpmath.odefun(state.field, rows[0][0], x, tol=mpmath.mpf(10) ** -13) if state.n else lambda t: []
        for r in rows[1:4]:
            y = state.y(mpmath.mpf(r[0]), solution(r[0]))
            gap = max(abs(a - b) / (1 + abs(a)) for a, b in zip(y, r[1:]))
            tally.check(gap < 1e-6, f"{name}: y from the state at t = {r[0]}", f"differs by {mpmath.nstr(gap, 3)}")
    return True


def polynomial(rng, top):
    return "+".join(f"({rng.randint(-3, 3)})*t^{k}" for k in range(top + 1))


def random_motions(tally, solver, rng, count):
    compared = 0
    for k in range(count):
        p, q = rng.randint(1, 3), rng.randint(1, 3)
        A1 = [[polynomial(rng, 1) if rng.random() < 0.5 and i else "0" for _ in range(p)] for i in range(p)]
        A0 = [[polynomial(rng, 1) if rng.random() < 0.6 else "0" for _ in range(p)] for _ in range(p)]
        B = [[polynomial(rng, 1) for _ in range(q)] for _ in range(p)]
        names = [f"y{i + 1}" for i in range(p)]
        system = {"form": "operator", "unknowns": names, "coefficients": [A0, A1], "B": B, "sources": rng.sample(SOURCES, q)}
        plain, _ = solver.solve({"system": system})
        if not plain or not plain["solvable"]:
            continue
        start = rng.choice([1, 2, 3])
        compared += motion(tally, solver, f"motion {k}", system, start, start + 0.5)
    tally.check(compared >= count // 6, "enough motions are compared", str(compared))


def nilpotencies(tally, solver, rng, count):
    """B diag(D - R, N D - 1) C with unimodular B and C of integers."""
    for k in range(count):
        sizes = [rng.randint(1, 3) for _ in range(rng.randint(1, 2))]
        r = rng.randint(0, 2)
        n = r + sum(sizes)
        A1, A0 = sympy.zeros(n, n), sympy.zeros(n, n)
        for i in range(r):
            A1[i, i], A0[i, i] = 1, rng.randint(-3, 3)
        at = r
        for s in sizes:
            for i in range(s):
                A0[at + i, at + i] = 1
                if i + 1 < s:
                    A1[at + i, at + i + 1] = 1
            at += s
        for _ in range(2 * n if n > 1 else 0):
            i, j = rng.sample(range(n), 2)
            f = rng.choice([-1, 1, 2])
            A1[i, :], A0[i, :] = A1[i, :] + f * A1[j, :], A0[i, :] + f * A0[j, :]
            i, j = rng.sample(range(n), 2)
            A1[:, i], A0[:, i] = A1[:, i] + f * A1[:, j], A0[:, i] + f * A0[:, j]
        text = [[[str(c) for c in m.row(i)] for i in range(n)] for m in (A0, A1)]
        result, problem = solver.solve({"system": {"form": "operator", "unknowns": [f"y{i}" for i in range(n)], "coefficients": text}})
        if not tally.check(result, f"Weierstrass {k}", str(problem)):
            continue
        label = f"Weierstrass {k}: blocks {sizes} beside {r}"
        tally.check(result["index"]["operator"] == max(sizes), f"{label}: index", str(result["index"]))
        tally.check(result["kronecker"]["nilpotency"] == max(sizes), f"{label}: nilpotency", str(result["kronecker"]))
        tally.check(sorted(result["kronecker"]["infinite"]) == sorted(sizes),
                    f"{label}: blocks", str(result["kronecker"]))
        tally.check(result["state"]["dimension"] == r, f"{label}: dimension")


def run(tally, solver, rng):
    random_motions(tally, solver, rng, scaled(36))
    nilpotencies(tally, solver, rng, scaled(20))
