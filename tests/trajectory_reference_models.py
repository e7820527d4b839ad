"""Writes tests/cases/trajectory_reference_models.json: the models that solvers are judged by, to 20 digits and more.

    /usr/bin/python3 tests/trajectory_reference_models.py [MODEL...]

Mechanical systems are integrated in minimal coordinates, or with multipliers by hand, by Taylor series; stiff ones by
collocation of order 25 on the equations M y' = f as they stand. Each is computed twice with different orders, and
where values have been published they must be met."""
import json
import os
import sys

import mpmath as mp
import numpy as np
from scipy.integrate import solve_ivp

from jets import jet, radau_points, sin_cos, sqrt
from trajectory_reference import CASES, case, equations, twice


def near(value, published, digits):
    assert abs(mp.mpf(value) / mp.mpf(published) - 1) < mp.mpf(10) ** -digits, (value, published)


def solve(A, b):
    """A x = b for jets, by elimination without pivoting."""
    n = len(b)
    A, b = [list(r) for r in A], list(b)
    for k in range(n):
        for i in range(k + 1, n):
            f = A[i][k] / A[k][k]
            A[i] = [p - f * q for p, q in zip(A[i], A[k])]
            b[i] = b[i] - f * b[k]
    x = [None] * n
    for k in reversed(range(n)):
        for j in range(k + 1, n):
            b[k] = b[k] - A[k][j] * x[j]
        x[k] = b[k] / A[k][k]
    return x


def arm():
    """First source, section 6, its gauge fixed by a constant tau1."""
    m0, m1, m2, m, l, R = 1, 2, 1, mp.mpf("0.5"), 1, mp.mpf("0.1")

    def acceleration(phi, omega):
        x = phi - l
        return (mp.mpf("0.05") - (x * (2 * (m0 + m2)) + (2 * m0 + m2) * l) * omega * omega) / (
            x * x * (m0 + m2) + x * ((2 * m0 + m2) * l) + (m + m0 + mp.mpf(m1 + m2) / 3) * l ** 2)
    times = [1, 4, 10]
    rows = []
    for phi, omega in twice(lambda t, y: [y[1], acceleration(*y)], [1, "0.1"], times):
        x = phi - l
        tau2 = R * ((m0 + m2) * acceleration(phi, omega) - omega ** 2 * (m2 * (x + mp.mpf(l) / 2) + m0 * (x + l)))
        rows.append([phi, omega, x, tau2])
    with open(os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "etc", "examples", "arm.json"), encoding="utf-8") as f:
        system = json.load(f)["system"]
    case("arm", "the telescopic arm with tau1 kept constant (Munoz-Lecanda, Roman-Roy, EJDE 1999/10, section 6)", system, times,
         {"phi": 1, "omega": "0.1", "x": 0, "v": "0.1", "tau1": "0.05", "tau2": 0}, ["phi", "omega", "x", "tau2"], rows,
         {"verdict": "underdetermined"})
    CASES[-1]["request"]["trajectory"].update(gauge={"rates": {"tau1": "0"}}, hold=["phi", "omega", "tau1"])


def chain():
    """Three unit masses on unit rods, in Cartesian coordinates with multipliers; the reference in angles."""
    def field(t, y):
        a, w = y[:3], y[3:]
        A = [[None] * 3 for _ in range(3)]
        b = []
        for i in range(3):
            r = -sin_cos(a[i])[0] * (3 - i)
            for j in range(3):
                s, c = sin_cos(a[i] - a[j])
                A[i][j] = c * (3 - max(i, j))
                r = r - s * w[j] * w[j] * (3 - max(i, j))
            b.append(r)
        return list(w) + solve(A, b)
    times = ["0.5", 1, 2, 4]
    rows = []
    for v in twice(field, [mp.pi / 2] * 3 + [0] * 3, times):
        x = y = mp.mpf(0)
        row = []
        for a in v[:3]:
            x, y = x + mp.sin(a), y - mp.cos(a)
            row += [x, y]
        rows.append(row)
    case("chain of three pendula", "own: index 3; the reference in angles",
         equations(["x1", "y1", "x2", "y2", "x3", "y3", "k", "l", "m"],
                   ["x1'' = -k*x1 + l*(x2 - x1)", "y1'' = -k*y1 + l*(y2 - y1) - 1", "x2'' = -l*(x2 - x1) + m*(x3 - x2)",
                    "y2'' = -l*(y2 - y1) + m*(y3 - y2) - 1", "x3'' = -m*(x3 - x2)", "y3'' = -m*(y3 - y2) - 1",
                    "x1^2 + y1^2 = 1", "(x2 - x1)^2 + (y2 - y1)^2 = 1", "(x3 - x2)^2 + (y3 - y2)^2 = 1"]),
         times, {"x1": 1, "x2": 2, "x3": 3, **{v: 0 for v in ("y1", "y2", "y3", "x1'", "x2'", "x3'", "y1'", "y2'", "y3'")}},
         ["x1", "y1", "x2", "y2", "x3", "y3"], rows)


def slider_crank():
    """A mass on a crank of length 1, a slider at a rod of length 2 with a spring; the reference in the crank's angle."""
    def field(t, y):
        s, c = sin_cos(y[0])
        r = sqrt(4 - s * s)
        S = -s - s * c / r
        slope = -c - (c * c - s * s) / r - s * s * c * c / (r * r * r)
        return [y[1], (-(S * slope * y[1] * y[1]) - c - (c + r - 2) * S) / (S * S + 1)]
    times = [1, 5, 20]
    rows = [[mp.cos(a), mp.sin(a), mp.cos(a) + mp.sqrt(4 - mp.sin(a) ** 2), w] for a, w in twice(field, [0, 3], times)]
    for r in rows:
        r.pop()
    case("slider-crank", "own: index 3, turning over; the reference in the angle",
         equations(["x", "y", "s", "l", "m"], ["x'' = -l*x + m*(s - x)", "y'' = -l*y - m*y - 1", "s'' = -m*(s - x) - (s - 2)",
                                               "x^2 + y^2 = 1", "(s - x)^2 + y^2 = 4"]),
         times, {"x": 1, "y": 0, "s": 3, "x'": 0, "y'": 3, "s'": 0}, ["x", "y", "s"], rows)


def car_axis():
    """Index 3, stiff springs (Mazzia, Magherini, Test set for IVP solvers, 2008): multipliers solved for by hand."""
    k = 10 * mp.mpf("0.01") ** 2 / 2

    def field(t, q):
        xl, yl, xr, yr, ul, vl, ur, vr = q
        s, c = sin_cos(t * 10)
        yb, yb1, yb2 = s * mp.mpf("0.1"), c, s * -10
        xb = sqrt(1 - yb * yb)
        xb1 = -(yb * yb1) / xb
        xb2 = -(yb1 * yb1 + yb * yb2 + xb1 * xb1) / xb
        ll, lr = sqrt(xl * xl + yl * yl), sqrt((xr - xb) * (xr - xb) + (yr - yb) * (yr - yb))
        fl, fr = (mp.mpf("0.5") - ll) / ll, (mp.mpf("0.5") - lr) / lr
        free = [fl * xl / k, fl * yl / k - 1, fr * (xr - xb) / k, fr * (yr - yb) / k - 1]
        dx, dy = xl - xr, yl - yr
        # accelerations free + columns * (l1, l2) / k
        one, two = [xb, yb, jet(0), jet(0)], [dx * 2, dy * 2, dx * -2, dy * -2]
        g1, g2 = [xb, yb, jet(0), jet(0)], [dx, dy, -dx, -dy]

        def dot(a, b):
            return sum((p * q for p, q in zip(a, b)), jet(0))
        r1 = -(dot(g1, free) + ul * xb1 * 2 + xl * xb2 + vl * yb1 * 2 + yl * yb2)
        r2 = -(dot(g2, free) + (ul - ur) * (ul - ur) + (vl - vr) * (vl - vr))
        l1, l2 = solve([[dot(g1, one) / k, dot(g1, two) / k], [dot(g2, one) / k, dot(g2, two) / k]], [r1, r2])
        return [ul, vl, ur, vr] + [f + a * l1 / k + b * l2 / k for f, a, b in zip(free, one, two)]
    start, times = ["0", "0.5", "1", "0.5", "-0.5", "0", "-0.5", "0"], ["0.1", 1, 3]
    rows = [r[:4] for r in twice(field, start, times)]
    for v, published in zip(rows[-1], ["0.0493455784275402", "0.496989460230171", "1.04174252488542", "0.373911027265361"]):
        near(v, published, 12)
    names = ["xl", "yl", "xr", "yr"]
    case("car axis", "index 3 (Mazzia, Magherini, Test set for IVP solvers, 2008)",
         equations(names + ["l", "m"],
                   ["xl''/2000 = (1/2 - sqrt(xl^2 + yl^2))*xl/sqrt(xl^2 + yl^2) + l*sqrt(1 - sin(10*t)^2/100) + 2*m*(xl - xr)",
                    "yl''/2000 = (1/2 - sqrt(xl^2 + yl^2))*yl/sqrt(xl^2 + yl^2) + l*sin(10*t)/10 + 2*m*(yl - yr) - 1/2000",
                    "xr''/2000 = (1/2/R - 1)*(xr - sqrt(1 - sin(10*t)^2/100)) - 2*m*(xl - xr)".replace("R", ROOT),
                    "yr''/2000 = (1/2/R - 1)*(yr - sin(10*t)/10) - 2*m*(yl - yr) - 1/2000".replace("R", ROOT),
                    "xl*sqrt(1 - sin(10*t)^2/100) + yl*sin(10*t)/10 = 0", "(xl - xr)^2 + (yl - yr)^2 = 1"]),
         times, dict(zip(names + [n + "'" for n in names], start)), names, rows)


ROOT = "sqrt((xr - sqrt(1 - sin(10*t)^2/100))^2 + (yr - sin(10*t)/10)^2)"


def collocate(mass, f, jacobian, y, grid, stages, digits=32):
    """y at the grid's times, of mass y' = f(t, y): stages at the Radau points. Newton steps with matrices in double
    and residuals in full length; mass is constant, lists of floats that are exact."""
    with mp.workdps(digits + 12):
        c = radau_points(stages)
        n, s = len(y), stages
        V, W = mp.matrix(s, s), mp.matrix(s, s)
        for i in range(s):
            for k in range(s):
                V[i, k], W[i, k] = c[i] ** k, c[i] ** (k + 1) / (k + 1)
        D = (W * V ** -1) ** -1                 # h y'_i = sum D_ij z_j
        Df = np.array([[float(D[i, j]) for j in range(s)] for i in range(s)])
        Mf = np.array([[float(v) for v in r] for r in mass])
        y, out = [mp.mpf(v) for v in y], []
        z = [[mp.mpf(0)] * n for _ in range(s)]
        for t, stop in zip(grid, grid[1:]):
            h = stop - t
            last = None
            for turn in range(60):
                points = [[a + b for a, b in zip(y, z[i])] for i in range(s)]
                rest = np.empty(s * n)
                exact = []
                for i in range(s):
                    g = f(t + c[i] * h, points[i])
                    rate = [mp.fsum(D[i, j] * z[j][k] for j in range(s)) for k in range(n)]
                    exact += [h * g[k] - mp.fsum(mass[k][q] * rate[q] for q in range(n) if mass[k][q]) for k in range(n)]
                if turn < 6:
                    M = np.kron(Df, Mf)
                    for i in range(s):
                        J = np.array([[float(v) for v in r] for r in jacobian(t + c[i] * h, points[i])])
                        M[i * n:(i + 1) * n, i * n:(i + 1) * n] -= float(h) * J
                    rows = np.abs(M).max(axis=1)
                    inverse = np.linalg.inv(M / rows[:, None])
                scale = max(abs(v) for v in exact) or mp.mpf(1)
                rest = np.array([float(v / scale) for v in exact]) / rows
                d = [mp.mpf(v) * scale for v in inverse @ rest]
                for i in range(s):
                    for k in range(n):
                        z[i][k] += d[i * n + k]
                # each variable against its own size: some are tiny
                size = [max(abs(y[k]), max(abs(z[i][k]) for i in range(s)), mp.mpf(10) ** -12) for k in range(n)]
                last = max(abs(d[i * n + k]) / size[k] for i in range(s) for k in range(n))
                if last < mp.mpf(10) ** -(digits + 2):
                    break
            assert last < mp.mpf(10) ** -(digits - 2), (t, last)
            y = [a + b for a, b in zip(y, z[s - 1])]
            out.append(list(y))
            z = [[mp.mpf(0)] * n for _ in range(s)]
        return out


def steps_of(field, y, times, rtol):
    """The steps that a Radau code of order 5 takes, all times among them."""
    grid = [0.0]
    y = [float(v) for v in y]
    for stop in times:
        r = solve_ivp(lambda t, v: [float(q) for q in field(t, v)], (grid[-1], float(stop)), y, method="Radau", rtol=rtol, atol=1e-3 * rtol)
        grid += list(r.t[1:])
        y = r.y[:, -1]
    return grid


def stiff(name, source, system, mass, f, jacobian, start, times, columns, grid, accuracy, initial=None, digits=20):
    exact = [mp.mpf(t) for t in times]
    marks = [mp.mpf(min(exact, key=lambda v, g=g: abs(float(v) - g))) if min(abs(float(v) - g) for v in exact) < 1e-12 * max(g, 1e-9) else mp.mpf(g) for g in grid]
    results = []
    for stages in (11, 13):
        values = dict(zip(map(float, marks[1:]), collocate(mass, f, jacobian, start, marks, stages)))
        results.append([values[float(t)] for t in exact])
    for a, b in zip(*results):
        agree = max(abs(p - q) / (abs(q) + mp.mpf(10) ** -9) for p, q in zip(a, b))
        print(name, len(marks) - 1, "steps, agrees to", mp.nstr(agree, 3), flush=True)
        assert agree < mp.mpf(10) ** -digits
    case(name, source, system, times, initial or dict(zip(columns, [str(v) for v in start])), columns, results[1])
    CASES[-1]["request"]["accuracy"] = accuracy
    return results[1]


def eye(n):
    return [[1 if i == j else 0 for j in range(n)] for i in range(n)]


def van_der_pol():
    e = mp.mpf(10) ** 6

    def f(t, y):
        return [y[1], e * ((1 - y[0] * y[0]) * y[1] - y[0])]

    def jacobian(t, y):
        return [[0, 1], [e * (-2 * y[0] * y[1] - 1), e * (1 - y[0] * y[0])]]
    times = ["0.5", 1, 2, 4]
    rows = stiff("van der pol, mu 10^6", "scaled as by Hairer and Wanner, Solving Ordinary Differential Equations II (1996), IV.10",
                 equations(["x", "y"], ["x' = y", "y' = 10^6*((1 - x^2)*y - x)"]), eye(2), f, jacobian, [2, 0], times, ["x", "y"],
                 steps_of(lambda t, y: [y[1], 1e6 * ((1 - y[0] ** 2) * y[1] - y[0])], [2, 0], times, 2e-6), {"rtol": 1e-8, "atol": 1e-8})
    near(rows[2][0], "1.706167732170483", 13)
    near(rows[2][1], "-0.8928097010247975", 12)


def hires():
    """Schaefer 1975; Hairer and Wanner II, IV.10."""
    def q(v):
        return mp.mpf(v)

    def f(t, y):
        a, b, c, d, e, g, h, i = y
        return [q("-1.71") * a + q("0.43") * b + q("8.32") * c + q("0.0007"), q("1.71") * a - q("8.75") * b,
                q("-10.03") * c + q("0.43") * d + q("0.035") * e, q("8.32") * b + q("1.71") * c - q("1.12") * d,
                q("-1.745") * e + q("0.43") * g + q("0.43") * h,
                -280 * g * i + q("0.69") * d + q("1.71") * e - q("0.43") * g + q("0.69") * h, 280 * g * i - q("1.81") * h, -280 * g * i + q("1.81") * h]

    def jacobian(t, y):
        J = [[0] * 8 for _ in range(8)]
        for r, k, v in ((0, 0, -1.71), (0, 1, .43), (0, 2, 8.32), (1, 0, 1.71), (1, 1, -8.75), (2, 2, -10.03), (2, 3, .43), (2, 4, .035),
                        (3, 1, 8.32), (3, 2, 1.71), (3, 3, -1.12), (4, 4, -1.745), (4, 5, .43), (4, 6, .43), (5, 3, .69), (5, 4, 1.71),
                        (5, 6, .69), (6, 6, -1.81), (7, 6, 1.81)):
            J[r][k] = v
        g, i = y[5], y[7]
        for r, sign in ((5, -280), (6, 280), (7, -280)):
            J[r][5] += sign * i
            J[r][7] += sign * g
        J[5][5] -= .43
        return J
    names = ["a", "b", "c", "d", "e", "f", "g", "h"]
    times, start = [1, 50, "321.8122"], [1, 0, 0, 0, 0, 0, 0, "0.0057"]
    rows = stiff("hires", "a high irradiance response, stiff (Hairer and Wanner, 1996, IV.10)",
                 equations(names, ["a' = -1.71*a + 0.43*b + 8.32*c + 0.0007", "b' = 1.71*a - 8.75*b", "c' = -10.03*c + 0.43*d + 0.035*e",
                                   "d' = 8.32*b + 1.71*c - 1.12*d", "e' = -1.745*e + 0.43*f + 0.43*g",
                                   "f' = -280*f*h + 0.69*d + 1.71*e - 0.43*f + 0.69*g", "g' = 280*f*h - 1.81*g", "h' = -280*f*h + 1.81*g"]),
                 eye(8), f, jacobian, start, times, names, steps_of(f, start, times, 1e-7), {"rtol": 1e-8, "atol": 1e-11})
    near(rows[2][0], "0.7371312573325668e-3", 13)
    near(rows[2][7], "0.2850001604814231e-2", 12)


def akzo_nobel():
    """Index 1 (Mazzia, Magherini 2008): five rates and an algebraic equation, as they stand."""
    def rates(y):
        a, b, c, d, e, g = y
        root = mp.sqrt(b)
        r1, r2, r3 = mp.mpf("18.7") * a ** 4 * root, mp.mpf("0.58") * c * d, mp.mpf("0.58") / mp.mpf("34.4") * a * e
        return r1, r2, r3, mp.mpf("0.09") * a * d * d, mp.mpf("0.42") * g * g * root, mp.mpf("3.3") * (mp.mpf("0.9") / 737 - b)

    def f(t, y):
        r1, r2, r3, r4, r5, feed = rates([mp.mpf(v) for v in y])
        return [-2 * r1 + r2 - r3 - r4, -r1 / 2 - r4 - r5 / 2 + feed, r1 - r2 + r3, -r2 + r3 - 2 * r4, r2 - r3 + r5, mp.mpf("115.83") * y[0] * y[3] - y[5]]

    def jacobian(t, y):
        a, b, c, d, e, g = (float(v) for v in y)
        root = b ** .5
        d1 = [4 * 18.7 * a ** 3 * root, 18.7 * a ** 4 / 2 / root, 0, 0, 0, 0]
        d2, d3 = [0, 0, .58 * d, .58 * c, 0, 0], [.58 / 34.4 * e, 0, 0, 0, .58 / 34.4 * a, 0]
        d4, d5 = [.09 * d * d, 0, 0, .18 * a * d, 0, 0], [0, .42 * g * g / 2 / root, 0, 0, 0, .84 * g * root]
        J = np.zeros((6, 6))
        for row, parts in enumerate([[(-2, d1), (1, d2), (-1, d3), (-1, d4)], [(-.5, d1), (-1, d4), (-.5, d5)], [(1, d1), (-1, d2), (1, d3)],
                                     [(-1, d2), (1, d3), (-2, d4)], [(1, d2), (-1, d3), (1, d5)]]):
            for w, v in parts:
                J[row] += w * np.array(v)
        J[1, 1] -= 3.3
        J[5] = [115.83 * d, 0, 0, 115.83 * a, 0, -1]
        return J.tolist()
    mass = eye(6)
    mass[5][5] = 0
    start = ["0.444", "0.00123", 0, "0.007", 0, mp.mpf("115.83") * mp.mpf("0.444") * mp.mpf("0.007")]
    times, names = [1, 20, 180], ["a", "b", "c", "d", "e", "f"]

    def reduced(t, y):
        return f(t, list(y) + [115.83 * y[0] * y[3]])[:5]
    grid = steps_of(reduced, start[:5], times, 1e-7)
    rows = stiff("chemical akzo nobel", "index 1 (Mazzia, Magherini, Test set for IVP solvers, 2008)",
                 equations(names, ["a' = -2*18.7*a^4*sqrt(b) + 0.58*c*d - 0.58/34.4*a*e - 0.09*a*d^2",
                                   "b' = -18.7*a^4*sqrt(b)/2 - 0.09*a*d^2 - 0.42*f^2*sqrt(b)/2 + 3.3*(0.9/737 - b)",
                                   "c' = 18.7*a^4*sqrt(b) - 0.58*c*d + 0.58/34.4*a*e", "d' = -0.58*c*d + 0.58/34.4*a*e - 2*0.09*a*d^2",
                                   "e' = 0.58*c*d - 0.58/34.4*a*e + 0.42*f^2*sqrt(b)", "f = 115.83*a*d"]),
                 mass, f, jacobian, start, times, names, grid, {"rtol": 1e-8, "atol": 1e-10},
                 {"a": "0.444", "b": "0.00123", "c": 0, "d": "0.007", "e": 0})
    near(rows[2][0], "0.1150794920661702", 13)
    near(rows[2][5], "0.4873531310307455e-2", 12)


def amplifier():
    """A transistor amplifier with a singular capacitance matrix, index 1 (Hairer, Lubich, Roche 1989, page 108)."""
    k, us = [mp.mpf(i) * mp.mpf(10) ** -6 for i in range(1, 6)], mp.mpf("0.026")
    mass = [[mp.mpf(0)] * 8 for _ in range(8)]
    for (i, j), c in zip(((0, 1), (3, 4), (6, 7)), (k[0], k[2], k[4])):
        mass[i][i] = mass[j][j] = -c
        mass[i][j] = mass[j][i] = c
    mass[2][2], mass[5][5] = -k[1], -k[3]
    alpha, beta, r0, r = mp.mpf("0.99"), mp.mpf(10) ** -6, 1000, 9000

    def diode(v):
        return beta * (mp.exp(v / us) - 1)

    def f(t, y):
        y1, y2, y3, y4, y5, y6, y7, y8 = y
        p, q = diode(y2 - y3), diode(y5 - y6)
        ue = mp.mpf("0.1") * mp.sin(200 * mp.pi * t)
        return [(y1 - ue) / r0, 2 * y2 / r - mp.mpf(6) / r + (1 - alpha) * p, y3 / r - p, (y4 - 6) / r + alpha * p,
                2 * y5 / r - mp.mpf(6) / r + (1 - alpha) * q, y6 / r - q, (y7 - 6) / r + alpha * q, y8 / r]

    def jacobian(t, y):
        v = [float(x) for x in y]
        p, q = (1e-6 * np.exp((v[i] - v[i + 1]) / 0.026) / 0.026 for i in (1, 4))
        J = np.diag([1 / 1000, 2 / 9000, 1 / 9000, 1 / 9000, 2 / 9000, 1 / 9000, 1 / 9000, 1 / 9000])
        for (i, j), d in zip(((1, 2), (4, 5)), (p, q)):
            J[i, i] += 0.01 * d
            J[i, j] -= 0.01 * d
            J[i + 1, i] -= d
            J[i + 1, j] += d
            J[i + 2, i] += 0.99 * d
            J[i + 2, j] -= 0.99 * d
        return J.tolist()
    start, times = [0, 3, 3, 6, 3, 3, 6, 0], ["0.001", "0.01", "0.05"]
    names = [f"y{i}" for i in range(1, 9)]
    grid = [0.0] + [2.0 ** i * 1e-9 for i in range(15)]
    while grid[-1] < 0.05:
        grid.append(grid[-1] + 1.2e-4)
    grid = sorted(set([g for g in grid if g < 0.05 and min(abs(g - float(t)) for t in times) > 1e-5] + [float(t) for t in times]))
    eqs = ["1e-6*(y2' - y1') = (y1 - sin(200*pi*t)/10)/1000", "1e-6*(y1' - y2') = 2*y2/9000 - 6/9000 + 0.01*D1", "-2e-6*y3' = y3/9000 - D1",
           "3e-6*(y5' - y4') = (y4 - 6)/9000 + 0.99*D1", "3e-6*(y4' - y5') = 2*y5/9000 - 6/9000 + 0.01*D2", "-4e-6*y6' = y6/9000 - D2",
           "5e-6*(y8' - y7') = (y7 - 6)/9000 + 0.99*D2", "5e-6*(y7' - y8') = y8/9000"]
    eqs = [e.replace("D1", "1e-6*(exp((y2 - y3)/0.026) - 1)").replace("D2", "1e-6*(exp((y5 - y6)/0.026) - 1)") for e in eqs]
    stiff("transistor amplifier", "index 1 (Hairer, Lubich, Roche, 1989, page 108)", equations(names, eqs), mass, f, jacobian, start, times,
          names, grid, {"rtol": 1e-8, "atol": 1e-8})


def main():
    """Of the models named, or of all; the other cases of the file stay."""
    mp.mp.dps = 45
    path = os.path.join(os.path.dirname(os.path.abspath(__file__)), "cases", "trajectory_reference_models.json")
    kept = {}
    if sys.argv[1:] and os.path.exists(path):
        with open(path, encoding="utf-8") as f:
            kept = {c["name"]: c for c in json.load(f)}
    models = (arm, slider_crank, chain, car_axis, van_der_pol, hires, akzo_nobel, amplifier)
    for model in models:
        if model.__name__ in sys.argv[1:] or not sys.argv[1:]:
            model()
            print(model.__name__, flush=True)
            kept[CASES[-1]["name"]] = CASES[-1]
            with open(path, "w", encoding="utf-8") as f:
                json.dump(list(kept.values()), f, indent=1)
                f.write("\n")


if __name__ == "__main__":
    main()
