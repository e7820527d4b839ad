"""A request in other words: order, signs, names, units, spelling, named signals.

A Said is a request together with what its words mean in those of the first: a rewriting changes it in place and
keeps the account. What a form does not allow is left as it is; `done` lists what was changed.
"""
import copy
from fractions import Fraction

import respell
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
        self.system = s = copy.deepcopy(request["system"])
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


# Order

def equations(rng, said):
    s, form = said.system, said.form
    if form in ("equations",):
        rng.shuffle(s["equations"])
    elif form == "quasilinear":
        order = places(rng, len(s["alpha"]))
        s["alpha"] = moved(s["alpha"], order)
        s["A"].permute(cols=order) if s.get("transpose") else s["A"].permute(order)
    elif form == "linear":
        order = places(rng, s["A"].rows)
        for k in ("A", "B", "C"):
            if k in s:
                s[k].permute(order)
    elif form == "operator":
        order = places(rng, len(said.user))
        for m in s["coefficients"]:
            m.permute(order)
        if "B" in s:
            s["B"].permute(order)
        elif "sources" in s:
            s["sources"] = moved(s["sources"], order)
        else:
            s["sources"] = moved([f"e{k + 1}" for k in range(len(said.user))], order)
    elif form in ("lagrangian", "mechanical"):
        key = "holonomic" if form == "lagrangian" else "constraints"
        if key in s:
            order = places(rng, len(s[key]))
            s[key] = moved(s[key], order)
            new = {old: said.multipliers[k] for old, k in zip(said.multipliers, order)}
            back = {v: k for k, v in said.names.items()}
            said.names.update({back[old]: name for old, name in new.items() if old in back})
            rename_start(said, new)
    elif form == "control":
        rng.shuffle(s["constraints"])
    if "restrict" in s:
        rng.shuffle(s["restrict"])
    return True


def variables(rng, said):
    s, form, n = said.system, said.form, len(said.user)
    order = places(rng, n)
    if form == "hamiltonian" and "omega" not in s:
        half = places(rng, n // 2)
        order = half + [k + n // 2 for k in half]
    said.user = moved(said.user, order)
    if form == "quasilinear":
        s["A"].permute(rows=order) if s.get("transpose") else s["A"].permute(cols=order)
    elif form == "linear":
        for k in ("A", "B", "D"):
            if k in s:
                s[k].permute(cols=order)
        if "inputs" in s and "C" in s and s["inputs"]:
            turn = places(rng, len(s["inputs"]))
            s["inputs"] = moved(s["inputs"], turn)
            s["C"].permute(cols=turn)
            if "D" in s:
                s["D"].permute(turn)
    elif form == "control":
        s["F"] = moved(s["F"], order)
        s["G"].permute(cols=order)
        turn = places(rng, len(said.inputs))
        said.inputs = moved(said.inputs, turn)
        s["G"].permute(turn)
    elif form == "hamiltonian" and "omega" in s:
        s["omega"].permute(order, order)
    elif form in ("lagrangian", "mechanical"):
        if "forces" in s:
            s["forces"] = moved(s["forces"], order)
        if "masses" in s:
            if isinstance(s["masses"], Matrix):
                s["masses"].permute(order, order)
            else:
                s["masses"] = moved(s["masses"], order)
    elif form == "operator":
        for m in s["coefficients"]:
            m.permute(cols=order)
    return n > 1


# Signs

def pick_factor(rng):
    return rng.choice([Fraction(-1)] * 4 + [Fraction(2), Fraction(-3), Fraction(1, 7), Fraction(5, 2), Fraction(-10)])


def signs(rng, said):
    """Equations times numbers, sides exchanged."""
    s, form = said.system, said.form
    if form == "equations":
        out = []
        for e in s["equations"]:
            left, right = respell.SIDES.split(e)
            c = pick_factor(rng)
            if c != 1:
                left, right = f"{respell.number(c)}*({left})", f"{respell.number(c)}*({right})"
            if rng.random() < 0.5:
                left, right = right, left
            if rng.random() < 0.2:
                left, right = f"{left} - ({right})", "0"
            out.append(f"{left} = {right}")
        s["equations"] = out
    elif form in ("quasilinear", "linear", "operator"):
        matrices = [s[k] for k in ("A", "B", "C") if k in s] if form != "operator" else s["coefficients"] + ([s["B"]] if "B" in s else [])
        if form == "operator" and "B" not in s:
            return False
        count = len(s["alpha"]) if form == "quasilinear" else matrices[0].rows
        c = [pick_factor(rng) for _ in range(count)]
        for m in matrices:
            if s.get("transpose"):
                m.change(lambda i, j, e: times(c[j], e))
            else:
                m.change(lambda i, j, e: times(c[i], e))
        if form == "quasilinear":
            s["alpha"] = [times(k, e) for k, e in zip(c, s["alpha"])]
    elif form in ("lagrangian", "mechanical"):
        key = "holonomic" if form == "lagrangian" else "constraints"
        back = {v: k for k, v in said.names.items()}
        for k, e in enumerate(s.get(key, [])):
            c = pick_factor(rng)
            s[key][k] = times(c, e)
            m = said.multipliers[k]
            said.scale[back[m]] = said.scale.get(back[m], 1) * c
            rescale_start(said, m, c)
    elif form == "control":
        s["constraints"] = [times(pick_factor(rng), e) for e in s["constraints"]]
    if "restrict" in s:
        s["restrict"] = [times(pick_factor(rng), e) for e in s["restrict"]]
    return True


# Names

def rename_start(said, new):
    t = said.trajectory
    if not t:
        return

    def put(n):
        return respell.rename(n, new)
    if isinstance(t.get("initial"), dict):
        t["initial"] = {put(k): v for k, v in t["initial"].items()}
    if "hold" in t:
        t["hold"] = [put(n) for n in as_list(t["hold"])]
    g = t.get("gauge") or {}
    if "rates" in g:
        g["rates"] = {put(k): put(e) for k, e in g["rates"].items()}
    if "conditions" in g:
        g["conditions"] = [put(e) for e in as_list(g["conditions"])]


def names(rng, said):
    """Other names, of variables, inputs, parameters and time; half of the time in reversed alphabetical order."""
    s = said.system
    old = sorted(set(said.user + said.inputs + said.sources()))
    parameters = list(s.get("parameters") or {})
    taken = {"pi", "der"} | set(s.get("tables") or {}) | said.used()
    pool = [n for n in ["x", "y", "z", "a1", "b_2", "Omega", "mu", "_u", "w9", "e", "i", "D", "T", "E", "zz", "Q"] if n not in taken]
    pool += [f"q_{k}" for k in range(len(old) + len(parameters) + 1)]
    rng.shuffle(pool)
    if rng.random() < 0.5:
        fresh = [f"v{k:03d}" for k in range(len(old))][::-1]
    else:
        fresh = pool[:len(old)]
    new = dict(zip(old, fresh))
    rest = pool[len(old):]
    new.update(zip(parameters, rest))
    time = rest[len(parameters)] if rng.random() < 0.3 else said.time
    new[said.time] = time
    if "parameters" in s and s["parameters"]:
        items = [(new[k], v) for k, v in s["parameters"].items()]
        rng.shuffle(items)
        s["parameters"] = dict(items)
    said.change(lambda e: respell.rename(e, new), trajectory=False)
    rename_start(said, new)
    said.user, said.inputs = [new[v] for v in said.user], [new[v] for v in said.inputs]
    said.time = time
    if "time" in s:
        s["time"] = time
    said.signals = [(new[n], respell.rename(e, new)) for n, e in said.signals]
    former = said.multipliers
    said.multipliers = said.multiplier_names()
    rename_start(said, dict(zip(former, said.multipliers)))
    new.update(zip(former, said.multipliers))
    said.names = {k: new.get(v, v) for k, v in said.names.items()}
    said.parameter = {p: new[n] for p, n in said.parameter.items()}
    return True


# Units

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


def units(rng, said):
    """Variables in units of powers of ten."""
    s, form = said.system, said.form
    if form not in ("equations", "quasilinear", "linear", "control", "lagrangian", "hamiltonian", "operator") or "omega" in s:
        return False
    largest = rng.choice([3, 3, 6])
    power = {v: rng.choice([0, rng.randint(-largest, largest)]) for v in said.user + said.inputs + said.sources()
             if v not in dict(said.signals)}
    if form == "hamiltonian":
        half = len(said.user) // 2
        for q, p in zip(said.user, said.user[half:]):
            power[p] = -power[q]
    c = {v: Fraction(10) ** k for v, k in power.items() if k}
    if not c:
        return False

    def put(n):
        base = n.rstrip("'")
        return f"({respell.number(c[base])}*{n})" if base in c else n

    def sub(e):
        return respell.Tree(e).text(put) if isinstance(e, str) else e
    if form == "linear" or form == "operator":
        for m in [s[k] for k in ("A", "B", "D") if k in s and form == "linear"] + (s["coefficients"] if form == "operator" else []):
            m.change(lambda i, j, e: times(c.get(said.user[j], Fraction(1)), e))
        for k, e in enumerate(s.get("inputs", []) if form == "linear" else []):
            if e in c:
                s["C"].change(lambda i, j, a: times(c[e], a) if j == k else a)
    else:
        said.change(sub)
        said.signals = [(n, sub(e)) for n, e in said.signals]
    if form == "quasilinear":
        if s.get("transpose"):
            s["A"].change(lambda i, j, e: times(c.get(said.user[i], Fraction(1)), e))
        else:
            s["A"].change(lambda i, j, e: times(c.get(said.user[j], Fraction(1)), e))
    elif form == "control":
        s["F"] = [times(1 / c.get(v, Fraction(1)), e) for v, e in zip(said.user, s["F"])]
        s["G"].change(lambda i, j, e: times(c.get(said.inputs[i], Fraction(1)) / c.get(said.user[j], Fraction(1)), e))
    elif form == "lagrangian" and "forces" in s:
        s["forces"] = [times(c.get(v, Fraction(1)), e) for v, e in zip(said.user, s["forces"])]
    back = {v: k for k, v in said.names.items()}
    for v, f in c.items():
        if v in back:
            said.scale[back[v]] = said.scale.get(back[v], 1) * f
        rescale_start(said, v, f)
    return True


# Spelling

def spelling(rng, said):
    speller = respell.Speller(rng)

    def say(e):
        return respell.Tree(e).text(speller=speller) if isinstance(e, str) else e
    said.change(say)
    return True


# Named signals

def signals(rng, said):
    """Up to two subexpressions without derivatives become variables of their own, with an equation each."""
    if said.form not in ("equations", "quasilinear", "control") or said.system.get("transpose"):
        return False
    put = False
    for _ in range(rng.choice([1, 1, 2])):
        put |= signal(rng, said)
    return put


def signal(rng, said):
    s = said.system
    known = set(said.user + said.inputs) - {n for n, _ in said.signals}
    texts = {"equations": ("equations",), "quasilinear": ("alpha", "A"), "control": ("constraints", "F", "G")}[said.form]
    found = set()

    def collect(e):
        if not isinstance(e, str):
            return e
        tree = respell.Tree(e)
        inside = {k for n in range(len(tree.node)) if tree.node[n][0] == "der" for k in tree.graph.cone([n])}
        for n in tree.graph.cone([tree.root]):
            here = tree.graph.names([n])
            if tree.node[n][0] in ("const", "sym", "pi", "der") or n in inside or not here & known or any("'" in m for m in here):
                continue
            found.add(tree.print(n, lambda m: m))
        return e
    said_change(said, texts, collect)
    if not found:
        return False
    chosen = rng.choice(sorted(found))
    name = "s1_"
    taken = said.used() | set(said.user) | set(said.inputs) | set(s.get("parameters") or {}) | {said.time} | set(s.get("tables") or {})
    while name in taken:
        name = f"s{int(name[1:-1]) + 1}_"

    def replace(e):
        if not isinstance(e, str):
            return e
        return replaced(respell.Tree(e), chosen, name)
    said_change(said, texts, replace)
    sign = rng.random() < 0.5
    if said.form == "equations":
        s["equations"].insert(rng.randint(0, len(s["equations"])), f"{name} = {chosen}" if sign else f"{chosen} = {name}")
        said.user.insert(rng.randint(0, len(said.user)), name)
    elif said.form == "quasilinear":
        s["A"].rows += 1
        s["A"].cols += 1
        if not s["A"].sparse:
            s["A"].entries += [(s["A"].rows - 1, j, 0) for j in range(s["A"].cols)] + [(i, s["A"].cols - 1, 0) for i in range(s["A"].rows - 1)]
        s["alpha"].append(f"{name} - {chosen}" if sign else f"{chosen} - {name}")
        said.user.append(name)
    else:
        said.inputs.append(name)
        s["G"].rows += 1
        if not s["G"].sparse:
            s["G"].entries += [(s["G"].rows - 1, j, 0) for j in range(s["G"].cols)]
        s["constraints"].append(f"{name} - {chosen}" if sign else f"{chosen} - {name}")
    said.signals.append((name, chosen))
    return True


def said_change(said, keys, f):
    s = said.system
    for k in keys:
        if isinstance(s.get(k), Matrix):
            s[k].change(lambda i, j, e: f(e))
        elif k in s:
            s[k] = [respell.on_sides(e, f) for e in s[k]]


def replaced(tree, chosen, name):
    """The tree's text with a subexpression replaced by a name, but not inside der(...)."""
    def walk(e):
        op, *args = tree.node[e]
        if op == "der":
            return tree.print(e, lambda m: m)
        if op not in ("const", "sym", "pi"):
            if tree.print(e, lambda m: m) == chosen:
                return name
            parts = [walk(a) for a in args]
            return f"(-{parts[0]})" if op == "neg" else f"({parts[0]} {op} {parts[1]})" if op in "+-*/^" else f"{op}({', '.join(parts)})"
        return tree.print(e, lambda m: m)
    return walk(tree.root)


KINDS = {"equations": equations, "variables": variables, "signs": signs, "names": names, "units": units,
         "spelling": spelling, "signals": signals}


def rewrite(rng, request, kinds):
    """The request with these rewritings, one after another."""
    said = Said(request)
    for kind in kinds:
        if KINDS[kind](rng, said):
            said.done.append(kind)
    return said
