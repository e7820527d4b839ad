"""The programs built for arm64: arm64_check.py BUILD_DIR         (make arm64-test; with a Debian mirror)

Cross-built with -Werror against arm64's Debian packages, which are unpacked in BUILD_DIR/arm64 and not installed, and run by
qemu-user: the unit tests of the lower floors, then requests, whose answers are those of this machine's program with --interpret-only:
texts and whole numbers the same, most answers to the last digit, the others (Debian's libraries of arm64 round a product and a sum at
once) within the errors that they state. No kernel of arm64 runs there: that the sandbox's filter loads is not tried here.
"""
import glob
import json
import os
import re
import subprocess
import sys

from cases import load
from tally import ROOT, Tally, build_folder

FLOORS = ("base", "exact", "expr", "lin", "num", "ode")
EVERY = int(os.environ.get("SGA_TEST_EVERY", "40"))        # of the corpus
ITS_OWN = ("work", "version", "program")                   # of a run, not of its request


def run(*command, seconds=1800, **more):
    return subprocess.run(command, capture_output=True, text=True, timeout=seconds, check=False, **more)


def libraries(tally, at):
    """The packages that tests/setup names, of arm64, with all that they need, unpacked: the folder; None: they cannot be had."""
    root = os.path.join(at, "root")
    if os.path.exists(root):
        return root
    named = re.search(r'^build="gcc make (.*?)"', open(os.path.join(ROOT, "tests/setup"), encoding="utf-8").read(), re.M | re.S).group(1).split()
    for folder in ("lists/partial", "archives/partial", "state"):
        os.makedirs(os.path.join(at, folder), exist_ok=True)
    open(os.path.join(at, "status"), "w", encoding="utf-8").close()
    settings = os.path.join(at, "apt.conf")
    with open(settings, "w", encoding="utf-8") as f:
        f.write('APT::Architecture "arm64"; APT::Architectures { "arm64"; }; APT::Sandbox::User "root";\n'
                f'Dir::State "{at}/state"; Dir::State::lists "{at}/lists"; Dir::State::status "{at}/status"; Dir::Cache "{at}"; Dir::Cache::archives "{at}/archives";\n')
    env = {**os.environ, "APT_CONFIG": settings}
    for command in (["update"], ["install", "-y", "--download-only", "--no-install-recommends", *named]):
        got = run("apt-get", *command, env=env)
        if not tally.check(got.returncode == 0, "apt-get " + command[0], got.stderr[-1000:]):
            return None
    for package in sorted(glob.glob(os.path.join(at, "archives", "*.deb"))):
        run("dpkg-deb", "-x", package, root + ".new")
    os.rename(root + ".new", root)
    return root


def made(tally, at, root):
    """Both programs and the unit tests: the folder that they are in; None: they do not compile."""
    out = os.path.join(at, "build")
    units = sorted(f"{out}/unit/" + os.path.basename(u)[:-2] for floor in FLOORS for u in glob.glob(os.path.join(ROOT, "tests/unit", floor + "_*.c")))
    beside = " ".join(f"-Wl,-rpath-link,{root}{folder}/aarch64-linux-gnu" for folder in ("/lib", "/usr/lib"))
    make = run("make", "-C", ROOT, f"-j{os.cpu_count()}", f"CC=aarch64-linux-gnu-gcc --sysroot={root}", "OPT=-O2", "WERROR=1", f"LDFLAGS={beside}", f"B={out}",
               "all", *units, env={k: v for k, v in os.environ.items() if not k.startswith("MAKE") and k != "MFLAGS"})
    return (out, units) if tally.check(make.returncode == 0, "make for arm64", (make.stdout + make.stderr)[-3000:]) else (None, [])


def without(said):
    """Solved strata are results with work of their own."""
    if isinstance(said, dict):
        return {k: without(v) for k, v in said.items() if k not in ITS_OWN}
    return [without(v) for v in said] if isinstance(said, list) else said


def agree(there, here, error):
    """Within the error, of numbers that are not whole."""
    if isinstance(there, (list, tuple)) and isinstance(here, (list, tuple)):
        return len(there) == len(here) and all(agree(a, b, error) for a, b in zip(there, here))
    if isinstance(there, dict) and isinstance(here, dict):
        return there.keys() == here.keys() and all(agree(there[k], here[k], error) for k in there)
    if isinstance(there, float) and isinstance(here, (float, int)):
        return abs(there - here) <= error * (1 + abs(here))
    return there == here


def answer(command, request):
    got = run(*command, "solve", "-", "--json", "--interpret-only", input=json.dumps(request), seconds=600)
    try:
        said = json.loads(got.stdout)
    except ValueError:
        return got.returncode, got.stdout, got.stderr
    return got.returncode, without(said), got.stderr


def main():
    tally, build = Tally("arm64"), build_folder()
    at = os.path.join(build, "arm64")
    root = libraries(tally, at)
    out, units = made(tally, at, root) if root else (None, [])
    qemu = ["qemu-aarch64-static", "-L", root]
    for unit in units:
        got = run(*qemu, unit, env={**os.environ, "SGA_TEST_SCALE": os.environ.get("SGA_TEST_SCALE", "0.2")})
        tally.check(got.returncode == 0 and re.search(r"^[1-9]\d* passed, 0 failed$", got.stdout, re.M), os.path.basename(unit), (got.stdout + got.stderr)[-1000:])
    requests = {os.path.basename(p): json.load(open(p, encoding="utf-8")) for p in glob.glob(os.path.join(ROOT, "etc/examples/*.json"))}
    requests |= {case["name"]: case["request"] for case in list(load([]))[::max(1, EVERY)] if "request" in case}
    same = 0
    for name, request in requests.items() if out else ():
        there, here = (answer(command, request) for command in ([*qemu, out + "/sga"], [build + "/sga"]))
        of = here[1].get("trajectory") if isinstance(here[1], dict) else None
        same += there == here
        tally.check(agree(there, here, 4 * (of or {}).get("error_estimate", 0) + 1e-13), name, f"{str(there)[:400]} and not {str(here)[:400]}")
    tally.check(not out or same > 0.9 * len(requests), "most answers to the last digit", f"{same} of {len(requests)}")
    print(f"# {same} of {len(requests)} answers to the last digit")
    return tally.end()


if __name__ == "__main__":
    sys.exit(main())
