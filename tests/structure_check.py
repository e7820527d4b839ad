"""`structure` of a result checked by other routes: combinations by substitution at points,
consequences by solving the system without them, free initial values by a rank on Pf,
blocks and needs against an incidence of our own."""
import copy

import mpmath

import linear
from expression import EXACT


def matching(rows, cols):
    """Size of a largest matching, by single augmenting paths without recursion."""
    owner = {}
    for root in range(len(rows)):
        before, queue, seen, end = {}, [root], set(), None
        for i in queue:
            for j in rows[i]:
                if j in seen:
                    continue
                seen.add(j)
                before[j] = i
                if j not in owner:
                    end = j
                    break
                queue.append(owner[j])
            if end is not None:
                break
        while end is not None:
            i = before[end]
            previous = next((j for j, r in owner.items() if r == i), None)
            owner[end] = i
            end = previous if i != root else None
    return len(owner)


class StructureCheck:
    def __init__(self, tally, name, solver, request, result, answer):
        self.tally, self.name, self.solver, self.request, self.result = tally, name, solver, request, result
        self.answer, self.s = answer, result["structure"]
        self.names = answer.names
        self.rows = []
        listed = set(self.names)
        for e in self.s.get("equations", []):
            g = answer.graph
            node = answer.problem._place(g.equation(e["text"]), listed) if "text" in e else None
            if e["equation"].startswith("definition of "):
                new = e["equation"][len("definition of "):]
                node = g.make("-", g.sym("@" + new[:-1]), g.sym(new))
            self.rows.append(node)

    def check(self, ok, what, detail=""):
        self.tally.check(ok, f"{self.name}: structure: {what}", detail)

    def run(self, expect):
        if self.result["verdict"] != "inconsistent":
            with mpmath.workdps(self.answer.digits + 15):
                self.whole = None not in self.rows
                self.anywhere = self.answer.sample([], 3)
                self.final = self.answer.sample([e for _, e in self.answer.constraints], 2)
                self.check(bool(self.anywhere and self.final), "points were found")
                if self.whole:
                    self.same_equations()
                self.combinations()
                self.initial()
                self.blocks()
                self.motion()
            self.without_consequences()
        if self.whole:
            self.predicted()
        self.expected(expect)

    whole = False

    def at(self, node, env):
        """The equation node at a point: [coefficients | constant] of an affine function of velocities."""
        g = self.answer.graph
        here = {**env, **{"@" + n: mpmath.mpf(0) for n in self.names}}
        value = g.values(g.cone([node]), here, EXACT)
        d = g.gradient(node, value, EXACT)
        return [d.get("@" + n, mpmath.mpf(0)) for n in self.names] + [value[node]]

    def gradient(self, k, env):
        e = self.answer.constraints[k][1]
        _, d, dt, _ = self.answer.row(e, env, self.answer.graph.cone([e]))
        return d + [dt]

    def same_equations(self):
        """The printed rows span what the request's equations span, at general points."""
        tiny = self.answer.tiny()
        for env in self.anywhere:
            mine = [self.at(r, env) for r in self.answer.problem.rows]
            theirs = [self.at(r, env) for r in self.rows]
            ranks = [linear.rank(m, tiny) for m in (mine, theirs, mine + theirs)]
            self.check(len(set(ranks)) == 1, "the printed equations are the request's", str(ranks))

    def combinations(self):
        g = self.answer.graph
        for e in self.s["equations"]:
            if not e.get("combination") or not self.whole or any(p["factor"] is None for p in e["combination"]):
                continue
            points = self.anywhere
            if e["holds"] != "everywhere":
                points = self.answer.sample([c for k, c in self.answer.constraints if k <= e["after_generation"]], 2)
            own = [p["factor"] for p in e["combination"] if p["equation"] == e["index"]]
            self.check(own == ["1"], f"equation {e['index']} has the factor 1 in its combination", str(own))
            for env in points:
                total = [mpmath.mpf(0)] * (len(self.names) + 1)
                for p in e["combination"]:
                    node = g.parse(p["factor"])
                    factor = g.values(g.cone([node]), env, EXACT)[node]
                    total = [a + factor * b for a, b in zip(total, self.at(self.rows[p["equation"]], env))]
                self.check(max(abs(a) for a in total) < self.answer.tiny(),
                           f"the combination of equation {e['index']} vanishes", str([mpmath.nstr(a, 3) for a in total]))

    def dropped(self, drop):
        """The request without the equations at these places of its own list, or None."""
        system = copy.deepcopy(self.request["system"])
        if system["form"] == "equations":
            system["equations"] = [e for i, e in enumerate(system["equations"]) if i not in drop]
            return system
        if system["form"] == "quasilinear" and isinstance(system["A"], list) and not system.get("transpose"):
            system["A"] = [r for i, r in enumerate(system["A"]) if i not in drop]
            system["alpha"] = [r for i, r in enumerate(system["alpha"]) if i not in drop]
            return system
        return None

    def place(self, e):
        """Where a row stands in the request's list of equations."""
        text = e["equation"]
        for before, after in (("equations[", "]"), ("row ", "")):
            if text.startswith(before):
                return int(text[len(before):len(text) - len(after)])
        return None

    def solve_without(self, drop, what):
        system = self.dropped(drop)
        if not drop or system is None or None in drop:
            return
        request = {**self.request, "system": system, "want": ["constraints", "index", "gauge", "vector_field"]}
        request.pop("trajectory", None)
        result, problem = self.solver.solve(request)
        self.check(problem is None, f"solved without {what}", str(problem))
        if problem is None:
            self.check(result["dimensions"]["final"] == self.result["dimensions"]["final"]
                       and result["verdict"] == self.result["verdict"],
                       f"the same without {what}", f"{result['verdict']} {result['dimensions']} {self.result['dimensions']}")
            self.check(self.same_set(result), f"the same Pf without {what}")

    def same_set(self, other):
        g = self.answer.graph
        if other.get("definitions"):
            return True
        nodes = [g.parse(c["expression"]) for c in other["constraints"]]
        with mpmath.workdps(self.answer.digits + 15):
            for env in self.final:
                for e in nodes:
                    if abs(g.values(g.cone([e]), env, EXACT)[e]) > self.answer.tiny():
                        return False
        return True

    def without_consequences(self):
        drop = {self.place(e) for e in self.s["equations"] if e["role"] == "consequence"}
        self.solve_without(drop, f"the consequences {sorted(map(str, drop))}")
        for e in self.s["equations"]:
            if "implied_by_derivative_of" in e:
                self.solve_without({self.place(e)}, f"equation {e['index']}")

    def initial(self):
        s = self.s
        self.check(s["degrees_of_freedom"]["initial"] == self.result["dimensions"]["final"], "degrees of freedom")
        if "gauge" in self.result:
            self.check(s["degrees_of_freedom"]["functions"] == self.result["gauge"]["dimension"], "free functions")
        free = s["free_initial"]
        if free is None:
            return
        self.check(len(free) == self.result["dimensions"]["final"], "as many free initial values as dim Pf", str(free))
        rest = [i for i, n in enumerate(self.names) if n not in free]
        self.check(sorted(d["variable"] for d in s["determined_initial"]) == sorted(self.names[i] for i in rest),
                   "the others are determined")
        self.check(sorted(d["constraint"] for d in s["determined_initial"]) == list(range(len(self.answer.constraints))),
                   "each by a constraint of its own")
        best = 0
        for env in self.final:
            part = [[self.gradient(k, env)[i] for i in rest] for k in range(len(self.answer.constraints))]
            best = max(best, linear.rank(part, self.answer.tiny()) if part else 0)
        self.check(best == len(rest), "the determined values are determined", f"rank {best} of {len(rest)}")

    def source_row(self, origin, env):
        if "equation" in origin:
            return self.at(self.rows[origin["equation"]], env) if self.rows[origin["equation"]] is not None else None
        return self.gradient(origin["constraint_differentiated"], env)

    def blocks(self):
        tiny, known = self.answer.tiny(), set()
        listed = [n for b in self.s["blocks"] for n in b["derivatives_of"]]
        self.check(sorted(listed) == sorted(self.names), "every derivative is in one block", str(listed))
        free = [n for b in self.s["blocks"] if not b["from"] for n in b["derivatives_of"]]
        self.check(len(free) == self.s["degrees_of_freedom"]["functions"], "free derivatives", str(free))
        for b in self.s["blocks"]:
            own = b["derivatives_of"]
            known |= set(own)
            if not b["from"]:
                continue
            self.check(len(b["from"]) == len(own), "a block is square", str(b))
            pattern = [set() for _ in own]
            regular = False
            for env in self.final:
                rows = [self.source_row(o, env) for o in b["from"]]
                if None in rows:
                    return
                for i, r in enumerate(rows):
                    here = {n for n, a in zip(self.names, r) if abs(a) > tiny}
                    self.check(here <= known, "a block needs earlier ones only", f"{b} {sorted(here - known)}")
                    pattern[i] |= here & set(own)
                regular |= linear.rank([[r[self.names.index(n)] for n in own] for r in rows], tiny) == len(own)
            self.check(regular, "a block is regular", str(b))
            # irreducible: from each unknown every other one is reached (row i is matched with unknown i)
            for start in range(len(own)):
                seen, stack = {start}, [start]
                for i in stack:
                    for n in pattern[i]:
                        k = own.index(n)
                        if k not in seen:
                            seen.add(k)
                            stack.append(k)
                self.check(len(seen) == len(own), "a block does not fall apart", str(b))

    def motion(self):
        groups, g = self.s["motion"], self.answer.graph
        listed = [n for q in groups for n in q["variables"]]
        self.check(sorted(listed) == sorted(self.names), "every variable has one group")
        closure, place = [], {}
        for k, q in enumerate(groups):
            self.check(all(m < k for m in q["needs"]), "needs come earlier", str(q))
            closure.append(set(q["variables"]).union(*(closure[m] for m in q["needs"])))
            place.update({n: k for n in q["variables"]})
        velocity = {"@" + n: n for n in self.names}
        for b in self.s["blocks"]:
            for n, o in zip(b["derivatives_of"], b["from"]):
                if "equation" in o:
                    if self.rows[o["equation"]] is None:
                        continue
                    used = g.names([self.rows[o["equation"]]])
                else:
                    used = g.names([self.answer.constraints[o["constraint_differentiated"]][1]])
                used = {velocity.get(u, u) for u in used} & set(self.names)
                self.check(used <= closure[place[n]] or self.vanishing(o, used - closure[place[n]]),
                           f"the motion of {n} needs no more than said", str(sorted(used - closure[place[n]])))

    def vanishing(self, origin, names):
        """The velocities of these names have zero coefficients on Pf."""
        for env in self.final:
            r = self.source_row(origin, env)
            if any(abs(r[self.names.index(n)]) > self.answer.tiny() for n in names):
                return False
        return True

    def predicted(self):
        g = self.answer.graph
        velocity = {"@" + n: n for n in self.names}
        rows = [sorted({velocity.get(u, u) for u in g.names([r])} & set(self.names)) for r in self.rows]
        rank = matching(rows, self.names)
        p = self.s["predicted"]
        self.check(p["structural_rank"] == rank, "structural rank", f"{p['structural_rank']}, by our own matching {rank}")
        if rows:
            over = [i for i in range(len(rows)) if len(rows) > rank and matching(rows[:i] + rows[i + 1:], self.names) == rank]
            self.check(p["overdetermined"]["equations"] == over, "overdetermined equations", f"{p['overdetermined']}, {over}")

    def expected(self, expect):
        s = self.s
        got = {
            "initial": s.get("degrees_of_freedom", {}).get("initial"),
            "functions": s.get("degrees_of_freedom", {}).get("functions"),
            "free_initial": s.get("free_initial") and sorted(s["free_initial"]),
            "consequences": [e["index"] for e in s.get("equations", []) if e["role"] == "consequence"],
            "everywhere": [e["index"] for e in s.get("equations", []) if e.get("holds") == "everywhere"],
            "combined": [e["index"] for e in s.get("equations", []) if e.get("combination")],
            "implied": [e["index"] for e in s.get("equations", []) if "implied_by_derivative_of" in e],
            "count": sum(e["role"] == "consequence" for e in s.get("equations", [])),
            "roles": [e["role"] for e in s.get("equations", [])],
            "blocks": sorted(len(b["derivatives_of"]) for b in s.get("blocks", [])),
            "groups": len(s.get("motion", [])),
            "structural_rank": s["predicted"]["structural_rank"],
        }
        for key, value in expect.items():
            self.check(got[key] == value, key, f"is {got[key]!r}, should be {value!r}")
