"""A request in other words: order, signs, names, units, spelling, named signals.

A Said is a request together with what its words mean in those of the first: a rewriting changes it in place and
keeps the account. What a form does not allow is left as it is; `done` lists what was changed.
"""
import copy
from fractions import Fraction

import respell
from descriptor import as_linear
from problem import as_list

LISTS = {"quasilinear": ("alpha", "restrict"), "equations": ("equations",), "linear": ("inputs",),
         "control": ("F", "constraints"), "hamiltonian": ("restrict",), "lagrangian": ("forces", "holonomic"),
         "mechanical": ("forces", "constraints", "restrict"), "operator": ("sources",)}
MATRICES = {"quasilinear": ("A",), "linear": ("A", "B", "C", "D"), "control": ("G",), "hamiltonian": ("omega",),
            "mechanical": ("masses",), "operator": ("B",)}
SINGLE = {"hamiltonian": ("hamiltonian",), "lagrangian": ("lagrangian",)}
USER = {"lagrangian": "coordinates", "mechanical": "coordinates", "operator": "unknowns"}
LARGEST = 60000    # characters of a request that is rewritten


class CannotSay(Exception):
    """A request that these rewritings do not read."""


class Matrix:
    """Entries by place; written as it came, dense or sparse."""

    def __init__(self, given, cols=None, rows=None):
        self.sparse = isinstance(given, dict)
        if self.sparse:
            self.rows, self.cols = given["rows"], given["cols"]
            self.entries = [(i, j, e) for i, j, e in given["entries"]]
            return
        given = as_list(given)
        if not any(isinstance(r, list) for r in given) and cols and cols > 1 and len(given) == cols and rows in (None, 1):
            given = [given]
        given = [as_list(r) for r in given]
        self.rows, self.cols = len(given), len(given[0]) if given else 0
        if any(len(r) != self.cols for r in given):
            raise CannotSay
        self.entries = [(i, j, e) for i, r in enumerate(given) for j, e in enumerate(r)]

    def permute(self, rows=None, cols=None):
        """rows[k]: where row k goes."""
        self.entries = [(rows[i] if rows else i, cols[j] if cols else j, e) for i, j, e in self.entries]

    def change(self, f):
        self.entries = [(i, j, f(i, j, e)) for i, j, e in self.entries]

    def write(self):
        if self.sparse:
            return {"rows": self.rows, "cols": self.cols, "entries": [list(e) for e in self.entries]}
        out = [[0] * self.cols for _ in range(self.rows)]
        for i, j, e in self.entries:
            out[i][j] = e
        return out


def times(c, e):
    """c e as text or number."""
    if c == 1:
        return e
    q = respell.exact(e)
    return str(c * q) if q is not None else f"{respell.number(Fraction(c))}*({e})"


class Said:
    def __init__(self, request):
        self.system = s = copy.deepcopy(as_linear(request["system"]))
        self.form = form = s["form"]
        self.user = list(as_list(s[USER.get(form, "variables")]))
        self.time = self.first_time = s.get("time", "t")
        self.inputs = list(as_list(s["inputs"])) if form == "control" else []
        for k in LISTS[form]:
            if k in s:
                s[k] = list(as_list(s[k]))
        for k in MATRICES.get(form, ()):
            if k in s and not (k == "masses" and not isinstance(s[k], dict) and not any(isinstance(r, list) for r in as_list(s[k]))):
                rows = len(s["alpha"]) if k == "A" and form == "quasilinear" else len(self.inputs) if k == "G" else None
                s[k] = Matrix(s[k], len(self.user), rows)
            elif k in s:
                s[k] = list(as_list(s[k]))
        if form == "operator":
            s["coefficients"] = [Matrix(m) for m in s["coefficients"]]
        self.trajectory = self.start_of(request.get("trajectory"))
        self.rest = {k: copy.deepcopy(request[k]) for k in ("strata",) if k in request}
        self.multipliers = self.multiplier_names()
        # what the words mean: old name -> new name, old value = scale * new value
        self.names = {v: v for v in self.user + self.inputs + self.sources() + self.multipliers}
        self.scale = {}
        self.signals = []       # (name, text in the names of now) that were put in
        self.done = []
        self.parameter = {p: p for p in s.get("parameters") or {}}

    @staticmethod
    def start_of(given):
        if not isinstance(given, dict):
            return None
        out = {k: copy.deepcopy(given[k]) for k in ("initial", "hold", "gauge") if k in given}
        start = given.get("start", given["times"][0] if given.get("times") else 0)
        out["start"] = start
        return out

    def sources(self):
        """Inputs of the form linear that are names, and so variables."""
        if self.form != "linear" or "D" in self.system:
            return []
        known = {self.time, "pi"} | set(self.user) | set(self.system.get("parameters") or {}) | set(self.system.get("tables") or {})
        return [e for e in self.system.get("inputs", []) if isinstance(e, str) and respell.NAME.fullmatch(e) and "'" not in e and e not in known]

    def multiplier_names(self):
        count = len(self.system.get({"lagrangian": "holonomic", "mechanical": "constraints"}.get(self.form), []) or [])
        taken = set(self.user) | {self.time} | set(self.system.get("parameters") or {})
        out = []
        for k in range(count):
            name = f"lambda{k + 1}"
            while name in taken:
                name += "_"
            out.append(name)
        return out

    def request(self):
        s = {k: v for k, v in self.system.items() if k != "name"}
        s[USER.get(self.form, "variables")] = self.user
        if self.form == "control":
            s["inputs"] = self.inputs
        for k, v in s.items():
            if isinstance(v, Matrix):
                s[k] = v.write()
            elif k == "coefficients":
                s[k] = [m.write() for m in v]
        if self.time != "t":
            s["time"] = self.time
        out = {"system": s, "want": ["constraints", "index", "vector_field", "gauge"], **self.rest, "limits": {"seconds": 20}}
        if self.trajectory is not None:
            out["trajectory"] = {**self.trajectory, "stop": stop_after(self.trajectory["start"])}
            if "initial" in self.trajectory:
                out["want"].append("consistent_initial")
        return out

    # Every expression

    def change(self, f, trajectory=True):
        """f on every expression; on both sides of equations."""
        s = self.system

        def both(e):
            return respell.on_sides(e, f)
        for k in LISTS[self.form] + MATRICES.get(self.form, ()):
            if isinstance(s.get(k), Matrix):
                s[k].change(lambda i, j, e: both(e))
            elif isinstance(s.get(k), list):
                s[k] = [both(e) for e in s[k]]
        for k in SINGLE.get(self.form, ()):
            s[k] = both(s[k])
        for m in s["coefficients"] if self.form == "operator" else ():
            m.change(lambda i, j, e: both(e))
        if trajectory and self.trajectory:
            g = self.trajectory.get("gauge") or {}
            if "rates" in g:
                g["rates"] = {k: both(e) for k, e in g["rates"].items()}
            if "conditions" in g:
                g["conditions"] = [both(e) for e in as_list(g["conditions"])]

    def used(self):
        out = set()

        def look(e):
            if isinstance(e, str):
                out.update(m.group(1) for m in respell.NAME.finditer(e))
            return e
        self.change(look)
        return out

    def value(self, name, primes):
        """The new name of an old variable of the result."""
        return self.names.get(name, name) + primes


def stop_after(start):
    q = respell.exact(start)
    return str(q + 1) if q is not None else 1


def places(rng, n):
    order = list(range(n))
    rng.shuffle(order)
    return order


def moved(items, order):
    """The list with item k at place order[k]."""
    out = [None] * len(items)
    for k, e in zip(order, items):
        out[k] = e
    return out


# The start, where names and units change

def rename_start(said, new):
    t = said.trajectory
    if not t:
        return

    def put(n):
        return respell.rename(n, new)
    if isinstance(t.get("initial"), dict):
        t["initial"] = {put(k): put(v) for k, v in t["initial"].items()}
    if "hold" in t:
        t["hold"] = [put(n) for n in as_list(t["hold"])]
    g = t.get("gauge") or {}
    if "rates" in g:
        g["rates"] = {put(k): put(e) for k, e in g["rates"].items()}
    if "conditions" in g:
        g["conditions"] = [put(e) for e in as_list(g["conditions"])]


def rescale_start(said, name, c):
    """Values of the start of a variable that is now 1/c of what it was."""
    t = said.trajectory
    if not t:
        return
    for key, v in list((t.get("initial") or {}).items()):
        if key.rstrip("'") == name:
            q = respell.exact(v)
            if q is None:
                t["initial"][key] = f"({v})/{respell.number(Fraction(c))}"
            else:
                t["initial"][key] = str(q / c)
    rates = (t.get("gauge") or {}).get("rates", {})
    for key, v in list(rates.items()):
        if key == name:
            rates[key] = times(1 / Fraction(c), v)
