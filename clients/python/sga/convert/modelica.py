"""Flat Modelica in and out: one model of Real variables, parameters and equations, as `flat Modelica` texts of tools and textbooks have it.

Taken: Real (and types that end so: SI.Length), parameter, constant, input, output, discrete-free equations with der(), start and fixed,
initial equations `x = value`, the experiment annotation. Refused by line: algorithms, when, if, for, connect, arrays that are not written out,
other types. Reference: Modelica Language Specification 3.6."""
from __future__ import annotations

import re
import warnings
from typing import Any, Dict, List, NamedTuple, Optional, Tuple

from .errors import ConvertError, ConvertWarning
from .modelica_text import model
from .reading import MOST_NESTED, Names, Parser, Piece, Token, lex

__all__ = ["request", "model"]

_TOKENS = re.compile(r"(?P<skip>\s+|//[^\n]*|/\*.*?\*/)|(?P<string>\"(?:\\.|[^\"\\])*\")|(?P<number>(?:\d+\.?\d*|\.\d+)(?:[eE][+-]?\d+)?)"
                     r"|(?P<name>[A-Za-z_]\w*|'(?:\\.|[^'\\\n])+')|(?P<op>:=|==|<>|<=|>=|\.[*/^+-]|[-+*/^=<>(),;:{}\[\].])", re.S | re.A)
_PREFIXES = {"parameter", "constant", "input", "output", "discrete", "flow", "stream", "final", "inner", "outer", "public", "protected", "replaceable"}
_REFUSED = {"when": "a when clause", "if": "an if clause", "for": "a for clause", "connect": "connections", "algorithm": "an algorithm", "extends": "inheritance", "import": "imports",
            "equation": "", "function": "a function", "record": "a record", "package": "a package", "block": "a block", "connector": "a connector", "type": "a type", "while": "a loop",
            "reinit": "reinit", "terminate": "terminate"}


class Component(NamedTuple):
    prefix: str              # parameter, input, output or ""
    name: str                # in the request
    value: Optional[str]     # of the declaration
    start: Optional[str]
    fixed: bool
    token: Token


class _Reader(Parser):
    PRODUCTS = {"*": "*", "/": "/", ".*": "*", "./": "/"}
    SUMS = {"+": "+", "-": "-", ".+": "+", ".-": "-"}
    POWERS = ("^", ".^")

    def __init__(self, text: str) -> None:
        super().__init__(lex(text, _TOKENS))
        self.names = Names()
        self.declared: Dict[str, Component] = {}
        self.equations: List[str] = []
        self.initial: List[Tuple[str, str, Token]] = []       # name, value
        self.used: List[Tuple[str, Token]] = []
        self.experiment: Dict[str, str] = {}
        self.time = self.names.take("time")
        self.title = self.model()

    # -- names and calls --

    def reference(self, first: Token) -> str:
        """a.b[1].c, as it is written; the first token is taken already."""
        text = first.text
        while True:
            if self.token.text == "." and self.tokens[self.at + 1].kind == "name":
                text += "." + self.tokens[self.at + 1].text
                self.at += 2
            elif self.token.text == "[":
                end = self.at
                while self.tokens[end].text not in ("]", "", ";"):
                    end += 1
                inside = self.tokens[self.at + 1:end]
                if not inside or any(t.kind != "number" and t.text != "," for t in inside) or self.tokens[end].text != "]":
                    raise self.wrong("only subscripts that are whole numbers are known here: write arrays out")
                text += "[" + "".join(t.text for t in inside) + "]"
                self.at = end + 1
            else:
                return text

    def name(self, token: Token) -> Piece:
        if self.next("if"):
            return self.conditional()
        if token.text in ("true", "false", "not", "and", "or"):
            raise self.wrong("only expressions of Real are known here", token)
        self.at += 1
        word = self.reference(token)
        if self.next("("):
            return self.call(token, word, self.arguments())
        if word in ("Modelica.Constants.pi", "Modelica.Constants.PI"):
            return "pi", 5
        if word == "Modelica.Constants.e":
            return "exp(1)", 5
        if word in ("Modelica.Constants.g_n",):
            return "9.80665", 5
        if word == "time":
            return self.time, 5
        made = self.names.take(word)
        self.used.append((made, token))
        return made, 5

    # -- conditions --

    def conditional(self) -> Piece:
        """if c then a elseif d then b else e"""
        self.depth += 1
        if self.depth > MOST_NESTED:
            raise self.wrong("the expression is nested too deeply")
        condition = self.condition()
        self.need("then")
        first = self.expression()[0]
        second = self.conditional()[0] if self.next("elseif") else None
        if second is None:
            self.need("else")
            second = self.expression()[0]
        self.depth -= 1
        return f"if({condition}, {first}, {second})", 5

    def condition(self) -> str:
        """or over and over not over relations."""
        text = self.conjunction()
        while self.next("or"):
            text = f"{text} or {self.conjunction()}"
        return text

    def conjunction(self) -> str:
        text = self.negation()
        while self.next("and"):
            text = f"{text} and {self.negation()}"
        return text

    def negation(self) -> str:
        return f"not ({self.relation()})" if self.next("not") else self.relation()

    def relation(self) -> str:
        begin, depth = self.at, self.depth
        if self.next("("):                  # of a condition, or of a side of a relation
            self.depth += 1
            try:
                if self.depth > MOST_NESTED:
                    raise self.wrong("the expression is nested too deeply")
                inside = self.condition()
                self.need(")")
                if self.token.text in ("then", "and", "or", ")"):
                    self.depth = depth
                    return f"({inside})"
            except ConvertError:
                pass
            self.at, self.depth = begin, depth
        left = self.expression()[0]
        op = self.next("<", "<=", ">", ">=")
        if not op:
            raise self.wrong("a condition is a relation, <, <=, > or >=, of Real expressions")
        return f"{left} {op.text} {self.expression()[0]}"

    def call(self, token: Token, name: str, arguments: List[Piece]) -> Piece:
        name = name.removeprefix("Modelica.Math.")
        if name == "der" and len(arguments) == 1:
            return f"der({arguments[0][0]})", 5
        if name == "log10" and len(arguments) == 1:
            return f"log({arguments[0][0]})/log(10)", 2
        if name == "noEvent" and len(arguments) == 1:
            return arguments[0]
        if name in ("smooth", "homotopy") and len(arguments) == 2:
            return arguments[1 if name == "smooth" else 0]
        return super().call(token, name, arguments)

    def arguments(self) -> List[Piece]:
        """homotopy has names for its arguments."""
        out: List[Piece] = []
        if self.next(")"):
            return out
        while True:
            if self.token.text in ("actual", "simplified") and self.tokens[self.at + 1].text == "=":
                self.at += 2
            out.append(self.expression())
            if not self.next(","):
                self.need(")")
                return out

    # -- the model --

    def skip_text(self) -> None:
        """A comment in quotes, with its concatenations."""
        while self.token.kind == "string" or (self.token.text == "+" and self.tokens[self.at + 1].kind == "string"):
            self.at += 1

    def skip_parentheses(self) -> None:
        depth = 0
        while True:
            t = self.token
            depth += (t.text == "(" and t.kind == "op") - (t.text == ")" and t.kind == "op")
            if t.kind == "end":
                raise self.wrong("a parenthesis is not closed")
            self.at += 1
            if depth == 0:
                return

    def annotation(self) -> bool:
        if not self.next("annotation"):
            return False
        begin = self.at
        self.skip_parentheses()
        words = self.tokens[begin:self.at]
        for i, t in enumerate(words[:-2]):
            if t.text == "experiment" and words[i + 1].text == "(":
                inside, depth = words[i + 2:], 1
                for k in range(len(inside) - 2):
                    depth += (inside[k].text == "(") - (inside[k].text == ")")
                    if depth == 0:
                        break
                    minus = inside[k + 2].text == "-" and k + 3 < len(inside)
                    value = inside[k + 3 if minus else k + 2]
                    if inside[k].kind == "name" and inside[k + 1].text == "=" and value.kind == "number":
                        self.experiment[inside[k].text] = ("-" if minus else "") + value.text
        return True

    def model(self) -> str:
        if self.next("within"):
            while not self.next(";"):
                if self.token.kind == "end":
                    raise self.wrong("; is missing")
                self.at += 1
        while self.next("partial", "encapsulated", "final"):
            pass
        if not self.next("model", "class"):
            raise self.wrong("a model begins with `model NAME`" + (f"; this is {_REFUSED[self.token.text]}" if _REFUSED.get(self.token.text) else ""))
        if self.token.kind != "name":
            raise self.wrong("the name of the model is missing")
        title = self.token.text
        self.at += 1
        title = self.reference(self.tokens[self.at - 1])
        self.skip_text()
        section = "declarations"
        while not self.next("end"):
            if self.token.kind == "end":
                raise self.wrong("`end` is missing")
            if self.next("initial"):
                if not self.next("equation"):
                    raise self.wrong("only initial equations are known here, no initial algorithm")
                section = "initial"
            elif self.next("equation"):
                section = "equations"
            elif self.next("public", "protected"):
                section = "declarations"
            elif self.annotation():
                self.need(";")
            else:
                {"declarations": self.declaration, "initial": self.start, "equations": self.equation}[section]()
        if self.token.kind == "name":
            self.at += 1
            self.reference(self.tokens[self.at - 1])
        self.need(";")
        if self.token.kind != "end":
            raise self.wrong("there is more than one model")
        return title

    def refuse(self) -> None:
        if self.token.text in _REFUSED:
            raise self.wrong(f"{_REFUSED[self.token.text] or self.token.text}: this is no flat model of equations")

    def declaration(self) -> None:
        self.refuse()
        prefixes: List[str] = []
        while self.token.text in _PREFIXES:
            prefixes.append(self.token.text)
            self.at += 1
        if "discrete" in prefixes:
            raise self.wrong("discrete variables have no place in a request")
        kind = self.token
        if kind.kind != "name":
            raise self.wrong("a declaration is missing")
        self.at += 1
        written = self.reference(kind)
        constant = bool({"parameter", "constant"} & set(prefixes))
        if written in ("Boolean", "String") or (written == "Integer" and not constant):
            raise self.wrong(f"only Real variables are known here, not {written}", kind)
        if written not in ("Real", "Integer") and "." not in written:
            raise self.wrong(f"the type {written} is not known here: a flat model has Real alone", kind)
        prefix = "parameter" if constant else "input" if "input" in prefixes else "output" if "output" in prefixes else ""
        while True:
            self.component(prefix)
            if not self.next(","):
                break
        self.skip_text()
        self.annotation()
        self.need(";")

    def component(self, prefix: str) -> None:
        token = self.token
        if token.kind != "name":
            raise self.wrong("the name of a variable is missing")
        self.at += 1
        name = self.names.take(self.reference(token))
        if name in self.declared:
            raise self.wrong(f"{token.text} is declared twice", token)
        start: Optional[str] = None
        fixed = False
        if self.token.text == "(":
            start, fixed = self.modification()
        value = self.expression()[0] if self.next("=", ":=") else None
        self.skip_text()
        self.declared[name] = Component(prefix, name, value, start, fixed, token)

    def modification(self) -> Tuple[Optional[str], bool]:
        """(start = ..., fixed = ...); what else is said of a variable does not change the system."""
        self.need("(")
        start: Optional[str] = None
        fixed = False
        while not self.next(")"):
            while self.next("each", "final"):
                pass
            word = self.token
            if word.kind != "name":
                raise self.wrong("a modification is missing")
            self.at += 1
            if self.token.text == "(":
                self.skip_parentheses()
            elif self.next("="):
                if word.text == "start":
                    start = self.expression()[0]
                elif word.text == "fixed":
                    fixed = bool(self.next("true"))
                    if not fixed:
                        self.need("false")
                else:
                    depth = 0
                    while depth or self.token.text not in (",", ")"):
                        depth += (self.token.text in ("(", "{")) - (self.token.text in (")", "}"))
                        if self.token.kind == "end":
                            raise self.wrong("a parenthesis is not closed")
                        self.at += 1
            if not self.next(","):
                self.need(")")
                break
        return start, fixed

    def equation(self) -> None:
        self.refuse()
        if self.token.text == "assert" and self.tokens[self.at + 1].text == "(":
            warnings.warn(f"line {self.token.line}: assert is left out", ConvertWarning, stacklevel=6)
            self.at += 1
            self.skip_parentheses()
        else:
            left = self.expression()[0]
            self.need("=")
            self.equations.append(f"{left} = {self.expression()[0]}")
        self.skip_text()
        self.annotation()
        self.need(";")

    def start(self) -> None:
        self.refuse()
        token = self.token
        left = self.expression()[0]
        self.need("=")
        self.initial.append((left, self.expression()[0], token))
        self.skip_text()
        self.annotation()
        self.need(";")


# A name of the grammar in a text: no function, and no exponent of a number.
_NAME = re.compile(r"(?<![\w.])[A-Za-z_]\w*(?!\w|\()", re.A)
MOST_LETTERS = 20000         # of a parameter's value, once others are put in


def _plain(text: str) -> bool:
    return re.fullmatch(r"[A-Za-z_]\w*", text) is not None


def _closed(values: Dict[str, str], tokens: Dict[str, Token]) -> Dict[str, str]:
    """Values of parameters without names: those of others are put in."""
    out: Dict[str, str] = {}

    def close(name: str, above: Tuple[str, ...]) -> str:
        if name in above:
            raise ConvertError(f"the parameter {name} hangs on itself", tokens[name].line, tokens[name].column)
        if name not in out:
            out[name] = _NAME.sub(lambda m: "(" + close(m[0], (*above, name)) + ")" if m[0] in values else m[0], values[name])
            if len(out[name]) > MOST_LETTERS or len(above) > 200:
                raise ConvertError(f"the value of {name} grows too long once other parameters are put in", tokens[name].line, tokens[name].column)
        return out[name]
    for name in values:
        close(name, ())
    return {k: v[1:-1] if re.fullmatch(r"\([^()]*\)", v) else v for k, v in out.items()}


def request(text: str) -> Dict[str, Any]:
    """The request of a model. A parameter without a value stays symbolic. With an experiment annotation there is a trajectory; its start takes
    `start` as a guess, and holds what is `fixed` or in an initial equation."""
    reader = _Reader(text)
    declared = reader.declared
    for name, token in reader.used:
        if name not in declared:
            raise ConvertError(f"{token.text} is not declared", token.line, token.column)
    parameters = {c.name: c.value or c.start for c in declared.values() if c.prefix == "parameter"}
    unknowns = [c for c in declared.values() if c.prefix != "parameter"]
    if not unknowns:
        raise ConvertError("the model has no variables")
    given = {k: v for k, v in parameters.items() if v is not None}
    tokens = {k: c.token for k, c in declared.items()}
    for k, v in given.items():
        for word in _NAME.findall(v):
            if word in declared and word not in given:
                raise ConvertError(f"the value of {k} hangs on {word}, which is " + ("a parameter without a value" if word in parameters else "a variable"), tokens[k].line, tokens[k].column)
    closed = _closed(given, tokens)
    equations = reader.equations + [f"{c.name} = {c.value}" for c in unknowns if c.value]
    system: Dict[str, Any] = {"name": reader.title.strip("'"), "form": "equations", "time": reader.time, "variables": [c.name for c in unknowns],
                              "parameters": {k: closed.get(k) for k in parameters}, "equations": equations}
    if not parameters:
        del system["parameters"]
    out: Dict[str, Any] = {"system": system}
    initial: Dict[str, str] = {c.name: c.start for c in unknowns if c.start is not None}
    hold = [c.name for c in unknowns if c.fixed]
    initial.update({n: "0" for n in hold if n not in initial})
    for left, right, token in reader.initial:
        m = re.fullmatch(r"der\(([A-Za-z_]\w*)\)", left)
        target = left if _plain(left) and left in declared else f"{m[1]}'" if m else None
        if target is None:
            raise ConvertError("only initial equations `x = value` and `der(x) = value` are known here", token.line, token.column)
        initial[target] = right
        hold.append(target)
    known = {k: f"({v})" for k, v in closed.items()}
    for name, value in initial.items():
        initial[name] = _NAME.sub(lambda m: known.get(m[0], m[0]), value)
        unknown = [w for w in _NAME.findall(initial[name]) if w in declared or w == reader.time]
        if unknown:
            raise ConvertError(f"the start of {name} hangs on {unknown[0]}, which has no value")
    if "StopTime" in reader.experiment:
        start, stop = reader.experiment.get("StartTime", "0"), reader.experiment["StopTime"]
        interval = float(reader.experiment.get("Interval", 0))
        span = float(stop) - float(start)
        trajectory: Dict[str, Any] = {"start": start, "stop": stop, "samples": min(max(2, round(span / interval) + 1), 1000000) if interval > 0 else 501, "initial": initial}
        if hold:
            trajectory["hold"] = hold
        out["trajectory"] = trajectory
        if "Tolerance" in reader.experiment:
            out["accuracy"] = {"rtol": float(reader.experiment["Tolerance"])}
    elif initial:
        warnings.warn("without an experiment annotation with a StopTime there is no trajectory, and starts are left out", ConvertWarning, stacklevel=2)
    return out
