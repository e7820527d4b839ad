"""The stabilization general algorithm in SymPy: a second opinion, slow and plain.

P_k is kept as a substitution: every new constraint is solved for one variable (one
in which it is linear if there is one, otherwise a root is taken), so that a function
vanishes on P_k if it simplifies to 0 after the substitution.
"""
import sympy as sp


class Undecided(Exception):
    pass


class Manifold:
    def __init__(self, variables, simplify):
        self.variables, self.simplify = variables, simplify
        self.value = {}                       # solved variable -> expression in the others
        self.constraints = []                 # (generation, expression)

    def on(self, e):
        """e on the manifold."""
        for _ in range(len(self.value) + 1):
            e = e.subs(self.value)
            if not e.free_symbols & set(self.value):
                break
        return self.simplify(e)

    def add(self, e, generation):
        """Adds the zero set of e; False where e vanishes already. Empty: ValueError."""
        top = sp.numer(sp.together(self.on(e)))
        top = self.simplify(top)
        if top == 0:
            return False
        open_variables = [v for v in self.variables if top.has(v)]
        if not open_variables:
            raise ValueError("empty")
        if top.is_polynomial(*open_variables):    # a set, not a formula: z^2 = 0 means z = 0
            top = sp.sqf_part(top, *open_variables)
            e = top if sp.degree(top, open_variables[0]) < sp.degree(sp.numer(sp.together(self.on(e))), open_variables[0]) else e
        for v in open_variables:
            if sp.simplify(sp.diff(top, v, 2)) == 0:
                slope = sp.diff(top, v)
                solution = -top.subs(v, 0) / slope
                break
        else:
            v = open_variables[-1]
            roots = sp.solve(top, v)
            if not roots:
                raise Undecided(str(top))
            solution = roots[0]
        solution = self.simplify(solution)
        self.value = {k: self.simplify(x.subs(v, solution)) for k, x in self.value.items()}
        self.value[v] = solution
        self.constraints.append((generation, sp.numer(sp.together(e))))
        return True


def reduce(A, alpha, variables, restrict=(), time=sp.Symbol("t"), simplify=sp.cancel):
    """A: list of rows, alpha: list. Returns the verdict, dimensions, constraints, X0 and gauge fields."""
    n = len(variables)
    A, alpha = sp.Matrix(A), sp.Matrix(alpha)
    m = Manifold(list(variables), simplify)
    generation, dims = 1, []
    for e in restrict:
        m.add(sp.sympify(e), 1)
    tangency = sp.zeros(0, n)
    rhs = sp.zeros(0, 1)
    while True:
        M = A.col_join(tangency).applyfunc(m.on)
        b = alpha.col_join(rhs)
        before = len(m.value)
        held = len(m.constraints)
        try:
            grown = True
            while grown:    # the rank may fall on the smaller set: the same generation
                grown = any([m.add((z.T * b)[0], generation) for z in M.T.nullspace(simplify=simplify)])
                if grown:
                    smaller = M.applyfunc(m.on)
                    grown, M = smaller != M, smaller
        except ValueError:
            return {"verdict": "inconsistent", "generations": dims}
        if generation == 1 and restrict:
            held = 0
        if len(m.value) == before and not (generation == 1 and restrict):
            break
        dims.append(n - len(m.value))
        for _, e in m.constraints[held:]:
            tangency = tangency.col_join(sp.Matrix([[sp.diff(e, v) for v in variables]]))
            rhs = rhs.col_join(sp.Matrix([-sp.diff(e, time)]))
        generation += 1
    M = A.col_join(tangency).applyfunc(m.on)
    b = alpha.col_join(rhs).applyfunc(m.on)
    gauge = M.nullspace(simplify=simplify)
    X = particular(M, b, simplify)
    final = n - len(m.value)
    moving = any(e.has(time) for _, e in m.constraints)
    verdict = "underdetermined" if gauge else "isolated" if final == 0 and not moving else "unique"
    return {"verdict": verdict, "generations": dims, "final": final, "gauge": gauge, "X": X, "manifold": m}


def particular(M, b, simplify):
    """One solution of M v = b (known to have one), free unknowns 0."""
    aug, pivots = M.row_join(b).rref(simplify=simplify, iszerofunc=lambda e: simplify(e) == 0)
    X = [sp.Integer(0)] * M.cols
    for i, j in enumerate(pivots):
        X[j] = simplify(aug[i, M.cols])
    return X
