"""Small dense linear algebra over mpmath numbers or fractions, with explicit ranks.

A matrix is a list of rows. Numeric ranks equilibrate rows first and pivot fully; what is
left below `tiny` counts as zero, and so does a row that is all below it: callers pass
numbers with many more digits than that.
"""
from fractions import Fraction


def _scale(row):
    return max((abs(a) for a in row), default=0)


def eliminate(rows, cols, tiny=0, equilibrate=True):
    """Row echelon form by full pivoting over the first `cols` columns; the columns past
    them are carried along. Returns (reduced rows, [(row, column) of each pivot])."""
    work = []
    for r in rows:
        s = _scale(r[:cols]) if equilibrate and tiny else 1
        work.append([a / s for a in r] if s > tiny else list(r))
    pivots = []
    top = 0
    while top < len(work):
        best, where = tiny, None
        for i in range(top, len(work)):
            for j in range(cols):
                if abs(work[i][j]) > best:
                    best, where = abs(work[i][j]), (i, j)
                    if tiny == 0:
                        break
            if where and tiny == 0:
                break
        if not where:
            break
        i, j = where
        work[top], work[i] = work[i], work[top]
        p = work[top][j]
        work[top] = [a / p for a in work[top]]
        for k in range(len(work)):
            if k != top and work[k][j] != 0:
                f = work[k][j]
                work[k] = [a - f * b for a, b in zip(work[k], work[top])]
                work[k][j] = p * 0
        pivots.append((top, j))
        top += 1
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
        gram = [[sum(a * b for a, b in zip(u, v)) for v in kernel] for u in kernel]
        c = solve(gram, [-sum(a * b for a, b in zip(u, x)) for u in kernel], tiny)[0]
        for k, v in zip(c, kernel):
            x = [a + k * b for a, b in zip(x, v)]
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
