"""Random systems for the order suite, by number: every class that the reduction treats in a way of its own."""
import random

import invariance

FUNCTIONS = ["sin({})", "cos({})", "exp({})", "sqrt(1 + {}^2)", "log(2 + {}^2)", "tanh({})", "sinh({})"]
SWITCHES = ["abs({})", "max(0, {})", "min({}, 1)", "sqrt({})", "cbrt({})", "sign({})*sqrt(abs({}))"]


def with_names(system):
    return system.request([f"x{k}" for k in range(system.n)])


def poly(rng, names, degree=2):
    out = [str(rng.choice([-2, -1, 0, 1]))]
    for _ in range(rng.randint(1, 3)):
        out.append(f"{rng.choice([-2, -1, 1, 3])}*" + "*".join(rng.choice(names) for _ in range(rng.randint(1, degree))))
    return " + ".join(out)


def components(rng):
    """Products as constraints: unions of sets."""
    x = ["x", "y", "z"]
    a, b = poly(rng, x, 1), poly(rng, x, 2)
    return {"form": "equations", "variables": x, "equations": [f"({a})*({b}) = 0", f"x' = {poly(rng, x)}"] +
            ([f"y' = {poly(rng, x)}"] if rng.random() < 0.5 else [])}


def hidden(rng):
    """A component that is no polynomial factor."""
    f = rng.choice(["exp(x) - 1", "sin(x)", "sinh(x)", "x*cos(x)", "tanh(x)", "log(1 + x)"])
    return {"form": "equations", "variables": ["x", "y"], "equations": [f"x' + x*y' = {poly(rng, ['x', 'y'], 1)}", f"x*y = {f}"]}


def transcendental(rng):
    x = ["x", "y", "z"]
    f = rng.choice(FUNCTIONS).format(rng.choice(x))
    return {"form": "equations", "variables": x,
            "equations": [f"x' = {poly(rng, x)}", f"y = {rng.choice(FUNCTIONS).format('x')} + {poly(rng, ['x'])}", f"z' + y' = {f} + {poly(rng, x, 1)}"]}


def switches(rng):
    f = rng.choice(SWITCHES).replace("{}", rng.choice(["u", "(u - 1)", "(x - y)"]))
    return {"form": "equations", "variables": ["x", "y", "u"],
            "equations": [f"x' = {rng.choice(['-x + y', '1', 'y', 'y - x^2'])}", f"y = {f}", f"u = {rng.choice(['x', '2*x - 1', 'x + 1', 'x^2'])}"]}


def overdetermined(rng):
    """A motion with some of its integrals given, and multiples of them."""
    extra = rng.sample(["x^2 + y^2 = 1", "x*y' - y*x' = 1", "x'^2 + y'^2 = 1", "x^2 + x'^2 = 1", "2*x^2 + 2*y^2 - 2 = 0", "x*x' + y*y' = 0"], rng.randint(1, 4))
    return {"form": "equations", "variables": ["x", "y"], "equations": ["x'' = -x", "y'' = -y"] + extra}


def redundant(rng):
    x = ["x", "y", "z"]
    g, h = poly(rng, x, 2), poly(rng, x, 1)
    k = rng.choice(["2", "(1 + x^2)", "y", "(z - 1)"])
    return {"form": "quasilinear", "variables": x, "A": [["1", "0", poly(rng, x, 1)], ["0", "0", "0"], ["0", "0", "0"], ["0", "0", "0"]],
            "alpha": [poly(rng, x, 1), g, h, f"{k}*({g}) + {rng.choice(['3', '(y)', '0'])}*({h})"]}


def multibody(rng):
    """Points on surfaces, with multipliers."""
    g = rng.choice(["x^2 + y^2 - 1", "x - y^2", "x*y - 1", "x^2 + 2*y^2 - 2", "y - sin(x)", "sqrt(x^2 + y^2) - 1"])
    form = rng.choice(["equations", "lagrangian", "mechanical"])
    if form == "lagrangian":
        return {"form": form, "coordinates": ["x", "y"], "lagrangian": f"(x'^2 + {rng.randint(1, 3)}*y'^2)/2 - {rng.choice(['y', 'x*y', 'x^2'])}", "holonomic": [g]}
    if form == "mechanical":
        return {"form": form, "coordinates": ["x", "y"], "masses": ["1", str(rng.randint(1, 3))], "forces": ["0", "-1"], "constraints": [g]}
    return {"form": form, "variables": ["x", "y", "l"], "equations": ["x'' = -l*x", "y'' = -2*l*y - 1", f"{g} = 0"]}


def spelled(rng):
    """Definite functions, as they come out of forms."""
    a, k = rng.choice(["x^2/(2*e*e)", "(x*x + 1)/(e*e*3)", "x^2*y^2/(1 + e^2)", "(x^2 + y^2)/e", "x^4 + x^2*e^2 + 1"]), rng.choice(["1 + ", "", "y^2 + "])
    return {"form": "equations", "variables": ["x", "e", "y"], "equations": ["x' = 1 + y", "e' = 1", f"{k}{a} = 0"]}


def linear(rng):
    return with_names(invariance.random_linear(rng)[0])["system"]


def polynomial(rng):
    return with_names(invariance.random_polynomial(rng)[0])["system"]


CLASSES = [linear, polynomial, components, hidden, transcendental, switches, overdetermined, redundant, multibody, spelled]


def systems(first, count):
    """(label, request) by number: the same for the same seed."""
    for number in range(count):
        rng = random.Random(f"{first} order {number}")
        make = CLASSES[number % len(CLASSES)]
        system = make(rng)
        request = {"system": system}
        if rng.random() < 0.3 and system["form"] == "equations":
            request["trajectory"] = {"start": 0, "stop": 1, "initial": {v: round(rng.uniform(-2, 2), 2) for v in system["variables"][:rng.randint(1, 3)]}}
        yield f"random {make.__name__} {number}", request
