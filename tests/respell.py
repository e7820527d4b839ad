"""Expressions in other words: names replaced, units changed, and spellings that mean the same.

A tree is parsed by the checkers' own parser; der(expression) stays a node of its own. What is
printed means the same wherever the given text has a value.
"""
import re
from fractions import Fraction

from expression import Graph

NAME = re.compile(r"(?<![A-Za-z_0-9.])([A-Za-z_][A-Za-z_0-9]*)('*)(?!\s*\()(?![A-Za-z_0-9'])")
SIDES = re.compile(r"==|=|~")


def rename(text, names):
    """The text with names replaced; numbers stay numbers."""
    if not isinstance(text, str):
        return text
    return NAME.sub(lambda m: names.get(m.group(1), m.group(1)) + m.group(2), text)


def exact(value):
    """The exact rational that a number or the text of one is; None where it is neither."""
    try:
        return Fraction(repr(value) if isinstance(value, float) else value)
    except (ValueError, TypeError, ZeroDivisionError):
        return None


def number(q):
    """A rational as text that stands anywhere."""
    return f"({q})" if q < 0 or q.denominator != 1 else str(q)


LOGIC = ("<", "<=", ">", ">=", "==", "!=", "and", "or", "not")     # whose values are no numbers


def joined(op, parts):
    """The text of an operator or function of texts."""
    if op in ("neg", "not"):
        return f"({'-' if op == 'neg' else 'not '}{parts[0]})"
    if op in LOGIC or op in "+-*/^":
        return f"({f' {op} '.join(parts)})"
    return f"{op}({', '.join(parts)})"


class Tree:
    """One text, with der(expression) kept."""

    def __init__(self, text):
        self.graph = Graph()
        self.graph.total = lambda e: self.graph.make("der", e)
        self.root = self.graph.parse(text)
        self.node = self.graph.node

    def print(self, e, leaf, speller=None):
        """The text of a node; leaf: what stands for a name, speller: chooses among spellings."""
        op, *args = self.node[e]
        if op == "const":
            return (speller.const if speller else number)(args[0])
        if op == "pi":
            return "pi"
        if op == "sym":
            return leaf(args[0])
        if speller and op in "+-*/^":
            return speller.binary(self, e, leaf)
        parts = [self.print(a, leaf, speller) for a in args]
        if speller and op in ("min", "max") and speller.coin():
            parts.reverse()
        return joined(op, parts)

    def text(self, leaf=lambda n: n, speller=None):
        return self.print(self.root, leaf, speller)

    def operands(self, e, op):
        """The operands of a chain of sums or products, with whether each is subtracted (divided by)."""
        out, stack = [], [(e, False)]
        less = {"+": "-", "*": "/"}[op]
        while stack:
            k, inverse = stack.pop()
            kind, *args = self.node[k]
            if kind == op:
                stack += [(args[1], inverse), (args[0], inverse)]
            elif kind == less:
                stack += [(args[1], not inverse), (args[0], inverse)]
            elif kind == "neg" and op == "+":
                stack.append((args[0], not inverse))
            else:
                out.append((k, inverse))
        return out


class Speller:
    """Chooses, at random, spellings that mean the same."""

    def __init__(self, rng):
        self.rng = rng

    def coin(self):
        return self.rng.random() < 0.5

    def const(self, q):
        if q.denominator == 1 and 2 <= q <= 100 and self.rng.random() < 0.1:
            k = self.rng.randint(1, int(q) - 1)
            return f"({k} + {q - k})"
        d = q.denominator
        for p in (2, 5):
            while d % p == 0:
                d //= p
        if d == 1 and q.denominator != 1 and q.denominator < 10 ** 6 and self.coin():
            k = len(str(q.denominator)) * 4
            digits = str(int(q * 10 ** k)).rjust(k + 1, "0")
            return f"{digits[:-k]}.{digits[-k:].rstrip('0') or '0'}"
        return number(q)

    def binary(self, tree, e, leaf):
        op, *args = tree.node[e]
        if op == "^":
            return self.power(tree, args, leaf)
        chain = "+" if op in "+-" else "*"
        parts = [(tree.print(k, leaf, self), inverse) for k, inverse in tree.operands(e, chain)]
        self.rng.shuffle(parts)
        return self.sum(parts) if chain == "+" else self.product(self.powers(parts))

    def powers(self, parts):
        """Equal factors as a power, half of the time."""
        out = []
        for part in dict.fromkeys(parts):
            n = parts.count(part)
            out += [(f"({part[0]}^{n})", part[1])] if n > 1 and self.coin() else [part] * n
        return out

    def power(self, tree, args, leaf):
        base = tree.print(args[0], leaf, self)
        kind, *value = tree.node[args[1]]
        if kind == "const" and value[0] in (2, 3) and self.coin():
            return "(" + "*".join([base] * int(value[0])) + ")"
        if kind == "const" and value[0] == 4 and self.coin():
            return f"(({base})^2)^2"
        if kind == "const" and value[0].denominator == 1 and value[0] > 1 and self.rng.random() < 0.3:
            return f"({base} * {base}^{value[0] - 1})"
        return f"({base} ^ {tree.print(args[1], leaf, self)})"

    def sum(self, parts):
        """Signed parts, associated at random."""
        if len(parts) == 1:
            return f"(-{parts[0][0]})" if parts[0][1] else parts[0][0]
        cut = self.rng.randint(1, len(parts) - 1)
        left, right = parts[:cut], parts[cut:]
        if self.coin():
            return f"({self.sum(left)} + {self.sum(right)})"
        if self.coin():
            return f"({self.sum(left)} - {self.sum([(p, not s) for p, s in right])})"
        return f"(-({self.sum([(p, not s) for p, s in right])} - {self.sum(left)}))"

    def product(self, parts):
        """Factors and divisors; a divisor alone is a power of -1 or 1 divided by it."""
        if len(parts) == 1:
            text, inverse = parts[0]
            return text if not inverse else f"(1/{text})" if self.coin() else f"({text}^-1)"
        cut = self.rng.randint(1, len(parts) - 1)
        left, right = parts[:cut], parts[cut:]
        if self.coin():
            return f"({self.product(left)} * {self.product(right)})"
        if not all(inverse for _, inverse in right):    # 1/(1/y) has no value at y = 0
            return f"({self.product(right)} * {self.product(left)})"
        return f"({self.product(left)} / {self.product([(p, not s) for p, s in right])})"


def on_sides(text, change):
    """change on a text, or on both sides of an equation."""
    if isinstance(text, str) and SIDES.search(text):
        left, right = SIDES.split(text)
        return change(left) + " = " + change(right)
    return change(text)
