"""Other names, other units, other spellings."""
from fractions import Fraction

import respell
from said import rename_start, rescale_start, times


def names(rng, said):
    """Other names, of variables, inputs, parameters and time; half of the time in reversed alphabetical order."""
    s = said.system
    if any("[" in name for name in said.user + said.inputs):        # a range of names: what loops make of it is not looked into
        return False
    old = sorted(set(said.user + said.inputs + said.sources()))
    parameters = list(s.get("parameters") or {})
    taken = {"pi", "der", said.time} | set(s.get("tables") or {}) | said.used()
    pool = [n for n in ["x", "y", "z", "a1", "b_2", "Omega", "mu", "_u", "w9", "e", "i", "D", "T", "E", "zz", "Q"] if n not in taken]
    pool += [n for n in (f"q_{k}" for k in range(len(old) + len(parameters) + 2)) if n != said.time]
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
