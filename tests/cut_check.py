"""Only what the outputs depend on is modelled: cut_check.py BUILD_DIR

Random systems of blocks, some of which drive others, with a few outputs. The trajectory alone, where equations may be left
out, must be the one of the whole system, which is modelled where all variables are among the outputs; and so must that beside an
index, where all that does not feed the outputs is left out of the motion, and nothing of what is said. What must be modelled at the
least, and at the most, is known from how the blocks were made. SGA_TEST_SEED, SGA_TEST_SCALE."""
import copy
import random
import sys

from solver import Solver
from tally import Tally, build_folder, scaled, seed

WANT = ["trajectory"]


class Blocks:
    """Blocks of equations; each is of a kind and may be driven by signals of earlier ones."""

    def __init__(self, rng, blocks):
        self.rng, self.variables, self.equations, self.initial = rng, [], [], {}
        self.signals = []         # (expression, block)
        self.sources = []         # by block: the blocks that drive it
        self.own = []             # by block: names
        self.kinds = []           # by block
        self.pulls = []           # by block: does it ask something of the blocks that drive it?
        for k in range(blocks):
            self.add(k)

    def drive(self, k):
        """A bounded signal of some earlier block, or none."""
        if self.signals and self.rng.random() < 0.6:
            text, block = self.rng.choice(self.signals)
            self.sources[k].add(block)
            return f" + {self.rng.randint(1, 3)}*sin({text})"
        return ""

    def add(self, k):
        self.sources.append(set())
        kind = self.rng.choice(["lag", "oscillator", "monitor", "pendulum", "mass", "loop", "circle", "matrix", "bent", "prescribed", "driven", "linkage"])
        a, b, c = (f"{n}{k}" for n in "abc")
        v = round(self.rng.uniform(0.2, 1), 2)
        names, start, tied = [a], {a: v}, False
        if kind == "lag":
            eqs = [f"2*{a}' = -{a}{self.drive(k)}"]
        elif kind == "oscillator":
            names, start = [a, b], {a: v, b: 0}
            eqs = [f"{a}' = {b}", f"{b}' = -{self.rng.randint(1, 4)}*{a}{self.drive(k)}"]
        elif kind == "monitor":       # a is followed by b, which nothing else has to know
            names, start = [a, b], {a: v}
            eqs = [f"{a}' = -{a}^3{self.drive(k)}", f"0 = 3*{b} - {a}^2"]
        elif kind == "pendulum":
            names, start = [a, b, c], {a: 0.6, b: -0.8, f"{a}'": 0, f"{b}'": 0}
            eqs = [f"{a}'' = -{c}*{a}", f"{b}'' = -{c}*{b} - {self.rng.randint(1, 9)}", f"{a}^2 + {b}^2 = 1"]
        elif kind == "mass":          # a coefficient that is no number
            eqs = [f"(2 + sin({a}))*{a}' = 1{self.drive(k)}"]
            tied = True
        elif kind == "loop":          # without velocities, in a circle
            names, start = [a, b], {}
            eqs = [f"{a} = {b}/3 + 1{self.drive(k)}", f"{b} = {a}/3 - t"]
        elif kind == "matrix":        # velocities by a constant matrix
            names, start = [a, b], {a: v, b: -v}
            eqs = [f"2*{a}' + {b}' = -{a}{self.drive(k)}", f"{a}' - 3*{b}' = {b}"]
        elif kind == "bent":          # solved for any value of the rest, though not by a number
            names, start = [a], {}
            eqs = [f"{a} + {self.rng.randint(1, 3)}*{a}^3 + atan({a}) = t{self.drive(k)}"]
        elif kind == "prescribed":    # a given motion, its velocity, and the force that it takes
            names, start = [a, b, c], {}
            eqs = [f"{a} = sin({self.rng.randint(1, 3)}*t)", f"{a}' = {b}", f"{b}' = {c} - {a}{self.drive(k)}"]
        elif kind == "driven":        # index 3, behind what drives it
            names, start = [a, b, c], {a: 0.6, b: -0.8, f"{a}'": 0, f"{b}'": 0}
            eqs = [f"{a}'' = -{c}*{a}{self.drive(k)}", f"{b}'' = -{c}*{b} - 5{self.drive(k)}", f"{a}^2 + {b}^2 = 1"]
            tied = True
        elif kind == "linkage":       # two rods and their forces behind a crank, which turns as it is told
            names, start, push = [a, b, c], {}, self.drive(k) or " + 1"
            eqs = [f"cos({a}) + 2*cos({b}) = 2{push}/20", f"sin({a}) + 2*sin({b}) = 1", f"{c} = {a}''"]
            tied = True
        else:
            names, start = [a, b], {a: 0.6, b: 0.8}
            eqs = [f"{a}' = -{b}", f"{a}^2 + {b}^2 = 1"]
            tied = True
        self.variables += names
        self.equations += eqs
        self.initial.update(start)
        self.own.append(names)
        self.pulls.append(tied)
        self.kinds.append(kind)
        self.signals += [(n, k) for n in names if n != c]

    def request(self, outputs):
        equations = list(self.equations)
        self.rng.shuffle(equations)
        return {"system": {"form": "equations", "variables": self.variables, "equations": equations}, "want": list(WANT),
                "trajectory": {"stop": 1, "samples": 5, "initial": self.initial, "outputs": outputs}}

    def needed(self, blocks):
        """Blocks that these depend on."""
        todo, done = list(blocks), set()
        while todo:
            k = todo.pop()
            if k not in done:
                done.add(k)
                todo += self.sources[k]
        return done


def near(a, b):
    """Rows of two trajectories, within what both say of themselves; b may have more columns."""
    if len(a["rows"]) != len(b["rows"]) or a["columns"] != b["columns"][:len(a["columns"])] or a["ended"] != b["ended"]:
        return False
    for p, q, e, f in zip(a["rows"], b["rows"], a["errors"], b["errors"]):
        if any(abs(x - y) > 2 * (e + f) + 1e-9 for x, y in zip(p, q)):
            return False
    return True


def compare(tally, solver, label, request):
    """The cut answer, after it was compared with that of the whole system."""
    whole = copy.deepcopy(request)
    whole["want"] = request["want"] + ["index", "constraints"]
    beside = copy.deepcopy(whole)
    whole["trajectory"]["outputs"] = request["trajectory"]["outputs"] + every(request["system"])
    a, wrong = solver.solve(request)
    b, other = solver.solve(whole)
    if a is None or b is None:
        tally.check((wrong or {}).get("code") == (other or {}).get("code"), f"{label}: refused alike", (wrong, other))
        return None
    tally.check(near(a["trajectory"], b["trajectory"]), f"{label}: the same motion", (request, a["trajectory"]["rows"], b["trajectory"]["rows"]))
    check_beside(tally, solver, label, beside, a, b)
    tally.check("not_modelled" not in b["evidence"] and b["work"]["variables"] == b["work"]["variables_modelled"], f"{label}: the whole system")
    less = a["evidence"].get("not_modelled", {"variables": 0, "apart": 0, "follow": 0, "names": []})
    moved = a["work"].get("variables_moved", a["work"]["variables_modelled"])
    tally.check(less["variables"] == a["work"]["variables"] - moved == less["apart"] + less["follow"], f"{label}: counts", less)
    here = {v["name"] for v in a["variables"]}
    tally.check(len(a["variables"]) == a["work"]["variables_modelled"] and moved == len(here - set(less["names"])), f"{label}: variables", (here, less))
    given = {**a["trajectory"]["initial"]["given"], **a["trajectory"]["initial"].get("not_modelled", {})}
    tally.check(set(given) == set(request["trajectory"]["initial"]), f"{label}: no given value is lost", given)
    return a


def every(system):
    """All variables."""
    return system["variables"] if "variables" in system else system["coordinates"]


def check_beside(tally, solver, label, request, cut, whole):
    """Where more than the motion is wanted: what is said is of the whole system, the motion of what feeds it."""
    c, wrong = solver.solve(request)
    if not tally.check(c is not None, f"{label}: beside an index", wrong):
        return
    tally.check(near(c["trajectory"], whole["trajectory"]), f"{label}: the same motion beside an index", (request, c["trajectory"]["rows"], whole["trajectory"]["rows"]))
    for key in ("verdict", "dimensions", "index", "variables", "constraints"):
        tally.check(c[key] == whole[key], f"{label}: {key} of the whole system", (c[key], whole[key]))
    less = c["evidence"].get("not_modelled")
    moved, modelled = c["work"].get("variables_moved", c["work"]["variables"]), c["work"]["variables_modelled"]
    tally.check(modelled == c["work"]["variables"] == moved + (less or {"variables": 0})["variables"], f"{label}: counts beside an index", c["work"])
    tally.check(moved <= cut["work"]["variables_modelled"] or c["verdict"] != "unique" or "whole system" in label, f"{label}: no more than the motion alone",
                (request, moved, cut["work"]))


def random_systems(tally, solver, rng):
    cut = 0
    for n in range(scaled(60)):
        blocks = Blocks(rng, rng.randint(2, 7))
        chosen = rng.sample(range(len(blocks.own)), rng.choice([1, 1, 2]) if len(blocks.own) > 2 else 1)
        outputs = [rng.choice(blocks.own[k]) for k in chosen]
        request = blocks.request(outputs)
        if rng.random() < 0.2:
            request["trajectory"]["hold"] = [rng.choice([v for v in blocks.initial if "'" not in v] or blocks.variables)]
        a = compare(tally, solver, f"random {n}", request)
        if a is None:
            continue
        got = {v["name"].rstrip("'") for v in a["variables"]}
        must = set(outputs)
        most = {v for k in blocks.needed(chosen) for v in blocks.own[k]}
        tally.check(must <= got, f"random {n}: outputs are modelled", got)
        # what only follows from states is left out, and what the outputs need is not
        only_lags = not any(blocks.pulls) and "hold" not in request["trajectory"]
        if only_lags:
            tally.check(got <= most, f"random {n}: nothing else is modelled", (request, sorted(got - most)))
        # a linkage among what is needed may start in several ways, and then the whole is asked where
        if "hold" not in request["trajectory"] and "linkage" not in [blocks.kinds[k] for k in blocks.needed(chosen)]:
            beside, _ = solver.solve({**request, "want": ["trajectory", "index"]})
            out = set(beside["evidence"].get("not_modelled", {"names": []})["names"])
            tally.check({v["name"] for v in beside["variables"]} - out <= most | {v + "'" for v in most}, f"random {n}: nothing but what feeds the outputs moves",
                        (request, sorted(out), sorted(most)))
        cut += a["work"]["variables_modelled"] < a["work"]["variables"]
    print(f"{cut} systems were cut")
    tally.check(cut >= scaled(20), "systems are cut", cut)


def pendulums(n, outputs):
    variables = [v for k in range(n) for v in (f"x{k}", f"y{k}", f"lam{k}")]
    equations = [e for k in range(n) for e in (f"x{k}'' = -lam{k}*x{k}", f"y{k}'' = -lam{k}*y{k} - {10 + k}", f"x{k}^2 + y{k}^2 = 1")]
    initial = {**{f"x{k}": 1 for k in range(n)}, **{f"y{k}": 0 for k in range(n)}}
    return {"system": {"form": "equations", "variables": variables, "equations": equations}, "want": list(WANT),
            "trajectory": {"stop": 2, "samples": 5, "initial": initial, "outputs": outputs}}


def decoupled(tally, solver):
    """Of 200 subsystems one costs what it costs alone."""
    one, many = solver.solve(pendulums(1, ["x0"]))[0], solver.solve(pendulums(200, ["x0"]))[0]
    for key in ("variables_modelled", "pivots", "steps", "rejected_steps", "evaluations"):
        tally.check(one["work"][key] == many["work"][key], f"200 subsystems: {key}", (one["work"][key], many["work"][key]))
    tally.check(many["work"]["variables"] == 1000 and many["evidence"]["not_modelled"]["apart"] == 995, "200 subsystems: counts", many["work"])
    tally.check(one["trajectory"]["rows"] == many["trajectory"]["rows"], "200 subsystems: the same numbers")
    tally.check(one["evidence"]["decisions"] == many["evidence"]["decisions"], "200 subsystems: the same decisions", many["evidence"]["decisions"])


CHAIN = {"form": "equations", "variables": ["x", "y", "z", "w"], "equations": ["x' = -x", "y' = x - y", "z = x + y", "w' = z*w"]}


def explicit(initial, outputs, **more):
    return {"system": copy.deepcopy(CHAIN), "want": list(WANT),
            "trajectory": {"stop": 1, "samples": 3, "initial": initial, "outputs": outputs, **more}}


def rules(tally, solver):
    """What is kept, name by name."""
    given = {"x": 1, "y": 2, "w": 1}
    table = [
        ("one state", explicit(given, ["x"]), ["x"]),
        ("what drives it", explicit(given, ["y"]), ["x", "y"]),
        ("a sum", explicit(given, ["x + z"]), ["x", "y", "z"]),
        ("what follows has an initial value", explicit({**given, "z": 3}, ["x"]), ["x", "y", "z"]),
        ("a start that is not given is tied to what follows", explicit({"x": 1, "w": 1}, ["y"]), ["x", "y", "z"]),
        ("hold", explicit(given, ["x"], hold=["w"]), ["x", "y", "z", "w"]),
        ("an event", explicit(given, ["x"], events=[{"name": "e", "expression": "y - 1", "direction": "any", "action": "record"}]), ["x", "y"]),
        ("the time alone", explicit(given, ["t"]), []),
    ]
    for label, request, names in table:
        a = compare(tally, solver, label, request)
        if a:
            tally.check([v["name"] for v in a["variables"]] == names, f"{label}: modelled", [v["name"] for v in a["variables"]])
    # a projection that moves given values is that of the whole system
    moved = {"system": {"form": "equations", "variables": ["x", "y", "z"], "equations": ["x' = -y", "x^2 + y^2 = 1", "z = 3*x"]}, "want": list(WANT),
             "trajectory": {"stop": 0.5, "samples": 3, "initial": {"x": 0.5, "y": 0.5}, "outputs": ["x"]}}
    a = compare(tally, solver, "a start that is moved", moved)
    tally.check(a["work"]["variables_modelled"] == 3, "a start that is moved: all is modelled", a["work"])
    restrict = {"system": {"form": "quasilinear", "variables": ["x", "y", "z", "w"], "A": [["1", "0", "0", "0"], ["0", "1", "0", "0"]],
                           "alpha": ["y", "-x"], "restrict": ["z - x", "w^2 - y - 4"]}, "want": list(WANT),
                "trajectory": {"start": 0, "stop": 1, "samples": 3, "initial": {"x": 1, "y": 0, "w": 2}, "outputs": ["x"]}}
    a = compare(tally, solver, "restrictions", restrict)
    tally.check([v["name"] for v in a["variables"]] == ["x", "y", "w"], "restrictions: modelled", a["variables"])
    # a constraint downstream that restricts what is upstream
    back = {"system": {"form": "equations", "variables": ["x", "u", "y", "w"], "equations": ["x' = u", "y' = x", "y = sin(t)", "w' = x"]}, "want": list(WANT),
            "trajectory": {"stop": 1, "samples": 3, "initial": {"x": 1, "y": 0, "u": 0, "w": 0}, "outputs": ["x"]}}
    a = compare(tally, solver, "a constraint behind", back)
    tally.check([v["name"] for v in a["variables"]] == ["x", "u", "y"], "a constraint behind: modelled", a["variables"])
    # least norm over what is free, and a rate that something else depends on
    free = {"system": {"form": "quasilinear", "variables": ["x", "u", "y"], "A": [["1", "0", "0"], ["0", "0", "0"]], "alpha": ["u", "y - 2*u"]},
            "want": list(WANT), "trajectory": {"stop": 1, "samples": 3, "initial": {"x": 0, "u": 1, "y": 2}, "outputs": ["x"]}}
    compare(tally, solver, "least norm", free)
    rates = copy.deepcopy(free)
    rates["trajectory"]["gauge"] = {"rates": {"u": "-u"}}
    compare(tally, solver, "rates", rates)
    conditions = copy.deepcopy(free)
    conditions["trajectory"]["gauge"] = {"conditions": ["u - cos(t)"]}
    compare(tally, solver, "conditions", conditions)
    mechanical(tally, solver)
    behind(tally, solver)
    energies(tally, solver)
    # all is reduced where the whole system is asked about, or strata of it
    for want in (["trajectory", "constraints"], ["trajectory", "structure"], ["trajectory", "gauge"], ["trajectory", "vector_field"]):
        r, _ = solver.solve({**explicit(given, ["x"]), "want": want})
        tally.check(r and r["work"]["variables_modelled"] == 4, f"want {want}: all is modelled")
    r, _ = solver.solve({**explicit(given, ["x"]), "strata": "solve"})
    tally.check(r and r["work"]["variables_modelled"] == 4, "strata: all is modelled")
    # what is cut away is not examined, and that is said
    clash = {"system": {"form": "equations", "variables": ["x", "y"], "equations": ["x' = -x", "y = 1", "y = 2"]}, "want": list(WANT),
             "trajectory": {"stop": 1, "samples": 3, "initial": {"x": 1, "y": 1}, "outputs": ["x"]}}
    r, _ = solver.solve(clash)
    tally.check(r and "not examined" in r["evidence"]["not_modelled"]["note"] and r["evidence"]["not_modelled"]["names"] == ["y"]
                and r["trajectory"]["initial"]["not_modelled"] == {"y": 1}, "a contradiction apart", r and r["evidence"])
    # a start, and a sweep of starts
    r, _ = solver.solve({**explicit(given, ["y"]), "want": ["consistent_initial"]})
    tally.check(r and r["consistent_initial"]["projected"] == {"x": 1, "y": 2} and r["consistent_initial"]["not_modelled"] == {"w": 1},
                "consistent start", r and r["consistent_initial"])
    sweep = {**explicit(given, ["y"]), "sweep": [{"initial": {"x": 2}}, {"initial": {"y": 5, "w": 7}}]}
    a, b = solver.solve(sweep)[0], solver.solve({**sweep, "want": ["trajectory", "index"]})[0]
    tally.check(a["work"]["variables_modelled"] < 4 and all(near(p, q) for p, q in zip(a["trajectories"], b["trajectories"])), "sweep", a["work"])


def behind(tally, solver):
    """What can be given in other ways than by one number, and what looks so and cannot."""
    decay, swing = ["x' = -x"], ["x' = v", "v' = -x"]
    table = [
        ("a constant matrix", ["x", "p", "q", "r"], decay + ["p' + q' = x - p", "p' + 2*q' = -p - 2*q", "q' + r' = sin(p) - q"], {"p": 1, "q": 1, "r": 1}, ["x"], ["x"]),
        ("one row of a constant matrix", ["p", "q", "r"], ["p' + q' = -p - q", "p' + 2*q' = -p - 2*q", "q' + r' = sin(p) - q"], {"p": 1, "q": 1, "r": 1}, ["q"], ["p", "q"]),
        ("a chain of velocities", ["x", "a", "b", "c"], decay + ["a' + b' = x", "b' + c' = x^2"], {"a": 0, "b": 0, "c": 0}, ["x"], None),
        ("a matrix without an inverse", ["x", "p", "q"], decay + ["p' + q' = x", "2*p' + 2*q' = x^2"], {}, ["x"], ["x", "p", "q"]),
        ("a prescribed motion", ["y", "w", "l"], ["y = sin(t)", "y' = w", "w' = l - 1"], {}, ["y"], ["y"]),
        ("the force that it takes", ["y", "w", "l"], ["y = sin(t)", "y' = w", "w' = l - 1"], {}, ["l"], ["y", "w", "l"]),
        ("a motion that is followed", ["x", "v", "y", "w", "l"], swing + ["y = x", "y' = w", "w' = l - x"], {"v": 0}, ["x"], ["x", "v"]),
        ("bent sensors", ["x", "v", "s", "u"], swing + ["s + s^3 = u*x", "u = sin(x)*exp(v)"], {"v": 0}, ["x"], ["x", "v"]),
        ("a sensor that ends", ["x", "v", "s"], swing + ["s + sqrt(s) = x + 2"], {"v": 0, "s": 1}, ["x"], ["x", "v", "s"]),
        ("a crank behind which a linkage moves", ["x", "a", "b", "f"], ["x' = 1", "cos(x) + 3*cos(a) = 3 + 2*cos(b)", "sin(x) + 3*sin(a) = 2*sin(b)", "f = a'' + b''"], {}, ["x"], None, ["x"]),
        ("a pendulum that is driven", ["x", "v", "p", "q", "l"], swing + ["p'' = -l*p + x", "q'' = -l*q - 1", "p^2 + q^2 = 4"], {"v": 0, "p": 0, "q": -2, "p'": 0, "q'": 0}, ["x"], None, ["x", "v"]),
        ("one whose start does not fit what drives it", ["x", "v", "p", "q", "l"], swing + ["p'' = -l*p + x", "q'' = -l*q - 1", "p^2 + q^2 = 4 + x^2"], {"v": 0, "p": 0.5, "q": -2}, ["x"], None, ["x", "v", "p", "q", "l", "p'", "q'"]),
        ("what restricts the output", ["x", "v", "p"], ["x' = v", "v' = p", "x^2 + p^2 = 1"], {"x": 0.6, "v": 0.8}, ["x"], ["x", "v", "p"], ["x", "v", "p"]),
        ("a circle of values", ["x", "a", "b"], decay + ["a = b/3 + x", "b = a/3 - t"], {}, ["x"], ["x"]),
        ("a circle without an inverse", ["x", "a", "b"], ["x' = -x + a - b"] + ["a = b + x", "b = a - exp(-t)"], {}, ["x"], ["x", "a", "b"]),
        ("a velocity that asks for itself", ["x", "u", "v"], decay + ["v' = u + x", "u = v' - 2*x + x"], {}, ["x"], ["x", "u", "v"]),
        ("a velocity that asks for itself by way of others", ["x", "u", "v", "w"], decay + ["v' = u + x", "u - w' = 0", "w = v - x"], {}, ["x"], ["x", "u", "v", "w"]),
    ]
    for label, variables, equations, initial, outputs, names, *moved in table:
        start = {**({"x": 1} if "x" in variables else {}), **initial}
        request = {"system": {"form": "equations", "variables": variables, "equations": equations}, "want": list(WANT),
                   "trajectory": {"stop": 1, "samples": 3, "initial": start, "outputs": outputs}}
        a = compare(tally, solver, label, request)
        if a and names:
            tally.check([v["name"] for v in a["variables"]] == names, f"{label}: modelled", [v["name"] for v in a["variables"]])
        elif a and not moved:
            tally.check(a["work"]["variables_modelled"] == 1, f"{label}: modelled", a["work"])
        for names in moved:
            c, _ = solver.solve({**request, "want": ["trajectory", "constraints"]})
            left = [v["name"] for v in c["variables"] if v["name"] not in c["evidence"].get("not_modelled", {"names": []})["names"]]
            tally.check(left == names, f"{label}: moved", left)
            left = [v["name"] for v in a["variables"] if v["name"] not in a["evidence"].get("not_modelled", {"names": []})["names"]]
            tally.check(left == names and a["work"].get("variables_moved", a["work"]["variables_modelled"]) == len(names), f"{label}: moved for the trajectory alone", left)


def energies(tally, solver):
    """The energy of what is left out is not known: it is no integral of the part. One that the request names is kept whole."""
    forms = [({"form": "hamiltonian", "variables": ["q1", "q2", "p1", "p2"], "hamiltonian": "(p1^2 + p2^2)/2 + q1^2/2 + q2^4"}, {"q1": 1, "q2": 1, "p1": 0, "p2": 0}, "p2^2/2 + q2^4"),
             ({"form": "lagrangian", "coordinates": ["q1", "q2"], "lagrangian": "(q1'^2 + q2'^2)/2 - q1^2/2 - q2^4"}, {"q1": 1, "q2": 1, "q1'": 0, "q2'": 0}, "q2'^2/2 + q2^4")]
    for system, initial, own in forms:
        request = {"system": system, "want": list(WANT), "trajectory": {"stop": 2, "samples": 3, "initial": initial, "outputs": ["q1"]}}
        a, wrong = solver.solve(request)
        tally.check(a and a["work"]["variables_modelled"] == 2 and not a["trajectory"].get("drift", {}).get("integrals"), f"{system['form']}: a part has no energy of the whole", wrong)
        request["trajectory"]["integrals"] = [own]
        a, wrong = solver.solve(request)
        tally.check(a and a["work"]["variables_modelled"] == 4 and len(a["trajectory"]["drift"]["integrals"]) == 2, f"{system['form']}: an integral keeps what it names", wrong)
        request = {**request, "want": ["trajectory", "index"]}
        a, wrong = solver.solve(request)
        tally.check(a and "variables_moved" not in a["work"], f"{system['form']}: moved whole", wrong)


def mechanical(tally, solver):
    """The form's own parts are cut with the rest: masses, forces, constraints, reactions."""
    system = {"form": "mechanical", "coordinates": ["a", "x", "y", "z", "w"], "masses": [[2, 0, 0, 0, 0], [0, 1, 0, 0, 0], [0, 0, 3, 0, 0], [0, 0, 0, 1, "1/2"], [0, 0, 0, "1/2", 2]],
              "forces": ["-a", "-x", "-1", "-z", "w' - w"], "constraints": ["z' - w^2 - 1", "x^2 + y^2 - 1"]}
    start = {"a": 1, "a'": 0, "x": 0.6, "y": 0.8, "x'": 0.4, "y'": -0.3, "z": 0, "z'": 2, "w": 1, "w'": 0}
    table = [(["a"], {}, ["a", "a'"]), (["y", "reaction_x"], {}, ["x", "y", "x'", "y'", "lambda2"]), (["z'"], {}, ["z", "w", "z'", "w'", "lambda1"]),
             (["a + reaction_w"], {}, ["a", "z", "w", "a'", "z'", "w'", "lambda1"]),
             (["x"], {"events": [{"name": "e", "expression": "a - 1/2", "direction": "any", "action": "record"}]}, ["a", "x", "y", "a'", "x'", "y'", "lambda2"])]
    for outputs, more, names in table:
        request = {"system": system, "want": list(WANT), "trajectory": {"start": 0, "stop": 1, "samples": 3, "initial": start, "outputs": outputs, **more}}
        a = compare(tally, solver, f"mechanical {outputs}", request)
        if a:
            tally.check(sorted(v["name"] for v in a["variables"]) == sorted(names), f"mechanical {outputs}: modelled", [v["name"] for v in a["variables"]])
    power = {"system": system, "want": list(WANT), "trajectory": {"start": 0, "stop": 1, "samples": 3, "initial": start, "outputs": ["a", "reaction_power"]}}
    a, _ = solver.solve(power)
    tally.check(a and a["work"]["variables_modelled"] == a["work"]["variables"], "mechanical: the power needs all")


def main():
    tally, solver = Tally("cut"), Solver(build_folder())
    rng = random.Random(seed(20260501))
    rules(tally, solver)
    decoupled(tally, solver)
    random_systems(tally, solver, rng)
    return tally.end()


if __name__ == "__main__":
    sys.exit(main())
