"""One case: a request, what is expected of the answer, and the identities that hold anyway."""
import json
import os
import re
from decimal import Decimal

import mpmath

import schemas
from combination import Combinations
from consistent_check import ConsistentCheck
from expression import EXACT, FLOAT, Graph, Undefined, evaluate
from identities import Answer, Broken
from limits_told import told_too_early
from mode_check import ModeCheck, at_start
from structure_check import StructureCheck
from symmetry_case import SymmetryCase
from table import tables_of

KNOWN = set("verdict ambient generations final index differentiation seed gauge equilibrium variables on off field "
            "parameters near digits error trajectory trajectories strata solved unsolved assumed initial points identities structure primary closed "
            "redundant sides tradeoff consistent symmetries kronecker operator regular regularity motion kinds zeros warnings texts "
            "linearization linear_motion along transfer equilibria dirac".split())


IDENTITIES = os.environ.get("SGA_TEST_IDENTITIES", "1") != "0"


# Where a case comes from: a reference with its year, or "own: why it is there"
SOURCE = re.compile(r"own: .{5}|.{8,}\b(1[89]|20)\d\d\b")


# What is not algebraic: functions other than roots, exponents that are not numbers
TRANSCENDENTAL = re.compile(r"\b(a?(sin|cos|tan)h?|atan2|exp|log|abs|sign|min|max|pi|if|step)\b|\^\s*-?[A-Za-z_]|\^\s*\([^)]*[A-Za-z_]|table")


# Whose points modulo primes take more guesses than are made: closed chains in space, given by all distances at once
TOO_COUPLED = ("published: Bricard's orthogonal linkage",)


def number(x):
    return float(evaluate(x if isinstance(x, str) else repr(x)))


def result_constraints(answer):
    return answer.result.get("constraints", [])


class CaseCheck:
    def __init__(self, tally, solver):
        self.tally, self.solver = tally, solver
        self.result_schema, self.problem_schema = schemas.validator("result"), schemas.validator("problem")
        self.request_schema = schemas.validator("request")

    def run(self, case):
        expect = case["expect"]
        name = case["name"]
        unknown = set(expect) - KNOWN
        if unknown or not SOURCE.match(case.get("source", "")):
            self.tally.check(False, name, "the case itself: " + str(
                unknown or "source must be a reference with its year, or start with 'own: ' and say why the case is there"))
            return
        request = case["body"] if "body" in case else case["request"]
        try:
            result, problem = self.solver.solve(request)
        except Exception as e:    # a crash of the program under test is one failed case
            self.tally.check(False, name, str(e))
            return
        try:
            if "error" in expect:
                self.refusal(name, expect["error"], result, problem)
            elif problem is not None:
                self.tally.check(False, name, f"refused: {json.dumps(problem)}")
            else:
                self.answer(name, case, expect, result)
        except Broken as e:
            self.tally.check(False, name, str(e))
        except Exception as e:
            self.tally.check(False, name, f"checker: {type(e).__name__}: {e}")

    def same(self, name, what, is_, should):
        self.tally.check(is_ == should, f"{name}: {what}", f"is {is_!r}, should be {should!r}")

    def refusal(self, name, expect, result, problem):
        if problem is None:
            self.tally.check(False, name, f"accepted, verdict {result.get('verdict')}, should be {expect}")
            return
        if "type" in problem:    # the object itself, not the line for reading
            fault = schemas.faults(self.problem_schema, problem)
            self.tally.check(not fault, f"{name}: problem schema", fault)
        for part in expect.get("says", []):      # a refusal has no warnings: limits that were met are part of its text
            self.tally.check(part in problem.get("detail", ""), f"{name}: the refusal says {part}", str(problem.get("detail")))
        for member, should in expect.items():
            if member == "says":
                continue
            allowed = should if isinstance(should, list) else [should]
            self.tally.check(problem.get(member) in allowed, f"{name}: {member}",
                             f"is {problem.get(member)!r}, should be {should!r} ({problem.get('detail')})")

    def answer(self, name, case, expect, result):
        request = case["request"]
        fault = schemas.faults(self.request_schema, request)
        self.tally.check(not fault, f"{name}: request schema", fault)
        fault = schemas.faults(self.result_schema, result)
        self.tally.check(not fault, f"{name}: result schema", fault)
        self.plain(name, expect, result)
        early = told_too_early(result)
        self.tally.check(not early, f"{name}: limits of larger systems", str(early))
        self.modular(name, request, result)
        ModeCheck(self.tally, name, self.solver, request, result).run(expect.get("trajectory", {}))
        request = at_start(request)
        answer = Answer(request, result, digits=expect.get("digits", 50), near=expect.get("near"),
                        parameters=expect.get("parameters"), points=expect.get("points", 2), primary=expect.get("primary"))
        if expect.get("identities", True) and IDENTITIES:
            try:
                answer.check()
                self.tally.check(True, name)
                done, wrong = Combinations(answer).check()
                if done:
                    self.tally.check(not wrong, f"{name}: combinations", "; ".join(wrong))
            except Broken as e:
                self.tally.check(False, f"{name}: identities", str(e))
        self.at_points(name, expect, answer)
        if "texts" in expect and result["verdict"] in ("unique", "isolated"):
            self.sent_back(name, request, result)
        for s in result.get("strata", []):
            if "point" in s:
                self.singular(name, request, answer, s)
        self.strata(name, expect, request, result, [])
        if "symmetries" in result:
            SymmetryCase(self.tally, name, request, result, answer).run(expect.get("symmetries", {}))
        if "predicted" in result.get("structure", {}):
            StructureCheck(self.tally, name, self.solver, request, result, answer).run(expect.get("structure", {}))
        if "consistent_initial" in result:
            ConsistentCheck(self.tally, name, request, result, answer).run(expect.get("consistent", {}))
        if "trajectories" in expect:
            self.sweep(name, case["request"], result, expect["trajectories"])
        if "trajectory" in expect:
            TrajectoryCheck(self.tally, name, request, result, answer).run(expect["trajectory"], "modes" in result)

    def strata(self, name, expect, request, result, where):
        """Each solved stratum is checked as an answer of its own, whether or not a case expects
        something of it, and so are its strata."""
        solved = []
        for s in result.get("strata", []):
            if request.get("strata") == "solve" and "constraints" in result and s["kind"] not in ("instant", "domain", "excess"):
                self.tally.check(any(k in s for k in ("result", "same_as", "problem")), f"{name}: {s['where']} is solved, or a problem is said")
            if s["kind"] == "branch" and "point" in s:
                self.satisfies(name, request, {**s["point"], request["system"].get("time", "t"): s["time"]})
            if "result" not in s:
                continue
            here = name + ": where " + ", ".join(s["where"])
            inner, added = s["result"], where if "substituted" in s else where + s["where"]
            own = self.substituted(request, s.get("substituted", {}))
            values = {k: v for k, v in expect.get("parameters", {}).items() if k not in s.get("substituted", {})}
            try:
                answer = Answer(own, inner, digits=expect.get("digits", 50), parameters=values, points=2, where=added,
                                near=None if s["where"] else s.get("point"))
                answer.check()
                self.tally.check(True, here)
            except Broken as e:
                self.tally.check(False, f"{here}: identities", str(e))
                continue
            solved.append((s, inner, answer, own, added, here))
        for want in expect.get("solved", []):
            hits = [x for x in solved if self.is_meant(want, x[0], x[2], expect)]
            self.tally.check(len(hits) == 1, f"{name}: {want} is one solved stratum", f"{len(hits)}")
            for s, inner, answer, *_, here in hits:
                self.plain(here, want, inner)
                self.at_points(here, want, answer)
        for want in expect.get("unsolved", []):
            self.tally.check(any(s.get("problem", {}).get("code") == want for s in result["strata"]), f"{name}: {want} is said")
        for s, inner, answer, own, added, here in solved:
            deeper = next((w for w in expect.get("solved", []) if self.is_meant(w, s, answer, expect)), {})
            self.strata(here, deeper, own, inner, added)

    def satisfies(self, name, request, env):
        """A place where the answer is said to be another one satisfies the equations without derivatives, as they were given."""
        g = Graph()
        for n, v in (request["system"].get("parameters") or {}).items():
            if v is not None:
                g.define(n, v)
        for text in request["system"].get("equations", []):
            if "'" in text or "der(" in text or text.count("=") != 1:
                continue
            left, right = (g.parse(part) for part in text.split("="))
            values = g.values(g.cone([left, right]), env, FLOAT)
            off = abs(values[left] - values[right])
            self.tally.check(off <= 1e-9 * (1 + abs(values[left])), f"{name}: the point of a branch satisfies {text}", f"off by {off:.3g}")

    def is_meant(self, want, stratum, answer, expect):
        if "part" in want:
            return not stratum["where"]
        if "put" in want:
            return {n: v.replace(" ", "") for n, v in stratum.get("substituted", {}).items()} == want["put"]
        if "parameter" in want:
            return want["parameter"] in stratum.get("substituted", {})
        if "substituted" in stratum:
            return False
        with mpmath.workdps(60):
            env = answer.point({**expect.get("parameters", {}), **want["at"]})
            return stratum["where"] and all(abs(self.value(answer, e, env)) < mpmath.mpf(10) ** -25 for e in stratum["where"])

    @staticmethod
    def substituted(request, values):
        if not values:
            return request
        system = dict(request["system"])
        kept = {k: v for k, v in system["parameters"].items() if k not in values}
        system["parameters"] = {**values, **kept}    # an earlier value may use this parameter
        return {**request, "system": system}

    def texts(self, name, expect, result):
        """How the answer is written, letter by letter."""
        if "constraints" in expect:
            self.same(name, "texts of the constraints", [c["expression"] for c in result["constraints"]], expect["constraints"])
        components = result.get("vector_field", {}).get("components", {})
        for key, text in expect.get("field", {}).items():
            self.same(name, f"text of the component of {key}", components.get(key), text)
        if "gauge" in expect:
            self.same(name, "texts of the gauge fields", result["gauge"]["fields"], expect["gauge"])
        if "pivots" in expect:
            self.same(name, "texts of the pivots", [p["assumed_not_zero"] for p in result["evidence"]["pivots"]], expect["pivots"])

    def sent_back(self, name, request, result):
        """The printed field on the printed constraints, with the same parameters, is a system of the same dimension."""
        plain = {v["name"]: v["name"].replace("'", "_prime") for v in result["variables"]}

        def renamed(text):
            return re.sub(r"[A-Za-z_][A-Za-z_0-9]*'*", lambda m: plain.get(m[0], m[0]), text)
        field, n = result["vector_field"]["components"], len(plain)
        back = {"system": {**{k: request["system"][k] for k in ("parameters", "time") if k in request["system"]}, "form": "quasilinear",
                           "variables": list(plain.values()), "A": [[int(i == j) for j in range(n)] for i in range(n)],
                           "alpha": [renamed(field[v]) for v in plain]}, "want": ["index", "constraints"]}
        if result["constraints"]:
            back["system"]["restrict"] = [renamed(c["expression"]) for c in result["constraints"]]
        again, problem = self.solver.solve(back)
        self.tally.check(again and again["verdict"] in ("unique", "isolated") and again["dimensions"]["final"] == result["dimensions"]["final"],
                         f"{name}: the answer sent back as a request", problem or again)

    def plain(self, name, expect, result):
        dims, index = result.get("dimensions", {}), result.get("index", {})
        where = {"verdict": result.get("verdict"), "ambient": dims.get("ambient"), "generations": dims.get("generations"),
                 "final": dims.get("final"), "index": index.get("generations"), "seed": index.get("seed"),
                 "differentiation": index.get("differentiation"), "gauge": result.get("gauge", {}).get("dimension"),
                 "equilibrium": result.get("equilibrium")}
        for key, value in where.items():
            if key in expect:
                self.same(name, key, value, expect[key])
        if "regular" in expect:
            self.same(name, "regular", result.get("regular"), expect["regular"])
        for key, value in expect.get("regularity", {}).items():
            self.same(name, "regularity " + key, result.get("regularity", {}).get(key), value)
        for key, value in expect.get("kronecker", {}).items():
            self.same(name, "kronecker " + key, result.get("structure", {}).get("kronecker", {}).get(key), value)
        if "operator" in expect:
            self.operator(name, expect["operator"], result)
        evidence = result.get("evidence", {})
        if "closed" in expect:
            self.same(name, "closed", evidence.get("two_form", {}).get("closed", "absent"), expect["closed"])
        if "sides" in expect:
            got = [[s["function"], s["sign"], s["beyond"]] for s in evidence.get("sides", [])]
            self.same(name, "sides", sorted(got), sorted(expect["sides"]))
        if "redundant" in expect:
            self.same(name, "redundant restrictions", evidence.get("redundant_restrictions"), expect["redundant"])
        if "texts" in expect:
            self.texts(name, expect["texts"], result)
        if "kinds" in expect:
            self.same(name, "kinds of strata", sorted(s["kind"] for s in result.get("strata", [])), sorted(expect["kinds"]))
        if "warnings" in expect:
            self.warnings(name, expect["warnings"], result["warnings"])
        if "zeros" in expect:
            self.same(name, "zeros of determinants", [d["zeros"] for d in evidence.get("determinants", [])], expect["zeros"])
        if "variables" in expect:
            self.same(name, "variables", sorted(v["name"] for v in result.get("variables", [])), sorted(expect["variables"]))
        if "initial" in expect:
            got = result.get("consistent_initial") or result["trajectory"]["initial"]
            self.close(name, "projected", got["projected"], expect["initial"], 1e-8)

    def modular(self, name, request, result):
        """Where nothing but rational operations and roots takes part, every zero is one modulo primes too; unless the constraints have further
        components, on which points modulo primes lie as well as on the one that is meant."""
        if any(s["kind"] == "excess" for s in result.get("strata", [])):
            return
        decisions = result.get("evidence", {}).get("decisions")
        if name in TOO_COUPLED:
            return
        if decisions and isinstance(request, dict) and not TRANSCENDENTAL.search(json.dumps(request["system"])):
            self.tally.check(decisions["zero_numeric"] == 0, f"{name}: an algebraic system has modular evidence", str(decisions))

    def warnings(self, name, expect, got):
        """expect: by code, what a detail says; no other codes."""
        self.same(name, "warnings", sorted({w["code"] for w in got}), sorted(expect))
        for code, said in expect.items():
            for part in said if isinstance(said, list) else [said]:
                self.tally.check(any(w["code"] == code and part in w["detail"] for w in got), f"{name}: {code} says {part}", str(got))

    def operator(self, name, expect, result):
        factors, state = result.get("invariant_factors"), result.get("state", {})
        is_ = {"solvable": result.get("solvable"), "rank": result.get("rank"), "index": result["index"]["operator"],
               "nu0": result.get("transfer_leading_order"), "dimension": state.get("dimension"),
               "order": factors and len(factors[-1]) - 1, "factors": factors and len(factors),
               "nilpotency": result.get("kronecker", {}).get("nilpotency"), "state": state, "jacobson": result["jacobson"].get("code"),
               "roots": [s["root_of"] for s in result.get("singular_times", [])],
               "lost": ["pole" if "pole" in s["lost"] else "zero" for s in result.get("singular_times", [])]}
        for key, value in expect.items():
            if key == "times":
                times = [s["t"] for s in result["singular_times"]]
                close = len(times) == len(value) and all(abs(a - number(b)) <= 4e-16 * abs(a) for a, b in zip(times, value))
                self.tally.check(close, f"{name}: singular times", f"{times}, should be {value}")
            elif key == "state":
                self.tally.check(all(state.get(k) == v for k, v in value.items()), f"{name}: state form", str(state))
            else:
                self.same(name, "operator " + key, is_[key], value)

    def close(self, name, what, got, should, tolerance):
        for key, value in should.items():
            value = number(value)
            ok = got.get(key) is not None and abs(got[key] - value) <= tolerance * (1 + abs(value))
            self.tally.check(ok, f"{name}: {what} {key}", f"is {got.get(key)}, should be {value}")

    def at_points(self, name, expect, answer):
        bound = mpmath.mpf(10) ** (-answer.digits // 2)
        given = expect.get("parameters", {})
        for p in expect.get("on", []):
            r = answer.residuals({**given, **p})
            self.tally.check(all(abs(x) < bound for x in r), f"{name}: {p} lies on Pf", str([mpmath.nstr(x, 3) for x in r]))
        for p in expect.get("off", []):
            try:
                r = answer.residuals({**given, **p})
            except Undefined:
                r = [1]
            self.tally.check(any(abs(x) > bound for x in r), f"{name}: {p} does not lie on Pf")
        for f in expect.get("field", []):
            gap = answer.field_differs({**given, **f["at"]}, f["value"])
            self.tally.check(gap < bound, f"{name}: X at {f['at']}", f"differs by {mpmath.nstr(gap, 3)}")
        for text, kind in expect.get("assumed", {}).items():
            found = {a["expression"].replace(" ", ""): a["kind"] for a in answer.result.get("assumptions", [])}
            self.tally.check(found.get(text) == kind, f"{name}: {text} is assumed {kind}", str(found))
        for m in expect.get("motion", []):      # closed forms of accelerations and reactions, on Pf
            self.motion(name, m, answer)
        for p in expect.get("strata", []):
            with mpmath.workdps(60):
                env = answer.point({**given, **p})
                sets = [s["where"] for s in answer.result.get("strata", [])]
                sets += [[a["expression"]] for a in answer.result.get("assumptions", [])]
                hit = any(where and all(abs(self.value(answer, e, env)) < bound for e in where) for where in sets)
            self.tally.check(hit, f"{name}: {p} lies on a stratum", str(sets))

    def motion(self, name, closed, answer):
        with mpmath.workdps(answer.digits + 15):
            points = answer.sample([e for _, e in answer.constraints], 2)
            self.tally.check(points, f"{name}: motion: points of Pf")
            for env in points:
                for key, texts in closed.items():
                    for text, e in zip(texts, answer.motions[key]):
                        is_ = answer.graph.values(answer.graph.cone([e]), env, EXACT)[e]
                        should = self.value(answer, text, env)
                        self.tally.check(abs(is_ - should) <= answer.tiny() * (1 + abs(should)), f"{name}: {key} = {text}",
                                         f"is {mpmath.nstr(is_, 8)}, should be {mpmath.nstr(should, 8)}")

    def singular(self, name, request, answer, stratum):
        """The square matrix of a quasilinear system without constraints at the point of a
        described stratum: its least singular value is 0 beside the largest."""
        system = request["system"]
        if system["form"] != "quasilinear" or result_constraints(answer):
            return
        with mpmath.workdps(30):
            env = answer.point({k: repr(v) for k, v in {**stratum["point"], "t": stratum["time"]}.items()})
            A = mpmath.matrix([[self.value(answer, str(e), env) for e in row] for row in system["A"]])
            values = mpmath.svd_r(A, compute_uv=False)
            self.tally.check(min(values) < 1e-9 * max(values), f"{name}: the matrix is singular at the stratum's point", mpmath.nstr(values, 3))

    @staticmethod
    def value(answer, text, env):
        e = answer.graph.parse(text)
        return answer.graph.values(answer.graph.cone([e]), env, EXACT)[e]

    def sweep(self, name, request, result, expect):
        """Each trajectory is, to the last digit, the one of a request with this start alone; or the error is. With
        parameters of its own, whose expressions may be evaluated in another order, to the accuracy asked for; "own: "
        before what is expected says that the general analysis must not have been used."""
        got = result.get("trajectories", [])
        self.tally.check(len(got) == len(request["sweep"]) == len(expect) and "trajectory" not in result, f"{name}: as many trajectories as starts")
        for start, one, kind in zip(request["sweep"], got, expect):
            alone = {k: v for k, v in request.items() if k != "sweep"}
            alone["trajectory"] = dict(request["trajectory"], initial={**request["trajectory"].get("initial", {}), **start.get("initial", {})})
            system = request["system"]
            alone["system"] = {**system, "parameters": {**system.get("parameters", {}), **start.get("parameters", {})}}
            other, problem = self.solver.solve(alone)
            label = f"{name}: from {start}"
            if any("parameters" in s for s in request["sweep"]):
                own = kind.startswith("own: ")
                kind = kind.removeprefix("own: ")
                if not kind.startswith("error "):
                    self.same(label, "analysis", one.get("analysis"), "own" if own else "shared")
                    if self.tally.check("rows" in one and other, label, f"{str(one)[:300]} {problem}"):
                        self.alike(label, request, one, other["trajectory"])
                    ended = (one.get("ended") or {}).get("reason", "reaches its stop")
                    self.tally.check(ended == kind, label, f"{ended}, not {kind}")
                    continue
            if kind.startswith("error "):
                self.tally.check(one.get("error", {}).get("code") == kind[6:] == (problem or {}).get("code"), label, str(one)[:200])
                continue
            self.tally.check("rows" in one and other and one == other["trajectory"], label, "differs from the trajectory alone")
            ended = (one.get("ended") or {}).get("reason", "reaches its stop")
            self.tally.check(ended == kind, label, f"{ended}, not {kind}")


    def alike(self, label, request, one, other):
        """Two trajectories of one motion."""
        for key in ("columns", "gauge", "arithmetic"):
            self.same(label, key, one[key], other[key])
        self.same(label, "ended", (one["ended"] or {}).get("reason"), (other["ended"] or {}).get("reason"))
        accuracy = {"rtol": 1e-8, "atol": 1e-10, **request.get("accuracy", {})}
        self.tally.check(len(one["rows"]) == len(other["rows"]), f"{label}: rows")
        for r, q in zip(one["rows"], other["rows"]):
            off = max((abs(x - y) / (accuracy["atol"] + accuracy["rtol"] * abs(y)) for x, y in zip(r[1:], q[1:])), default=0)
            if not self.tally.check(off <= 2 or not (one["accuracy_reached"] and other["accuracy_reached"]), f"{label}: at {r[0]}", f"{r} {q}"):
                return


class TrajectoryCheck:
    """Samples against the constraints, against closed forms, and against the motion that
    our own linear algebra finds at the samples (Simpson's rule over three of them)."""

    def __init__(self, tally, name, request, result, answer):
        self.tally, self.name, self.request, self.result, self.answer = tally, name, request, result, answer
        self.spec = request["trajectory"]
        self.t = result["trajectory"]
        self.columns = self.t["columns"]
        self.rows = self.t["rows"]
        self.tables = tables_of(request["system"])

    def check(self, ok, what, detail=""):
        self.tally.check(ok, f"{self.name}: trajectory: {what}", detail)

    def slides(self, expected):
        got = self.t.get("slides", [])
        shape = [[s["surface"], s["to"] is None, s["left"]] for s in got]
        self.check(shape == [[surface, to is None, left] for surface, _, to, left in expected], "slides", str(got))
        for s, (_, start, to, _) in zip(got, expected):
            asked = {"rtol": 1e-8, "atol": 1e-10, **self.request.get("accuracy", {})}
            off = max(abs(s["from"] - start), abs(s["to"] - to) if to is not None and s["to"] is not None else 0)
            self.check(off <= max(10 * asked["rtol"], 1e-9), "a slide's times", f"{s}, off by {off:.3g}")
            self.check(-1 - 1e-9 <= s["switch"][0] <= s["switch"][1] <= 1 + 1e-9, "a switch between -1 and 1", str(s))
        self.check(("slides" in self.t) == bool(self.spec.get("sliding")), "slides where they are asked for")

    def run(self, expect, modes=False):
        modes = modes or bool(self.spec.get("sliding"))     # each choice of switches has its own constraints
        self.check(self.columns[0] == self.answer.problem.time, "first column is time", str(self.columns))
        self.check(all(len(r) == len(self.columns) and None not in r for r in self.rows), "rows are full")
        if not self.rows:
            self.check(expect.get("rows") == 0, "has rows")
            return
        if "rows" in expect:
            self.check(len(self.rows) == expect["rows"], "rows", str(len(self.rows)))
        if "reference" in expect:
            self.reference(expect["reference"])
        if expect.get("estimates"):
            self.estimates(expect["reference"])
        if "drift" in expect:
            self.drift(expect["drift"])
        if "gauge" in expect:
            self.check(self.t["gauge"] == expect["gauge"], "gauge choice", self.t["gauge"])
        if "gauge_numeric" in expect:
            self.check(("gauge_numeric" in self.t) == expect["gauge_numeric"], "gauge choice by expressions or not", str(self.t.get("gauge_numeric")))
        if "method" in expect:
            self.check(self.t["method"] == expect["method"], "method", self.t["method"])
        if "arithmetic" in expect:
            self.check(self.t["arithmetic"] == expect["arithmetic"], "arithmetic", self.t["arithmetic"])
        passed = [p["t"] for p in self.t.get("passed", [])]
        if "passed" in expect:       # singular positions that the motion goes through: the first ones' times; and how many there are
            near = expect.get("passed_tolerance", 1e-7)
            times = [number(t) for t in expect["passed"]]
            self.check(len(passed) == expect.get("passes", len(times)) and all(abs(a - b) <= near for a, b in zip(passed, times)), "singular positions passed", str(passed[:5]))
        else:
            self.check(not passed, "no singular position on the way", str(passed[:5]))
        if "slides" in expect:       # surface, from, to, the side it was left to
            self.slides(expect["slides"])
        if "charts" in expect:
            self.check(bool(self.t.get("charts")) == expect["charts"], "other pivots on the way", str(self.t.get("charts")))
        if "reached" in expect:
            self.check(self.t["accuracy_reached"] == expect["reached"], "accuracy reached", str(self.t.get("accuracy_shortfall")))
        self.ended(expect.get("ended"))
        if "events" in expect:
            self.events(expect["events"], expect.get("event_tolerance", 1e-7))
        if "exact_events" in expect:
            self.exact_events(expect["exact_events"])
        self.times()
        if "final" in expect:
            last = dict(zip(self.columns, self.rows[-1]))
            tolerance = expect.get("tolerance", 1e-6)
            for key, value in expect["final"].items():
                value = number(value)
                self.check(abs(last[key] - value) <= tolerance * (1 + abs(value)), f"final {key}", f"is {last[key]}, should be {value}")
        for text in expect.get("conserved", []):
            self.conserved(text, expect.get("tolerance", 1e-6))
        for key, text in expect.get("closed", {}).items():
            self.closed(key, text, expect.get("tolerance", 1e-6))
        if set(self.answer.names) <= set(self.columns) and not modes:      # whose pieces have each their own constraints (mode_check.py)
            self.residuals(expect.get("residual", 1e-9))
            self.equations_hold(expect.get("residual", 1e-9))
            self.simpson(expect.get("defect", 1e-4))

    def reference(self, rows):
        """Values known to many digits: within the tolerances, or the answer has to say that it is not."""
        asked = self.request["accuracy"]
        self.check(len(rows) == len(self.rows) == len(self.t["errors"]), "as many rows and estimates as known", str(len(self.rows)))
        if not self.t["accuracy_reached"]:
            self.check(bool(self.t.get("accuracy_shortfall")), "says why the accuracy was not reached")
            return
        for got, should in zip(self.rows, rows):
            for name, x, r in zip(self.columns[1:], got[1:], should):
                with mpmath.workdps(50):
                    error = float(abs(mpmath.mpf(getattr(x, "text", x)) - mpmath.mpf(r)))
                self.check(error <= asked["atol"] + asked["rtol"] * abs(float(r)), f"{name} at {got[0]}", f"off by {error:.3g}")

    def estimates(self, rows):
        """Each estimate holds, whether the accuracy was reached or not."""
        for got, should, estimate in zip(self.rows, rows, self.t["errors"]):
            error = max(float(abs(mpmath.mpf(x) - mpmath.mpf(r))) for x, r in zip(got[1:], should))
            self.check(estimate is not None and error <= estimate, f"the estimate at {got[0]}", f"off by {error:.3g}, estimated {estimate}")

    def drift(self, expect):
        """[function, conserved, the most it may drift]; and, where a column is that function, what the rows say."""
        got = self.t["drift"]
        self.check(got["constraints"] == self.t["constraint_residual"], "drift of the constraints")
        self.check([[d["function"], d["conserved"]] for d in got["integrals"]] == [e[:2] for e in expect], "functions whose drift is given", str(got))
        for d, (name, _, most) in zip(got["integrals"], expect):
            self.check(most is None or d["largest"] <= most, f"drift of {name}", str(d))
            size = abs(d["start"])
            self.check(d["relative"] == (d["largest"] / size if size else None), f"relative drift of {name}", str(d))
            if name in self.columns:
                far = max((abs(r[self.columns.index(name)] - d["start"]), r[0]) for r in self.rows)
                self.check(abs(far[0] - d["largest"]) <= 1e-14 * (1 + size), f"drift of {name} in the rows", f"{far}, {d}")

    def ended(self, expect):
        ended = self.t["ended"]
        if expect is None:
            self.check(ended is None, "reaches its end", str(ended))
            return
        self.check(ended is not None, "ends early")
        if ended is None:
            return
        if "reason" in expect:
            allowed = expect["reason"] if isinstance(expect["reason"], list) else [expect["reason"]]
            self.check(ended["reason"] in allowed, "reason", str(ended))
        if "detail" in expect:
            self.check(expect["detail"] in ended["detail"], "detail", str(ended))
        if "t" in expect:
            self.check(abs(ended["t"] - number(expect["t"])) <= expect.get("tolerance", 1e-3), "ends at its time", str(ended))
        back = -1 if number(self.spec.get("stop", ended["t"])) < number(self.spec.get("start", 0)) else 1
        self.check(all(back * (r[0] - ended["t"]) <= 1e-12 for r in self.rows), "no sample lies past the end")

    def events(self, expect, tolerance):
        """All of them, in their order (those of one time have none): [name, direction, time]; and that the estimates of their errors hold."""
        got, begin = list(self.t["events"]), 0
        while begin < len(expect):
            end = begin + sum(e[2] == expect[begin][2] for e in expect[begin:])
            order = [e[:2] for e in expect[begin:end]]
            got[begin:end] = sorted(got[begin:end], key=lambda e: order.index([e["name"], e["direction"]]) if [e["name"], e["direction"]] in order else len(order))
            begin = end
        names = [[e["name"], e["direction"]] for e in got]
        self.check(names == [e[:2] for e in expect], "the events that happen", str(names))
        if len(got) != len(expect):
            return
        for e, (name, direction, t) in zip(got, expect):
            off = abs(e["t"] - number(t))
            self.check(off <= tolerance if direction != "touch" else off <= 1e-4, f"event {name} at {t}", f"off by {off:.3g}")
            self.check(e["error"] is not None and (direction == "touch" or off <= e["error"]), f"event {name}: its error", f"{off:.3g} > {e['error']}")
            self.check(len(e["values"]) == len(self.columns) - 1, f"event {name} has values")

    def exact_events(self, expect):
        """[name, direction, time to many digits, values (may be left out)]: within the tolerances, and the estimates hold;
        what is printed of the values is right to three units of the last digit."""
        got = self.t["events"]
        asked = self.request["accuracy"]
        self.check([[e["name"], e["direction"]] for e in got] == [e[:2] for e in expect], "the events that happen", str(got))
        for e, (name, direction, t, *values) in zip(got, expect):
            with mpmath.workdps(50):
                off = float(abs(mpmath.mpf(e["t"].text if hasattr(e["t"], "text") else e["t"]) - mpmath.mpf(t)))
            allowed = asked["atol"] + asked["rtol"] * abs(float(t))
            if self.t["accuracy_reached"]:
                self.check(off <= (allowed if direction not in ("touch", "undecided") else allowed ** 0.5), f"event {name} at {t}", f"off by {off:.3g}")
            self.check(direction == "touch" or off <= e["error"], f"event {name} at {t}: its error", f"{off:.3g} > {e['error']}")
            for v, true in zip(e["values"], values[0] if values else []):
                text = v.text if hasattr(v, "text") else repr(v)
                with mpmath.workdps(50):
                    off = abs(mpmath.mpf(text) - mpmath.mpf(true))
                    unit = mpmath.mpf(10) ** Decimal(text).as_tuple().exponent
                    self.check(off <= 3 * unit, f"event {name} at {t}: value {true}", text)

    def times(self):
        if "samples" not in self.spec or self.t["ended"]:
            return
        a, b, n = number(self.spec["start"]), number(self.spec["stop"]), self.spec["samples"]
        self.check(len(self.rows) == n, "as many rows as samples", str(len(self.rows)))
        if n > 1:
            off = max(abs(r[0] - (a + (b - a) * i / (n - 1))) for i, r in enumerate(self.rows))
            self.check(off <= 1e-12 * max(1, abs(b)), "evenly spaced", str(off))

    def environments(self):
        for r in self.rows:
            env = dict(zip(self.columns, r))
            for n, u in self.tables.items():
                env.update({n + "'" * k: float(u.value(k, r[0])) for k in range(5)})
            yield env

    def along(self, text):
        g = Graph()
        for n, v in (self.request["system"].get("parameters") or {}).items():
            if v is not None:
                g.define(n, v)
        e = g.parse(text)
        cone = g.cone([e])
        return [g.values(cone, env, FLOAT)[e] for env in self.environments()]

    def conserved(self, text, tolerance):
        v = self.along(text)
        size = 1 + max(abs(x) for x in v)
        self.check(max(v) - min(v) <= tolerance * size, f"{text} is conserved", f"varies by {max(v) - min(v):.3g}")

    def closed(self, key, text, tolerance):
        v = self.along(f"({text}) - {key}") if key.isidentifier() else self.along(text)
        size = 1 + max(abs(env[key]) for env in self.environments())
        worst = max(abs(x) for x in v)
        self.check(worst <= tolerance * size, f"{key} = {text}", f"off by {worst:.3g}")

    def residuals(self, bound):
        g = self.answer.graph
        worst = 0
        for env in self.environments():
            for _, e in self.answer.constraints:
                value = g.values(g.cone([e]), env, FLOAT)
                size = 1 + max([abs(v) for v in value.values() if isinstance(v, float)] + [0])
                worst = max(worst, abs(value[e]) / size)
        self.check(worst <= bound, "stays on Pf", f"residual {worst:.3g}")

    def equations_hold(self, bound):
        """Equations without derivatives, as they were given, put to every sample."""
        for text in self.request["system"].get("equations", []):
            if "'" in text or "der(" in text or text.count("=") != 1:
                continue
            left, right = text.split("=")
            off = self.along(f"({left}) - ({right})")
            size = [1 + abs(a) for a in self.along(left)]
            worst = max(abs(v) / s for v, s in zip(off, size))
            self.check(worst <= bound, f"the samples satisfy {text}", f"off by {worst:.3g}")

    def set_between(self, trio):
        """Whether an event set something between these samples."""
        sets = {e["name"] for e in self.spec.get("events", []) if e.get("action") == "set"}
        times = [env[self.answer.problem.time] for env in trio]
        return any(min(times) <= e["t"] <= max(times) for e in self.t.get("events", []) if e["name"] in sets)

    def simpson(self, bound):
        """x(t+2h) - x(t) against h/3 (v0 + 4 v1 + v2) of the velocity that our route finds."""
        gauge = self.spec.get("gauge", {})
        if "conditions" in gauge or len(self.rows) < 3:
            return
        rates = {n: self.answer.graph.parse(e) for n, e in gauge.get("rates", {}).items()}
        middle = len(self.rows) // 2
        for first in {0, max(0, middle - 1), len(self.rows) - 3}:
            trio = list(self.environments())[first:first + 3]
            if self.set_between(trio):
                continue       # it jumps there
            v = []
            with mpmath.workdps(30):
                for env in trio:
                    move = self.answer.motion({k: mpmath.mpf(x) for k, x in env.items()}, rates)
                    if move is None:
                        self.check(False, "has a tangent motion at a sample")
                        return
                    v.append(move)
            time = self.answer.problem.time
            h = (trio[2][time] - trio[0][time]) / 2
            for i, n in enumerate(self.answer.names):
                step = trio[2][n] - trio[0][n]
                rule = float(h / 3 * (v[0][i] + 4 * v[1][i] + v[2][i]))
                if abs(step - rule) > bound * (1 + abs(step)):
                    self.check(False, f"moves along X ({n}, row {first})", f"step {step:.6g}, rule {rule:.6g}")
                    return
        self.check(True, "moves along X")
