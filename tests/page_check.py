"""The page in Debian's Chromium: page_check.py BUILD_DIR

Starts two daemons, an open one and one that wants a token, and lets tests/page/check.mjs use the page of each. Packages of npm are
installed once into BUILD_DIR/page, as tests/page/package-lock.json pins them."""
import filecmp
import os
import shutil
import subprocess
import sys
import time

HERE = os.path.dirname(os.path.abspath(__file__))
sys.path.insert(0, os.path.join(HERE, "api"))

from daemon import Daemon  # noqa: E402
from tally import build_folder  # noqa: E402


def modules(build):
    """The folder with the packages, as the lock file has them."""
    place, lock = os.path.join(os.path.abspath(build), "page"), os.path.join(HERE, "page", "package-lock.json")
    kept = os.path.join(place, "package-lock.json")
    if not (os.path.exists(kept) and filecmp.cmp(lock, kept, False) and os.path.isdir(os.path.join(place, "node_modules"))):
        os.makedirs(place, exist_ok=True)
        for name in ("package.json", "package-lock.json"):
            shutil.copy(os.path.join(HERE, "page", name), place)
        subprocess.run(["npm", "ci", "--ignore-scripts", "--no-audit", "--no-fund", "--silent"], cwd=place, check=True)
    return place


def main():
    build = build_folder()
    subprocess.run([os.path.join(HERE, "setup"), "page"], check=True)
    place = modules(build)
    with Daemon(build) as d, Daemon(build, "--access", "tokens") as guarded:
        made = subprocess.run([os.path.join(build, "sgad"), "token", "create", "--state", os.path.join(guarded.state, "sgad"), "--name", "page",
                               "--scope", "submit,read"], capture_output=True, text=True, check=True)
        token = next(w for w in made.stdout.split() if w.startswith("sgad_"))
        while guarded.get("/v1/jobs", Authorization="Bearer " + token).status != 200:      # a daemon notices new tokens after a while
            time.sleep(0.1)
        done = subprocess.run(["node", os.path.join(HERE, "page", "check.mjs"), d.url(), guarded.url(), token, place, os.path.join(place, "pictures")], check=False)
        return done.returncode


if __name__ == "__main__":
    sys.exit(main())
