"""Samples as files: samples_check.py BUILD_DIR

What `sga solve --npy`, `--mat` and `--svg` print, by the programs that load them: NumPy, Octave, an XML reader. Each is held against the rows of
the answer, double for double; of the image against its own axes. Odd names, names that come twice, sweeps with sets that fail, values that there
are none, many columns, one row."""
import json
import math
import os
import re
import subprocess
import tempfile
import xml.etree.ElementTree

import numpy

from tally import Tally, build_folder

PENDULUM = {"form": "equations", "variables": ["x", "y", "lam"], "parameters": {"g": "9.81"}, "equations": ["x'' = -lam*x", "y'' = -lam*y - g", "x^2 + y^2 = 1"]}
START = {"x": 1, "y": 0}
DECAY = {"form": "equations", "variables": ["set"], "parameters": {"p": 1}, "equations": ["set' = set/p"]}
REQUESTS = {
    "plain": {"system": PENDULUM, "trajectory": {"stop": 2, "samples": 23, "initial": START}},
    "outputs": {"system": PENDULUM, "trajectory": {"stop": 1, "samples": 4, "initial": START, "outputs": ["x", "x' + y", "x", "t", "x", "x^2/(1 + y^2)"]}},
    "one row": {"system": PENDULUM, "trajectory": {"times": [0], "initial": START}},
    "digits": {"system": PENDULUM, "trajectory": {"stop": 1, "samples": 3, "initial": START}, "accuracy": {"arithmetic": "double-double"}},
    "sweep": {"system": DECAY, "trajectory": {"stop": 1, "samples": 3, "initial": {"set": 1}}, "sweep": [{"parameters": {"p": p}} for p in (1, 0, 2)]},
    "wide": {"system": {"form": "equations", "variables": [f"variable_{k}" for k in range(3000)], "equations": [f"variable_{k}' = {k}" for k in range(3000)]},
             "want": ["trajectory"], "trajectory": {"stop": 1, "samples": 2, "initial": {f"variable_{k}": k / 7 for k in range(3000)}}},
}


def run(build, folder, request, *options):
    path = os.path.join(folder, "request.json")
    with open(path, "w", encoding="utf-8") as f:
        json.dump(request, f)
    return subprocess.run([os.path.join(build, "sga"), "solve", path, *options], capture_output=True, check=False)


def told_apart(names):
    return [n if names.index(n) == i else f"{n}#{names[:i].count(n) + 1}" for i, n in enumerate(names)]


def table(result):
    """(columns, rows) of the answer as they should be in a file."""
    if "trajectory" in result:
        return told_apart(result["trajectory"]["columns"]), result["trajectory"]["rows"]
    sets = result["trajectories"]
    columns = next(s["columns"] for s in sets if "columns" in s)
    name = "set"
    while name in columns:
        name += "_"
    return [name] + told_apart(columns), [[k] + r for k, s in enumerate(sets) for r in s.get("rows", [])]


def same(got, rows):
    want = numpy.array([[math.nan if v is None else float(v) for v in r] for r in rows])
    return got.shape == want.shape and ((got == want) | (numpy.isnan(got) & numpy.isnan(want))).all()


def octave_table(path):
    """(names, values) as Octave has them, numbers in all their digits."""
    said = subprocess.run(["octave-cli", "--quiet", "--norc", "--no-history", "--eval",
                           f"s = load('{path}'); printf('%s %s %d %d %d\\n', strjoin(sort(fieldnames(s)), ','), class(s.rows), size(s.rows), iscellstr(s.columns)); "
                           "printf('%s\\n', s.columns{:}); printf('%.17g ', s.rows.');"], capture_output=True, text=True, check=False)
    lines = said.stdout.split("\n")
    fields, kind, rows, columns, names = lines[0].split()
    if (fields, kind, names) != ("columns,rows", "double", "1"):
        raise ValueError(said.stdout[:200] + said.stderr[:200])
    return lines[1:-1], numpy.array([float(w) for w in lines[-1].split()]).reshape(int(rows), int(columns))


def pixels(line):
    return [tuple(float(v) for v in p.split(",")) for p in line.get("points").split()]


def scale_of(root, across):
    """From pixels to values, by the labels of the axis that are numbers."""
    anchor, place = ("middle", "x") if across else ("end", "y")
    marks = [(float(t.get(place)) - (0 if across else 5), float(t.text)) for t in root.iter("{http://www.w3.org/2000/svg}text")
             if t.get("text-anchor") == anchor and not t.get("transform") and re.fullmatch(r"-?[\d.]+(e[-+]?\d+)?", t.text or "")]
    (p0, v0), (p1, v1) = marks[0], marks[-1]
    return lambda p: v0 + (p - p0) * (v1 - v0) / (p1 - p0)


def image(tally, name, text, x, y, rows):
    root = xml.etree.ElementTree.fromstring(text)
    lines = [line for line in root.iter("{http://www.w3.org/2000/svg}polyline")]
    to_x, to_y = scale_of(root, True), scale_of(root, False)
    if not tally.check(len(lines) == len(y), f"{name}: a curve for each column", len(lines)):
        return
    wide = [max(abs(r[k]) for r in rows) + 1 for k in range(len(rows[0]))]
    for k, line in zip(y, lines):
        got = [(to_x(a), to_y(b)) for a, b in pixels(line)]
        off = max(max(abs(a - r[x]) / wide[x], abs(b - r[k]) / wide[k]) for (a, b), r in zip(got, rows))
        tally.check(len(got) == len(rows) and off < 5e-3, f"{name}: the curve of column {k} is where its values are", off)


def one(tally, build, folder, name, request):
    answer = run(build, folder, request, "--json")
    if not tally.check(answer.returncode == 0, f"{name}: is solved", answer.stderr[:300]):
        return
    columns, rows = table(json.loads(answer.stdout))
    path = os.path.join(folder, "made.npy")
    made = run(build, folder, request, "--npy", "--output", path)
    tally.check(made.returncode == 0 and not made.stdout, f"{name}: npy into a file", made.stderr[:300])
    array = numpy.load(path, max_header_size=10**6)
    tally.check(list(array.dtype.names) == columns, f"{name}: npy's names", array.dtype.names)
    tally.check(same(numpy.array(array.tolist()), rows), f"{name}: npy's values")
    with open(path, "rb") as f:
        data = f.read()
    tally.check((len(data) - 8 * len(rows) * len(columns)) % 64 == 0, f"{name}: npy's values are aligned")
    path = os.path.join(folder, "made.mat")
    with open(path, "wb") as f:
        made = run(build, folder, request, "--mat")
        f.write(made.stdout)
    names, values = octave_table(path)
    tally.check(made.returncode == 0 and names == columns, f"{name}: mat's names", names[:20])
    tally.check(same(values, rows), f"{name}: mat's values")


def images(tally, build, folder):
    request = REQUESTS["plain"]
    columns, rows = table(json.loads(run(build, folder, request, "--json").stdout))
    image(tally, "all", run(build, folder, request, "--svg").stdout, 0, range(1, len(columns)), rows)
    chosen = run(build, folder, request, "--svg", "--x", "x", "--columns", "y,lam").stdout
    image(tally, "chosen", chosen, columns.index("x"), [columns.index("y"), columns.index("lam")], rows)
    wrong = run(build, folder, request, "--svg", "--columns", "y,z")
    tally.check(wrong.returncode == 1 and b"no column z; it has t x y" in wrong.stderr, "no such column", wrong.stderr)
    request = {**request, "trajectory": {**request["trajectory"], "outputs": ["x", "atan2(x, y)", "y"]}}
    columns, rows = table(json.loads(run(build, folder, request, "--json").stdout))
    image(tally, "commas", run(build, folder, request, "--svg", "--columns", "atan2(x, y),y").stdout, 0, [2, 3], rows)
    sweep = run(build, folder, REQUESTS["sweep"], "--svg").stdout
    tally.check(sweep.count(b"<polyline") == 2 and b">set, set 0<" in sweep and b">set, set 2<" in sweep, "a curve for each set that has rows", sweep[-600:])


def refusals(tally, build, folder):
    none = {"system": PENDULUM}
    for option in ("--npy", "--mat", "--svg"):
        path = os.path.join(folder, "none")
        said = run(build, folder, none, option)
        tally.check(said.returncode == 1 and not said.stdout and b"no samples" in said.stderr, f"{option} without samples", said.stderr)
        said = run(build, folder, {"system": {}}, option, "-o", path)
        tally.check(said.returncode == 1 and not os.path.exists(path), f"{option}: no file where there is no answer", said.stderr)
        said = run(build, folder, REQUESTS["plain"], option, "-o", os.path.join(folder, "none", "none"))
        tally.check(said.returncode == 1 and b"cannot write" in said.stderr, f"{option}: a place that cannot be written", said.stderr)
    tally.check(run(build, folder, none, "--npy", "--mat").returncode == 2, "two forms")


def main():
    tally, build = Tally("samples"), build_folder()
    with tempfile.TemporaryDirectory() as folder:
        for name, request in REQUESTS.items():
            try:
                one(tally, build, folder, name, request)
            except (ValueError, OSError, IndexError) as e:
                tally.check(False, name, f"{type(e).__name__}: {e}")
        images(tally, build, folder)
        refusals(tally, build, folder)
    return tally.end()


if __name__ == "__main__":
    raise SystemExit(main())
