"""Jumps in other coordinates: used by switch_check.py

x' = a x + b w + sin t with w + w^3/4 = u - c x, where u jumps, is of index 1: x stays and w jumps. Written in p and q, functions of x and w, the
derivatives that stand there are those of both, none of which stays. Its equations are mixed, in any order, its variables of any size.
The motion is the first one, in these coordinates."""
import math

STOP, ROWS = 2, 8
CLOSE = 1e-7

# x and w of p and q, the derivative of x, and p and q of x and w
COORDINATES = [
    ("p + b*q", "q", "p' + b*q'", lambda x, w, b, c: (x - b * w, w)),
    ("p + c*q^2", "q", "p' + 2*c*q*q'", lambda x, w, b, c: (x - c * w * w, w)),
    ("p*exp(c*q)", "q", "p'*exp(c*q) + c*p*exp(c*q)*q'", lambda x, w, b, c: (x * math.exp(-c * w), w)),
    ("p + c*q^3", "q + b*p + b*c*q^3", "p' + 3*c*q^2*q'", lambda x, w, b, c: (x - c * (w - b * x) ** 3, w - b * x)),
]


def put(text, **names):
    """Names of one letter, outside of other names."""
    return "".join(f"({names[k]})" if k in names and not (text[i - 1:i].isalpha() or text[i + 1:i + 2].isalpha()) else k for i, k in enumerate(text))


class Jumps:
    def __init__(self, tally, solver):
        self.tally, self.solver = tally, solver

    def motion(self, variables, equations, initial, parameters, start, method):
        request = {"system": {"form": "equations", "variables": variables, "equations": equations, "parameters": parameters},
                   "trajectory": {"start": start, "stop": STOP - start, "samples": ROWS, "initial": initial}, "accuracy": {"rtol": 1e-9, "method": method}}
        result, problem = self.solver.solve(request)
        ended = problem or result["trajectory"]["ended"]
        return None if ended else [dict(zip(["t"] + variables, r)) for r in result["trajectory"]["rows"]], f"{equations} {variables} {initial}: {ended}"

    def one(self, k, rng):
        a, b0, c0 = (rng.choice([-2, -1, 1, 2]) / 2 for _ in range(3))
        before, after = rng.choice([(0, 1), (1, 3), (0.5, -1), (1, 0), (2, -2)])
        u = rng.choice([f"if(t < 1, {before}, {after})", f"({before} + ({after - before})*step(t - 1))*(1 + t/4)",
                        f"({(before + after) / 2} + ({(after - before) / 2})*sign(t - 1))"])
        rate, graph = f"({a})*x + ({b0})*w + sin(t)", f"w + w^3/4 - {u} + ({c0})*x/2"
        start, method = rng.choice([0, 0, STOP]), rng.choice(["auto", "dop853", "tsit5", "radau", "taylor"])
        plain, said = self.motion(["x", "w"], [f"x' = {rate}", f"{graph} = 0"], {"x": rng.choice([-1, -0.5, 0.3, 1.2])}, {}, start, method)
        self.tally.check(plain, f"jump {k}: what stays is a variable", said)
        if not plain:
            return
        x, w, dx, inverse = rng.choice(COORDINATES)
        b, c, unit = rng.choice([0.5, 1, -1, 0.25]), rng.choice([0.3, -0.2, 0.1]), rng.choice([1, 1, 1e-4, 1e5])
        large = f"{unit:.4f}*p"
        equations = [f"{put(dx, p=large).replace(f'({large})' + chr(39), f'{unit:.4f}*p' + chr(39))} - ({put(rate, x=put(x, p=large), w=put(w, p=large))})",
                     put(graph, x=put(x, p=large), w=put(w, p=large))]
        if rng.random() < 0.4:
            equations = [f"{equations[0]} - 2*({equations[1]})", f"{equations[0]} + 3*({equations[1]})"]
        variables = ["p", "q"]
        rng.shuffle(equations)
        rng.shuffle(variables)
        p, q = inverse(plain[0]["x"], plain[0]["w"], b, c)
        mixed, said = self.motion(variables, [f"{e} = 0" for e in equations], {"p": p / unit, "q": q}, {"b": str(b), "c": str(c)}, start, method)
        self.tally.check(mixed, f"jump {k}: what stays is no variable", said)
        for one, other in zip(plain, mixed or []):
            p, q = inverse(one["x"], one["w"], b, c)
            off = max(abs(other["p"] * unit - p) / (1 + abs(p)), abs(other["q"] - q) / (1 + abs(q)))
            self.tally.check(off <= CLOSE, f"jump {k}: the same motion at {one['t']:.3g}", f"off by {off:.3g}: {said}")
