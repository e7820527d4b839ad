"""The same question in other words gets the same answer: order_check.py BUILD_DIR [NAME...]

Asked again with equations and variables in another order, with other signs and factors, other names, other units,
other spellings of expressions, and with subexpressions named as signals (rewrite.py). What must not move
(order_answers.py): verdict, dimensions, index, gauge, the admissible set, strata as sets, the start, and the code of a
refusal. Each difference is printed with both requests. Every case of the corpus can be asked, and random systems
(order_random.py). SGA_TEST_SEED repeats a run, SGA_TEST_SCALE makes its sample larger; SGA_TEST_SEEDS=N asks
every case with N seeds (make order-test SEEDS=N). Names choose cases of the corpus.
"""
import json
import multiprocessing
import os
import random
import resource
import sys
import tempfile

import cases
import order_known
import rewrite
import said as words
from expression import Syntax
from order_answers import Base, differences
from order_random import systems
from solver import Crash, Solver
from tally import Tally, build_folder, scaled, seed

WORKERS = 2
ORDER = ["equations", "variables", "signs"]
WORDS = ["names", "spelling", "units", "signals"]
SAMPLE, RANDOM = 120, 100    # cases of the corpus and random systems of one run
SLOW = 1.0                   # processor seconds of an answer past which a case is asked in long runs only
SECONDS = 60                 # no answer takes longer
UNREADABLE = (words.CannotSay, Syntax, KeyError, IndexError, ValueError, TypeError, AttributeError, RecursionError)


def corpus(patterns):
    for case in cases.load(patterns):
        request = case.get("request")
        if isinstance(request, dict) and isinstance(request.get("system"), dict) and len(json.dumps(request)) < words.LARGEST:
            yield case["name"], request


def plan(rng):
    """Two lists of rewritings: the order of everything; and other words, sometimes in another order too."""
    return [rng.sample(ORDER, 3), [rng.choice(WORDS + ["signals"])] + ([rng.choice(ORDER + ["names"])] if rng.random() < 0.5 else [])]


def worked():
    """Processor seconds of the answers so far."""
    used = resource.getrusage(resource.RUSAGE_CHILDREN)
    return used.ru_utime + used.ru_stime


class Order:
    def __init__(self, tally, solver):
        self.tally, self.solver = tally, solver
        self.asked = self.known = 0

    def base(self, request):
        """The first answer, or None where the request is not read by these rewritings, or refused by a reader."""
        try:
            said = words.Said(request)
            plain, begun = said.request(), worked()
            result, problem = self.solver.solve(plain)
        except (Crash, *UNREADABLE):
            return None
        if problem and problem.get("stage") in (None, "request", "read"):
            return None
        return Base(request, plain, said, result, problem, worked() - begun)

    def ask(self, label, base, kinds, number):
        try:
            said = rewrite.rewrite(random.Random(number), base.request, kinds)
        except UNREADABLE:
            return
        if not said.done:
            return
        new = said.request()
        self.asked += 1
        try:
            found = differences(base, said, new, *self.solver.solve(new))
        except Crash as e:
            found = [f"crash: {e}"]
        label = f"{label} [{' '.join(said.done)}]"
        causes = [order_known.cause(label, d) for d in found]
        if found and all(causes):
            self.known += 1
            print(f"known: {label}: {causes[0]}: {'; '.join(found)[:200]}")
        elif not self.tally.check(not found, label, "; ".join(found)):
            print(f"  first: {json.dumps(base.plain)}\n  second: {json.dumps(new)}", flush=True)


def share(listed, first, seeds, worker, out):
    """Every WORKERS-th question, its output in a file; the counts are its last line."""
    sys.stdout = out
    sys.setrecursionlimit(20000)
    order = Order(Tally("order"), Solver(build_folder(), SECONDS))
    for k, (label, request) in list(enumerate(listed))[worker::WORKERS]:
        if k // WORKERS % 100 == 0:
            print(f"# {k} of {len(listed)}", flush=True)
        base = order.base(request)
        if base is None or (seeds == 1 and base.seconds > SLOW):
            continue
        for number in range(first, first + seeds):
            for kinds in plan(random.Random(f"{number} {label}")):
                order.ask(label, base, kinds, f"{number} {label} {kinds}")
    print(order.tally.passed, order.tally.failed, order.asked, order.known, flush=True)


def run(listed, first, seeds, tally):
    """By two processes; what they print is shown in the order of the questions each had."""
    folder = os.environ.get("SGA_TEST_OUT")    # where the output can be watched
    out = [open(os.path.join(folder, f"order{k}.out"), "w+", encoding="utf-8") if folder
           else tempfile.TemporaryFile("w+", encoding="utf-8") for k in range(WORKERS)]
    workers = [multiprocessing.Process(target=share, args=(listed, first, seeds, k, out[k])) for k in range(WORKERS)]
    for w in workers:
        w.start()
    asked = known = 0
    for k, w in enumerate(workers):
        w.join()
        out[k].seek(0)
        *said, counts = out[k].read().splitlines() or [""]
        out[k].close()
        print("\n".join(line for line in said if not line.startswith("#")))
        if tally.check(w.exitcode == 0, f"worker {k}", f"ended with {w.exitcode}: {counts}"):
            passed, failed, a, n = map(int, counts.split())
            tally.passed, tally.failed, asked, known = tally.passed + passed, tally.failed + failed, asked + a, known + n
    print(f"{asked} questions in other words, {tally.failed} other answers, {known} of known causes")


def main():
    tally = Tally("order")
    first, seeds = seed(20261101), int(os.environ.get("SGA_TEST_SEEDS", "0"))
    listed = list(corpus(sys.argv[2:]))
    random.Random(first).shuffle(listed)
    if not seeds and not sys.argv[2:]:
        listed = listed[:scaled(SAMPLE)]
    if not sys.argv[2:]:
        listed = list(systems(first, scaled(RANDOM))) + listed
    run(listed, first, max(seeds, 1), tally)
    return tally.end()


if __name__ == "__main__":
    sys.exit(main())
