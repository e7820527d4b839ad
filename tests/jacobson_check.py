"""The form `operator` beside Singular's jacobson.lib: jacobson_check.py BUILD_DIR

 * random systems: rank, the order of the torsion part, and, where the rank is full, the solutions: y = V z with
   the last invariant factor of z zero, by our transformation and by Singular's, are power series at an ordinary
   time modulo a prime, and must span one space of the same dimension;
 * pairs of operators (from build/unit/operator_pairs): greatest common right divisor and least common left multiple against
   left ideals of the Weyl algebra over Q(t), division against Singular's products.
Coefficients are not compared: a Jacobson form is unique up to similarity only. Seeded.
"""
import os
import random
import re
import resource
import subprocess
import sys

import ore
from ore import K
from operator_check import moved, polynomial, random_system
from solver import Solver
from tally import Tally, build_folder, scaled, seed

PRIME = (1 << 61) - 1
PLACES = (3, 5, 7, 11, 13, 17)     # where series are taken, modulo the prime
TERMS = 36
SECONDS = 4                        # of CPU for each of Singular's answers


def ask(lines, order="lp(1),lp(1)"):
    """What Singular prints after the word BEGIN; None where it cannot follow."""
    text = "\n".join(['LIB "jacobson.lib";', f"ring r = 0,(t,d),({order});", "def R = nc_algebra(1,1); setring R;", "short = 0;",
                      '"BEGIN";', *lines, "quit;"]) + "\n"
    run = subprocess.run(["Singular", "-q", "--no-warn", "--no-rc"], input=text, capture_output=True, text=True, check=False,
                         preexec_fn=lambda: resource.setrlimit(resource.RLIMIT_CPU, (SECONDS, SECONDS)))
    if run.returncode < 0:
        return None
    said = run.stdout.split("BEGIN", 1)[1]
    if "jacobson.lib::triangle" in said:      # the library's own index error, on matrices that are not full
        return None
    if "?" in said:
        raise RuntimeError(said[-400:])
    return said.split()


def written(x):
    """An operator over Q[t] for Singular: coefficients on the left."""
    return "+".join(f"({str(c.as_expr()).replace('**', '^')})*d^{k}" for k, c in enumerate(x) if c) or "0"


def whole(row):
    """A row times the common denominator of its entries: the same left module over Q(t)."""
    den = K.one
    for x in row:
        for c in x:
            den = den * (K(c.denom) / K(c.denom.gcd(den.numer)))
    return [[c * den for c in x] for x in row]


TERM = re.compile(r"([+-]?)([^+-]+)")


def read(text):
    """An operator that Singular printed: terms with t before d."""
    powers = {}
    for sign, term in TERM.findall(text):
        c, k = K.one, 0
        for factor in term.split("*"):
            if factor[0] == "d":
                k = int(factor[2:] or 1)
            elif factor[0] == "t":
                c = c * K.gens[0] ** int(factor[2:] or 1)
            else:
                c = c * ore.number(factor)
        powers[k] = powers.get(k, K.zero) + (-c if sign == "-" else c)
    return ore.trim([powers.get(k, K.zero) for k in range(max(powers, default=-1) + 1)])


# Power series modulo the prime

def taylor(p, place):
    """A polynomial in t moved to the place."""
    c = [0] * (p.degree() + 1 if p else 1)
    for (k,), v in p.terms():
        c[k] = v.numerator * pow(v.denominator, -1, PRIME) % PRIME
    for i in range(len(c)):
        for j in range(len(c) - 2, i - 1, -1):
            c[j] = (c[j] + place * c[j + 1]) % PRIME
    return (c + [0] * TERMS)[:TERMS]


def times(a, b):
    return [sum(a[i] * b[k - i] for i in range(k + 1)) % PRIME for k in range(min(len(a), len(b)))]


def inverse(a):
    out = [pow(a[0], -1, PRIME)]
    for k in range(1, len(a)):
        out.append(-out[0] * sum(a[i] * out[k - i] for i in range(1, k + 1)) % PRIME)
    return out


def series(c, place):
    """An element of Q(t); None where it has a pole."""
    den = taylor(c.denom, place)
    return times(taylor(c.numer, place), inverse(den)) if den[0] else None


def slope(z):
    return [k * z[k] % PRIME for k in range(1, len(z))]


def apply(x, z, place):
    out = [0] * (TERMS - len(x) + 1)
    for k, c in enumerate(x):
        part = series(c, place)
        if part is None:
            return None
        out = [(a + b) % PRIME for a, b in zip(out, times(part, z))]
        z = slope(z)
    return out


def kernel(x, place):
    """A basis of the series with x z = 0; None where the place is not ordinary."""
    n, a = len(x) - 1, [series(c, place) for c in x]
    if None in a or not a[-1][0]:
        return None
    a = [times(inverse(a[-1]), c) for c in a]
    basis = []
    for first in range(n):
        z = [int(k == first) for k in range(n)]
        for m in range(TERMS - n):         # the coefficient of (t - place)^m in z^(n) + sum a_k z^(k)
            total = 0
            for k in range(n):
                for i in range(m + 1):
                    rise = 1
                    for q in range(k):
                        rise = rise * (m - i + k - q) % PRIME
                    total += a[k][i] * rise * z[m - i + k]
            rise = 1
            for q in range(n):
                rise = rise * (m + n - q) % PRIME
            z.append(-total * pow(rise, -1, PRIME) % PRIME)
        basis.append(z)
    return basis


def rank(rows):
    rows, r = [list(x) for x in rows], 0
    for j in range(len(rows[0]) if rows else 0):
        pivot = next((i for i in range(r, len(rows)) if rows[i][j]), None)
        if pivot is None:
            continue
        rows[r], rows[pivot] = rows[pivot], rows[r]
        inv = pow(rows[r][j], -1, PRIME)
        for i in range(r + 1, len(rows)):
            if rows[i][j]:
                f = rows[i][j] * inv % PRIME
                rows[i] = [(a - f * b) % PRIME for a, b in zip(rows[i], rows[r])]
        r += 1
    return r


def solutions(V, diagonal, place):
    """Series of y = V z for z in the kernel of the diagonal, one row for each; None at a bad place."""
    rows, n = [], len(V)
    for j, x in enumerate(diagonal):
        basis = kernel(x, place)
        if basis is None:
            return None
        for z in basis:
            row = []
            for i in range(n):
                y = apply(V[i][j], z, place)
                if y is None:
                    return None
                row.append(y)
            rows.append(row)
    return rows


def vanish(P, rows, place):
    """P y = 0, as far as the terms go."""
    for row in rows:
        for line in P:
            total = None
            for x, y in zip(line, row):
                part = apply(x, y + [0] * (TERMS - len(y)), place)
                keep = len(y) - len(x)
                part = part[:max(keep, 0)]
                total = part if total is None else [(a + b) % PRIME for a, b in zip(total, part)]
            if any(total):
                return False
    return True


def spaces(tally, name, P, ours, theirs):
    for place in PLACES:
        a, b = solutions(*ours, place), solutions(*theirs, place)
        if a is None or b is None:
            continue
        shortest = min(len(y) for rows in (a, b) for row in rows for y in row)
        tally.check(vanish(P, a, place) and vanish(P, b, place), f"{name}: both solve")
        flat = [[[c for y in row for c in y[:shortest]] for row in rows] for rows in (a, b)]
        ranks = (rank(flat[0]), rank(flat[1]), rank(flat[0] + flat[1]))
        tally.check(ranks == (len(a),) * 3, f"{name}: one space of solutions", str(ranks))
        return True
    return False


def compare(tally, solver, name, system):
    """Whether Singular followed, and whether the solutions were compared."""
    P = [whole(r) for r in ore.of_system(system)]
    n = len(P)
    entries = ",".join(written(x) for r in P for x in r)
    said = ask([f"matrix m[{n}][{n}] = {entries};", "list J = jacobson(m, 0); int i; int k;",
                f"for (i = 1; i <= {n}; i++) {{ string(J[2][i,i]); }}", "size(ideal(J[1]*m*J[3] - J[2])) == 0;",
                f"for (i = 1; i <= {n}; i++) {{ for (k = 1; k <= {n}; k++) {{ string(J[3][i,k]); }} }}"])
    if said is None or sum(map(len, said)) > 20000:
        return False, False
    diagonal = [read(x) for x in said[:n]]
    result, problem = solver.solve({"system": {"form": "operator", "unknowns": [f"y{i + 1}" for i in range(n)], "coefficients": system}})
    if not tally.check(result, f"{name}: answered", str(problem)):
        return True, False
    tally.check(said[n] == "1", f"{name}: Singular's form multiplies out")
    tally.check(result["rank"] == sum(bool(x) for x in diagonal), f"{name}: rank", f"{result['rank']}, Singular {diagonal}")
    factors = [ore.trim([ore.number(c) for c in f]) for f in result["invariant_factors"] or []]
    order = sum(len(x) - 1 for x in diagonal if x)
    if not factors:
        return True, False
    tally.check(len(factors[-1]) - 1 == order, f"{name}: order of the torsion", f"{len(factors[-1]) - 1}, Singular {order}")
    if result["rank"] < n or not order or order > 5 or "V" not in result["jacobson"]:
        return True, False
    V, W = ore.read(result["jacobson"]["V"]), [[read(x) for x in said[n + 1 + i * n:n + 1 + (i + 1) * n]] for i in range(n)]
    if max(len(x) for M in (V, W) for r in M for x in r) > TERMS // 3:
        return True, False
    return True, spaces(tally, name, P, (V, factors), (W, diagonal))


def pairs(tally, build):
    run = subprocess.run([os.path.join(build, "unit", "operator_pairs")], capture_output=True, text=True, check=True)
    count = 0
    for line in run.stdout.splitlines():
        if not line.startswith("pair|"):
            continue
        a, b, g, m, q, r, ql, rl = [ore.trim([ore.number(c) for c in x.split(";")]) if x else [] for x in line[5:].split("|")]
        label = f"pair {count}"
        tally.check(ore.add(ore.mul(q, b), r) == a and len(r) < len(b), f"{label}: right division")
        tally.check(ore.add(ore.mul(b, ql), rl) == a and len(rl) < len(b), f"{label}: left division")
        if not a:
            continue
        A, B, G, M = (written(whole([x])[0]) for x in (a, b, g, m))
        # least orders of the left ideals (a, b) and (a) intersected with (b), over Q(t); that g lies in the first and m in the second up
        # to a factor in Q[t] follows where dividing their elements by g, and m by a and b, leaves nothing
        said = ask([f"ideal I = std(ideal({A}, {B}));", "ideal N = std(intersect(ideal(" + A + "), ideal(" + B + ")));", "int i;",
                    "for (i = 1; i <= size(I); i++) { string(I[i]); }", '"NEXT";', "for (i = 1; i <= size(N); i++) { string(N[i]); }"], "a(0,1),lp")
        if said is None:
            continue
        count += 1
        cut = said.index("NEXT")
        first, second = [read(x) for x in said[:cut]], [read(x) for x in said[cut + 1:]]
        least = min(first, key=len)
        tally.check(len(least) == len(g) and monic(least) == g, f"{label}: gcrd", f"{g}, Singular {least}")
        least = min(second, key=len)
        tally.check(len(least) == len(m) and monic(least) == m, f"{label}: lclm", f"{m}, Singular {least}")
        tally.check(G and M, label)
    tally.check(count >= 15, "enough pairs are compared", str(count))


def monic(x):
    return ore.trim([c / x[-1] for c in x])


def main():
    tally = Tally("jacobson")
    build = build_folder()
    solver = Solver(build)
    rng = random.Random(seed(2027))
    pairs(tally, build)
    followed = compared = 0
    for k in range(scaled(24)):
        n, order = rng.choice([1, 2, 2, 2, 3]), rng.randint(1, 2)
        system = random_system(rng, n, order)
        if k % 4 == 0:
            system = moved(rng, system)
        if k % 5 == 0 and n == 2:     # two equations of one operator each: their solutions add up
            system = [[[polynomial(rng, 1), "0"], ["0", polynomial(rng, 1)]], [["1", "0"], ["0", "1"]]]
        a, b = compare(tally, solver, f"random {k}", system)
        followed += a
        compared += b
    tally.check(followed >= 12 * float(os.environ.get("SGA_TEST_SCALE", "1")) and compared >= 6 * float(os.environ.get("SGA_TEST_SCALE", "1")),
                "enough systems are compared", f"{followed}, {compared}")
    return tally.end()


if __name__ == "__main__":
    sys.exit(main())
