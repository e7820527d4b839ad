"""What is asked at the sets of a sweep is what requests of their own have: sets_check.py BUILD_DIR

Cases of tests/cases with linearizations, transfer matrices, equilibria, fits or sensitivities are asked as sweeps over values of one of their parameters, or over starts, and each set as a
request without a sweep: members are the same, but for times of work. Beside them poles and stability of a loop as its gain grows (closed forms), a set at which the rank drops, sets that
cannot be, and time that ends among them. SGA_TEST_SCALE."""
import copy
import json
import os
import random
import sys

import mpmath as mp

from cases import load
from solver import Solver
from tally import ROOT, Tally, build_folder, scaled, seed

MEMBERS = ("linearization", "transfer", "equilibria", "fit")
MOST_SECONDS = 20


def plain(value):
    """Numbers as they are printed, seconds left out."""
    if isinstance(value, dict):
        return {k: plain(v) for k, v in value.items() if k not in ("seconds", "work")}
    if isinstance(value, list):
        return [plain(v) for v in value]
    return getattr(value, "text", value)


def alone(request, one):
    """The set as a request of its own."""
    r = copy.deepcopy(request)
    del r["sweep"]
    if one.get("parameters"):
        r["system"].setdefault("parameters", {}).update(one["parameters"])
    if one.get("initial"):
        r.setdefault("trajectory", {}).setdefault("initial", {}).update(one["initial"])
    return r


def same(tally, solver, label, request, solved=None):
    """Each set is its own request's."""
    answer, wrong = solver.solve(request)
    if not tally.check(answer and len(answer.get("sets", [])) == len(request["sweep"]), f"{label}: has its sets", wrong):
        return
    for k, (got, one) in enumerate(zip(answer["sets"], request["sweep"])):
        own, refused = solver.solve(alone(request, one))
        if not own:
            tally.check(got.get("error", {}).get("code") == refused["code"], f"{label}, set {k}: fails as its own request does", (got, refused))
            continue
        should = {m: own[m] for m in MEMBERS if m in own}
        if own.get("trajectory", {}).get("sensitivities"):
            should["sensitivities"] = own["trajectory"]["sensitivities"]
        have = {m: got[m] for m in (*MEMBERS, "sensitivities") if m in got}
        tally.check(should and plain(have) == plain(should), f"{label}, set {k}: what its own request has", (json.dumps(plain(have))[:600], json.dumps(plain(should))[:600], got.get("error")))
        if solved is not None:
            solved.append(label)


def candidates():
    for path in sorted(os.listdir(os.path.join(ROOT, "tests", "cases"))):
        for case in load(path[:-5]) if path.endswith(".json") else []:
            r = case.get("request", {})
            wants = set(r.get("want", [])) | {m for m in MEMBERS if m in r and "want" not in r}
            sensitive = "sensitivities" in r.get("trajectory", {})
            if "sweep" not in r and "error" not in case.get("expect", {}) and (wants & set(MEMBERS) or sensitive):
                yield case["name"], r


def of_cases(tally, solver, rng):
    found, solved = list(candidates()), []
    rng.shuffle(found)
    for name, r in found[:max(30, scaled(60))]:
        r = copy.deepcopy(r)
        numbers = [k for k, v in r["system"].get("parameters", {}).items() if isinstance(v, (int, float)) and not isinstance(v, bool)]
        fitted = set((r.get("fit") or {}).get("parameters", {})) | set(r.get("trajectory", {}).get("sensitivities", {}).get("parameters", []))
        numbers = [k for k in numbers if k not in fitted]
        if r["system"].get("form") == "operator":
            continue
        if numbers:
            name_ = rng.choice(numbers)
            v = r["system"]["parameters"][name_]
            r["sweep"] = [{"parameters": {name_: v}}, {"parameters": {name_: round(v * 1.25, 6) if v else 0.5}}]
        elif r.get("trajectory", {}).get("initial"):
            r["sweep"] = [{"initial": {}}, {"initial": dict(r["trajectory"]["initial"])}]
        else:
            continue
        if "want" in r:
            r["want"] = [w for w in r["want"] if w not in ("consistent_initial", "tradeoff", "derivation", "dirac", "symmetries", "structure")]
        r.setdefault("limits", {})["seconds"] = MOST_SECONDS
        answer, wrong = solver.solve({**alone(r, r["sweep"][0])})
        if answer:
            same(tally, solver, name, r, solved)
    tally.check(len(solved) >= 3, "sets of cases were compared", len(solved))


def loop(tally, solver):
    """s (s + 1) (s + 2) + k: stable for 0 < k < 6."""
    gains = [1, 3, "11/2", 6, 7, 0, -1]
    request = {"system": {"form": "equations", "variables": ["x", "u"], "parameters": {"k": None}, "equations": ["x''' + 3*x'' + 2*x' + k*x = u"]},
               "want": ["linearization", "transfer"], "linearization": {"inputs": ["u"], "outputs": ["x"]}, "transfer": {"inputs": ["u"], "outputs": ["x"]},
               "sweep": [{"parameters": {"k": k}} for k in gains]}
    answer, wrong = solver.solve(request)
    if not tally.check(answer and len(answer["sets"]) == len(gains), "a loop: has its sets", wrong):
        return
    for k, got in zip(gains, answer["sets"]):
        value = mp.mpf(11) / 2 if isinstance(k, str) else mp.mpf(k)
        poles = sorted(mp.polyroots([1, 3, 2, value], maxsteps=200, extraprec=200), key=lambda z: (mp.re(z), mp.im(z)))
        one = got["linearization"][0]
        have = sorted((mp.mpc(float(e[0]), float(e[1])) for e in one["eigenvalues"] for _ in range(e[2])), key=lambda z: (mp.re(z), mp.im(z)))
        tally.check(all(abs(a - b) < 1e-9 for a, b in zip(poles, have)) and len(have) == 3, f"a loop at k = {k}: poles", (poles, have))
        tally.check(one["stability"] == ("asymptotic" if 0 < value < 6 else "marginal" if value in (0, 6) else "unstable"), f"a loop at k = {k}: stable", one["stable"])
        tally.check("transfer" in got and "trajectories" not in answer, f"a loop at k = {k}: transfer, no trajectory", list(got))


def special(tally, solver):
    """Values at which the final set is another one, or nothing can be linearized: each set by itself."""
    request = {"system": {"form": "equations", "variables": ["x", "y"], "parameters": {"p": 1}, "equations": ["p*x' = y - x", "y' = -y"]}, "want": ["linearization", "equilibria"],
               "trajectory": {"initial": {"x": 0.5}}, "sweep": [{"parameters": {"p": p}} for p in (1, 0, 2)]}
    answer, wrong = solver.solve(request)
    if tally.check(answer and [len(s["linearization"][0]["state"]["names"]) for s in answer["sets"]] == [2, 1, 2], "a rank that drops at p = 0: states", wrong or answer.get("sets")):
        same(tally, solver, "a rank that drops at p = 0", request)
    request["system"]["equations"][1] = "y' = -y/p"
    answer, wrong = solver.solve(request)
    tally.check(answer and [("error" in s) for s in answer["sets"]] == [False, True, False], "a set at which nothing has a value has its error", wrong or answer.get("sets"))
    same(tally, solver, "a set at which nothing has a value", request)


def beside(tally, solver):
    """With trajectories beside, in one analysis; their rows are those without."""
    request = {"system": {"form": "lagrangian", "coordinates": ["q"], "parameters": {"k": 2, "c": 0.3}, "lagrangian": "c*q'^2/2 - k*(1 - cos(q))"}, "want": ["trajectory", "equilibria"],
               "trajectory": {"stop": 2, "samples": 3, "initial": {"q": 0.5}, "sensitivities": {"parameters": ["c"]}}, "equilibria": {"bounds": {"q": [-1, 4]}},
               "sweep": [{"parameters": {"k": 1}}, {"parameters": {"k": 3}, "initial": {"q": 0.1}}]}
    answer, wrong = solver.solve(request)
    if not tally.check(answer and len(answer["trajectories"]) == 2 and all("rows" in t and "sensitivities" not in t for t in answer["trajectories"]), "trajectories beside sets", wrong):
        return
    same(tally, solver, "beside trajectories", request)


def time_ends(tally, solver):
    """Among trajectories, or among sets: what is there is kept, and what is not says so."""
    for terms, stop, sets, seconds in ((60, 200, 3000, 4), (200, 3000, 3, 3)):
        request = {"system": {"form": "equations", "variables": ["x"], "parameters": {"k": 1},
                              "equations": ["x'' = -k*x + (" + " + ".join(f"sin(x + {k})" for k in range(terms)) + ")*1e-9"]}, "want": ["trajectory"],
                   "trajectory": {"stop": stop, "samples": 3, "initial": {"x": 1}, "sensitivities": {"parameters": ["k"]}}, "accuracy": {"rtol": 1e-11},
                   "limits": {"seconds": seconds}, "sweep": [{"parameters": {"k": 1 + i / 7}} for i in range(sets)]}
        answer, wrong = solver.solve(request)
        if wrong:            # a slow machine has not even one
            tally.check("time_limit" in str(wrong), f"{sets} sets, time ends: no other reason", wrong)
            continue
        left_out = any(w["code"] == "work_cut" and w["pointer"] == "/want" for w in answer["warnings"])
        tally.check(len(answer["trajectories"]) == sets and left_out is ("sets" not in answer), f"{sets} sets, time ends: trajectories are kept, sets are there or it is said", answer["warnings"])
        told = [s for s in answer.get("sets", []) if "sensitivities" in s or s.get("error", {}).get("code") == "time_limit"]
        tally.check(len(told) == len(answer.get("sets", [])), f"{sets} sets, time ends: each has what is asked, or says why not", answer.get("sets", [])[-1:])


def main():
    tally, solver = Tally("sets"), Solver(build_folder())
    loop(tally, solver)
    special(tally, solver)
    beside(tally, solver)
    time_ends(tally, solver)
    of_cases(tally, solver, random.Random(seed(20261126)))
    return tally.end()


if __name__ == "__main__":
    sys.exit(main())
