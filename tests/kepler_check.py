"""Kepler's orbits with the distance as a variable, x^2 + y^2 = r^2, by each method against Kepler's equation: kepler_check.py BUILD_DIR

The constraint's pivot and the field's pole are both r, which no motion makes 0. A trial point of a step that is refused may have
r < 0, and steps by which methods are compared have such points; that must not end a motion. With r = sqrt(x^2 + y^2) there is no
such side: it is the second route."""
import sys

import mpmath

from solver import Solver
from tally import Tally, build_folder

ECCENTRICITIES = [5 + 4 * k for k in range(20)]    # hundredths
METHODS = ("auto", "dop853", "tsit5", "taylor", "radau")
TIMES = {"auto": [2, 63, 400]}                     # steps of trial come rarely
FEW_TIMES = [2, 63]
TOLERANCE = 1e-8
HELD = 0.95


def exact(e, t):
    """x, y, u, v, r of the orbit with the half axis 1 from its nearest point."""
    mean = mpmath.fmod(t, 2 * mpmath.pi)
    E = mpmath.findroot(lambda E: E - e * mpmath.sin(E) - mean, mean + e * mpmath.sin(mean), tol=1e-50)
    s, c, b = mpmath.sin(E), mpmath.cos(E), mpmath.sqrt(1 - e * e)
    r = 1 - e * c
    return [c - e, b * s, -s / r, b * c / r, r]


def request(hundredths, method, law, times):
    return {"system": {"form": "equations", "variables": ["x", "y", "u", "v", "r"],
                       "equations": ["x' = u", "y' = v", "u' = -x/r^3", "v' = -y/r^3", law]},
            "want": ["trajectory"], "accuracy": {"rtol": TOLERANCE, **({} if method == "auto" else {"method": method})},
            "trajectory": {"start": 0, "times": times,
                           "initial": {"x": f"{100 - hundredths}/100", "y": 0, "u": 0,
                                       "v": f"sqrt({100 + hundredths}/{100 - hundredths})", "r": f"{100 - hundredths}/100"}}}


def main():
    mpmath.mp.dps = 60
    tally, solver = Tally("kepler"), Solver(build_folder())
    held = samples = 0
    for hundredths in ECCENTRICITIES:
        should = [exact(mpmath.mpf(hundredths) / 100, mpmath.mpf(t)) for t in TIMES["auto"]]
        for method, law in [(m, "x^2 + y^2 = r^2") for m in METHODS] + [("auto", "r = sqrt(x^2 + y^2)")]:
            times = TIMES.get(method, FEW_TIMES)
            name = f"e = 0.{hundredths:02d}, {method}, {law}"
            result, problem = solver.solve(request(hundredths, method, law, times))
            t = result and result["trajectory"]
            if not tally.check(t and not t["ended"] and len(t["rows"]) == len(times), name, str(problem or t and t["ended"])):
                continue
            errors = [max(float(abs(mpmath.mpf(x) - s)) for x, s in zip(row[1:], one)) for row, one in zip(t["rows"], should)]
            # over all of the motion: by what is estimated tolerances are tightened until that holds
            tally.check(max(errors) < 10 * TOLERANCE, f"{name}: rows", f"errors {errors}")
            samples += len(errors)
            held += sum(is_ <= (said if said is not None else float("inf")) for is_, said in zip(errors, t["errors"]))
    print(f"{samples} samples: the estimate holds in {100 * held / max(samples, 1):.1f} %")
    tally.check(held >= HELD * samples > 0, "estimates hold", f"{held} of {samples}")
    return tally.end()


if __name__ == "__main__":
    sys.exit(main())
