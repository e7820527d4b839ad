"""Equations in MATLAB's Symbolic Math Toolbox, in and out: `syms x(t) y(t) g`, `diff(x(t), t, 2) == -x(t)`, lists of them, and values.

What symbolic expressions print as is taken too (`[diff(x(t), t) == y(t), ...]`, without syms). Names that get a number are parameters with that value;
names that get an expression stand for it. Other calls (reduceDAEIndex, solve, plots) are left out with a warning, as they are asked of the service.
Refused by line: what has no place in a request. MATLAB itself was not there: the texts were held against the grammar's values."""
from __future__ import annotations

import re
import warnings
from typing import Any, Dict, List, Mapping, Optional, Set, Tuple

from .. import expressions
from ..expressions import Tree
from .errors import ConvertError, ConvertWarning
from .reading import Names, Parser, Piece, Token, lex, put

_TOKENS = re.compile(r"(?P<skip>[ \t\r]+|\.\.\.[^\n]*\n|^[ \t]*%\{[ \t]*\n.*?^[ \t]*%\}[ \t]*$|%[^\n]*)|(?P<string>'[^'\n]*'|\"[^\"\n]*\")|(?P<number>(?:\d+\.?\d*|\.\d+)(?:[eE][+-]?\d+)?(?![\w.]))"
                     r"|(?P<name>[A-Za-z_]\w*)|(?P<op>==|~=|<=|>=|&&|\|\||\.[*/^]|[-+*/^=<>(),;:{}\[\]~&|@\n.'])", re.S | re.A | re.M)
_LEFT_OUT = "is left out: it is no equation"
MOST_LETTERS = 200000        # of an equation, once expressions are put in for their names


class _Definition:
    """A name that was given: an equation or several, or an expression; closed: without names."""

    def __init__(self, text: str, closed: bool, equations: bool) -> None:
        self.text, self.closed, self.equations = text, closed, equations


class _Reader(Parser):
    PRODUCTS = {"*": "*", "/": "/", ".*": "*", "./": "/"}
    POWERS = ("^", ".^")

    def __init__(self, text: str) -> None:
        super().__init__(lex(text, _TOKENS))
        self.names = Names()
        self.functions: Dict[str, str] = {}       # name: argument
        self.symbols: List[str] = []
        self.time: Optional[str] = None
        self.declared = False                     # whether there is any syms
        self.given: Dict[str, _Definition] = {}
        self.equations: List[str] = []
        self.order: List[str] = []                # of variables, where a list of them alone is given
        self.parameters: Dict[str, str] = {}
        self.free = False                         # whether a name was met in the present expression
        while self.token.kind != "end":
            self.statement()

    # -- statements --

    def ends(self) -> bool:
        return self.token.kind == "end" or self.token.text in ("\n", ";", ",")

    def finish(self) -> None:
        if not self.ends():
            raise self.wrong(f"{self.token.text!r} is too much")
        while self.token.text in ("\n", ";", ",") and self.token.kind == "op":
            self.at += 1

    def line_left_out(self, why: str) -> None:
        token, depth = self.token, 0
        warnings.warn(f"line {token.line}: {why} {_LEFT_OUT}", ConvertWarning, stacklevel=6)
        while self.token.kind != "end" and (depth > 0 or self.token.text not in ("\n", ";")):
            depth += (self.token.text in ("(", "[", "{")) - (self.token.text in (")", "]", "}"))
            self.at += 1

    def statement(self) -> None:
        self.free = False
        if self.ends():
            self.finish()
            return
        t = self.token
        if t.text == "syms":
            self.at += 1
            self.declarations()
        elif t.text in ("clear", "clc", "close", "format", "hold", "figure", "assume", "assumeAlso", "disp", "pretty", "simplify", "plot", "fplot", "clearvars", "warning", "digits"):
            self.line_left_out(t.text)
        elif t.text in ("for", "while", "if", "function", "switch", "try", "end", "parfor", "classdef"):
            raise self.wrong(f"{t.text}: programs are not known here, only equations")
        elif t.text == "[" and self.several():
            self.line_left_out("a call with several results")
        elif t.kind == "name" and self.tokens[self.at + 1].text == "=":
            self.at += 2
            self.assignment(t)
        elif t.kind == "name" and self.tokens[self.at + 1].text == "(" and self.symbolic_function():
            pass
        else:
            self.take_equations(self.value())
        self.finish()

    def several(self) -> bool:
        """[a, b] = f(...)"""
        at = self.at
        while self.tokens[at].kind != "end" and self.tokens[at].text not in ("]", "\n"):
            at += 1
        return self.tokens[at].text == "]" and self.tokens[at + 1].text == "="

    def symbolic_function(self) -> bool:
        """f(t) = expression: f stands for it."""
        words = [t.text for t in self.tokens[self.at:self.at + 5]]
        if len(words) < 5 or words[3:5] != [")", "="]:
            return False
        token = self.token
        self.at += 5
        self.assignment(token)
        return True

    def declarations(self) -> None:
        self.declared = True
        while not self.ends():
            t = self.token
            if t.kind != "name":
                raise self.wrong("syms needs names")
            self.at += 1
            if self.next("("):
                argument = self.token
                if argument.kind != "name" or self.tokens[self.at + 1].text != ")":
                    raise self.wrong("only functions of one variable, time, are known here")
                self.at += 2
                self.function(t, argument.text)
            elif t.text not in ("real", "positive", "integer", "rational"):
                self.symbols.append(t.text)

    def function(self, token: Token, argument: str) -> None:
        if self.time is not None and argument != self.time:
            raise self.wrong(f"{token.text} is a function of {argument}, others are of {self.time}", token)
        self.time = argument
        self.functions.setdefault(token.text, argument)

    def assignment(self, name: Token) -> None:
        if self.token.kind == "name" and self.tokens[self.at + 1].text == "(" and self.token.text in ("sym", "symfun", "symvar", "str2sym") and self.declaring(name):
            return
        if self.token.kind == "name" and self.tokens[self.at + 1].text == "(" and self.foreign(self.token.text):
            self.line_left_out(self.token.text)
            return
        values = self.value()
        equations = [v for v in values if v[1]]
        if name.text in self.functions and not equations:
            raise self.wrong(f"{name.text} is a function of time already", name)
        if equations:
            fresh = [v for v in values if v[1] and not v[2]]
            self.given[name.text] = _Definition("", False, True)
            self.take_equations(fresh)
        elif len(values) == 1:
            text = values[0][0]
            closed = not self.free
            if closed:
                self.parameters[name.text] = text
            self.given[name.text] = _Definition(text, closed, False)
        else:
            self.take_order([v[0] for v in values])
            self.given[name.text] = _Definition("", False, True)

    def foreign(self, word: str) -> bool:
        return word in {"reduceDAEIndex", "reduceDAEToODE", "reduceDifferentialOrder", "massMatrixForm", "daeFunction", "odeFunction", "decic", "ode15i", "ode15s", "ode45", "ode23t", "odeset", "solve",
                        "dsolve", "isLowIndexDAE", "findDecoupledBlocks", "incidenceMatrix", "matlabFunction", "jacobian", "linspace", "zeros", "ones", "figure"}

    def declaring(self, name: Token) -> bool:
        """x = sym('x')"""
        words = self.tokens[self.at:self.at + 4]
        if words[0].text == "sym" and words[2].kind == "string" and words[2].text.strip("'\"") == name.text:
            self.at += 3
            while not self.next(")"):
                if self.token.kind == "end":
                    raise self.wrong(") is missing")
                self.at += 1
            self.declared = True
            self.symbols.append(name.text)
            return True
        return False

    def take_equations(self, values: List[Tuple[str, bool, bool]]) -> None:
        if len(values) > 1 and not any(v[1] for v in values):
            self.take_order([v[0] for v in values])
            return
        for text, equation, known in values:
            if not equation and not known:
                warnings.warn(f"line {self.token.line}: {text if len(text) < 60 else text[:57] + '...'} {_LEFT_OUT}", ConvertWarning, stacklevel=7)
            elif not known:
                self.equations.append(text)

    def take_order(self, texts: List[str]) -> None:
        variables = {self.names.known[f] for f in self.functions if f in self.names.known}
        if all(t in variables for t in texts):
            self.order = texts

    # -- values --

    def value(self) -> List[Tuple[str, bool, bool]]:
        """An expression, an equation or a list of them: text, whether it is an equation, whether it was counted before."""
        if not self.next("["):
            return self.one()
        out: List[Tuple[str, bool, bool]] = []
        while not self.next("]"):
            if self.next(",", ";", "\n"):
                continue
            if self.token.kind == "end":
                raise self.wrong("] is missing")
            out += self.one()
            if self.token.text not in (",", ";", "\n", "]"):
                raise self.wrong("a comma or ] is missing")
        self.next("'")
        return out

    def one(self) -> List[Tuple[str, bool, bool]]:
        t = self.token
        if t.kind == "name" and t.text in self.given and self.given[t.text].equations and self.tokens[self.at + 1].text in (",", ";", "]", "\n", ""):
            self.at += 1
            return [("", True, True)]
        if t.kind == "name" and t.text in self.given and self.given[t.text].equations and self.tokens[self.at + 1].kind == "name":
            self.at += 1
            raise self.wrong("a comma is missing")
        left = self.expression()[0]
        if not self.next("=="):
            if self.token.text in ("<", ">", "<=", ">=", "~=", "="):
                raise self.wrong("an equation is written with ==")
            return [(left, False, False)]
        return [(f"{left} = {self.expression()[0]}", True, False)]

    def name(self, token: Token) -> Piece:
        self.at += 1
        word = token.text
        if word in self.functions or (not self.declared and self.tokens[self.at].text == "(" and self.tokens[self.at + 1].text == (self.time or "t") and self.tokens[self.at + 2].text == ")"):
            return self.variable(token)
        if word in self.given:
            return self.standing(token)
        if word == "pi":
            return "pi", 5
        if self.token.text == "(" and word not in self.symbols:
            self.at += 1
            return self.call(token, word, [])
        if word in ("i", "j", "Inf", "NaN", "inf", "nan") and word not in self.symbols:
            raise self.wrong(f"{word} has no place in a request", token)
        if self.declared and word not in self.symbols and word != self.time:
            raise self.wrong(f"{word} is not declared: add it to syms", token)
        if word not in self.symbols and word != self.time and word not in (self.time or "t"):
            self.symbols.append(word)
        self.free = True
        return self.names.take(word), 5

    def variable(self, token: Token) -> Piece:
        if self.next("("):
            argument = self.token
            if argument.kind != "name" or self.tokens[self.at + 1].text != ")" or (self.time is not None and argument.text != self.time):
                raise self.wrong(f"{token.text} must stand as {token.text}({self.time or 't'}): no values and no delays")
            self.at += 2
            self.function(token, argument.text)
        self.free = True
        return self.names.take(token.text), 5

    def standing(self, token: Token) -> Piece:
        d = self.given[token.text]
        if d.equations:
            raise self.wrong(f"{token.text} is a list or an equation, not an expression", token)
        if self.time and self.token.text == "(" and self.tokens[self.at + 1].text == self.time and self.tokens[self.at + 2].text == ")":
            self.at += 3
        if d.closed:
            return self.names.take(token.text), 5
        self.free = True
        if len(d.text) > MOST_LETTERS:
            raise self.wrong(f"{token.text} grows too long once expressions are put in for their names", token)
        return f"({d.text})", 5

    def call(self, token: Token, name: str, arguments: List[Piece]) -> Piece:
        if name == "diff":
            return self.derivative(token)
        if name in ("sym", "vpa", "rewrite") and self.token.kind == "string":
            inside = self.token.text.strip("'\"")
            self.at += 1
            self.need(")")
            if not re.fullmatch(r"[-+\d./eE*() ]+", inside):
                raise self.wrong(f"sym('{inside}') is no number", token)
            return f"({inside})", 5
        arguments = self.arguments()
        if name in ("sym", "simplify", "expand", "double", "collect") and len(arguments) == 1:
            return put(arguments[0], 5) if arguments[0][1] == 5 else f"({arguments[0][0]})", 5
        if name in ("log10", "log2") and len(arguments) == 1:
            return f"log({arguments[0][0]})/log({name[3:]})", 2
        if name == "nthroot" and len(arguments) == 2 and arguments[1][0] == "3":
            return f"cbrt({arguments[0][0]})", 5
        if name == "power" and len(arguments) == 2:
            return f"{put(arguments[0], 5)}^{put(arguments[1], 5)}", 4
        by_sine = {"sec": "1/cos({0})", "csc": "1/sin({0})", "cot": "cos({0})/sin({0})"}
        if name in by_sine and len(arguments) == 1:
            return by_sine[name].format(arguments[0][0]), 2
        return super().call(token, name, arguments)

    def derivative(self, token: Token) -> Piece:
        """diff(e), diff(e, t), diff(e, n), diff(e, t, n), diff(e, t, t)"""
        text, rank = self.expression()
        order, given = 0, False
        while self.next(","):
            t = self.token
            self.at += 1
            if t.kind == "name" and t.text == (self.time or "t"):
                self.time = t.text
                order, given = order + 1, True
            elif t.kind == "number" and t.text.isdigit():
                order, given = order - (1 if order else 0) + int(t.text), True
            else:
                raise self.wrong("diff is by time alone, as diff(x(t), t, 2)", t)
        self.need(")")
        if not given:
            order = 1
        base = text.rstrip("'")
        if re.fullmatch(r"[A-Za-z_]\w*'*", text) and base in {self.names.known.get(f) for f in self.functions}:
            return text + "'" * order, 5
        return (f"der({text})" if order == 1 else f"der({text}, {order})"), 5

    def power(self) -> Piece:
        """From left to right; an exponent may have a sign."""
        left = self.atom()
        while self.next(*self.POWERS):
            negative = False
            while self.token.text in ("+", "-"):
                negative ^= self.token.text == "-"
                self.at += 1
            right = self.atom()
            left = f"{put(left, 5)}^{f'(-{put(right, 4)})' if negative else put(right, 5)}", 4
        if self.token.text == "'":
            raise self.wrong("a transpose has no place in an equation")
        return left


def request(text: str) -> Dict[str, Any]:
    """The request of a text. Variables are the functions of time, in the order of a list of them alone, else as they are declared or come."""
    reader = _Reader(text)
    if not reader.functions:
        raise ConvertError("there is no function of time: syms x(t)")
    if not reader.equations:
        raise ConvertError("there are no equations, with ==")
    unused = [f for f in reader.functions if f not in reader.names.known]
    variables = [reader.names.take(f) for f in reader.functions if f not in unused]
    if unused:
        warnings.warn(f"no equation uses {', '.join(unused)}", ConvertWarning, stacklevel=2)
    if reader.order and set(reader.order) <= set(variables):
        variables = reader.order + [v for v in variables if v not in reader.order]
    used: Set[str] = set()
    for e in reader.equations:
        used |= set(re.findall(r"(?<![\w.])[A-Za-z_]\w*(?!\w|\()", e))
    values: Dict[str, Optional[str]] = {}
    for s in [*dict.fromkeys(reader.symbols), *reader.parameters]:
        made = reader.names.known.get(s)
        if made in used and made not in variables and s != reader.time:
            values[made] = _closed(s, reader)
    system: Dict[str, Any] = {"form": "equations", "variables": variables, "equations": reader.equations}
    if values:
        system["parameters"] = values
    time = reader.names.known.get(reader.time or "t", reader.time or "t")
    if time != "t":
        system["time"] = time
    return {"system": system}


def _closed(name: str, reader: _Reader) -> Optional[str]:
    """The value of a parameter: other ones in it are put in (each was given before it)."""
    text = reader.parameters.get(name)
    back = {v: k for k, v in reader.names.known.items()}
    for _ in range(100):
        if text is None or not any(back.get(w) in reader.parameters for w in re.findall(r"(?<![\w.])[A-Za-z_]\w*(?!\w|\()", text)):
            return text
        text = re.sub(r"(?<![\w.])[A-Za-z_]\w*(?!\w|\()", lambda m: f"({reader.parameters[back[m[0]]]})" if back.get(m[0]) in reader.parameters else m[0], text)
        if len(text) > MOST_LETTERS:
            break
    raise ConvertError(f"the value of {name} grows too long once others are put in")


# -- out --

_OUT = {"sin", "cos", "tan", "asin", "acos", "atan", "atan2", "sinh", "cosh", "tanh", "asinh", "acosh", "atanh", "exp", "log", "sqrt", "abs", "sign", "log10", "log2"}
_KEYWORDS = {"break", "case", "catch", "classdef", "continue", "else", "elseif", "end", "for", "function", "global", "if", "otherwise", "parfor", "persistent", "return", "spmd", "switch", "try", "while",
             "syms", "diff", "i", "j", "pi", "eqns", "vars", "real"} | _OUT


def _text(t: Tree, names: Mapping[str, str], time: str) -> str:
    if t.op == "number":
        return t.value
    if t.op == "name":
        return names[t.value] if t.value != "pi" or "pi" in names else "pi"
    if t.op in ("+", "-", "*", "/"):
        first, rest = expressions.spine(t, "+", "-") if t.op in "+-" else expressions.spine(t, "*", "/")
        return "(" + _text(first, names, time) + "".join(f" {op} {_text(a, names, time)}" for op, a in rest) + ")"
    a = [_text(x, names, time) for x in t.args]
    if t.op == "neg":
        return f"(-{a[0]})"
    if t.op == "^":
        return f"({a[0]}^{a[1] if re.fullmatch(r'[0-9]+', a[1]) else '(' + a[1] + ')'})"
    if t.op == "call" and t.value == "der":
        return f"diff({a[0]}, {time}{', ' + a[1] if len(a) > 1 else ''})"
    if t.op == "call" and t.value == "cbrt":
        return f"(sign({a[0]})*abs({a[0]})^(1/3))"
    if t.op == "call" and t.value in ("min", "max") and len(a) >= 2:       # min and max of symbols are not MATLAB's
        out = a[0]
        for b in a[1:]:
            out = f"(({out} + {b} {'-' if t.value == 'min' else '+'} abs({out} - {b}))/2)"
        return out
    if t.op == "call" and t.value in _OUT:
        return f"{t.value}({', '.join(a)})"
    raise ConvertError(f"{t.value or t.op} is not written for MATLAB")


def text(request_: Mapping[str, Any]) -> str:
    """A request of the form `equations` as statements of the toolbox: syms, values of parameters, `eqns` and `vars`."""
    system = request_["system"] if "system" in request_ else request_
    if system.get("form", "equations") != "equations" or system.get("tables"):
        raise ConvertError("only systems of the form `equations` without tables are written")
    listed = [system["variables"]] if isinstance(system["variables"], str) else list(system["variables"])
    parameters, taken = dict(system.get("parameters") or {}), set(_KEYWORDS)

    def identifier(name: str) -> str:
        made = re.sub(r"\W+", "_", name)
        made = made if made[0] != "_" else "x" + made
        while made in taken:
            made += "_"
        taken.add(made)
        return made
    time = identifier(system.get("time", "t"))
    names: Dict[str, str] = {system.get("time", "t"): time}
    functions = {v: identifier(v) for v in listed}
    names.update({p: identifier(p) for p in parameters})
    equations = [system["equations"]] if isinstance(system["equations"], str) else system["equations"]
    lines = ["syms " + " ".join([f"{f}({time})" for f in functions.values()])]
    free = [names[p] for p, v in parameters.items() if v is None]
    lines += ["syms " + " ".join(free)] if free else []
    rows: List[str] = []
    try:
        lines += [f"{names[p]} = sym({_text(expressions.parse(v), {}, time)});" for p, v in parameters.items() if v is not None]
        for e in equations:
            tree = expressions.parse(e)
            stack = [tree]
            while stack:
                t = stack.pop()
                stack.extend(t.args)
                base = t.value.rstrip("'")
                if t.op == "name" and base in functions:
                    order = len(t.value) - len(base)
                    names[t.value] = f"{functions[base]}({time})" if not order else f"diff({functions[base]}({time}), {time}{', ' + str(order) if order > 1 else ''})"
            left, right = tree.args if tree.op == "=" else (tree, Tree("number", "0"))
            rows.append(f"  {_text(left, names, time)} == {_text(right, names, time)}")
    except KeyError as e:
        raise ConvertError(f"{e.args[0]} is no variable, no parameter and not time") from None
    except ValueError as e:
        raise e if isinstance(e, ConvertError) else ConvertError(str(e)) from None
    return "\n".join([*lines, "eqns = [", *(r + ";" for r in rows), "];", f"vars = [{', '.join(f'{f}({time})' for f in functions.values())}];", ""])
