"""Netlists: equations against stamps of their own, motions against closed forms, operating points against NumPy, refusals by line."""
import math
import warnings

import mpmath
import numpy

from expression import Arithmetic, Graph

# text, value
NUMBERS = [("4.7k", 4700), ("10u", 1e-5), ("10uF", 1e-5), ("2MEG", 2e6), ("1e-3", 1e-3), ("100n", 1e-7), ("3mil", 3 * 25.4e-6), ("-5", -5), (".5", 0.5), ("2m", 2e-3), ("1.5e3k", 1.5e6),
           ("3p", 3e-12), ("7f", 7e-15), ("1g", 1e9), ("2t", 2e12), ("10ohm", 10), ("5V", 5)]
NOT_NUMBERS = ["1k5", "k", "", "1..2", "--1", "0x10"]


def network(rng):
    """(netlist, elements): random, each node to be reached, values of all sizes."""
    nodes = ["0", *(str(k) for k in range(1, rng.randrange(2, 6)))]
    elements = [("V1", nodes[1], "0", {"dc": rng.uniform(-5, 5)})]
    for k, kind in enumerate([rng.choice("RLCIEFGHRRCC") for _ in range(rng.randrange(3, 10))]):
        a, b = rng.sample(nodes, 2)
        value = rng.choice([-1, 1] if kind in "EFGH" else [1]) * 10 ** rng.uniform(-6, 4)
        if kind in "EG":
            elements.append((f"{kind}{k}", a, b, {"value": value, "control": tuple(rng.sample(nodes, 2))}))
        elif kind in "FH":
            elements.append((f"{kind}{k}", a, b, {"value": value, "source": "V1"}))
        else:
            elements.append((f"{kind}{k}", a, b, {"dc": value} if kind == "I" else {"value": value}))
    for n in nodes[1:]:
        elements.append((f"Rload{n}", n, "0", {"value": rng.uniform(1, 1000)}))
    lines = ["a random network"]
    for name, a, b, more in elements:
        rest = [more["dc"]] if "dc" in more else [*more.get("control", ()), *([more["source"]] if "source" in more else []), more["value"]]
        lines.append(" ".join([name if rng.random() < 0.5 else name.lower(), a, b, *(repr(w) if isinstance(w, float) else w for w in rest)]))
    return "\n".join([*lines, ".tran 1m 1", ".end"]), elements


def stamps(elements):
    """(variables, E, A, b): E x' + A x = b, a row for each node in the order in which they come, then the laws."""
    nodes = list(dict.fromkeys(n for name, a, b, more in elements for n in (a, b, *(more.get("control", ()))) if n != "0"))
    branches = [e[0].upper() for e in elements if e[0][0].upper() in "VLEH"]
    variables = ["v_" + n for n in nodes] + ["i_" + e for e in branches]
    n = len(variables)
    e_, a_, b_ = numpy.zeros((n, n)), numpy.zeros((n, n)), numpy.zeros(n)
    v = {node: k for k, node in enumerate(nodes)}
    i = {name: len(nodes) + k for k, name in enumerate(branches)}

    def pair(matrix, row, p, q, x):
        for node, sign in ((p, 1), (q, -1)):
            if node != "0":
                matrix[row, v[node]] += sign * x
    for name, p, q, more in elements:
        name = name.upper()
        for node, sign in ((p, 1), (q, -1)):
            if node == "0":
                continue
            row = v[node]
            if name[0] == "R":
                pair(a_, row, p, q, sign / more["value"])
            elif name[0] == "C":
                pair(e_, row, p, q, sign * more["value"])
            elif name[0] == "I":
                b_[row] -= sign * more["dc"]
            elif name[0] == "G":
                pair(a_, row, *more["control"], sign * more["value"])
            elif name[0] == "F":
                a_[row, i[more["source"]]] += sign * more["value"]
            else:
                a_[row, i[name]] += sign
        if name in i:
            row = i[name]
            pair(a_, row, p, q, 1)
            if name[0] == "V":
                b_[row] = more["dc"]
            elif name[0] == "L":
                e_[row, i[name]] -= more["value"]
            elif name[0] == "E":
                pair(a_, row, *more["control"], -more["value"])
            else:
                a_[row, i[more["source"]]] -= more["value"]
    return variables, e_, a_, b_


def residuals(request, x, dx):
    graph, number = Graph(), Arithmetic(mpmath.mp)
    roots = [graph.equation(e) for e in request["system"]["equations"]]
    env = {"t": 0.0, **x, **{k + "'": v for k, v in dx.items()}}
    for k, text in request["system"].get("parameters", {}).items():
        g = Graph()
        e = g.parse(text)
        env[k] = g.values(g.cone([e]), {}, number)[e]
    value = graph.values(graph.cone(roots), env, number)
    return [value[r] for r in roots]


def equations(tally, spice, rng):
    text, elements = network(rng)
    request = spice.request(text)
    variables, e_, a_, b_ = stamps(elements)
    if not tally.check(request["system"]["variables"] == variables, "spice: variables", (text, request["system"]["variables"], variables)):
        return
    x, dx = numpy.array([rng.uniform(-1, 1) for _ in variables]), numpy.array([rng.uniform(-1, 1) for _ in variables])
    want, got = e_ @ dx + a_ @ x - b_, residuals(request, dict(zip(variables, x)), dict(zip(variables, dx)))
    size = abs(e_) @ abs(dx) + abs(a_) @ abs(x) + abs(b_)
    tally.check(len(got) == len(want) and all(abs(g - w) <= 1e-12 * (1 + s) for g, w, s in zip(got, want, size)), "spice: equations are the stamps", (text, got, list(want)))
    start = request["trajectory"]["initial"]
    # no current through capacitors, no voltage over inductors
    reached = {"0"}
    for _ in elements:
        for name, p, q, more in elements:
            if name[0] != "C" and {p, q} & reached:
                reached |= {p, q}
    if abs(numpy.linalg.cond(a_)) < 1e10 and start:
        true = numpy.linalg.solve(a_, b_)
        tally.check(all(abs(start[n] - w) <= 1e-7 * (1 + abs(w)) for n, w in zip(variables, true)), "spice: operating point", (text, start, list(true)))


def clamp_response(t, k, rate, v0=0.0):
    """v' = (u - v)*rate with u = k*t from v0 at 0."""
    return k * (t - 1 / rate) + (v0 + k / rate) * math.exp(-rate * t)


def pulse_response(t, rate, points):
    """v' = (u - v)*rate, u through the points, from u's first value."""
    v = points[0][1]
    for (t0, u0), (t1, u1) in zip(points, points[1:]):
        span, slope = min(t, t1) - t0, (u1 - u0) / (t1 - t0)
        v = u0 + clamp_response(span, slope, rate, v - u0)
        if t <= t1:
            break
    return v


SQUARE = [(0, 1), (1e-3, 1), (1.1e-3, 3), (2.1e-3, 3), (2.3e-3, 1), (4e-3, 1), (4.1e-3, 3), (5.1e-3, 3), (5.3e-3, 1), (6e-3, 1)]
W = 2 * math.pi * 50
# name: netlist, column, its value at t, tolerance
MOTIONS = {
    "RC charges from uic": ("title\nV1 in 0 DC 5\nR1 in out 1k\nC1 out 0 1u\n.tran 0.1m 5m uic\n", "v_out", lambda t: 5 * (1 - math.exp(-t / 1e-3)), 1e-6),
    "RC rests in its operating point": ("title\nV1 in 0 5\nR1 in out 1k\nC1 out 0 1u\n.tran 0.1m 5m\n", "v_out", lambda t: 5.0, 1e-9),
    "RC from .ic": ("title\nV1 in 0 0\nR1 in out 1k\nC1 out 0 1u\n.ic v(out)=2\n.tran 0.1m 5m\n", "v_out", lambda t: 2 * math.exp(-t / 1e-3), 1e-6),
    "RC from ic=": ("title\nV1 in 0 0\nR1 in out 1k\nC1 in out 1u ic=2\n.tran 0.1m 5m uic\n", "v_out", lambda t: -2 * math.exp(-t / 1e-3), 1e-6),
    "RL from ic=": ("title\nL1 a 0 10m ic=0.5\nR1 a 0 10\n.tran 0.1m 5m uic\n", "i_L1", lambda t: 0.5 * math.exp(-t * 1e3), 1e-6),
    "LC rings": ("title\nL1 a 0 1m ic=0\nC1 a 0 1u ic=3\n.tran 10u 1m uic\n", "v_a", lambda t: 3 * math.cos(t / math.sqrt(1e-9)), 1e-5),
    "sine into RC": ("title\nV1 in 0 SIN(1 2 50)\nR1 in out 1k\nC1 out 0 1u\n.tran 0.1m 40m\n", "v_out",
                     lambda t: 1 + 2 / (1 + (W * 1e-3) ** 2) * (math.sin(W * t) - W * 1e-3 * math.cos(W * t) + W * 1e-3 * math.exp(-t / 1e-3)), 1e-6),
    "sine with delay and damping": ("title\nV1 in 0 SIN(0 1 100 5m 20)\nR1 in 0 1\n.tran 0.5m 20m\n", "v_in",
                                    lambda t: 0.0 if t < 5e-3 else math.exp(-20 * (t - 5e-3)) * math.sin(2 * math.pi * 100 * (t - 5e-3)), 1e-9),
    "sine with phase": ("title\nV1 in 0 DC 3 SIN 0.5 1 100 0 0 30\nR1 in 0 1\n.tran 0.5m 20m\n", "v_in", lambda t: 0.5 + math.sin(2 * math.pi * 100 * t + math.pi / 6), 1e-9),
    "pulses into RC": ("title\nV1 in 0 PULSE(1 3 1m 0.1m 0.2m 1m 3m)\nR1 in out 1k\nC1 out 0 0.1u\n.tran 0.1m 6m\n", "v_out", lambda t: pulse_response(t, 1e4, SQUARE), 1e-6),
    "pieces": ("title\nV1 in 0 PWL(0 0 1m 2\n+ 3m 2 4m -1)\nR1 in 0 1\n.tran 0.5m 6m\n", "v_in", lambda t: float(numpy.interp(t, [0, 1e-3, 3e-3, 4e-3], [0, 2, 2, -1])), 1e-9),
    "a current source charges": ("title\nI1 0 a 1m\nC1 a 0 1u\nR1 a 0 1meg\n.tran 1m 10m uic\n", "v_a", lambda t: 1e3 * (1 - math.exp(-t)), 1e-4),
    "a divider with a gain": ("title\nV1 in 0 SIN(0 1 50)\nR1 in m 1k\nR2 m 0 3k\nE1 out 0 m 0 -4\nR3 out 0 1k\n.tran 1m 40m\n", "v_out", lambda t: -3 * math.sin(W * t), 1e-9),
    "an integrator": ("title\nV1 in 0 SIN(0 1 50)\nR1 in m 1k\nC1 m out 1u\nE1 out 0 0 m 1e6\n.tran 1m 40m\n", "v_out", lambda t: -1e3 / W * (1 - math.cos(W * t)), 1e-4),
    "current mirrored": ("title\nV1 in 0 SIN(0 2 50)\nVs in x 0\nR1 x 0 1k\nF1 0 out Vs 5\nR2 out 0 100\n.tran 1m 40m\n", "v_out", lambda t: math.sin(W * t), 1e-9),
    "transresistance": ("title\nV1 in 0 SIN(0 2 50)\nVs in x 0\nR1 x 0 1k\nH1 out 0 Vs 250\nR2 out 0 100\n.tran 1m 40m\n", "v_out", lambda t: 0.5 * math.sin(W * t), 1e-9),
    "transconductance": ("title\nV1 in 0 SIN(0 2 50)\nG1 0 out in 0 1m\nR2 out 0 {rload}\n.param rload={2*half} half=250\n.tran 1m 40m\n", "v_out", lambda t: math.sin(W * t), 1e-9),
    "a source on a capacitor": ("title\nV1 in 0 SIN(0 1 50)\nC1 in 0 2u\n.tran 1m 40m\n", "i_V1", lambda t: -2e-6 * W * math.cos(W * t), 1e-9),
    "a current into an inductor": ("title\nI1 0 a SIN(0 1 50)\nL1 a 0 10m\n.tran 1m 40m\n", "v_a", lambda t: 10e-3 * W * math.cos(W * t), 1e-9),
}


def motions(tally, spice, solver):
    for name, (text, column, true, within) in MOTIONS.items():
        result, problem = solver.solve(spice.request(text))
        if not tally.check(result is not None and result["trajectory"]["ended"] is None, f"spice: {name}: is solved", problem or result["trajectory"]["ended"]):
            continue
        motion = result["trajectory"]
        k = motion["columns"].index(column)
        worst = max(abs(row[k] - true(row[0])) for row in motion["rows"])
        size = max(abs(true(row[0])) for row in motion["rows"])
        tally.check(worst <= within * (1 + size), f"spice: {name}: the motion", worst)


# netlist, the line, a word of what is said
REFUSED = [("t\nR1 a 0\n", 2, "two nodes and a value"), ("t\nR1 a 0 1k\nD1 a 0 dio\n", 3, "diode"), ("t\nR1 a 0 abc\n", 2, "'abc'"), ("t\nR1 a 0 1k\nR1 a 0 2k\n", 3, "line 2"),
           ("t\n\n* c\nF1 a 0 V9 2\n", 4, "V9"), ("t\nV1 a 0 PULSE(0 1)\n", 2, ".tran"), ("t\nV1 a 0 EXP(0 1)\n", 2, "exp"), ("t\nV1 a 0 PWL(0 1 2)\n.tran 1 2\n", 2, "pairs"),
           ("t\nV1 a 0 PWL(0 1 0 2)\n.tran 1 2\n", 2, "increase"), ("t\nR1 a 0 0\n", 2, "value 0"), ("t\nR1 a 0 {1/0}\n", 2, "division"), ("t\nR1 a 0 {1+}\n", 2, "no value"),
           ("t\nR1 a 0 1\n.subckt x a\n", 3, ".subckt"), ("t\n+ 3\n", 2, "goes on"), ("t\nR1 a 0 1\n.tran 1\n", 3, "stop time"), ("t\nR1 a 0 1\n.ic v(q)=2\n", 3, "node q"),
           ("t\nR1 a 0 1\n.ic a=2\n", 3, "v(NODE)"), ("t\nC1 a 0 1u m=3\n", 2, "m = 3"), ("t\nV1 a 0 SIN(0 1 50 1m 0 90)\n", 2, "jumps"), ("t\nE1 a 0 POLY(1) b 0 1 2\n", 2, "linear"),
           ("t\nR1 a 0 {2\n", 2, "brace"), ("t\n.param x\nR1 a 0 x\n", 2, "NAME=VALUE"), ("t\nR1 a b 1\n", None, "ground"), ("only a title\n", None, "no elements"), ("", None, "no elements"),
           ("t\nV1 a 0 SIN(0 1 2\n", 2, "not closed"), ("t\nV1 a 0 1 2\n", 2, "2"), ("t\nR1 a 0 1\n?? a\n", 3, "no element"), ("t\nV1 a 0 PULSE(0 1 0 1n 1n 1n 4n)\n.tran 1 1\n", 2, "bends"),
           ("t\nR1 a 0 " + "{" + "(" * 200 + "1" + ")" * 200 + "}\n", 2, "no value")]


def refusals(tally, spice, error):
    for text, line, word in REFUSED:
        try:
            got = spice.request(text)
        except error as e:
            tally.check(e.line == line and word in str(e), f"spice: refused {text[:40]!r}", (e.line, str(e)))
        else:
            tally.check(False, f"spice: refused {text[:40]!r}", got)


def numbers(tally, spice):
    for text, value in NUMBERS:
        got = spice.number(text)
        tally.check(got is not None and abs(float(got) - value) <= 1e-15 * abs(value), f"spice: {text}", got)
        if got is not None:
            g = Graph()
            e = g.parse(spice.decimal(got))
            tally.check(abs(g.values(g.cone([e]), {}, Arithmetic(mpmath.mp))[e] - value) <= 1e-15 * abs(value), f"spice: {text} in the grammar", spice.decimal(got))
    tally.check(all(spice.number(t) is None for t in NOT_NUMBERS), "spice: no numbers", [spice.number(t) for t in NOT_NUMBERS])


def told(tally, spice, warning):
    """What is left out is said; what is nobody's business is not."""
    with warnings.catch_warnings(record=True) as said:
        warnings.simplefilter("always")
        spice.request("t\nV1 a 0 DC 1 AC 1 0\nR1 a 0 1k ; load\n.ac dec 10 1 1k\n.print tran v(a)\n.end\nR2 this is behind the end")
    texts = [str(w.message) for w in said if issubclass(w.category, warning)]
    tally.check(len(texts) == 3 and all(any(w in t for t in texts) for w in ("AC value", ".ac", ".print")), "spice: what is left out", texts)
    with warnings.catch_warnings(record=True) as said:
        warnings.simplefilter("always")
        request = spice.request("t\nV1 a 0 1\nV2 a 0 2\n.tran 1 2\n")
    tally.check(any("operating point" in str(w.message) for w in said) and request["trajectory"]["initial"] == {}, "spice: no operating point", [str(w.message) for w in said])


def check(tally, solver, rng, count):
    from sga.convert import ConvertError, ConvertWarning, spice
    numbers(tally, spice)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        for _ in range(count):
            equations(tally, spice, rng)
        motions(tally, spice, solver)
        refusals(tally, spice, ConvertError)
    told(tally, spice, ConvertWarning)
