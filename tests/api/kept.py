"""Rows that are kept where `limits.seconds` ends: in each arithmetic, with events, of sets, and beside a tradeoff; their errors hold against closed forms.

No computer comes to the end of what is asked: each request takes ten times and more what is granted on a fast one, and fewer steps than end a
motion for their number, or for a stop that is out of reach. A slow one has its first rows early."""
import itertools
import json

import mpmath
import schemas
from daemon import Daemon

COUNTER = itertools.count(1)
TERMS = " + ".join(f"sin(x + {k})" for k in range(60))      # costs, and moves nothing
NESTED = "sin(" * 60 + "x" + ")" * 60                     # costs the same, for a third of the operations
FINE = {"rtol": 1e-20, "atol": 1e-20}


def spring(seconds=4, stop=80000, samples=80001, terms=TERMS, **members):
    """x = cos(omega t), x' of it beside."""
    k = 1000 + next(COUNTER)
    request = {"system": {"form": "equations", "variables": ["x"], "parameters": {"k": k}, "equations": [f"x'' = -k*x + ({terms})*1e-60"]}, "want": ["trajectory"],
               "trajectory": {"stop": stop, "samples": samples, "initial": {"x": 1, "x'": 0}}, "limits": {"seconds": seconds}, **members}
    return request, mpmath.sqrt(k)


def ask(d, c, request, label):
    """The answer, numbers with all digits; {} where there is none."""
    a = d.ask("POST", "/v1/solve", request, {"Prefer": "wait=60"}, seconds=90)
    job = json.loads(a.body, parse_float=mpmath.mpf)
    c(job.get("status") == "done" and not schemas.faults(c.result_schema, a.json().get("result")), f"{label}: is done", job.get("error") or schemas.faults(c.result_schema, a.json().get("result")))
    return job.get("result", {})


def cut(c, t, label, stop=80000, samples=80001):
    """It ended for want of time, past its start and before its stop."""
    end, rows = t["ended"] or {}, t["rows"]
    return c(end.get("reason") == "time_limit" and "seconds" in end["detail"].replace(" s passed", " seconds") and 1 < len(rows) < samples and 0 < rows[-1][0] <= end["t"] < stop,
             f"{label}: it says that the time ended", (end, rows[-1:]))


def errors_hold(c, t, true, label):
    """Each row has an error, within which the first column's true value lies: in 98 of 100 rows, as everywhere, and in the others within three times it."""
    rows = [(r, e, abs(r[1] - true(r[0]))) for r, e in zip(t["rows"], t["errors"])]
    wrong = [(r, e, off) for r, e, off in rows if e is None or not off <= e]
    far = [(r, e, off) for r, e, off in wrong if e is None or not off <= 3 * e]
    c(not far and len(wrong) <= len(rows) / 50 and len(t["errors"]) == len(t["rows"]) and t["error_estimate"] is not None, f"{label}: errors hold", (len(wrong), len(rows), wrong[:2]))


def kept_digits(build, c):
    """Double-double, with events too, balls, and what `auto` takes for fine tolerances."""
    mpmath.mp.dps = 40
    with Daemon(build, "--workers", "1") as d:
        for label, accuracy, asked in (("double-double", {"arithmetic": "double-double", **FINE}, {"stop": 8000}), ("ball", {"arithmetic": "ball", **FINE}, {"stop": 8000}),
                                       ("auto", FINE, {"stop": 300, "samples": 3001, "terms": NESTED, "seconds": 2})):
            request, omega = spring(accuracy=accuracy, **asked)
            t = ask(d, c, request, label).get("trajectory")
            if t and cut(c, t, label, asked["stop"], asked.get("samples", 80001)):
                errors_hold(c, t, lambda at, omega=omega: mpmath.cos(omega * at), label)
                c(t["arithmetic"] == ("double-double" if label == "auto" else label), f"{label}: arithmetic", t["arithmetic"])
        request, omega = spring(accuracy={"arithmetic": "double-double", **FINE}, stop=8000)
        request["trajectory"]["events"] = [{"name": "zero", "expression": "x"}]
        t = ask(d, c, request, "double-double, events").get("trajectory")
        if t and cut(c, t, "double-double, events", 8000):
            errors_hold(c, t, lambda at: mpmath.cos(omega * at), "double-double, events")
            count, should = len(t["events"]), int(mpmath.floor(omega * t["ended"]["t"] / mpmath.pi + 0.5))
            c(count == should and t["arithmetic"] == "double-double", "double-double: every event up to the end", (count, should))
            c(all(abs(e["t"] - (i + mpmath.mpf(1) / 2) * mpmath.pi / omega) <= e["error"] for i, e in enumerate(t["events"])), "double-double: events' errors hold")


def kept_pieces(build, c):
    """Events that set: a kick that changes nothing; modes: up at 1, down at 2; slides: a switch that is run through."""
    mpmath.mp.dps = 30
    with Daemon(build, "--workers", "1") as d:
        request, omega = spring()
        request["trajectory"]["events"] = [{"name": "kick", "expression": "x", "direction": "up", "action": "set", "set": {"x'": "x'"}}]
        t = ask(d, c, request, "set").get("trajectory")
        if t and cut(c, t, "set"):
            errors_hold(c, t, lambda at: mpmath.cos(omega * at), "set")
            last, should = t["rows"][-1][0], int(mpmath.floor((omega * t["rows"][-1][0] / mpmath.pi + 0.5) / 2))
            c(len(t["events"]) == should and all(e["t"] <= last for e in t["events"]), "set: every event up to the end, none beyond", (len(t["events"]), should))
        request = {"system": {"form": "equations", "variables": ["x"], "modes": {"m": {"values": [1, 2], "start": 1}}, "equations": [f"x' = if(m == 1, 1, -2) + ({TERMS})*1e-60"]}, "want": ["trajectory"],
                   "trajectory": {"stop": 79999.5, "samples": 160000, "initial": {"x": 0}, "events": [{"name": "top", "expression": "x - 1", "direction": "up", "action": "set", "set": {"m": "2"}},
                                                                                         {"name": "ground", "expression": "x", "direction": "down", "action": "set", "set": {"m": "1"}}]},
                   "limits": {"seconds": 4}}
        t = ask(d, c, request, "modes").get("trajectory")
        if t and cut(c, t, "modes"):
            errors_hold(c, t, lambda at: at % mpmath.mpf(1.5) if at % mpmath.mpf(1.5) <= 1 else 2 * (mpmath.mpf(1.5) - at % mpmath.mpf(1.5)), "modes")
            last = t["rows"][-1][0]
            c(all(p["t"] <= last for p in t["pieces"]) and len(t["pieces"]) == len(t["events"]) + 1, "modes: pieces up to the end, none beyond", (len(t["pieces"]), len(t["events"])))
        request = {"system": {"form": "equations", "variables": ["x", "v"], "equations": ["x' = v", f"v' = -sign(v) + 50*cos(5*t) + ({TERMS.replace('x', 'v')})*1e-60"]}, "want": ["trajectory"],
                   "trajectory": {"stop": 80000, "samples": 80001, "initial": {"x": 0, "v": 0}, "outputs": ["v"], "sliding": True}, "limits": {"seconds": 4}}
        t = ask(d, c, request, "sliding").get("trajectory")
        if t and cut(c, t, "sliding"):
            errors_hold(c, t, friction(), "sliding")


def kept_beside(build, c):
    """Sensitivities that there is no time for: the motion is kept, and it is said."""
    mpmath.mp.dps = 30
    with Daemon(build, "--workers", "1") as d:
        request, omega = spring()
        request["trajectory"]["sensitivities"] = {"parameters": ["k"]}
        # at rest, which is one step; what p moves swings a million times
        rest = {"system": {"form": "equations", "variables": ["x"], "parameters": {"p": 0}, "equations": [f"x'' = p - 10^4*x + x^2*({TERMS})"]}, "want": ["trajectory"],
                "trajectory": {"stop": 10000, "samples": 401, "initial": {"x": 0, "x'": 0}, "sensitivities": {"parameters": ["p"]}}, "limits": {"seconds": 2}}
        for label, asked, true in (("the motion cut", request, lambda at: mpmath.cos(omega * at)), ("the motion whole", rest, lambda at: 0)):
            result = ask(d, c, asked, f"sensitivities, {label}")
            t = result.get("trajectory")
            if t and (asked is rest or cut(c, t, f"sensitivities, {label}")):
                c(asked is not rest or (t["ended"] is None and len(t["rows"]) == 401), f"sensitivities, {label}: it comes to its end", t["ended"])
                errors_hold(c, t, true, f"sensitivities, {label}")
                said = [w for w in result["warnings"] if w["code"] == "work_cut" and w["pointer"] == "/trajectory/sensitivities"]
                c("sensitivities" not in t and len(said) == 1 and f"{asked['limits']['seconds']} seconds" in said[0]["detail"], f"sensitivities, {label}: left out, and said",
                  (list(t.get("sensitivities", {})), result["warnings"]))


def friction():
    """v' = -sign(v) + 50 cos 5t from 0, piece by piece: v = 10 sin 5t - s t + c between zeros of v."""
    pieces = [(mpmath.mpf(0), 1, mpmath.mpf(0))]      # from, sign, c

    def v(at):
        while True:
            begin, s, add = pieces[-1]
            if at < begin + mpmath.mpf(1) / 2:
                break
            f = lambda t: 10 * mpmath.sin(5 * t) - s * t + add
            zero = mpmath.findroot(f, (begin + mpmath.mpf("0.5"), begin + mpmath.mpf("0.75")), solver="anderson")
            if at <= zero:
                break
            pieces.append((zero, -s, -10 * mpmath.sin(5 * zero) - s * zero))
        begin, s, add = next(p for p in reversed(pieces) if p[0] <= at)
        return 10 * mpmath.sin(5 * at) - s * at + add
    return v


def kept_sets(build, c):
    """A sweep: a set that is whole, one that is cut, one that was not begun; and no answer where nothing was found. A motion beside a tradeoff."""
    mpmath.mp.dps = 30
    with Daemon(build, "--workers", "1") as d:
        request, omega = spring()
        k = request["system"]["parameters"]["k"]
        request["sweep"] = [{"parameters": {"k": k * i}} for i in (0, 1, *range(3, 12))]
        request["trajectory"]["samples"] = 8001
        sets = ask(d, c, request, "sweep").get("trajectories")
        if sets and c(len(sets) == 11, "sweep: each set says something", sets):
            c(sets[0]["ended"] is None and len(sets[0]["rows"]) == 8001, "sweep: the first is whole", sets[0]["ended"])
            if cut(c, sets[1], "sweep"):
                errors_hold(c, sets[1], lambda at: mpmath.cos(omega * at), "sweep")
            late = [s.get("error", {}).get("code") or s["ended"]["reason"] for s in sets[2:]]
            c(set(late) == {"time_limit"} and "begun" in sets[-1].get("error", {}).get("detail", ""), "sweep: of the others too, the last was not begun", late)
        request, omega = spring(seconds=0.3)
        request["trajectory"]["samples"] = 2
        request["sweep"] = [{"initial": {"x": 1}}, {"initial": {"x": 2}}]
        error = d.ask("POST", "/v1/solve", request, {"Prefer": "wait=60"}).json().get("error", {})
        c(error.get("code") == "time_limit" and "0.3 seconds" in error["detail"], "sweep: nothing found is no answer", error)
        request, omega = spring(want=["trajectory", "tradeoff"])
        result = ask(d, c, request, "tradeoff")
        t = result.get("trajectory")
        if t and cut(c, t, "tradeoff"):
            errors_hold(c, t, lambda at: mpmath.cos(omega * at), "tradeoff")
            said = [w for w in result["warnings"] if w["code"] == "work_cut" and w["pointer"] == "/want"]
            c("tradeoff" not in result and len(said) == 1 and "without the tradeoff" in said[0]["detail"], "tradeoff: left out, and said", result["warnings"])


ALL = [kept_digits, kept_pieces, kept_beside, kept_sets]
