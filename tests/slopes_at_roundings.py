"""Derivatives of a pendulum that begins level, by what its start is given as: roundings of 0 (6e-17 for cos(pi/2)) change none (sensitivities_check.py)."""
import itertools

CONSTRAINTS = ["x^2 + y^2 = 1", "1/(x^2 + y^2) = 1"]
STARTS = [(6e-17, 0.0), (0.0, 1e-16), (6e-17, -1.02e-16)]


def check(tally, solver):
    for constraint, gravity, by in itertools.product(CONSTRAINTS, (0, 9.81), ("x", "y", "x'", "y'")):
        def rows(y, rate):
            system = {"form": "equations", "variables": ["x", "y", "l"], "equations": ["x'' = -l*x", f"y'' = -l*y - {gravity}", constraint]}
            trajectory = {"stop": 0.5, "samples": 3, "initial": {"x": 1, "y": y, "x'": rate, "y'": 1.7}, "sensitivities": {"initial": [by]}}
            result, problem = solver.solve({"system": system, "want": ["trajectory"], "trajectory": trajectory})
            told = (result or {}).get("trajectory", {}).get("sensitivities")
            tally.check(told is not None and len(told["rows"]) == 3, f"{label}: answered to the end", str(problem or told or result["warnings"]))
            return told["rows"] if told else []
        label = f"roundings: {constraint}, gravity {gravity}, by {by}, zeros"
        plain = rows(0.0, 0.0)
        for y, rate in STARTS:
            label = f"roundings: {constraint}, gravity {gravity}, by {by}, from {y}, {rate}"
            for a, b in zip(plain, rows(y, rate)):
                off = max(abs(p - q) for p, q in zip(a, b))
                tally.check(off < 1e-8, label, f"at {a[0]} off by {off}: {a}, {b}")
