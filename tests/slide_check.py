"""Slides against a peer: slide_check.py BUILD_DIR

Random systems of two to four variables with one or two relays, linear between them and driven. The motion along surfaces is held against
SciPy's Radau on the same system with each relay as a steep tanh: in the limit that is Filippov's motion (along one surface; along two it is that of
the relays as unknowns). Each is asked for again with its relays spelt otherwise. SGA_TEST_SEED, SGA_TEST_SCALE."""
import random
import sys

import numpy as np
from scipy.integrate import solve_ivp

from solver import Solver
from tally import Tally, build_folder, scaled, seed

STEEP = 1e-7          # width of a tanh: the motions differ by some times as much
SPELT = ["sign({0})", "if({0} > 0, 1, -1)", "(2*step({0}) - 1)", "-sign(-2*({0}))"]


class Relays:
    def __init__(self, rng):
        self.n, m = rng.choice([2, 3, 4]), rng.choice([1, 1, 2])
        def draw(a, b, *shape):
            return np.reshape([round(rng.uniform(a, b), 2) for _ in range(int(np.prod(shape)))], shape)
        self.A, self.b, self.c, self.d = draw(-1.5, 1, self.n, self.n), draw(-2, 2, m, self.n), draw(-1, 1, m, self.n), draw(-0.5, 0.5, self.n)
        self.offset, self.start = draw(-0.3, 0.3, m), draw(-1, 1, self.n)

    def request(self, spelling):
        names = [f"x{k}" for k in range(self.n)]
        relay = [spelling.format(" + ".join(f"({c})*{v}" for c, v in zip(row, names)) + f" + ({o})") for row, o in zip(self.c, self.offset)]
        equations = [f"{v}' = " + " + ".join(f"({a})*{u}" for a, u in zip(row, names)) + "".join(f" + ({b})*{r}" for b, r in zip(self.b[:, i], relay)) + f" + ({self.d[i]})*sin(3*t)"
                     for i, (v, row) in enumerate(zip(names, self.A))]
        return {"system": {"form": "equations", "variables": names, "equations": equations}, "want": ["trajectory"], "limits": {"seconds": 60},
                "trajectory": {"stop": 3, "samples": 4, "initial": dict(zip(names, self.start)), "sliding": True}, "accuracy": {"rtol": 1e-8}}

    def peer(self):
        def field(t, x):
            return self.A @ x + np.tanh((self.c @ x + self.offset) / STEEP) @ self.b + self.d * np.sin(3 * t)

        def slope(_, x):
            return self.A + self.b.T @ (self.c / STEEP / np.cosh(np.minimum(np.abs((self.c @ x + self.offset) / STEEP), 300))[:, None] ** 2)
        return solve_ivp(field, [0, 3], self.start, method="Radau", jac=slope, rtol=1e-9, atol=1e-11, t_eval=[0, 1, 2, 3]).y.T


def one(tally, solver, label, relays, spelling):
    """The rows, and how many slides, of a motion that is the peer's."""
    result, wrong = solver.solve(relays.request(spelling))
    t = result and result["trajectory"]
    if not tally.check(t and t["ended"] is None and t["accuracy_reached"], f"{label}: reaches its end", wrong or t["ended"]):
        return None
    rows, peer = np.array(t["rows"])[:, 1:], relays.peer()
    off = np.abs(rows - peer).max() / max(1, np.abs(peer).max())
    tally.check(off < 300 * STEEP, f"{label}: the peer's motion", (off, relays.request(spelling)))
    for s in t["slides"]:
        tally.check(all(abs(v) <= 1 + 1e-6 for v in s["switch"]), f"{label}: the switch lies between its values", s)
    return rows, np.array(t["column_errors"]), len(t["slides"])


def main():
    tally, solver, slides = Tally("slides"), Solver(build_folder()), 0
    rng = random.Random(seed(20261125))
    for n in range(scaled(40)):
        relays = Relays(rng)
        a = one(tally, solver, f"relays {n}", relays, SPELT[0])
        b = one(tally, solver, f"relays {n}, spelt otherwise", relays, rng.choice(SPELT[1:]))
        if a and b:
            slides += a[2]
            tally.check(a[2] == b[2] and (np.abs(a[0] - b[0]).max(axis=0) <= 2 * (a[1] + b[1]) + 1e-9).all(), f"relays {n}: the same however spelt", (a, b))
    tally.check(slides >= scaled(6), "some of them slide", slides)
    return tally.end()


if __name__ == "__main__":
    sys.exit(main())
