"""Systems of any size whose answers are known: chains, ladders, grids. Each function gives (request, expected),
expected: verdict, dimensions of the generations and of the final set, index, as counted by hand in its text.

large.py NAME N [WANT...] prints the request."""
import json
import math
import random
import sys


def asked(name, system, initial=None, outputs=(), want=("index", "constraints"), stop=1):
    request = {"system": {"name": name, **system}, "want": list(want), "limits": {"seconds": 3600, "megabytes": 2000}}
    if "trajectory" in want:
        request["trajectory"] = {"start": 0, "stop": stop, "samples": 11, "outputs": list(outputs), "initial": initial or {}}
    return request


def chain(n, want=("index", "constraints"), stop=1):
    """n planar pendulums in Cartesian coordinates with multipliers, unit masses and lengths, released at rest from a slope
    of 3 to 4. A constraint, its rate and its second rate for each rod: index 3, dimension 5 n - 3 n."""
    variables, equations, initial = [], [], {}
    for i in range(1, n + 1):
        variables += [f"x{i}", f"y{i}", f"l{i}"]
        dx, dy = (f"(x{i} - x{i - 1})", f"(y{i} - y{i - 1})") if i > 1 else ("x1", "y1")
        ex, ey = (f" + l{i + 1}*(x{i + 1} - x{i})", f" + l{i + 1}*(y{i + 1} - y{i})") if i < n else ("", "")
        equations += [f"x{i}'' = -l{i}*{dx}{ex}", f"y{i}'' = -l{i}*{dy}{ey} - 10", f"{dx}^2 + {dy}^2 = 1"]
        initial.update({f"x{i}": f"{3 * i}/5", f"y{i}": f"-{4 * i}/5", f"x{i}'": 0, f"y{i}'": 0})
    return (asked(f"{n} pendulums", {"form": "equations", "variables": variables, "equations": equations}, initial, ("x1", "y1"), want, stop),
            {"verdict": "unique", "generations": [4 * n, 3 * n, 2 * n], "index": 3})


def ladder(n, want=("index", "constraints"), stop=1):
    """n cells of a capacitor to ground behind a resistor u = i + i^3, driven by sin(t). One constraint a resistor, index 1."""
    variables, equations = [], []
    for k in range(1, n + 1):
        variables += [f"v{k}", f"i{k}"]
        equations += [f"v{k}' = i{k}" + (f" - i{k + 1}" if k < n else ""),
                      (f"v{k - 1}" if k > 1 else "sin(t)") + f" - v{k} = i{k} + i{k}^3"]
    return (asked(f"{n} cells of a nonlinear ladder", {"form": "equations", "variables": variables, "equations": equations}, {}, ("v1",), want, stop),
            {"verdict": "unique", "generations": [n], "index": 1})


def scattered(n, want=("index", "constraints"), stop=1):
    """n equations with a derivative and n without, each with unknowns from anywhere: a random graph, whose factors fill. Index 1."""
    rng = random.Random(n)
    variables, equations = [f"x{k}" for k in range(n)] + [f"y{k}" for k in range(n)], []
    for k in range(n):
        a, b, c, d = (rng.randrange(n) for _ in range(4))
        equations += [f"x{k}' = -x{k}^3 + y{a} - sin(x{b})", f"y{k}^3 + y{k} = x{k} + x{c}*sin(x{d})/2"]
    return (asked(f"{n} unknowns that follow from others anywhere", {"form": "equations", "variables": variables, "equations": equations}, {}, ("x1",), want, stop),
            {"verdict": "unique", "generations": [n], "index": 1})


def pairs(n, want=("index", "constraints"), stop=1):
    """n masses (n even) on springs, joined in rigid pairs: n/2 constraints of three generations, index 3; linear."""
    m = n // 2
    variables = [f"x{k}" for k in range(1, n + 1)] + [f"l{k}" for k in range(1, m + 1)]
    equations = []
    for k in range(1, n + 1):
        left, right = (f"x{k - 1}" if k > 1 else "0"), (f"x{k + 1}" if k < n else "0")
        equations.append(f"x{k}'' = {left} - 2*x{k} + {right} {'-' if k % 2 else '+'} l{(k + 1) // 2}")
    equations += [f"x{2 * k} - x{2 * k - 1} = 1" for k in range(1, m + 1)]
    return (asked(f"{n} masses in rigid pairs", {"form": "equations", "variables": variables, "equations": equations}, {}, ("x1",), want, stop),
            {"verdict": "unique", "generations": [2 * n, 2 * n - m, 2 * n - 2 * m], "index": 3})


def grid(n, nonlinear=False, want=("index", "constraints"), stop=1):
    """n x n nodes (n >= 3), a capacitor to ground at each but those of the last column, inductors along the rows, resistors along
    the columns; voltage sources set the first column. A node of the last column has inductors and current sources only (there its
    resistors are left out), so that its inductors form a cutset. Source nodes: e fixed, its capacitor's current follows. Index 2:
    constraints e = s(t) of the sources; the cutsets i_k = source; their rates give the source currents and the potentials of the
    cutset nodes."""
    variables, equations = [], []
    def e(r, c):
        return f"e{r}_{c}"
    for r in range(n):
        for c in range(n):
            variables.append(e(r, c))
            terms = []
            if c > 0:
                terms.append(f"i{r}_{c - 1}")
            if c < n - 1:
                terms.append(f"-i{r}_{c}")
            if c == n - 1:
                equations.append(f"{' + '.join(terms)} = sin(t + {r})")
                continue
            for q in (r - 1, r + 1):
                if 0 <= q < n:
                    d = f"({e(q, c)} - {e(r, c)})"
                    terms.append(f"{d}^3 + {d}" if nonlinear else d)
            if c == 0:
                terms.append(f"j{r}")
            equations.append(f"{e(r, c)}' = {' + '.join(terms)}")
        for c in range(n - 1):
            variables.append(f"i{r}_{c}")
            equations.append(f"i{r}_{c}' = {e(r, c)} - {e(r, c + 1)}")
        variables.append(f"j{r}")
        equations.append(f"{e(r, 0)} = cos({r + 1}*t)")
    size = n * n + n * (n - 1) + n
    return (asked(f"a network of {n} x {n} nodes", {"form": "equations", "variables": variables, "equations": equations}, {}, (e(0, 1),), want, stop),
            {"verdict": "unique", "generations": [size - 2 * n, size - 4 * n], "index": 2})


def truss(n, want=("index", "constraints"), stop=1):
    """n x n joints in the plane, joined along each row by rigid bars, the first of each row held by a bar to the wall, along
    the columns by springs. A bar each joint: index 3, dimension 4 n^2 - 2 n^2."""
    variables, equations, initial = [], [], {}
    for r in range(n):
        for c in range(n):
            k = f"{r}_{c}"
            variables += [f"x{k}", f"y{k}", f"l{k}"]
            dx, dy = (f"(x{k} - x{r}_{c - 1})", f"(y{k} - y{r}_{c - 1})") if c else (f"x{k}", f"(y{k} - {r})")
            fx, fy = [f"-l{k}*{dx}"], [f"-l{k}*{dy}", "-1"]
            if c < n - 1:
                m = f"{r}_{c + 1}"
                fx.append(f"l{m}*(x{m} - x{k})")
                fy.append(f"l{m}*(y{m} - y{k})")
            for q in (r - 1, r + 1):
                if 0 <= q < n:
                    fx.append(f"(x{q}_{c} - x{k})")
                    fy.append(f"(y{q}_{c} - y{k})")
            equations += [f"x{k}'' = {' + '.join(fx)}", f"y{k}'' = {' + '.join(fy)}", f"{dx}^2 + {dy}^2 = 1"]
            initial.update({f"x{k}": c + 1, f"y{k}": r, f"x{k}'": 0, f"y{k}'": 0})
    m = n * n
    return (asked(f"a truss of {n} x {n} joints", {"form": "equations", "variables": variables, "equations": equations}, initial, ("x0_0",), want, stop),
            {"verdict": "unique", "generations": [4 * m, 3 * m, 2 * m], "index": 3})


def heat(n, want=("index", "constraints"), stop=1, spacing=1):
    """The heat equation on (n + 2) x (n + 2) points less the corners; a source u^2/8 inside, the boundary u + u^3 = neighbour + sin t
    algebraic: 4 n constraints, index 1. `spacing` 1/(n + 1): the unit square, stiff."""
    variables, equations, flow = [], [], round(spacing ** -2)
    for r in range(n + 2):
        for c in range(n + 2):
            edge = (r in (0, n + 1)) + (c in (0, n + 1))
            if edge == 2:
                continue
            u = f"u{r}_{c}"
            variables.append(u)
            if edge:
                q = f"u{min(max(r, 1), n)}_{min(max(c, 1), n)}"
                equations.append(f"{u} + {u}^3 = {q} + sin(t)")
            else:
                equations.append(f"{u}' = {flow}*(u{r - 1}_{c} + u{r + 1}_{c} + u{r}_{c - 1} + u{r}_{c + 1} - 4*{u}) + {u}^2/8")
    return (asked(f"heat on {n} x {n} points", {"form": "equations", "variables": variables, "equations": equations}, {}, ("u1_1",), want, stop),
            {"verdict": "unique", "generations": [n * n], "index": 1})


def stokes(n, want=("index", "constraints"), stop=1):
    """Stokes flow in a cavity of n x n cells (velocities on the inner faces, pressures in the cells), the lid moves: div = 0 in each
    cell, of which one follows from the others; a pressure is free. dimension after P1: 2 n (n - 1) + n^2 - (n^2 - 1)."""
    variables = ([f"u{r}_{c}" for r in range(n) for c in range(1, n)] + [f"v{r}_{c}" for r in range(1, n) for c in range(n)]
                 + [f"p{r}_{c}" for r in range(n) for c in range(n)])
    equations = []
    def u(r, c):
        return f"u{r}_{c}" if 0 < c < n else "0"
    def v(r, c):
        return f"v{r}_{c}" if 0 < r < n else "0"
    for r in range(n):
        for c in range(1, n):
            around = [u(r, c - 1), u(r, c + 1), u(r - 1, c) if r else f"(2 - u{r}_{c})", u(r + 1, c) if r < n - 1 else f"(-u{r}_{c})"]
            equations.append(f"u{r}_{c}' = {' + '.join(x for x in around if x != '0')} - 4*u{r}_{c} - p{r}_{c} + p{r}_{c - 1}")
    for r in range(1, n):
        for c in range(n):
            around = [v(r - 1, c), v(r + 1, c), v(r, c - 1) if c else f"(-v{r}_{c})", v(r, c + 1) if c < n - 1 else f"(-v{r}_{c})"]
            equations.append(f"v{r}_{c}' = {' + '.join(x for x in around if x != '0')} - 4*v{r}_{c} - p{r}_{c} + p{r - 1}_{c}")
    for r in range(n):
        for c in range(n):
            equations.append(f"{u(r, c + 1)} - {u(r, c)} + {v(r + 1, c)} - {v(r, c)} = 0")
    size, m = 2 * n * (n - 1) + n * n, n * n - 1
    return (asked(f"Stokes flow in {n} x {n} cells", {"form": "equations", "variables": variables, "equations": equations}, {}, ("u0_1",), want, stop),
            {"verdict": "underdetermined", "generations": [size - m, size - 2 * m], "index": None})


def web(n, want=("index", "constraints"), stop=1):
    """The food web of SUNDIALS' idaFoodWeb on n x n points (n = 20 there): prey c diffuse and grow, predators p are algebraic; no flow over
    the boundary. alpha 50, beta 1000. The start is that of the example, whose predators are a guess. n^2 constraints, index 1."""
    variables, equations, initial = [], [], {}
    m = n - 1
    def around(s, r, c):
        return " + ".join(f"{s}{q if 0 <= q < n else 2 * r - q}_{k if 0 <= k < n else 2 * c - k}"
                          for q, k in ((r - 1, c), (r + 1, c), (r, c - 1), (r, c + 1)))
    for r in range(n):
        for c in range(n):
            u, p = f"c{r}_{c}", f"p{r}_{c}"
            b = f"(1 + 50*{r * c}/{m * m} + 1000*sin(4*pi*{c}/{m})*sin(4*pi*{r}/{m}))"
            variables += [u, p]
            equations += [f"{u}' = {m * m}*({around('c', r, c)} - 4*{u}) + {u}*({b} - {u} - {p}/2000000)",
                          f"0 = {m * m}*({around('p', r, c)} - 4*{p})/20 + {p}*(-{b} + 10000*{u} - {p})"]
            initial[u] = f"10 + (16*{r * c * (m - r) * (m - c)}/{m ** 4})^2"
            initial[p] = 100000
    return (asked(f"a food web on {n} x {n} points", {"form": "equations", "variables": variables, "equations": equations}, initial,
                  ("c0_0", "p0_0"), want, stop),
            {"verdict": "unique", "generations": [n * n], "index": 1})


def mesh(n, want=("index", "constraints"), stop=1):
    """n x n nodes joined by resistors i = u + u^3, a capacitor to ground at every fifth; at the others a leak and a current source. A
    constraint at each of these, coupled with those around it: index 1."""
    variables, equations = [f"e{r}_{c}" for r in range(n) for c in range(n)], []
    for r in range(n):
        for c in range(n):
            terms = []
            for q, k in ((r - 1, c), (r + 1, c), (r, c - 1), (r, c + 1)):
                if 0 <= q < n and 0 <= k < n:
                    d = f"(e{q}_{k} - e{r}_{c})"
                    terms.append(f"{d} + {d}^3")
            flow = " + ".join(terms)
            equations.append(f"e{r}_{c}' = {flow} - e{r}_{c}" if (7 * r + 3 * c) % 5 == 0 else f"{flow} - e{r}_{c}/10 + {(r + c) % 3}*sin(t) = 0")
    held = sum((7 * r + 3 * c) % 5 == 0 for r in range(n) for c in range(n))
    return (asked(f"a mesh of {n} x {n} nodes", {"form": "equations", "variables": variables, "equations": equations}, {}, ("e0_1", f"e{n // 2}_{n // 2}"), want, stop),
            {"verdict": "unique", "generations": [held], "index": 1})


def reaction(n, rng, want=("index", "trajectory"), stop=1):
    """n species u that react, stiffly, on a random graph of links, each held by an algebraic p that meets a nonlinear equation with the p beside it: n
    coupled constraints, index 1. Equations in any order. All coefficients random."""
    u, p = [f"u{k}" for k in range(n)], [f"p{k}" for k in range(n)]
    beside = {k: {(k + 1) % n, (k - 1) % n} for k in range(n)}
    for _ in range(n // 2):
        a, b = rng.sample(range(n), 2)
        beside[a].add(b)
        beside[b].add(a)
    d, rate = rng.choice((1, 10, 100)), rng.choice((10, 1000, 10000))
    equations = []
    for k in range(n):
        about = sorted(beside[k])
        equations += [f"{u[k]}' = {rate}*(sin({p[k]}) - {u[k]}^3) + {' + '.join(u[q] for q in about)} - {len(about)}*{u[k]} + cos({rng.randint(1, 3)}*t)",
                      f"0 = {d}*({' + '.join(p[q] for q in about)} - {len(about)}*{p[k]}) + {u[k]} - {p[k]} - {p[k]}^3 + {rng.randint(-2, 2)}"]
    rng.shuffle(equations)
    initial = {name: round(rng.uniform(-1, 1), 2) for name in u}
    return (asked(f"a reaction of {n} species", {"form": "equations", "variables": u + p, "equations": equations}, initial, rng.sample(u + p, 6), want, stop),
            {"verdict": "unique", "generations": [n], "index": 1})


def network(n, **more):
    """grid with resistors i = u + u^3."""
    return grid(n, True, **more)


FAMILIES = {"chain": chain, "ladder": ladder, "pairs": pairs, "scattered": scattered, "grid": grid, "network": network, "truss": truss, "heat": heat, "stokes": stokes, "web": web, "mesh": mesh}
PLANAR = ("grid", "network", "truss", "heat", "stokes", "web", "mesh")


def sized(name, unknowns):
    """The member of a family that has about so many unknowns of first order."""
    each = {"chain": 5, "ladder": 2, "pairs": 2.5, "scattered": 2, "grid": 2, "network": 2, "truss": 5, "heat": 1, "stokes": 3, "web": 2, "mesh": 1}[name]
    n = unknowns / each
    return max(3, round(math.sqrt(n))) if name in PLANAR else 2 * max(1, round(n / 2))


if __name__ == "__main__":
    json.dump(FAMILIES[sys.argv[1]](int(sys.argv[2]), **({"want": sys.argv[3:]} if sys.argv[3:] else {}))[0], sys.stdout)
