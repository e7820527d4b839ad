"""Small errors put into the code, one at a time: mutate.py BUILD_DIR COUNT [FOLDER...]

Each is a change of one operator, constant or condition in a copy of the sources (folders of lib/; sga, traj, points, ode, poly and
request unless named). What is built of it must fail some test: the unit tests of its folder, then the suites of SUITES at a small scale, every
tenth case last; what these do not see is shown to WHOLE, as they run in `make test`. What no test sees is printed: a test is missing there, or the code does not matter. SGA_TEST_SEED
repeats a run. Ends with the share of errors that were seen, which it puts into doc/developer.md; a process that takes far more of a processor than
the right code does counts as seen.
"""
import os
import random
import re
import resource
import shutil
import subprocess
import sys

import developer_figures
from tally import ROOT, seed

FOLDERS = ["sga", "traj", "points", "ode", "poly", "request"]
CHANGES = [(r" < ", " <= "), (r" <= ", " < "), (r" > ", " >= "), (r" >= ", " > "), (r" == ", " != "), (r" != ", " == "), (r" \+ ", " - "), (r" - ", " + "),
           (r" \* ", " / "), (r" && ", " || "), (r" \|\| ", " && "), (r"\bif \(!", "if ("), (r"\breturn true;", "return false;"),
           (r"\breturn false;", "return true;"), (r"\+\+", "--"), (r" \+= ", " -= "), (r"\b1\b", "2"), (r"\b0\b", "1"), (r"\bfmax\(", "fmin("), (r"\bcontinue;", ";")]
SKIP = re.compile(r"^\s*(\*|/\*|//|#|enum|struct|static const|[A-Z_]+\()|sga_fail|snprintf|printf|sizeof|alloc\(|\"")       # more memory than is needed is no error
# After the unit tests, those that take least first; each at a small scale.
SUITES = ["hard_sets", "products_check", "switch_check", "slide_check", "units_check", "parameter_cases", "order_check", "start_check", "kepler_check", "spelling_check", "tables_check",
          "cut_check", "cases"]
WHOLE = ["cases", "order_check", "slide_check", "switch_check"]
TURN, TIMES = 30, 10  # seconds of a processor for one process: so many times what the right code took, and these at least; a loaded machine changes nothing
HANGS = 7200          # seconds: nothing that computes gets here; what sleeps for ever does


took = {}             # seconds of a processor that the right code took, by command


def run(command, cwd, env=None, right=False):
    """Its status. right: of the right code, which shows what it takes."""
    key, before = (*command, *sorted((env or {}).items())), resource.getrusage(resource.RUSAGE_CHILDREN)
    turn = int(max(TURN, TIMES * took.get(key, 0)))
    try:
        status = subprocess.run(command, cwd=cwd, capture_output=True, timeout=HANGS, check=False, env={**os.environ, **(env or {})},
                                preexec_fn=None if right else lambda: resource.setrlimit(resource.RLIMIT_CPU, (turn, turn))).returncode
    except subprocess.TimeoutExpired:
        return None
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    if right:
        took[key] = after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime
    return status


def sites(tree, folders):
    for folder in folders:
        at = os.path.join(tree, "lib", folder)
        for name in sorted(os.listdir(at)):
            if not name.endswith(".c"):
                continue
            with open(os.path.join(at, name), encoding="utf-8") as f:
                text = f.read().split("\n")
            for k, line in enumerate(text):
                code = line.split("/*")[0]
                if SKIP.search(line) or not code.strip():
                    continue
                for pattern, to in CHANGES:
                    for m in re.finditer(pattern, code):
                        yield os.path.join("lib", folder, name), k, m.start(), m.end(), to


def made(tree, build, *targets):
    return run(["make", "-s", "-j2", f"B={build}", "OPT=-O2", *targets], tree, right=True) == 0


def seen(tree, build, folders, path=None):
    """By what the change of a file was seen: the unit tests of its folder, before all else is linked; "" where nothing saw it; None where it does not compile."""
    env = {"SGA_TEST_SCALE": "0.05", "SGA_TEST_EVERY": "10", "PYTHONDONTWRITEBYTECODE": "1"}
    python = "/usr/bin/python3"
    right = path is None
    units = [f[:-2] for f in sorted(os.listdir(os.path.join(tree, "tests", "unit"))) if f.endswith(".c") and f.split("_")[0] in folders]
    if path and not made(tree, build, os.path.join(build, path[:-2] + ".o")):
        return None
    if not made(tree, build, *[os.path.join(build, "unit", u) for u in units]):
        return "units that do not link"
    for u in units:
        if run([os.path.join(tree, build, "unit", u)], tree, env, right) != 0:
            return f"unit {u}"
    if not made(tree, build, os.path.join(build, "sga")):
        return "a program that does not link"
    for name in SUITES:
        if run([python, f"tests/{name}.py", build], tree, env, right) != 0:
            return name
    for name in WHOLE:
        if run([python, f"tests/{name}.py", build], tree, {"PYTHONDONTWRITEBYTECODE": "1"}, right) != 0:
            return f"the whole of {name}"
    return ""


def main():
    tree, count = os.path.abspath(sys.argv[1]), int(sys.argv[2])
    folders, rng = sys.argv[3:] or FOLDERS, random.Random(seed(20261123))
    os.environ.pop("SGA_TEST_SEED", None)      # it chooses the errors: tests have their own
    shutil.rmtree(tree, ignore_errors=True)
    shutil.copytree(ROOT, tree, ignore=lambda at, names: [n for n in names if at == ROOT and (n.startswith("build") or n == ".git")])
    listed, tried, survived = list(sites(tree, folders)), 0, []
    by = seen(tree, "build", folders)
    if by:
        sys.exit(f"the right code fails: {by}")
    while tried < count and listed:
        path, k, a, b, to = listed.pop(rng.randrange(len(listed)))
        with open(os.path.join(tree, path), encoding="utf-8") as f:
            right = f.read()
        lines = right.split("\n")
        was, lines[k] = lines[k], lines[k][:a] + to + lines[k][b:]
        with open(os.path.join(tree, path), "w", encoding="utf-8") as f:
            f.write("\n".join(lines))
        by = seen(tree, "build", [path.split("/")[1]], path)
        with open(os.path.join(tree, path), "w", encoding="utf-8") as f:
            f.write(right)
        if by is None:
            continue
        tried += 1
        print(f"{path}:{k + 1}: {'seen by ' + by if by else 'NOT SEEN'}: {was.strip()}  ->  {lines[k].strip()}", flush=True)
        survived += [path] * (not by)
    said = f"{tried - len(survived)} of {tried} errors were seen by a test ({100 * (tried - len(survived)) / max(tried, 1):.0f} %): {', '.join(folders)}."
    print(said)
    developer_figures.rewrite("mutants", [said])
    return 0 if tried else 1


if __name__ == "__main__":
    sys.exit(main())
