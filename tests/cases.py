"""Runs every tests/cases/*.json: cases.py BUILD_DIR [NAME...]"""
import glob
import json
import os
import sys

from case_check import CaseCheck
from solver import Solver
from tally import ROOT, Tally, build_folder


def load(patterns):
    for path in sorted(glob.glob(os.path.join(ROOT, "tests", "cases", "*.json"))):
        with open(path, encoding="utf-8") as f:
            cases = json.load(f)
        for case in cases:
            if not patterns or any(p in case["name"] for p in patterns):
                yield case


def main():
    tally = Tally("cases")
    check = CaseCheck(tally, Solver(build_folder()))
    names = set()
    for case in load(sys.argv[2:]):
        tally.check(case["name"] not in names, case["name"], "two cases of one name")
        names.add(case["name"])
        if os.environ.get("SGA_TEST_VERBOSE"):
            print("#", case["name"], flush=True)
        check.run(case)
    print(f"{len(names)} cases")
    return tally.end()


if __name__ == "__main__":
    sys.exit(main())
