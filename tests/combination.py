"""The combinations in `evidence` are multiplied out at points.

A combination is a sum of factor * equation and factor * tangency, where an equation is A v - alpha
and the tangency of a constraint is d xi v + d_t xi. It claims to be free of v on the constraints
that were known before, once velocities that the equations (and earlier tangencies) determine are inserted;
what is left is the new constraint, or the contradiction. So at random points of the earlier
constraints: the coefficients of v must be combinations of the rows of the equations and of the
tangencies of older generations, and what then remains is the constraint itself (or what it stands in place of).
"""
import mpmath

import linear
from expression import EXACT, Undefined


class Combinations:
    def __init__(self, answer):
        self.a = answer
        self.evidence = answer.result.get("evidence", {})
        g, named = answer.graph, {}
        for name, row in answer.problem.named(self.evidence.get("pull_back"), g).items():
            named[name] = row
        self.named = named
        self.points = {}     # by what vanishes at them

    def sample(self, nodes):
        """Two points; those after one constraint are those before the next one."""
        key = tuple(nodes)
        if key not in self.points:
            self.points[key] = self.a.sample(nodes, 2)
        return self.points[key]

    def linear_in_v(self, node, sign, env):
        """(coefficients of v, constant term) of an equation's residual."""
        a = self.a
        here = {**env, **{"@" + n: mpmath.mpf(0) for n in a.names}}
        value = a.graph.values(a.graph.cone([node]), here, EXACT)
        d = a.graph.gradient(node, value, EXACT)
        return [sign * d.get("@" + n, mpmath.mpf(0)) for n in a.names], sign * value[node]

    def tangency(self, k, env):
        a = self.a
        e = a.constraints[k][1]
        _, d, dt, _ = a.row(e, env, a.graph.cone([e]))
        return d, dt

    def remainder(self, parts, older, env):
        """What the combination leaves at a point, and how large its terms are; None where it does not get rid of the velocities."""
        a, n = self.a, len(self.a.names)
        v, rest, size = [mpmath.mpf(0)] * n, mpmath.mpf(0), mpmath.mpf(1)
        for p in parts:
            f = a.graph.parse(p["factor"])
            f = a.graph.values(a.graph.cone([f]), env, EXACT)[f]
            d, c = self.tangency(p["tangency_of"], env) if "tangency_of" in p else self.linear_in_v(*self.named[p["equation"]], env)
            v = [x + f * y for x, y in zip(v, d)]
            rest += f * c
            size = max(size, abs(f * c), *[abs(f * y) for y in d])
        rows = [self.linear_in_v(*r, env) for r in self.named.values()] + [self.tangency(k, env) for k in older]
        rows = [r for r in rows if max(abs(x) for x in r[0]) > a.tiny()]
        if max(abs(x) for x in v) <= a.tiny() * size:
            return rest, size
        if not rows:
            return None
        found = linear.solve([[r[0][j] for r in rows] for j in range(n)], [-x for x in v], a.tiny())
        if found is None:
            return None
        extra = [m * r[1] for m, r in zip(found[0], rows)]
        return rest + sum(extra), max([size] + [abs(x) for x in extra])

    def meant(self, i, env):
        """What the combination of constraint i is to leave: the constraint itself, or what it stands in place of."""
        a = self.a
        text = self.evidence["constraints"][i].get("in_place_of")
        e = a.graph.parse(text) if text else a.constraints[i][1]
        return a.graph.values(a.graph.cone([e]), env, EXACT)[e]

    def vanishes(self, x):
        return abs(x) <= self.a.tiny()

    def constraint(self, i, parts):
        """A message, or None where all is well."""
        a = self.a
        generation, _ = a.constraints[i]
        listed = self.evidence["constraints"]
        same = [k for k, c in enumerate(listed) if c.get("in_place_of") and c.get("in_place_of") == listed[i].get("in_place_of")
                and a.constraints[k][0] == generation] or [i]
        if i > same[0]:
            return None      # one function stands for several: looked at with the first of them
        before = [c for _, c in a.constraints[:i]]
        older = [k for k, (g, _) in enumerate(a.constraints) if g <= generation - 2]
        for nodes in (before, before + [a.constraints[k][1] for k in same]):
            for env in self.sample(nodes):
                try:
                    value = self.meant(i, env)
                    r = self.remainder(parts, older, env)
                except Undefined:
                    continue
                if r is None:
                    return f"the combination of constraint {i} does not get rid of the velocities"
                if abs(r[0] - value) > a.tiny() * r[1]:
                    return f"the combination of constraint {i} leaves {mpmath.nstr(r[0], 5)} where the constraint is {mpmath.nstr(value, 5)}"
        return None

    def contradiction(self, c):
        a = self.a
        if c["expression"] is None:
            return None
        nodes = [e for _, e in a.constraints]
        top = max([g for g, _ in a.constraints], default=0)
        wanted = a.graph.parse(c["expression"])
        for env in self.sample(nodes):
            value = a.graph.values(a.graph.cone([wanted]), env, EXACT)[wanted]
            if self.vanishes(value):
                return "the contradiction vanishes at a point of the earlier constraints"
            if not c["combination"]:
                continue           # a restriction
            left = []
            for youngest in (top - 1, top - 2):
                older = [k for k, (g, _) in enumerate(a.constraints) if g <= youngest]
                left.append(self.remainder(c["combination"], older, env))
            if all(r is None or abs(r[0] - value) > a.tiny() * r[1] for r in left):
                return f"the combination of the contradiction leaves {left}, not {mpmath.nstr(value, 5)}"
        return None

    def check(self):
        """(how many were multiplied out, list of messages)"""
        done, wrong = 0, []
        with mpmath.workdps(self.a.digits + 15):
            for i, c in enumerate(self.evidence.get("constraints", [])):
                parts = c.get("combination", [])
                if not parts or any(p["factor"] is None for p in parts):
                    continue
                done += 1
                wrong.append(self.constraint(i, parts))
            c = self.evidence.get("contradiction")
            if c and all(p["factor"] is not None for p in c["combination"]):
                done += 1
                wrong.append(self.contradiction(c))
        return done, [w for w in wrong if w]
