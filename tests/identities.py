"""The answer checked against the definition of the reduction, at points, to many digits.

Nothing is taken from the C code but its printed answer. The reduction is

    P_{k+1} = { m in P_k : some v in T_m P_k has A(m) v = alpha(m) }        (P_0 = M)

so for each generation of printed constraints we look, at random points found by our
own Newton iteration:
  * on P_{k+1} the equations A v = alpha, d xi v = -d_t xi have a solution v;
  * at points of P_k where all but one of the new constraints hold they have none
    (so every constraint is necessary);
  * the differentials of all constraints are independent (so the dimensions are right);
and on Pf that X + sum f Z solves the equations and is tangent for any f, that each Z
lies in ker A and TPf, and that there are as many of them as dim(ker A intersected TPf).
"""
import random
from fractions import Fraction

import mpmath

import linear
from expression import EXACT, FLOAT, Graph, Undefined, evaluate
from problem import Problem


ORDERS = 16    # derivatives of tables that answers may use


class Broken(Exception):
    """An identity does not hold."""


class Answer:
    """A result's texts, parsed into the problem's own graph."""

    def __init__(self, request, result, seed=1, digits=50, near=None, parameters=None, points=3,
                 where=(), primary=None):
        self.result = result
        self.digits = digits
        self.rng = random.Random(seed)
        listed = [v["name"] for v in result["variables"]] if "variables" in result else None
        self.problem = p = Problem(request, listed if request["system"]["form"] == "equations" else None, primary,
                                   result.get("regularity", {}).get("redundant", ()) or result.get("evidence", {}).get("redundant_holonomic", ()), result.get("regularity", {}).get("conditions", ()))
        self.names = listed or p.names
        if p.form == "mechanical" and not result.get("regularity", {}).get("own_conditions", True):
            p.names += [n for n in self.names if n not in p.names]    # multipliers of conditions that were found
        if sorted(self.names) != sorted(p.names):
            raise Broken(f"variables are {self.names}, not {p.names}")
        g = self.graph = p.graph
        for d in result.get("definitions", []):
            g.define(d["name"], d["expression"])
        # a stratum is the same system restricted to functions that vanish there
        p.restrict = p.restrict + [g.parse(e) for e in list(where) + result.get("where", [])]
        self.constraints = [(c["generation"], g.parse(c["expression"])) for c in result.get("constraints", [])]
        self.field = self.free = None
        if "vector_field" in result:
            f = result["vector_field"]
            self.free = f["free"]
            self.field = {n: g.parse(e) for n, e in f["components"].items()}
        self.gauge = None
        if "gauge" in result:
            self.gauge = [{n: g.parse(e) for n, e in z.items()} for z in result["gauge"]["fields"]]
        self.motions = None
        if "acceleration" in result:
            self.motions = {k: [g.parse(e) for e in result["acceleration"][k]] for k in ("total", "tangent", "orthogonal")}
            self.motions["reaction"] = [g.parse(e) for e in result["reaction"]]
        self.fixed = {k: str(v) for k, v in (parameters or {}).items()}
        self.near = near or {}
        self.points = points

    # Points

    def random_values(self, spread):
        env = {p.strip(): mpmath.mpf(self.rng.randint(500, 1999)) / 1000 for p in self.problem.parameters}
        for k, v in self.fixed.items():
            env[k] = evaluate(v)
        env[self.problem.time] = mpmath.mpf(self.rng.randint(-999, 999)) / 700
        if self.problem.time in self.near:
            env[self.problem.time] = evaluate(str(self.near[self.problem.time]))
        for n in self.problem.tables:
            for k in range(ORDERS):
                env[n + "'" * k] = mpmath.mpf(self.rng.choice((-1, 1)) * self.rng.randint(300, 1999)) / 1000
        for n in self.names:
            env[n] = mpmath.mpf(self.rng.randint(-9999, 9999)) / 10000 * spread
            if n in self.near:
                near = evaluate(str(self.near[n]))
                env[n] = near + env[n] / 10 * min(1, max(abs(near), mpmath.mpf("0.01")))
        return env

    def row(self, e, env, cone):
        """Value, gradient by variable and partial time derivative of a node."""
        value = self.graph.values(cone, env, EXACT)
        d = self.graph.gradient(e, value, EXACT)
        by_time = d.get(self.problem.time, mpmath.mpf(0))
        for n in self.problem.tables:
            by_time += sum(d[n + "'" * k] * env[n + "'" * (k + 1)] for k in range(ORDERS - 1) if n + "'" * k in d)
        return value[e], [d.get(n, mpmath.mpf(0)) for n in self.names], by_time, d

    def rough(self, nodes, env, steps):
        """Moves the variables near the common zeros in plain doubles, each step shortened until
        the residual falls: Newton alone may wander for ever in a narrow valley. None: not near."""
        cones = [self.graph.cone([e]) for e in nodes]
        env = {k: float(v) for k, v in env.items()}

        def residuals(at):
            out = []
            for e, c in zip(nodes, cones):
                value = self.graph.values(c, at, FLOAT)
                d = self.graph.gradient(e, value, FLOAT)
                out.append((value[e], [d.get(n, 0.0) for n in self.names]))
            return out

        def size(rows, steep):
            return max([abs(r[0]) / s for r, s in zip(rows, steep)], default=0.0)
        try:
            rows = residuals(env)
            for _ in range(steps):
                steep = [max(abs(d) for d in r[1]) for r in rows]
                if any(s == 0 for s in steep):
                    return None
                now = size(rows, steep)
                if now < 1e-9:
                    return env
                move = linear.least_norm([[d / s for d in r[1]] for r, s in zip(rows, steep)], [-r[0] / s for r, s in zip(rows, steep)], 1e-10)
                if not move:
                    return None
                part = min(1.0, 2 / (max(abs(a) for a in move) or 1.0))
                for _ in range(12):
                    try:
                        there = {**env, **{n: env[n] + part * a for n, a in zip(self.names, move)}}
                        tried = residuals(there)
                        if size(tried, steep) < now * (1 - part / 8):
                            break
                    except Undefined:
                        pass
                    part /= 2
                else:
                    return None
                env, rows = there, tried
        except (Undefined, OverflowError, ZeroDivisionError):
            pass
        return None

    def newton(self, nodes, env, digits):
        """Moves the variables onto the common zeros of the nodes, or None."""
        cones = [self.graph.cone([e]) for e in nodes]
        last = None
        for step in range(80):
            with mpmath.workdps(digits + 15 if step > 12 else 30):
                try:
                    rows = [self.row(e, env, c) for e, c in zip(nodes, cones)]
                except Undefined:
                    return None
                steep = [max(abs(d) for d in r[1]) for r in rows]
                if any(s == 0 for s in steep):
                    return None
                size = max([mpmath.mpf(0)] + [abs(r[0]) / s for r, s in zip(rows, steep)])
                if size < mpmath.mpf(10) ** (-digits):
                    return env
                move = linear.least_norm([[d / s for d in r[1]] for r, s in zip(rows, steep)],
                                         [-r[0] / s for r, s in zip(rows, steep)], mpmath.mpf(10) ** -14)
                big = max(abs(a) for a in move) if move else 0
                if big == 0:
                    return None
                damp = min(mpmath.mpf(1), 1 / big)
                if last is not None and size > 1e6 * last:
                    return None
                last = size
                env = dict(env)
                for n, a in zip(self.names, move):
                    env[n] += damp * a
        return None

    def sample(self, nodes, count, digits=None):
        """Points where the nodes vanish, with everything printed and given defined there."""
        digits = digits or self.digits
        found = []
        for attempt in range(60 + 30 * count):
            spread = (1, 2, 0.5, 4)[attempt % 4]
            with mpmath.workdps(digits + 15):
                env = self.random_values(spread)
                near = self.rough(nodes, env, 3000 if attempt in (30, 75) else 60) if nodes else None
                env = self.newton(nodes, {k: mpmath.mpf(v) for k, v in near.items()} if near else env, digits)
                if env is None:
                    continue
                try:
                    self.equations(env)
                    for _, e in self.constraints:
                        self.row(e, env, self.graph.cone([e]))
                    if not self.on_sides(env):
                        continue
                except Undefined:
                    continue
            found.append(env)
            if len(found) == count:
                break
        return found

    def on_sides(self, env):
        """Whether the point is where the answer says that it holds (evidence.sides)."""
        for s in self.result.get("evidence", {}).get("sides", []):
            e = self.graph.parse(s["function"])
            value = self.graph.values(self.graph.cone([e]), env, EXACT)[e]
            if (value > 0) != (s["sign"] == "positive"):
                return False
        return True

    # The linear system at a point

    def equations(self, env):
        """A and alpha at a point, from the residuals r(v) = A v - alpha, affine in v."""
        g = self.graph
        speed = {"@" + n: mpmath.mpf(0) for n in self.names}
        here = {**env, **speed}
        A, alpha = [], []
        for r in self.problem.rows:
            cone = g.cone([r])
            value = g.values(cone, here, EXACT)
            d = g.gradient(r, value, EXACT)
            A.append([d.get("@" + n, mpmath.mpf(0)) for n in self.names])
            alpha.append(-value[r])
        return A, alpha

    def augmented(self, env, nodes, tangent):
        """[A; d xi] and [alpha; -d_t xi], rows scaled."""
        A, b = self.equations(env)
        rows, right = list(A), list(b)
        for e in nodes if tangent else []:
            _, d, dt, _ = self.row(e, env, self.graph.cone([e]))
            rows.append(d)
            right.append(-dt)
        out, scaled = [], []
        for r, c in zip(rows, right):
            s = max([abs(a) for a in r] + [mpmath.mpf(0)])
            s = s if s > self.tiny() else mpmath.mpf(1)    # what is below is rounding
            out.append([a / s for a in r])
            scaled.append(c / s)
        return out, scaled

    def tiny(self):
        return mpmath.mpf(10) ** (-self.digits // 2)

    def compatible(self, env, nodes, tangent):
        rows, right = self.augmented(env, nodes, tangent)
        return linear.solve(rows, right, self.tiny()) is not None

    # The checks

    def check(self):
        with mpmath.workdps(self.digits + 15):
            self.counts()
            if "constraints" not in self.result:
                return
            nodes = [e for _, e in self.constraints]
            if self.result["verdict"] == "inconsistent":
                self.contradiction(nodes)
                return
            points = self.sample(nodes, self.points)
            if not points:
                raise Broken("no point of Pf was found from the printed constraints")
            for env in points:
                self.at_point(env, nodes)
                if self.motions:
                    Mechanics(self, env).check()
            self.generations()

    def contradiction(self, nodes):
        """Where the printed constraints hold, no solution is tangent to them; a restriction that never holds is none of them, and
        its value is looked at with the combinations."""
        told = self.result.get("evidence", {}).get("contradiction")
        if told and not told["combination"]:
            return
        for env in self.sample(nodes, 1) if nodes or not self.problem.restrict else []:
            if self.compatible(env, nodes, True):
                raise Broken("inconsistent, but a solution is tangent to the constraints so far")

    def counts(self):
        r = self.result
        dim = r.get("dimensions")
        if not dim:
            return
        if dim["ambient"] != len(self.names):
            raise Broken(f"ambient {dim['ambient']}, variables {self.names}")
        if r["verdict"] == "inconsistent":
            return
        gens = dim["generations"]
        if (gens[-1] if gens else dim["ambient"]) != dim["final"]:
            raise Broken(f"final {dim['final']} against generations {gens}")
        if "constraints" in r:
            for k, d in enumerate(gens, 1):
                n = sum(1 for g, _ in self.constraints if g <= k)
                if dim["ambient"] - n != d:
                    raise Broken(f"{n} constraints up to generation {k}, but dim P{k} = {d} of {dim['ambient']}")
            if max([g for g, _ in self.constraints], default=0) != len(gens):
                raise Broken("generations of the constraints do not fit dimensions.generations")
        if any(a <= b for a, b in zip([dim["ambient"]] + gens, gens)):
            raise Broken(f"dimensions do not fall: {dim['ambient']}, {gens}")
        if "index" in r:
            i = r["index"]
            if i["generations"] != len(gens) or i["seed"] != max(0, len(gens) - 1):
                raise Broken(f"index {i} against {len(gens)} generations")
        if "gauge" in r:
            if r["gauge"]["dimension"] != len(r["gauge"]["fields"]):
                raise Broken("gauge.dimension is not the number of fields")
            if (r["gauge"]["dimension"] > 0) != (r["verdict"] == "underdetermined"):
                raise Broken(f"gauge dimension {r['gauge']['dimension']} with verdict {r['verdict']}")
        if r["verdict"] == "isolated" and dim["final"] != 0:
            raise Broken("isolated with dimension " + str(dim["final"]))

    def at_point(self, env, nodes):
        tiny, n = self.tiny(), len(self.names)
        grads = [self.row(e, env, self.graph.cone([e]))[1] for e in nodes]
        if nodes and linear.rank(grads, tiny) != len(nodes):
            raise Broken("the constraints are not independent at a point of Pf")
        rows, right = self.augmented(env, nodes, True)
        found = linear.solve(rows, right, tiny)
        if rows and found is None:
            raise Broken("no solution is tangent to Pf at a point of it")
        kernel = found[1] if rows else None
        freedom = len(kernel) if rows else n
        if "gauge" in self.result and self.result["gauge"]["dimension"] != freedom:
            raise Broken(f"gauge dimension {self.result['gauge']['dimension']}, but dim(ker A & TPf) = {freedom}")
        if (freedom > 0) != (self.result["verdict"] == "underdetermined"):
            raise Broken(f"verdict {self.result['verdict']}, but dim(ker A & TPf) = {freedom}")
        fields = self.fields(env)
        if fields:
            if linear.rank(fields, tiny) != len(fields):
                raise Broken("the gauge fields are dependent at a point of Pf")
            for z in fields:
                self.fits(rows, [mpmath.mpf(0)] * len(rows), z, "a gauge field is not in ker A and TPf")
        if self.field is not None:
            for _ in range(2):
                self.fits(rows, right, self.velocity(env, fields), "X does not solve the equations tangentially")

    def fields(self, env):
        if self.gauge is None:
            return None
        return [self.texts(z, env) for z in self.gauge]

    def texts(self, by_name, env):
        if not set(by_name) <= set(self.names):
            raise Broken(f"components of unknown variables: {set(by_name) - set(self.names)}")
        out = []
        for n in self.names:
            if n not in by_name:
                out.append(mpmath.mpf(0))
                continue
            cone = self.graph.cone([by_name[n]])
            out.append(self.graph.values(cone, env, EXACT)[by_name[n]])
        return out

    def velocity(self, env, fields):
        """X at a point for random values of the free functions."""
        if set(self.field) != set(self.names):
            raise Broken(f"vector_field has components {sorted(self.field)}")
        f = {name: mpmath.mpf(self.rng.randint(-99, 99)) / 10 for name in self.free}
        x = self.texts(self.field, {**env, **f})
        if fields is not None:
            if len(self.free) != len(fields):
                raise Broken("as many free functions as gauge fields are needed")
            x0 = self.texts(self.field, {**env, **{k: mpmath.mpf(0) for k in f}})
            whole = [a + sum(f[k] * z[i] for k, z in zip(self.free, fields)) for i, a in enumerate(x0)]
            mentioned = any(a != b for a, b in zip(x, x0))
            if mentioned and any(abs(a - b) > self.tiny() * (1 + abs(a)) for a, b in zip(x, whole)):
                raise Broken("the free functions of X do not multiply the gauge fields in their order")
            x = whole
        return x

    def fits(self, rows, right, v, message):
        for r, b in zip(rows, right):
            s = sum(a * x for a, x in zip(r, v))
            size = abs(b) + sum(abs(a * x) for a, x in zip(r, v)) + 1
            if abs(s - b) > self.tiny() * size:
                raise Broken(f"{message} (residual {mpmath.nstr(s - b, 3)})")

    def generations(self):
        """Each generation against the definition of the reduction."""
        restrict = self.problem.restrict
        last = max([g for g, _ in self.constraints], default=0)
        for k in range(last):
            below = [e for g, e in self.constraints if g <= k]
            new = [e for g, e in self.constraints if g == k + 1]
            for e in new:
                rest = below + [o for o in new if o != e]
                for env in self.sample(rest, 1):
                    value, d, _, _ = self.row(e, env, self.graph.cone([e]))
                    if abs(value) <= self.tiny() * max([mpmath.mpf(1)] + [abs(a) for a in d]):
                        raise Broken(f"a constraint of generation {k + 1} vanishes where the others do")
                    if k == 0 and any(abs(self.row(f, env, self.graph.cone([f]))[0]) > self.tiny() for f in restrict):
                        continue
                    if self.compatible(env, below, k > 0):
                        raise Broken(f"a constraint of generation {k + 1} is not necessary on P{k}")
            for env in self.sample(below + new, 1):
                if not self.compatible(env, below, k > 0):
                    raise Broken(f"P{k + 1} as printed is too large")
                if k == 0:
                    for f in restrict:
                        value, d, _, _ = self.row(f, env, self.graph.cone([f]))
                        if abs(value) > self.tiny() * max([mpmath.mpf(1)] + [abs(a) for a in d]):
                            raise Broken("P1 as printed is not inside the zero set of restrict")
        if last == 0 and restrict:
            raise Broken("restrict gives no constraint")

    # Given points

    def point(self, given):
        """The environment of given exact values; what is left out is 0."""
        with mpmath.workdps(self.digits + 15):
            env = self.random_values(0)
            env[self.problem.time] = mpmath.mpf(0)
            for n in self.names:
                env[n] = mpmath.mpf(0)
            for n, v in given.items():
                env[n] = evaluate(v if isinstance(v, str) else str(v))
            return env

    def residuals(self, given):
        with mpmath.workdps(self.digits + 15):
            env = self.point(given)
            return [self.row(e, env, self.graph.cone([e]))[0] for _, e in self.constraints]

    def field_differs(self, at, value):
        """How far X at a point is from a value, modulo the gauge fields; value by variable,
        variables left out are not compared."""
        with mpmath.workdps(self.digits + 15):
            env = self.point(at)
            fields = self.fields(env) or []
            x = self.texts(self.field, {**env, **{k: mpmath.mpf(0) for k in self.free}})
            seen = [i for i, n in enumerate(self.names) if n in value]
            gap = [evaluate(str(value[self.names[i]])) - x[i] for i in seen]
            if fields:
                columns = [[z[i] for z in fields] for i in seen]
                square = [[sum(r[a] * r[b] for r in columns) for b in range(len(fields))] for a in range(len(fields))]
                right = [sum(r[a] * c for r, c in zip(columns, gap)) for a in range(len(fields))]
                found = linear.solve(square, right, self.tiny())
                if found:
                    gap = [c - sum(f * a for f, a in zip(found[0], r)) for c, r in zip(gap, columns)]
            return max(abs(c) for c in gap)

    def motion(self, env, rates):
        """The velocity of least norm among the tangent solutions with given rates; own route."""
        nodes = [e for _, e in self.constraints]
        rows, right = self.augmented(env, nodes, True)
        for name, e in rates.items():
            rows.append([mpmath.mpf(int(n == name)) for n in self.names])
            right.append(self.graph.values(self.graph.cone([e]), env, EXACT)[e])
        return linear.least_norm(rows, right, self.tiny_numeric)

    tiny_numeric = mpmath.mpf(10) ** -6


class Mechanics:
    """Acceleration and reaction at a point of Pf, against their definition alone."""

    def __init__(self, answer, env):
        self.answer, self.env, self.p = answer, env, answer.problem

    def value(self, e):
        g = self.answer.graph
        return g.values(g.cone([e]), self.env, EXACT)[e]

    def near(self, a, b, size, what):
        if abs(a - b) > self.answer.tiny() * (1 + size):
            raise Broken(f"{what}: {mpmath.nstr(a, 8)} is not {mpmath.nstr(b, 8)}")

    def dot(self, row, v):
        return sum((a * b for a, b in zip(row, v)), mpmath.mpf(0))

    def check(self):
        p, d = self.p, self.p.d
        parts = {k: [self.value(e) for e in v] for k, v in self.answer.motions.items()}
        xi, tangent, normal, R = (parts[k] for k in ("total", "tangent", "orthogonal", "reaction"))
        n = len(xi)
        size = max([abs(x) for x in xi + R] + [mpmath.mpf(1)])
        M = [[self.value(e) for e in r] for r in p.masses]
        F = [self.value(e) for e in p.force]
        eta = [self.value(p.graph.sym(w)) for w in p.names[n:2 * n]]
        H = [[self.value(e) for e in r] for r in p.H]
        for i in range(n):
            self.near(xi[i], tangent[i] + normal[i], size, "total = tangent + orthogonal")
            self.near(self.dot(M[i], xi), F[i] + R[i], size, "M xi = F + R")
        if not self.answer.result["regularity"]["own_conditions"]:
            for h in p.condition:
                self.near(self.value(h), 0, size, "a condition vanishes on W")
            if H and linear.rank(H, self.answer.tiny()) != self.answer.result["regularity"]["rank"]:
                raise Broken("H has another rank")
        for h, row in zip(p.condition, H):
            rate = self.dot([self.value(d.of(h, q)) for q in p.names[:n]], eta) + self.value(p.by_time(h))
            self.near(self.dot(row, xi), -rate, size, "H xi = -(D_X h) eta")
            self.near(self.dot(row, tangent), 0, size, "the tangent part lies in ker H")
        square = [[self.dot(a, b) for b in H] for a in H]
        for v, what in ((R, "the reaction"), (normal, "the orthogonal part")):
            c = linear.solve(square, [self.dot(r, v) for r in H], self.answer.tiny())[0] if H else []
            for i in range(n):
                self.near(v[i], sum((a * r[i] for a, r in zip(c, H)), mpmath.mpf(0)), size, what + " lies in the row space of H")
