"""The expression grammar, read by code that shares nothing with the C parser.

A Graph holds shared nodes in order (children first); texts are parsed into it, values
come from one loop over the nodes, gradients from one sweep back. Constants are exact.
Two kinds of numbers: mpmath (any number of digits) and Python floats.
"""
import math
import re
from fractions import Fraction

import mpmath

TOKEN = re.compile(r"\s*(?:(\d+\.?\d*(?:[eE][+-]?\d+)?|\.\d+(?:[eE][+-]?\d+)?)"
                   r"|([A-Za-z_][A-Za-z_0-9]*)('*)|(\*\*|==|<=|>=|!=|~=|[-+*/^(),=~<>]))")
UNARY = ("sin cos tan asin acos atan sinh cosh tanh asinh acosh atanh exp log sqrt cbrt abs sign").split()
PRECEDENCE = {"or": 0.1, "and": 0.2, "not": 0.3, "<": 0.5, "<=": 0.5, ">": 0.5, ">=": 0.5, "==": 0.5, "!=": 0.5,
              "+": 1, "-": 1, "*": 2, "/": 2, "neg": 2.5, "^": 4}
LOGIC = {"<": lambda a, b: a < b, "<=": lambda a, b: a <= b, ">": lambda a, b: a > b, ">=": lambda a, b: a >= b, "==": lambda a, b: a == b,
         "!=": lambda a, b: a != b, "and": lambda a, b: a and b, "or": lambda a, b: a or b, "not": lambda a: not a}


class Undefined(Exception):
    """The expression has no real value at this point."""


class Syntax(Exception):
    pass


class Graph:
    def __init__(self):
        self.node = []       # (operator, argument...) ; ("const", Fraction), ("sym", name)
        self.known = {}
        self.constants = {}  # value -> node
        self.alias = {}      # a defined name -> node
        self.cones = {}      # root -> its cone: nodes never change, so neither do these
        self.total = None    # the total derivative of a node, where der(expression) is allowed

    def make(self, *key):
        if key not in self.known:
            self.known[key] = len(self.node)
            self.node.append(key)
        return self.known[key]

    def const(self, value):
        if value not in self.constants:
            self.constants[value] = self.make("const", Fraction(value))
        return self.constants[value]

    def sym(self, name):
        return self.alias[name] if name in self.alias else self.make("sym", name)

    def parse(self, text):
        """A text, or a JSON number (the decimal it is written as)."""
        if not isinstance(text, str):
            return self.const(Fraction(repr(text)) if isinstance(text, float) else text)
        tokens, at = [], 0
        text = text.rstrip()
        while at < len(text):
            m = TOKEN.match(text, at)
            if not m:
                raise Syntax(f"column {at + 1} of {text!r}")
            tokens.append(m)
            at = m.end()
        return self._shunt(tokens, text)

    def equation(self, text):
        """left - right."""
        depth, sides, at, i = 0, [], 0, 0
        while i < len(text):
            depth += (text[i] == "(") - (text[i] == ")")
            if depth == 0 and text[i] in "=~":
                sides.append(text[at:i])
                i += text[i:i + 2] == "=="
                at = i + 1
            i += 1
        sides.append(text[at:])
        if len(sides) != 2:
            raise Syntax(text)
        return self.make("-", self.parse(sides[0]), self.parse(sides[1]))

    def _shunt(self, tokens, text):
        out, ops = [], []    # ops: operator names, "(" with (function, argument count)

        def reduce():
            op = ops.pop()[0]
            if op in ("neg", "not"):
                out.append(self.make(op, out.pop()))
            else:
                b, a = out.pop(), out.pop()
                out.append(self.make(op, a, b))

        operand = True       # whether an operand is expected
        i = 0
        try:
            while i < len(tokens):
                number, name, primes, sign = tokens[i].groups()
                if number is not None:
                    out.append(self.const(Fraction(number)))
                    operand = False
                elif name == "der" and self._is_plain_der(tokens, i):
                    args = [t.group(0).strip() for t in tokens[i + 1:i + 6]]
                    order, width = (int(args[3]), 5) if args[2] == "," else (1, 3)
                    out.append(self.sym(args[1] + "'" * order))
                    i += width
                    operand = False
                elif name == "not" and operand and any(o[:2] == ("(", "if") for o in ops):
                    ops.append(("not",))
                elif name in ("and", "or") and not operand:
                    while ops and ops[-1][0] != "(" and PRECEDENCE[ops[-1][0]] >= PRECEDENCE[name]:
                        reduce()
                    ops.append((name,))
                    operand = True
                elif name is not None:
                    following = tokens[i + 1].group(4) if i + 1 < len(tokens) else None
                    if following == "(" and not primes:
                        ops.append(("(", name, 1))
                        i += 1
                        operand = True
                    else:
                        out.append(self.make("pi") if name == "pi" else self.sym(name + primes))
                        operand = False
                elif sign == "(":
                    ops.append(("(", None, 1))
                    operand = True
                elif sign in ",)":
                    while ops[-1][0] != "(":
                        reduce()
                    if sign == ",":
                        ops[-1] = ("(", ops[-1][1], ops[-1][2] + 1)
                        operand = True
                    else:
                        _, function, count = ops.pop()
                        operand = False
                        if function:
                            arguments = [out.pop() for _ in range(count)][::-1]
                            out.append(self._call(function, arguments))
                else:
                    sign = {"**": "^", "~=": "!="}.get(sign, sign)
                    if operand:
                        if sign == "-":
                            ops.append(("neg",))
                        elif sign != "+":
                            raise Syntax(text)
                    else:
                        here = PRECEDENCE[sign]
                        while ops and ops[-1][0] != "(" and \
                                (PRECEDENCE[ops[-1][0]] > here or PRECEDENCE[ops[-1][0]] == here and sign != "^"):
                            reduce()
                        ops.append((sign,))
                        operand = True
                i += 1
            while ops:
                reduce()
        except (IndexError, KeyError, ValueError) as e:
            raise Syntax(text) from e
        if len(out) != 1:
            raise Syntax(text)
        return out[0]

    @staticmethod
    def _is_plain_der(tokens, i):
        """der(x) or der(x, 2), not der of an expression"""
        after = tokens[i + 3].group(0).strip() if i + 3 < len(tokens) else ")"
        return bool(tokens[i + 2].group(2)) and after in ",)"

    def _call(self, function, arguments):
        if function == "der" and self.total and len(arguments) <= 2:
            e = arguments[0]
            for _ in range(int(self.node[arguments[1]][1]) if len(arguments) == 2 else 1):
                e = self.total(e)
            return e
        if function in UNARY and len(arguments) == 1 or function == "atan2" and len(arguments) == 2 \
                or function in ("step", "log10", "log2") and len(arguments) == 1 or function == "if" and len(arguments) == 3 or function == "hypot" and len(arguments) >= 2:
            return self.make(function, *arguments)
        if function in ("min", "max") and len(arguments) >= 2:
            total = arguments[0]
            for a in arguments[1:]:
                total = self.make(function, total, a)
            return total
        raise Syntax(f"{function} of {len(arguments)} arguments")

    def define(self, name, text):
        self.alias[name] = self.parse(text)

    # Values

    def cone(self, roots):
        """The nodes under the roots, children first."""
        if len(roots) == 1:
            if roots[0] not in self.cones:
                self.cones[roots[0]] = self._cone(roots)
            return self.cones[roots[0]]
        return self._cone(roots)

    def _cone(self, roots):
        seen, stack = set(), list(roots)
        while stack:
            e = stack.pop()
            if e in seen:
                continue
            seen.add(e)
            if self.node[e][0] not in ("const", "sym", "pi"):
                stack.extend(self.node[e][1:])
        return sorted(seen)

    def names(self, roots):
        return {self.node[e][1] for e in self.cone(roots) if self.node[e][0] == "sym"}

    def values(self, cone, env, number):
        """Values of the nodes of a cone at a point; Undefined where there are none. In branches of if that are not taken there may be none: None."""
        if any(self.node[e][0] == "if" for e in cone):
            return self._values_by_branches(cone, env, number)
        return self._values(cone, env, number, {})

    def _values_by_branches(self, cone, env, number):
        value, used = {}, {a for e in cone if self.node[e][0] not in ("const", "sym", "pi") for a in self.node[e][1:]}
        for root in [e for e in cone if e not in used]:
            self._by_need(root, env, number, value)
        return {e: value.get(e) for e in cone}

    def _by_need(self, root, env, number, value):
        """The value of a node, without recursion: of if the condition first, and then one branch."""
        stack = [root]
        while stack:
            e = stack[-1]
            op, *args = self.node[e]
            if op == "if" and args[0] in value:
                args = [args[1 if value[args[0]] else 2]]
            elif op == "if":
                args = args[:1]
            wanted = [] if op in ("const", "sym", "pi") else [a for a in args if a not in value]
            if wanted:
                stack += wanted
                continue
            stack.pop()
            if op == "if":
                value[e] = value[args[0]]
            else:
                self._values([e], env, number, value)

    def _values(self, cone, env, number, value):
        for e in cone:
            op, *args = self.node[e]
            if op == "const":
                value[e] = number.const(args[0])
            elif op == "sym":
                value[e] = env[args[0]]
            elif op == "pi":
                value[e] = number.pi()
            else:
                value[e] = number.apply(op, [value[a] for a in args], self._integer(args))
        return value

    def _integer(self, args):
        """The integer that the last argument is, or None."""
        key = self.node[args[-1]]
        if key[0] == "neg" and self.node[key[1]][0] == "const" and self.node[key[1]][1].denominator == 1:
            return -int(self.node[key[1]][1])
        return int(key[1]) if key[0] == "const" and key[1].denominator == 1 else None

    def gradient(self, root, value, number):
        """d root / d name, for every name the root depends on."""
        weight, out = {root: number.const(Fraction(1))}, {}
        for e in reversed(self.cone([root])):
            if e not in weight or value[e] is None:
                continue
            op, *args = self.node[e]
            if op == "sym":
                out[args[0]] = weight[e]
            elif op not in ("const", "pi"):
                partial = number.partials(op, [value[a] for a in args], value[e], self._integer(args))
                for a, d in zip(args, partial):
                    weight[a] = weight.get(a, 0) + weight[e] * d
        return out

    def sympy(self, e, symbols):
        """The node as a SymPy expression; symbols: name -> Symbol."""
        import sympy as sp
        table = {"asin": sp.asin, "acos": sp.acos, "atan": sp.atan, "abs": sp.Abs, "min": sp.Min, "max": sp.Max,
                 "if": lambda c, a, b: sp.Piecewise((a, c), (b, True)), "step": lambda a: sp.Piecewise((1, a >= 0), (0, True)),
                 "<": sp.Lt, "<=": sp.Le, ">": sp.Gt, ">=": sp.Ge, "==": sp.Eq, "!=": sp.Ne, "and": sp.And, "or": sp.Or, "not": sp.Not,
                 "hypot": lambda *a: sp.sqrt(sum(k ** 2 for k in a)), "log10": lambda a: sp.log(a, 10), "log2": lambda a: sp.log(a, 2),
                 "cbrt": lambda a: sp.sign(a) * sp.Abs(a) ** sp.Rational(1, 3)}
        value = {}
        for n in self.cone([e]):
            op, *args = self.node[n]
            if op == "const":
                value[n] = sp.Rational(args[0].numerator, args[0].denominator)
            elif op == "sym":
                value[n] = symbols[args[0]]
            elif op == "pi":
                value[n] = sp.pi
            else:
                a = [value[k] for k in args]
                value[n] = (a[0] + a[1] if op == "+" else a[0] - a[1] if op == "-" else a[0] * a[1] if op == "*"
                            else a[0] / a[1] if op == "/" else -a[0] if op == "neg" else a[0] ** a[1] if op == "^"
                            else (table.get(op) or getattr(sp, op))(*a))
        return value[e]


class Arithmetic:
    """Operators over a module of elementary functions (mpmath.mp or math)."""

    def __init__(self, m):
        self.m = m

    def pi(self):
        return +self.m.pi

    def const(self, q):
        return mpmath.mpf(q.numerator) / q.denominator if self.m is not math else q.numerator / q.denominator

    def cbrt(self, a):
        third = self.const(Fraction(1, 3))
        return a ** third if a > 0 else -((-a) ** third) if a < 0 else a

    def apply(self, op, v, n):
        try:
            r = self._apply(op, v, n)
        except (ZeroDivisionError, OverflowError, ValueError) as e:
            raise Undefined(op) from e
        if isinstance(r, (complex, mpmath.mpc)) or r != r or r in (mpmath.inf, -mpmath.inf):
            raise Undefined(op)
        return r

    def _apply(self, op, v, n):
        a, m = v[0], self.m
        if op == "+":
            return a + v[1]
        if op == "-":
            return a - v[1]
        if op == "*":
            return a * v[1]
        if op == "/":
            return a / v[1]
        if op == "neg":
            return -a
        if op == "^":
            if n is not None:
                return a ** n
            if a < 0 or (a == 0 and v[1] <= 0):     # 0 to a positive power is 0
                raise Undefined("^")
            return a ** v[1]
        if op == "cbrt":
            return self.cbrt(a)
        if op == "abs":
            return abs(a)
        if op in LOGIC:
            return int(bool(LOGIC[op](*v)))
        if op == "step":
            return int(a >= 0) + a * 0
        if op == "hypot":
            return m.sqrt(sum(k * k for k in v))
        if op in ("log10", "log2"):
            if a < 0:
                raise Undefined(op)
            return m.log(a, 10 if op == "log10" else 2)
        if op == "sign":
            return (a > 0) - (a < 0) + a * 0
        if op in ("min", "max"):
            return min(v) if op == "min" else max(v)
        if op in ("sqrt", "log") and a < 0 or op in ("asin", "acos") and abs(a) > 1 \
                or op == "acosh" and a < 1 or op == "atanh" and abs(a) >= 1:
            raise Undefined(op)
        return getattr(m, op)(*v)

    def partials(self, op, v, y, n):
        try:
            return self._partials(op, v, y, n)
        except (ZeroDivisionError, OverflowError, ValueError) as e:
            raise Undefined(op) from e

    def _partials(self, op, v, y, n):
        a, m = v[0], self.m
        one = {"+": (1, 1), "-": (1, -1), "neg": (-1,), "sign": (0,)}
        if op in one:
            return one[op]
        if op == "if":
            return 0, int(bool(a)), int(not a)
        if op in LOGIC or op == "step":
            return (0,) * len(v)
        if op == "hypot":
            return tuple(k / y for k in v)
        if op in ("log10", "log2"):
            return (1 / (a * m.log(10 if op == "log10" else 2)),)
        if op == "*":
            return v[1], a
        if op == "/":
            return 1 / v[1], -y / v[1]
        if op == "^":
            if n is not None:
                return (n * a ** (n - 1) if n else 0), 0
            return v[1] * y / a, y * m.log(a)
        if op == "atan2":
            s = a * a + v[1] * v[1]
            return v[1] / s, -a / s
        if op in ("min", "max"):
            first = (a <= v[1]) == (op == "min")
            return int(first), int(not first)
        return ({"sin": lambda: m.cos(a), "cos": lambda: -m.sin(a), "tan": lambda: 1 + y * y,
                 "asin": lambda: 1 / m.sqrt(1 - a * a), "acos": lambda: -1 / m.sqrt(1 - a * a),
                 "atan": lambda: 1 / (1 + a * a), "sinh": lambda: m.cosh(a), "cosh": lambda: m.sinh(a),
                 "tanh": lambda: 1 - y * y, "asinh": lambda: 1 / m.sqrt(1 + a * a),
                 "acosh": lambda: 1 / m.sqrt(a * a - 1), "atanh": lambda: 1 / (1 - a * a), "exp": lambda: y,
                 "log": lambda: 1 / a, "sqrt": lambda: 1 / (2 * y), "cbrt": lambda: 1 / (3 * y * y),
                 "abs": lambda: (a > 0) - (a < 0)}[op](),)


EXACT = Arithmetic(mpmath.mp)
FLOAT = Arithmetic(math)


def evaluate(text, env=None, number=EXACT):
    """The value of one text, given the values of its names."""
    g = Graph()
    e = g.parse(text)
    return g.values(g.cone([e]), env or {}, number)[e]
