"""Switches of equations (abs, sign, min, max, if) that turn along a motion in ball arithmetic, with derivatives, events at their very zeros, and sweeps: closed forms of dry friction
and of a ball in air that bounces; random fields beside double-double, which goes through them in its steps; and what is not gone through."""
import json

import mpmath as mp

# what closed forms are off by, in the digits that they are made with
LOW = mp.mpf(10) ** -38


def friction(x, v, k, stop):
    """x'' = -x - k sign(x') from (x, v): (t, x, v) at any time up to stop, and the times of turns."""
    pieces, t = [], mp.mpf(0)
    side = mp.sign(v) if v else -mp.sign(x)
    while t < stop:
        c = -k * side
        pieces.append((t, x - c, v, c))
        # v(s) = v cos s - (x - c) sin s
        s = mp.atan2(v, x - c) % mp.pi
        s = s if s > mp.mpf(10) ** -30 else mp.pi
        x, t, v, side = c + (x - c) * mp.cos(s) + v * mp.sin(s), t + s, mp.mpf(0), -side
        if abs(x) <= k:
            return None, None           # it sticks

    def at(s):
        t0, a, b, c = [p for p in pieces if p[0] <= s][-1]
        return [c + a * mp.cos(s - t0) + b * mp.sin(s - t0), b * mp.cos(s - t0) - a * mp.sin(s - t0)]
    return at, [p[0] for p in pieces[1:]]


def in_air(h, k, e, stop):
    """x'' = -1 - k v |v| from rest at height h, with restitution e: (x, v) at any time, times of tops and of bounces."""
    r, pieces, t, tops, bounces = mp.sqrt(k), [], mp.mpf(0), [], []
    x, v = h, mp.mpf(0)
    while t < stop:
        if len(pieces) > 16:
            return None, None, None         # bounces have a limit
        if v > 0:
            pieces.append((t, x, v))
            angle = mp.atan(v * r)
            t, x, v = t + angle / r, x - mp.log(mp.cos(angle)) / k, mp.mpf(0)
            tops.append(t)
        else:
            pieces.append((t, x, v))
            fall = mp.acosh(mp.exp(k * x)) / r
            t, x, v = t + fall, mp.mpf(0), e * mp.tanh(r * fall) / r
            bounces.append(t)

    def at(s):
        t0, x0, v0 = [p for p in pieces if p[0] <= s][-1]
        if v0 > 0:
            angle = mp.atan(v0 * r)
            return [x0 + mp.log(mp.cos(angle - r * (s - t0)) / mp.cos(angle)) / k, mp.tan(angle - r * (s - t0)) / r]
        return [x0 - mp.log(mp.cosh(r * (s - t0))) / k, -mp.tanh(r * (s - t0)) / r]
    return at, [s for s in tops if s < stop], [s for s in bounces if s < stop]


def slopes(function, at, times):
    """Derivatives of its values by each of the numbers in `at`, as columns of sensitivities come."""
    h = mp.mpf(10) ** -25
    rows = []
    for t in times:
        moved = []
        for k in range(len(at)):
            up, down = ([a + (s * h if i == k else 0) for i, a in enumerate(at)] for s in (1, -1))
            moved.append([(p - q) / (2 * h) for p, q in zip(function(*up)(t), function(*down)(t))])
        rows.append([moved[k][j] for j in range(len(moved[0])) for k in range(len(at))])
    return rows


def hold_slopes(c, name, t, rows, low=mp.mpf(10) ** -35):
    s = t.get("sensitivities")
    if not c.tally.check(s is not None and not s.get("ended") and len(s["rows"]) == len(rows), f"{name}: derivatives at all rows", json.dumps(s and s["ended"] or s, default=str)[-300:]):
        return
    for got, radii, true in zip(s["rows"], s["radii"], rows):
        off = [(j, str(a), str(b)) for j, (a, r, b) in enumerate(zip(got[1:], radii, true)) if abs(a - b) > r + low * (1 + abs(b)) + abs(mp.mpf(a)) * mp.mpf(10) ** -20]
        c.tally.check(not off, f"{name}: derivatives at {got[0]}", str(off[:2]))


def random_friction(c, rng, count):
    for n in range(count):
        x, v, k, name = mp.mpf(rng.randint(-12, 12)) / 4, mp.mpf(rng.choice([0, 0, 1, -2, 3, -5])) / 4, mp.mpf(rng.randint(1, 4)) / 8, f"dry friction {n}"
        stop = mp.mpf(rng.randint(3, 9))
        if not c.wanted(name) or abs(x) <= k:
            continue
        at, turns = friction(x, v, k, stop)
        if at is None:
            continue
        # as it is, on a line in the plane (index 3), with its speed solved for (index 1)
        form = rng.choice(["plain", "line", "solved"])
        system = {"form": "equations", "variables": ["x", "v"], "equations": ["x' = v", "v' = -x - k*sign(v)"], "parameters": {"k": mp.nstr(k, 20)}}
        if form == "line":
            system["variables"] = ["x", "y", "v", "w", "l"]
            system["equations"] = ["x' = v", "y' = w", "v' = -x - k*sign(v) + l", "w' = -2*x - 2*k*sign(w) - l/2", "y = 2*x"]
        elif form == "solved":
            system["variables"] = ["x", "v", "s"]
            system["equations"] = ["x' = v", "v' = -x - k*(if(s > 0, 1, -1))", "s = v/3"]
        asked = [stop * i / 5 for i in range(6)]
        moving = bool(v) and form == "plain"
        trajectory = {"start": 0, "times": [mp.nstr(s, 30) for s in asked], "initial": {"x": mp.nstr(x, 20), "v": mp.nstr(v, 20)}, "outputs": ["x", "v"],
                      "events": [{"name": "turn", "expression": "v" if rng.random() < 0.5 or form == "solved" else "-v"}], "sensitivities": {"parameters": ["k"], "initial": ["x"] if moving else []}}
        t = c.solve(f"{name} ({form})", system, trajectory, 1e-24)
        c.hold(f"{name} ({form})", t, [at(s) for s in asked], 1e-24, LOW)
        if t is None:
            continue
        if form != "solved":
            told = [e for e in t["events"] if e["t"] > 0 or v]
            c.tally.check(len(told) == len(turns) and all(abs(e["t"] - s) <= e["error"] + mp.mpf(10) ** -15 for e, s in zip(told, turns)), f"{name} ({form}): turns at their times", f"{t['events']} {turns}"[:300])
        hold_slopes(c, f"{name} ({form})", t, slopes(lambda kk, xx=x: friction(xx, v, kk, stop)[0], [k] + ([x] if moving else []), asked))


def random_air(c, rng, count):
    for n in range(count):
        h, k, e, name = mp.mpf(rng.randint(2, 9)) / 4, mp.mpf(rng.randint(1, 6)) / 8, mp.mpf(rng.randint(5, 8)) / 8, f"a ball in air {n}"
        if not c.wanted(name):
            continue
        stop = mp.mpf(rng.randint(4, 9))
        at, tops, bounces = in_air(h, k, e, stop)
        if at is None:
            continue
        asked = [stop * i / 5 for i in range(6)]
        system = {"form": "equations", "variables": ["x", "v"], "equations": ["x' = v", "v' = -1 - k*v*abs(v)"], "parameters": {"k": mp.nstr(k, 20), "e": mp.nstr(e, 20)}}
        events = [{"name": "ground", "expression": "x", "direction": "down", "action": "set", "set": {"v": "-e*v"}}, {"name": "top", "expression": "v", "direction": "down"}]
        t = c.solve(name, system, {"start": 0, "times": [mp.nstr(s, 30) for s in asked], "initial": {"x": mp.nstr(h, 20), "v": 0}, "outputs": ["x", "v"], "events": events,
                                   "sensitivities": {"parameters": ["k", "e"]}}, 1e-22)
        c.hold(name, t, [at(s) for s in asked], 1e-22, LOW)
        if t is None:
            continue
        for what, times in (("ground", bounces), ("top", tops)):
            told = [ev["t"] for ev in t["events"] if ev["name"] == what]
            c.tally.check(len(told) == len(times) and all(abs(a - b) <= mp.mpf(10) ** -14 for a, b in zip(told, times)), f"{name}: {what}", f"{told} {times}"[:300])
        hold_slopes(c, name, t, slopes(lambda kk, ee: in_air(h, kk, ee, stop)[0], [k, e], asked))


def random_fields(c, rng, count):
    """Beside double-double."""
    switches = ["abs({})", "max({}, 0)", "min({}, 1/3)", "if({} > 0, 1/4, -1/8)", "sign({})/5", "max(abs({}) - 1/2, 0)"]
    for n in range(count):
        name, dimension = f"switches {n}", rng.randint(1, 3)
        if not c.wanted(name):
            continue
        names = [f"x{i}" for i in range(dimension)]

        def linear():
            return " + ".join(f"({rng.randint(-4, 4)}/4)*{x}" for x in names) + f" + {rng.randint(-3, 3)}/8" + rng.choice(["", " + sin(t)", " - cos(2*t)"])
        equations = [f"{x}' = -{x} + cos({i + 1}*t) + a*{rng.choice(switches).format(linear())} + {rng.choice(switches).format(linear())}/2" for i, x in enumerate(names)]
        variables = list(names)
        if rng.random() < 0.4:
            variables.append("z")
            equations.append(f"z = 2*{names[0]} + {rng.choice(switches[:2]).format(names[-1])}")
        system = {"form": "equations", "variables": variables, "equations": equations, "parameters": {"a": "3/4"}}
        backward = rng.random() < 0.2
        trajectory = {"start": 0, "stop": -2 if backward else 5, "samples": 6, "initial": {x: f"{rng.randint(-9, 9)}/8" for x in names}, "sensitivities": {"parameters": ["a"], "initial": names[:1]}}
        both = []
        for arithmetic, rtol in (("ball", 1e-20), ("double-double", 1e-20)):
            result, problem = c.solver.solve({"system": system, "want": ["trajectory"], "trajectory": trajectory, "accuracy": {"rtol": rtol, "atol": rtol, "arithmetic": arithmetic}})
            both.append(result and result["trajectory"])
            refused = problem and problem["code"] in ("no_motion", "inconsistent_initial") and ("starts at the zero" in problem["detail"] or "starts where the equations change" in problem["detail"] or "goes on from another surface" in problem["detail"])
            c.tally.check(result is not None or refused, f"{name}: {arithmetic}", json.dumps(problem)[:300])
        ball, fine = both
        if not ball or not fine:
            continue
        if fine["ended"] or ball["ended"]:
            # a jump that leads back: both end there; balls also where two switches turn at once, or one only touches
            c.tally.check(ball["ended"] is not None and (not fine["ended"] or abs(ball["ended"]["t"]) <= abs(fine["ended"]["t"]) + mp.mpf(10) ** -12), f"{name}: ends not beyond", f"{ball['ended']} {fine['ended']}"[:300])
            c.ended_early += fine["ended"] is None
        c.compared += 1
        for row, radii, other in zip(ball["rows"], ball["radii"], fine["rows"]):
            off = [(a, b) for a, r, b in zip(row[1:], radii, other[1:]) if abs(a - b) > r + mp.mpf(10) ** -17 * (1 + abs(b))]
            c.tally.check(not off, f"{name}: as double-double at {row[0]}", str(off))
        s, f = ball.get("sensitivities"), fine.get("sensitivities")
        for row, radii, other in zip(s["rows"], s["radii"], f["rows"]):
            off = [(a, b) for a, r, b in zip(row[1:], radii, other[1:]) if abs(a - b) > r + mp.mpf(10) ** -9 * (1 + abs(b))]
            c.tally.check(not off, f"{name}: derivatives as double-double at {row[0]}", str(off))


def side_of_abs(c):
    """x' = -1 + |x| / 2."""
    turn = 2 * mp.log(mp.mpf(4) / 3)

    def at(t):
        return [2 - mp.mpf(3) / 2 * mp.exp(t / 2) if t < turn else 2 * mp.exp((turn - t) / 2) - 2]
    if c.wanted("abs at 0"):
        t = c.solve("abs at 0", {"form": "equations", "variables": ["x"], "equations": ["x' = -1 + abs(x)/2"]}, {"start": 0, "times": ["0.25", "4"], "initial": {"x": "1/2"}}, 1e-30)
        c.hold("abs at 0", t, [at(mp.mpf("0.25")), at(mp.mpf(4))], 1e-30, LOW)


def sides_swept(c):
    """Sets of a sweep go through as requests of their own do."""
    name = "sets of a sweep through a switch"
    if not c.wanted(name):
        return
    system = {"form": "equations", "variables": ["x", "v"], "equations": ["x' = v", "v' = -x - k*sign(v)"], "parameters": {"k": "1/8"}}
    trajectory = {"start": 0, "stop": 8, "samples": 5, "initial": {"x": 3, "v": 0}}
    for sweep in ([{"parameters": {"k": "1/8"}}, {"parameters": {"k": "3/8"}}], [{"initial": {"x": 3}}, {"initial": {"x": "5/2", "v": "1/4"}}]):
        result, problem = c.solver.solve({"system": system, "want": ["trajectory"], "trajectory": trajectory, "sweep": sweep, "accuracy": {"rtol": 1e-20, "arithmetic": "ball"}})
        if not c.tally.check(result is not None, name, json.dumps(problem)):
            continue
        for m, t in zip(sweep, result["trajectories"]):
            k, x, v = (mp.mpf(eval(str(m.get(kind, {}).get(what, other)))) for kind, what, other in (("parameters", "k", "1/8"), ("initial", "x", "3"), ("initial", "v", "0")))
            at, _ = friction(x, v, k, mp.mpf(8))
            c.hold(f"{name}: {m}", t, [at(mp.mpf(s)) for s in (0, 2, 4, 6, 8)], 1e-20, LOW)


def sides_not_taken(c):
    sticks = {"form": "equations", "variables": ["x", "v"], "equations": ["x' = v", "v' = -x - sign(v)"]}
    one = {"form": "equations", "variables": ["x"], "equations": ["x' = -sign(x)/2"]}
    touches = {"form": "equations", "variables": ["x"], "equations": ["x' = sign((t - 2)^2)"]}
    for name, system, initial, t, rows, reason in (
            ("a mass that sticks", sticks, {"x": "5/2", "v": 0}, mp.pi, 4, "not_smooth"), ("a jump that leads back", one, {"x": 1}, mp.mpf(2), 2, "not_smooth"),
            # a switch that only touches its zero is not told from one that turns
            ("a switch that touches", touches, {"x": 0}, mp.mpf(2), 2, "not_enclosed")):
        if not c.wanted(name):
            continue
        got = c.solve(name, system, {"start": 0, "stop": 4, "samples": 5, "initial": initial}, 1e-8)
        ended = got and got["ended"]
        c.tally.check(ended and ended["reason"] == reason and abs(ended["t"] - t) < mp.mpf(10) ** -9 and len(got["rows"]) in (rows, rows + 1), f"{name}: ends", str(ended))
        c.tally.check(reason == "not_enclosed" or "trajectory.sliding" in ended["detail"], f"{name}: says what follows it", str(ended))
