"""Events in ball arithmetic: each time in a ball that holds it, all of them, in order, and none of another kind.

The motion is a turn, in one of four spellings (two variables, a circle of three with its multiplier, a rate that grows with time, backwards);
functions are products and shifted pairs of x - c, y - d, t - e, so that the truth is a list of closed forms."""
import mpmath as mp

SPELLINGS = [
    ("plain", {"form": "equations", "variables": ["x", "y"], "equations": ["x' = y", "y' = -x"]}, {"x": 1, "y": 0}),
    ("circle", {"form": "equations", "variables": ["x", "y", "l"], "equations": ["x' = y + l*x", "y' = -x + l*y", "x^2 + y^2 = 1"]}, {"x": 1, "y": 0}),
    ("second order", {"form": "equations", "variables": ["x", "y"], "equations": ["x'' = -x", "y = x'"]}, {"x": 1, "x'": 0}),
]
STOP = 7


def zeros(kind, c):
    """Times in (0, STOP) at which x, y or t is c, and the sign of its rate."""
    if kind == "t":
        return [(mp.mpf(c), 1)]
    a = mp.acos(c) if kind == "x" else mp.asin(-c)
    both = [(a, -1), (-a, 1)] if kind == "x" else [(a, -1), (mp.pi - a, 1)]
    return [(t + 2 * k * mp.pi, s) for t, s in both for k in range(-1, 3) if 0 < t + 2 * k * mp.pi < STOP]


def value(kind, c, t):
    return (mp.cos(t) if kind == "x" else -mp.sin(t) if kind == "y" else t) - mp.mpf(c)


def draw(rng):
    """Factors of one function: (kind, place as text, place)."""
    out = []
    for _ in range(rng.choice([1, 1, 2, 3])):
        kind = rng.choice("xyt")
        place = mp.mpf(rng.randint(1, 8)) / 10 * (5 if kind == "t" else rng.choice([1, -1]))
        out.append((kind, mp.nstr(place, 12), place))
        if rng.random() < 0.3:       # a cluster: what double takes for one
            near = place + mp.mpf(10) ** -rng.randint(3, 11)
            out.append((kind, mp.nstr(near, 30), near))
    return out


def truth(factors):
    found = []
    for i, (kind, _, c) in enumerate(factors):
        for t, s in zeros(kind, c):
            others = mp.mpf(1)
            for j, (k, _, d) in enumerate(factors):
                others *= 1 if j == i else value(k, d, t)
            if abs(others) < mp.mpf(10) ** -30:      # a double zero
                return None
            found.append((t, "up" if s * others > 0 else "down"))
    return sorted(found)


def random_events(c, rng, count):
    """One function and one motion each; forwards and backwards, going on or stopping at one of them."""
    for case in range(count):
        name, system, start = rng.choice(SPELLINGS)
        label = f"events {case} ({name})"
        factors = draw(rng)
        expected = truth(factors)
        if not c.wanted(label) or expected is None:
            continue
        event = {"name": "e", "expression": "*".join(f"({k} - ({text}))" for k, text, _ in factors)}
        if rng.random() < 0.3:
            event["direction"] = rng.choice(["up", "down"])
            expected = [e for e in expected if e[1] == event["direction"]]
        if rng.random() < 0.3:
            event["action"] = "stop"
        trajectory = {"start": 0, "stop": STOP, "samples": 8, "initial": start, "events": [event]}
        t = c.solve(label, system, trajectory, 1e-16)
        if t is None:
            continue
        stops = event.get("action") == "stop" and bool(expected)
        expected = expected[:1] if stops else expected
        check(c.tally, label, t, expected, stops)


def check(tally, label, t, expected, stops):
    got = t["events"]
    if not tally.check([e["direction"] for e in got] == [d for _, d in expected], f"{label}: which", f"{[(str(e['t']), e['direction']) for e in got]} for {expected}"):
        return
    for e, (at, _) in zip(got, expected):
        off = abs(mp.mpf(str(e["t"])) - at)
        tally.check(off <= mp.mpf(str(e["error"])) + mp.mpf(10) ** -50, f"{label}: inside", f"{mp.nstr(off, 3)} > {e['error']}")
        tally.check(mp.mpf(str(e["error"])) < mp.mpf(10) ** -9, f"{label}: known", str(e["error"]))
    if stops:
        tally.check(t["ended"] is not None and t["ended"]["reason"] == "event", f"{label}: it stops", str(t["ended"]))
        rows = [r for r in range(8) if r * mp.mpf(STOP) / 7 < expected[0][0]]
        tally.check(len(t["rows"]) == len(rows), f"{label}: rows before it", str(len(t["rows"])))
    else:
        tally.check(t["ended"] is None and len(t["rows"]) == 8, f"{label}: it goes on", str(t["ended"]))


def backwards(c, rng, count):
    """The same zeros in the other order, with directions as time grows."""
    for case in range(count):
        factors = draw(rng)
        expected = truth(factors)
        label = f"events back {case}"
        if expected is None or not c.wanted(label):
            continue
        system = {"form": "equations", "variables": ["x", "y", "c"], "equations": ["x' = y", "y' = -x", "c = cos(7) - cos(t)"]}
        event = {"name": "e", "expression": "*".join(f"({k} - ({text}))" for k, text, _ in factors)}
        t = c.solve(label, system, {"start": STOP, "stop": 0, "samples": 8, "initial": {"x": "cos(7)", "y": "-sin(7)"}, "events": [event]}, 1e-16)
        if t is not None:
            check(c.tally, label, t, expected[::-1], False)


def touches(c):
    """What cannot be proved is said, where it is; what stops a motion ends it there."""
    for text, at in [("x - 1", mp.pi / 2), ("(x - 1)^2", mp.pi / 2), ("abs(y)", mp.pi / 2)]:
        for action in ("record", "stop"):
            label = f"touch {text}, {action}"
            if not c.wanted(label):
                continue
            t = c.solve(label, {"form": "equations", "variables": ["x", "y"], "equations": ["x' = y", "y' = -x"]},
                        {"start": 0, "stop": 3, "samples": 4, "initial": {"x": 0, "y": 1}, "events": [{"name": "e", "expression": text, "action": action}]}, 1e-16)
            if t is None:
                continue
            got = t["events"]
            if c.tally.check([e["direction"] for e in got] == ["undecided"], label, str(got)):
                c.tally.check(abs(mp.mpf(str(got[0]["t"])) - at) <= mp.mpf(str(got[0]["error"])) < 1e-9, f"{label}: where", str(got[0]))
            reason = t["ended"] and t["ended"]["reason"]
            c.tally.check(reason == ("not_enclosed" if action == "stop" else None), f"{label}: the end", str(t["ended"]))
            c.tally.check(len(t["rows"]) == (2 if action == "stop" else 4), f"{label}: rows", str(len(t["rows"])))
