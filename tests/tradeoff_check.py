"""Tables of speed against accuracy: tradeoff_check.py BUILD_DIR [NAME...]

Each case of tests/cases/tradeoff.json is held against its own rows: order, choices, advice, the table and the image made
of it. Each system of tests/cases/trajectory_reference.json is measured up to its last time, where 20 digits are known: what a
row calls its error must be the true one. No time is measured, none is judged."""
import csv
import json
import os
import signal
import subprocess
import sys
import tempfile
import time
import xml.etree.ElementTree as ElementTree

import mpmath

import schemas
from expression import evaluate
from tally import ROOT, Tally, build_folder

SVG = "{http://www.w3.org/2000/svg}"
COLUMNS = ["method", "arithmetic", "rtol", "atol", "seconds", "evaluations", "error", "residual", "error_at_most", "digits", "within", "note"]
# A true error stands where the best solution is wrong by a quarter of it at the most.
TRUE_TO = 0.3
# Of rows over the corpus: the best solution's own estimate is one, too.
HELD = 0.98
# The references have 25 digits.
KNOWN = 1e-25
# Seconds of a job whose process is stopped most of the time; of jobs with little time.
DISTURBED, SHORT = 8, (0.5, 2)


def series(rows):
    found = {}
    for r in rows:
        found.setdefault((r["method"], r["arithmetic"]), []).append(r)
    return found


class Table:
    """One result's table against itself."""

    def __init__(self, tally, name, request, t):
        self.tally, self.name, self.request, self.t, self.rows = tally, name, request, t, t["rows"]
        self.accuracy = {"rtol": 1e-8, "atol": 1e-10, **request.get("accuracy", {})}

    def check(self, ok, what, detail=""):
        self.tally.check(ok, f"{self.name}: {what}", detail)

    def run(self):
        self.order()
        self.members()
        self.choices()
        for key, rows in series(self.rows).items():
            self.falls(" ".join(key), rows)

    def order(self):
        groups = [(r["method"], r["arithmetic"]) for r in self.rows]
        starts = [g for i, g in enumerate(groups) if i == 0 or groups[i - 1] != g]
        self.check(len(starts) == len(set(starts)), "a method's rows stand together", starts)
        for rows in series(self.rows).values():
            self.check(all(a["rtol"] > b["rtol"] for a, b in zip(rows, rows[1:])), "rows get tighter")
        ratio = self.accuracy["atol"] / self.accuracy["rtol"]
        self.check(all(abs(r["atol"] / r["rtol"] / ratio - 1) < 1e-9 for r in self.rows), "atol keeps its ratio")

    def members(self):
        for r in self.rows:
            label = f"{r['method']} {r['arithmetic']} at {r['rtol']:g}"
            known = "error_at_most" in r
            self.check(known or r["error"] is None, f"{label}: an error is compared")
            self.check(r["error"] is not None or r.get("note"), f"{label}: an unknown error has its reason")
            if known and r["error"] is not None:
                self.check(r["error"] <= r["error_at_most"] <= 2 * r["error"], f"{label}: bound", r)
            if known:
                self.check(r["residual"] is not None and r["residual"] < 1e-9, f"{label}: residual", r["residual"])
                self.check(r["evaluations"] > 0, f"{label}: evaluations")
        self.check(self.t["best"] is not None or all("error_at_most" not in r for r in self.rows), "no best, no errors")

    def choices(self):
        self.check([c["digits"] for c in self.t["choices"]] == [4, 6, 8, 10, 12, None], "choices", self.t["choices"])
        parts = self.t["advice"].split("; ")
        self.check(self.t["best"] or parts[0].startswith("no errors are known"), "advice without errors", parts)
        for c, said in zip(self.t["choices"], parts if self.t["best"] else [""] * 6):
            d = c["digits"]
            reached = [i for i, r in enumerate(self.rows) if (r.get("within") if d is None else (r.get("digits") or 0) >= d)]
            self.check(c["reached"] is (True if reached else c["reached"] and None), f"choice {d}: reached", c)
            if not reached:
                words = {False: "none of the rows", None: "not known"}[c["reached"]]
                self.check(c["row"] is None and (not said or words in said), f"choice {d}: none", (c, said))
                continue
            best = min(self.rows[i]["seconds"] for i in reached)
            ok = c["row"] in reached and self.rows[c["row"]]["seconds"] == best
            self.check(ok, f"choice {d}: the cheapest that reached it", (c, best))
            if ok:
                r = self.rows[c["row"]]
                words = said.split(": ", 1)[1]
                self.check(words.startswith(r["method"]) and f"at rtol {r['rtol']:g}, " in words and (said.startswith(f"{d} digits: ") or d is None),
                           f"choice {d}: advice", said)
        self.left_out()

    def left_out(self):
        """What has fewer rows than its arithmetic has tolerances, without having refused, is left out and told."""
        late = [e for e in self.t["left_out"] if "from" in e]
        said = self.t["advice"].split("left out for want of time: ")
        self.check(len(said) == 1 + bool(late), "advice tells of rows left out", (late, said))
        for e in late:
            word = e["method"] if e["arithmetic"] == "double" else e["arithmetic"]
            self.check(word in said[-1], f"advice names {e['method']} in {e['arithmetic']}", said)
        # what ended early, but for cut-off rows, stands in the list
        ends = {"double": 1e-13, "double-double": 1e-28, "ball": 1e-28}
        for key, rows in series(self.rows).items():
            done = [r["rtol"] for r in rows if not r.get("note", "").startswith("cut off")]
            whole = len(done) == len(rows) and done[-1] <= ends[key[1]] * 1.001
            told = [e for e in self.t["left_out"] if (e["method"], e["arithmetic"]) == key]
            self.check(whole or told, f"{key}: it is said why there is no more", rows[-1])
            self.check(not told or not done or "from" not in told[0] or told[0]["from"] < done[-1], f"{key}: from where on it was left out", told)

    def falls(self, label, rows):
        """Errors follow tolerances on the whole, as long as they can be told. One row may lie beside: an explicit method
        on a stiff system has the errors of its last few steps, at the edge of stability."""
        told = [r for r in rows if r["error"] is not None]
        if len(told) > 3 and max(r["error"] for r in told[:2]) > 1e-10:
            self.check(min(r["error"] for r in told[-2:]) < 0.1 * max(r["error"] for r in told[:2]), f"{label}: errors fall", [r["error"] for r in told])


def saved(build, request):
    """The result with its table and image, as the client writes them."""
    with tempfile.TemporaryDirectory() as folder:
        names = [os.path.join(folder, n) for n in ("request.json", "t.csv", "t.svg")]
        with open(names[0], "w", encoding="utf-8") as f:
            json.dump(request, f)
        run = subprocess.run([os.path.join(build, "sga"), "solve", names[0], "--json", "--tradeoff-csv", names[1], "--tradeoff-svg", names[2]],
                             capture_output=True, check=True, timeout=120, env={k: v for k, v in os.environ.items() if k != "SGA_SERVER"})
        with open(names[1], encoding="utf-8", newline="") as f:
            table = f.read()
        with open(names[2], encoding="utf-8") as f:
            return json.loads(run.stdout), table, f.read()


def solved(build, request):
    """The result, and once more with all digits of its numbers; or None and what is said instead."""
    run = subprocess.run([os.path.join(build, "sga"), "solve", "-", "--json"], input=json.dumps(request), capture_output=True, text=True,
                         check=False, timeout=120, env={k: v for k, v in os.environ.items() if k != "SGA_SERVER"})
    if run.returncode:
        return None, run.stderr
    return json.loads(run.stdout), json.loads(run.stdout, parse_float=mpmath.mpf, parse_int=mpmath.mpf)


def check_table(tally, name, rows, text):
    lines = list(csv.reader(text.splitlines()))
    tally.check(lines[0] == COLUMNS, f"{name}: columns of the table", lines[0])
    tally.check(len(lines) == len(rows) + 1, f"{name}: rows of the table")
    for r, line in zip(rows, lines[1:]):
        for key, is_ in zip(COLUMNS, line):
            should = r.get(key)
            same = is_ == "" if should is None else is_ == should if isinstance(should, str) else json.loads(is_) == should
            tally.check(same, f"{name}: table, {key}", (is_, should))


def check_image(tally, name, rows, text):
    root = ElementTree.fromstring(text.encode())
    tags = {e.tag for e in root.iter()}
    tally.check(root.tag == SVG + "svg" and tags <= {SVG + t for t in "svg title rect line polyline circle path text tspan".split()}, f"{name}: image", tags)
    placed = {k: [r for r in v if (r["error"] or r.get("error_at_most") or 0) > 0] for k, v in series(rows).items()}
    points = [len(e.get("points").split()) for e in root.iter(SVG + "polyline")]
    tally.check(points == [len(v) for v in placed.values() if v], f"{name}: a point for each row", points)
    texts = ["".join(e.itertext()) for e in root.iter(SVG + "text")]
    tally.check(all(", ".join(k) in texts for k in placed), f"{name}: the legend names all", texts)
    box = [float(x) for x in root.get("viewBox").split()]
    inside = all(0 <= float(v) <= m for e in root.iter(SVG + "polyline") for p in e.get("points").split() for v, m in zip(p.split(","), box[2:]))
    tally.check(inside, f"{name}: points are inside")
    # farther right is more error, higher is more time
    for line, k in zip(root.iter(SVG + "polyline"), [k for k, v in placed.items() if v]):
        at = [tuple(map(float, p.split(","))) for p in line.get("points").split()]
        for (p, a) in zip(at, placed[k]):
            for (q, b) in zip(at, placed[k]):
                ea, eb = a["error"] or a["error_at_most"], b["error"] or b["error_at_most"]
                if ea < eb and p[0] > q[0] + 0.2 or a["seconds"] < b["seconds"] and p[1] < q[1] - 0.2:
                    tally.check(False, f"{name}: places of the points", (a, b))


def check_case(tally, build, validator, case):
    name, expect, request = case["name"], case["expect"]["tradeoff"], case["request"]
    result, table, image = saved(build, request)
    fault = schemas.faults(validator, result)
    tally.check(not fault, f"{name}: schema", fault)
    t = result["tradeoff"]
    Table(tally, name, request, t).run()
    check_table(tally, name, t["rows"], table)
    check_image(tally, name, t["rows"], image)
    tally.check(("trajectory" in result) == ("trajectory" in request["want"]), f"{name}: a trajectory only where it is wanted")
    rows = t["rows"]
    tally.check(any((r.get("digits") or 0) >= expect["digits"] for r in rows), f"{name}: digits", [r.get("digits") for r in rows])
    methods = {r["method"] for r in rows if "digits" in r}
    tally.check(methods == set(expect["methods"]) if expect.get("only") else methods >= set(expect["methods"]), f"{name}: methods", methods)
    for m in expect.get("noted", []):
        tally.check(any(r["method"] == m and r.get("note") and "digits" not in r for r in rows), f"{name}: {m} says why it has no error")
    for k, e in enumerate(expect.get("last", [])):
        tight = [r for r in rows if "digits" in r][-1]
        tally.check(abs(tight["last"][k] - float(evaluate(e))) < 1e-10, f"{name}: last values", tight["last"])


def disturbed(build, request):
    """As solved(), of a process that gets a small part of the time on the clock: what it may do is CPU."""
    with tempfile.NamedTemporaryFile("w+") as given, tempfile.TemporaryFile("w+") as got:
        json.dump(request, given)
        given.flush()
        with subprocess.Popen([os.path.join(build, "sga"), "solve", given.name, "--json"], stdout=got,
                              env={k: v for k, v in os.environ.items() if k != "SGA_SERVER"}) as run:
            while run.poll() is None:
                run.send_signal(signal.SIGSTOP)
                time.sleep(0.05)
                run.send_signal(signal.SIGCONT)
                time.sleep(0.01)
        got.seek(0)
        return json.load(got)


def check_disturbed(tally, build):
    """The table is that of a machine at rest: every method to its tightest tolerance, though far more time passes on the clock than the
    rows may have."""
    request = {"system": {"form": "equations", "variables": ["x", "v"], "equations": ["x' = v", "v' = -x"]}, "want": ["tradeoff"],
               "accuracy": {"arithmetic": "double"}, "trajectory": {"stop": 300, "samples": 3, "initial": {"x": 1, "v": 0}}, "limits": {"seconds": DISTURBED}}
    t = disturbed(build, request)["tradeoff"]
    Table(tally, "disturbed", request, t).run()
    left = [e for e in t["left_out"] if "from" in e]
    tally.check(not left, "disturbed: nothing is left out", (left, t["advice"]))


class References:
    def __init__(self, tally):
        self.tally = tally
        self.rows = self.told = self.right = self.bounded = self.kept = self.promised = 0

    def add(self, name, should, accuracy, t, exact):
        should = [mpmath.mpf(v) for v in should]
        size = [max(abs(v), accuracy["atol"] / accuracy["rtol"]) for v in should]
        for r, last in zip(t["rows"], (e.get("last") for e in exact["rows"])):
            if "error_at_most" not in r:
                continue
            if r["arithmetic"] == "double":
                last = r["last"]
            # less than what is not known of the reference
            apart = [max(0, abs(mpmath.mpf(v) - s) - 10 * KNOWN * abs(s)) for v, s in zip(last, should)]
            true = float(max(apart))
            self.rows += 1
            self.bounded += true <= r["error_at_most"] and (r["digits"] == 0 or max(a / s for a, s in zip(apart, size)) <= 10 ** -r["digits"])
            if r["error"] is not None and r["error"] > 1000 * KNOWN * max(map(abs, should)):
                self.told += 1
                right = abs(true - r["error"]) <= TRUE_TO * r["error"]
                self.right += right
                self.tally.check(true <= 4 * r["error"] and r["error"] <= 4 * true, f"{name}: {r['method']} at {r['rtol']:g}", (true, r["error"]))
            if r["within"]:
                self.promised += 1
                self.kept += all(a <= accuracy["atol"] + accuracy["rtol"] * abs(s) for a, s in zip(apart, should))

    def none(self, name, should, accuracy, t):
        """Where none is said to have reached it, none has."""
        size = [max(abs(mpmath.mpf(v)), accuracy["atol"] / accuracy["rtol"]) for v in should]
        for c in t["choices"]:
            if c["reached"] is not False or c["digits"] is None:
                continue
            for r in t["rows"]:
                if r.get("last") and "digits" in r:
                    apart = max(abs(mpmath.mpf(v) - mpmath.mpf(s)) / z for v, s, z in zip(r["last"], should, size))
                    self.tally.check(apart > 0.999 * mpmath.mpf(10) ** -c["digits"], f"{name}: none has {c['digits']} digits", r)

    def end(self):
        print(f"{self.rows} rows with a bound, which holds in {self.bounded}; {self.told} errors told, true to {TRUE_TO:g} in {self.right}; "
              f"{self.promised} within the tolerances, true in {self.kept}")
        for what, n, of in (("bounds", self.bounded, self.rows), ("errors", self.right, self.told), ("promises", self.kept, self.promised)):
            self.tally.check(of and n >= HELD * of, f"{what} hold", f"{n} of {of}")


def main():
    mpmath.mp.dps = 40
    tally, build, named = Tally("tradeoff"), build_folder(), sys.argv[2:]
    validator = schemas.validator("result")
    with open(os.path.join(ROOT, "tests", "cases", "tradeoff.json"), encoding="utf-8") as f:
        for case in json.load(f):
            if "tradeoff" in case["expect"] and (not named or any(n in case["name"] for n in named)):
                check_case(tally, build, validator, case)
    references = References(tally)
    with open(os.path.join(ROOT, "tests", "cases", "trajectory_reference.json"), encoding="utf-8") as f:
        cases = [c for c in json.load(f) if not named or any(n in c["name"] for n in named)]
    if not named:
        check_disturbed(tally, build)
    for number, case in enumerate(cases):
        spec = case["request"]["trajectory"]
        request = {**case["request"], "want": ["tradeoff"], "trajectory": {**spec, "times": spec["times"][-1:]}, "limits": {"seconds": 16}}
        result, exact = solved(build, request)
        if not tally.check(result is not None, case["name"], exact):
            continue
        t = result["tradeoff"]
        Table(tally, case["name"], request, t).run()
        tally.check(t["best"] is not None, f"{case['name']}: a best solution", t["advice"])
        should = case["expect"]["trajectory"]["reference"][-1]
        references.add(case["name"], should, request["accuracy"], t, exact["tradeoff"])
        references.none(case["name"], should, request["accuracy"], t)
        request["limits"] = {"seconds": SHORT[number % len(SHORT)]}
        result, exact = solved(build, request)
        if result is not None:      # otherwise the reduction alone took the time
            Table(tally, case["name"] + ", short", request, result["tradeoff"]).run()
            references.add(case["name"], should, request["accuracy"], result["tradeoff"], exact["tradeoff"])
            references.none(case["name"], should, request["accuracy"], result["tradeoff"])
    if cases:
        references.end()
    return tally.end()


if __name__ == "__main__":
    sys.exit(main())
