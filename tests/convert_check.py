"""The converters of the Python client: convert_check.py BUILD_DIR

Requests from netlists, Modelica, SymPy and MATLAB's text, and back, each by another route: stamps, closed forms, round trips at random points."""
import contextlib
import glob
import io
import os
import random
import re
import sys

import convert_modelica
import convert_spice
from solver import Solver
from tally import ROOT, Tally, build_folder, scaled, seed

sys.path.insert(0, os.path.join(ROOT, "clients", "python"))


def pages(tally):
    """doc/convert.md: texts are the examples' files, Python runs and prints what stands below it."""
    with open(os.path.join(ROOT, "doc", "convert.md"), encoding="utf-8") as f:
        blocks = re.findall(r"^```(\w+)\n(.*?)^```$", f.read(), re.S | re.M)
    files = [open(p, encoding="utf-8").read() for p in glob.glob(os.path.join(ROOT, "etc", "examples", "*")) if not p.endswith((".json", ".c"))]
    space = {}
    for (before, code), (language, block) in zip([("", ""), *blocks], blocks):
        if language == "python":
            try:
                compile(block, "doc/convert.md", "exec")
            except SyntaxError as e:
                tally.check(False, "doc/convert.md", f"{e}: {block}")
        if language == "text" and before == "python":
            out = io.StringIO()
            try:
                with contextlib.redirect_stdout(out):
                    exec(code, space)
            except Exception as e:
                out.write(f"{type(e).__name__}: {e}")
            tally.check(out.getvalue() == block, f"doc/convert.md: {code[:50]!r} prints what it says", out.getvalue())
        elif language == "text":
            tally.check(block in files, "doc/convert.md: an example's text", block[:60])


def main():
    tally, build = Tally("convert"), build_folder()
    rng = random.Random(seed(31))
    for module, count in ((convert_spice, 60), (convert_modelica, 200)):
        try:
            module.check(tally, Solver(build), rng, scaled(count))
        except Exception as e:    # an error in one is one failure; the others go on
            tally.check(False, module.__name__, f"{type(e).__name__}: {e}")
    pages(tally)
    return tally.end()


if __name__ == "__main__":
    raise SystemExit(main())
