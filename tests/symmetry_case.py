"""`symmetries` of a result checked by another route: SymPy's derivatives of the printed
expressions, evaluated with mpmath at points of the final constraint set that we find
ourselves; membership in the gauge fields by ranks. X and K are the printed ones, which the
identities have checked already."""
import mpmath
import sympy

import linear

TRUTH = {True: "T", False: "F", None: "?"}
MARKS = ("symmetry", "tangent", "preserves_T", "preserves_alpha", "gauge")


class Texts:
    """Printed expressions as SymPy's; a prime in a name becomes _prime."""

    def __init__(self, names):
        self.symbol = {n: sympy.Symbol(n.replace("'", "_prime")) for n in names}
        self.space = {s.name: s for s in self.symbol.values()}
        self.space.update({"max": sympy.Max, "min": sympy.Min, "abs": sympy.Abs, "pi": sympy.pi,
                           "cbrt": lambda u: sympy.sign(u) * sympy.Abs(u) ** sympy.Rational(1, 3)})

    def __call__(self, text):
        plain = str(text).replace("'", "_prime").replace("^", "**")
        return sympy.parse_expr(plain, local_dict=self.space, transformations=sympy.parsing.sympy_parser.standard_transformations
                                + (sympy.parsing.sympy_parser.rationalize,))


class SymmetryCase:
    def __init__(self, tally, name, request, result, answer):
        self.tally, self.name, self.request, self.result, self.answer = tally, name, request, result, answer
        self.s = result["symmetries"]

    def check(self, ok, what, detail=""):
        self.tally.check(ok, f"{self.name}: symmetries: {what}", detail)

    def run(self, expect):
        self.expected(expect)
        if self.result["verdict"] == "inconsistent" or "vector_field" not in self.result:
            return
        self.prepare()
        self.check(bool(self.points), "points were found")
        asked = {c["name"]: c for c in self.request["symmetries"].get("check", [])}
        for c in self.s["checked"]:
            self.candidate(c, asked[c["name"]])
        for f in self.s.get("found", []):
            D = self.components(f["field"], 0)
            self.check(self.symmetry(D) == (True, True), f"{f['field']} is a symmetry")
            self.check(self.in_gauge(D) == f["gauge"], f"{f['field']} is gauge: {f['gauge']}")
        self.independent()
        for F in self.s.get("first_integrals", []):
            e = self.text(F)
            self.check(all(self.zero(self.along(Y, e)) for Y in [self.X] + self.K), f"{F} is constant along solutions")
        self.commutators()
        self.noether()

    # What is expected of the case

    def expected(self, expect):
        marks = {c["name"]: "".join(TRUTH[c[m]] for m in MARKS) for c in self.s["checked"]}
        for name, should in expect.get("checked", {}).items():
            self.check(marks.get(name) == should, name, f"is {marks.get(name)}, should be {should}")
        found = self.s.get("found", [])
        is_ = {"dimension": len(found), "gauge": sum(f["gauge"] for f in found), "integrals": len(self.s.get("first_integrals", [])),
               "noether": len(self.s.get("noether", [])), "gauge_closed": self.s.get("gauge_closed"),
               "complete": self.s.get("search", {}).get("fields", {}).get("complete"),
               "presymplectic": "".join(TRUTH[v] for v in self.s.get("presymplectic", {}).values())}
        for key, should in expect.items():
            if key != "checked":
                self.check(is_[key] == should, key, f"is {is_[key]!r}, should be {should!r}")

    # The printed answer

    def prepare(self):
        self.names = self.answer.names
        self.time = self.request["system"].get("time", "t")
        self.text = Texts([*self.names, self.time, *self.answer.problem.parameters])
        self.x = [self.text.symbol[n] for n in [*self.names, self.time]]
        self.n = len(self.names)
        for d in self.result.get("definitions", []):
            self.text.space[d["name"]] = self.text(d["expression"])
        self.xi = [self.text(c["expression"]) for c in self.result["constraints"]]
        self.X = [self.text(self.result["vector_field"]["components"][n]) for n in self.names] + [sympy.Integer(1)]
        self.K = [[self.text(z.get(n, "0")) for n in self.names] + [sympy.Integer(0)] for z in self.result["gauge"]["fields"]]
        with mpmath.workdps(65):
            env = self.answer.sample([e for _, e in self.answer.constraints], 3)
        self.points = [self.polished(p) for p in env]

    def polished(self, env):
        """The sampled point to 60 digits: sampling may end where 30 digits show no residual."""
        point = {self.text.symbol[k]: v for k, v in env.items() if k in self.text.symbol}
        x = self.x[:-1]
        for _ in range(3 if self.xi else 0):
            with mpmath.workdps(60):
                rows = [self.values([e.diff(v) for v in x], point) for e in self.xi]
                move = linear.least_norm(rows, [-v for v in self.values(self.xi, point)], mpmath.mpf(10) ** -14)
                point.update({v: point[v] + d for v, d in zip(x, move)})
        return point

    def components(self, field, default):
        return [self.text(field[n]) if n in field else (sympy.Integer(0) if default == 0 else self.x[i])
                for i, n in enumerate([*self.names, self.time])]

    # Calculus

    def values(self, vector, point):
        symbols = list(point)
        with mpmath.workdps(60):
            return [mpmath.mpf(v) for v in sympy.lambdify(symbols, list(vector), "mpmath")(*[point[s] for s in symbols])]

    def zero(self, e):
        return all(abs(self.values([e], p)[0]) < mpmath.mpf(10) ** -35 for p in self.points)

    def along(self, D, f):
        return sum((d * sympy.diff(f, x) for d, x in zip(D, self.x)), sympy.Integer(0))

    def bracket(self, D, E):
        return [self.along(D, e) - self.along(E, d) for d, e in zip(D, E)]

    def inside(self, v, K=None):
        """v in the span of K at every point."""
        K = self.K if K is None else K
        for p in self.points:
            rows = [self.values(k, p) for k in K]
            last = self.values(v, p)
            size = max([abs(a) for a in last])
            if not rows:
                if size > mpmath.mpf(10) ** -35:
                    return False
                continue
            if linear.rank(rows + [[a / max(size, 1) for a in last]], mpmath.mpf(10) ** -30) > linear.rank(rows, mpmath.mpf(10) ** -30):
                return False
        return True

    def in_gauge(self, D):
        return self.inside(D)

    def symmetry(self, D):
        """(tangent, maps solutions to solutions)"""
        tangent = all(self.zero(self.along(D, e)) for e in self.xi)
        ok = True
        for Y in [self.X] + self.K:
            slow = self.along(Y, D[-1])
            v = [a + slow * b for a, b in zip(self.bracket(D, Y), self.X)]
            ok = ok and self.inside(v)
        return tangent, tangent and ok

    def map(self, phi):
        there = dict(zip(self.x, phi))
        move = lambda e: sympy.sympify(e).subs(there, simultaneous=True)
        tangent = all(self.zero(move(e)) for e in self.xi)
        jacobian = sympy.Matrix(phi).jacobian(self.x).det()
        ok = tangent and all(abs(self.values([jacobian], p)[0]) > mpmath.mpf(10) ** -30 for p in self.points)
        X, K = [move(e) for e in self.X], [[move(e) for e in k] for k in self.K]
        for Y in [self.X] + self.K:
            slow = self.along(Y, phi[-1])
            v = [self.along(Y, f) - slow * b for f, b in zip(phi, X)]
            ok = ok and self.inside(v, K)
        return tangent, ok

    # T and alpha as the request has them

    def tensor(self):
        s = self.request["system"]
        if s["form"] == "quasilinear" and not s.get("transpose"):
            A, alpha = [[self.text(e) for e in r] for r in s["A"]], [self.text(e) for e in s["alpha"]]
        elif s["form"] == "hamiltonian" and not s.get("restrict"):
            k = self.n // 2
            omega = s.get("omega") or [[(j == i + k) - (i == j + k) for j in range(self.n)] for i in range(self.n)]
            A = [[self.text(omega[j][i]) for j in range(self.n)] for i in range(self.n)]
            alpha = [sympy.diff(self.text(s["hamiltonian"]), x) for x in self.x[:-1]]
        else:
            return None, None
        return (A, alpha) if len(A) == self.n else (None, None)

    def field_preserves(self, D):
        A, alpha = self.tensor()
        if A is None or D[-1].free_symbols:
            return None, None
        N, x = range(self.n), self.x
        T = [self.along(D, A[i][j]) + sum(A[k][j] * D[k].diff(x[i]) + A[i][k] * D[k].diff(x[j]) for k in N) for i in N for j in N]
        a = [self.along(D, alpha[i]) + sum(alpha[k] * D[k].diff(x[i]) for k in N) for i in N]
        return all(self.zero(e) for e in T), all(self.zero(e) for e in a)

    def map_preserves(self, phi):
        A, alpha = self.tensor()
        if A is None or phi[-1] != self.x[-1]:
            return None, None
        there, N, x = dict(zip(self.x, phi)), range(self.n), self.x
        move = lambda e: sympy.sympify(e).subs(there, simultaneous=True)
        d = [[phi[k].diff(x[i]) for k in N] for i in N]
        T = [sum(move(A[k][m]) * d[i][k] * d[j][m] for k in N for m in N) - A[i][j] for i in N for j in N]
        a = [sum(move(alpha[k]) * d[i][k] for k in N) - alpha[i] for i in N]
        return all(self.zero(e) for e in T), all(self.zero(e) for e in a)

    # Parts of the answer

    def candidate(self, c, asked):
        if "field" in asked:
            D = self.components(asked["field"], 0)
            tangent, ok = self.symmetry(D)
            mine = [ok, tangent, *self.field_preserves(D), self.in_gauge(D)]
        else:
            phi = self.components(asked["map"], 1)
            tangent, ok = self.map(phi)
            mine = [ok, tangent, *self.map_preserves(phi), None]
        for m, should in zip(MARKS, mine):
            self.check(c[m] == should, f"{c['name']}: {m}", f"is {c[m]}, should be {should}")
        self.check((c["symmetry"] is True) or bool(c["defects"]), f"{c['name']}: a defect says why", str(c))
        for f in c["defects"]:
            if f["decided"] and f["expression"] is not None:
                vanishes = self.zero(self.text(f["expression"]))
                self.check(vanishes == (f["condition"] == "diffeomorphism"), f"{c['name']}: defect of {f['condition']}", f["expression"])

    def independent(self):
        """No constant combination of the fields, or of the integrals' differences, vanishes on Pf."""
        fields = [self.components(f["field"], 0) for f in self.s.get("found", [])]
        if not fields or not self.points:
            return
        with mpmath.workdps(65):
            env = self.answer.sample([e for _, e in self.answer.constraints], 6 + len(fields) // 2)
        rows = []
        for p in env:
            here = self.polished(p)
            value = [self.values(D, here) for D in fields]
            rows += [[v[a] for v in value] for a in range(self.n + 1)]
        self.check(linear.rank(rows, mpmath.mpf(10) ** -25) == len(fields), "the fields are independent on the final set")

    def commutators(self):
        fields = [self.components(f["field"], 0) for f in self.s.get("found", [])]
        pairs = self.s.get("commutators", [])
        for c in pairs[:30]:
            if c["combination"] is None:
                continue
            v = self.bracket(fields[c["left"]], fields[c["right"]])
            for part in c["combination"]:
                v = [a - self.text(part["factor"]) * b for a, b in zip(v, fields[part["field"]])]
            self.check(all(self.zero(a) for a in v), f"commutator {c['left']}, {c['right']}", str(c["combination"]))

    def two_form(self):
        """T of Noether's theorem, before any pull-back; None where this checker has none."""
        s, N, x = self.request["system"], range(self.n), self.x
        if s["form"] == "hamiltonian":
            k = self.n // 2
            omega = s.get("omega") or [[(j == i + k) - (i == j + k) for j in N] for i in N]
            return [[self.text(omega[j][i]) for j in N] for i in N]
        if s["form"] == "lagrangian":
            k, L = len(s["coordinates"]), self.text(s["lagrangian"])
            momentum = [L.diff(x[k + i]) for i in range(k)]
            T = sympy.zeros(self.n, self.n)
            for i in range(k):
                for a in range(2 * k):
                    T[i, a] += momentum[i].diff(x[a])
                    T[a, i] -= momentum[i].diff(x[a])
            return T.tolist()
        return self.tensor()[0]

    def noether(self):
        T = self.two_form()
        differentials = [[e.diff(v) for v in self.x[:-1]] for e in self.xi]
        for r in self.s.get("noether", []):
            F, D = self.text(r["integral"]), self.components(r["field"], 0)
            self.check(all(self.zero(self.along(Y, F)) for Y in [self.X] + self.K), f"noether: {r['integral']} is constant")
            self.check(self.symmetry(D) == (True, True), f"noether: {r['field']} is a symmetry")
            self.check(T is not None, f"noether: {r['integral']} has a 2-form")
            if T is not None:
                v = [F.diff(self.x[j]) - sum(D[i] * T[i][j] for i in range(self.n)) for j in range(self.n)]
                self.check(self.inside(v, differentials), f"noether: dF = i_D T on vectors tangent to Pf, {r['integral']}")
