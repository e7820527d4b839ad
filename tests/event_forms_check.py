"""Events whose functions have the same signs: event_forms_check.py BUILD_DIR

Random motions, with and without switches in their equations, and a function u of them; u's zeros are asked for as they are, and as those of functions that have u's sign: smooth ones,
saturated ones, and ones that jump over 0. Times, directions, and what stops there are the same, in both arithmetics, of which `auto` takes the longer one where
tolerances ask for it, forward and backward, and errors of times hold."""
import json
import math
import random
import sys

import mpmath

from solver import Crash, Solver
from tally import Tally, build_folder, scale, scaled, seed

FORMS = ["{u}", "-({u})", "({u})^3", "sinh({u})", "atan({u})/4", "({u})*(2 + sin({w}))", "({u})/(1 + abs({u}))", "max(min({u}, 1/50), -1/30)", "({u})*abs({u})",
         "sign({u})", "sign({u}) + cos({w})/2", "2*sign({u}) - ({w})/(1 + abs({w}))", "if({u} > 0, 3, -1/7)", "if({u} > 0, 1 + ({w})^2, -1/2 - ({u})^2)", "sign({u})*(1 + ({w})^2)",
         "1000*sign({u}) + 7*cos(3*{w})", "({u})*100 + sign({u})", "step({u}) - 1/2"]
ODD = {"-({u})"}           # which turn the sign
CLOSE, NEAR = 3e-2, {"double": 2e-7, "double-double": 1e-15, "auto": 1e-15}


def number(rng):
    return f"{rng.choice([-1, 1]) * rng.randint(1, 12)}/{rng.choice([4, 5, 8])}"


def linear(rng, names):
    return " + ".join(f"({number(rng)})*{x}" for x in names)


def motion(rng):
    names = ["x", "v", "w"][:rng.randint(2, 3)]
    u = rng.choice([names[1], linear(rng, names), f"{linear(rng, names)} + 1/5", f"{names[1]} - sin(2*t)/3", "sin(3*t) + 1/7", f"sin(2*{names[0]}) + {names[1]}/4"])
    switch = rng.choice(["", "", f" - sign({u})/8", f" + abs({u})/4", f" - max({u}, 0)/3", f" - sign({names[1]})/5", " + sign(sin(3*t))/4"])
    equations = ["x' = v", f"v' = -{rng.randint(2, 9)}*x - v/{rng.randint(10, 60)} + cos({rng.randint(1, 3)}*t)/2{switch}"] + ["w' = x - w/3"][:len(names) - 2]
    system = {"form": "equations", "variables": names, "equations": equations}
    if rng.random() < 0.3:
        system = {**system, "variables": names + ["z"], "equations": equations + [f"z = {linear(rng, names)}"]}
    return system, {x: number(rng) for x in names}, u, linear(rng, names)


def events(result):
    return [(e["t"], e["direction"], e["error"]) for e in result["trajectory"]["events"]]


class Forms:
    def beside_balls(self, system, trajectory, plain, name):
        """What is proved of a motion whose events set variables, also where switches of its equations have their zeros: events, rows, derivatives."""
        result, _ = self.ask(system, trajectory, "ball")
        ball = result and result["trajectory"]
        if not ball or ball["ended"] or plain["ended"]:
            return
        self.proved += 1
        self.tally.check(len(ball["events"]) == len(plain["events"]) and all(abs(a["t"] - b["t"]) <= 1e-7 for a, b in zip(ball["events"], plain["events"])), f"{name}: events as in balls", f"{ball['events']} {plain['events']}"[:400])
        for a, b in zip(ball["rows"], plain["rows"]):
            self.tally.check(all(abs(p - q) <= plain["error_estimate"] + 1e-12 * (1 + abs(q)) for p, q in zip(a, b)), f"{name}: rows as in balls", f"{a} {b}")
        s, z = ball["sensitivities"], plain["sensitivities"]
        for a, b in zip(s["rows"], z["rows"]):
            self.tally.check(all(abs(p - q) <= 1e-5 * (1 + max(map(abs, a))) for p, q in zip(a, b)), f"{name}: derivatives as in balls", f"{a} {b}")

    def slopes(self, got, other, name):
        """Derivatives are the same, up to where they end; those of functions that jump end with what says why."""
        ended = got["ended"]
        self.tally.check(not ended or other["ended"] or "jumps over 0" in ended["detail"] or "several at once" in ended["detail"], f"{name}: derivatives end", str(ended))
        off = [(a, b) for a, b in zip(got["rows"], other["rows"]) if any(abs(p - q) > 1e-5 * (1 + max(map(abs, b))) for p, q in zip(a, b))]
        self.tally.check(not off, f"{name}: derivatives are the same", str(off[:1]))
        self.differentiated += not ended

    def __init__(self, solver, tally):
        self.solver, self.tally, self.compared, self.jumped, self.differentiated, self.proved = solver, tally, 0, 0, 0, 0

    def ask(self, system, trajectory, arithmetic):
        rtol = 1e-9 if arithmetic == "double" else 1e-20
        return self.solver.solve({"system": system, "want": ["trajectory"], "trajectory": trajectory, "accuracy": {"rtol": rtol, "atol": rtol, "arithmetic": arithmetic}})

    def check(self, rng, n):
        system, initial, u, w = motion(rng)
        arithmetic, action = rng.choice(["double", "double", "double-double", "auto"]), rng.choice(["record", "record", "stop", "set"])
        stop, direction = rng.choice([6, 6, -4]), rng.choice(["any", "any", "up", "down"])
        base = {"start": 0, "stop": stop, "samples": 3, "initial": initial}
        if action == "set" and rng.random() < 0.6:
            base["sensitivities"] = {"initial": ["x"]}

        def asked(form, way):
            event = {"name": "e", "expression": form.format(u=u, w=w), "direction": way, "action": action}
            return {**base, "events": [{**event, "set": {"v": "-v*2/3 - 1/9"}, "max": 3} if action == "set" else event]}
        plain, problem = self.ask(system, asked("{u}", direction), arithmetic)
        name = f"motion {n}, {arithmetic}, {action} {direction} at {u}"
        if plain is None:      # a jump that leads back, from the start on
            self.tally.check(problem["code"] in ("no_motion", "not_supported", "inconsistent_initial"), name, json.dumps(problem)[:300])
            return
        told = events(plain)
        times = [0.0] + [t for t, *_ in told]
        every = self.ask(system, {**base, "events": [{"name": "e", "expression": u}]}, arithmetic)[0]
        all_times = [t for t, *_ in events(every)] if every else [0, 0]
        apart = all(abs(a - b) > CLOSE for each in (times, all_times) for i, a in enumerate(each) for b in each[:i])
        if not apart or any(d in ("touch", "undecided") for _, d, _ in events(every)):
            return
        if "sensitivities" in base:
            self.beside_balls(system, asked("{u}", direction), plain["trajectory"], name)
        for form in rng.sample(FORMS[1:], 4):
            way = {"up": "down", "down": "up"}.get(direction, direction) if form in ODD else direction
            result, problem = self.ask(system, asked(form, way), arithmetic)
            if not self.tally.check(result is not None, f"{name}: {form}", json.dumps(problem)[:300]):
                continue
            got = events(result)
            same = len(got) == len(told) and (arithmetic != "auto" or result["trajectory"]["arithmetic"] == "double-double")
            for (t, d, error), (s, f, other) in zip(got, told):
                turned = {"up": "down", "down": "up"}.get(f, f) if form in ODD else f
                known = error is not None and other is not None
                same = same and d == turned and abs(t - s) <= (error + other if known else 0) + NEAR[arithmetic] * (1 + abs(s)) and known and error <= 1e-3
            self.tally.check(same, f"{name}: {form}", f"{got} {told} {json.dumps(system)} {json.dumps(asked(form, way))}")
            if action == "set" and same:
                both = zip(result["trajectory"]["rows"][-1], plain["trajectory"]["rows"][-1])
                self.tally.check(all(abs(a - b) <= 1e3 * NEAR[arithmetic] * (1 + abs(b)) for a, b in both), f"{name}: {form} goes on alike", f"{result['trajectory']['rows'][-1]} {plain['trajectory']['rows'][-1]}")
            if "sensitivities" in base and same:
                self.slopes(result["trajectory"]["sensitivities"], plain["trajectory"]["sensitivities"], f"{name}: {form}")
            ends = [r["trajectory"]["ended"] and r["trajectory"]["ended"]["reason"] for r in (result, plain)]
            self.tally.check(ends[0] == ends[1], f"{name}: {form} ends alike", str(ends))
            self.compared += 1
            self.jumped += "sign" in form or "if(" in form or "step" in form


def small_before_large(solver, tally):
    """A switch of no matter just before one that matters, in the same step: x' = 1 + sign(x - 1)/2, with another at 1 - d, is 1 + 3 a/2 at t = 2 + a."""
    for digits in range(1, 12):
        for weight, a in (("1e-13", 1 / 16), ("-1e-12", 1 / 8), ("0", 1 / 32), ("0", 2)):
            for rtol in (1e-6, 1e-9, 1e-12, 1e-20):
                d = f"1e-{digits}"
                small = f"{weight}*sign(x - 1 + {d})" if weight != "0" else "0"
                result, problem = solver.solve({"system": {"form": "equations", "variables": ["x", "v"], "equations": [f"x' = 1 + sign(x - 1)/2 + {small}", "v' = -v"]}, "want": ["trajectory"], "accuracy": {"rtol": rtol, "arithmetic": "double" if rtol > 1e-13 else "double-double"},
                                                "trajectory": {"stop": 2 + a, "samples": 2, "initial": {"x": 0, "v": 1}, "events": [{"name": "e", "expression": f"step(x - 1 + {d})*3 - 1", "direction": "up"}]}})
                t = result and result["trajectory"]
                tally.check(t and abs(t["rows"][-1][1] - 1 - 3 * a / 2) <= max(1e-11, 1e-1 * rtol) and t["error_estimate"] <= 100 * rtol and len(t["events"]) == 1, f"a switch of weight {weight} {d} before another, rtol {rtol}", json.dumps(t["rows"][-1] if t else problem))


def jump_beside_slope(solver, tally):
    """A function that jumps as it passes 0 and is a line on both sides: near enough to the place the two are told apart, however long steps are. x = cos t passes 0 at pi/2 + k pi."""
    for weight in (3, 30, 100, 300, 3000):
        for k in range(0, 30, 3):
            rtol, method = 10 ** (-6 - k / 5), ("taylor", "dop853", "radau", "tsit5")[k // 3 % 4]
            result, problem = solver.solve({"system": {"form": "equations", "variables": ["x", "v", "z"], "equations": ["x' = -v", "v' = x", "z = 5*x/2 + 9*v/8"]}, "want": ["trajectory"],
                                            "accuracy": {"rtol": rtol, "atol": rtol, "method": method, "arithmetic": "double"},
                                            "trajectory": {"stop": 9, "samples": 2, "initial": {"x": 1, "v": 0}, "events": [{"name": "e", "expression": f"{weight}*x + sign(x)", "direction": "any"}]}})
            events = result["trajectory"]["events"] if result else []
            off = [abs(e["t"] - (j + 0.5) * math.pi) for j, e in enumerate(events)]
            tally.check(len(off) == 3 and max(off) <= 1e3 * rtol and all(o <= e["error"] + 1e-14 and e["error"] <= 1e4 * rtol for o, e in zip(off, events)),
                        f"a jump beside a slope of {weight}, {method}, rtol {rtol:.1e}", f"{off} {[e['error'] for e in events] or problem}")


FACTORS = [("{g}", 1), ("10^(-40)*({g})", 1), ("-({g})*10^200", -1), ("({g})^3", 1), ("({g})^2", 0)]


def behind(solver, tally, rng):
    """What follows sin t with a lag of 1/k is (k^2 sin t - k cos t)/(k^2 + 1), and meets it again where tan t = -k, so that their difference is as small as 1/k all the way. Whatever
    the function is multiplied by, each passage is told once, at its time to the error that is said, where double sees the difference as what its tolerances leave too."""
    digits = rng.choice([2, 3, 5, 6, 8, 9, 11, 12])
    k, (form, sense), rtol = rng.randint(1, 9) * 10**digits, rng.choice(FACTORS), rng.choice([1e-15, 1e-18, 1e-22])
    method = rng.choice(["auto", "radau"] + ["taylor"] * (digits < 3))
    arithmetic = rng.choice(["auto", "double-double"])
    name = f"lag 1/{k}, {method}, {arithmetic}, {rtol}: {form}"
    result, problem = solver.solve({"system": {"form": "equations", "variables": ["y"], "equations": [f"y' = {k}*(sin(t) - y)"]}, "want": ["trajectory"],
                                    "accuracy": {"rtol": rtol, "atol": rtol, "method": method, "arithmetic": arithmetic},
                                    "trajectory": {"stop": 8, "samples": 3, "initial": {"y": f"-{k}/({k}^2 + 1)"}, "events": [{"name": "e", "expression": form.format(g="sin(t) - y")}]}})
    if not tally.check(result is not None, name, json.dumps(problem)[:300]):
        return []
    t = result["trajectory"]
    told, first = t["events"], mpmath.pi / 2 + mpmath.atan(mpmath.mpf(1) / k)
    senses = [{-1: "down", 0: "touch", 1: "up"}[(-1) ** (i + 1) * sense] for i in range(3)]
    late = [abs(mpmath.mpf(getattr(e["t"], "text", e["t"])) - first - i * mpmath.pi) for i, e in enumerate(told)]
    tally.check([e["direction"] for e in told] == senses and t["ended"] is None, name, json.dumps([told, t["ended"]])[:500])
    tally.check(all(e["error"] is not None and d <= 10 * e["error"] for e, d in zip(told, late)), f"{name}: errors", json.dumps([[e["error"], float(d)] for e, d in zip(told, late)]))
    # what a touch is known to: where the difference is no more than the tolerance
    most = 1e3 * rtol * k if sense else 1e3 * rtol * k**2
    tally.check(all(d <= min(most, 1e-3) for d in late), f"{name}: times", json.dumps([float(d) for d in late]))
    return [d <= e["error"] for e, d in zip(told, late)]


def in_balls(solver, tally, rng, n):
    """In balls what is told is that of double-double, up to where the motion ends, or is said to be undecided; functions that do not jump are all told."""
    system, initial, u, w = motion(rng)
    form = rng.choice(FORMS)
    base = {"start": 0, "stop": 3, "samples": 3, "initial": initial}
    name = f"balls {n}: {form} of {u}"

    def ask(expression, arithmetic):
        trajectory = {**base, "events": [{"name": "e", "expression": expression}]}
        return solver.solve({"system": system, "want": ["trajectory"], "trajectory": trajectory, "accuracy": {"rtol": 1e-20, "atol": 1e-20, "arithmetic": arithmetic}})
    fine, _ = ask(u, "double-double")
    ball, problem = ask(form.format(u=u, w=w), "ball")
    told = events(fine) if fine else []
    if not fine or any(d == "touch" for _, d, _ in told) or any(abs(a[0] - b[0]) < CLOSE for i, a in enumerate(told) for b in told[:i]):
        return 0
    if not tally.check(ball is not None, name, json.dumps(problem)[:300]):
        return 0
    end, got = ball["trajectory"]["ended"], events(ball)
    decided = sum(d != "undecided" for _, d, _ in got)
    same = len(got) == len(told) or (end and decided <= len(told) <= len(got)) or (end and len(got) < len(told))
    for (t, d, error), (s, f, other) in zip(got, told):
        turned = {"up": "down", "down": "up"}.get(f, f) if form in ODD else f
        same = same and d in (turned, "undecided") and abs(t - s) <= error + other + 1e-15 * (1 + abs(s))
    tally.check(same, name, f"{got} {told} {end} {json.dumps(system)} {json.dumps(initial)}")
    return not end


STOPS = ["v", "5*v", "v^3", "sign(v)", "sign(v) + 1/3", "if(v > 0, 1, -2)", "v*(1 + x^2)"]


def at_slides(solver, tally, rng, n):
    """A block with more friction than its force has, after it has moved: its velocity comes to 0 once, and is no event from then on, however it is written; where it is
    let go again, it is 0 once more at the next stop."""
    friction, spring, x, v = rng.randint(4, 9), rng.randint(1, 4), rng.choice([-1, 1]) * rng.randint(1, 3), rng.choice([-1, 1]) * rng.randint(1, 12)
    held = friction / 2 > spring * (abs(x) / 4 + (v / 4) ** 2) + 1 / 2       # where it can come to rest at all, it stays
    system = {"form": "equations", "variables": ["x", "v"], "equations": ["x' = v", f"v' = -{spring}*x + cos({rng.randint(1, 3)}*t)/2 - {friction}/2*sign(v)"]}
    trajectory = {"start": 0, "stop": 5, "samples": 3, "initial": {"x": f"{x}/4", "v": f"{v}/4"}, "sliding": True}
    for arithmetic in ("double", "double-double", "ball"):
        for form in rng.sample(STOPS, 3):
            result, problem = solver.solve({"system": system, "want": ["trajectory"], "trajectory": {**trajectory, "events": [{"name": "e", "expression": form}]},
                                            "accuracy": {"rtol": 1e-9 if arithmetic == "double" else 1e-18, "arithmetic": arithmetic}})
            name = f"block {n}, {arithmetic}: {form} {json.dumps(system['equations'])} {trajectory['initial']}"
            if not held or not tally.check(result is not None, name, json.dumps(problem)[:300]):
                continue
            t = result["trajectory"]
            undecided = arithmetic == "ball" and t["ended"] is not None and form == "v*(1 + x^2)"      # which of two comes first
            right = len(t["slides"]) == 1 and len(t["events"]) == 1 and abs(t["events"][0]["t"] - t["slides"][0]["from"]) < 1e-9 and t["events"][0]["direction"] == ("down" if v > 0 else "up")
            tally.check(undecided or right, name, json.dumps([t["events"], t["slides"], t["ended"]])[:600])


def main():
    tally, rng = Tally("event forms"), random.Random(seed(20261127))
    forms = Forms(Solver(build_folder()), tally)
    for n in range(scaled(150)):
        try:
            forms.check(rng, n)
        except Crash as e:
            tally.check(False, f"motion {n}", str(e))
    through = sum(in_balls(forms.solver, tally, rng, n) for n in range(scaled(80)))
    mpmath.mp.dps = 60
    held = [one for _ in range(scaled(60)) for one in behind(forms.solver, tally, rng)]
    tally.check(sum(held) >= 0.97 * len(held) - 2, "errors of times hold", f"{sum(held)} of {len(held)}")
    for n in range(scaled(25)):
        at_slides(forms.solver, tally, rng, n)
    small_before_large(forms.solver, tally)
    jump_beside_slope(forms.solver, tally)
    if scale() >= 1:
        tally.check(through >= scaled(25), "motions in balls come to their ends", through)
        tally.check(forms.compared >= scaled(150), "most motions have zeros that lie apart", forms.compared)
        tally.check(forms.proved >= scaled(8), "motions with derivatives beside balls", forms.proved)
        tally.check(forms.differentiated >= scaled(10), "derivatives among them", forms.differentiated)
        tally.check(forms.jumped >= scaled(60), "functions that jump among them", forms.jumped)
    return tally.end()


if __name__ == "__main__":
    sys.exit(main())
