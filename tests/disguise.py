"""The same system in other words: row operations, other names and orders, other coordinates, other units.

A System is A x' = alpha (with `restrict`) in format strings: "{0}" is the first variable, "{t}"
is time. A disguise returns the new system and the map of its points back to the old ones with
its inverse, so that a final set can be compared point by point.
"""
from fractions import Fraction

import mpmath

from problem import Problem
from symbolic import Derivatives

LONGEST = 20000    # characters of one entry: what a disguise may make of it


class TooLong(Exception):
    pass


class System:
    def __init__(self, A, alpha, n, restrict=(), parameters=None):
        self.A, self.alpha, self.n = A, alpha, n
        self.restrict, self.parameters = list(restrict), dict(parameters or {})

    def like(self, A, alpha, restrict=None):
        return System(A, alpha, self.n, self.restrict if restrict is None else restrict, self.parameters)

    def request(self, names, time="t", initial=None):
        def put(e):
            return e.format(*names, t=time)
        system = {"form": "quasilinear", "variables": names, "A": [[put(e) for e in r] for r in self.A],
                  "alpha": [put(e) for e in self.alpha]}
        if time != "t":
            system["time"] = time
        if self.restrict:
            system["restrict"] = [put(e) for e in self.restrict]
        if self.parameters:
            system["parameters"] = self.parameters
        out = {"system": system, "want": ["constraints", "index", "vector_field", "gauge"]}
        if initial:
            start = initial.get(time, 0)
            out["trajectory"] = {"start": start, "stop": start + 1, "initial": {n: initial[n] for n in names}}
        return out

    def moves(self):
        return any("{t}" in e for e in [e for r in self.A for e in r] + self.alpha + self.restrict)

    def polynomial(self):
        """Whether no function is called and no root taken."""
        texts = [e for r in self.A for e in r] + self.alpha + self.restrict
        return not any(f + "(" in e for e in texts
                       for f in "sin cos tan exp log sqrt cbrt sinh cosh tanh abs sign atan2 min max asin acos atan".split()) \
            and not any("^(" in e or "pi" in e for e in texts)


def of_request(request, listed):
    """The System of any form, by the checkers' own reader; listed: the names of the result's variables."""
    problem = Problem(request, listed if request["system"]["form"] == "equations" else None)
    g, d = problem.graph, Derivatives(problem.graph)
    place = {n: f"{{{i}}}" for i, n in enumerate(problem.names)}
    place[problem.time] = "{t}"
    A, alpha = [], []
    for row in problem.rows:
        A.append([text(g, d.of(row, "@" + n), place) for n in problem.names])
        alpha.append(text(g, d.sub(g.const(0), still(g, d, row)), place))
    return problem.names, System(A, alpha, len(problem.names), [text(g, e, place) for e in problem.restrict],
                                 {p: None for p in problem.parameters})


def still(g, d, root):
    """The node with all velocities 0."""
    new = {}
    for e in g.cone([root]):
        op, *args = g.node[e]
        if op == "sym":
            new[e] = g.const(0) if args[0].startswith("@") else e
        elif op in ("const", "pi"):
            new[e] = e
        else:
            a = [new[k] for k in args]
            new[e] = {"+": d.add, "-": d.sub, "*": d.mul}[op](*a) if op in "+-*" else g.make(op, *a)
    return new[root]


def text(g, root, place):
    """A node as a format string."""
    out = {}
    for e in g.cone([root]):
        op, *args = g.node[e]
        a = [out[k] for k in args] if op not in ("const", "sym", "pi") else args
        if op == "const":
            out[e] = str(a[0]) if a[0].denominator == 1 and a[0] >= 0 else f"({a[0]})"
        elif op == "sym":
            out[e] = place.get(a[0], a[0])
        elif op == "pi":
            out[e] = "pi"
        elif op == "neg":
            out[e] = f"(-{a[0]})"
        elif op in "+-*/^":
            out[e] = f"({a[0]} {op} {a[1]})"
        else:
            out[e] = f"{op}({', '.join(a)})"
        if len(out[e]) > LONGEST:
            raise TooLong
    return out[root]


def combine(weights, texts):
    """A linear combination of texts; "0" where nothing is left."""
    parts = [f"({w})*({t})" for w, t in zip(weights, texts) if w not in (0, "0") and t != "0"]
    out = " + ".join(parts) or "0"
    if len(out) > LONGEST:
        raise TooLong
    return out


def unimodular(rng, n):
    """An invertible integer matrix, from a few elementary steps."""
    T = [[int(i == j) for j in range(n)] for i in range(n)]
    for _ in range(min(n, 6)):
        i, j = rng.randrange(n), rng.randrange(n)
        if i != j:
            k = rng.choice([-2, -1, 1, 2])
            T[i] = [a + k * b for a, b in zip(T[i], T[j])]
    rng.shuffle(T)
    return T


def same_point(x, t):
    return x, t


# Rows

def mix_rows(rng, s):
    P = unimodular(rng, len(s.A))
    return s.like([[combine(p, [r[j] for r in s.A]) for j in range(s.n)] for p in P], [combine(p, s.alpha) for p in P]), same_point, same_point


def row_factors(rng, s):
    """Rows times functions that never vanish, and multiples of rows by functions added to others."""
    A, alpha = [list(r) for r in s.A], list(s.alpha)
    for _ in range(2):
        k, j = rng.randrange(len(A)), rng.randrange(s.n)
        f = rng.choice(["2 + {%d}^2", "exp({%d})", "3 + sin({%d})", "1/(1 + {%d}^2)"]) % j if rng.random() < 0.8 else "2 + {t}^2"
        A[k], alpha[k] = [combine([f], [e]) for e in A[k]], combine([f], [alpha[k]])
    if len(A) > 1:
        i, k = rng.sample(range(len(A)), 2)
        f = rng.choice(["{%d}", "{%d}^2 - 1", "sin({%d})", "1 - {%d}"]) % rng.randrange(s.n)
        A[i] = [combine([1, f], [a, b]) for a, b in zip(A[i], A[k])]
        alpha[i] = combine([1, f], [alpha[i], alpha[k]])
    return s.like(A, alpha), same_point, same_point


def repeat_row(rng, s):
    k = rng.randrange(len(s.A))
    return s.like(s.A + [[combine([3], [e]) for e in s.A[k]]], s.alpha + [combine([3], [s.alpha[k]])]), same_point, same_point


# Names and order

def reorder(rng, s):
    order = list(range(s.n))
    rng.shuffle(order)
    place = [f"{{{order.index(j)}}}" for j in range(s.n)]
    rows = list(range(len(s.A)))
    rng.shuffle(rows)

    def put(e):
        return e.format(*place, t="{t}")
    return (s.like([[put(s.A[i][j]) for j in order] for i in rows], [put(s.alpha[i]) for i in rows], [put(e) for e in s.restrict]),
            lambda y, t: ([y[order.index(j)] for j in range(s.n)], t), lambda x, t: ([x[j] for j in order], t))


# Coordinates

def substitute(s, old, jacobian, drift=None, time="{t}", pace=1):
    """x = old(y): A(old) J y' = alpha(old) - A(old) drift; pace: dt_old / dt_new."""
    def put(e):
        out = e.format(*old, t=time)
        if len(out) > LONGEST:
            raise TooLong
        return out
    moved = [[put(e) for e in r] for r in s.A]
    A = [[combine([jacobian.get((k, j), 0) for k in range(s.n)], r) for j in range(s.n)] for r in moved]
    alpha = [put(e) for e in s.alpha]
    if drift:
        alpha = [combine([1] + ["-(" + d + ")" if d else 0 for d in drift], [a] + r) for a, r in zip(alpha, moved)]
    if pace != 1:
        alpha = [combine([pace], [a]) for a in alpha]
    return s.like(A, alpha, [put(e) for e in s.restrict])


def change_linear(rng, s):
    """x = T y + b"""
    T = unimodular(rng, s.n)
    b = [rng.choice([0, 0, 1, -2]) for _ in range(s.n)]
    old = ["(" + combine(r, [f"{{{j}}}" for j in range(s.n)]) + (f" + {c}" if c else "") + ")" for r, c in zip(T, b)]
    inverse = exact_inverse(T)
    return (substitute(s, old, {(k, j): T[k][j] for k in range(s.n) for j in range(s.n)}),
            lambda y, t: ([sum(a * v for a, v in zip(r, y)) + c for r, c in zip(T, b)], t),
            lambda x, t: ([sum(mpmath.mpf(a.numerator) / a.denominator * (v - c) for a, v, c in zip(r, x, b)) for r in inverse], t))


def exact_inverse(T):
    import linear
    return linear.inverse([[Fraction(a) for a in r] for r in T])


SHEARS = [("{j}^2", "2*{j}", lambda v: v * v), ("{j}*{j}*{j}/3", "{j}^2", lambda v: v ** 3 / 3), ("sin({j})", "cos({j})", mpmath.sin)]


def change_shear(rng, s, shears=SHEARS):
    """x_i = y_i + c p(y_j) for one or two pairs: invertible everywhere."""
    old, J, steps = [f"{{{k}}}" for k in range(s.n)], {(k, k): 1 for k in range(s.n)}, []
    if s.n < 2:
        return s, same_point, same_point
    order = rng.sample(range(s.n), min(s.n, 3))
    for i, j in zip(order[1:], order):    # the first of the order stays, each other one moves by the one before it
        p, dp, f = rng.choice(shears)
        c = rng.choice([-1, 1, 2])
        old[i] = f"({{{i}}} + {c}*({p.format(j='{%d}' % j)}))"
        J[i, j] = f"{c}*({dp.format(j='{%d}' % j)})"
        steps.append((i, j, c, f))

    def back(y, t):
        x = list(y)
        for i, j, c, f in steps:
            x[i] = y[i] + c * f(y[j])
        return x, t

    def forth(x, t):
        y = list(x)
        for i, j, c, f in steps:    # in order: y[j] is known when it is used
            y[i] = x[i] - c * f(y[j])
        return y, t
    return substitute(s, old, J), back, forth


def change_polynomial(rng, s):
    return change_shear(rng, s, SHEARS[:2])


def change_sinh(rng, s):
    """x_i = sinh(y_i)"""
    i = rng.randrange(s.n)
    old = [f"{{{k}}}" if k != i else f"sinh({{{k}}})" for k in range(s.n)]
    J = {(k, k): 1 if k != i else f"cosh({{{i}}})" for k in range(s.n)}
    return (substitute(s, old, J), lambda y, t: ([mpmath.sinh(v) if k == i else v for k, v in enumerate(y)], t),
            lambda x, t: ([mpmath.asinh(v) if k == i else v for k, v in enumerate(x)], t))


def change_moving(rng, s):
    """x_i = y_i + f(t): a system at rest becomes one that depends on time"""
    i = rng.randrange(s.n)
    f, df, value = rng.choice([("sin({t})", "cos({t})", mpmath.sin), ("{t}^2", "2*{t}", lambda t: t * t)])
    old = [f"{{{k}}}" if k != i else f"({{{k}}} + {f})" for k in range(s.n)]
    return (substitute(s, old, {(k, k): 1 for k in range(s.n)}, [df if k == i else 0 for k in range(s.n)]),
            lambda y, t: ([v + value(t) if k == i else v for k, v in enumerate(y)], t),
            lambda x, t: ([v - value(t) if k == i else v for k, v in enumerate(x)], t))


# Units

def power(k):
    return f"1e{k}"


def units(rng, s, largest):
    """x_i = 10^a_i y_i and rows times powers of ten"""
    def pick():
        return rng.choice([0, rng.randint(-largest, largest)])
    a = [pick() for _ in range(s.n)]
    old = [f"({power(k)}*{{{i}}})" if k else f"{{{i}}}" for i, k in enumerate(a)]
    out = substitute(s, old, {(i, i): power(k) for i, k in enumerate(a)})
    rows = [power(pick()) for _ in out.A]
    out = out.like([[combine([w], [e]) for e in r] for w, r in zip(rows, out.A)], [combine([w], [e]) for w, e in zip(rows, out.alpha)])
    return (out, lambda y, t: ([v * mpmath.mpf(10) ** k for v, k in zip(y, a)], t),
            lambda x, t: ([v / mpmath.mpf(10) ** k for v, k in zip(x, a)], t))


def units_small(rng, s):
    return units(rng, s, 3)


def units_large(rng, s):
    return units(rng, s, 150)


def scale_rows(rng, s):
    rows = [power(rng.choice([0, rng.randint(-150, 150)])) for _ in s.A]
    return (s.like([[combine([w], [e]) for e in r] for w, r in zip(rows, s.A)], [combine([w], [e]) for w, e in zip(rows, s.alpha)]),
            same_point, same_point)


def scale_time(rng, s):
    """t = 10^k s"""
    k = rng.choice([-2, -1, 1, 2])
    return (substitute(s, [f"{{{i}}}" for i in range(s.n)], {(i, i): 1 for i in range(s.n)}, None, f"({power(k)}*{{t}})", power(k)),
            lambda y, t: (y, t * mpmath.mpf(10) ** k), lambda x, t: (x, t / mpmath.mpf(10) ** k))
