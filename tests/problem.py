"""A request, read for the checkers: the equations as functions of a point and a velocity.

Nothing is reduced here. For the form `equations` the residual is the user's own text
with each derivative taken from the state where the result lists it as a variable and
from the velocity otherwise, so the order reduction of the C code is checked too.
"""
from fractions import Fraction

from expression import Graph


def as_list(x):
    return x if isinstance(x, list) else [x]


def split(name):
    """x'' -> (x, 2)"""
    base = name.rstrip("'")
    return base, len(name) - len(base)


class Problem:
    """names: the variables of the space the reduction ran in. rows: list of residuals, each
    a node in the variables, time, parameters and velocities "@x". The velocity of x is the symbol "@x"."""

    def __init__(self, request, names=None):
        system = request["system"]
        self.graph = g = Graph()
        self.time = system.get("time", "t")
        self.form = system["form"]
        self.parameters = []
        for name, value in (system.get("parameters") or {}).items():
            if value is None:
                self.parameters.append(name)
            else:
                g.define(name, value)
        user = as_list(system["variables"])
        if self.form == "quasilinear":
            self.names = user
            self._quasilinear(system)
        elif self.form == "equations":
            self._equations(system, user, names)
        else:
            raise ValueError(self.form)

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

    def _place(self, root, listed):
        """Derivatives that are not variables become velocities."""
        g, new = self.graph, {}
        for e in g.cone([root]):
            op, *args = g.node[e]
            if op == "sym" and args[0].endswith("'") and args[0] not in listed:
                new[e] = g.sym("@" + args[0][:-1])
            elif op in ("sym", "const", "pi"):
                new[e] = e
            else:
                new[e] = g.make(op, *[new[a] for a in args])
        return new[root]
