"""A request, read for the checkers: the equations as functions of a point and a velocity.

Nothing is reduced here. For the form `equations` the residual is the user's own text
with each derivative taken from the state where the result lists it as a variable and
from the velocity otherwise, so the order reduction of the C code is checked too. The other forms are built here
from their definitions, by routes of their own.
"""
import itertools
import re
from fractions import Fraction

from expression import Graph
from descriptor import as_linear
from symbolic import Derivatives


def as_list(x):
    return x if isinstance(x, list) else [x]


def split(name):
    """x'' -> (x, 2)"""
    base = name.rstrip("'")
    return base, len(name) - len(base)


class Problem:
    """names: the variables of the space the reduction ran in. rows: list of residuals, each
    a node in the variables, time, parameters and velocities "@x". The velocity of x is the symbol "@x"."""

    def __init__(self, request, names=None, primary=None, redundant=(), conditions=()):
        """primary: regular functions with the zeros of restrict, where those are not. redundant: constraints of the forms
        mechanical and lagrangian whose multipliers are chosen; conditions: the answer's own for its multipliers."""
        system = as_linear(request["system"])
        self.system, self.primary = system, primary
        self.graph = g = Graph()
        self.time = system.get("time", "t")
        self.form = system["form"]
        self.parameters = []
        self.tables = list(system.get("tables", {}))    # functions of time: u, u', u'', ... can have any values
        for name, value in (system.get("parameters") or {}).items():
            if value is None:
                self.parameters.append(name)
            else:
                g.define(name, value)
        user = as_list(system[{"lagrangian": "coordinates", "mechanical": "coordinates", "operator": "unknowns"}.get(self.form, "variables")])
        self.restrict = []
        if self.form == "quasilinear":
            self.names = user
            self._quasilinear(system)
        elif self.form == "equations":
            self._equations(system, user, names)
        elif self.form == "operator":
            self._equations({"equations": self._operator(system, user)}, user, names)
        elif self.form == "mechanical":
            self.d = Derivatives(g)
            self._mechanical(system, user, redundant, conditions)
        elif self.form == "lagrangian":
            self.d = Derivatives(g)
            self._lagrangian(system, user, redundant)
        elif self.form in ("linear", "control", "hamiltonian"):
            self.d = Derivatives(g)
            getattr(self, "_" + self.form)(system, user)
        else:
            raise ValueError(self.form)

    @staticmethod
    def _operator(system, user):
        """sum A_i y^(i) = B e as texts; sources that are only named cannot be checked here."""
        p, sources = len(user), system["sources"]
        B = system.get("B") or [["1" if i == j else "0" for j in range(p)] for i in range(p)]
        left = [" + ".join(f"({m[i][j]})*{user[j]}{chr(39) * k}" for k, m in enumerate(system["coefficients"])
                           for j in range(p) if str(m[i][j]) != "0") for i in range(p)]
        return [f"{left[i]} = " + " + ".join(f"({B[i][j]})*({sources[j]})" for j in range(len(sources))) for i in range(p)]

    def _quasilinear(self, system):
        g = self.graph
        A = system["A"]
        if isinstance(A, dict):
            entries = [(i, j, g.parse(e)) for i, j, e in A["entries"]]
        else:
            A = as_list(A)
            if len(as_list(system["alpha"])) == 1 and len(A) == len(self.names) > 1 and not isinstance(A[0], list):
                A = [A]    # one flat list for one row
            entries = [(i, j, g.parse(e)) for i, r in enumerate(A) for j, e in enumerate(as_list(r))]
        if system.get("transpose"):
            entries = [(j, i, e) for i, j, e in entries]
        self.rows = [g.make("neg", g.parse(a)) for a in as_list(system["alpha"])]
        for i, j, e in entries:
            self.rows[i] = g.make("+", self.rows[i], g.make("*", e, g.sym("@" + self.names[j])))
        self.restrict = [g.parse(e) for e in as_list(system.get("restrict", []))]

    def _equations(self, system, user, names):
        g = self.graph
        d = Derivatives(g)
        moving = {self.time: g.const(1)}

        def total(e):
            rates = {n: moving[n] if n in moving else g.sym(n + "'") for n in g.names([e])
                     if n in moving or split(n)[0] in list(user) + self.tables}
            return d.sum(d.mul(d.of(e, n), rate) for n, rate in rates.items())
        g.total = total
        texts = [g.equation(t) for t in as_list(system["equations"])]
        used = g.names(texts)
        self.restrict = []
        order = {v: max([split(n)[1] for n in used if split(n)[0] == v], default=0) for v in user}
        if names is None:    # the state without prolongation
            names = [v + "'" * k for k in range(max([1] + list(order.values()))) for v in user if k < max(order[v], 1)]
        self.names = names
        listed = set(names)
        self.rows = []
        for n in names:
            base, k = split(n)
            if k:
                self.rows.append(g.make("-", g.sym("@" + base + "'" * (k - 1)), g.sym(n)))
        for e in texts:
            self.rows.append(self._place(e, listed))

    def by_time(self, e):
        """The derivative at fixed variables: by time, and by what is a function of time."""
        g, d = self.graph, self.d
        return d.add(d.of(e, self.time), d.sum(d.mul(d.of(e, n), g.sym(n + "'")) for n in g.names([e]) if split(n)[0] in self.tables))

    def _place(self, root, listed):
        """Derivatives that are not variables become velocities."""
        g, new = self.graph, {}
        for e in g.cone([root]):
            op, *args = g.node[e]
            if op == "sym" and args[0].endswith("'") and args[0] not in listed and split(args[0])[0] not in self.tables:
                new[e] = g.sym("@" + args[0][:-1])
            elif op in ("sym", "const", "pi"):
                new[e] = e
            else:
                new[e] = g.make(op, *[new[a] for a in args])
        return new[root]

    def _matrix(self, given, rows, cols):
        """A matrix of nodes, dense; rows None: as many as are written."""
        g = self.graph
        if isinstance(given, dict):
            m = [[g.const(0)] * given["cols"] for _ in range(given["rows"])]
            for i, j, e in given["entries"]:
                m[i][j] = self.d.add(m[i][j], g.parse(e))
            return m
        given = as_list(given)
        flat = not any(isinstance(r, list) for r in given)
        if flat and cols > 1 and len(given) == cols and rows in (None, 1):
            given = [given]
        return [[g.parse(e) for e in as_list(r)] for r in given]

    def speed(self, name):
        return self.graph.sym("@" + name)

    def _linear(self, system, user):
        """A x' - B x - C u, where u is D x' or what stands under inputs."""
        g, d = self.graph, self.d
        A = self._matrix(system["A"], None, len(user))
        B = self._matrix(system["B"], len(A), len(user))
        self.names = list(user)
        u = []
        if "D" in system:
            u = [d.sum(d.mul(e, self.speed(n)) for e, n in zip(r, user)) for r in self._matrix(system["D"], None, len(user))]
        else:
            for e in as_list(system.get("inputs", [])):
                known = set(user) | {self.time, "pi"} | set(system.get("parameters") or {}) | set(self.tables)
                if isinstance(e, str) and re.fullmatch("[A-Za-z_][A-Za-z_0-9]*", e) and e not in known:
                    self.names.append(e)
                u.append(g.parse(e))
        C = self._matrix(system["C"], len(A), len(u)) if "C" in system else [[] for _ in A]
        self.rows = [d.sub(d.sub(d.sum(d.mul(e, self.speed(n)) for e, n in zip(a, user)),
                                 d.sum(d.mul(e, g.sym(n)) for e, n in zip(b, user))),
                           d.sum(d.mul(e, v) for e, v in zip(c, u))) for a, b, c in zip(A, B, C)]

    def _control(self, system, user):
        g, d = self.graph, self.d
        inputs = as_list(system["inputs"])
        self.names = user + inputs
        G = self._matrix(system["G"], len(inputs), len(user))
        self.rows = [d.sub(self.speed(n), d.add(g.parse(f), d.sum(d.mul(r[i], g.sym(u)) for r, u in zip(G, inputs))))
                     for i, (n, f) in enumerate(zip(user, as_list(system["F"])))]
        self.rows += [g.parse(c) for c in as_list(system["constraints"])]

    def _determinant(self, m, known):
        """By the first column; known: those of minors met before."""
        if not m:
            return self.graph.const(1)
        key = tuple(map(tuple, m))
        if key in known:
            return known[key]
        d, total = self.d, self.graph.const(0)
        for i, r in enumerate(m):
            if d.zero(r[0]):
                continue
            part = d.mul(r[0], self._determinant([q[1:] for k, q in enumerate(m) if k != i], known))
            total = d.add(total, part) if i % 2 == 0 else d.sub(total, part)
        known[key] = total
        return total

    def _hamiltonian(self, system, user):
        """omega(x', e) = dH(e), for all e; on a submanifold for e tangent to it: those are spanned
        by the cofactor vectors of the differentials, one for each choice of m + 1 variables."""
        g, d, n = self.graph, self.d, len(user)
        self.names = user
        H = g.parse(system["hamiltonian"])
        if "omega" in system:
            omega = self._matrix(system["omega"], n, n)
        else:
            omega = [[g.const((j == i + n // 2) - (i == j + n // 2)) for j in range(n)] for i in range(n)]
        whole = [d.sub(d.sum(d.mul(omega[j][i], self.speed(user[j])) for j in range(n)), d.of(H, user[i])) for i in range(n)]
        self.restrict = [g.parse(e) for e in as_list(system.get("restrict", []))]
        self.whole = whole
        J = [[d.of(g.parse(e) if self.primary else e, v) for v in user] for e in self.primary or self.restrict]
        self.rows, known = [], {}
        for chosen in itertools.combinations(range(n), len(J) + 1):
            total = g.const(0)
            for k, i in enumerate(chosen):
                minor = self._determinant([[r[j] for j in chosen if j != i] for r in J], known)
                total = d.add(total, d.mul(minor, whole[i])) if k % 2 == 0 else d.sub(total, d.mul(minor, whole[i]))
            if not d.zero(total):
                self.rows.append(total)

    def _lagrangian(self, system, user, redundant):
        """d/dt dL/dv by the chain rule; or the contraction of sum dq ^ dp, with E differentiated as it is."""
        g, d, n = self.graph, self.d, len(user)
        v = [q + "'" for q in user]
        L = g.parse(system["lagrangian"])
        constraints = [g.parse(e) for e in as_list(system.get("holonomic", []))]
        taken = set(user) | {self.time} | set(system.get("parameters") or {})
        multipliers = []
        for k in range(len(constraints)):
            name = f"lambda{k + 1}"
            while name in taken:
                name += "_"
            multipliers.append(name)
        self.names = user + v + multipliers
        force = [g.parse(e) for e in as_list(system.get("forces", [0] * n))]
        force = [d.add(f, d.sum(d.mul(g.sym(m), d.of(c, q)) for m, c in zip(multipliers, constraints)))
                 for f, q in zip(force, user)]
        p = [d.of(L, w) for w in v]
        rate = [d.add(self.by_time(e), d.sum(d.mul(d.of(e, z), self.speed(z)) for z in user + v)) for e in p]
        if system.get("second_order", True):
            self.rows = [d.sub(self.speed(q), g.sym(w)) for q, w in zip(user, v)]
            self.rows += [d.sub(d.sub(r, d.of(L, q)), f) for r, q, f in zip(rate, user, force)]
        else:
            E = d.sub(d.sum(d.mul(g.sym(w), e) for w, e in zip(v, p)), L)
            left = [d.sum(d.mul(self.speed(q), d.of(e, z)) for q, e in zip(user, p)) for z in user + v]
            self.rows = [d.sub(d.sub(a, d.of(E, z)), d.sub(r, f)) for a, z, r, f in zip(left, user, rate, force)]
            self.rows += [d.sub(a, d.of(E, z)) for a, z in zip(left[n:], v)]
        self.rows += constraints
        self.redundant = list(redundant)
        self.rows += [g.sym(multipliers[k]) for k in redundant]

    def named(self, pull_back, graph):
        """The equations by the names that answers use: name -> (node, sign) with sign * node = A v - alpha."""
        system, form, n = self.system, self.form, len(self.rows)
        d = getattr(self, "d", None)
        if form in ("quasilinear", "linear") or (form == "hamiltonian" and not self.restrict):
            return {f"row {i}": (r, 1) for i, r in enumerate(self.rows)}
        user = as_list(system[{"lagrangian": "coordinates", "mechanical": "coordinates", "operator": "unknowns"}.get(form, "variables")])
        if form == "hamiltonian":
            at = {v: i for i, v in enumerate(user)}
            return {f"pull-back {k}": (d.sum(d.mul(graph.parse(e), self.whole[at[v]]) for v, e in z.items()), 1)
                    for k, z in enumerate(pull_back or []) if None not in z.values()}       # those that were too long to be written are not known
        if form == "control":
            names = [(f"equation of {v}", 1) for v in user]
            names += [(f"constraints[{i}]", -1) for i in range(n - len(names))]
        elif form == "mechanical":
            names = [(f"definition of {q}'", 1) for q in user] + [(f"equation of {q}", 1) for q in user]
            names += [(f"constraints[{i}]", -1) for i in range(len(self.constraints))]
            names += [(f"choice of {self.names[2 * len(user) + k]}", -1) for k in self.redundant]
        elif form == "lagrangian":
            second = system.get("second_order", True)
            own = 1 if second else -1       # i_X omega - dE along dq is minus the Euler-Lagrange expressions
            of_q, of_v = [(f"equation of {q}", own) for q in user], [(("definition" if second else "equation") + f" of {q}'", 1) for q in user]
            names = of_v + of_q if second else of_q + of_v
            names += [(f"holonomic[{i}]", -1) for i in range(n - len(names) - len(self.redundant))]
            names += [(f"choice of {self.names[2 * len(user) + k]}", -1) for k in self.redundant]
        else:
            names = [(f"definition of {v}", 1) for v in self.names if v.endswith("'")]
            names += [(f"equations[{i}]", 1) for i in range(n - len(names))]
        return {name: (r, sign) for (name, sign), r in zip(names, self.rows)}

    def _mechanical(self, system, user, redundant, conditions):
        """q' = v, M v' = F + H^T lambda, 0 = h; a multiplier whose constraint is redundant is 0."""
        g, d, n = self.graph, self.d, len(user)
        v = [q + "'" for q in user]
        self.constraints = [g.parse(e) for e in as_list(system["constraints"])]
        taken = set(user) | {self.time} | set(system.get("parameters") or {})
        multipliers = []
        for k in range(len(self.constraints)):
            name = f"lambda{k + 1}"
            while name in taken:
                name += "_"
            multipliers.append(name)
        self.names = user + v + multipliers
        masses = system["masses"]
        if isinstance(masses, dict) or any(isinstance(r, list) for r in as_list(masses)):
            self.masses = self._matrix(masses, n, n)
        else:
            self.masses = [[g.parse(m) if i == j else g.const(0) for j in range(n)] for i, m in enumerate(as_list(masses))]
        self.force = [g.parse(f) for f in as_list(system["forces"])]
        self.condition = []     # h, or its derivative where no velocity occurs
        for h in self.constraints:
            if not g.names([h]) & set(v):
                h = d.add(self.by_time(h), d.sum(d.mul(d.of(h, q), g.sym(w)) for q, w in zip(user, v)))
            self.condition.append(h)
        self.restrict = [g.parse(e) for e in as_list(system.get("restrict", []))]
        if conditions:
            self.condition = [g.parse(c["expression"]) for c in conditions]
            acting = [c["multiplier"] for c in conditions]
            multipliers += [m for m in acting if m not in multipliers]
            self.names = user + v + multipliers
            redundant = [k for k, m in enumerate(multipliers) if m not in acting]
        else:
            acting = multipliers
        self.H = [[d.of(h, w) for w in v] for h in self.condition]
        self.rows = [d.sub(self.speed(q), g.sym(w)) for q, w in zip(user, v)]
        for i in range(n):
            left = d.sum(d.mul(self.masses[i][j], self.speed(w)) for j, w in enumerate(v))
            right = d.add(self.force[i], d.sum(d.mul(r[i], g.sym(m)) for r, m in zip(self.H, acting)))
            self.rows.append(d.sub(left, right))
        self.rows += self.constraints
        self.redundant = list(redundant)
        self.rows += [g.sym(multipliers[k]) for k in redundant]
