"""Writes tests/cases/trajectory_reference.json and long_times.json: systems whose solutions are known to 20 digits and more.

    /usr/bin/python3 tests/trajectory_reference.py

By closed forms, or by jets.py: Taylor series or collocation at more than 30 digits, each computed twice with different
orders; the digits stored are those that agree."""
import json
import os

import mpmath as mp

import jets
from jets import exp, radau, sin_cos, sqrt, taylor

mp.mp.dps = 45
CASES = []


def text(v):
    return mp.nstr(mp.mpf(v), 25, min_fixed=-3, max_fixed=20)


def case(name, source, system, times, initial, columns, rows, expect=None):
    """columns: expressions; rows: their values at the times."""
    CASES.append({
        "name": "reference: " + name, "source": source,
        "request": {"system": system, "accuracy": {"rtol": 1e-8, "atol": 1e-8},
                    "trajectory": {"start": 0, "times": [str(t) for t in times], "initial": initial, "outputs": columns}},
        "expect": {**(expect or {"verdict": "unique"}),
                   "trajectory": {"reference": [[text(v) for v in r] for r in rows], "rows": len(rows), "defect": 1e9}}})


def equations(variables, eqs, **parameters):
    s = {"form": "equations", "variables": variables, "equations": eqs}
    if parameters:
        s["parameters"] = parameters
    return s


def explicit(variables, rates, **parameters):
    return equations(variables, [f"{v}' = {r}" for v, r in zip(variables, rates)], **parameters)


def twice(field, x, times):
    a, b = taylor(field, 0, x, times, 32), taylor(field, 0, x, times, 38)
    for p, q in zip(a, b):
        assert max(abs(u - v) / (1 + abs(u)) for u, v in zip(p, q)) < mp.mpf(10) ** -24, "does not agree"
    return b


def by_taylor(name, source, variables, rates, field, x, times, **parameters):
    case(name, source, explicit(variables, rates, **parameters), times,
         {v: str(a) for v, a in zip(variables, x)}, variables, twice(field, x, times))


def closed(name, source, system, times, initial, columns, function, expect=None):
    case(name, source, system, times, initial, columns, [function(mp.mpf(t)) for t in times], expect)


def kepler(t, e=mp.mpf("0.6")):
    E = mp.findroot(lambda E: E - e * mp.sin(E) - t, t)
    s, rate = mp.sqrt(1 - e * e), 1 / (1 - e * mp.cos(E))
    return [mp.cos(E) - e, s * mp.sin(E), -mp.sin(E) * rate, s * mp.cos(E) * rate]


def closed_forms():
    closed("oscillator", "x = cos t", equations(["x"], ["x'' = -x"]), [1, 10, 50, 100], {"x": 1, "x'": 0}, ["x", "x'"],
           lambda t: [mp.cos(t), -mp.sin(t)])

    def pendulum(t):
        k2 = mp.mpf(1) / 2
        theta = 2 * mp.asin(mp.sqrt(k2) * mp.ellipfun("cd", t, m=k2))
        return [mp.sin(theta), -mp.cos(theta), 3 * mp.cos(theta)]
    closed("pendulum", "Cartesian, index 3, from rest at the height of its hinge: elliptic functions",
           equations(["x", "y", "lam"], ["x'' = -lam*x", "y'' = -lam*y - 1", "x^2 + y^2 = 1"]), [1, 3, 10, 30],
           {"x": 1, "y": 0, "x'": 0, "y'": 0}, ["x", "y", "lam"], pendulum)
    orbit = {"x": "0.4", "y": 0, "u": 0, "v": 2}
    gravity = ["u", "v", "-x/(x^2 + y^2)^(3/2)", "-y/(x^2 + y^2)^(3/2)"]
    closed("kepler", "eccentricity 0.6: Kepler's equation", explicit(["x", "y", "u", "v"], gravity), [1, 6, 20, 60],
           orbit, ["x", "y", "u", "v"], kepler)
    closed("kepler with its angular momentum", "the same held on x v - y u = 4/5",
           {"form": "quasilinear", "variables": ["x", "y", "u", "v"], "restrict": ["x*v - y*u - 4/5"], "alpha": gravity,
            "A": [[1, 0, 0, 0], [0, 1, 0, 0], [0, 0, 1, 0], [0, 0, 0, 1]]}, [1, 6, 20], orbit, ["x", "y", "u", "v"], kepler)
    closed("euler top", "Jacobi's functions sn, cn, dn with m = 0.51",
           explicit(["a", "b", "c"], ["b*c", "-a*c", "-0.51*a*b"]), [1, 5, 20], {"a": 0, "b": 1, "c": 1}, ["a", "b", "c"],
           lambda t: [mp.ellipfun(f, t, m=mp.mpf("0.51")) for f in ("sn", "cn", "dn")])
    closed("logistic", "x = 1/(1 + 99 exp(-t))", explicit(["x"], ["x*(1 - x)"]), [1, 5, 10, 20], {"x": "0.01"}, ["x"],
           lambda t: [1 / (1 + 99 * mp.exp(-t))])
    closed("tangent", "x' = 1 + x^2 towards its pole", explicit(["x"], ["1 + x^2"]), ["0.5", "1", "1.5", "1.57"], {"x": 0},
           ["x"], lambda t: [mp.tan(t)])
    closed("growth and decay", "scales 10^6 apart", explicit(["x", "y"], ["x*cos(t)", "-3*y/10"]), [1, 5, 20],
           {"x": 1, "y": "10^6"}, ["x", "y"], lambda t: [mp.exp(mp.sin(t)), mp.mpf(10) ** 6 * mp.exp(-3 * t / 10)])
    closed("index 1 with a square", "y = -x^2, x = 1/(1 + t)", equations(["x", "y"], ["x' = y", "y + x^2 = 0"]), [1, 5, 50],
           {"x": 1}, ["x", "y"], lambda t: [1 / (1 + t), -1 / (1 + t) ** 2])
    closed("index 2 in time", "x + y = 2 sin t, x' = y: a linear system with its input",
           equations(["x", "y", "z"], ["x' = y + z", "y' = -x + cos(t)", "x + y = 2*sin(t)"]), [1, 4, 10], {"x": 0, "y": 0}, ["x", "y"],
           index2)
    closed("index 5", "a chain of derivatives of sin t + t^2",
           equations(["a", "b", "c", "d", "e"], ["a' = b", "b' = c", "c' = d", "d' = e", "a = sin(t) + t^2"]), [1, 3, 8], {},
           ["a", "b", "c", "d", "e"], lambda t: [mp.sin(t) + t ** 2, mp.cos(t) + 2 * t, 2 - mp.sin(t), -mp.cos(t), mp.sin(t)])


def index2(t):
    # y' = -x + cos t, x = 2 sin t - y: y' = y - 2 sin t + cos t, y = C e^t + sin(t)/2 + ... solved by coefficients
    # y = a cos t + b sin t: -a sin + b cos = a cos + b sin - 2 sin + cos -> b = a + 1, -a = b - 2
    a, b = mp.mpf(1) / 2, mp.mpf(3) / 2
    y = -a * mp.exp(t) + a * mp.cos(t) + b * mp.sin(t)
    return [2 * mp.sin(t) - y, y]


def linear():
    M = [["-1/2", "2", "0"], ["-2", "-1/2", "1/3"], ["1/5", "0", "-1/10"]]
    exact = mp.matrix([[mp.mpf(sum_text(v)) for v in r] for r in M])
    closed("linear", "exp(t M) by mpmath", explicit(["x", "y", "z"], [f"{r[0]}*x + {r[1]}*y + {r[2]}*z" for r in M]), [1, 5, 20],
           {"x": 1, "y": 2, "z": 3}, ["x", "y", "z"], lambda t: list(mp.expm(exact * t) * mp.matrix([1, 2, 3])))
    S = [["-1", "999", "0"], ["0", "-1000", "99000"], ["0", "0", "-100000"]]
    exact2 = mp.matrix([[mp.mpf(v) for v in r] for r in S])

    def stiff(t):
        with mp.workdps(80):
            # triangular with simple eigenvalues: by its eigenvectors
            values, vectors = mp.eig(exact2)
            w = mp.lu_solve(vectors, mp.matrix([1, 1, 1]))
            return [mp.re(sum(vectors[i, k] * mp.exp(values[k] * t) * w[k] for k in range(3))) for i in range(3)]
    closed("stiff linear", "eigenvalues -1, -10^3, -10^5, not normal",
           explicit(["x", "y", "z"], [f"{r[0]}*x + {r[1]}*y + {r[2]}*z" for r in S]), ["0.00001", "0.001", "0.1", "1", "5"],
           {"x": 1, "y": 1, "z": 1}, ["x", "y", "z"], stiff)


def sum_text(v):
    if "/" in v:
        a, b = v.split("/")
        return mp.mpf(a) / mp.mpf(b)
    return mp.mpf(v)


def stiff_closed():
    closed("prothero and robinson", "x = cos t + exp(-10^6 t)", explicit(["x"], ["-10^6*(x - cos(t)) - sin(t)"]),
           ["0.000001", "0.1", "1", "5", "10"], {"x": 2}, ["x"], lambda t: [mp.cos(t) + mp.exp(-mp.mpf(10) ** 6 * t)])
    closed("nonlinear prothero and robinson", "x = 2 + cos t", explicit(["x"], ["-10^4*(x^3 - (2 + cos(t))^3) - sin(t)"]),
           ["0.1", "1", "5", "10"], {"x": 3}, ["x"], lambda t: [2 + mp.cos(t)])
    closed("kaps", "x = exp(-2 t), y = exp(-t), stiff by 10^6", explicit(["x", "y"], ["-(10^6 + 2)*x + 10^6*y^2", "x - y*(1 + y)"]),
           ["0.1", "1", "3", "10"], {"x": 1, "y": 1}, ["x", "y"], lambda t: [mp.exp(-2 * t), mp.exp(-t)])
    closed("kaps, index 1", "its limit 0 = y^2 - x", equations(["x", "y"], ["y' = x - y*(1 + y)", "x = y^2"]),
           ["0.1", "1", "3", "10"], {"y": 1}, ["x", "y"], lambda t: [mp.exp(-2 * t), mp.exp(-t)])


def by_series():
    by_taylor("lotka and volterra", "predator and prey", ["x", "y"], ["x*(1 - y)", "y*(x - 1)/2"],
              lambda t, v: [v[0] * (1 - v[1]), v[1] * (v[0] - 1) * mp.mpf("0.5")], [2, 1], [1, 5, 20])
    by_taylor("lorenz", "errors grow by e^(0.9 t)", ["x", "y", "z"], ["10*(y - x)", "x*(28 - z) - y", "x*y - 8*z/3"],
              lambda t, v: [(v[1] - v[0]) * 10, v[0] * (28 - v[2]) - v[1], v[0] * v[1] - v[2] * (mp.mpf(8) / 3)],
              [1, 1, 20], [1, 3, 8])
    by_taylor("van der pol, mu 5", "a mild relaxation oscillation", ["x", "y"], ["y", "5*(1 - x^2)*y - x"],
              lambda t, v: [v[1], (1 - v[0] * v[0]) * v[1] * 5 - v[0]], [2, 0], [1, 5, 12, 20])
    by_taylor("brusselator", "A = 1, B = 3", ["x", "y"], ["1 + x^2*y - 4*x", "3*x - x^2*y"],
              lambda t, v: [1 + v[0] * v[0] * v[1] - v[0] * 4, v[0] * 3 - v[0] * v[0] * v[1]], [1, 1], [1, 8, 20])
    by_taylor("henon and heiles", "two coupled oscillators, E = 1/8", ["x", "y", "u", "v"],
              ["u", "v", "-x - 2*x*y", "-y - x^2 + y^2"],
              lambda t, w: [w[2], w[3], -w[0] - w[0] * w[1] * 2, -w[1] - w[0] * w[0] + w[1] * w[1]],
              ["0", "0.1", "0.49", "0.05"], [1, 10, 40])

    def duffing(t, v):
        return [v[1], v[0] - v[0] ** 3 - v[1] * mp.mpf("0.2") + sin_cos(t)[1] * mp.mpf("0.3")]
    by_taylor("duffing", "forced", ["x", "y"], ["y", "x - x^3 - y/5 + 3*cos(t)/10"], duffing, [1, 0], [1, 10, 30])
    double_pendulum()
    diode()
    arenstorf()


def double_pendulum():
    """Two unit masses on unit rods, in Cartesian coordinates with multipliers; the reference in angles."""
    def field(t, v):
        a, b, p, q = v
        s, c = sin_cos(a - b)
        sa, sb = sin_cos(a)[0], sin_cos(b)[0]
        d = 2 - c * c
        return [p, q, (-(q * q) * s - p * p * s * c - sa * 2 + sb * c) / d, (p * p * s * 2 + q * q * s * c + sa * c * 2 - sb * 2) / d]
    times = [1, 3, 6]
    rows = []
    for a, b, p, q in twice(field, [mp.pi / 2, mp.pi / 2, 0, 0], times):
        rows.append([mp.sin(a), -mp.cos(a), mp.sin(a) + mp.sin(b), -mp.cos(a) - mp.cos(b)])
    case("double pendulum", "index 3, two rods; the reference in angles",
         equations(["x", "y", "u", "v", "l", "m"],
                   ["x'' = -l*x + m*(u - x)", "y'' = -l*y + m*(v - y) - 1", "u'' = -m*(u - x)", "v'' = -m*(v - y) - 1",
                    "x^2 + y^2 = 1", "(u - x)^2 + (v - y)^2 = 1"]),
         times, {"x": 1, "y": 0, "u": 2, "v": 0, "x'": 0, "y'": 0, "u'": 0, "v'": 0}, ["x", "y", "u", "v"], rows)


def diode():
    """A driven diode and capacitor: 0 = i - (exp(u) - 1), c' = i - c, u = sin t - c."""
    def field(t, v):
        return [exp(sin_cos(t)[0] * 3 - v[0]) - 1 - v[0]]
    times = [1, 4, 10]
    ref = twice(field, [0], times)
    rows = [[r[0], mp.exp(3 * mp.sin(t) - r[0]) - 1] for t, r in zip(times, ref)]
    case("rectifier", "index 1: a diode charges a capacitor",
         equations(["c", "u", "i"], ["c' = i - c", "i = exp(u) - 1", "u + c = 3*sin(t)"]), times, {"c": 0}, ["c", "i"], rows)


def arenstorf():
    mu, nu = mp.mpf("0.012277471"), 1 - mp.mpf("0.012277471")

    def field(t, w):
        x, y, u, v = w
        a, b = (x + mu) * (x + mu) + y * y, (x - nu) * (x - nu) + y * y
        d1, d2 = a * sqrt(a), b * sqrt(b)
        return [u, v, x + v * 2 - (x + mu) / d1 * nu - (x - nu) / d2 * mu, y - u * 2 - y / d1 * nu - y / d2 * mu]
    case("arenstorf", "a satellite of earth and moon (Hairer, Norsett, Wanner, II.0)",
         explicit(["x", "y", "u", "v"],
                  ["u", "v", "x + 2*v - nu*(x + mu)/((x + mu)^2 + y^2)^(3/2) - mu*(x - nu)/((x - nu)^2 + y^2)^(3/2)",
                   "y - 2*u - nu*y/((x + mu)^2 + y^2)^(3/2) - mu*y/((x - nu)^2 + y^2)^(3/2)"],
                  mu="0.012277471", nu="0.987722529"),
         [1, 6, 12], {"x": "0.994", "y": 0, "u": 0, "v": "-2.00158510637908252240537862224"}, ["x", "y"],
         [r[:2] for r in twice(field, ["0.994", 0, 0, "-2.00158510637908252240537862224"], [1, 6, 12])])


def robertson():
    def field(t, y):
        a, b, q = mp.mpf("0.04") * y[0], 10 ** 4 * y[1] * (1 - y[0] - y[1]), 3 * 10 ** 7 * y[1] ** 2
        return [-a + b, a - b - q]

    def jacobian(t, y):
        z = 1 - y[0] - y[1]
        return [[mp.mpf("-0.04") - 10 ** 4 * y[1], 10 ** 4 * (z - y[1])],
                [mp.mpf("0.04") + 10 ** 4 * y[1], -10 ** 4 * (z - y[1]) - 6 * 10 ** 7 * y[1]]]

    def solve(stages, per_decade):
        grid = [mp.mpf(0)] + [mp.mpf(10) ** (mp.mpf(k) / per_decade) for k in range(-5 * per_decade, 1)]
        grid += [40 * mp.mpf(10) ** (mp.mpf(k - 2 * per_decade) / per_decade) for k in range(per_decade, 12 * per_decade + 1)]
        grid = sorted(g for g in grid if g <= 1 or g > mp.mpf("1.01"))
        steps = [(a, b - a) for a, b in zip(grid, grid[1:])]
        values = radau(field, jacobian, [1, 0], steps, stages, 30)
        at = {mp.nstr(b, 12): v for b, v in zip(grid[1:], values)}
        return [at[mp.nstr(mp.mpf(t), 12)] for t in (40, 4000, 400000, 40000000000)]
    a, b = solve(13, 10), solve(12, 13)
    for p, q in zip(a, b):
        agree = max(abs(u - v) / abs(u) for u, v in zip(p, q))
        print("robertson agrees to", mp.nstr(agree, 3))
        assert agree < mp.mpf(10) ** -20
    case("robertson", "as a DAE to 4 10^10", equations(["x", "y", "z"], ["x' = -0.04*x + 10^4*y*z",
         "y' = 0.04*x - 10^4*y*z - 3*10^7*y^2", "x + y + z = 1"]), [40, 4000, 400000, 40000000000],
         {"x": 1, "y": 0, "z": 0}, ["x", "y", "z"], [[p[0], p[1], 1 - p[0] - p[1]] for p in a])
    CASES[-1]["request"]["accuracy"] = {"rtol": 1e-8, "atol": 1e-14}


def long_case(name, source, system, times, trajectory, rows, drift, tolerance, note=None):
    """Over ten thousand periods: the estimates hold, and what should be constant is."""
    CASES.append({
        "name": "long times: " + name, "source": "own: " + source, **({"note": note} if note else {}),
        "request": {"system": system, "accuracy": {"rtol": tolerance, "atol": tolerance}, "limits": {"seconds": 600},
                    "trajectory": {"start": 0, "times": times, **trajectory}},
        "expect": {"verdict": "unique",
                   "trajectory": {"reference": [[text(v) for v in r] for r in rows], "rows": len(rows), "defect": 1e9,
                                  "estimates": True, "drift": drift}}})


def long_times():
    del CASES[:]

    def pendulum(t):
        k2, T = mp.mpf(1) / 2, 2 * mp.pi / mp.agm(1, mp.sqrt(mp.mpf(1) / 2))
        u = mp.mpf(t) - T * mp.floor(mp.mpf(t) / T)
        theta, speed = 2 * mp.asin(mp.sqrt(k2) * mp.ellipfun("cd", u, m=k2)), mp.diff(lambda s: 2 * mp.asin(mp.sqrt(k2) * mp.ellipfun("cd", s, m=k2)), u)
        return [mp.sin(theta), -mp.cos(theta), speed * mp.cos(theta), speed * mp.sin(theta)]
    times = ["7", "744", "7418", "74161.25"]
    long_case("the pendulum in Cartesian coordinates", "index 3, 10^4 swings from rest at the height of the hinge: elliptic functions, the period by the arithmetic-geometric mean",
              equations(["x", "y", "lam"], ["x'' = -lam*x", "y'' = -lam*y - 1", "x^2 + y^2 = 1"]), times,
              {"initial": {"x": 1, "y": 0, "x'": 0, "y'": 0}, "outputs": ["x", "y", "x'", "y'"], "integrals": ["(x'^2 + y'^2)/2 + y", "x*y"]},
              [pendulum(t) for t in times], [["(x'^2 + y'^2)/2 + y", True, 1e-8], ["x*y", False, None]], 1e-6)
    long_case("the pendulum from its Lagrangian", "the same motion over 10^2 swings; the energy is found by itself",
              {"form": "lagrangian", "coordinates": ["x", "y"], "lagrangian": "(x'^2 + y'^2)/2 - y", "holonomic": ["x^2 + y^2 - 1"]}, times[:2],
              {"initial": {"x": 1, "y": 0, "x'": 0, "y'": 0}, "outputs": ["x", "y", "x'", "y'"]},
              [pendulum(t) for t in times[:2]], [["energy", True, 1e-8]], 1e-6)
    orbit = {"x": "0.4", "y": 0, "u": 0, "v": 2}
    gravity = ["u", "v", "-x/(x^2 + y^2)^(3/2)", "-y/(x^2 + y^2)^(3/2)"]
    energy, momentum = "(u^2 + v^2)/2 - 1/sqrt(x^2 + y^2)", "x*v - y*u"
    rows = [kepler(mp.mpf(t) - 2 * mp.pi * mp.floor(mp.mpf(t) / (2 * mp.pi))) for t in ("7", "629.5", "6283", "62833")]
    quasilinear = {"form": "quasilinear", "variables": ["x", "y", "u", "v"], "alpha": gravity,
                   "A": [[1, 0, 0, 0], [0, 1, 0, 0], [0, 0, 1, 0], [0, 0, 0, 1]]}
    motion = {"initial": orbit, "outputs": ["x", "y", "u", "v", energy], "integrals": [energy, momentum]}
    rows = [r + [mp.mpf(-1) / 2] for r in rows]
    long_case("kepler held on its energy and angular momentum", "eccentricity 0.6, 10^4 orbits: Kepler's equation",
              {**quasilinear, "restrict": [momentum + " - 4/5", energy + " + 1/2"]}, ["7", "629.5", "6283", "62833"], motion, rows,
              [[energy, True, 1e-13], [momentum, True, 1e-13]], 1e-6)
    long_case("kepler held on its angular momentum", "10^3 orbits; the energy drifts, and the phase with its square",
              {**quasilinear, "restrict": [momentum + " - 4/5"]}, ["7", "629.5", "6283"], motion, rows[:3],
              [[energy, True, 1e-6], [momentum, True, 1e-13]], 1e-5)


def write(name):
    path = os.path.join(os.path.dirname(os.path.abspath(__file__)), "cases", name)
    with open(path, "w", encoding="utf-8") as f:
        json.dump(CASES, f, indent=1)
        f.write("\n")
    print(len(CASES), "cases")


def main():
    assert jets
    long_times()
    write("long_times.json")
    del CASES[:]
    closed_forms()
    linear()
    stiff_closed()
    by_series()
    robertson()
    write("trajectory_reference.json")


if __name__ == "__main__":
    main()
