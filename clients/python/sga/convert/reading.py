"""Expressions of other languages read into the grammar's texts: tokens with their places, and one parser that languages fill in."""
from __future__ import annotations

import re
from typing import Dict, List, NamedTuple, Optional, Pattern, Set, Tuple

from .errors import ConvertError

FUNCTIONS = {"sin", "cos", "tan", "asin", "acos", "atan", "atan2", "sinh", "cosh", "tanh", "asinh", "acosh", "atanh", "exp", "log", "sqrt", "cbrt", "abs", "sign", "min", "max"}
# What a request has a meaning for, and names of variables may not be.
RESERVED = FUNCTIONS | {"pi", "der", "hypot", "log10", "log2", "step", "if", "and", "or", "not"}
MOST_NESTED = 60         # parentheses: each takes some frames of Python's 1000


class Token(NamedTuple):
    kind: str            # number, name, string, op, end
    text: str
    line: int
    column: int


def lex(text: str, pattern: Pattern[str]) -> List[Token]:
    """The tokens; groups of the pattern are named by kinds, `skip` among them. What fits none is refused."""
    out: List[Token] = []
    at, line, begin = 0, 1, 0
    while at < len(text):
        m = pattern.match(text, at)
        if not m or m.end() == at:
            raise ConvertError(f"{text[at]!r} is not understood", line, at - begin + 1)
        kind = m.lastgroup or "skip"
        if kind != "skip":
            out.append(Token(kind, m[0], line, at - begin + 1))
        newlines = m[0].count("\n")
        if newlines:
            line, begin = line + newlines, at + m[0].rindex("\n") + 1
        at = m.end()
    out.append(Token("end", "", line, at - begin + 1))
    return out


class Names:
    """Names of another tool as names of the grammar, each its own."""

    def __init__(self) -> None:
        self.known: Dict[str, str] = {}
        self.taken: Set[str] = set(RESERVED)

    def take(self, name: str) -> str:
        if name not in self.known:
            made = re.sub(r"_+$", "", re.sub(r"\W+", "_", name.replace("'", ""), flags=re.ASCII)) or "x"
            made = made if re.match(r"[A-Za-z_]", made) else "x" + made
            while made in self.taken:
                made += "_"
            self.taken.add(made)
            self.known[name] = made
        return self.known[name]


Piece = Tuple[str, int]          # a text, and how strongly it binds: 1 sum, 2 product, 3 sign, 4 power, 5 all


def put(piece: Piece, least: int) -> str:
    return piece[0] if piece[1] >= least else f"({piece[0]})"


class Parser:
    """Sums, products, signs, powers, calls and parentheses. Languages give `name` and `call`, and say how operators are spelt."""
    SUMS: Dict[str, str] = {"+": "+", "-": "-"}
    PRODUCTS: Dict[str, str] = {"*": "*", "/": "/"}
    POWERS: Tuple[str, ...] = ("^",)

    def __init__(self, tokens: List[Token]) -> None:
        self.tokens, self.at, self.depth = tokens, 0, 0

    # -- tokens --

    @property
    def token(self) -> Token:
        return self.tokens[self.at]

    def next(self, *texts: str) -> Optional[Token]:
        t = self.token
        if t.kind in ("op", "name") and t.text in texts:
            self.at += 1
            return t
        return None

    def need(self, text: str) -> Token:
        t = self.next(text)
        if not t:
            raise self.wrong(f"{text} is missing")
        return t

    def wrong(self, detail: str, token: Optional[Token] = None) -> ConvertError:
        t = token or self.token
        return ConvertError(detail + (f" before {t.text!r}" if detail.endswith("missing") and t.text else ""), t.line, t.column)

    # -- expressions --

    def name(self, token: Token) -> Piece:
        raise NotImplementedError

    def call(self, token: Token, name: str, arguments: List[Piece]) -> Piece:
        """A function of the grammar, unless a language has more."""
        if name not in FUNCTIONS:
            raise self.wrong(f"the function {name} is not known here", token)
        count = 2 if name in ("atan2", "min", "max") else 1
        if len(arguments) != count:
            raise self.wrong(f"{name} takes {count} argument{'s' if count > 1 else ''}", token)
        return f"{name}({', '.join(a[0] for a in arguments)})", 5

    def expression(self) -> Piece:
        self.depth += 1
        if self.depth > MOST_NESTED:
            raise self.wrong("the expression is nested too deeply")
        left = self.product()
        while self.token.kind == "op" and self.token.text in self.SUMS:
            op = self.SUMS[self.tokens[self.at].text]
            self.at += 1
            left = f"{put(left, 1)} {op} {put(self.product(), 2)}", 1
        self.depth -= 1
        return left

    def product(self) -> Piece:
        left = self.signed()
        while self.token.kind == "op" and self.token.text in self.PRODUCTS:
            op = self.PRODUCTS[self.tokens[self.at].text]
            self.at += 1
            left = f"{put(left, 2)}{op}{put(self.signed(), 4)}", 2
        return left

    def signed(self) -> Piece:
        signs = 0
        while self.token.kind == "op" and self.token.text in ("+", "-"):
            signs += self.token.text == "-"
            self.at += 1
        inside = self.power()
        return (f"-{put(inside, 4)}", 3) if signs % 2 else inside

    def power(self) -> Piece:
        base = self.atom()
        if not self.next(*self.POWERS):
            return base
        return f"{put(base, 5)}^{put(self.exponent(), 5)}", 4

    def exponent(self) -> Piece:
        """Powers of powers are the languages' own matter."""
        return self.atom()

    def atom(self) -> Piece:
        t = self.token
        if self.next("("):
            inside = self.expression()
            self.need(")")
            return inside
        if t.kind == "number":
            self.at += 1
            return t.text, 5
        if t.kind != "name":
            raise self.wrong("an operand is missing")
        return self.name(t)

    def arguments(self) -> List[Piece]:
        """After the opening parenthesis."""
        out: List[Piece] = []
        if self.next(")"):
            return out
        out.append(self.expression())
        while self.next(","):
            out.append(self.expression())
        self.need(")")
        return out
