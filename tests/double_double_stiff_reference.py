"""Writes tests/cases/double_double_stiff.json: stiff systems with solutions to 34 digits, asked for in double-double arithmetic.

    /usr/bin/python3 tests/double_double_stiff_reference.py [NAME...]

By closed forms, or by collocation in 55 digits on the equations with as few variables as they have, its steps chosen here by
the last Legendre coefficients inside of them. Each is computed twice, with different numbers of stages and tolerances, and
must agree; where values have been published they must be met."""
import json
import os
import sys

import mpmath as mp
import numpy as np

import trajectory_reference as reference
from jets import radau_points
from trajectory_reference import case, equations, explicit
from trajectory_reference_models import near

DIGITS = 34
mp.mp.dps = 55


def text(v):
    return mp.nstr(mp.mpf(v), DIGITS, min_fixed=-3, max_fixed=20)


class Formula:
    def __init__(self, s):
        self.s, self.c = s, radau_points(s)
        V, W = mp.matrix(s, s), mp.matrix(s, s)
        for i in range(s):
            for k in range(s):
                V[i, k], W[i, k] = self.c[i] ** k, self.c[i] ** (k + 1) / (k + 1)
        D = (W * V ** -1) ** -1                   # h x'_i = sum D_ij z_j
        self.D = [[D[i, j] for j in range(s)] for i in range(s)]
        self.rough = np.array([[float(v) for v in r] for r in self.D])
        P = mp.matrix(s + 1, s + 1)               # Legendre polynomials at 0 and the nodes
        for i, c in enumerate([mp.mpf(0)] + self.c):
            for k in range(s + 1):
                P[i, k] = mp.legendre(k, 2 * c - 1)
        P = P ** -1
        self.tail = [[P[s - k, i + 1] for i in range(s)] for k in range(2)]


def stages(formula, field, jacobian, t, h, x, scale):
    """z, by Newton steps with matrices in double; None where they do not settle."""
    s, n = formula.s, len(x)
    z = [[mp.mpf(0)] * n for _ in range(s)]
    for turn in range(40):
        points = [[a + b for a, b in zip(x, row)] for row in z]
        rest = []
        for i in range(s):
            f = field(t + formula.c[i] * h, points[i])
            rest += [h * f[k] - mp.fsum(formula.D[i][j] * z[j][k] for j in range(s)) for k in range(n)]
        if turn < 8:
            M = np.kron(formula.rough, np.eye(n))
            for i in range(s):
                M[i * n:(i + 1) * n, i * n:(i + 1) * n] -= float(h) * np.array(jacobian(float(t + formula.c[i] * h), [float(v) for v in points[i]]))
            unit = np.tile([float(v) for v in scale], s)
            inverse = np.linalg.inv(M * unit[None, :] / unit[:, None])
        largest = max(abs(v / u) for v, u in zip(rest, [q for _ in range(s) for q in scale])) or mp.mpf(1)
        d = inverse @ np.array([float(v / scale[i % n] / largest) for i, v in enumerate(rest)])
        if not np.all(np.isfinite(d)):
            return None
        for i in range(s):
            for k in range(n):
                z[i][k] += mp.mpf(d[i * n + k]) * largest * scale[k]
        size = largest * float(abs(d).max())
        if size < mp.mpf(10) ** -(DIGITS + 8):
            return z
        if turn > 8 and size > 1:
            return None
    return None


def collocate(field, jacobian, x, times, least, s, tol):
    """x at the times; least: what is nothing, by variable."""
    formula, out = Formula(s), []
    t, x = mp.mpf(0), [mp.mpf(v) for v in x]
    h = mp.mpf(10) ** -8
    count = 0
    for stop in (mp.mpf(v) for v in times):
        while t < stop:
            step = stop - t if t + h > stop else h
            scale = [max(abs(v), mp.mpf(q)) for v, q in zip(x, least)]
            z = stages(formula, field, jacobian, t, step, x, scale)
            if z is None:
                h = step / 4
                continue
            e = max(abs(mp.fsum(w * z[i][k] for i, w in enumerate(row))) / max(scale[k], abs(z[-1][k])) for row in formula.tail for k in range(len(x)))
            h = step * min(4, max(mp.mpf("0.1"), mp.mpf("0.9") * (tol / max(e, mp.mpf(10) ** -60)) ** (mp.mpf(1) / s)))
            if e <= tol:
                t = t + step if step < stop - t else stop
                x = [a + b for a, b in zip(x, z[-1])]
                count += 1
        out.append(list(x))
    return out, count


def stiff(name, source, system, field, jacobian, start, times, columns, least, ratio, initial, values=lambda t, x: x):
    """ratio: atol over rtol of the request."""
    (a, n), (b, m) = (collocate(field, jacobian, start, times, least, s, mp.mpf(10) ** -e) for s, e in ((22, 31), (25, 33)))
    agree = max(abs(p - q) / max(abs(q), mp.mpf(v)) for x, y in zip(a, b) for p, q, v in zip(x, y, least))
    print(name, n, m, "steps, agrees to", mp.nstr(agree, 3), flush=True)
    assert agree < mp.mpf(10) ** -(DIGITS - 1)
    rows = [values(mp.mpf(t), x) for t, x in zip(times, b)]
    case(name, source, system, times, initial, columns, rows)
    reference.CASES[-1]["ratio"] = ratio
    return rows


def closed_forms():
    reference.closed("decay", "exp(-10^6 t), every digit of it", explicit(["x"], ["-10^6*x"]), ["0.000001", "0.00001", "0.0001"], {"x": 1}, ["x"],
                     lambda t: [mp.exp(-mp.mpf(10) ** 6 * t)])
    reference.CASES[-1]["ratio"] = 1e-50
    for k in (10, 16):
        reference.closed(f"prothero and robinson, 10^{k}", "x = cos t", explicit(["x"], [f"-10^{k}*(x - cos(t)) - sin(t)"]), ["0.1", "1", "10"],
                         {"x": 1}, ["x"], lambda t: [mp.cos(t)])
    reference.closed("prothero and robinson in small units", "x = 10^(-100) cos t + 10^(-100) exp(-10^6 t)",
                     explicit(["x"], ["-10^6*(x - cos(t)/10^100) - sin(t)/10^100"]), ["0.00001", "0.1", "1", "10"],
                     {"x": "2/10^100"}, ["x"], lambda t: [(mp.cos(t) + mp.exp(-mp.mpf(10) ** 6 * t)) / mp.mpf(10) ** 100])
    reference.CASES[-1]["ratio"] = 1e-100
    reference.closed("backwards in time", "x = cos t, unstable forwards", explicit(["x"], ["10^6*(x - cos(t)) - sin(t)"]), ["-0.1", "-1", "-10"],
                     {"x": 2}, ["x"], lambda t: [mp.cos(t) + mp.exp(mp.mpf(10) ** 6 * t)])
    reference.closed("on a circle", "held on x^2 + y^2 = 1, with z' = -10^5 (z - x y) + d(x y)/dt",
                     {"form": "quasilinear", "variables": ["x", "y", "z"], "restrict": ["x^2 + y^2 - 1"], "A": [[1, 0, 0], [0, 1, 0], [0, 0, 1]],
                      "alpha": ["-y", "x", "-10^5*(z - x*y) + x^2 - y^2"]}, ["0.01", "1", "20"], {"x": 1, "y": 0, "z": 1}, ["x", "y", "z"],
                     lambda t: [mp.cos(t), mp.sin(t), mp.cos(t) * mp.sin(t) + mp.exp(-mp.mpf(10) ** 5 * t)])
    reference.closed("a slope that turns, stiff", "abs changes its branch where the state gets there",
                     explicit(["x", "y"], ["-1", "-10^5*(y - abs(x))"]), ["0.5", "0.9", "1.00001", "3"], {"x": 1, "y": "1.00001"}, ["x", "y"], turn)


def turn(t):
    e = 1 / mp.mpf(10) ** 5
    return [1 - t, 1 - t + e if t <= 1 else t - 1 - e + 2 * e * mp.exp(-(t - 1) / e)]


def van_der_pol(k, times, published):
    e = mp.mpf(10) ** k

    def field(t, y):
        return [y[1], e * ((1 - y[0] * y[0]) * y[1] - y[0])]

    def jacobian(t, y):
        return [[0, 1], [float(e) * (-2 * y[0] * y[1] - 1), float(e) * (1 - y[0] * y[0])]]
    rows = stiff(f"van der pol, mu 10^{k}", "scaled as by Hairer and Wanner, Solving Ordinary Differential Equations II (1996), IV.10",
                 explicit(["x", "y"], ["y", f"10^{k}*((1 - x^2)*y - x)"]), field, jacobian, [2, 0], times, ["x", "y"], ["1e-3", "1e-3"], 1, {"x": 2, "y": 0})
    for v, (p, digits) in zip(rows[-1], published):
        near(v, p, digits)


def robertson():
    def field(t, y):
        a, b, q = mp.mpf(4) / 100 * y[0], 10 ** 4 * y[1] * (1 - y[0] - y[1]), 3 * 10 ** 7 * y[1] ** 2
        return [-a + b, a - b - q]

    def jacobian(t, y):
        z = 1 - y[0] - y[1]
        return [[-0.04 - 1e4 * y[1], 1e4 * (z - y[1])], [0.04 + 1e4 * y[1], -1e4 * (z - y[1]) - 6e7 * y[1]]]
    rows = stiff("robertson", "as a DAE to 10^11 (Mazzia, Magherini, Test set for IVP solvers, 2008)",
                 equations(["x", "y", "z"], ["x' = -0.04*x + 10^4*y*z", "y' = 0.04*x - 10^4*y*z - 3*10^7*y^2", "x + y + z = 1"]), field, jacobian,
                 [1, 0], [40, 4 * 10 ** 5, 10 ** 11], ["x", "y", "z"], ["1e-20", "1e-20"], 1e-10, {"x": 1, "y": 0, "z": 0},
                 lambda t, x: [x[0], x[1], 1 - x[0] - x[1]])
    for v, p in zip(rows[-1], ["0.2083340149701255e-7", "0.8333360770334713e-13", "0.9999999791665050"]):
        near(v, p, 12)


def hires():
    q = mp.mpf

    def field(t, y):
        a, b, c, d, e, g, h, i = y
        return [q("-1.71") * a + q("0.43") * b + q("8.32") * c + q("0.0007"), q("1.71") * a - q("8.75") * b,
                q("-10.03") * c + q("0.43") * d + q("0.035") * e, q("8.32") * b + q("1.71") * c - q("1.12") * d,
                q("-1.745") * e + q("0.43") * g + q("0.43") * h,
                -280 * g * i + q("0.69") * d + q("1.71") * e - q("0.43") * g + q("0.69") * h, 280 * g * i - q("1.81") * h, -280 * g * i + q("1.81") * h]

    def jacobian(t, y):
        J = np.zeros((8, 8))
        for r, k, v in ((0, 0, -1.71), (0, 1, .43), (0, 2, 8.32), (1, 0, 1.71), (1, 1, -8.75), (2, 2, -10.03), (2, 3, .43), (2, 4, .035),
                        (3, 1, 8.32), (3, 2, 1.71), (3, 3, -1.12), (4, 4, -1.745), (4, 5, .43), (4, 6, .43), (5, 3, .69), (5, 4, 1.71),
                        (5, 6, .69), (6, 6, -1.81), (7, 6, 1.81)):
            J[r, k] = v
        for r, sign in ((5, -280), (6, 280), (7, -280)):
            J[r, 5] += sign * y[7]
            J[r, 7] += sign * y[5]
        J[5, 5] -= .43
        return J
    names = list("abcdefgh")
    start = [1, 0, 0, 0, 0, 0, 0, "0.0057"]
    rows = stiff("hires", "a high irradiance response (Schaefer 1975; Hairer and Wanner, 1996, IV.10)",
                 equations(names, ["a' = -1.71*a + 0.43*b + 8.32*c + 0.0007", "b' = 1.71*a - 8.75*b", "c' = -10.03*c + 0.43*d + 0.035*e",
                                   "d' = 8.32*b + 1.71*c - 1.12*d", "e' = -1.745*e + 0.43*f + 0.43*g",
                                   "f' = -280*f*h + 0.69*d + 1.71*e - 0.43*f + 0.69*g", "g' = 280*f*h - 1.81*g", "h' = -280*f*h + 1.81*g"]),
                 field, jacobian, start, [1, 50, "321.8122"], names, ["1e-6"] * 8, 1e-3, dict(zip(names, map(str, start))))
    for v, p in zip(rows[-1], ["0.7371312573325668e-3", "0.1442485726316185e-3", "0.5888729740967575e-4", "0.1175651343283149e-2",
                               "0.2386356198831331e-2", "0.6238968252742796e-2", "0.2849998395185769e-2", "0.2850001604814231e-2"]):
        near(v, p, 11)


def orego():
    def field(t, y):
        return [mp.mpf("77.27") * (y[1] + y[0] * (1 - mp.mpf("8.375e-6") * y[0] - y[1])), (y[2] - (1 + y[0]) * y[1]) / mp.mpf("77.27"),
                mp.mpf("0.161") * (y[0] - y[2])]

    def jacobian(t, y):
        return [[77.27 * (1 - 2 * 8.375e-6 * y[0] - y[1]), 77.27 * (1 - y[0]), 0], [-y[1] / 77.27, -(1 + y[0]) / 77.27, 1 / 77.27], [0.161, 0, -0.161]]
    rows = stiff("orego", "the Oregonator (Field and Noyes 1974; Hairer and Wanner, 1996, IV.10)",
                 explicit(["x", "y", "z"], ["77.27*(y + x*(1 - 0.000008375*x - y))", "(z - (1 + x)*y)/77.27", "0.161*(x - z)"]),
                 field, jacobian, [1, 2, 3], [30, 200, 360], ["x", "y", "z"], ["1e-2"] * 3, 1e-1, {"x": 1, "y": 2, "z": 3})
    for v, p in zip(rows[-1], ["0.1000814870318523e1", "0.1228178521549917e4", "0.1320554942846706e3"]):
        near(v, p, 11)


def e5():
    A, B, C, M = mp.mpf("7.89e-10"), mp.mpf("1.1e7"), mp.mpf("1.13e3"), mp.mpf("1e6")

    def field(t, y):       # y4 = y2 - y3
        a, b, c = y
        d = b - c
        return [-A * a - B * a * c, A * a - M * C * b * c, A * a - B * a * c - M * C * b * c + C * d]

    def jacobian(t, y):
        a, b, c = y
        A, B, C, M = 7.89e-10, 1.1e7, 1.13e3, 1e6
        return [[-A - B * c, 0, -B * a], [A, -M * C * c, -M * C * b], [A - B * c, -M * C * c + C, -B * a - M * C * b - C]]
    stiff("e5", "a chemical reaction with values down to 10^(-22) (Enright, Hull, Lindberg 1975; Hairer and Wanner, 1996, IV.10)",
          explicit(["a", "b", "c", "d"], ["-7.89*a/10^10 - 1.1*10^7*a*c", "7.89*a/10^10 - 1.13*10^9*b*c", "7.89*a/10^10 - 1.1*10^7*a*c - 1.13*10^9*b*c + 1130*d",
                                          "1.1*10^7*a*c - 1130*d"]), field, jacobian, ["0.00176", 0, 0], [10, 10 ** 5, 10 ** 9], ["a", "b", "c", "d"],
          ["1e-12", "1e-24", "1e-24"], 1e-16, {"a": "0.00176", "b": 0, "c": 0, "d": 0}, lambda t, x: [x[0], x[1], x[2], x[1] - x[2]])


def pendulum():
    """Index 3 in Cartesian coordinates, and a fast variable that follows its height; the reference in the angle."""
    def field(t, y):
        return [y[1], -mp.sin(y[0]), -10 ** 5 * (y[2] + mp.cos(y[0])) - y[2] ** 3]

    def jacobian(t, y):
        return [[0, 1, 0], [-np.cos(y[0]), 0, 0], [1e5 * np.sin(y[0]), 0, -1e5 - 3 * y[2] ** 2]]
    stiff("pendulum and what follows it", "own: index 3 and a fast rate",
          equations(["x", "y", "l", "z"], ["x'' = -l*x", "y'' = -l*y - 1", "x^2 + y^2 = 1", "z' = -10^5*(z - y) - z^3"]),
          field, jacobian, [mp.pi / 2, 0, 1], ["0.001", 1, 8], ["x", "y", "l", "z"], ["1e-3"] * 3, 1, {"x": 1, "y": 0, "x'": 0, "y'": 0, "z": 1},
          lambda t, v: [mp.sin(v[0]), -mp.cos(v[0]), v[1] ** 2 + mp.cos(v[0]), v[2]])


MODELS = {
    "van der pol, 3": lambda: van_der_pol(3, ["0.5", 1, 2], []),
    "van der pol, 6": lambda: van_der_pol(6, ["0.5", 1, 2], [("1.706167732170483", 13), ("-0.8928097010247975", 12)]),
    "robertson": robertson, "hires": hires, "orego": orego, "e5": e5, "pendulum": pendulum,
}


def main():
    reference.text = text
    names = sys.argv[1:]
    path = os.path.join(os.path.dirname(os.path.abspath(__file__)), "cases", "double_double_stiff.json")
    kept = []
    if names:      # only these anew
        with open(path, encoding="utf-8") as f:
            kept = json.load(f)
    if not names or "closed" in names:
        closed_forms()
        reference.stiff_closed()
        reference.CASES = [c for c in reference.CASES if "index 1" not in c["name"]]
        linear = reference.CASES
        reference.CASES = []
        reference.linear()
        reference.CASES = linear + [c for c in reference.CASES if "stiff" in c["name"]]
    for name, model in MODELS.items():
        if not names or name in names:
            model()
    for c in reference.CASES:
        ratio = c.pop("ratio", 1)
        c["name"] = c["name"].replace("reference: ", "double-double, stiff: ")
        c["source"] = c["source"] if "(" in c["source"] and "19" in c["source"] or "20" in c["source"] else "own: " + c["source"].replace("own: ", "")
        c["request"]["accuracy"] = {"rtol": 1e-22, "atol": 1e-22 * ratio, "arithmetic": "double-double"}
    new = {c["name"]: c for c in kept + reference.CASES}
    with open(path, "w", encoding="utf-8") as f:
        json.dump(list(new.values()), f, indent=1)
        f.write("\n")
    print(len(new), "cases")


if __name__ == "__main__":
    main()
