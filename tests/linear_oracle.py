"""The reduction of A x' = B x + c with constant rational A, B, c, by exact elimination.

A second route for verdict, dimensions, index and gauge dimension: affine subspaces are
kept as rows (r | s) for r x + s = 0, all in fractions.
"""
from fractions import Fraction

import linear


def reduce(A, B, c, restrict=()):
    """restrict: rows (r..., s). Returns {"verdict", "generations", "gauge", "inconsistent"}."""
    n = len(B[0]) if B else len(restrict[0]) - 1
    held = []                 # independent rows (r | s)
    dims = []
    new = [list(map(Fraction, r)) for r in restrict]
    first = True
    while True:
        stacked = [list(map(Fraction, r)) for r in A] + ([] if first else [r[:n] for r in held])
        for z in linear.left_kernel(stacked) if stacked else []:
            row = [sum(z[i] * Fraction(B[i][j]) for i in range(len(A))) for j in range(n)]
            new.append(row + [sum(z[i] * Fraction(c[i]) for i in range(len(A)))])
        before = len(held)
        held, empty = independent(held + new, n)
        if empty:
            return {"verdict": "inconsistent", "generations": dims, "final": None, "gauge": None}
        if len(held) == before:
            if not first or not restrict:
                break
        else:
            dims.append(n - len(held))
        new, first = [], False
    gauge = n - linear.rank([list(map(Fraction, r)) for r in A] + [r[:n] for r in held]) if A or held else n
    final = n - len(held)
    verdict = "isolated" if final == 0 else "underdetermined" if gauge else "unique"
    return {"verdict": verdict, "generations": dims, "final": final, "gauge": gauge}


def independent(rows, n):
    """Rows that are independent as equations, and whether they contradict each other."""
    work, pivots = linear.eliminate(rows, n)
    return work[:len(pivots)], any(r[n] != 0 for r in work[len(pivots):])
