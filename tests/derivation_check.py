"""Replays every derivation of the corpus at random points: derivation_check.py BUILD_DIR [NAME...]

Each step is checked from those it uses, by an evaluator of the tests' own (mpmath, its derivatives by its own gradient):
- given: the equation of the request, built from the request's definition of its form;
- differentiate: the gradient times the velocities and the time derivative of the constraint that it uses;
- insert, constraint, redundant: the sum of the multiples, with the velocities put in that the other steps give, is what the step gives, at points
  where the constraints that it uses vanish, any points where it uses none;
- solve: the sum is a multiple of the velocity less its value, or all equations used hold with the values put in for any free functions, which are as
  many as the rank leaves;
- constraint, branch: what it came from vanishes where it does; the dimension falls by one, and by the rank of all differentials;
- pivot: not zero at points of the final set; stop: the verdict, and the contradiction is not zero.
Then steps are spoilt, of every kind and in several ways, and each must be seen.
Every twelfth case is asked, from one that SGA_TEST_SEED chooses; SGA_TEST_EVERY=1 asks all, which takes half an hour.
"""
import contextlib
import copy
import json
import multiprocessing
import os
import re
import sys
import tempfile

import mpmath

import linear
from cases import load, waiting
from expression import EXACT, Undefined
from identities import Answer, Broken
from solver import Crash, Solver
from tally import Tally, build_folder

WANT = ["constraints", "vector_field", "gauge", "derivation"]
KINDS = ("given", "solve", "differentiate", "insert", "constraint", "redundant", "branch", "pivot", "stop")
VELOCITY = re.compile(r"der\(([^()]*)\)")
DIGITS = 40
MANY = 60                  # of systems with more variables no points of constraint sets are looked for: steps that hold anywhere are checked
LARGE, LOOKED_AT = 80, 25     # of longer derivations so many steps are looked at, drawn at random


class Wrong(Exception):
    pass


class Skipped(Exception):
    """A step that has no text, or no points to look at."""


class Replay:
    def __init__(self, answer, steps):
        self.a, self.steps, self.graph = answer, steps, answer.graph
        self.velocity = {n: f"velocity_{i}_" for i, n in enumerate(answer.names)}
        self.digits = answer.digits
        self.tiny = mpmath.mpf(10) ** (-self.digits // 2)
        self.named = answer.problem.named(answer.result.get("evidence", {}).get("pull_back"), self.graph)
        self.points, self.counts, self.skipped = {}, {k: 0 for k in KINDS}, {k: 0 for k in KINDS}
        for f in answer.free or []:
            self.graph.sym(f)

    # Texts

    def side(self, text):
        return self.graph.parse(VELOCITY.sub(lambda m: self.velocity[m.group(1)], text))

    def lines(self, step):
        """[(left, right, relation)] as nodes."""
        if step["gives"] is None:
            raise Skipped
        out = []
        for line in step["gives"].split("; "):
            relation = "!=" if "!=" in line else "="
            left, right = line.split(relation)
            out.append((self.side(left), self.side(right), relation))
        return out

    def value(self, node, env):
        return self.graph.values(self.graph.cone([node]), env, EXACT)[node]

    def affine(self, line, env):
        """(coefficients of the velocities, the rest, size) of left less right."""
        here = {**env, **{w: mpmath.mpf(0) for w in self.velocity.values()}}
        coefficients, rest, size = [mpmath.mpf(0)] * len(self.a.names), mpmath.mpf(0), mpmath.mpf(1)
        for node, sign in ((line[0], 1), (line[1], -1)):
            value = self.graph.values(self.graph.cone([node]), here, EXACT)
            d = self.graph.gradient(node, value, EXACT)
            coefficients = [c + sign * d.get(self.velocity[n], mpmath.mpf(0)) for c, n in zip(coefficients, self.a.names)]
            rest += sign * value[node]
            size = max(size, abs(value[node]))
        return coefficients, rest, max([size] + [abs(c) for c in coefficients])

    # Points

    def before(self, n, generation):
        """Constraints that were found before step n, of generations below this one."""
        return [self.lines(s)[0][0] for s in self.steps[:n - 1] if s["kind"] == "constraint" and s["generation"] < generation]

    def where(self, step):
        """The constraints that the step uses."""
        return [self.lines(s)[0][0] for s in self.used(step) if s["kind"] == "constraint"]

    def sample(self, nodes):
        if not nodes:            # anywhere: each time another place
            return [self.a.random_values(1), self.a.random_values(2)]
        key = tuple(nodes)
        if key not in self.points and len(self.a.names) > MANY:
            raise Skipped
        if key not in self.points:
            found = self.a.sample(list(nodes), 2, self.digits)
            self.points[key] = [e for e in found if not any(0 < abs(e[n]) < mpmath.mpf(10) ** (-self.digits // 2) for n in self.a.names)]      # on x (x s - r) = 0 with x = 0 nothing is left of r/x
        if not self.points[key]:
            raise Skipped
        return self.points[key]

    def near_zero(self, x, size=1):
        return abs(x) <= self.tiny * size

    # Steps

    def used(self, step):
        if any(k >= step["n"] for k in step["uses"]):
            raise Wrong("uses a later step")
        return [self.steps[k - 1] for k in step["uses"]]

    def total(self, step, env):
        """The sum of the multiples at a point, and the other equations with velocities that it uses."""
        terms = step["combination"]
        n = len(self.a.names)
        sum_, rest, size = [mpmath.mpf(0)] * n, mpmath.mpf(0), mpmath.mpf(1)
        for t in terms:
            if t["factor"] is None:
                raise Skipped
            if t["step"] not in step["uses"]:
                raise Wrong("a term that is not used")
            f = self.value(self.side(t["factor"]), env)
            c, r, s = self.affine(self.lines(self.steps[t["step"] - 1])[0], env)
            sum_ = [x + f * y for x, y in zip(sum_, c)]
            rest += f * r
            size = max(size, abs(f) * s)
        others = []
        for s in self.used(step):
            if s["n"] in [t["step"] for t in terms] or s["kind"] not in ("given", "solve", "differentiate"):
                continue
            row = self.affine(self.lines(s)[0], env)
            if max(abs(x) for x in row[0]) > self.tiny:
                others.append(row)
        return sum_, rest, size, others

    def inserted(self, sum_, rest, size, others, extra=()):
        """What is left once the others are put in: (rest, size, weights of the extra columns). None: velocities stay."""
        columns = [r[0] for r in others] + [e for e in extra]
        if max(abs(x) for x in sum_) <= self.tiny * size and not extra:
            return rest, size, []
        if not columns:
            return None
        found = linear.solve([[c[j] for c in columns] for j in range(len(sum_))], sum_, self.tiny)
        if found is None:
            return None
        weights = found[0]
        taken = [w * r[1] for w, r in zip(weights, others)]
        return rest - sum(taken), max([size] + [abs(x) for x in taken]), weights[len(others):]

    def given(self, step):
        source = step["text"].split(",", 1)[1].strip()
        match = [k for k in self.named if source == k or source.startswith(k + ":")]
        if not match:
            raise Skipped
        node, sign = self.named[max(match, key=len)]
        for _ in range(40):
            env = self.a.random_values(1)
            speeds = {n: mpmath.mpf(self.a.rng.randint(-999, 999)) / 500 for n in self.a.names}
            env.update({k.split()[-1]: mpmath.mpf(0) for k in self.named if k.startswith("choice of ")})
            speeds.update({n: env[n + "'"] for n in self.a.names if n + "'" in env})     # where the velocity is a variable, equations may use it
            env = {**env, **{"@" + n: v for n, v in speeds.items()}, **{self.velocity[n]: v for n, v in speeds.items()}}
            try:
                left, right, _ = self.lines(step)[0]
                mine, theirs = self.value(left, env) - self.value(right, env), sign * self.value(node, env)
            except Undefined:
                continue
            if not self.near_zero(mine - theirs, 1 + abs(theirs) + abs(self.value(left, env))):
                raise Wrong(f"the equation is {mpmath.nstr(theirs, 6)} at a point, and not {mpmath.nstr(mine, 6)}")
            return
        raise Skipped

    def differentiate(self, step):
        (of,) = self.used(step)
        if of["kind"] != "constraint":
            raise Wrong("what is differentiated is no constraint")
        xi = self.lines(of)[0][0]
        for env in self.sample([]):
            env = {**env, self.a.problem.time: env[self.a.problem.time] + mpmath.mpf("0.0113")}      # off the kinks of cases that begin at one
            _, gradient, by_time, _ = self.a.row(xi, env, self.graph.cone([xi]))
            c, rest, size = self.affine(self.lines(step)[0], env)
            if any(not self.near_zero(x - y, size) for x, y in zip(c, gradient)) or not self.near_zero(rest - by_time, size + abs(by_time)):
                raise Wrong(f"it is not the derivative: {mpmath.nstr(rest, 6)} and {mpmath.nstr(by_time, 6)} besides the velocities")

    def at_sum(self, step):
        (left_side, right_side, _), = self.lines(step)
        for env in self.sample(self.where(step)):
            s = self.total(step, env)
            left = self.inserted(*s)
            if left is None:
                raise Wrong("velocities are left")
            should = self.value(left_side, env) - self.value(right_side, env)
            if not self.near_zero(left[0] - should, left[1] + abs(should)):
                raise Wrong(f"the sum leaves {mpmath.nstr(left[0], 6)}, not {mpmath.nstr(should, 6)}")

    def insert(self, step):
        self.at_sum(step)

    redundant = insert

    def zero_side(self, step):
        """The function that a step says is 0."""
        (xi, right, relation), = self.lines(step)
        if relation != "=" or self.value(right, {}) != 0:
            raise Wrong("its right side is not 0")
        return xi

    def constraint(self, step):
        before, after = step["dimension"]
        if before - after != 1:
            raise Wrong("the dimension does not fall by one")
        xi = self.zero_side(step)
        if "combination" in step:
            self.at_sum(step)
        else:
            self.vanishes(step, xi)
        if not any(s["kind"] == "constraint" for s in self.steps[step["n"]:]):
            self.independent(step)

    def vanishes(self, step, xi):
        """What the step came from vanishes where it does; a sum that is the constraint itself is so everywhere."""
        before = self.where(step)
        origin = [s for s in self.used(step) if s["kind"] in ("insert", "branch", "given")]
        if not origin:
            raise Wrong("it comes from nothing")
        together = [self.lines(s)[0][0] for s in self.steps if s["kind"] == step["kind"] and s["uses"][:1] == step["uses"][:1]]
        if step["kind"] == "constraint" and origin[0]["kind"] == "branch":
            together = [self.lines(origin[0])[0][0]]
        for env in self.sample(before + (together if step["basis"] != "identity" else [xi])):
            for s in origin:
                for left, right, _ in self.lines(s):
                    if not self.near_zero(self.value(left, env) - self.value(right, env), 1):
                        raise Wrong("what it came from does not vanish there")
        if step["basis"] == "identity":
            for env in self.sample(before):
                left, right, _ = self.lines(origin[0])[0]
                if not self.near_zero(self.value(left, env) - self.value(right, env) - self.value(xi, env), 1 + abs(self.value(xi, env))):
                    raise Wrong("it is another function than what it came from")

    def branch(self, step):
        if not step["uses"]:
            return           # special points: the constraints that it makes are looked at
        self.vanishes(step, self.zero_side(step))

    def independent(self, step):
        nodes = [self.lines(s)[0][0] for s in self.steps if s["kind"] == "constraint"]
        for env in self.sample(nodes):
            rows = [self.a.row(e, env, self.graph.cone([e]))[1] for e in nodes]
            if linear.rank(rows, self.tiny) != len(self.a.names) - step["dimension"][1]:
                raise Wrong("the differentials are not independent")

    def solve(self, step):
        if "combination" in step:
            self.solve_one(step)
        else:
            self.solve_all(step)

    def solve_one(self, step):
        left, right, _ = self.lines(step)[0]
        unit = self.affine((left, self.graph.const(0), "="), {})[0]
        if sorted(unit) != [0] * (len(unit) - 1) + [1]:
            raise Wrong("its left side is no velocity")
        for env in self.sample(self.where(step)):
            sum_, rest, size, others = self.total(step, env)
            left_over = self.inserted(sum_, rest, size, others, [unit])
            if left_over is None:
                raise Wrong("other velocities are left")
            factor, value = left_over[2][0], self.value(right, env)
            if self.near_zero(factor):
                raise Wrong("the velocity is not in the sum")
            if not self.near_zero(left_over[0] + factor * value, left_over[1] + abs(factor * value)):
                raise Wrong("with the value put in the equation does not hold")

    def solve_all(self, step):
        nodes = self.before(step["n"], 10 ** 6)
        for env in self.sample(nodes):
            here = {**env, **{f: mpmath.mpf(self.a.rng.randint(-999, 999)) / 400 for f in self.a.free or []}}
            for left, right, _ in self.lines(step):
                here[next(w for w in self.velocity.values() if self.graph.sym(w) == left)] = self.value(right, here)
            rows = []
            for s in self.used(step):
                line = self.lines(s)[0]
                c, rest, size = self.affine(line, env)
                rows.append(c)
                terms = [x * here[self.velocity[n]] for x, n in zip(c, self.a.names)]
                if not self.near_zero(rest + sum(terms), max([size] + [abs(t) for t in terms])):
                    raise Wrong(f"equation ({s['n']}) does not hold with the velocities put in")
            if len(self.a.names) - linear.rank(rows, self.tiny) != len(self.a.free or []):
                raise Wrong("there are as many free velocities as the rank leaves, and not as are said")

    def is_number(self, node):
        """Whether it has a value without that of any name."""
        try:
            self.value(node, {})
        except KeyError:
            return False
        return True

    def pivot(self, step):
        for left, right, relation in self.lines(step):
            if relation != "!=":
                raise Wrong("it does not say what is not zero")
            values = [abs(self.value(left, env) - self.value(right, env)) for env in self.sample(self.before(step["n"], 10 ** 6))]
            if max(values) <= self.tiny and self.is_number(left) and self.is_number(right):
                with mpmath.workdps(1000):       # a number may be as small as it likes
                    values = [v * self.tiny / mpmath.mpf(10) ** -900 for v in [abs(self.value(left, {}) - self.value(right, {}))]]
            if max(values) <= self.tiny:
                raise Wrong("it vanishes")

    def stop(self, step):
        if step["basis"] != self.a.result["verdict"]:
            raise Wrong(f"the verdict is {self.a.result['verdict']}")
        if step["n"] != len(self.steps):
            raise Wrong("steps come after it")
        if step["basis"] == "inconsistent" and step["gives"]:
            self.pivot(step)

    def chain(self):
        """Numbers and dimensions follow each other, and the constraints are those of the answer."""
        last = len(self.a.names)
        for i, s in enumerate(self.steps):
            if s["n"] != i + 1 or s["dimension"][0] != last or (s["kind"] != "constraint" and s["dimension"][1] != last):
                raise Wrong(f"({s['n']}): numbers or dimensions do not follow")
            last = s["dimension"][1]
        told = [(s["generation"], s["gives"]) for s in self.steps if s["kind"] == "constraint"]
        listed = [(c["generation"], f"{c['expression']} = 0") for c in self.a.result["constraints"]]
        if not self.a.result.get("definitions") and [t for t in told if t[1]] != [c for c, t in zip(listed, told) if t[1]]:
            raise Wrong("the constraints are not those of the answer")
        if len(told) != len(listed):
            raise Wrong("the answer has another number of constraints")

    def looked_at(self):
        if len(self.steps) <= LARGE:
            return self.steps
        few = self.a.rng.sample([s for s in self.steps if len(s["uses"]) < LARGE], LOOKED_AT) if sum(len(s["uses"]) < LARGE for s in self.steps) >= LOOKED_AT else []
        return sorted(few, key=lambda s: s["n"]) + ([] if self.steps[-1] in few else [self.steps[-1]])

    def check(self):
        """Messages of what is wrong; counts has how many of each kind were looked at."""
        wrong = []
        with mpmath.workdps(self.digits + 20):
            try:
                self.chain()
            except Wrong as e:
                wrong.append(str(e))
            for s in self.looked_at():
                try:
                    getattr(self, s["kind"])(s)
                    self.counts[s["kind"]] += 1
                except (Skipped, Undefined):
                    self.skipped[s["kind"]] += 1
                except Wrong as e:
                    wrong.append(f"({s['n']}) {s['kind']}: {e}")
        return wrong


def spoilt(steps):
    """(kind, what was done, derivation) for one step of each kind in several ways."""
    for kind in KINDS:
        for s in steps:
            if s["kind"] != kind:
                continue
            if s["gives"] and kind not in ("pivot", "stop") and not (kind == "branch" and not s["uses"]):
                t = copy.deepcopy(steps)
                lines = s["gives"].split("; ")
                fixed = [k for k, line in enumerate(lines) if not re.search(r"\bf\d", line)]
                if fixed:
                    lines[fixed[-1]] += " + 3/7"
                    t[s["n"] - 1]["gives"] = "; ".join(lines)
                    yield kind, "another equation", t
            others = [k["n"] for k in steps[:s["n"] - 1] if k["kind"] == ("constraint" if kind == "differentiate" else "insert") and k["n"] not in s["uses"] and k["gives"]]
            if kind in ("differentiate", "constraint") and len(s["uses"]) == 1 and others and s["gives"] and steps[s["uses"][0] - 1]["kind"] in ("constraint", "insert"):
                t = copy.deepcopy(steps)
                t[s["n"] - 1]["uses"] = [others[-1]]
                yield kind, "from another step", t
            if "combination" in s and s["gives"] and kind in ("insert", "constraint") and s["combination"][-1]["factor"] and steps[s["combination"][-1]["step"] - 1]["kind"] != "constraint":
                t = copy.deepcopy(steps)
                t[s["n"] - 1]["combination"][-1]["factor"] = f"({s['combination'][-1]['factor']}) - 3/5"
                yield kind, "another multiple", t
            if kind == "pivot" and s["gives"]:
                t = copy.deepcopy(steps)
                t[s["n"] - 1]["gives"] = "0 != 0"
                yield kind, "zero", t
            if kind == "stop":
                t = copy.deepcopy(steps)
                t[s["n"] - 1]["basis"] = "unique" if s["basis"] != "unique" else "underdetermined"
                yield kind, "another verdict", t
            if kind == "constraint":
                t = copy.deepcopy(steps)
                t[s["n"] - 1]["dimension"][1] -= 1
                yield kind, "another dimension", t
            if "combination" in s and s["combination"][0]["factor"] and s["gives"] and kind == "insert":
                t = copy.deepcopy(steps)
                t[s["n"] - 1]["combination"][0]["factor"] = f"({s['combination'][0]['factor']}) + 2/3"
                yield kind, "another factor", t
            if "combination" in s and s["gives"] and kind in ("insert", "solve") and len(s["uses"]) > len(s["combination"]) and "velocities that are left" not in s["text"]:
                t = copy.deepcopy(steps)
                t[s["n"] - 1]["uses"] = [c["step"] for c in s["combination"]]
                yield kind, "velocities not put in", t
            break


class Check:
    def __init__(self, solver, tally):
        self.solver, self.tally = solver, tally
        self.counts, self.seen, self.skipped, self.blind = ({k: 0 for k in KINDS} for _ in range(4))
        self.told = 0

    def run(self, case):
        name, expect = case["name"], case["expect"]
        request = {k: v for k, v in case["request"].items() if k in ("system", "trajectory", "limits")}
        request["want"] = WANT
        try:
            result, problem = self.solver.solve(request)
        except Crash as e:
            self.tally.check(False, name, str(e))
            return
        if result is None:
            self.tally.check(problem["code"].startswith(("limit", "undecided", "irregular", "split", "no_")), name, f"refused: {problem}")
            return
        try:
            answer = Answer(request, result, digits=max(DIGITS, expect.get("digits", 0)), near=expect.get("near"), parameters=expect.get("parameters"), points=2, primary=expect.get("primary"))
        except Broken as e:
            self.tally.check(False, name, str(e))
            return
        steps = result["derivation"]["steps"]
        replay = Replay(answer, steps)
        wrong = replay.check()
        if wrong and (not expect.get("identities", True) or " on the part of " in steps[-1]["text"] or " on the side of " in steps[-1]["text"]
                      or any("point" in s for s in result.get("strata", []))):
            print(f"not judged: {name}: the answer is that of a part of the set, and points are looked for on all of it: {wrong[0]}", flush=True)
            return
        self.tally.check(not wrong, name, "; ".join(wrong[:3]))
        self.told += len(steps)
        for k in KINDS:
            self.counts[k] += replay.counts[k]
            self.skipped[k] += replay.skipped[k]
        if wrong or len(steps) > 60:
            return
        for kind, what, bad in spoilt(steps):
            if self.seen[kind] >= 12 or not replay.counts[kind]:
                continue
            again = Replay(answer, bad)
            again.points = replay.points
            found = again.check()
            if found or again.counts[kind] == replay.counts[kind]:     # otherwise it could not be looked at
                self.tally.check(bool(found), f"{name}: a spoilt step of the kind {kind}", f"{what} is not seen")
                self.seen[kind] += 1
            else:
                self.blind[kind] += 1


def share(listed, taken, out, counts):
    sys.stdout = out
    tally = Tally("derivation")
    check = Check(Solver(build_folder()), tally)
    for case in waiting(listed, taken):
        if os.environ.get("SGA_TEST_VERBOSE"):
            print("#", case["name"], flush=True)
        try:
            check.run(case)
        except Exception as e:
            tally.check(False, case["name"], f"checker: {type(e).__name__}: {e}")
    for i, k in enumerate(KINDS):
        with counts.get_lock():
            for part, told in enumerate((check.counts, check.seen, check.skipped, check.blind)):
                counts[part * len(KINDS) + i] += told[k]
    print(tally.passed, tally.failed, flush=True)


def main():
    tally = Tally("derivation")
    listed = [c for c in load(sys.argv[2:]) if "error" not in c["expect"] and "request" in c and c["request"]["system"].get("form") != "operator" and not c["request"]["system"].get("modes")]
    every = 1 if sys.argv[2:] else int(os.environ.get("SGA_TEST_EVERY", "12"))
    listed = listed[int(os.environ.get("SGA_TEST_SEED", "7")) % every::every]
    listed.sort(key=lambda case: len(json.dumps(case)), reverse=True)
    taken, counts = multiprocessing.Value("i", 0), multiprocessing.Array("i", 4 * len(KINDS))
    workers = 2
    with contextlib.ExitStack() as stack:
        out = [stack.enter_context(tempfile.TemporaryFile("w+", encoding="utf-8")) for _ in range(workers)]
        running = [multiprocessing.Process(target=share, args=(listed, taken, out[k], counts)) for k in range(workers)]
        for w in running:
            w.start()
        for k, w in enumerate(running):
            w.join()
            out[k].seek(0)
            *said, last = out[k].read().splitlines() or [""]
            print("\n".join(said), end="\n" if said else "")
            if tally.check(w.exitcode == 0, f"worker {k}", f"ended with {w.exitcode}: {last}"):
                passed, failed = map(int, last.split())
                tally.passed += passed
                tally.failed += failed
    for part, what in enumerate(("steps looked at", "spoilt steps seen", "steps that could not be looked at (no text, no points, too many variables)", "spoilt steps that could not be looked at")):
        print(f"{what}:", ", ".join(f"{k} {counts[part * len(KINDS) + i]}" for i, k in enumerate(KINDS)))
    if not sys.argv[2:]:
        for i, k in enumerate(KINDS):
            tally.check(counts[i] > 0 and counts[len(KINDS) + i] > 0, f"steps of the kind {k}", f"{counts[i]} looked at, {counts[len(KINDS) + i]} spoilt")
    return tally.end()


if __name__ == "__main__":
    sys.exit(main())
