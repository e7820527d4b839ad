"""The corpus in SymPy, timed case by case in one warm process: corpus_sympy.py BUILD_DIR SECONDS

The reduction of sympy_sga.py, from matrices to constraints, gauge fields and one field X (no
texts read or written, no witness), in CPU seconds with SymPy's cache emptied before each case,
for the cases where it gives the verdict and dimensions that the case expects within SECONDS.
Prints one line of JSON: {name: {"seconds", "request"}}.
"""
import json
import os
import signal
import sys
from time import process_time

import sympy as sp

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), ".."))
import cases  # noqa: E402
import sympy_check  # noqa: E402
import sympy_sga  # noqa: E402
from problem import Problem  # noqa: E402
from solver import Solver  # noqa: E402


class Late(Exception):
    pass


def late(*_):
    raise Late


def seconds(request, names, expect, limit):
    """CPU seconds, or None where SymPy does not give the answer."""
    try:
        signal.setitimer(signal.ITIMER_VIRTUAL, limit)
        problem = Problem(request, names if request["system"]["form"] == "equations" else None)
        A, alpha, restrict, symbols = sympy_check.symbolic(problem)
        variables = [symbols[n] for n in problem.names]
        sp.core.cache.clear_cache()
        begun = process_time()
        answer = sympy_sga.reduce(A, alpha, variables, restrict, symbols[problem.time])
        took = process_time() - begun
    except Exception:    # what it cannot do is left out
        return None
    finally:
        signal.setitimer(signal.ITIMER_VIRTUAL, 0)
    right = answer["verdict"] == expect["verdict"] and answer["generations"] == expect["generations"]
    return took if right else None


def main():
    signal.signal(signal.SIGVTALRM, late)
    limit, out, solver = float(sys.argv[2]), {}, Solver(os.path.abspath(sys.argv[1]))
    for case in cases.reduced(sys.argv[3:]):
        expect = case["expect"]
        if "verdict" not in expect or "generations" not in expect:
            continue
        request = {"system": case["request"]["system"], "want": ["constraints", "index", "vector_field", "gauge"]}
        result, problem = solver.solve(request)
        if problem or result["verdict"] != expect["verdict"] or result["dimensions"]["generations"] != expect["generations"]:
            continue
        took = seconds(request, [v["name"] for v in result["variables"]] if "variables" in result else None, expect, limit)
        if took is not None:
            out[case["name"]] = {"seconds": took, "request": request}
    print(json.dumps(out))


if __name__ == "__main__":
    main()
