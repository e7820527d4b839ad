"""Expressions of the grammar: read into a tree, and written as Python, LaTeX and SymPy."""
from __future__ import annotations

import importlib
import re
from typing import Any, Callable, List, Mapping, NamedTuple, Optional, Tuple, Union

_TOKEN = re.compile(r"\s*(?:(\d+\.?\d*(?:[eE][+-]?\d+)?|\.\d+(?:[eE][+-]?\d+)?)|([A-Za-z_]\w*(?:\[[\d,]+\])?'*)|(\*\*|<=|>=|==|!=|[-+*/^(),=<>])|(\S))")
LONG = 100               # terms that are still written as a sum
MOST_NESTED = 60         # parentheses: each takes some frames of Python's 1000


class Tree(NamedTuple):
    """`op` is number, name, call, neg, +, -, *, /, ^ or =; `value` the text of a leaf, the function of a call."""
    op: str
    value: str
    args: Tuple["Tree", ...] = ()


class _Reader:
    def __init__(self, text: str) -> None:
        self.text, self.tokens, self.at, self.depth = text, list(self._lex(text)), 0, 0

    @staticmethod
    def _lex(text: str) -> List[Tuple[str, str]]:
        out, at = [], 0
        text = text.rstrip()
        while at < len(text):
            m = _TOKEN.match(text, at)
            if not m or m[4]:
                raise ValueError(f"column {at + 1} of {text!r} cannot be read")
            out.append(("number", m[1]) if m[1] else ("name", m[2]) if m[2] else ("op", m[3]))
            at = m.end()
        return out

    def next(self, *ops: str) -> Optional[str]:
        if self.at < len(self.tokens) and self.tokens[self.at][0] == "op" and self.tokens[self.at][1] in ops:
            self.at += 1
            return self.tokens[self.at - 1][1]
        return None

    def need(self, op: str) -> None:
        if not self.next(op):
            raise ValueError(f"{self.text!r}: {op} is missing")

    def chain(self, below: Callable[[], Tree], *ops: str) -> Tree:
        left = below()
        while True:
            op = self.next(*ops)
            if not op:
                return left
            left = Tree("=" if op == "==" else op, "", (left, below()))

    def equation(self) -> Tree:
        self.depth += 1
        if self.depth > MOST_NESTED:
            raise ValueError("the expression is nested too deeply")
        left = self.chain(self.sum, "=", "==")
        self.depth -= 1
        return left

    def sum(self) -> Tree:
        return self.chain(self.product, "+", "-")

    def product(self) -> Tree:
        return self.chain(self.signed, "*", "/")

    def signed(self) -> Tree:
        if self.next("-"):
            return Tree("neg", "", (self.signed(),))
        return self.signed() if self.next("+") else self.power()

    def power(self) -> Tree:
        base = self.atom()
        return Tree("^", "", (base, self.signed())) if self.next("^", "**") else base

    def atom(self) -> Tree:
        if self.next("("):
            inside = self.equation()
            self.need(")")
            return inside
        if self.at == len(self.tokens) or self.tokens[self.at][0] == "op":
            raise ValueError(f"{self.text!r}: an operand is missing")
        kind, word = self.tokens[self.at]
        self.at += 1
        if kind == "number" or not self.next("("):
            return Tree(kind, word)
        args = [self.equation()]
        while self.next(","):
            args.append(self.equation())
        self.need(")")
        if word == "der" and args[0].op == "name" and (len(args) == 1 or args[1].op == "number"):
            return Tree("name", args[0].value + "'" * (int(args[1].value) if len(args) > 1 else 1))
        return Tree("call", word, tuple(args))


def spine(t: Tree, *ops: str) -> Tuple[Tree, List[Tuple[str, Tree]]]:
    """a + b - c + ... as its first operand and the others, so that nothing recurses on how long a sum is."""
    rest: List[Tuple[str, Tree]] = []
    while t.op in ops:
        rest.append((t.op, t.args[1]))
        t = t.args[0]
    return t, rest[::-1]


def parse(text: Union[str, int, float, Tree]) -> Tree:
    """The tree of an expression or an equation. ValueError where it is none."""
    if isinstance(text, Tree):
        return text
    reader = _Reader(str(text))
    try:
        tree = reader.equation()
    except RecursionError:
        raise ValueError("the expression is nested too deeply") from None
    if reader.at < len(reader.tokens):
        raise ValueError(f"{text!r}: {reader.tokens[reader.at][1]} is too much")
    return tree


# -- Python --

_PYTHON = {"sin": "sin", "cos": "cos", "tan": "tan", "asin": "asin", "acos": "acos", "atan": "atan", "atan2": "atan2", "sinh": "sinh", "cosh": "cosh", "tanh": "tanh",
           "asinh": "asinh", "acosh": "acosh", "atanh": "atanh", "exp": "exp", "log": "log", "sqrt": "sqrt", "cbrt": "cbrt", "abs": "abs", "sign": "sign", "min": "min", "max": "max",
           "hypot": "hypot", "log10": "log10", "log2": "log2", "step": "step"}


def python(tree: Union[str, Tree], names: Mapping[str, str]) -> str:
    """The expression as Python. Names become what `names` says, functions `f.sin` and so on, long sums `f.total((a, b, ...))`: an object f must have them. Nothing else of
    the text gets into the result, so that it may be evaluated. KeyError names what is not known."""
    t = parse(tree)
    if t.op == "number":
        return t.value + ("" if any(c in t.value for c in ".eE") else ".0")
    if t.op == "name":
        return "f.pi" if t.value == "pi" and "pi" not in names else names[t.value]
    if t.op in ("+", "-", "*", "/"):
        first, rest = spine(t, "+", "-") if t.op in "+-" else spine(t, "*", "/")
        if t.op in "+-" and len(rest) > LONG:      # Python's own compiler recurses on long sums
            return "f.total((" + python(first, names) + "".join(f", {python(a, names)}" if op == "+" else f", -{python(a, names)}" for op, a in rest) + "))"
        return "(" + python(first, names) + "".join(f" {op} {python(a, names)}" for op, a in rest) + ")"
    args = [python(a, names) for a in t.args]
    if t.op == "call":
        return f"f.{_PYTHON[t.value]}({', '.join(args)})"
    if t.op == "neg":
        return f"(-{args[0]})"
    if t.op == "=":
        return f"({args[0]} - {args[1]})"
    if t.op == "^":
        power = t.args[1] if t.args[1].op == "number" else None
        return f"({args[0]}**{power.value})" if power and power.value.isdigit() else f"({args[0]}**{args[1]})"
    raise KeyError(t.op)


# -- LaTeX --

_GREEK = set("alpha beta gamma delta epsilon zeta eta theta iota kappa lambda mu nu xi rho sigma tau upsilon phi chi psi omega "
             "Gamma Delta Theta Lambda Xi Pi Sigma Upsilon Phi Psi Omega pi".split())
_KNOWN = {"sin", "cos", "tan", "sinh", "cosh", "tanh", "exp", "log", "min", "max"}
_RANK = {"=": 0, "+": 1, "-": 1, "neg": 2, "*": 3, "/": 6, "^": 5}


def _latex_name(word: str) -> str:
    base, order = word.rstrip("'"), len(word) - len(word.rstrip("'"))
    m = re.fullmatch(r"(.*?)_?(\d+|\[[\d,]+\])", base)
    stem, index = (m[1], m[2].strip("[]")) if m and m[1] else (base, "")
    shown = "\\" + stem if stem in _GREEK else stem if len(stem) == 1 else r"\mathit{" + stem.replace("_", r"\_") + "}"
    dotted = {0: shown, 1: rf"\dot{{{shown}}}", 2: rf"\ddot{{{shown}}}"}.get(order, rf"{shown}^{{({order})}}")
    return dotted + (f"_{{{index}}}" if index else "")


def latex(tree: Union[str, Tree]) -> str:
    """The expression as LaTeX, for math mode."""
    t = parse(tree)

    def part(a: Tree, least: int) -> str:
        return latex(a) if _RANK.get(a.op, 6) >= least else r"\left(" + latex(a) + r"\right)"
    if t.op == "number":
        return re.sub(r"[eE]([+-]?)0*(\d+)", lambda m: rf"\cdot 10^{{{m[1].replace('+', '')}{m[2]}}}", t.value)
    if t.op == "name":
        return _latex_name(t.value)
    a = t.args
    if t.op == "call":
        special = {"sqrt": r"\sqrt{%s}", "cbrt": r"\sqrt[3]{%s}", "abs": r"\left|%s\right|", "exp": r"e^{%s}", "asin": r"\arcsin\left(%s\right)", "acos": r"\arccos\left(%s\right)", "atan": r"\arctan\left(%s\right)"}
        if t.value in special and len(a) == 1:
            return special[t.value] % latex(a[0])
        name = "\\" + t.value if t.value in _KNOWN else rf"\operatorname{{{t.value}}}"
        return name + r"\left(" + ", ".join(map(latex, a)) + r"\right)"
    if t.op == "neg":
        return "-" + part(a[0], 3)
    if t.op == "/":
        return rf"\frac{{{latex(a[0])}}}{{{latex(a[1])}}}"
    if t.op == "^":
        return f"{part(a[0], 6)}^{{{latex(a[1])}}}" if a[0].op != "/" else rf"\left({latex(a[0])}\right)^{{{latex(a[1])}}}"
    if t.op == "*":
        first, rest = spine(t, "*")
        dots = [b.op == "number" or (b.op in ("^", "*") and b.args[0].op == "number") for _, b in rest]
        return part(first, 2) + "".join((r" \cdot " if dot else r" \, ") + part(b, 3) for dot, (_, b) in zip(dots, rest))
    if t.op == "=":
        return f"{latex(a[0])} = {latex(a[1])}"
    first, rest = spine(t, "+", "-")
    return part(first, 1) + "".join(f" {op} {part(b, 2)}" for op, b in rest)


# -- SymPy --

def sympy(tree: Union[str, Tree], symbols: Optional[Mapping[str, Any]] = None) -> Any:
    """The expression as SymPy's, decimals as exact rationals; an equation as its left side minus its right. x' is the symbol named "x'".
    `symbols` may give objects for names."""
    sp: Any = importlib.import_module("sympy")   # only here: the rest works without
    t = parse(tree)
    if t.op == "number":
        return sp.Rational(t.value)
    if t.op == "name":
        known = symbols or {}
        return known[t.value] if t.value in known else sp.pi if t.value == "pi" else sp.Symbol(t.value, real=True)
    if t.op in ("+", "-", "*", "/"):
        first, rest = spine(t, "+", "-") if t.op in "+-" else spine(t, "*", "/")
        total = sympy(first, symbols)
        if t.op in "+-":
            return sp.Add(total, *[sympy(a, symbols) if op == "+" else -sympy(a, symbols) for op, a in rest])
        return sp.Mul(total, *[sympy(a, symbols) if op == "*" else 1 / sympy(a, symbols) for op, a in rest])
    args = [sympy(a, symbols) for a in t.args]
    if t.op == "call":
        named = {"abs": sp.Abs, "min": sp.Min, "max": sp.Max, "cbrt": sp.real_root, "step": lambda x: sp.Piecewise((0, x < 0), (1, True)),
                 "log10": lambda x: sp.log(x, 10), "log2": lambda x: sp.log(x, 2), "hypot": lambda x, y: sp.sqrt(x**2 + y**2)}
        if t.value == "cbrt":
            return sp.real_root(args[0], 3)
        return named[t.value](*args) if t.value in named else getattr(sp, _PYTHON[t.value])(*args)
    if t.op == "neg":
        return -args[0]
    return args[0] ** args[1] if t.op == "^" else args[0] - args[1]
