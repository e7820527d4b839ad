"""Flat Modelica in and out: one model of Real variables, parameters and equations, as `flat Modelica` texts of tools and textbooks have it.

Taken: Real (and types that end so: SI.Length), parameter, constant, input, output, discrete-free equations with der(), start and fixed,
initial equations `x = value`, the experiment annotation. Refused by line: algorithms, when, if, for, connect, arrays that are not written out,
other types. Reference: Modelica Language Specification 3.6."""
from __future__ import annotations

import re
import warnings
from typing import Any, Dict, List, Mapping, NamedTuple, Optional, Set, Tuple

from .. import expressions
from ..expressions import Tree
from .errors import ConvertError, ConvertWarning
from .reading import Names, Parser, Piece, Token, lex, put

_TOKENS = re.compile(r"(?P<skip>\s+|//[^\n]*|/\*.*?\*/)|(?P<string>\"(?:\\.|[^\"\\])*\")|(?P<number>(?:\d+\.?\d*|\.\d+)(?:[eE][+-]?\d+)?)"
                     r"|(?P<name>[A-Za-z_]\w*|'(?:\\.|[^'\\\n])+')|(?P<op>:=|==|<>|<=|>=|\.[*/^+-]|[-+*/^=<>(),;:{}\[\].])", re.S | re.A)
_PREFIXES = {"parameter", "constant", "input", "output", "discrete", "flow", "stream", "final", "inner", "outer", "public", "protected", "replaceable"}
_REFUSED = {"when": "a when clause", "if": "an if clause", "for": "a for clause", "connect": "connections", "algorithm": "an algorithm", "extends": "inheritance", "import": "imports",
            "equation": "", "function": "a function", "record": "a record", "package": "a package", "block": "a block", "connector": "a connector", "type": "a type", "while": "a loop",
            "reinit": "reinit", "terminate": "terminate"}
_KEYWORDS = set("algorithm and annotation assert block break class connect connector constant constrainedby der discrete each else elseif elsewhen encapsulated end enumeration equation "
                "expandable extends external false final flow for function if import impure in initial inner input loop model not operator or outer output package parameter partial "
                "protected public pure record redeclare replaceable return stream then true type when while within time Real Integer Boolean String abs sign sqrt sin cos tan asin acos "
                "atan atan2 sinh cosh tanh exp log log10 min max mod rem div floor ceil integer pre edge change sum product size smooth noEvent homotopy delay sample reinit".split())


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
        if token.text == "if":
            raise self.wrong("an if expression has no place in a request", token)
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


# -- out --

_CALLS = {"cbrt": "(sign({0})*abs({0})^(1/3))", "asinh": "(sign({0})*log(abs({0}) + sqrt({0}^2 + 1)))",
          "acosh": "log({0} + sqrt({0}^2 - 1))", "atanh": "0.5*log((1 + {0})/(1 - {0}))", "log2": "(log({0})/log(2))", "hypot": "sqrt({0}^2 + {1}^2)",
          "step": "(if {0} < 0 then 0 else 1)"}


def _text(t: Tree, names: Mapping[str, str]) -> str:
    if t.op == "number":
        return t.value if re.match(r"\d", t.value) else "0" + t.value
    if t.op == "name":
        if t.value == "pi" and "pi" not in names:
            return "3.141592653589793"
        return names[t.value]
    if t.op in ("+", "-", "*", "/"):
        first, rest = expressions.spine(t, "+", "-") if t.op in "+-" else expressions.spine(t, "*", "/")
        return "(" + _text(first, names) + "".join(f" {op} {_text(a, names)}" for op, a in rest) + ")"
    a = [_text(x, names) for x in t.args]
    if t.op == "neg":
        return f"(-{a[0]})"
    if t.op == "^":
        return f"({a[0]}^{a[1] if re.fullmatch(r'[0-9.]+', a[1]) else '(' + a[1] + ')'})"
    if t.op == "=":
        return f"{a[0].strip()} = {a[1]}"
    if t.op == "call" and t.value == "der" and len(a) > 1:
        raise ConvertError("higher derivatives of an expression are not written: give it a name")
    if t.op == "call" and t.value in _CALLS:
        return _CALLS[t.value].format(*a)
    if t.op == "call" and t.value in ("min", "max") and len(a) > 2:
        return f"{t.value}({a[0]}, {_text(Tree('call', t.value, t.args[1:]), names)})"
    if t.op == "call" and t.value in {"der", "sin", "cos", "tan", "asin", "acos", "atan", "atan2", "sinh", "cosh", "tanh", "exp", "log", "log10", "sqrt", "abs", "sign", "min", "max"}:
        return f"{t.value}({', '.join(a)})"
    raise ConvertError(f"{t.value or t.op} has no place in Modelica")


def _identifier(name: str, taken: Set[str]) -> str:
    made = name if re.fullmatch(r"[A-Za-z_]\w*", name) and name not in _KEYWORDS else "'" + name.replace("'", "_") + "'"
    while made in taken:
        made = made.rstrip("'") + "_" + ("'" if made.endswith("'") else "")
    taken.add(made)
    return made


def _orders(trees: List[Tree], variables: Set[str]) -> Dict[str, int]:
    """The highest derivative of each variable that is written with primes or der(x, n)."""
    out: Dict[str, int] = {}
    stack = list(trees)
    while stack:
        t = stack.pop()
        stack.extend(t.args)
        base = t.value.rstrip("'")
        if t.op == "name" and base in variables:
            out[base] = max(out.get(base, 0), len(t.value) - len(base))
    return out


def model(request_: Mapping[str, Any], name: Optional[str] = None) -> str:
    """A request of the form `equations` as a Modelica model. Higher derivatives become variables of their own. ConvertError: another form, tables,
    or what Modelica has no word for."""
    system = request_["system"] if "system" in request_ else request_
    if system.get("form", "equations") != "equations":
        raise ConvertError(f"only systems of the form `equations` are written, not {system.get('form')!r}")
    if system.get("tables"):
        raise ConvertError("tables are not written")
    given = system["variables"]
    listed = [given] if isinstance(given, str) else list(given)
    equations = system["equations"]
    try:
        trees = [expressions.parse(e) for e in ([equations] if isinstance(equations, str) else equations)]
    except ValueError as e:
        raise ConvertError(str(e)) from None
    taken: Set[str] = set()
    names = {v: _identifier(v, taken) for v in listed}
    parameters = dict(system.get("parameters") or {})
    names.update({p: _identifier(p, taken) for p in parameters})
    orders = _orders(trees, set(listed))
    start = dict((request_.get("trajectory") or {}).get("initial") or {})
    for key in start:
        base = key.rstrip("'")
        if base in names:
            orders[base] = max(orders.get(base, 0), len(key) - len(base) + (key != base))
    extra: List[Tuple[str, str]] = []            # a name, and what it is the derivative of
    for v in listed:
        above = names[v]
        for order in range(1, orders.get(v, 0) + 1):
            names[v + "'" * order] = f"der({above})"
            if order < orders[v]:
                made = _identifier(f"{v}_d{order}", taken)
                extra.append((made, above))
                names[v + "'" * order] = made
                above = made
    time = system.get("time", "t")
    names.setdefault(time, "time")
    hold = set((request_.get("trajectory") or {}).get("hold") or [])
    title = _identifier(name or re.sub(r"\W", "_", system.get("name") or "Model"), set())

    def attributes(key: str) -> str:
        value = start.get(key)
        if value is None:
            return ""
        return f"(start = {_text(expressions.parse(value), names)}{', fixed = true' if key in hold else ''})"
    lines = [f"model {title}"]
    lines += [f"  parameter Real {names[p]}{'' if v is None else ' = ' + _text(expressions.parse(v), names)};" for p, v in parameters.items()]
    lines += [f"  Real {names[v]}{attributes(v)};" for v in listed]
    back = {names[v + "'" * k]: v + "'" * k for v in listed for k in range(1, orders.get(v, 0))}
    lines += [f"  Real {made}{attributes(back[made])};" for made, _ in extra]
    lines.append("equation")
    lines += [f"  der({above}) = {made};" for made, above in extra]
    try:
        lines += [f"  {_text(t if t.op == '=' else Tree('=', '', (t, Tree('number', '0'))), names)};" for t in trees]
    except KeyError as e:
        raise ConvertError(f"{e.args[0]} is no variable, no parameter and not time") from None
    trajectory = request_.get("trajectory") or {}
    if "stop" in trajectory:
        interval = ""
        if "samples" in trajectory:
            span = expressions.parse(trajectory["stop"]), expressions.parse(trajectory.get("start", 0))
            if all(t.op == "number" for t in span) and int(trajectory["samples"]) > 1:
                interval = f", Interval = {(float(span[0].value) - float(span[1].value)) / (int(trajectory['samples']) - 1)!r}"
        lines.append(f"  annotation(experiment(StartTime = {trajectory.get('start', 0)}, StopTime = {trajectory['stop']}{interval}));")
    return "\n".join([*lines, f"end {title};", ""])
