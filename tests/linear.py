"""Small dense linear algebra over mpmath numbers or fractions, with explicit ranks.

A matrix is a list of rows. Numeric ranks equilibrate rows first and pivot fully; what is
left below `tiny` counts as zero, and so does a row that is all below it: callers pass
numbers with many more digits than that.
"""
import math
from fractions import Fraction

import mpmath


def _scale(row):
    return max((abs(a) for a in row), default=0)


def _magnitude(a):
    """The binary exponent of a number of mpmath, without arithmetic."""
    parts = getattr(a, "_mpf_", None)
    if parts and parts[1]:
        return parts[2] + parts[3]
    zero = not parts[2] if parts else a == 0      # no mantissa and no exponent; infinities have one
    return -math.inf if zero else mpmath.mag(a)


def _largest(row, cols):
    """(magnitude, column) of the largest entry of a row, to a factor of two."""
    return max(((_magnitude(row[j]), -j) for j in range(cols)), default=(-math.inf, 0))


def _pivot(work, top, cols, tiny, largest):
    """(row, column) of an entry above `tiny`, the largest where numbers are rounded, or None."""
    if tiny == 0:
        return next(((i, j) for i in range(top, len(work)) for j in range(cols) if work[i][j] != 0), None)
    i = max(range(top, len(work)), key=lambda k: largest[k][0])
    j = -largest[i][1]
    if cols and abs(work[i][j]) > tiny:
        return i, j
    best, i, j = max(((abs(work[i][j]), i, j) for i in range(top, len(work)) for j in range(cols)), default=(0, 0, 0))
    return (i, j) if best > tiny else None


def eliminate(rows, cols, tiny=0, equilibrate=True):
    """Row echelon form by full pivoting over the first `cols` columns; the columns past
    them are carried along. Returns (reduced rows, [(row, column) of each pivot])."""
    work = []
    for r in rows:
        s = _scale(r[:cols]) if equilibrate and tiny else 1
        work.append([a / s for a in r] if s > tiny else list(r))
    largest = [_largest(r, cols) for r in work] if tiny else None
    pivots = []
    for top in range(len(work)):
        where = _pivot(work, top, cols, tiny, largest)
        if not where:
            break
        i, j = where
        work[top], work[i] = work[i], work[top]
        if tiny:
            largest[top], largest[i] = largest[i], largest[top]
        p = work[top][j]
        work[top] = [a / p if a else a for a in work[top]]
        filled = [(c, b) for c, b in enumerate(work[top]) if b]
        for k, row in enumerate(work):
            if k != top and row[j]:
                f = row[j]
                for c, b in filled:
                    row[c] -= f * b
                row[j] = p * 0
                if tiny:
                    largest[k] = _largest(row, cols)
        pivots.append((top, j))
    return work, pivots


def rank(rows, tiny=0):
    return len(eliminate(rows, len(rows[0]), tiny)[1]) if rows else 0


def solve(rows, right, tiny=0):
    """A solution of rows x = right (free unknowns 0) and a basis of the kernel, or None."""
    if not rows:
        return None
    n = len(rows[0])
    work, pivots = eliminate([list(r) + [b] for r, b in zip(rows, right)], n, tiny)
    size = max([1] + [abs(b) for b in right]) if tiny else 0
    for r in work[len(pivots):]:
        if abs(r[n]) > tiny * size:
            return None
    zero = work[0][n] * 0
    x, pivot_of = [zero] * n, {j: i for i, j in pivots}
    for j, i in pivot_of.items():
        x[j] = work[i][n]
    kernel = []
    for j in range(n):
        if j not in pivot_of:
            v = [zero] * n
            v[j] = zero + 1
            for c, i in pivot_of.items():
                v[c] = -work[i][j]
            kernel.append(v)
    return x, kernel


def least_norm(rows, right, tiny=0):
    """The solution of least Euclidean norm, or None where there is none."""
    found = solve(rows, right, tiny)
    if found is None:
        return None
    x, kernel = found
    if kernel:
        filled = [[(i, a) for i, a in enumerate(u) if a] for u in kernel]
        gram = [[sum(a * v[i] for i, a in u if v[i]) for v in kernel] for u in filled]
        c = solve(gram, [-sum(a * x[i] for i, a in u if x[i]) for u in filled], tiny)[0]
        for k, v in zip(c, filled):
            for i, a in v:
                x[i] += k * a
    return x


def left_kernel(rows):
    """Exact basis of { z : z^T rows = 0 } (fractions)."""
    m = len(rows)
    n = len(rows[0])
    work, pivots = eliminate([list(r) + [Fraction(int(i == k)) for k in range(m)] for i, r in enumerate(rows)], n)
    return [r[n:] for r in work[len(pivots):]]


def inverse(rows):
    n = len(rows)
    work, pivots = eliminate([list(r) + [Fraction(int(i == k)) for k in range(n)] for i, r in enumerate(rows)], n)
    if len(pivots) < n:
        return None
    out = [None] * n
    for i, j in pivots:
        out[j] = work[i][n:]
    return out
