"""Every spelling of an expression is one expression to a decision: spelling_check.py BUILD_DIR [NAME...]

Systems whose answers rest on signs (tests/cases/definite.json; others by their names) are asked in ten spellings each,
made at random (respell.py): factors in any order, powers as products, nested quotients, sums taken apart. Verdict,
dimensions, kinds of strata and the code of a refusal must be those of the case as it is written. SGA_TEST_SEED repeats
a run, SGA_TEST_SCALE asks in more spellings.
"""
import json
import os
import random
import sys

import cases
from respell import Speller, Tree, on_sides
from solver import Solver
from tally import ROOT, Tally, build_folder, scaled, seed

SPELLINGS = 10
LISTS, TEXTS = ("equations", "alpha", "restrict", "constraints"), ("lagrangian", "hamiltonian")


def listed(patterns):
    if patterns:
        return cases.load(patterns)
    with open(os.path.join(ROOT, "tests", "cases", "definite.json"), encoding="utf-8") as f:
        return json.load(f)


def respelled(request, speller):
    def change(text):
        return on_sides(text, lambda part: Tree(part).text(speller=speller)) if isinstance(text, str) else text
    system = dict(request["system"])
    for key in LISTS:
        if key in system:
            system[key] = [change(text) for text in system[key]]
    for key in TEXTS:
        if key in system:
            system[key] = change(system[key])
    return {**request, "system": system}


def said(result, problem):
    if problem:
        return problem["code"]
    return result["verdict"], result["dimensions"], sorted(s["kind"] for s in result.get("strata", []))


def main():
    tally, solver, rng = Tally("spelling"), Solver(build_folder()), random.Random(seed(11))
    for case in listed(sys.argv[2:]):
        given = said(*solver.solve(case["request"]))
        for _ in range(scaled(SPELLINGS)):
            request = respelled(case["request"], Speller(random.Random(rng.random())))
            answer = said(*solver.solve(request))
            tally.check(answer == given, case["name"], f"{answer}, should be {given}: {json.dumps(request)}")
    return tally.end()


if __name__ == "__main__":
    sys.exit(main())
