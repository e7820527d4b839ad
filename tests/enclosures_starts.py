"""Starts that are searched for (start_equations, bounds), in ball arithmetic: closed forms of tests/cases/start_equations.json, and of random ones."""
import json
import os
import re

import mpmath as mp

from tally import ROOT

FUNCTIONS = {n: getattr(mp, n) for n in ("sin", "cos", "tan", "exp", "sqrt", "log", "sinh", "cosh", "tanh", "atan", "asin", "acos")}


def value(text, t):
    """A closed form of time, each number in it exact."""
    exact = re.sub(r"(?<![\w.])(\d+\.?\d*(?:e-?\d+)?)(?![\w.])", r"mpf('\1')", str(text)).replace("^", "**")
    return mp.mpf(eval(exact, {"mpf": mp.mpf, "t": t, "pi": mp.pi, **FUNCTIONS}))


def known_starts(c):
    with open(os.path.join(ROOT, "tests", "cases", "start_equations.json"), encoding="utf-8") as f:
        cases = json.load(f)
    for case in cases:
        closed = case["expect"].get("trajectory", {}).get("closed")
        motion = case["request"].get("trajectory", {})
        if not closed or not c.wanted(case["name"]) or "sensitivities" in motion or "events" in motion or case["request"].get("parameters"):
            continue
        n, stop = motion["samples"], mp.mpf(str(motion["stop"]))
        times = [mp.mpf(str(motion.get("start", 0))) * (n - 1 - k) / (n - 1) + stop * k / (n - 1) for k in range(n)]
        t = c.solve(case["name"] + ", in balls", case["request"]["system"], {**motion, "outputs": list(closed)}, 1e-25)
        c.hold(case["name"] + ", in balls", t, [[value(f, s) for f in closed.values()] for s in times], 1e-25)


def random_starts(c, rng, count):
    """A point on a circle by where it is asked to be, its speed by its angular momentum, or by how far it gets."""
    rod = {"form": "equations", "variables": ["x", "y", "l"], "equations": ["x'' = -l*x", "y'' = -l*y", "x^2 + y^2 = 1"]}
    for k in range(count):
        a, b, w = rng.randint(-9, 9), rng.randint(1, 9), rng.randint(-5, 5)
        name = f"random start {k}: towards ({a}, {b}), {w}"
        if not c.wanted(name):
            continue
        way, spare = rng.randrange(3), rng.random() < 0.5
        size = mp.sqrt(a * a + b * b)
        x, y, rate = mp.mpf(a) / size, mp.mpf(b) / size, mp.mpf(w)
        motion = {"start": 0, "times": ["0.5", "2"], "initial": {"x": a, "y": b}, "outputs": ["x", "y", "l"]}
        if way == 0:         # the nearest point of the circle
            motion["start_equations"] = [f"x*y' - y*x' = {w}"]
        elif way == 1:       # on a line through the origin
            motion["start_equations"] = [f"{b}*x = {a}*y", f"x*y' - y*x' = {w}"]
            motion["bounds"] = {"y": [0, None]}
        else:                # a bound that the nearest point passes
            x, y = mp.mpf(3) / 5, mp.mpf(4) / 5
            motion["initial"] = {"x": "0.9", "y": "0.5"}
            motion["start_equations"] = ["5*x = 3", f"x*y' - y*x' = {w}"]
            motion["bounds"] = {"y": ["0.5", None]}
        if spare:            # what follows from the others
            motion["start_equations"].insert(rng.randrange(len(motion["start_equations"]) + 1), rng.choice(["x^2 = 1 - y^2", "x*x' = -y*y'", f"{w} = x*y' - y*x'"]))
        t = c.solve(name, rod, motion, 1e-25)
        rows = [[x * mp.cos(rate * s) - y * mp.sin(rate * s), y * mp.cos(rate * s) + x * mp.sin(rate * s), rate ** 2] for s in (mp.mpf("0.5"), mp.mpf(2))]
        c.hold(name, t, rows, 1e-25)
    c.closed("a start on its bound", {"form": "equations", "variables": ["x", "y"], "equations": ["x' = y", "y' = -x", "x^2 + y^2 = 1"]}, ["1"], {"x": "0.9", "y": "0.1"}, ["x", "y"],
             lambda t: [mp.mpf("0.75") * mp.cos(t) + mp.sqrt(7) / 4 * mp.sin(t), mp.sqrt(7) / 4 * mp.cos(t) - mp.mpf("0.75") * mp.sin(t)], 1e-30, bounds={"x": [None, 0.75]})
    c.refused("a start that no point meets", rod, {"start": 0, "stop": 1, "initial": {"x": 1, "y": 0}, "start_equations": ["x = 2"]}, "inconsistent_initial")
