"""Runs every tests/cases/*.json: cases.py BUILD_DIR [NAME...]. SGA_TEST_EVERY=20: every twentieth of them. SGA_TEST_IDENTITIES=0:
without the identities at points, which cost most (another build gave the same answers and had them checked). SGA_TEST_LONGEST=BUILD_DIR:
without those that took longer than a second there: half of the time goes into a hundred of them.

A case says where it comes from (source) and may say how its expectations were found
(note)."""
import contextlib
import glob
import json
import multiprocessing
import os
import sys
import tempfile
import time

from case_check import CaseCheck
from solver import Solver
from tally import ROOT, Tally, build_folder

CITED = 150    # cases that cite a paper or a book, at the least


def load(patterns, but=()):
    for path in sorted(glob.glob(os.path.join(ROOT, "tests", "cases", "*.json"))):
        if os.path.basename(path) in but:
            continue
        with open(path, encoding="utf-8") as f:
            cases = json.load(f)
        for case in cases:
            if not patterns or any(p in case["name"] for p in patterns):
                yield case


# Whose point is what a plain reduction over the complex numbers cannot see: zeros that only simplification
# finds, sets whose real points are fewer, strata. They have checkers of their own.
# The checkers' own equations are pulled back by the restrictions as they stand, and vanish where those depend.
DEPENDENT = ("restrict with a function that follows", "restriction that is a square", "restriction that is a sum of squares",
             "restriction that follows from two others",
             "Appell-Hamel")     # open: its stratum x' = y' = z' = 0 is given by three functions, which the script for Singular takes one by one
BEYOND_PEERS = ("zero_identities.json", "regular.json", "strata.json", "structure.json", "findings.json", "tables.json", "tables_longer.json", "parameter_sweep.json",
                "definite.json", "components.json")


def reduced(patterns, but=BEYOND_PEERS):
    """The cases with an answer of the reduction; forms with a theory of their own have checkers of their own."""
    for case in load(patterns, but):
        if case["name"] in DEPENDENT or "redundant_constraint" in case["expect"].get("warnings", ()):    # a multiplier is chosen there
            continue
        if "error" not in case["expect"] and case.get("request", {}).get("system", {}).get("form") not in (None, "operator", "mechanical"):
            yield case


WORKERS = 2


def waiting(listed, taken):
    """The cases that no worker has taken yet."""
    while True:
        with taken.get_lock():
            k = taken.value
            taken.value += 1
        if k >= len(listed):
            return
        yield listed[k]


def share(listed, taken, out):
    """Cases as long as there are any, their output in a file; the counts are its last line."""
    sys.stdout = out
    tally = Tally("cases")
    check = CaseCheck(tally, Solver(build_folder()))
    for case in waiting(listed, taken):
        begun = time.monotonic()
        check.run(case)
        print("#", time.monotonic() - begun, case["name"])
    print(tally.passed, tally.failed, flush=True)


SECONDS = "case_seconds.json"
LONG = 1


def without_long(listed):
    """Those that another build has run in a second, or has not run."""
    other = os.environ.get("SGA_TEST_LONGEST")
    if not other or not os.path.exists(os.path.join(other, SECONDS)):
        return listed
    with open(os.path.join(other, SECONDS), encoding="utf-8") as f:
        seconds = json.load(f)
    return [case for case in listed if seconds.get(case["name"], 0) <= LONG]


def main():
    tally = Tally("cases")
    listed = list(load(sys.argv[2:]))
    names, cited, seconds = set(), 0, {}
    for case in listed:
        tally.check(case["name"] not in names, case["name"], "two cases of one name")
        names.add(case["name"])
        cited += not case.get("source", "own: ").startswith("own: ")
    listed = listed[::int(os.environ.get("SGA_TEST_EVERY", "1"))]
    listed = without_long(listed)
    listed.sort(key=lambda case: len(json.dumps(case)), reverse=True)    # long ones first: no worker waits for the other at the end
    taken = multiprocessing.Value("i", 0)
    with contextlib.ExitStack() as stack:
        out = [stack.enter_context(tempfile.TemporaryFile("w+", encoding="utf-8")) for _ in range(WORKERS)]
        workers = [multiprocessing.Process(target=share, args=(listed, taken, out[k])) for k in range(WORKERS)]
        for w in workers:
            w.start()
        for k, w in enumerate(workers):
            w.join()
            out[k].seek(0)
            *said, counts = out[k].read().splitlines() or [""]
            for line in said:
                if line.startswith("# "):
                    _, took, name = line.split(" ", 2)
                    seconds[name] = float(took)
            said = [line for line in said if not line.startswith("# ")]
            print("\n".join(said), end="\n" if said else "")
            if not tally.check(w.exitcode == 0, f"worker {k}", f"ended with {w.exitcode}: {counts}"):
                continue
            passed, failed = map(int, counts.split())
            tally.passed += passed
            tally.failed += failed
    if not sys.argv[2:]:
        with open(os.path.join(build_folder(), SECONDS), "w", encoding="utf-8") as f:
            json.dump(seconds, f)
    print(f"{len(names)} cases, {cited} of them from the literature")
    tally.check(sys.argv[2:] or cited >= CITED, "cases from the literature", f"{cited}, should be {CITED} at least")
    return tally.end()


if __name__ == "__main__":
    sys.exit(main())
