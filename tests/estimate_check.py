"""Error estimates over random motions: estimate_check.py BUILD_DIR

Ten families of smooth motions (pendulums, orbits, chaos, relaxation, a rotor, index 1 to 3, tables) from random starts over random times, at random tolerances from
1e-4 to 1e-11, beside the same motion in double-double. The estimate has to hold in 98.5 % of all samples and (but for five) in 95 % of each family's, and where it does not the
error is less than ten times as large in all but one motion of a hundred; in the median it is not more than 60 times the error. SGA_TEST_SEED, SGA_TEST_SCALE:
the part of the motions."""
import math
import random
import statistics
import sys

from solver import Solver
from tally import Tally, build_folder, scaled, seed

MOTIONS, SAMPLES = 40, 20
FINE = {"rtol": 1e-20, "atol": 1e-20, "arithmetic": "double-double"}


def equations(variables, *lines):
    return {"form": "equations", "variables": variables.split(), "equations": list(lines)}


ORBIT = ("x y u v", "x' = u", "y' = v", "u' = -x/(x^2 + y^2)^(3/2)", "v' = -y/(x^2 + y^2)^(3/2)")


def at_pericentre(e):
    return {"x": 1 - e, "y": 0, "u": 0, "v": math.sqrt((1 + e) / (1 - e))}


def families(rng, long):
    """(name, system, start, length of time)"""
    u = rng.uniform
    angle, rate, e = u(-2.5, 2.5), u(-2, 2), u(0, 0.8)
    yield ("pendulum of index 3", equations("x y u v L", "x' = u", "y' = v", "u' = -L*x", "v' = -L*y - 9.81", "x^2 + y^2 = 1"),
           {"x": math.sin(angle), "y": -math.cos(angle), "u": rate * math.cos(angle), "v": rate * math.sin(angle)}, u(5, 15))
    yield ("double pendulum", equations("a b p q", "a' = p", "b' = q", "2*p' + cos(a - b)*q' + sin(a - b)*q^2 + 2*9.81*sin(a) = 0",
                                        "cos(a - b)*p' + q' - sin(a - b)*p^2 + 9.81*sin(b) = 0"), {name: u(-1, 1) for name in "abpq"}, u(2, 6))
    yield "orbit", equations(*ORBIT), at_pericentre(e), u(10, 40)
    if long:      # errors of the energy, small beside those of the place, make these grow with the square of time
        yield "orbit of long times", equations(*ORBIT), at_pericentre(e), u(300, 3000)
    yield ("chaos", equations("x y z", "x' = 10*(y - x)", "y' = x*(28 - z) - y", "z' = x*y - 8*z/3"), {"x": u(-5, 5), "y": u(-5, 5), "z": u(15, 25)}, u(3, 8))
    yield ("relaxation", equations("x y", "x' = y", f"y' = {u(0.5, 4):.3f}*(1 - x^2)*y - x"), {"x": u(-2, 2), "y": u(-2, 2)}, u(5, 15))
    yield ("foxes and rabbits", equations("x y", "x' = x*(2 - y)", "y' = y*(x - 1)"), {"x": u(0.5, 3), "y": u(0.5, 3)}, u(5, 15))
    yield ("rotor", equations("a b c", f"a' = {u(0.5, 2):.2f}*b*c", "b' = -a*c", "c' = -0.51*a*b + 0.1*cos(t)"), {"a": u(-1, 1), "b": u(0.1, 1), "c": u(-1, 1)}, u(10, 30))
    yield ("index 1, damped", equations("x y z", "x' = -3*x + sin(t)", "y' = x - z", "z = y + y^3 + exp(-x)/9"), {"x": u(-1, 1), "y": u(0.5, 1)}, u(5, 15))


def driven(rng):
    """A pendulum of index 3 that is pushed as a table says: at its knots series end, distances do not."""
    system = equations("x y u v L", "x' = u", "y' = v", "u' = -L*x + w", "v' = -L*y - 9.81", "x^2 + y^2 = 1")
    system["tables"] = {"w": {"times": [0, 1, 2, 3.5, 5, 7, 10], "values": [round(rng.uniform(-2, 2), 2) for _ in range(7)]}}
    return "driven by a table", system, {"x": 0.6, "y": -0.8, "u": 0, "v": 0}, rng.uniform(4, 10)


def number(x):
    return float(getattr(x, "text", x))


class Family:
    def __init__(self):
        self.held = self.samples = self.motions = self.far = 0
        self.ratios = []

    def add(self, rows, errors, reference):
        worst = math.inf
        for row, error, truth in zip(rows, errors, reference):
            off = max(abs(number(x) - r) for x, r in zip(row[1:], truth))
            ratio = math.inf if error is None else error / max(off, 1e-17)
            self.held += ratio >= 1
            self.ratios.append(ratio)
            worst = min(worst, ratio)
        self.samples += len(rows)
        self.motions += 1
        self.far += worst < 0.1


def main():
    tally, solver, known = Tally("estimate"), Solver(build_folder()), {}
    base = seed(20261128)
    for k in range(scaled(MOTIONS)):
        rng = random.Random(f"{base} {k}")
        for name, system, start, length in [*families(rng, k % 4 == 0), driven(rng)]:
            request = {"system": system, "want": ["trajectory"], "trajectory": {"times": [length * (i + 1) / SAMPLES for i in range(SAMPLES)], "initial": start}}
            tol = 10 ** rng.uniform(-11, -4)
            fine, problem = solver.solve({**request, "accuracy": FINE})
            if not tally.check(fine and not fine["trajectory"]["ended"], f"{name} {k}: in double-double", problem or fine["trajectory"]["ended"]):
                continue
            reference = [[number(x) for x in row[1:]] for row in fine["trajectory"]["rows"]]
            result, problem = solver.solve({**request, "accuracy": {"rtol": tol, "atol": tol, "arithmetic": "double", **({"method": "taylor"} if "tables" in system else {})}})
            t = result and result["trajectory"]
            if tally.check(t and not t["ended"] and len(t["rows"]) == SAMPLES, f"{name} {k} at {tol:.2g}", problem or t["ended"]):
                known.setdefault(name, Family()).add(t["rows"], t["errors"], reference)
    together = Family()
    for name, f in known.items():
        tally.check(f.held >= 0.95 * f.samples - SAMPLES / 4, f"{name}: estimates hold", f"{f.held} of {f.samples}")
        for member in ("held", "samples", "motions", "far", "ratios"):
            setattr(together, member, getattr(together, member) + getattr(f, member))
    median = statistics.median(together.ratios)
    print(f"{together.motions} motions: the estimate holds in {100 * together.held / together.samples:.2f} % of {together.samples} samples, is {median:.0f} times the error "
          f"in the median; less than a tenth of it somewhere in {together.far}")
    tally.check(together.held >= 0.985 * together.samples, "estimates hold", f"{together.held} of {together.samples}")
    tally.check(together.far <= 1 + together.motions / 100, "errors far above their estimates", together.far)
    tally.check(1 < median < 60, "estimates are not too large", median)
    return tally.end()


if __name__ == "__main__":
    sys.exit(main())
