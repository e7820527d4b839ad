"""Equations and variables in another order, with other signs and factors, as the form allows."""
from fractions import Fraction

import respell
from said import Matrix, moved, places, rename_start, rescale_start, times


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
