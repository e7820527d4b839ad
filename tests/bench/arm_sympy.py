"""The telescopic arm with symbolic parameters, reduced in SymPy: the symbolic part alone,
timed in process (CPU seconds, best of three). Prints one line of JSON."""
import json
import os
import sys
from time import process_time

import sympy as sp

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), ".."))
import sympy_sga  # noqa: E402


def arm():
    phi, omega, x, v, tau1, tau2 = variables = sp.symbols("phi omega x v tau1 tau2")
    m0, m1, m2, m, l, R = sp.symbols("m0 m1 m2 m l R", positive=True)
    inertia = (m + m0 + (m1 + m2) / 3) * l**2 + (m0 + m2) * x**2 + (2 * m0 + m2) * l * x
    turn = (tau1 - (2 * (m0 + m2) * x + (2 * m0 + m2) * l) * omega * v) / inertia
    slide = (tau2 / R + omega**2 * (m2 * (x + l / 2) + m0 * (x + l))) / (m0 + m2)
    A = sp.diag(1, 1, 1, 1, 0, 0)
    return A, [omega, turn, v, slide, l + x - phi, 0], variables


def main():
    best = None
    for _ in range(3):
        sp.core.cache.clear_cache()
        A, alpha, variables = arm()
        start = process_time()
        answer = sympy_sga.reduce(A.tolist(), alpha, variables)
        best = min(best or 1e9, process_time() - start)
    assert answer["generations"] == [5, 4, 3] and len(answer["gauge"]) == 1, answer
    print(json.dumps({"seconds": best, "sympy": sp.__version__}))


if __name__ == "__main__":
    main()
