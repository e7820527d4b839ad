"""turns.py BUILD_DIR [COUNT] [MINUTES] [TEST...]: the tests of the API under faults in turn.

Each test is run once to count its writes, syncs, opens, processes, allocations, looks at the clock and lines of the log, then again
and again with one of them failing (and once more with that and the next 20): all of them, or COUNT for each kind, chosen by
a seed. What a test asks for may fail then; what may not: a daemon that dies, a refusal without a reason, a promise that is not
kept after a new start (history.py). The commands of `sgad` that change files come first, with COUNT of their calls or every one failing in turn.
SGA_TEST_SEED sets the seed, which is printed, and with it the order of the tests. After MINUTES (0: none) no test is begun; what was left out is told."""
import ctypes
import http.client
import os
import random
import re
import signal
import sys
import tempfile
import time

HERE = os.path.dirname(os.path.abspath(__file__))
sys.path[:0] = [HERE, os.path.dirname(HERE)]

import access  # noqa: E402
import audit  # noqa: E402
import chaos  # noqa: E402
import check  # noqa: E402
import command  # noqa: E402
import command_turns  # noqa: E402
import endpoints  # noqa: E402
import faults  # noqa: E402
import framing  # noqa: E402
import isolation  # noqa: E402
import kill  # noqa: E402
import life  # noqa: E402
import limits  # noqa: E402
import load  # noqa: E402
import packed  # noqa: E402
import page  # noqa: E402
import power  # noqa: E402
import proxies  # noqa: E402
import refusals  # noqa: E402
import shared  # noqa: E402
import store  # noqa: E402
import team  # noqa: E402
import upgrade  # noqa: E402
import watch  # noqa: E402
from common import Checks  # noqa: E402
from daemon import Daemon  # noqa: E402
from history import History  # noqa: E402
from shim import KINDS, Shim, compiled, sanitized  # noqa: E402
from tally import Tally  # noqa: E402

# One daemon of its own for each test of those that share one.
SHARED = endpoints.ALL + check.ALL + page.SHARED + refusals.ALL + framing.SHARED + packed.SHARED
OWN = [t for module in (life, limits, isolation, kill, load, store, access, audit, watch, command, faults, power, framing, packed, upgrade, team, shared, chaos, proxies, page) for t in module.ALL]
# No turn for them, and why.
WITHOUT = {
    "page_sources": "no daemon", "page_vendored": "no daemon", "unit": "no daemon", "trials": "no daemon", "power": "a shim of its own, which records what reaches the disk",
    "many_requests": "a count of what is lost, of a daemon without faults", "soak": "the same", "shared_chaos": "faults of its own, and a count of what is lost",
    "proxies": "about programs in front of the daemon", "processes": "no daemon",
}
# What a test itself takes away is no promise any more; all else is.
DAMAGE = {"damaged": "requests are changed in the queue, and it is put back as it was before"}                      # nothing that was told counts
RESULTS = {"dropped": "the file of results is deleted", "flipped": "bytes of results are changed", "older": "the file of results is dropped with its schema",
           "reading_only": "the file of results is deleted", "kept_apart": "results go by number and age"}                                                          # a job that is done may be done once more
PRUNED = {"kept": "ended jobs go by number and age", "kept_apart": "and by bytes"}                                                              # a job that has ended may be gone
GONE = (OSError, http.client.HTTPException, ValueError, AttributeError)
SECONDS = 150                         # a test that waits for what failed is given up


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
        self.histories, self.counted, self.after = {}, False, False

    def env(self):
        return self.shim.env

    def check(self, ok, label, detail=""):
        what = f"{self.name}, {self.kind} {self.nth}" + (f" to {self.nth + self.length - 1}" if self.length > 1 else "")
        return self.tally.check(ok, f"{what}: {label}", str(detail)[:3000])

    def began(self):
        if self.kind is None:
            if not self.counted:
                self.shim.arm("", 0)
            self.counted = True
        elif not self.after:
            self.shim.arm(self.kind, self.nth, self.length)

    def heard(self, d, method, path, answer, headers=None):
        if self.kind is not None:
            history = self.histories.setdefault(id(d), History(self.check, lambda: self.name in RESULTS or dropped(d), pruned=self.name in PRUNED))
            if self.name not in DAMAGE:
                history.heard(method, path, answer, headers)
            elif answer.status >= 400 and answer.body:
                history.refused(method, path, answer, answer.headers.get("content-type", "").split(";")[0])

    def lost(self, d, method, path):
        if id(d) in self.histories:
            self.histories[id(d)].lost(method, path)

    def lived(self, status, errors):
        """It ended as it was asked to (or by a test's kill -9), or for want of memory with its last words."""
        self.check(status in (0, 1, 2, -9) or (status == -6 and self.kind == "memory" and "out of memory" in errors), "it does not die", (status, errors[-1500:]))

    def stuck(self, errors):
        """It was told to end, and did not."""
        self.check(False, "it ends when it is told to", errors[-1500:])

    def left(self, d):
        """The test is over: without faults all promises are kept."""
        if self.kind is None:
            return
        self.shim.disarm()
        status = d.process.returncode if d.process else 0
        self.lived(status, d.all_errors())
        for pid in d.successors():
            try:
                self.lived(os.waitstatus_to_exitcode(os.waitpid(pid, 0)[1]), d.all_errors())
            except ChildProcessError:        # somebody else took note of its end
                pass
        if __name__ == "__main__":
            reap(d.state)
        history = self.histories.get(id(d))
        if not d.own or not history or not history.promised or d.shares():
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


class GivenUp(Exception):
    """The test goes on for too long."""


def give_up(*_):
    raise GivenUp


def reap(state=""):
    """Processes that a test left to us, such as a successor of which no line of the log told; those of that state, or all."""
    with open(f"/proc/self/task/{os.getpid()}/children", encoding="ascii") as f:
        for pid in map(int, f.read().split()):
            with open(f"/proc/{pid}/cmdline", encoding="utf-8", errors="replace") as line:
                if state not in line.read():
                    continue
            os.kill(pid, signal.SIGKILL)
            os.waitpid(pid, 0)


def run(test, build, guest):
    """The test with its guest; whatever it finds or raises is of no account here."""
    Daemon.guest = guest
    checks = Checks(Nothing())
    signal.signal(signal.SIGALRM, give_up)
    signal.alarm(SECONDS)
    try:
        if test in SHARED:
            with Daemon(build) as d:
                test(d, checks)
        else:
            test(build, checks)
    except Exception:      # noqa: BLE001
        pass
    finally:
        signal.alarm(0)
        Daemon.guest = None
        if __name__ == "__main__":
            reap()


def turns(total, count, rng):
    """Which calls fail: all, or some of the first, of the last and between."""
    return range(1, total + 1) if not count or total <= count else sorted(rng.sample(range(1, total + 1), count))


def in_turn(tally, build, count, names, minutes=0):
    seed = int(os.environ.get("SGA_TEST_SEED", "20261125"))
    rng = random.Random(seed)
    print(f"seed {seed}", flush=True)
    with tempfile.TemporaryDirectory(prefix="sgad-shim-") as folder:
        library, failed, done, left = compiled(folder), dict.fromkeys(KINDS[1:], 0), 0, []
        if not names or "commands" in names:
            command_turns.commands(tally, build, Shim(folder, library), count, rng)
        chosen, began = [t for t in SHARED + OWN if (not names or t.__name__ in names) and t.__name__ not in WITHOUT], time.monotonic()
        if minutes:
            rng.shuffle(chosen)
        for test in chosen:
            if minutes and time.monotonic() - began > 60 * minutes:
                left.append(test.__name__)
                continue
            shim = Shim(folder, library)
            run(test, build, Guest(shim, tally, test.__name__))
            counts, before = {k: shim.count(k) for k in KINDS[1:]}, dict(failed)
            for kind, total in counts.items():
                for nth in turns(total, count, rng):
                    length = rng.choice((1, 1, 20))
                    run(test, build, Guest(shim, tally, test.__name__, kind, nth, length))
                    failed[kind] += shim.failed()
            done += 1
            if os.environ.get("SGA_TEST_VERBOSE"):
                print(f"# {test.__name__}: of", counts, "failed", {k: failed[k] - before[k] for k in failed}, flush=True)
        print(f"{done} tests in turn")
        print("calls that failed:", failed, flush=True)
        if left:
            print("left out, as the time was over:", " ".join(left))
        if not names:
            tally.check(all(failed.values()), "each kind of fault was met", failed)


def some_turns(build, c):
    """A sample among the tests of the API."""
    if not sanitized(build):
        in_turn(c.tally, build, int(os.environ.get("SGA_TEST_TURNS", "1")), ["job", "listing", "request_of_job", "cancel", "restart", "owners", "commands"])


ALL = [some_turns]

if __name__ == "__main__":
    ctypes.CDLL(None).prctl(36, 1)      # PR_SET_CHILD_SUBREAPER: the ends of successors are told to us
    TALLY = Tally("turns")
    NUMBERS = [int(a) for a in sys.argv[2:4] if a.isdigit()]
    in_turn(TALLY, sys.argv[1], NUMBERS[0] if NUMBERS else 0, sys.argv[2 + len(NUMBERS):], NUMBERS[1] if len(NUMBERS) > 1 else 0)
    sys.exit(TALLY.end())
