"""The daemon over HTTP: run.py BUILD_DIR [TEST...]"""
import os
import sys
import time

HERE = os.path.dirname(os.path.abspath(__file__))
sys.path[:0] = [HERE, os.path.dirname(HERE)]

import access  # noqa: E402
import audit  # noqa: E402
import chaos  # noqa: E402
import check  # noqa: E402
import command  # noqa: E402
import endpoints  # noqa: E402
import faults  # noqa: E402
import framing  # noqa: E402
import isolation  # noqa: E402
import kept  # noqa: E402
import kill  # noqa: E402
import life  # noqa: E402
import limits  # noqa: E402
import load  # noqa: E402
import long_results  # noqa: E402
import packed  # noqa: E402
import page  # noqa: E402
import power  # noqa: E402
import proxies  # noqa: E402
import refusals  # noqa: E402
import shared as several  # noqa: E402
import store  # noqa: E402
import team  # noqa: E402
import turns  # noqa: E402
import upgrade  # noqa: E402
import watch  # noqa: E402
from common import Checks  # noqa: E402
from daemon import Daemon  # noqa: E402
from tally import Tally, build_folder  # noqa: E402

# Whose tests start daemons of their own; those of the others share one.
OWN = [
    life,
    limits,
    kept,
    isolation,
    kill,
    load,
    store,
    access,
    audit,
    watch,
    command,
    faults,
    turns,
    power,
    framing,
    packed,
    long_results,
    upgrade,
    team,
    several,
    chaos,
    proxies,
    page,
]


def one(tally, name, test, *arguments):
    begun = time.monotonic()
    try:
        test(*arguments)
    except Exception as e:    # an error in one test is one failure; the others go on
        tally.check(False, name, f"{type(e).__name__}: {e}")
    if os.environ.get("SGA_TEST_VERBOSE"):
        print(f"# {name} {time.monotonic() - begun:.1f} s", flush=True)


def main():
    tally, build = Tally("api"), build_folder()
    checks = Checks(tally)
    chosen = sys.argv[2:]
    shared = [t for t in endpoints.ALL + check.ALL + page.SHARED + refusals.ALL + framing.SHARED + packed.SHARED if not chosen or t.__name__ in chosen]
    if shared:
        with Daemon(build) as d:
            for test in shared:
                one(tally, test.__name__, test, d, checks)
                if d.process.poll() is not None:
                    tally.check(False, test.__name__, f"the daemon died with {d.process.returncode}: {d.errors()}")
                    d.start()
            tally.check(d.stop() == 0, "the daemon ends with 0", d.errors()[-500:])
    for test in [t for module in OWN for t in module.ALL]:
        if not chosen or test.__name__ in chosen:
            one(tally, test.__name__, test, build, checks)
    return tally.end()


if __name__ == "__main__":
    sys.exit(main())
