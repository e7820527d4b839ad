"""turns.py BUILD_DIR [COUNT] [TEST...]: the tests of the API under faults in turn.

Each test is run once to count its writes, syncs, opens, processes, allocations, looks at the clock and lines of the log, then again
and again with one of them failing (and once more with that and the next 20): all of them, or COUNT for each kind, chosen by
a seed. What a test asks for may fail then; what may not: a daemon that dies, a refusal without a reason, a promise that is not
kept after a new start (history.py). SGA_TEST_SEED sets the seed, which is printed."""
import http.client
import os
import random
import re
import sys
import tempfile

HERE = os.path.dirname(os.path.abspath(__file__))
sys.path[:0] = [HERE, os.path.dirname(HERE)]

import access  # noqa: E402
import audit  # noqa: E402
import check  # noqa: E402
import endpoints  # noqa: E402
import isolation  # noqa: E402
import life  # noqa: E402
import limits  # noqa: E402
import packed  # noqa: E402
import page  # noqa: E402
import refusals  # noqa: E402
import shared  # noqa: E402
import watch  # noqa: E402
from common import Checks  # noqa: E402
from daemon import Daemon  # noqa: E402
from history import History  # noqa: E402
from shim import KINDS, Shim, compiled, sanitized  # noqa: E402
from tally import Tally  # noqa: E402

# Those that neither damage files nor measure; the shared ones get a daemon of their own each.
SHARED = [endpoints.job, endpoints.cache, endpoints.waiting, endpoints.listing, endpoints.trajectory, endpoints.sweep, endpoints.events, endpoints.conditional, endpoints.code,
          check.check_all, check.request_of_job, refusals.bodies, endpoints.about, endpoints.metrics, endpoints.tradeoff, check.check_bodies, check.check_hints,
          refusals.paths, refusals.hosts, refusals.failed, refusals.unknown_words, refusals.large, packed.packing, packed.packing_head, page.page_files]
OWN = [life.cancel, life.full, life.restart, life.crashed, life.drained, access.tokens, access.owners, access.shares, watch.stages, watch.logs, watch.evicted,
       access.quotas, access.isolated, access.turns, audit.audit, audit.counted, life.killed, life.shutdown, limits.ended,
       limits.refused, isolation.apart, shared.shared_tenants]
GONE = (OSError, http.client.HTTPException, ValueError, AttributeError)


def dropped(d):
    with open(os.path.join(d.state, "test.log"), "rb") as f:
        return re.search(rb'"event":"(cache_dropped|results_evicted)"', f.read()) is not None


class Nothing:
    """A tally of what a test finds wrong while something fails: nobody asks."""

    @staticmethod
    def check(ok, *_):
        return bool(ok)


class Guest:
    """Goes with each daemon of a test (Daemon.guest): arms the fault when it listens, hears what it answers, and looks afterwards."""

    def __init__(self, shim, tally, name, kind=None, nth=0, length=1):
        self.shim, self.tally, self.name, self.kind, self.nth, self.length = shim, tally, name, kind, nth, length
        self.histories, self.counts, self.after = {}, {}, False

    def env(self):
        return self.shim.env

    def check(self, ok, label, detail=""):
        what = f"{self.name}, {self.kind} {self.nth}" + (f" to {self.nth + self.length - 1}" if self.length > 1 else "")
        return self.tally.check(ok, f"{what}: {label}", str(detail)[:600])

    def began(self, d):
        if self.kind is None:
            if not self.counts:
                self.shim.arm("", 0)
        elif not self.after:
            self.shim.arm(self.kind, self.nth, self.length)

    def heard(self, d, method, path, answer, headers=None):
        if self.kind is not None:
            self.histories.setdefault(id(d), History(self.check, lambda: dropped(d))).heard(method, path, answer, headers)

    def lost(self, d, method, path):
        if id(d) in self.histories:
            self.histories[id(d)].lost(method, path)

    def lived(self, d, status):
        """It ended as it was asked to (or by a test's kill -9), or for want of memory with its last words."""
        errors = d.errors()
        self.check(status in (0, 1, 2, -9) or (status == -6 and self.kind == "memory" and "out of memory" in errors), "it does not die", (status, errors[-1500:]))

    def ended(self, d, status):
        self.lived(d, status)

    def left(self, d):
        """The test is over: without faults all promises are kept."""
        if self.kind is None:
            self.counts = {k: self.shim.count(k) for k in KINDS[1:]}
            return
        self.shim.disarm()
        status = d.process.returncode if d.process else 0
        self.lived(d, status)
        history = self.histories.get(id(d))
        if not d.own or not history or not history.promised:
            return
        self.after = True
        try:
            d.start()
            history.holds(lambda id_, headers: d.ask("GET", "/v1/jobs/" + id_, headers=headers))
            d.stop()
        except (*GONE, RuntimeError) as e:
            self.check(False, "it starts again", (type(e).__name__, e, d.errors()[-1500:]))
            if d.process.poll() is None:
                d.process.kill()
                d.process.wait()
        self.after = False


def run(test, build, guest):
    """The test with its guest; whatever it finds or raises is of no account here."""
    Daemon.guest = guest
    checks = Checks(Nothing())
    try:
        if test in SHARED:
            with Daemon(build) as d:
                test(d, checks)
        else:
            test(build, checks)
    except Exception:      # noqa: BLE001
        pass
    finally:
        Daemon.guest = None


def turns(total, count, rng):
    """Which calls fail: all, or some of the first, of the last and between."""
    return range(1, total + 1) if not count or total <= count else sorted(rng.sample(range(1, total + 1), count))


def in_turn(tally, build, count, names):
    seed = int(os.environ.get("SGA_TEST_SEED", "20261125"))
    rng = random.Random(seed)
    print(f"seed {seed}", flush=True)
    with tempfile.TemporaryDirectory(prefix="sgad-shim-") as folder:
        library, failed = compiled(folder), dict.fromkeys(KINDS[1:], 0)
        for test in SHARED + OWN:
            if names and test.__name__ not in names:
                continue
            shim = Shim(folder, library)
            plain = Guest(shim, tally, test.__name__)
            run(test, build, plain)
            for kind, total in plain.counts.items():
                for nth in turns(total, count, rng):
                    length = rng.choice((1, 1, 20))
                    run(test, build, Guest(shim, tally, test.__name__, kind, nth, length))
                    failed[kind] += shim.failed()
        print("calls that failed:", failed, flush=True)
        if not names:
            tally.check(all(failed.values()), "each kind of fault was met", failed)


def some_turns(build, c):
    """A sample among the tests of the API."""
    if not sanitized(build):
        in_turn(c.tally, build, int(os.environ.get("SGA_TEST_TURNS", "1")), ["job", "listing", "request_of_job", "cancel", "restart", "owners"])


ALL = [some_turns]

if __name__ == "__main__":
    TALLY = Tally("turns")
    in_turn(TALLY, sys.argv[1], int(sys.argv[2]) if len(sys.argv) > 2 else 0, sys.argv[3:])
    sys.exit(TALLY.end())
