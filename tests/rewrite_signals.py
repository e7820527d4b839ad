"""Subexpressions as variables of their own, each with an equation that says what it is."""
import respell
from said import Matrix


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
            if tree.node[n][0] in ("const", "sym", "pi", "der", *respell.LOGIC) or n in inside or not here & known or any("'" in m for m in here):
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
            return respell.joined(op, parts)
        return tree.print(e, lambda m: m)
    return walk(tree.root)
