"""Systems of a thousand unknowns and more whose verdict, dimensions and index are known by construction: large_check.py BUILD_DIR

Implicit steps on the equations of large systems (lib/traj/field/whole.c): what they say of their errors, against far tighter motions.
Chains, ladders, random graphs and grids of tests/bench/large.py at two sizes each. How much was evaluated may grow as the size does (chains) or a
little faster (grids), by the counts of `work`: no clock. Faults in the middle of such a system are named by their place."""
import random
import sys

from solver import Solver
from tally import Tally, build_folder, scaled, seed

sys.path.insert(0, __file__.rsplit("/", 1)[0] + "/bench")
import large  # noqa: E402

# By family: two sizes, about 1,000 and 2,500 unknowns, and the most power of the size by which counts may grow between them.
SIZES = {"chain": (200, 500, 1.15), "ladder": (500, 1250, 1.15), "pairs": (400, 1000, 1.15), "scattered": (700, 2100, 1.15), "grid": (22, 35, 1.3), "network": (22, 35, 1.3),
         "heat": (30, 48, 1.3), "stokes": (12, 20, 1.5), "web": (22, 34, 1.5), "mesh": (30, 48, 1.5)}
UNKNOWNS = {"chain": 5, "ladder": 2, "pairs": 2.5, "scattered": 2, "grid": 2, "network": 2, "heat": 1, "stokes": 3, "web": 2, "mesh": 1}


def size(name, n):
    return UNKNOWNS[name] * (n * n if name in large.PLANAR else n)


def answered(tally, solver, name, n):
    request, expected = large.FAMILIES[name](n)
    answer, problem = solver.solve(request)
    label = f"{name} {n}"
    if not tally.check(answer, label, problem):
        return None
    told = {"verdict": answer["verdict"], "generations": answer["dimensions"]["generations"], "index": answer["index"]["differentiation"]}
    tally.check(told == expected, f"{label}: verdict, generations, index", (told, expected))
    return answer["work"]["counts"]


def grows(tally, name, small, big, most):
    a, b, power = SIZES[name]
    for count in sorted(small):
        if small[count] > 1000:
            tally.check(big[count] <= small[count] * (size(name, b) / size(name, a)) ** power * most, f"{name}: {count} grows as the size to the power {power}",
                        (small[count], big[count]))


def faults(tally, solver):
    """What is missing, contradictory or misspelt in the middle."""
    request, _ = large.ladder(500)
    equations = request["system"]["equations"]
    pointer = "/system/equations/500"
    answer, problem = solver.solve({**request, "system": {**request["system"], "equations": equations[:500] + ["v251' = i251 - *i252"] + equations[501:]}})
    tally.check(answer is None and problem["code"] == "expression_syntax" and problem["pointer"] == pointer, "a misspelt equation", problem)
    request, _ = large.ladder(500)
    missing = {**request, "want": ["index", "constraints", "gauge"], "system": {**request["system"], "equations": equations[:501] + equations[502:]}}
    answer, problem = solver.solve(missing)
    if tally.check(answer, "a missing equation", problem):
        tally.check(answer["verdict"] == "underdetermined", "a missing equation leaves a freedom", answer["verdict"])
        tally.check("i251" in str(answer["gauge"]) + str(answer.get("warnings", "")), "it is named", answer.get("warnings"))


def dense(tally, solver):
    """A full matrix of a lower rank in front of nonlinear functions: each of its constraints has all of them."""
    n, rank, rng = 60, 45, random.Random(3)
    left, right = ([[rng.randint(-3, 3) for _ in range(b)] for _ in range(a)] for a, b in ((n, rank), (rank, n)))
    matrix = [[sum(left[i][k] * right[k][j] for k in range(rank)) for j in range(n)] for i in range(n)]
    system = {"form": "quasilinear", "variables": [f"x{i}" for i in range(n)], "A": matrix, "alpha": [f"-x{i} + sin(x{(i + 1) % n}) - x{(i + 2) % n}^3/10" for i in range(n)]}
    answer, problem = solver.solve({"system": system, "want": ["index"], "limits": {"seconds": 60}})
    if tally.check(answer, "a full matrix", problem):
        told = answer["verdict"], answer["dimensions"]["generations"], answer["index"]["differentiation"]
        tally.check(told == ("unique", [rank], 1), "a full matrix: verdict, generations, index", told)
        told = any("GROWN_ON_SET" in w["detail"] for w in answer["warnings"]), answer.get("evidence", {}).get("factors_not_searched")
        tally.check(told == (True, True), "a full matrix: what was not put into each other is told", told)


def resistors(n, current):
    """n x n nodes joined by resistors, none of them grounded; `current` is fed in in the middle. The equations sum up to 0 = current."""
    variables, equations = [f"e{r}_{c}" for r in range(n) for c in range(n)], []
    for r in range(n):
        for c in range(n):
            beside = [f"(e{q}_{k} - e{r}_{c})" for q, k in ((r - 1, c), (r + 1, c), (r, c - 1), (r, c + 1)) if 0 <= q < n and 0 <= k < n]
            equations.append(" + ".join(beside) + f" = {current if r == c == n // 2 else 0}")
    return large.asked(f"{n} x {n} resistors", {"form": "equations", "variables": variables, "equations": equations})


def unasked(tally, solver):
    """Coordinates of which each pair has one mass, on springs: the field's numbers grow long, and without it what is evaluated is in proportion."""
    counts = []
    for n in (80, 300):
        lagrangian = " + ".join(f"(q{i}' + q{i + 1}')^2/2" for i in range(0, n, 2)) + " - " + " - ".join(f"(q{i + 1} - q{i})^2/2" for i in range(n - 1))
        request = {"system": {"form": "lagrangian", "coordinates": [f"q{i}" for i in range(n)], "lagrangian": lagrangian}, "want": ["index", "constraints"], "limits": {"seconds": 60}}
        answer, problem = solver.solve(request)
        if tally.check(answer, f"{n} coordinates with half as many masses", problem):
            tally.check(answer["verdict"] == "unique" and answer["dimensions"]["generations"] == [3 * n // 2, n], f"{n} coordinates: verdict and generations",
                        (answer["verdict"], answer["dimensions"]))
            counts.append(answer["work"]["counts"]["balls"])
    tally.check(len(counts) == 2 and counts[1] < 6 * counts[0], "what is evaluated grows with the coordinates", counts)


def bounded(tally, solver):
    """A block of 4,050 equations that are solved for one another, in memory that a full matrix of their size would use up."""
    request, expected = large.web(90)
    answer, problem = solver.solve({**request, "limits": {"seconds": 120, "megabytes": 280}})
    if tally.check(answer, "a food web in 280 MB", problem):
        tally.check(answer["verdict"] == expected["verdict"], "a food web in 280 MB: verdict", answer["verdict"])


def together(tally, solver):
    """Thousands of variables in one equation: a sphere, a mean field, one pressure for all."""
    n = 4000
    x = [f"x{i}" for i in range(n)]
    for name, variable, rate, equation, index in (("a sphere", "p", "{k}*{next} + p*{own}", " + ".join(v + "^2" for v in x) + " = 1", 2),
                                                  ("a mean field", "s", "s - {k}*{own} - {own}^3", f"s^3 + s = ({' + '.join(x)})/{n}", 1),
                                                  ("one pressure", "p", "p - {own} + {k}*sin(t)", " + ".join(x) + " = 0", 2)):
        equations = [f"{v}' = " + rate.format(k=i % 5 + 1, own=v, next=x[(i + 1) % n]) for i, v in enumerate(x)] + [equation]
        answer, problem = solver.solve({"system": {"form": "equations", "variables": [*x, variable], "equations": equations}, "want": ["index", "constraints"], "limits": {"seconds": 60}})
        if tally.check(answer, name, problem):
            told = answer["verdict"], answer["index"]["differentiation"], answer["dimensions"]["final"]
            tally.check(told == ("unique", index, n + 1 - index), f"{name}: verdict, index, dimension", told)


def summed(tally, solver):
    """A hundred thousand branches at a hub, its balance a sum of the request: one equation with as many variables."""
    n = 100000
    request = {"system": {"form": "equations", "sizes": {"n": n}, "variables": ["v[1:n]", "hub"],
                          "equations": [{"for": "i = 1:n", "equation": "v[i]' = hub - v[i]"}, "sum(i = 1:n, hub - v[i]) = sin(t)"]},
               "want": ["index", "constraints"], "limits": {"seconds": 60}}
    answer, problem = solver.solve(request)
    if tally.check(answer, "a hub of 100,000", problem):
        told = answer["verdict"], answer["index"]["differentiation"], answer["dimensions"]["final"]
        tally.check(told == ("unique", 1, n), "a hub of 100,000: verdict, index, dimension", told)


def large_faults(tally, solver):
    """A singular grid, an equation that is missing in the middle of one, a loop with a wrong bound: named by place, with little time to do it."""
    limits = {"seconds": 60, "megabytes": 2000}
    n = 40
    answer, problem = solver.solve({**resistors(n, 0), "limits": limits})
    if tally.check(answer, "a grid without ground", problem):
        tally.check(answer["verdict"] == "underdetermined" and answer["dimensions"]["final"] == 1, "its potential is free", answer["dimensions"])
        tally.check(answer["evidence"]["redundant_equations"] == 1, "one of its equations follows", answer["evidence"]["redundant_equations"])
        tally.check(any("free is e" in w["detail"] for w in answer["warnings"]), "a free potential is named", answer["warnings"])
    answer, problem = solver.solve({**resistors(n, 1), "limits": limits})
    if tally.check(answer, "a grid without ground that a current is fed into", problem):
        told = answer["evidence"]["contradiction"]
        tally.check(answer["verdict"] == "inconsistent", "it is contradictory", answer["verdict"])
        tally.check(told["combination"] and all(part["equation"].startswith("equations[") for part in told["combination"]), "an equation is named", told)
    request, _ = large.heat(100)
    equations = request["system"]["equations"]
    middle = len(equations) // 2
    missing = next(k for k in range(middle, len(equations)) if "'" not in equations[k])      # an equation of the boundary: of its point alone
    point = equations[missing].split()[0]
    answer, problem = solver.solve({**request, "limits": limits, "system": {**request["system"], "equations": equations[:missing] + equations[missing + 1:]}})
    if tally.check(answer, "heat without an equation of its boundary", problem):
        tally.check(answer["verdict"] == "underdetermined", "a freedom is left", answer["verdict"])
        tally.check(any(f"free is {point}" in w["detail"] for w in answer["warnings"]), f"{point} is named", answer["warnings"])
    for bound, far in (("1:n", 0), ("2:n", 50001)):
        loop = {"for": f"i = {bound}", "equation": "x[i]' = x[i-1] - 2*x[i] + x[i+1]"}
        answer, problem = solver.solve({"system": {"form": "equations", "sizes": {"n": 50000}, "variables": ["x[1:n]"], "equations": [loop]}, "want": ["index"], "limits": limits})
        tally.check(answer is None and problem["code"] == "unknown_name" and problem["pointer"] == "/system/equations/0/equation" and f"x[{far}]" in problem["detail"],
                    f"a loop over {bound}", problem)


def stiff_motions(tally, solver):
    """The food web, by implicit steps on its equations: predators and prey meet their equations, and an explicit method gives the same."""
    for n in (4, 5, 6, 7, 10):
        request, _ = large.web(n, want=("index", "trajectory"), stop=0.02)
        found = []
        for method in ("radau" if n < 6 else "auto", "dop853"):
            answer, problem = solver.solve({**request, "accuracy": {"rtol": 1e-6, "method": method}})
            if not tally.check(answer, f"web {n} by {method}", problem):
                return
            motion = answer["trajectory"]
            found.append(motion)
            tally.check(motion["ended"] is None and len(motion["rows"]) == 11, f"web {n} by {method} comes to its end", motion["ended"])
        tally.check(found[0]["method"] == "radau", f"web {n}: implicit steps", found[0]["method"])
        for a, b in zip(found[0]["rows"], found[1]["rows"]):
            allowed = found[0]["error_estimate"] + found[1]["error_estimate"] + 1e-9 * abs(b[2])
            tally.check(all(abs(u - v) <= allowed for u, v in zip(a, b)), f"web {n}: two methods at {b[0]}", (a, b, allowed))


def lossy_motions(tally, solver):
    """A mesh whose constraints, solved one after the other, march over it: the equations as they stand give the same by implicit and by explicit steps,
    and what they are said to miss is missed."""
    for n in (8, 12, 20, 30):
        request, _ = large.mesh(n, want=("trajectory",))
        found = []
        for method, rtol in (("auto", 1e-6), ("dop853", 1e-6), ("radau", 1e-10)):
            answer, problem = solver.solve({**request, "accuracy": {"rtol": rtol, "atol": rtol, "method": method}})
            if not tally.check(answer, f"mesh {n} by {method}", problem):
                return
            found.append(answer["trajectory"])
            tally.check(found[-1]["ended"] is None and len(found[-1]["rows"]) == 11, f"mesh {n} by {method} comes to its end", found[-1]["ended"])
        exact = found.pop()
        for motion in found:
            for a, b in zip(motion["rows"], exact["rows"]):
                allowed = motion["error_estimate"] + exact["error_estimate"]
                tally.check(all(abs(u - v) <= allowed for u, v in zip(a, b)), f"mesh {n}: {motion['method']} at {b[0]}", (a, b, allowed))


# Of samples whose error is below what is said of it, as in trajectory_errors.py.
HELD = 0.95
TIGHT = 1e-11


def estimates(tally, solver):
    """Errors of implicit steps on the equations as they stand, over random systems with coupled algebraic equations."""
    rng = random.Random(seed(20261125))
    held = count = promised = kept = 0
    for number in range(scaled(8)):
        if number % 4 == 3:
            request, _ = large.web(7, want=("trajectory",), stop=rng.choice((0.002, 0.02)))
        elif number % 4 == 1:      # constraints that leave nothing to choose
            n = rng.randint(8, 14)
            request, _ = large.heat(n, want=("trajectory",), spacing=1 / (n + 1), stop=rng.choice((0.1, 1)))
            request["trajectory"]["outputs"] = ["u1_1", f"u0_{n // 2}", f"u{n // 2}_{n // 2}", f"u{n + 1}_1"]
        else:
            request, _ = large.reaction(rng.randint(32, 48), rng, want=("trajectory",), stop=rng.choice((0.1, 1)))
        given = {}
        for rtol in (TIGHT, 1e-3, 1e-5, 1e-7):
            answer, problem = solver.solve({**request, "accuracy": {"rtol": rtol, "atol": rtol, "method": "radau"}})
            if not tally.check(answer, f"{request['system']['name']} at {rtol:g}", problem):
                break
            given[rtol] = answer["trajectory"]
        for rtol, t in given.items():
            if rtol == TIGHT:
                tally.check(t["ended"] is None and t["error_estimate"] is not None, f"{request['system']['name']}: a tight motion", t["ended"])
                continue
            exact = given[TIGHT]
            for row, true, estimate, left in zip(t["rows"], exact["rows"], t["errors"], exact["errors"]):
                apart = [abs(x - y) for x, y in zip(row[1:], true[1:])]
                count += 1
                held += max(apart) <= estimate + left
                if t["accuracy_reached"]:
                    promised += 1
                    kept += all(e <= rtol * (1 + abs(y)) + left for e, y in zip(apart, true[1:]))
    print(f"large, implicit: {count} samples, {held} within their estimates; {promised} promised, {kept} kept")
    tally.check(count and held >= HELD * count, "estimates of large motions hold", (held, count))
    tally.check(kept >= 0.98 * promised, "promises of large motions are kept", (kept, promised))


def kroneckers(tally, solver):
    """The structure of pencils: small ones by their minors, large ones by the generations, with the same blocks by construction; and as many
    free initial values as the final set has dimensions."""
    def told(request):
        answer, problem = solver.solve({**request, "want": ["structure"]})
        if not answer:
            return problem
        free = answer["structure"]["free_initial"]
        tally.check(free is not None and len(free) == answer["dimensions"]["final"], f"{request['system'].get('name')}: free initial values", str(free)[:200])
        return answer["structure"]["kronecker"]
    for n in (8, 40, 1000):
        k = told(large.pairs(n)[0])
        found = {key: k.get(key) for key in ("regular", "normal_rank", "finite", "infinite", "right", "left", "basis")}
        tally.check(found == {"regular": True, "normal_rank": 5 * n // 2, "finite": n, "infinite": [3] * (n // 2), "right": [], "left": [], "basis": "proved"},
                    f"pairs {n}: structure of the pencil", str(k)[:400])
        tally.check((k["eigenvalues"] is None) == (n == 1000), f"pairs {n}: eigenvalues", str(k)[:400])
    for n in (4, 8, 27):       # a potential that no equation has, and an equation that follows from others
        size, m = 2 * n * (n - 1) + n * n, n * n - 1
        k = told(large.stokes(n)[0])
        found = {key: k.get(key) for key in ("regular", "normal_rank", "finite", "infinite", "right", "left")}
        tally.check(found == {"regular": False, "normal_rank": size - 1, "finite": size - 1 - 2 * m, "infinite": [2] * m, "right": [0], "left": [0]},
                    f"stokes {n}: structure of the pencil", str(k)[:400])
    for n in (30, 2100):       # a chain of integrators behind a free function: one minimal index, n
        loop = {"for": "i = 1:n-1", "equation": "x[i]' = x[i+1]"}
        k = told({"system": {"form": "equations", "sizes": {"n": n}, "variables": ["x[1:n]"], "equations": [loop]}})
        if n == 30:
            tally.check(k["right"] == [n - 1] and k["left"] == [] and k["infinite"] == [], "a chain of integrators", str(k)[:400])
        else:
            tally.check("2000" in k.get("reason", ""), "a long chain of integrators is left out, with the reason", str(k)[:400])


def many_generations(tally, solver):
    """Index n: a generation for each constraint."""
    for n, right in ((100, "x[i+1] - x[i]"), (400, "x[i+1] - x[i]"), (30, "x[i+1]*x[1] - x[i]"), (14, "x[i+1] - sin(x[i])")):
        loop = {"for": "i = 1:n-1", "equation": f"x[i]' = {right}"}
        system = {"form": "equations", "sizes": {"n": n}, "variables": ["x[1:n]"], "equations": [loop, "x[1] = 1"]}
        answer, problem = solver.solve({"system": system, "want": ["index"], "limits": {"generations": 1000}})
        if tally.check(answer, f"index {n}", problem):
            tally.check(answer["index"]["differentiation"] == n and answer["dimensions"]["final"] == 0, f"index {n}", answer["index"])


def main():
    solver, tally = Solver(build_folder()), Tally("large")
    for name, (a, b, _) in SIZES.items():
        counts = [answered(tally, solver, name, n) for n in (a, b)]
        if all(counts):
            grows(tally, name, *counts, 1.1)
    answered(tally, solver, "truss", 45)      # rows held far from where starts are drawn
    answered(tally, solver, "stokes", 45)     # most of what an elimination would fill are columns that become no pivots
    kroneckers(tally, solver)
    many_generations(tally, solver)
    dense(tally, solver)
    unasked(tally, solver)
    bounded(tally, solver)
    together(tally, solver)
    summed(tally, solver)
    faults(tally, solver)
    large_faults(tally, solver)
    stiff_motions(tally, solver)
    lossy_motions(tally, solver)
    estimates(tally, solver)
    return tally.end()


if __name__ == "__main__":
    sys.exit(main())
