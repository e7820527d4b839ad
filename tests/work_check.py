"""The amount of work, without a clock: work_check.py BUILD_DIR

`work.counts` says how much was evaluated. Compared with each other, and with the size of what was reduced, these numbers are the
same on every machine: a search that runs where it has nothing to find shows here. Stages are told apart and add up."""
import sys

import cases
from solver import Solver
from tally import Tally, build_folder

sys.path.insert(0, __file__.rsplit("/", 1)[0] + "/bench")
import chain  # noqa: E402

PENDULUM = {"system": {"form": "equations", "variables": ["x", "y", "lam"], "parameters": {"g": "9.81"},
                       "equations": ["x'' = -lam*x", "y'' = -lam*y - g", "x^2 + y^2 = 1"]}}
CIRCUIT = {"system": {"form": "equations", "variables": ["v", "i", "j"], "parameters": {"C": None, "R": None, "U": None},
                      "equations": ["C*v' = i", "v + R*j = U", "i = j"]}}
STAGES = {"read", "operator", "mechanical", "reduction", "sampling", "texts", "strata", "signs", "witness", "structure", "symmetries",
          "initial", "trajectory", "sensitivities", "tradeoff", "linearization", "transfer", "equilibria", "derivation", "fit", "writing"}


def work(tally, solver, label, request):
    answer, problem = solver.solve(request)
    if not tally.check(answer, label, problem):
        return None
    w = answer["work"]
    seconds, total = dict(w["seconds"]), w["seconds"]["total"]
    del seconds["total"]
    tally.check(set(seconds) <= STAGES, f"{label}: stages", seconds)
    tally.check({"read", "reduction", "sampling", "texts", "witness", "writing"} <= set(seconds), f"{label}: those of every answer", seconds)
    tally.check(min(seconds.values()) >= 0 and abs(sum(seconds.values()) - total) < 1e-6 * total + 1e-9, f"{label}: they add up", w["seconds"])
    again = solver.solve(request)[0]["work"]
    tally.check(again["counts"] == w["counts"] and again["nodes"] == w["nodes"], f"{label}: the same work again", (w["counts"], again["counts"]))
    return w


def ratio(tally, label, a, b, most):
    tally.check(a <= most * b, label, f"{a} and {b}: {a / max(b, 1):.2f} times, at the most {most}")


def main():
    tally, solver = Tally("work"), Solver(build_folder())
    arm = next(c for c in cases.load([]) if c["name"] == "arm symbolic")["request"]
    done = {name: work(tally, solver, name, request) for name, request in
            (("arm", arm), ("pendulum", PENDULUM), ("circuit", CIRCUIT))}
    if all(done.values()):
        balls = {k: w["counts"]["balls"] for k, w in done.items()}
        terms = {k: w["counts"]["polynomial_terms"] for k, w in done.items()}
        ratio(tally, "the arm beside the pendulum, in balls", balls["arm"], balls["pendulum"], 4)
        ratio(tally, "the circuit beside the pendulum, in balls", balls["circuit"], balls["pendulum"], 2)
        ratio(tally, "the arm beside the pendulum, in terms of polynomials", terms["arm"], terms["pendulum"], 60)
        for name, w in done.items():
            ratio(tally, f"{name}: each node is evaluated so many times", balls[name], w["nodes"], 200)
    sizes, before = (4, 8, 16, 32), None
    for n in sizes:
        w = work(tally, solver, f"chain of {n}", {"system": chain.request(n)["system"], "want": ["constraints", "index", "vector_field"]})
        if w and before:
            for key in ("balls", "polynomial_terms"):
                ratio(tally, f"chain of {n} beside one of {n // 2}: {key}", w["counts"][key], before["counts"][key], 4)
            ratio(tally, f"chain of {n} beside one of {n // 2}: nodes", w["nodes"], before["nodes"], 2.5)
        before = w
    return tally.end()


if __name__ == "__main__":
    sys.exit(main())
