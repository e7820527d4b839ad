"""The same question in another order, with other signs, names, units, spellings and named signals gets the same answer: order_check.py BUILD_DIR [NAME...]

What must not move: verdict, dimensions, index, gauge, the admissible set, strata by kind and as sets, the start, and the
code of a refusal. Each difference is printed with both requests. SGA_TEST_SEED repeats a run, SGA_TEST_SCALE makes it
longer, SGA_TEST_SEEDS asks every case with that many seeds; names choose cases.
"""
import json
import multiprocessing
import os
import random
import sys
import time

import cases
import respell
import rewrite
from order_answers import Base, differences
from order_random import systems
from solver import Crash, Solver
from tally import Tally, build_folder, scaled, seed

WORKERS = 2
ORDER = ["equations", "variables", "signs"]
SAMPLE = 150        # cases of the corpus in one run, and random systems
RANDOM = 40
SLOW = 3.0          # seconds of an answer beyond which a case is asked in long runs only
# asked of a reader, not of the reduction
READING = {"invalid_json", "unknown_member", "missing_member", "invalid_value", "syntax", "unknown_name", "not_supported"}


def questions(patterns):
    for case in cases.load(patterns):
        request = case.get("request")
        if isinstance(request, dict) and isinstance(request.get("system"), dict) and len(json.dumps(request)) < rewrite.LARGEST:
            yield case["name"], request


def plan(rng):
    """Lists of rewritings to ask with."""
    other = rng.choice(["names", "spelling", "units", "signals", "signals", "spelling"])
    return [rng.sample(ORDER, 3), [other] + ([rng.choice(ORDER + ["names"])] if rng.random() < 0.5 else [])]


class Order:
    def __init__(self, tally, solver, out=sys.stdout):
        self.tally, self.solver, self.out = tally, solver, out
        self.asked = self.skipped = self.slow = 0

    def base(self, request):
        """The first answer, or None where there is nothing to compare."""
        try:
            said = rewrite.Said(request)
            plain = said.request()
            begun = time.time()
            result, problem = self.solver.solve(plain)
        except (Crash, rewrite.CannotSay, KeyError, TypeError, ValueError, AttributeError, IndexError):
            return None
        if problem and problem.get("stage") in (None, "read", "request", "check", "parse"):
            return None
        return Base(request, plain, said, result, problem, time.time() - begun)

    def ask(self, label, base, kinds, number):
        rng = random.Random(number)
        try:
            said = rewrite.rewrite(rng, base.request, kinds)
        except (respell_errors) as e:
            self.skipped += 1
            return
        if not said.done:
            self.skipped += 1
            return
        new = said.request()
        self.asked += 1
        try:
            result, problem = self.solver.solve(new)
            found = differences(base, said, new, result, problem)
        except Crash as e:
            found = [f"crash: {e}"]
        if not self.tally.check(not found, f"{label} [{' '.join(said.done)}] seed {number}", "; ".join(found)):
            print(f"  first: {json.dumps(base.plain)}\n  second: {json.dumps(new)}", flush=True)


respell_errors = (rewrite.CannotSay, respell_error := __import__("expression").Syntax, KeyError, IndexError, ValueError, TypeError, RecursionError)


def share(listed, first, seeds, worker, out, count):
    sys.stdout = out
    sys.setrecursionlimit(20000)
    tally = Tally("order")
    order = Order(tally, Solver(build_folder(), 60))
    for k, (label, request) in enumerate(listed):
        if k % WORKERS != worker:
            continue
        base = order.base(request)
        if base is None or (seeds == 1 and base.seconds > SLOW):
            order.skipped += 1
            continue
        for s in range(seeds):
            rng = random.Random(f"{first + s} {label}")
            for kinds in plan(rng):
                order.ask(label, base, kinds, f"{first + s} {label} {' '.join(kinds)}")
    print(f"# asked {order.asked}, left out {order.skipped}")
    print(tally.passed, tally.failed, flush=True)


def main():
    tally = Tally("order")
    first, seeds = seed(20261101), int(os.environ.get("SGA_TEST_SEEDS", "0"))
    rng = random.Random(first)
    listed = list(questions(sys.argv[2:]))
    if not seeds and not sys.argv[2:]:
        rng.shuffle(listed)
        listed = listed[:scaled(SAMPLE)]
    listed = list(systems(first, scaled(RANDOM))) * (not sys.argv[2:]) + listed
    folder = os.environ.get("SGA_TEST_OUT")
    import tempfile
    out = [open(os.path.join(folder, f"order{k}.out"), "w+", encoding="utf-8") if folder else tempfile.TemporaryFile("w+", encoding="utf-8") for k in range(WORKERS)]
    workers = [multiprocessing.Process(target=share, args=(listed, first, max(seeds, 1), k, out[k], len(listed))) for k in range(WORKERS)]
    for w in workers:
        w.start()
    for k, w in enumerate(workers):
        w.join()
        out[k].seek(0)
        *said, counts = out[k].read().splitlines() or [""]
        print("\n".join(said))
        if tally.check(w.exitcode == 0, f"worker {k}", f"ended with {w.exitcode}: {counts}"):
            passed, failed = map(int, counts.split())
            tally.passed += passed
            tally.failed += failed
    return tally.end()


if __name__ == "__main__":
    sys.exit(main())
