"""Solutions of ordinary differential equations to many digits, for references: Taylor series by recurrences over a
graph (Hairer, Norsett, Wanner, Solving Ordinary Differential Equations I, I.8) where nothing is stiff, and collocation
at the Radau points where something is. Slow and simple; nothing here is shared with the program under test."""
import mpmath as mp


class Jet:
    """A power series in the step; coefficients are computed when asked for."""

    def __init__(self, rule=None, first=None):
        self.c = [] if first is None else [mp.mpf(first)]
        self.rule = rule

    def get(self, k):
        while len(self.c) <= k:
            self.c.append(self.rule(len(self.c), self.c))
        return self.c[k]

    def __add__(self, o):
        o = jet(o)
        return Jet(lambda k, c: self.get(k) + o.get(k))

    def __neg__(self):
        return Jet(lambda k, c: -self.get(k))

    def __sub__(self, o):
        return self + -jet(o)

    def __rsub__(self, o):
        return jet(o) - self

    def __mul__(self, o):
        if not isinstance(o, Jet):
            v = mp.mpf(o)
            return Jet(lambda k, c: v * self.get(k))
        return Jet(lambda k, c: mp.fsum(self.get(i) * o.get(k - i) for i in range(k + 1)))

    def __truediv__(self, o):
        o = jet(o)
        return Jet(lambda k, c: (self.get(k) - mp.fsum(c[i] * o.get(k - i) for i in range(k))) / o.get(0))

    def __rtruediv__(self, o):
        return jet(o) / self

    __radd__, __rmul__ = __add__, __mul__

    def __pow__(self, n):
        r = self
        for _ in range(n - 1):
            r = r * self
        return r


def jet(v):
    if isinstance(v, Jet):
        return v
    v = mp.mpf(v)
    return Jet(lambda k, c: v if k == 0 else mp.mpf(0))


def sqrt(a):
    return Jet(lambda k, c: mp.sqrt(a.get(0)) if k == 0
               else (a.get(k) - mp.fsum(c[i] * c[k - i] for i in range(1, k))) / (2 * c[0]))


def exp(a):
    return Jet(lambda k, c: mp.exp(a.get(0)) if k == 0 else mp.fsum(i * a.get(i) * c[k - i] for i in range(1, k + 1)) / k)


def sin_cos(a):
    s, c = Jet(), Jet()
    s.rule = lambda k, own: mp.sin(a.get(0)) if k == 0 else mp.fsum(i * a.get(i) * c.get(k - i) for i in range(1, k + 1)) / k
    c.rule = lambda k, own: mp.cos(a.get(0)) if k == 0 else -mp.fsum(i * a.get(i) * s.get(k - i) for i in range(1, k + 1)) / k
    return s, c


def taylor(field, start, x, times, digits=34):
    """x at the times, of x' = field(t, x) (jets in, list of jets out), x = start values at time `start`."""
    order = int(1.2 * digits) + 6
    out = []
    with mp.workdps(digits + 12):
        t, x = mp.mpf(start), [mp.mpf(v) for v in x]
        for stop in (mp.mpf(s) for s in times):
            while t < stop:
                variables = [Jet(first=v) for v in x]
                now = t
                time = Jet(lambda k, c: now if k == 0 else mp.mpf(k == 1))
                rates = field(time, variables)
                for k in range(order):
                    new = [jet(r).get(k) / (k + 1) for r in rates]
                    for v, n in zip(variables, new):
                        v.c.append(n)
                size = max(1, max(abs(v) for v in x))
                h = stop - t
                for k in range(order - 7, order + 1):      # some vanish by symmetry
                    last = max(abs(v.c[k]) for v in variables)
                    if last > 0:
                        h = min(h, mp.mpf("0.9") * (mp.mpf(10) ** -(digits + 4) * size / last) ** (mp.mpf(1) / k))
                x = [mp.polyval(v.c[::-1], h) for v in variables]
                t = stop if t + h >= stop else t + h
            out.append(list(x))
    return out


def radau_points(s):
    """Zeros of the Radau polynomial of s stages, on (0, 1]; the last is 1."""
    p = [mp.mpf(0)] * (s - 1) + [mp.binomial(s, k) * (-1) ** (s - k) for k in range(s + 1)]
    for _ in range(s - 1):
        p = [k * p[k] for k in range(1, len(p))]
    return sorted(mp.re(r) for r in mp.polyroots(p[::-1], maxsteps=500, extraprec=600))


def radau(field, jacobian, x, steps, stages=12, digits=34):
    """x after each of the steps (t, h), by collocation at the zeros of the Radau polynomial, of order 2 stages - 1."""
    with mp.workdps(digits + 10):
        s, n = stages, len(x)
        c = radau_points(s)
        V = mp.matrix(s, s)
        W = mp.matrix(s, s)
        for i in range(s):
            for k in range(s):
                V[i, k] = c[i] ** k
                W[i, k] = c[i] ** (k + 1) / (k + 1)
        A = W * V ** -1
        x, out = [mp.mpf(v) for v in x], []
        for t, h in steps:
            z = [[mp.mpf(0)] * n for _ in range(s)]
            for _ in range(60):
                f = [field(t + c[i] * h, [a + b for a, b in zip(x, z[i])]) for i in range(s)]
                J = [jacobian(t + c[i] * h, [a + b for a, b in zip(x, z[i])]) for i in range(s)]
                M, r = mp.eye(s * n), mp.matrix(s * n, 1)
                for i in range(s):
                    for k in range(n):
                        r[i * n + k] = h * mp.fsum(A[i, j] * f[j][k] for j in range(s)) - z[i][k]
                        for j in range(s):
                            for q in range(n):
                                M[i * n + k, j * n + q] -= h * A[i, j] * J[j][k][q]
                d = mp.lu_solve(M, r)
                for i in range(s):
                    for k in range(n):
                        z[i][k] += d[i * n + k]
                if max(abs(v) for v in d) < mp.mpf(10) ** -(digits + 6):
                    break
            x = [a + b for a, b in zip(x, z[s - 1])]
            out.append(list(x))
        return out
