"""Systems with constant coefficients: a dense pencil of index 12, 200 dense unknowns, 2000 sparse ones."""
import os
import random
import sys
import time

sys.path.insert(0, os.path.dirname(os.path.dirname(os.path.abspath(__file__))))

import linear_oracle  # noqa: E402


def times(X, Y):
    columns = list(zip(*Y))
    return [[sum(x * y for x, y in zip(r, c)) for c in columns] for r in X]


def invertible(rng, n, most):
    """Random integers; full rank modulo a prime shows it."""
    p = (1 << 61) - 1
    while True:
        matrix = [[rng.randint(-most, most) for _ in range(n)] for _ in range(n)]
        work, rank = [r[:] for r in matrix], 0
        for c in range(n):
            k = next((i for i in range(rank, n) if work[i][c] % p), None)
            if k is None:
                break
            work[rank], work[k] = work[k], work[rank]
            inverse = pow(work[rank][c], -1, p)
            for i in range(rank + 1, n):
                f = work[i][c] * inverse % p
                if f:
                    work[i] = [(a - f * b) % p for a, b in zip(work[i], work[rank])]
            rank += 1
        if rank == n:
            return matrix


def weierstrass(chains, eigenvalues, seed, most):
    """P (s N - I, s I - J) Q with nilpotent chains of these lengths, P and Q dense integer matrices: (A, B)."""
    n, at, rng = sum(chains) + len(eigenvalues), 0, random.Random(seed)
    A, B = [[0] * n for _ in range(n)], [[0] * n for _ in range(n)]
    for length in chains:
        for i in range(at, at + length):
            B[i][i] = 1
            if i + 1 < at + length:
                A[i][i + 1] = 1
        at += length
    for i, v in enumerate(eigenvalues):
        A[at + i][at + i], B[at + i][at + i] = 1, v
    P, Q = invertible(rng, n, most), invertible(rng, n, most)
    return times(times(P, A), Q), times(times(P, B), Q)


def dense(A, B, want=None):
    request = {"system": {"form": "linear", "variables": [f"x{i}" for i in range(len(A[0]))], "A": A, "B": B}}
    return {**request, "want": want} if want else request


def ladder(nodes):
    """Resistors in a row, a capacitor at each fifth node and both ends, driven by sin t: 2000 unknown voltages."""
    rng = random.Random(8)
    g = [rng.randint(1, 9) for _ in range(nodes)]
    rows = []
    for k in range(nodes):
        flow = [f"{g[k - 1]}*(v{k - 1}-v{k})"] if k else ["sin(t)-v0"]
        flow += [f"{g[k]}*(v{k + 1}-v{k})"] if k + 1 < nodes else []
        rows.append((f"v{k}'" if k % 5 == 0 or k + 1 == nodes else "0") + " = " + "+".join(flow))
    return {"system": {"form": "equations", "variables": [f"v{k}" for k in range(nodes)], "equations": rows}, "want": ["index"]}


def run(folder, measure, show):
    print("constant coefficients, exact: seconds for all of a request")
    A, B = weierstrass([12, 6, 4], [1, -2, 3, -1], 5, 2)
    begun = time.process_time()
    found = linear_oracle.reduce(A, B, [0] * len(A))
    plain = time.process_time() - begun
    if len(found["generations"]) != 12:
        raise RuntimeError("the pencil has another index")
    for name, want in (("index", ["index"]), ("structure", ["structure"]), ("all that is usual", None)):
        ours = measure(folder, dense(A, B, want), 5)["best"]
        show(f"26 dense unknowns, index 12: {name}", f"{ours:.3f}", "<= 0.1", ours <= 0.1, f"plain fractions {plain:.2f} s, {plain / ours:.0f} times")
    A, B = weierstrass([5, 4, 1, 1] * 4 + [1] * 50, [i % 7 - 3 for i in range(106)], 6, 1)
    ours = measure(folder, {**dense(A, B, ["index"]), "limits": {"seconds": 300}})["best"]
    show("200 dense unknowns, index 5", f"{ours:.2f}", "<= 5", ours <= 5)
    ours = measure(folder, ladder(2000))["best"]
    show("2000 sparse unknowns", f"{ours:.2f}", "<= 2", ours <= 2)
