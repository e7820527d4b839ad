"""What server/store/store.h promises, asked of each store: store_check.py BUILD_DIR

build/conformance (tests/conformance/) has the checks; here it gets a store that is empty."""
import os
import re
import subprocess
import sys
import tempfile

sys.path.insert(1, os.path.join(os.path.dirname(os.path.abspath(__file__)), "api"))
from cluster import Cluster  # noqa: E402
from tally import Tally, build_folder  # noqa: E402


def conforms(tally, build, name, place):
    run = subprocess.run([os.path.join(build, "conformance"), place], capture_output=True, text=True, timeout=300, check=False)
    last = re.search(r"^(\d+) passed, (\d+) failed$", run.stdout, re.M)
    tally.check(run.returncode == 0 and last and int(last[1]) > 90 and last[2] == "0", f"the store in {name}", (run.stdout + run.stderr)[-2000:])
    tally.passed += int(last[1]) if last else 0


def main():
    tally, build = Tally("store"), build_folder()
    with tempfile.TemporaryDirectory() as folder:
        conforms(tally, build, "files of SQLite", os.path.join(folder, "state"))
    with Cluster() as server:
        conforms(tally, build, "a database of PostgreSQL", server.database("one"))
    return tally.end()


if __name__ == "__main__":
    sys.exit(main())
