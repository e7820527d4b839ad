"""Writes lib/ode/radau_tables.c: the Radau IIA formulas of 3, 5 and 7 stages (order 5, 9, 13).

    /usr/bin/python3 tests/radau_tables.py > lib/ode/radau_tables.c

Nodes: the zeros of d^(s-1)/dc^(s-1) [c^(s-1) (c-1)^s]. A integrates the Lagrange polynomials of the nodes. The inverse
of A has one real eigenvalue and (s-1)/2 pairs; the real form of its eigenvectors makes T. (Hairer, Wanner, Solving
Ordinary Differential Equations II, IV.5, IV.8.)"""
import textwrap

import mpmath as mp

mp.mp.dps = 60


def nodes(s):
    # coefficients of c^(s-1) (c-1)^s by rising power, differentiated s-1 times
    p = [mp.mpf(0)] * (s - 1) + [mp.binomial(s, k) * (-1) ** (s - k) for k in range(s + 1)]
    for _ in range(s - 1):
        p = [k * p[k] for k in range(1, len(p))]
    return sorted(mp.re(r) for r in mp.polyroots(p[::-1], maxsteps=500, extraprec=400))


def product(roots):
    p = [mp.mpf(1)]
    for r in roots:
        p = [(p[k - 1] if k else 0) - (r * p[k] if k < len(p) else 0) for k in range(len(p) + 1)]
    return p


def lagrange(c):
    out = []
    for i, ci in enumerate(c):
        others = c[:i] + c[i + 1:]
        p, d = product(others), mp.mpf(1)
        for x in others:
            d *= ci - x
        out.append([a / d for a in p])
    return out


def value(p, x):
    return sum(a * x ** k for k, a in enumerate(p))


def integral(p, x):
    return sum(a * x ** (k + 1) / (k + 1) for k, a in enumerate(p))


def table(s):
    c = nodes(s)
    c[-1] = mp.mpf(1)
    lag = lagrange(c)
    A = mp.matrix(s, s)
    for i in range(s):
        for j in range(s):
            A[i, j] = integral(lag[j], c[i])
    inv = A ** -1
    values, vectors = mp.eig(inv)
    order = [i for i in range(s) if abs(mp.im(values[i])) < mp.mpf(10) ** -30]
    assert len(order) == 1
    pairs = sorted((i for i in range(s) if mp.im(values[i]) > mp.mpf(10) ** -30), key=lambda i: mp.im(values[i]))
    T = mp.matrix(s, s)
    gamma = mp.re(values[order[0]])
    for i in range(s):
        T[i, 0] = mp.re(vectors[i, order[0]] / vectors[s - 1, order[0]])
    lam = []
    for k, e in enumerate(pairs):
        v = [vectors[i, e] for i in range(s)]
        v = [x / v[s - 1] for x in v]
        # A^-1 (p + iq) = (a + ib)(p + iq): on w1 p - w2 q the pair acts as (w1 + i w2) -> (a + ib)(w1 + i w2)
        for i in range(s):
            T[i, 1 + 2 * k] = mp.re(v[i])
            T[i, 2 + 2 * k] = mp.im(v[i])
        lam.append((mp.re(values[e]), mp.im(values[e])))
    TI = T ** -1
    block = TI * inv * T
    for k, (a, b) in enumerate(lam):
        r = 1 + 2 * k
        assert abs(block[r, r] - a) < 1e-30 and abs(abs(block[r, r + 1]) - b) < 1e-30
        if block[r, r + 1] > 0:      # [[a, b], [-b, a]]: the conjugate
            lam[k] = (a, -b)
    at0 = [value(p, mp.mpf(0)) for p in lag]
    defect = [-sum(at0[k] * inv[k, i] for k in range(s)) for i in range(s)]
    full = product(c)
    bump = max(abs(integral(full, mp.mpf(i) / 2000)) for i in range(2001))
    dense = bump * gamma / abs(value(full, mp.mpf(0)))
    # weights of the interpolation at 0, c_1, .., c_s (barycentric)
    every = [mp.mpf(0)] + c
    bary = []
    for i, x in enumerate(every):
        d = mp.mpf(1)
        for j, y in enumerate(every):
            if j != i:
                d *= x - y
        bary.append(1 / d)
    # the middles of the two widest gaps, and the derivatives there of the polynomials of 0, c_1, .., c_s
    gaps = sorted(range(s), key=lambda i: every[i] - every[i + 1])[:2]
    middle = [(every[i] + every[i + 1]) / 2 for i in gaps]
    slope = []
    for x in middle:
        r = []
        for p in lagrange(every)[1:]:
            r.append(sum(k * a * x ** (k - 1) for k, a in enumerate(p) if k))
        slope.append(r)
    return dict(middle=middle, slope=slope, s=s, c=c, T=T, TI=TI, gamma=gamma, lam=lam, defect=defect, dense=dense, bary=bary)


def num(x):
    return mp.nstr(x, 21, strip_zeros=False)


def row(v):
    return textwrap.fill("{" + ", ".join(num(x) for x in v) + "}", 96, subsequent_indent=" " * 12)


def main():
    print("""/* Radau IIA formulas of 3, 5 and 7 stages; written by tests/radau_tables.py. */
#include "radau_tables.h"

const struct radau_table radau_tables[RADAU_TABLES] = {""")
    for s in (3, 5, 7):
        t = table(s)
        print("    {\n        .s = %d,\n        .c = %s," % (s, row(t["c"])))
        for name in ("T", "TI"):
            print("        .%s = {" % name)
            for i in range(s):
                print("            %s," % row([t[name][i, j] for j in range(s)]))
            print("        },")
        print("        .gamma = %s," % num(t["gamma"]))
        print("        .re = %s," % row([a for a, _ in t["lam"]]))
        print("        .im = %s," % row([b for _, b in t["lam"]]))
        print("        .defect = %s," % row(t["defect"]))
        print("        .dense = %s," % num(t["dense"]))
        print("        .bary = %s," % row(t["bary"]))
        print("        .middle = %s," % row(t["middle"]))
        print("        .slope = {%s, %s},\n    }," % (row(t["slope"][0]), row(t["slope"][1])))
    print("};")


main()
