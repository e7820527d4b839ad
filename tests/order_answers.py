"""What must be alike in the answers to one question asked twice.

Sets are compared at points that the checkers' own Newton iteration finds (identities.Answer): a point of the first's
admissible set lies on the second's. Strata are compared as sets: a point where the rank drops (kind pivot), or one
that satisfies all given equations off the admissible set (kind branch), lies on a stratum of the other answer. Which
functions vanish there, and how many strata the same set is cut into, is a matter of how one eliminates.
"""
import collections
import re
import signal

import mpmath

import linear
import respell
from expression import EXACT, Graph, Undefined
from identities import Answer, Broken
from symbolic import Derivatives

POINTS_UP_TO = 12      # variables of systems whose sets are compared at points
STRATA_UP_TO = 4
DIGITS = 60            # in which points are carried over: of signals that are 10^15 times a difference, too
SECONDS = 15           # for all points of one comparison
TINY = re.compile(r"[0-9.]e[-+]?[0-9]{2}|/1" + "0" * 12)    # numbers that the digits of these points do not tell from 0
NEAR = 1e-6            # of starts, relative
BEYOND_DOUBLE = "too large for numbers in double|as far as numbers in double tell"
MOVED = 1e-12          # past rounding: stiff multipliers are as much as 1e12 times a place
# what the checkers do not read or cannot evaluate is not compared
ODD = (Broken, Undefined, KeyError, ValueError, TypeError, NotImplementedError, RecursionError, OverflowError, ZeroDivisionError, IndexError)


class Sets:
    """Points of the sets that an answer speaks of: of the admissible set, and of its strata."""

    def __init__(self, result):
        self.result, self.found = result, []

    def fill(self, request):
        result = self.result
        d = result["dimensions"]
        if d["ambient"] > POINTS_UP_TO or result["verdict"] == "inconsistent" or chosen_multipliers(result) or TINY.search(str(request["system"])):
            return
        self.answer = Answer(request, result, seed=7, digits=30)
        self.nodes = [e for _, e in self.answer.constraints]
        self.rank = d["ambient"] - result["gauge"]["dimension"]
        listed = result.get("strata", [])
        if not any(s["kind"] == "branch" for s in listed):
            given = self.given()    # the constraints may vanish on more, where they cut out the set near some points only
            self.found += [("set", env) for env in self.answer.sample(self.nodes, 1) if all(vanishes(self.answer, e, env) for e in given)]
        for s in [s for s in listed if s.get("where") and s["kind"] in ("pivot", "branch")][:STRATA_UP_TO]:
            self.found += [(s["kind"], env) for env in (self.pivot if s["kind"] == "pivot" else self.branch)(s["where"])]

    def pivot(self, where):
        """A point of the admissible set where the rank drops."""
        a = self.answer
        for env in a.sample(self.nodes + self.new(where), 1):
            with mpmath.workdps(a.digits + 15):
                if linear.rank(a.augmented(env, self.nodes, True)[0], a.tiny()) < self.rank:
                    yield env

    def branch(self, where):
        """A point that satisfies what is given without derivatives and does not lie on the admissible set."""
        for env in self.answer.sample(self.new(where) + self.given(), 1):
            if not self.on_set(env):
                yield env

    def given(self):
        """What is given without derivatives."""
        a, d = self.answer, Derivatives(self.answer.graph)
        speeds = [[n for n in a.graph.names([r]) if n.startswith("@")] for r in a.problem.rows]
        return [r for r, s in zip(a.problem.rows, speeds) if all(d.zero(d.of(r, n)) for n in s)] + a.problem.restrict

    def new(self, where):
        """The functions that are not among the constraints."""
        return [e for e in map(self.answer.graph.parse, where) if e not in self.nodes]

    def on_set(self, env):
        return all(vanishes(self.answer, e, env) for e in self.nodes)


def vanishes(answer, e, env):
    with mpmath.workdps(DIGITS):
        value, slope, _, _ = answer.row(e, env, answer.graph.cone([e]))
        size = max([abs(a * env[n]) for a, n in zip(slope, answer.names)] + [max(abs(a) for a in slope)] + [mpmath.mpf(10) ** -12])
        return abs(value) <= size * mpmath.mpf(10) ** -9


class Base:
    """The first answer, with points of its sets."""

    def __init__(self, request, plain, said, result, problem, seconds):
        self.request, self.plain, self.said, self.result, self.problem, self.seconds = request, plain, said, result, problem, seconds
        self.found = None

    def points(self):
        if self.found is None:
            self.found = points_of(self.plain, self.result)
        return self.found


def points_of(request, result):
    sets = Sets(result)
    try:
        sets.fill(request)
    except ODD:
        pass
    return sets.found


def numbers(result):
    d = result["dimensions"]
    return {"verdict": result["verdict"], "equilibrium": result.get("equilibrium"), "generations": d["generations"], "final": d["final"],
            "ambient": d["ambient"], "index": result.get("index", {}).get("generations"),
            "differentiation": result.get("index", {}).get("differentiation"), "gauge": result.get("gauge", {}).get("dimension")}


def expected(base, said):
    """The numbers of the first answer, as named signals shift them."""
    out = numbers(base.result)
    k = len(said.signals)
    if k:
        out["ambient"] += k
        if not out["generations"] and out["verdict"] != "inconsistent":
            out["generations"] = [out["ambient"] - k]
        if out["verdict"] != "inconsistent":
            out["index"] = max(out["index"] or 0, 1) if out["index"] is not None else None
            if out["differentiation"] is not None:
                out["differentiation"] = max(out["differentiation"], 1)
    return out


def differences(base, said, request, result, problem):
    if problem or base.problem:
        first = base.problem["code"] if base.problem else base.result["verdict"]
        second = problem["code"] if problem else result["verdict"]
        if "signals" in said.done and any(p and re.search(BEYOND_DOUBLE, p["detail"]) for p in (problem, base.problem)):
            return []     # a name makes a variable of what no sample can show, or of what its rounding hides
        if "units" in said.done and problem and problem["code"] == "no_motion" and "rank drops" in problem["detail"] and (base.result or {}).get("consistent_initial", {}).get("moved", 0) > MOVED:
            return []     # what is nearest is another point in other units: one at which the rank drops is refused, rightly
        return [] if first == second else [f"{first} became {second}" + (f" ({problem['detail'][:150]})" if problem else "")
                                           + (f" (was: {base.problem['detail'][:150]})" if base.problem else "")]
    should, is_ = expected(base, said), numbers(result)
    out = [f"{k}: {should[k]} became {is_[k]}" for k in should if should[k] != is_[k]]
    if out:
        return out
    return start(base, said, result) + sets(base, said, request, result)


def kinds(result):
    return collections.Counter(s["kind"] for s in result.get("strata", []))


def strata_text(result):
    return str([(s["kind"], s.get("where")) for s in result.get("strata", [])])[:400]


def start(base, said, result):
    """The projected start, in the names and units of the first. Of two that are as far from the guess (a velocity of which only
    the square is known) either is right; what is nearest where given values must move is a matter of units. What nothing determines is
    small, signals that have a name with the rest: then it is another one."""
    if "units" in said.done and base.result.get("consistent_initial", {}).get("moved", 0) > MOVED:
        return []
    first, second = (r.get("consistent_initial", {}).get("projected") for r in (base.result, result))
    if first is None or second is None:
        return [f"start: {first} became {second}"] if first != second else []
    left_out = set(base.said.multipliers if chosen_multipliers(base.result) else ())
    if "signals" in said.done:
        left_out |= undetermined(base)
    pairs = []
    for name, value in first.items():
        bare = name.rstrip("'")
        if said.value(bare, name[len(bare):]) not in second:
            return [f"start: {name} has no value now"]
        if bare not in left_out:
            pairs.append((name, float(value), float(second[said.value(bare, name[len(bare):])]) * float(said.scale.get(bare, 1))))
    largest = max([1.0] + [abs(v) for _, v, _ in pairs])
    off = [f"start: {n} {v:.9g} became {w:.9g}" for n, v, w in pairs if abs(v - w) > NEAR * largest]
    return [] if off and tied(base, pairs, largest, "signals" in said.done) else off


def on_first(base, pairs):
    """Whether the second start satisfies what is given without derivatives, and, where the first speaks of no other branch, the
    constraints that it printed."""
    sets = Sets(base.result)
    sets.answer = Answer(base.plain, base.result, digits=30)
    env = {name: mpmath.mpf(second) for name, _, second in pairs}
    env[base.said.first_time] = mpmath.mpf(str(base.said.trajectory.get("start", 0)))
    branches = any(s["kind"] == "branch" for s in base.result.get("strata", []))
    try:
        return all(vanishes(sets.answer, e, env) for e in sets.given() + ([] if branches else [e for _, e in sets.answer.constraints]))
    except ODD:
        return False


def moving_of(base):
    """The unknowns that have derivatives."""
    answer = Answer(base.plain, base.result)
    return {n[1:].rstrip("'") for n in answer.graph.names(answer.problem.rows) if n.startswith("@")}


def undetermined(base):
    """What was not given, where an unknown without a derivative may have any value."""
    answer = Answer(base.plain, base.result)
    given = base.said.trajectory.get("initial", {})
    free = set(base.result["consistent_initial"]["free"]) - moving_of(base) - set(given)
    return {n.rstrip("'") for n in answer.names if n not in given} if free else set()


def tied(base, pairs, largest, named):
    """Whether both starts are as far from the given values, and from 0 where none was given. Algebraic variables are free of
    charge, so that where some have got a name the small ones are others: of branches that differ in them alone either is right, if
    it satisfies the first's equations."""
    if named:
        if not on_first(base, pairs):
            return False
        moving = moving_of(base)
        pairs = [p for p in pairs if p[0].rstrip("'") in moving or p[0] in base.said.trajectory.get("initial", {})]
    guess = {n: float(respell.exact(v) or 0) for n, v in base.said.trajectory.get("initial", {}).items()}
    far = [sum((p[k] - guess.get(p[0], 0)) ** 2 for p in pairs) ** 0.5 for k in (1, 2)]
    return abs(far[0] - far[1]) < NEAR * largest


def chosen_multipliers(result):
    """Whether multipliers are a matter of choice: which of dependent constraints is called redundant, or
    which functions stand for an irregular one."""
    regularity = result.get("regularity", {})
    return bool(regularity.get("conditions") or regularity.get("redundant") or result.get("evidence", {}).get("redundant_holonomic"))


class TooSlow(Exception):
    pass


def too_slow(*_):
    raise TooSlow


def sets(base, said, request, result):
    """What the points say, as far as they are found within some seconds."""
    signal.signal(signal.SIGALRM, too_slow)
    signal.alarm(SECONDS)
    try:
        return differing_sets(base, said, request, result)
    except TooSlow:
        base.found = base.found or []
        return []
    finally:
        signal.alarm(0)


def differing_sets(base, said, request, result):
    """Points of the first's sets lie on the second's; where strata are listed in another way, the other way round too."""
    if cut(base.result) or cut(result):      # they say that they do not cover all
        return []
    with mpmath.workdps(DIGITS):
        there = [(kind, with_signals(said, request, translated(said, env))) for kind, env in base.points()]
        out = missed(there, request, result, "first")
        if kinds(base.result) != kinds(result):
            back = [(kind, given_back(said, env)) for kind, env in points_of(request, result)]
            out += missed(back, base.plain, base.result, "second")
        return out


def cut(result, code="search_cut"):
    """Whether a limit ended the search for branches, or for strata."""
    return any(w["code"] == code for w in result.get("warnings", []))


def missed(points, request, result, whose):
    out = []
    if chosen_multipliers(result):
        return out
    for kind, env in points:
        try:
            new = Answer(request, result, digits=30)
            asked = [(e, c) for (g, e), c in zip(new.constraints, result["constraints"]) if kind == "set" or g == 1]
            off = [str(c["expression"])[:150] for e, c in asked if not vanishes(new, e, env)]
            if kind == "set" and off:
                out.append(f"set: {off} not zero at a point of the {whose}'s")
            elif kind != "set" and not cut(result, "strata_not_searched") and not (kind == "branch" and not off) and not listed(new, env):
                out.append(f"strata: a point of a {kind} of the {whose} ({strata_text(result)} in the other)")
        except ODD:
            pass
    return out


def listed(answer, env):
    """Whether a stratum holds the point, or is only told by a point of its own."""
    for s in answer.result.get("strata", []):
        if not s.get("where") or all(vanishes(answer, answer.graph.parse(e), env) for e in s["where"]):
            return True
    return False


def with_signals(said, request, here):
    for name, text in said.signals:
        g = Graph()
        for p, v in (request["system"].get("parameters") or {}).items():
            if v is not None:
                g.define(p, v)
        e = g.parse(text)
        try:
            here[name] = g.values(g.cone([e]), here, EXACT)[e]
        except ODD:
            pass
    return here


def given_back(said, env):
    """A point in the names and units of the first."""
    names = {new: old for old, new in said.names.items()}
    parameters = {new: old for old, new in said.parameter.items()}
    out = {}
    for name, v in env.items():
        bare = name.rstrip("'")
        if bare in parameters:
            out[parameters[bare]] = v
        elif name == said.time:
            out[said.first_time] = v
        elif bare in names:
            c = said.scale.get(names[bare], 1)
            out[names[bare] + name[len(bare):]] = v * c.numerator / c.denominator
        else:
            out[name] = v
    return out


def translated(said, env):
    out = {}
    for name, v in env.items():
        bare = name.rstrip("'")
        if bare in said.parameter:
            out[said.parameter[bare]] = v
        elif name == said.first_time:
            out[said.time] = v
        elif bare in said.names:
            c = said.scale.get(bare, 1)
            out[said.value(bare, name[len(bare):])] = v / (mpmath.mpf(c.numerator) / c.denominator)
        else:
            out[name] = v
    return out
