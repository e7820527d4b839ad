"""Operators over Q(t), D a = a D + a', in SymPy's exact fractions: a second implementation.

An operator is a list of coefficients [a0, a1, ...] (none trailing zero), a matrix a list of rows.
"""
from sympy import QQ, sympify
from sympy.polys.fields import field

K, t = field("t", QQ)


def number(text):
    """An element of Q(t) from a text of the grammar or a number."""
    return K.from_expr(sympify(str(text).replace("^", "**"), rational=True))


def derive(a):
    return a.diff(t) if a else K.zero


def trim(a):
    a = list(a)
    while a and not a[-1]:
        a.pop()
    return a


def add(a, b, sign=1):
    n = max(len(a), len(b))
    return trim([(a[i] if i < len(a) else K.zero) + sign * (b[i] if i < len(b) else K.zero) for i in range(n)])


def mul(a, b):
    out, power = [], list(b)
    for i, c in enumerate(a):
        if i:
            power = add([K.zero] + power, [derive(x) for x in power])
        if c:
            out = add(out, [c * x for x in power])
    return out


def product(A, B):
    out = []
    for row in A:
        line = []
        for j in range(len(B[0]) if B else 0):
            entry = []
            for k, x in enumerate(row):
                entry = add(entry, mul(x, B[k][j]))
            line.append(entry)
        out.append(line)
    return out


def identity(n):
    return [[[K.one] if i == j else [] for j in range(n)] for i in range(n)]


def read(matrix):
    """A matrix of operators from lists of coefficient texts."""
    return [[trim([number(c) for c in entry]) for entry in row] for row in matrix]


def plain(matrix):
    """A matrix over Q(t) from texts."""
    return [[number(c) for c in row] for row in matrix]


def of_system(coefficients):
    """sum A_i D^i"""
    A = [plain(m) for m in coefficients]
    p = len(A[0])
    return [[trim([m[i][j] for m in A]) for j in range(p)] for i in range(p)]


def times(A, B):
    return [[sum((x * B[k][j] for k, x in enumerate(row)), K.zero) for j in range(len(B[0]) if B else 0)] for row in A]


def plus(A, B):
    return [[x + y for x, y in zip(r, s)] for r, s in zip(A, B)]


def derived(A):
    return [[derive(x) for x in r] for r in A]


def zeros(rows, cols):
    return [[K.zero] * cols for _ in range(rows)]
