"""Derivatives of nodes of a Graph as nodes, for checkers that build equations themselves."""


class Derivatives:
    def __init__(self, graph):
        self.g = graph
        self.known = {}

    def zero(self, e):
        return e == self.g.const(0)

    def one(self, e):
        return e == self.g.const(1)

    def add(self, a, b):
        return b if self.zero(a) else a if self.zero(b) else self.g.make("+", a, b)

    def sub(self, a, b):
        return a if self.zero(b) else self.g.make("-", a, b)

    def mul(self, a, b):
        if self.zero(a) or self.zero(b):
            return self.g.const(0)
        return b if self.one(a) else a if self.one(b) else self.g.make("*", a, b)

    def sum(self, terms):
        total = self.g.const(0)
        for e in terms:
            total = self.add(total, e)
        return total

    def of(self, root, name):
        """d root / d name"""
        g, d = self.g, {}
        for e in g.cone([root]):
            op, *args = g.node[e]
            if op in ("const", "pi", "sym"):
                d[e] = g.const(int(op == "sym" and args[0] == name))
            else:
                d[e] = self.sum(self.mul(p, d[a]) for p, a in zip(self.partials(e, op, args), args) if not self.zero(d[a]))
        return d[root]

    def partials(self, e, op, args):
        g, (a, *rest) = self.g, args
        b = rest[0] if rest else None
        one, two = g.const(1), g.const(2)

        def power(x, n):
            return g.make("^", x, g.const(n))
        if op == "^":
            n = g._integer(args)
            if n is not None:
                return [g.make("*", g.const(n), power(a, n - 1)), g.const(0)]
            return [g.make("/", g.make("*", b, e), a), g.make("*", e, g.make("log", a))]
        table = {"+": lambda: [one, one], "-": lambda: [one, g.const(-1)], "neg": lambda: [g.const(-1)],
                 "*": lambda: [b, a], "/": lambda: [g.make("/", one, b), g.make("neg", g.make("/", e, b))],
                 "sin": lambda: [g.make("cos", a)], "cos": lambda: [g.make("neg", g.make("sin", a))],
                 "tan": lambda: [g.make("+", one, power(e, 2))], "exp": lambda: [e], "log": lambda: [g.make("/", one, a)],
                 "sqrt": lambda: [g.make("/", one, g.make("*", two, e))], "sinh": lambda: [g.make("cosh", a)],
                 "cosh": lambda: [g.make("sinh", a)], "tanh": lambda: [g.make("-", one, power(e, 2))],
                 "atan": lambda: [g.make("/", one, g.make("+", one, power(a, 2)))],
                 "abs": lambda: [g.make("sign", a)], "sign": lambda: [g.const(0)]}
        return table[op]()
