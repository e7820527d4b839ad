"""Functions given by samples, by a route of their own: the cubic spline from its second derivatives at the
knots (the program takes slopes), all by one dense elimination."""
import bisect

import mpmath

import linear


def number(x):
    from expression import evaluate
    return mpmath.mpf(evaluate(x) if isinstance(x, str) else x)


class Table:
    """Functions between steps (two samples at one time), of which the later one counts there."""

    def __init__(self, given):
        self.t = t = [number(x) for x in given["times"]]
        cuts = [0] + [i for i in range(1, len(t)) if t[i] == t[i - 1]] + [len(t)]
        self.parts = [Smooth({**given, "times": given["times"][a:b], "values": given["values"][a:b]}) for a, b in zip(cuts, cuts[1:])]

    def value(self, order, t):
        late = [p for p in self.parts if p.t[0] <= t] or self.parts[:1]
        return late[-1].value(order, t)


class Smooth:
    def __init__(self, given):
        self.t = [number(x) for x in given["times"]]
        self.y = [number(x) for x in given["values"]]
        self.linear = given.get("interpolation", "cubic") == "linear"
        n = len(self.t)
        self.bend = [mpmath.mpf(0)] * n
        if not self.linear and n > 2:
            self.bend = self._bends(n)

    def _bends(self, n):
        h = [b - a for a, b in zip(self.t, self.t[1:])]
        chord = [(b - a) / s for a, b, s in zip(self.y, self.y[1:], h)]
        rows, right = [], []

        def row(**at):
            rows.append([mpmath.mpf(at.get(f"m{k}", 0)) for k in range(n)])
        for i in range(1, n - 1):
            row(**{f"m{i - 1}": h[i - 1] / 6, f"m{i}": (h[i - 1] + h[i]) / 3, f"m{i + 1}": h[i] / 6})
            right.append(chord[i] - chord[i - 1])
        if n == 3:                       # a parabola
            row(m0=1, m1=-1)
            row(m1=1, m2=-1)
        else:                            # the third derivative does not jump at the second knot and the last but one
            row(m0=1 / h[0], m1=-1 / h[0] - 1 / h[1], m2=1 / h[1])
            row(**{f"m{n - 3}": 1 / h[-2], f"m{n - 2}": -1 / h[-2] - 1 / h[-1], f"m{n - 1}": 1 / h[-1]})
        right += [mpmath.mpf(0)] * 2
        with mpmath.workdps(40):
            return linear.solve(rows, right, mpmath.mpf(10) ** -30)[0]

    def value(self, order, t):
        t = mpmath.mpf(t)
        k = min(max(bisect.bisect_right(self.t, t) - 1, 0), len(self.t) - 2)
        a, b, h = t - self.t[k], self.t[k + 1] - t, self.t[k + 1] - self.t[k]
        m, n, y, z = self.bend[k], self.bend[k + 1], self.y[k], self.y[k + 1]
        p, q = y / h - m * h / 6, z / h - n * h / 6
        return [m * b ** 3 / (6 * h) + n * a ** 3 / (6 * h) + p * b + q * a,
                -m * b ** 2 / (2 * h) + n * a ** 2 / (2 * h) - p + q,
                (m * b + n * a) / h, (n - m) / h][order] if order < 4 else mpmath.mpf(0)


def tables_of(system):
    return {name: Table(given) for name, given in system.get("tables", {}).items()}
