"""Starts against a search of their own: start_check.py BUILD_DIR

Random bodies on random quadrics, some coordinates and velocities given: the start must be the limit of nearest points as the
tiers' weights go to 0 one after the other, which Newton's method on Lagrange's conditions finds here: in floats with weights
1, 10^-4 and 10^-8 from many places, and from the nearest of what that finds in 60 digits with 1, 10^-14 and 10^-28. And every start of the corpus's own cases, in six orders of variables and
equations, is the same to 1e-9. Starts in units in which coordinates are large. A part of the values of a point of the set is kept, whatever branches of products
there are, in any order. SGA_TEST_SEED repeats a run, SGA_TEST_SCALE makes it longer."""
import itertools
import json
import math
import os
import random
import sys

import mpmath as mp

import endings_check
from solver import Solver
from tally import ROOT, Tally, build_folder, scaled, seed

ROUGH, WEIGHT = 1e-4, mp.mpf(10) ** -14
SEARCHES = 30


class Quadrics:
    """g_k = q S_k q + l_k q - r_k = 0 for n coordinates, with accelerations along the gradients."""

    def __init__(self, rng, n, count):
        self.n, self.S, self.l, self.r = n, [], [], []
        point = [rng.randint(-4, 4) / 2 for _ in range(n)]
        for _ in range(count):
            S = [[0] * n for _ in range(n)]
            for i in range(n):
                S[i][i] = rng.randint(1, 4)
                for j in range(i):
                    S[i][j] = S[j][i] = rng.choice([0, 0, 0.5])
            l = [rng.randint(-3, 3) for _ in range(n)]
            self.S.append(S)
            self.l.append(l)
            self.r.append(self.value(S, l, point))
        self.names = [f"q{i}" for i in range(n)]

    @staticmethod
    def value(S, l, q):
        n = len(q)
        return sum(q[i] * S[i][j] * q[j] for i in range(n) for j in range(n)) + sum(a * b for a, b in zip(l, q))

    def gradient(self, k, q):
        return [2 * sum(self.S[k][i][j] * q[j] for j in range(self.n)) + self.l[k][i] for i in range(self.n)]

    def text(self, k, i=None):
        q, S, l = self.names, self.S[k], self.l[k]
        if i is not None:
            return " + ".join([f"{2 * S[i][j]}*{q[j]}" for j in range(self.n) if S[i][j]] + [f"({l[i]})"])
        terms = [f"{S[i][j]}*{q[i]}*{q[j]}" for i in range(self.n) for j in range(self.n) if S[i][j]]
        return " + ".join(terms + [f"({l[i]})*{q[i]}" for i in range(self.n)])

    def system(self):
        count = len(self.S)
        moves = [f"{q}'' = -9.81*{int(i == 0)} - (" + " + ".join(f"l{k}*({self.text(k, i)})" for k in range(count)) + ")"
                 for i, q in enumerate(self.names)]
        return {"form": "equations", "variables": self.names + [f"l{k}" for k in range(count)],
                "equations": moves + [f"{self.text(k)} = {self.r[k]}" for k in range(count)]}


def conditions(s, z, guess, weight):
    """Lagrange's conditions and their derivative, z = coordinates, velocities, two multipliers for each constraint."""
    n, c = s.n, len(s.S)
    q, v, a, b = z[:n], z[n:2 * n], z[2 * n:2 * n + c], z[2 * n + c:]
    size = 2 * n + 2 * c
    f, J = [0] * size, [[0] * size for _ in range(size)]
    for i in range(2 * n):
        f[i] = weight[i] * (z[i] - guess[i])
        J[i][i] = weight[i]
    for k in range(c):
        g, S = s.gradient(k, q), s.S[k]
        along = [2 * sum(S[i][j] * v[j] for j in range(n)) for i in range(n)]
        f[2 * n + k] = s.value(S, s.l[k], q) - s.r[k]
        f[2 * n + c + k] = sum(x * y for x, y in zip(g, v))
        for i in range(n):
            f[i] += a[k] * g[i] + b[k] * along[i]
            f[n + i] += b[k] * g[i]
            J[i][2 * n + k] = J[2 * n + k][i] = J[n + i][2 * n + c + k] = J[2 * n + c + k][n + i] = g[i]
            J[i][2 * n + c + k] = J[2 * n + c + k][i] = along[i]
            for j in range(n):
                J[i][j] += 2 * a[k] * S[i][j]
                J[i][n + j] += 2 * b[k] * S[i][j]
                J[n + i][j] += 2 * b[k] * S[i][j]
    return f, J


def solve(A, b):
    """A x = b by elimination with pivots, in whatever numbers they are; None where a pivot is 0."""
    n = len(b)
    rows = [list(r) + [x] for r, x in zip(A, b)]
    for k in range(n):
        p = max(range(k, n), key=lambda i: abs(rows[i][k]))
        if not rows[p][k]:
            return None
        rows[k], rows[p] = rows[p], rows[k]
        for i in range(k + 1, n):
            m = rows[i][k] / rows[k][k]
            if m:
                rows[i] = [x - m * y for x, y in zip(rows[i], rows[k])]
    x = [0] * n
    for k in reversed(range(n)):
        x[k] = (rows[k][n] - sum(rows[k][j] * x[j] for j in range(k + 1, n))) / rows[k][k]
    return x


def newton(s, z, guess, weight, end, steps=100):
    """A zero of the conditions, or None."""
    for _ in range(steps):
        f, J = conditions(s, z, guess, weight)
        d = solve(J, f)
        if d is None:
            return None
        longest = max(abs(x) for x in d[:2 * s.n])
        part = min(1, 1 / longest) if longest else 1
        z = [x - part * y for x, y in zip(z, d)]
        if longest < end:
            return z
    return None


def multipliers(s, z, guess, weight):
    """Those that fit a point best, by normal equations."""
    n, c = s.n, len(s.S)
    f, J = conditions(s, list(z) + [0] * (2 * c), guess, weight)
    N = [[J[i][2 * n + k] for i in range(2 * n)] for k in range(2 * c)]
    return [-x for x in solve([[sum(x * y for x, y in zip(p, q)) for q in N] for p in N], [sum(x * y for x, y in zip(p, f)) for p in N])]


def scores(z, guess, tier):
    return [sum((x - g) ** 2 for x, g, t in zip(z, guess, tier) if t == k) for k in range(3)]


def farther(a, b):
    """Whether a is worse than b, tier by tier."""
    for x, y in zip(a, b):
        if abs(x - y) > 1e-9 * (1 + y):
            return x > y
    return False


def body(tally, rng, solver, number):
    n = rng.choice([2, 3, 3])
    s = Quadrics(rng, n, rng.randint(1, n - 1))
    names = s.names + [q + "'" for q in s.names]
    # velocities beside some places alone may have no nearest point at an edge of the quadric
    given = rng.sample(s.names, rng.randint(1, n)) if rng.random() < 0.5 else s.names + rng.sample(names[n:], rng.randint(0, n))
    given = {x: rng.randint(-6, 6) / 2 for x in given}
    label = f"body {number}: {json.dumps(s.system())} {json.dumps(given)}"
    request = {"system": s.system(), "want": ["consistent_initial"], "trajectory": {"start": 0, "initial": given}}
    result, problem = solver.solve(request)
    if not tally.check(problem is None, label, problem):
        return
    mp.mp.dps = 60
    guess = [given.get(x, 0) for x in names]
    tier = [0 if x in given else 1 if "'" not in x else 2 for x in names]
    weight, rough = ([w ** t for t in tier] for w in (WEIGHT, ROUGH))
    found = [mp.mpf(result["consistent_initial"]["projected"][x]) for x in names]
    best = None
    for _ in range(SEARCHES):
        z = [g + rng.uniform(-3, 3) for g in guess] + [rng.uniform(-1, 1) for _ in range(2 * len(s.S))]
        z = newton(s, z, guess, rough, 1e-7)
        total = z and sum(w * (x - g) ** 2 for w, x, g in zip(rough, z, guess))
        if z and (best is None or total < best[0]):
            best = total, z
    best = best and newton(s, [mp.mpf(x) for x in best[1]], guess, weight, 1e-25)
    there = best and [mp.nstr(x, 12) for x in best[:2 * n]]
    tally.check(not best or not farther(scores(found, guess, tier), scores(best, guess, tier)),
                f"{label}: none is nearer", f"{there} than {[mp.nstr(x, 12) for x in found]}")
    z = newton(s, found + multipliers(s, found, guess, weight), guess, weight, 1e-25)
    off = z and max(abs(x - y) for x, y in zip(z, found))
    tally.check(z is not None and off < 1e-8, f"{label}: Lagrange's conditions", off and mp.nstr(off, 3))


def orders(tally, rng, solver):
    for name in ("start_tiers", "consistent"):
        with open(os.path.join(ROOT, "tests", "cases", name + ".json"), encoding="utf-8") as f:
            cases = json.load(f)
        for case in cases:
            request = case["request"]
            if "error" in case["expect"] or request["system"]["form"] != "equations" or "consistent_initial" not in request["want"]:
                continue
            first, _ = solver.solve(request)
            for turn in range(6):
                system = dict(request["system"])
                for key in ("variables", "equations"):
                    system[key] = rng.sample(system[key], len(system[key]))
                again, problem = solver.solve({**request, "system": system})
                label = f"{case['name']}: order {turn}: {system['variables']} {system['equations']}"
                if not tally.check(problem is None, label, problem):
                    continue
                a, b = (r["consistent_initial"]["projected"] for r in (first, again))
                off = max(abs(a[x] - b[x]) / (1 + abs(a[x])) for x in a)
                tally.check(off < 1e-9, label, off)
                tally.check(set(first["consistent_initial"]["free"]) == set(again["consistent_initial"]["free"]), label + ": free", again["consistent_initial"]["free"])


def beyond(tally, solver):
    """Starts whose constraints hold only beyond a pole from what was given, or at places that steps from there miss: the same in all orders, and states stay as they
    are given where algebraic variables can adapt."""
    def of(y):
        return y * y + 1
    found = [(["-x^2 + 2/(y - 5/2) = 1", "x' = y^2"], {"x": x, "y": y}, {"x": x, "y": 2.5 + 2 / of(x)}) for x, y in ((2.83, 0.64), (-1.5, -1), (0.3, 1.2), (3.5, 2))]
    found += [(["2*x1 + 1/(x1 - 5/2) + x1*cos(x1) + 2*x3*exp(x3/2) = -1", "-x2 + 3/(2*(x3 - 5/2)) = 1", "x2' = -x2/2"], {"x1": -2.39, "x2": 1.27, "x3": -2.67}, {})]
    for equations, initial, expected in found:
        answers = []
        for names in itertools.permutations(sorted(initial)):
            for order in (equations, equations[::-1]):
                request = {"system": {"form": "equations", "variables": list(names), "equations": order}, "want": ["consistent_initial"],
                           "trajectory": {"initial": {n: initial[n] for n in names}, "stop": 1, "samples": 2}}
                result, problem = solver.solve(request)
                answers.append(result and result["consistent_initial"]["projected"])
        label = f"beyond {equations} {initial}"
        tally.check(all(answers) and all(abs(a[n] - answers[0][n]) < 1e-9 for a in answers for n in initial), f"{label}: the same in all orders", answers)
        tally.check(all(a and all(abs(a[n] - v) < 1e-9 for n, v in expected.items()) for a in answers), f"{label}: states stay", (expected, answers[0], problem))


def large(tally, solver):
    """A pendulum in small units: its circle is met to a rounding of L^2, which is far from 0 as a number."""
    for length in (5e5, 1e6, 1e7, 1e9):
        for off in (1.02, 0.97):
            result, fault = solver.solve({"system": {
                "form": "equations", "variables": ["x", "y", "vx", "vy", "l"], "parameters": {"g": repr(9.81 * length), "L": repr(off * length)},
                "equations": ["x' = vx", "y' = vy", "vx' = -l*x", "vy' = -l*y - g", "x^2 + y^2 = L^2"]}, "want": ["consistent_initial"],
                "trajectory": {"initial": {"x": repr(0.6 * length), "y": repr(-0.8 * length), "vx": 0}}})
            name = f"a pendulum of length {length} that is off by {off}"
            if not tally.check(result, name, str(fault)):
                continue
            x, y = (result["consistent_initial"]["projected"][n] / length for n in "xy")
            tally.check(abs(x * x + y * y - off * off) < 1e-12, name, f"{x} {y}")


def hung(rng):
    """A chain of rods at right angles, with places and velocities as a program computes them: 6e-17 for cos(pi/2). The request, and the same with zeros."""
    n, unit = rng.randint(1, 3), 10.0 ** rng.choice([0, 0, 0, -6, -3, 3, 6])
    form, gravity = rng.choice(["squares", "distances", "directions", "reciprocals", "factors"]), rng.choice([9.81, 0, 0])     # without it nothing else tells a size
    at, speed, place, rate, equations, initial = [0, 0], [0, 0], [], [], [], {}
    names = [c + str(i) for c in "xyl" for i in range(n)]
    length = [unit * rng.choice([0.5, 1, 1.25, 2]) for _ in range(n)]
    for i in range(n):
        angle, turn = math.pi / 2 * rng.choice([0, 1, 1, 2, -1, 3]), rng.choice([0, 1.7, -3, rng.uniform(-4, 4)])
        at = [at[0] + length[i] * math.sin(angle), at[1] - length[i] * math.cos(angle)]
        speed = [speed[0] + length[i] * math.cos(angle) * turn, speed[1] + length[i] * math.sin(angle) * turn]
        place.append(at)
        rate.append(speed)
        initial |= {f"x{i}": at[0], f"y{i}": at[1], f"x{i}'": speed[0], f"y{i}'": speed[1]}
        dx, dy = (f"({c}{i} - {c}{i - 1})" if i else f"{c}{i}" for c in "xy")
        square, size = f"({dx}^2 + {dy}^2)", f"{length[i]!r}"
        equations += {"squares": [f"{square} = {size}^2"], "distances": [f"r{i}^2 = {square}", f"r{i} = {size}"],
                      "directions": [f"{size}*c{i} = {dx}", f"{size}*s{i} = {dy}", f"c{i}^2 + s{i}^2 = 1"], "reciprocals": [f"1/{square} = 1/{size}^2"],
                      "factors": [f"({square} - {size}^2)*exp(x{i}/{unit!r}) = 0"]}[form]
        names += {"distances": [f"r{i}"], "directions": [f"c{i}", f"s{i}"]}.get(form, [])
        initial |= {f"r{i}": length[i]} if form == "distances" else {}
    for i in range(n):
        for c in "xy":
            pull = [f"l{i}*({c}{i}" + (f" - {c}{i - 1})" if i else ")")] + ([f"(-l{i + 1}*({c}{i + 1} - {c}{i}))"] if i + 1 < n else [])
            equations.append(f"{c}{i}'' = -({' + '.join(pull)}){f' - {gravity * unit!r}' if c == 'y' else ''}")
    rng.shuffle(names)
    rng.shuffle(equations)
    request = {"system": {"form": "equations", "variables": names, "equations": equations}, "want": ["trajectory"],
               "trajectory": {"stop": 0.5, "samples": 3, "initial": initial}, "accuracy": {"rtol": 1e-9, "arithmetic": rng.choice(["auto", "auto", "double-double"])}}
    sizes = {k: max(abs(v) for v in initial.values()) if "'" in k else unit for k in initial}
    return request, {k: 0.0 if abs(v) < 1e-14 * sizes[k] else v for k, v in initial.items()}, sizes


def roundings(tally, rng, solver, number):
    """Given values that are roundings of 0 stay with all others, and the motion is that of zeros."""
    request, zeros, sizes = hung(rng)
    label = f"roundings {number}: {request['system']['equations']}, {request['trajectory']['initial']}"
    (result, problem), (plain, _) = solver.solve(request), solver.solve({**request, "trajectory": {**request["trajectory"], "initial": zeros}})
    if not tally.check(result is not None and plain is not None, label, str(problem)):
        return
    told, motion, other = result["trajectory"]["initial"], result["trajectory"], plain["trajectory"]
    worst = max(abs(told["projected"][k] - v) / sizes[k] for k, v in told["given"].items())
    tally.check(worst < 1e-14, label, f"moved by {worst} of its size: {told['projected']}")
    for a, b, errors in zip(motion["rows"], other["rows"], zip(motion["errors"], other["errors"])):
        column = max((abs(x - y), motion["columns"][i]) for i, (x, y) in enumerate(zip(a, b)) if motion["columns"][i] in sizes)
        tally.check(column[0] <= 2 * sum(errors) + 1e-11 * sizes[column[1]], label, f"at {a[0]} {column} from the motion of zeros, errors {errors}")


def hardly_moving(tally, rng, solver, number):
    """One velocity of a chain is a little off what its rods allow, beside others that are large: a start is near, by places that move as little
    where their rods turn, by a place and a velocity of another rod, each the root of it, where they do not."""
    request, zeros, sizes = hung(rng)
    initial = {**request["trajectory"]["initial"]}
    largest = max(abs(v) for k, v in initial.items() if "'" in k)
    still = [k for k in zeros if "'" in k and zeros[k] == 0]
    if largest == 0 or not still or sizes["x0"] != 1:      # beside sizes far from 1 a move by 1 may be a large one
        return
    off = 10 ** -rng.uniform(6, 13)
    initial[rng.choice(still)] = off * largest * rng.choice([1, -1])
    request["trajectory"] |= {"initial": initial, "stop": 1e-6, "samples": 2}
    label = f"hardly moving {number}: {request['system']['equations']}, {initial}"
    result, problem = solver.solve(request)
    if tally.check(result is not None, label, str(problem)):
        told = result["trajectory"]["initial"]["projected"]
        far = max((abs(told[k] - v) / sizes[k], k) for k, v in initial.items())
        tally.check(far[0] <= 10 * off ** 0.5, label, f"{off} off, and the start {far} away: {told}")


def in_any_order(rng, solver, names, equations, given):
    names, equations = list(names), list(equations)
    rng.shuffle(names)
    rng.shuffle(equations)
    return solver.solve({"system": {"form": "equations", "variables": names, "equations": equations}, "want": ["index", "trajectory"],
                         "trajectory": {"stop": 0.01, "samples": 2, "initial": given}})


def parts(tally, rng, solver, number):
    """Values of a point of the set are given again without the others: the start keeps them, or is refused alike in all orders."""
    names, equations, place = endings_check.system(rng)
    whole, _ = in_any_order(rng, solver, names, equations, place)
    if whole is None or whole["verdict"] in ("isolated", "inconsistent"):
        return
    point = whole["trajectory"]["initial"]["projected"]
    given = {k: point[k] for k in rng.sample(names, rng.randint(1, len(names) - 1))}
    told = []
    for _ in range(3):
        part, refusal = in_any_order(rng, solver, names, equations, given)
        moved = part and max(abs(part["trajectory"]["initial"]["projected"][k] - v) / (1 + abs(v)) for k, v in given.items())
        told.append(refusal["code"] if refusal else "kept" if moved < 1e-6 else f"moved by {moved}")
    tally.check(len(set(told)) == 1 and "moved" not in told[0], f"part {number} of a start", f"{told}: {names}, {equations}, {given}")


def hinge(tally, rng, solver):
    """A crank that turns and bars behind it: b has two rates that agree, b (b' - a) = 0 comes with bars whose angles are not given, and b = 0 is no branch of a start on the circle."""
    bars = ["cos(p) + 2*cos(q) = 2 + 2*sin(b)/20", "sin(p) + 2*sin(q) = 1", "c = p''", "a^2 + b^2 = 1", "a' = -b"]
    for _ in range(6):
        part, refusal = in_any_order(rng, solver, ["a", "b", "c", "p", "q"], bars, {"a": 0.6, "b": 0.8})
        start = part and part["trajectory"]["initial"]["projected"]
        tally.check(part and part["verdict"] == "unique" and part["dimensions"]["final"] == 1 and start["a"] == 0.6 and start["b"] == 0.8, "a crank and bars", str(refusal or start))


def linkage(tally, rng, solver, number):
    """Three bars that close, the angle of one given: it stays, and of the two ways in which the others can lie, and their turns, the nearest to their guess is taken."""
    length, angle = [round(rng.uniform(0.5, 2), 3) for _ in range(3)], [rng.uniform(-3, 3) for _ in range(3)]
    x, y = (sum(a * f(q) for a, q in zip(length, angle)) for f in (math.cos, math.sin))
    held = rng.randrange(3)
    (a, b), u, v = [length[k] for k in range(3) if k != held], x - length[held] * math.cos(angle[held]), y - length[held] * math.sin(angle[held])
    reach, nearest = math.hypot(u, v), math.inf
    for side in (1, -1):
        first = math.atan2(v, u) + side * math.acos(max(-1, min(1, (a * a + reach * reach - b * b) / (2 * a * reach))))
        nearest = min(nearest, math.hypot(math.remainder(first, 2 * math.pi), math.atan2(v - a * math.sin(first), u - a * math.cos(first))))
    names, loop = ["q0", "q1", "q2"], [" + ".join(f"{a}*{f}(q{k})" for k, a in enumerate(length)) + f" - ({at!r})" for f, at in (("cos", x), ("sin", y))]
    rng.shuffle(names)
    rng.shuffle(loop)
    result, problem = solver.solve({"system": {"form": "lagrangian", "coordinates": names, "lagrangian": "q0'^2/2 + q1'^2 + q2'^2/2 - sin(q0)", "holonomic": loop},
                                    "want": ["trajectory"], "trajectory": {"stop": 0.01, "samples": 2, "initial": {f"q{held}": angle[held]}}})
    start = result and result["trajectory"]["initial"]["projected"]
    if not tally.check(result and abs(start[f"q{held}"] - angle[held]) < 1e-9, f"linkage {number}: it stays", str(problem or start)):
        return 0
    return math.hypot(*(start[f"q{k}"] for k in range(3) if k != held)) < nearest * (1 + 1e-6) + 1e-6


def main():
    tally = Tally("start")
    rng = random.Random(seed(20261122))
    solver = Solver(build_folder())
    orders(tally, rng, solver)
    beyond(tally, solver)
    for number in range(scaled(12)):
        body(tally, rng, solver, number)
    large(tally, solver)
    for number in range(scaled(25)):
        roundings(tally, rng, solver, number)
    for number in range(scaled(60)):
        hardly_moving(tally, rng, solver, number)
    hinge(tally, rng, solver)
    linkages = scaled(60)
    near = sum(linkage(tally, rng, solver, number) for number in range(linkages))
    tally.check(near >= 0.9 * linkages, "linkages: nearly all as near as can be", f"{near} of {linkages}")
    for number in range(scaled(40)):
        parts(tally, rng, solver, number)
    return tally.end()


if __name__ == "__main__":
    sys.exit(main())
