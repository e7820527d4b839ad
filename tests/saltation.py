"""Motions through events that set variables, differentiated: cases of sensitivities_check.py

Closed forms are differentiated by SymPy; what has none is held against differences of motions."""
import copy
import re

import sympy


def events(*all_):
    """(function, direction, what is set, more members)"""
    return [{"name": f"e{i}", "expression": e[0], "direction": e[1], "action": "set", "set": e[2], **(e[3] if len(e) > 3 else {})} for i, e in enumerate(all_)]


def ask(form, parameters, initial, stop, by, starts, at, accuracy=None, **more):
    form = {**form, "parameters": parameters}
    wanted = {k: v for k, v in (("parameters", by), ("initial", starts)) if v}
    outputs = {"outputs": more.pop("outputs")} if "outputs" in more else {}
    return {"system": {**form, **more}, "trajectory": {"start": 0, "stop": stop, "samples": 5, "initial": initial, "events": at, "sensitivities": wanted, **outputs},
            **({"accuracy": accuracy} if accuracy else {})}


def equations(variables, lines):
    return {"form": "equations", "variables": variables, "equations": lines}


def written(ask, table, text):
    """The same without the table: its name is u."""
    def put(part):
        if isinstance(part, str):
            return re.sub(r"\bu\b", f"({text})", part)
        return [put(p) for p in part] if isinstance(part, list) else {k: put(v) for k, v in part.items()} if isinstance(part, dict) else part
    own = copy.deepcopy(ask)
    own["system"]["tables"] = {"u": table}
    return own, put(ask)


def line(times, values):
    """Linear interpolation as an expression; two samples at one time are a step."""
    text = None
    for a, b, x, y in reversed(list(zip(times, times[1:], values, values[1:]))):
        if a == b:
            continue
        piece = f"{x} + ({y} - {x})*(t - {a})/({b} - {a})"
        text = piece if text is None else f"if(t < {b}, {piece}, {text})"
    return {"times": times, "values": values, "interpolation": "linear"}, text


FALL = equations(["x", "v"], ["x' = v", "v' = -g"])
GROUND = ("x", "down", {"v": "-e*v"})

T, G, E, H = sympy.symbols("t g e h", positive=True)


def bounces(count):
    """The height of a ball that falls from H, with its bounces one after the other."""
    first = sympy.sqrt(2 * H / G)
    speed, at, pieces = G * first, first, [(H - G * T**2 / 2, T <= first)]
    for _ in range(count):
        speed = E * speed
        end = at + 2 * speed / G
        pieces.append((speed * (T - at) - G * (T - at)**2 / 2, T <= end))
        at = end
    return sympy.Piecewise(*pieces)


# label, request, closed forms by output, values, by what
CLOSED = [
    ("a ball that bounces", ask(FALL, {"g": "9.81", "e": "0.8", "h": "1.3"}, {"x": "h", "v": 0}, 2.2, ["g", "e", "h"], None, events(GROUND), outputs=["x"]),
     [bounces(6)], {G: "9.81", E: "0.8", H: "1.3"}, [G, E, H]),
    ("a ball that bounces twice", ask(FALL, {"g": "9.81", "e": "0.8", "h": "1.3"}, {"x": "h", "v": 0}, 1.4, ["g", "e", "h"], None, events(GROUND + ({"max": 2},)), outputs=["x"]),
     [bounces(2)], {G: "9.81", E: "0.8", H: "1.3"}, [G, E, H]),
    # integrates and fires: from a reset at r to the threshold h takes log((1 - r)/(1 - h))/g
    ("it integrates and fires", ask(equations(["v"], ["v' = g*(1 - v)"]), {"g": "1.1", "e": "0.2", "h": "0.7"}, {"v": 0}, 2, ["g", "e", "h"], None, events(("v - h", "up", {"v": "e"}))),
     [sympy.Piecewise((1 - sympy.exp(-G * T), T <= -sympy.log(1 - H) / G),
                      (1 - (1 - E) / (1 - H) * sympy.exp(-G * T), T <= (-sympy.log(1 - H) + sympy.log((1 - E) / (1 - H))) / G),
                      (1 - (1 - E)**2 / (1 - H)**2 * sympy.exp(-G * T), True))], {G: "1.1", E: "0.2", H: "0.7"}, [G, E, H]),
]

# label, request
DIFFERENCES = [
    ("a ball, by its start", ask(FALL, {"g": "9.81", "e": "0.8"}, {"x": 1, "v": 0.5}, 1.5, ["g"], ["x", "v"], events(GROUND))),
    ("a floor that moves", ask(FALL, {"g": "9.81", "e": "0.8", "w": "5"}, {"x": 1, "v": 0.5}, 1.5, ["w", "e"], ["x"], events(("x - sin(w*t)/10", "down", {"v": "-e*v + (1 + e)*w*cos(w*t)/10"})))),
    ("what is set depends on time", ask(FALL, {"g": "9.81", "e": "0.8"}, {"x": 1, "v": 0.5}, 1.5, ["e", "g"], ["x"], events(("x", "down", {"v": "-e*v*(1 + t^2/5)", "x": "e*t/10"})))),
    ("against time", ask(FALL, {"g": "2", "e": "1.3"}, {"x": 1, "v": 0.5}, -1.5, ["g", "e"], ["x", "v"], events(("x", "any", {"v": "-e*v"})))),
    ("a field with a kink, and drag", ask(equations(["x", "v"], ["x' = v", "v' = -g - c*abs(v)*v"]), {"g": "9.81", "e": "0.8", "c": "0.3"}, {"x": 1, "v": 0.5}, 1.5, ["g", "e", "c"], ["v"],
                                          events(GROUND))),
    ("a field that jumps", ask(equations(["x", "v"], ["x' = v", "v' = -g - c*sign(v)"]), {"g": "9.81", "e": "0.8", "c": "0.9"}, {"x": 1, "v": 0.5}, 1.2, ["g", "e", "c"], ["v"], events(GROUND))),
    ("a relay", ask(equations(["x", "m"], ["x' = m - k*x/4", "m' = 0"]), {"k": "0.7", "h": "0.9"}, {"x": 0, "m": 1}, 6, ["k", "h"], ["x", "m"],
                    events(("x - h", "up", {"m": "-1"}), ("x + h", "down", {"m": "1 + k/5"})))),
    ("an oscillator in a clearance", ask(equations(["x", "v"], ["x' = v", "v' = -k*x - c*v + sin(2*t)"]), {"k": "2.3", "c": "0.1", "h": "0.6", "e": "0.9"}, {"x": 0.1, "v": 0.3}, 6,
                                         ["k", "c", "h", "e"], ["v"], events(("x - h", "up", {"v": "-e*v"}), ("x + h", "down", {"v": "-e*v"})))),
    ("two balls", ask(equations(["x", "v", "y", "w"], ["x' = v", "v' = -g", "y' = w", "w' = -g"]), {"g": "9.81", "e": "0.8"}, {"x": 1, "v": 0, "y": 1.6, "w": 0.1}, 1.2, ["g", "e"], ["x", "y"],
                      events(("x", "down", {"v": "-e*v"}), ("y - x", "down", {"v": "((1 - e)*v + (1 + e)*w)/2", "w": "((1 - e)*w + (1 + e)*v)/2"})))),
    ("a time that is given", ask(FALL, {"g": "9.81", "e": "0.8", "s": "0.3"}, {"x": 1, "v": 0.5}, 0.9, ["e", "s"], ["x"], events(("t - s", "up", {"v": "e*v + x*t", "x": "x^2"})))),
]

PENDULUM = equations(["x", "y", "lam"], ["x'' = -lam*x", "y'' = -lam*y - g", "x^2 + y^2 = L^2"])
OF_PENDULUM = {"g": "9.81", "L": "1.2", "e": "0.8"}


def mechanical(coordinates, masses, forces, constraints):
    return {"form": "mechanical", "coordinates": coordinates, "masses": masses, "forces": forces, "constraints": constraints}


BEAD = mechanical(["x", "y"], ["m", "2"], ["0", "-9.81*m"], ["x^2 + y^2 - L^2"])
DOUBLE = mechanical(["x", "y", "u", "v"], ["m", "m", "1", "1 + x^2/5"], ["0", "-m*9.81", "0", "-9.81"], ["x^2 + y^2 - L^2", "(u - x)^2 + (v - y)^2 - 1"])

# what is set is projected onto constraints, or shared by masses
DIFFERENCES += [
    ("a pendulum at a stop", ask(PENDULUM, OF_PENDULUM, {"x": 1}, 2, ["g", "L", "e"], ["x"], events(("x - 1/2", "down", {"x'": "-e*x'", "y'": "-e*y'"})))),
    ("one velocity of a pendulum", ask(PENDULUM, OF_PENDULUM, {"x": 1}, 1.2, ["g", "L", "e"], ["x"], events(("x - 1/5", "down", {"x'": "-e*x'"})))),
    ("a position of a pendulum", ask(PENDULUM, OF_PENDULUM, {"x": 1}, 1.2, ["g", "L", "e"], ["x"], events(("x - 1/5", "down", {"x": "1/4 + e/5"})))),
    ("a curve on which the rest follows", ask(equations(["x", "y", "z"], ["x' = -y", "y' = x*z", "x^2 + y^2/2 + z = k"]), {"k": "1.5", "e": "0.7"}, {"x": 0.6, "y": 0.4}, 2,
                                              ["k", "e"], ["x"], events(("x", "any", {"x": "e/3"})))),
    ("a circle, of which one coordinate is set", ask(equations(["x", "y"], ["x' = -y", "x^2 + y^2 = k^2"]), {"k": "1.5", "e": "0.7"}, {"x": 1.2}, 2, ["k", "e"], None,
                                                     events(("x - y", "down", {"x": "x + e/6 + t/9"})))),
    ("least movement", ask(equations(["x", "y", "z", "w"], ["x' = z", "y' = w*x", "z = x*y", "w + w^3/5 = k*x + y"]), {"k": "0.5", "e": "0.7"}, {"x": 0.6, "y": 0.4}, 1.6, ["k", "e"], ["x"],
                           events(("x - 4/5", "up", {"z": "e"})))),
    ("index 2", ask(equations(["x", "y", "l"], ["x' = y + x*l", "y' = -x*k + y*l", "x^2 + y^2 = 1 + t/10"]), {"k": "1.5", "e": "0.7"}, {"x": 0.6}, 2, ["k", "e"], ["x"],
                    events(("x - y/2", "any", {"y": "-e*y"})))),
    ("a bead at a wall", ask(BEAD, {"m": "1.3", "L": "1", "e": "0.5"}, {"x": 0.8}, 1.2, ["m", "L", "e"], ["x"], events(("x - 3/5", "down", {"x'": "-e*x'"})))),
    ("masses that are a matrix", ask(mechanical(["q", "s"], [["M + m", "m*l*cos(s)"], ["m*l*cos(s)", "m*l^2"]], ["m*l*s'^2*sin(s)", "-m*9.81*l*sin(s)"], []),
                                     {"M": "2", "m": "0.7", "l": "0.9", "e": "0.6"}, {"q": 0, "q'": 0.8, "s": 0.5}, 1.5, ["M", "m", "l", "e"], ["s"],
                                     events(("q - 1/4", "up", {"q'": "-e*q'"})))),
    ("two rods, of which the end is struck", ask(DOUBLE, {"m": "1.3", "L": "1", "e": "0.5"}, {"x": 0.8, "u": 1.4}, 0.7, ["m", "L", "e"], ["x"], events(("u - 1", "down", {"u'": "-e*u'"})))),
    ("a constraint on velocities", ask(mechanical(["x", "y", "a"], ["m", "m", "1"], ["0.3", "0.1", "k"], ["x'*sin(a) - y'*cos(a)"]), {"m": "1.3", "k": "0.4", "e": "0.5"},
                                       {"x": 0, "y": 0, "a": 0.3, "x'": 1, "a'": 0.2}, 1.5, ["m", "k", "e"], ["a", "a'"], events(("x - e", "up", {"x'": "-e*x'"})))),
]

def sliding(variables, lines, parameters, initial, stop, by, starts=(), **more):
    own = ask(equations(variables, lines), parameters, initial, stop, by, list(starts), [], **more)
    return {**own, "trajectory": {**own["trajectory"], "sliding": True}}


# x0 > 0 comes to 0 at x0/(k - h) and stays there; a block that a ramp pulls sticks until the force is k: v = (t - k)^2/2 from then on
SLIDES_CLOSED = [
    ("onto a surface, for good", sliding(["x"], ["x' = h - k*sign(x)"], {"k": "1.6", "h": "0.5"}, {"x": 1.1}, 2.1, ["k", "h"], ["x"]),
     [sympy.Piecewise((E - (G - H) * T, T < E / (G - H)), (0, True))], {G: "1.6", H: "0.5", E: "1.1"}, [G, H, E]),
    ("a block that is pulled", sliding(["x", "v"], ["x' = v", "v' = t - k*sign(v)"], {"k": "0.9"}, {"x": 0, "v": 0}, 2.2, ["k"], ["x"]),
     [sympy.Piecewise((E, T < G), (E + (T - G)**3 / 6, True)), sympy.Piecewise((0, T < G), ((T - G)**2 / 2, True))], {G: "0.9", E: 0}, [G, E]),
]
SLIDES = [
    ("friction, stick and slip", sliding(["x", "v"], ["x' = v", "v' = -k*x - c*sign(v) + a*sin(2*t)"], {"k": "1.7", "c": "0.5", "a": "1.3"}, {"x": 0.8, "v": 0.1}, 5, ["k", "c", "a"], ["x", "v"])),
    ("on a belt", sliding(["x", "v"], ["x' = v", "v' = -k*x - c*sign(v - w) - v/9"], {"k": "2", "c": "0.7", "w": "0.4"}, {"x": 0, "v": 0.2}, 5, ["k", "c", "w"], ["x"])),
    ("along a surface that moves", sliding(["x", "y"], ["x' = y - sign(x - a*sin(t))", "y' = -y/3 + x*k"], {"k": "0.7", "a": "0.4"}, {"x": 0.6, "y": 0.2}, 3, ["k", "a"], ["x", "y"])),
    ("of index 1", sliding(["x", "y", "z"], ["x' = z - k*sign(x)", "y' = x - y", "z + z^3/9 = cos(t)*a + y"], {"k": "0.9", "a": "1.4"}, {"x": 0.5, "y": 0.1}, 4, ["k", "a"], ["x", "y"])),
    ("of index 3", sliding(["x", "y", "l"], ["x'' = -x/2 + l*(1 + x/4) - c*sign(x')", "y'' = -k*l + a*sin(2*t)", "x + x^2/8 = k*y"], {"c": "0.9", "k": "1.2", "a": "1.4"},
                           {"x": 0.3, "x'": 0.5}, 4, ["c", "k", "a"], ["x", "x'"])),
]


STUCK = [("a start that sticks, moved off its surface", sliding(["x", "v"], ["x' = v", "v' = t - k*sign(v)"], {"k": "0.9"}, {"x": 0, "v": 0}, 2.2, ["k"], ["v"]), "inconsistent_initial",
          "/trajectory/initial")]


def random_slide(rng):
    """An oscillator with dry friction, at rest or on a belt that moves, or a relay; the surface may move with a parameter."""
    p = {"k": f"{rng.uniform(0.8, 2):.3f}", "c": f"{rng.uniform(0.3, 0.9):.3f}", "a": f"{rng.uniform(0.6, 1.6):.3f}", "w": f"{rng.uniform(-0.4, 0.4):.3f}"}
    start, stop = {"x": round(rng.uniform(-1, 1), 3), "v": round(rng.uniform(0.1, 0.9), 3)}, round(rng.uniform(2, 4), 3)
    push = rng.choice(["a*sin(2*t)", "a*cos(t)", "a*sin(t)^2"])
    kind = rng.choice(["friction", "belt", "relay", "two", "index 1"])
    if kind == "relay":
        return sliding(["x", "v"], ["x' = v - c*sign(x - w*t)", f"v' = -k*x - v/3 + {push}/3"], p, start, stop, rng.sample(sorted(p), 2), ["x"])
    if kind == "two":
        lines = ["x' = v", f"v' = -k*x - c*sign(v) - (x - y) + {push}", "y' = u", "u' = x - y - c*sign(u - w)/2"]
        return sliding(["x", "v", "y", "u"], lines, p, {**start, "y": 0.1, "u": -0.2}, stop, rng.sample(sorted(p), 2), ["x"])
    if kind == "index 1":
        return sliding(["x", "v", "f"], ["x' = v", f"v' = f + {push}", "f + f^3/20 = -k*x - c*sign(v)"], p, start, stop, rng.sample(sorted(p), 2), ["v"])
    speed = "w" if kind == "belt" else "0"
    return sliding(["x", "v"], ["x' = v", f"v' = -k*x - c*sign(v - {speed}) + {push}"], p, start, stop, rng.sample(sorted(p), 2), ["x", "v"])


PAIR = equations(["x", "v", "y", "w"], ["x' = v", "v' = -2", "y' = w", "w' = -2"])
BOTH = events(("x", "down", {"v": "-e*v"}), ("y", "down", {"w": "-e*w"}))

# label, request, when derivatives end (None: with the motion's rows), and what is said; None: they do not end
ENDED = [
    ("two balls at once, one of them moved", ask(PAIR, {"e": "0.5"}, {"x": 1, "v": 0, "y": 1, "w": 0}, 1.5, ["e"], ["x"], BOTH), 1, "the events 0 and 1 happen at once"),
    ("two balls at once, both moved", ask(PAIR, {"e": "0.5", "h": "1"}, {"x": "h", "v": 0, "y": "h", "w": 0}, 1.5, ["e", "h"], None, BOTH), None, None),
    ("a floor that is only touched", ask(equations(["x", "v"], ["x' = v", "v' = g"]), {"g": "2"}, {"x": 1, "v": -2}, 2, ["g"], None, events(("x", "any", {"v": "-v"}))), 1, "only touches"),
    ("onto the zero of another event", ask(FALL, {"g": "2"}, {"x": 1, "v": 0}, 2, ["g"], None, events(("x", "down", {"v": "-v + 0.1"}), ("v - 2.1", "down", {"v": "3*v"}))), 1, "zero of event 1"),
    ("at a step of a table", written(ask(FALL, {"g": "2", "s": "0.5"}, {"x": 1, "v": 0}, 1, ["g", "s"], None, events(("t - s", "up", {"v": "v + u"}))),
                                     *line([0, 0.5, 0.5, 2], [1, 1, 0, 0]))[0], 0.5, "at a knot of a table"),
    ("at a kink of a table", written(ask(FALL, {"g": "2", "s": "0.5"}, {"x": 1, "v": 0}, 1, ["s"], None, events(("t - s", "up", {"v": "v + u"}))),
                                     *line([0, 0.5, 2], [1, 1, 0]))[0], 0.5, "at a knot of a table"),
    ("at a step of a table, by what does not move it", written(ask(FALL, {"g": "2"}, {"x": 1, "v": 0}, 1, ["g"], None, events(("t - 1/2", "up", {"v": "v + u"}))),
                                                               *line([0, 0.5, 0.5, 2], [1, 1, 0, 0]))[0], None, None),
    ("an accumulation", ask(FALL, {"g": "2", "e": "0.5"}, {"x": 1, "v": 0}, 12, ["g", "e"], None, events(GROUND)), None, None),
    ("a start at the zero, to the other side", ask(FALL, {"g": "2", "e": "0.5"}, {"x": 0, "v": 1}, 1.4, ["g"], ["x"], events(GROUND)), None, None),
]

REFUSED = [
    ("a start at an event's zero", ask(FALL, {"g": "2", "e": "0.5"}, {"x": 0, "v": 1}, 1.5, ["g"], ["x"], events(("x", "any", {"v": "-e*v"}))), "inconsistent_initial", "/trajectory/initial"),
]


def modes(**all_):
    """name=(values, start)"""
    return {n: {"values": values, "start": start} for n, (values, start) in all_.items()}


# decay from s on, by decimals that no double is; two masses that come to one speed at s, by their impulse
CLOSED += [
    ("a mode that decays", ask(equations(["x"], ["x' = if(m == 1, -g*x, 1)"]), {"g": "1.1", "h": "0.7"}, {"x": 0}, 2, ["g", "h"], None, events(("t - h", "up", {"m": "1"})), modes=modes(m=([0, 1], 0))),
     [sympy.Piecewise((T, T <= H), (H * sympy.exp(-G * (T - H)), True))], {G: "1.1", H: "0.7"}, [G, H]),
    ("a clutch that closes", ask(mechanical(["a", "b"], ["g", "1.3"], ["h", "0"], ["m*(a' - b')"]), {"g": "2.1", "h": "0.7"}, {"a": 0, "b": 0, "a'": 5, "b'": 0}, 2.2, ["g", "h"], None,
                                 events(("t - h", "up", {"m": "1"})), modes=modes(m=([0, 1], 0)), outputs=["a'", "b'"]),
     [sympy.Piecewise((5 + H * T / G, T <= H), ((G * 5 + H * T) / (G + sympy.Rational(13, 10)), True)), sympy.Piecewise((sympy.Integer(0), T <= H), ((G * 5 + H * T) / (G + sympy.Rational(13, 10)), True))],
     {G: "2.1", H: "0.7"}, [G, H]),
]
# each mode has a reduction of its own, with another dimension and index
DIFFERENCES += [
    ("a clutch", ask(mechanical(["a", "b"], ["p", "3"], ["1", "0"], ["m*(a' - b')"]), {"p": "2", "s": "1"}, {"a": 0, "b": 0, "a'": 5, "b'": 0}, 4.2, ["p", "s"], ["a'"],
                     events(("t - s", "any", {"m": "1"}), ("t - 3*s", "any", {"m": "1 - m"})), modes=modes(m=([0, 1], 0)))),
    ("a converter whose choke runs empty", ask(equations(["i", "v"], ["if(s == 2, i, L*i' - if(s == 1, U, 0) + v) = 0", "v' = i - v/R"]), {"L": "1", "U": "12", "R": "1.1", "d": "0.5"},
                                               {"i": 0, "v": 0}, 3, ["L", "U", "R", "d"], None, events(("t - d", "any", {"s": "0"}), ("i", "down", {"s": "2"})),
                                               modes=modes(s=([0, 1, 2], 1)))),
    ("a rope that gets taut", ask(mechanical(["x", "y"], ["m", "1"], ["0", "-10"], ["taut*(x^2 + y^2 - L^2)"]), {"m": "1.2", "L": "1"}, {"x": 0.6, "y": 0}, 0.6, ["m", "L"], ["x"],
                                  events(("x^2 + y^2 - L^2", "up", {"taut": "1"})), modes=modes(taut=([0, 1], 0)))),
    ("a rod whose tip lands", ask(mechanical(["x", "y", "th"], ["m", "m", "m*l^2/3"], ["0", "-10*m", "0"], ["stuck*(y - l*sin(th))"]), {"m": "1.3", "l": "1.1"},
                                  {"x": 0, "y": 2, "th": 0.7, "th'": 0.3}, 0.8, ["m", "l"], ["y", "th"], events(("y - l*sin(th)", "down", {"stuck": "1"})),
                                  modes=modes(stuck=([0, 1], 0)), outputs=["y", "th"])),
    ("a rocking block", ask(mechanical(["x", "y", "th"], ["m", "m", "I"], ["0", "-m*g", "0"], ["x + foot*b*(cos(th) - 1) + h*sin(th)", "y + foot*b*sin(th) - h*cos(th)"]),
                            {"m": "1", "b": "1", "h": "2", "g": "10", "I": "1.7"}, {"th": "-1/5", "x": "b*(1 - cos(1/5)) + h*sin(1/5)", "y": "b*sin(1/5) + h*cos(1/5)"}, 1.3,
                            ["b", "I", "g"], None, events(("th", "up", {"foot": "-foot"}), ("th", "down", {"foot": "1"})), modes=modes(foot=([1, -1], 1)), outputs=["th", "th'"])),
    ("a brake that is let go", ask(equations(["x", "v", "f"], ["x' = v", "v' = f - k*x", "if(hold == 1, v, f) = 0"]), {"k": "1.2", "c": "0.5"}, {"x": 1, "v": 0}, 3, ["k", "c"], ["x"],
                                   events(("x - c", "down", {"hold": "1"}, {"once": True}), ("t - 2 - c", "up", {"hold": "0"})), modes=modes(hold=([0, 1], 0)))),
    ("least movement onto a mode", ask(equations(["a", "b", "l"], ["p*a' = -l - a/5", "3*b' = l", "if(m == 1, a - b*c, l) = 0"]), {"p": "2", "c": "0.9"}, {"a": 5, "b": 0}, 2, ["p", "c"], ["a"],
                                       events(("a - 4", "down", {"m": "1"})), modes=modes(m=([0, 1], 0)))),
]


def random_table(rng):
    """A motion with walls and a table in its field, in what is set, or in where a wall is: lines, lines with a step, or a cubic, which a spline reproduces."""
    p = {"k": f"{rng.uniform(1, 4):.3f}", "e": f"{rng.uniform(0.4, 1.1):.3f}", "h": f"{rng.uniform(0.5, 0.8):.3f}"}
    times = [0, round(rng.uniform(0.3, 0.9), 3), round(rng.uniform(1, 1.6), 3), round(rng.uniform(1.8, 2.2), 3), 3]
    where, kind = rng.choice(["field", "set", "wall", "constraint", "mode"]), rng.choice(["line", "step", "cubic"])
    if kind == "cubic":
        a, b = (rng.randint(-3, 3) / 8 for _ in range(2))
        table, text = {"times": times, "values": [f"{a}*({t})^3 + {b}*({t})^2 + 1/4" for t in times]}, f"{a}*t^3 + {b}*t^2 + 1/4"
    else:
        values = [round(rng.uniform(-0.5, 0.5), 3) for _ in times]
        if kind == "step" and where not in ("wall", "constraint"):
            times, values = times[:3] + times[2:], values[:3] + [values[2] + 0.5] + values[3:]
        table, text = line(times, values)
    lines, variables, more = ["x' = v", "v' = -k*x" + (" + u" if where == "field" else "")], ["x", "v"], {}
    hit, wall = "-e*v" + (" + u*x" if where == "set" else ""), "h + u/20" if where == "wall" else "h"
    walls = [(f"x - {wall}", "up", {"v": hit}), (f"x + {wall}", "down", {"v": hit})]
    if where == "constraint":
        lines, variables = ["x' = v", "v' = -f", "f + f^3/9 = k*x + u"], ["x", "v", "f"]
    if where == "mode":
        lines, more = ["x' = v", "v' = -k*x + m*u"], {"modes": modes(m=([1, 2], 1))}
        walls[0][2]["m"] = "3 - m"
    ask_ = ask(equations(variables, lines), p, {"x": 0.1, "v": round(rng.uniform(1, 1.6), 3)}, 2.7, rng.sample(sorted(p), 2), ["v"], events(*walls), **more)
    return f"{kind} in {where}", *written(ask_, table, text)


def random_case(rng):
    """An oscillator or a pendulum with walls, in a form and with a mode or without."""
    p = {"k": f"{rng.uniform(1, 4):.3f}", "c": f"{rng.uniform(0, 0.3):.3f}", "h": f"{rng.uniform(0.3, 0.7):.3f}", "e": f"{rng.uniform(0.4, 1.1):.3f}"}
    by, stop, hit = rng.sample(sorted(p), 2), round(rng.uniform(1.2, 3), 3), rng.choice(["-e*v", "-e*v + sin(t)/9", "-e*v*(1 + x^2)"])
    start = {"x": round(rng.uniform(-0.2, 0.2), 3), "v": round(rng.choice([-1, 1]) * rng.uniform(0.8, 1.6), 3)}
    walls = [("x - h", "up", {"v": hit}), ("x + h", "down", {"v": hit})]
    kind = rng.choice(["plain", "mode", "index 3", "mechanical"])
    if kind == "plain":
        return ask(equations(["x", "v"], ["x' = v", f"v' = -k*x - c*v + {rng.randint(1, 3)}*sin({rng.randint(1, 3)}*t)"]), p, start, stop, by, ["x", "v"], events(*walls))
    if kind == "mode":
        lines = ["x' = v", "v' = -c*v + sin(2*t) + f", "if(s == 1, f + 20*k*(x - h), f + k*x) = 0"]
        return ask(equations(["x", "v", "f"], lines), p, start, stop, by, ["v"], events(("x - h", "up", {"s": "1"}), ("x - h", "down", {"s": "0", "v": "e*v"}), walls[1]),
                   modes=modes(s=([0, 1], 0)))
    if kind == "index 3":
        return ask(equations(["x", "y", "l"], ["x'' = -l*x - c*x'", "y'' = -l*y - k", "x^2 + y^2 = 1"]), p, {"x": start["x"], "y": -1, "x'": start["v"]}, stop, by, ["x'"],
                   events(("x - h", "up", {"x'": "-e*x'"}), ("x + h", "down", {"x'": "-e*x'", "y'": "-e*y'"})))
    return ask(mechanical(["x", "y", "z"], ["1", "h + 1", "2"], ["-c*x'", "-k", "x - z"], ["x^2 + y^2 - 1", "z - x*y"]), p, {"x": start["x"], "y": -1, "x'": start["v"]}, stop, by, ["x'"],
               events(("x - h", "up", {"x'": "-e*x'"}), ("x + h", "down", {"x'": "-e*x'"})))


def held(label, *names):
    """The same from a start of which all is determined, as double-double needs it."""
    request = dict(DIFFERENCES)[label]
    return {**request, "trajectory": {**request["trajectory"], "hold": list(names)}}


FINE_STARTS = {label: held(label, *names) for label, *names in (("a bead at a wall", "x", "x'"), ("two rods, of which the end is struck", "x", "u", "x'", "u'"),)}
