"""Events that set variables or modes, in ball arithmetic: closed forms of bouncing balls, the cases of tests/cases beside double-double, and where nothing can be shown."""
import json
import os

import mpmath as mp

from tally import ROOT

# what has no enclosure: times of events that follow each other without time, or whose order is not told; a motion that stays at an event's zero without a constraint that holds it
ENDS = {"a brake that is let go", "two balls that hit at once", "two events that set one variable at once", "a set in double-double", "without restitution", "without restitution, backwards"}


def bounces(h, v, g, e, stop):
    """Times and speeds of a ball that starts at height h with v; (time, height, speed) at any time up to stop."""
    t, x, u, times = mp.mpf(0), h, v, []

    def at(s):
        k = max((i for i, b in enumerate(times) if b[0] < s), default=-1)
        t0, x0, u0 = (0, h, v) if k < 0 else (times[k][0], 0, times[k][2])
        return [x0 + u0 * (s - t0) - g * (s - t0) ** 2 / 2, u0 - g * (s - t0)]
    while len(times) < 60:
        fall = (u + mp.sqrt(u * u + 2 * g * x)) / g
        t, before = t + fall, u - g * fall
        if t > stop:
            return times, at
        x, u = mp.mpf(0), -e * before
        times.append((t, before, u))
    return None, at          # they have a limit


def random_bounces(c, rng, count):
    for k in range(count):
        h, v, g, e = mp.mpf(rng.randint(1, 9)) / 4, mp.mpf(rng.randint(-3, 3)) / 2, mp.mpf(rng.randint(1, 9)), mp.mpf(rng.randint(2, 9)) / 8
        name = f"bounces {k}: {h} {v} {g} {e}"
        if not c.wanted(name):
            continue
        stop = mp.mpf(rng.randint(2, 5)) * mp.sqrt(2 * h / g)
        stop = mp.mpf(int(stop * 64)) / 64
        times, at = bounces(h, v, g, e, stop)
        if times is None:
            continue
        tilt = rng.choice([None, "2", "-1/3"])
        system = {"form": "equations", "variables": ["x", "v"], "equations": ["x' = v", f"v' = -{mp.nstr(g, 30)}"]}
        event = {"name": "ground", "expression": "x", "direction": "down", "action": "set", "set": {"v": f"-({mp.nstr(e, 30)})*v"}}
        outputs = ["x", "v"]
        if tilt:            # the same in coordinates of a constraint: y = tilt x
            system = {"form": "equations", "variables": ["x", "y", "v"], "equations": ["x' = v", f"v' = -{mp.nstr(g, 30)}", f"y = ({tilt})*x"]}
            event["expression"], event["direction"] = f"({tilt})*y", "down"
        ask = [stop * i / 4 for i in range(1, 5)]
        t = c.solve(name, system, {"start": 0, "times": [mp.nstr(s, 30) for s in ask], "initial": {"x": mp.nstr(h, 30), "v": mp.nstr(v, 30)}, "outputs": outputs, "events": [event]}, 1e-25)
        if t is None:
            continue
        if t["ended"] and t["ended"]["reason"] == "accumulation":
            continue
        c.tally.check(t["ended"] is None and len(t["events"]) == len(times), f"{name}: as many", f"{t['ended']} {len(t['events'])} of {len(times)}")
        for got, (when, before, _) in zip(t["events"], times):
            c.tally.check(abs(mp.mpf(str(got["t"])) - when) <= got["error"] < 1e-20 and abs(mp.mpf(str(got["values"][1])) - before) < 1e-20, f"{name}: event", f"{got} {when}")
        for row, radii, s in zip(t["rows"], t["radii"], ask):
            should = at(s)
            near = min((abs(s - b[0]) for b in times), default=1)
            for x, r, w in zip(row[1:], radii, should):
                if x is None:        # a sample at the time of an event
                    c.tally.check(near < 1e-25, f"{name}: no value at {s}")
                    continue
                c.tally.check(abs(mp.mpf(str(x)) - w) <= r <= 1e-24 * (1 + abs(w)), f"{name}: at {s}", f"{x} {w} {r}")


def known_sets(c):
    """Every motion that sets something, beside the same in double-double: an arithmetic with other proofs, and estimates."""
    for file in ("events_set", "modes", "double_double_events"):
        with open(os.path.join(ROOT, "tests", "cases", file + ".json"), encoding="utf-8") as f:
            cases = json.load(f)
        for case in cases:
            motion = case["request"].get("trajectory", {})
            if not any(isinstance(e, dict) and "set" in e for e in motion.get("events", [])) or case["request"].get("sweep") or "sensitivities" in motion or not c.wanted(case["name"]):
                continue
            answers = []
            for arithmetic in ("double-double", "ball"):
                request = {**case["request"], "want": ["trajectory"], "accuracy": {"arithmetic": arithmetic, "rtol": 1e-20, "atol": 1e-20}}
                answers.append(c.solver.solve(request))
            (fine, no), (ball, none) = answers
            name = case["name"] + ", in balls"
            if ball is None:
                c.tally.check(no is not None and no["code"] == none["code"], f"{name}: refused as in double-double", f"{no} {none}")
                continue
            ball = ball["trajectory"]
            ended = ball["ended"]["reason"] if ball["ended"] else None
            c.tally.check((ended == "not_enclosed") == (case["name"] in ENDS), f"{name}: ends", str(ball["ended"]))
            if fine is None:
                continue
            fine = fine["trajectory"]
            if ended != "not_enclosed":
                c.tally.check(ended == (fine["ended"]["reason"] if fine["ended"] else None), f"{name}: ends alike", f"{ball['ended']} {fine['ended']}")
                c.tally.check(ended or ball["accuracy_reached"], f"{name}: accuracy", str(ball.get("accuracy_shortfall")))
                c.tally.check(ended or [e["name"] for e in ball["events"]] == [e["name"] for e in fine["events"]], f"{name}: events")
            for i, (x, y) in enumerate(zip(fine["rows"], ball["rows"])):
                error = fine["errors"][i]
                for a, b, r in zip(x[1:], y[1:], ball["radii"][i]):
                    if a is None or b is None or error is None:
                        continue
                    c.tally.check(abs(a - b) <= r + 3 * mp.mpf(error) + mp.mpf(10) ** -28 * (1 + abs(a)), f"{name}: at {x[0]}", f"{a} {b} {r} {error}")


def samples_at_events(c):
    ball = {"form": "equations", "variables": ["x", "v"], "equations": ["x' = v", "v' = -2"]}
    event = {"name": "ground", "expression": "x", "direction": "down", "action": "set", "set": {"v": "-0.8*v"}}
    t = c.solve("a sample at a bounce", ball, {"start": 0, "times": ["1", "2"], "initial": {"x": 1, "v": 0}, "events": [event]}, 1e-20) if c.wanted("a sample at a bounce") else None
    if t:
        c.tally.check(abs(t["rows"][0][1]) < 1e-20 and t["rows"][0][2] is None and t["rows"][1][2] is not None, "a sample at a bounce: no speed, as it has two", str(t["rows"]))
    for off in ("x - 1e-200", "x + 1e-200"):      # nearer than what the bits that the tolerances ask for tell apart
        label = f"the last sample right beside a bounce, {off}"
        beside = {**event, "expression": off}
        t = c.solve(label, ball, {"start": 0, "times": ["0.5", "1"], "initial": {"x": 1, "v": 0}, "events": [beside]}, 1e-20) if c.wanted(label) else None
        if t:
            c.tally.check(t["ended"] is None and len(t["events"]) <= 1 and abs(t["rows"][1][1]) < 1e-20 and t["rows"][1][2] in ((None, -2) if "+" in off else (None,)), f"{label}: no speed, or that before", str(t))
    clock = {"name": "clock", "expression": "t - 1", "action": "set", "set": {"v": "3"}}
    t = c.solve("a sample at a clock", ball, {"start": 0, "times": ["1", "1.5"], "initial": {"x": 1, "v": 0}, "events": [clock]}, 1e-20) if c.wanted("a sample at a clock") else None
    if t:                # its time is known: values before
        c.tally.check(outside_of(t, [[0, -2], [mp.mpf(3) / 2 - mp.mpf(1) / 4, 2]]), "a sample at a clock: values before", str(t["rows"]))


def outside_of(t, rows):
    return all(x is not None and abs(mp.mpf(str(x)) - s) <= r for got, radii, should in zip(t["rows"], t["radii"], rows) for x, r, s in zip(got[1:], radii, should))
