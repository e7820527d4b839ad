"""SymPy in and out: equations with functions of time and their derivatives.

    x, y, lam = (Function(n)(t) for n in ("x", "y", "lam"))
    request([Eq(x.diff(t, 2), -lam*x), Eq(y.diff(t, 2), -lam*y - g), x**2 + y**2 - 1], parameters={g: "9.81"})

What is no Eq is 0. SymPy is only needed here."""
from __future__ import annotations

import importlib
from typing import Any, Dict, Iterable, List, Mapping, NamedTuple, Optional, Set, Tuple

from .. import expressions
from ..expressions import Tree
from .errors import ConvertError
from .reading import Names, Piece, put

_FUNCTIONS = {"sin": "sin", "cos": "cos", "tan": "tan", "asin": "asin", "acos": "acos", "atan": "atan", "atan2": "atan2", "sinh": "sinh", "cosh": "cosh", "tanh": "tanh", "asinh": "asinh",
              "acosh": "acosh", "atanh": "atanh", "exp": "exp", "Abs": "abs", "sign": "sign"}
_BY_SINE = {"sec": "1/cos({0})", "csc": "1/sin({0})", "cot": "cos({0})/sin({0})", "sech": "1/cosh({0})", "csch": "1/sinh({0})", "coth": "cosh({0})/sinh({0})"}


class System(NamedTuple):
    """Equations of a request in SymPy: Eq over `variables`, functions of `time`; `parameters`: their values by symbol, None where they have none."""
    equations: List[Any]
    variables: List[Any]
    parameters: Dict[Any, Any]
    time: Any


def _sympy() -> Any:
    return importlib.import_module("sympy")


class _Writer:
    def __init__(self, time: Any) -> None:
        self.sp, self.time, self.names = _sympy(), time, Names()
        self.variables: List[Any] = []       # in the order in which they come
        self.symbols: List[Any] = []
        if time is not None:
            self.names.take(time.name)

    def name(self, e: Any) -> str:
        """A function of time, or a symbol."""
        if e == self.time:
            return self.names.take(e.name)
        function = not e.is_Symbol
        known = self.variables if function else self.symbols
        if e not in known:
            known.append(e)
        return self.names.take(f"{e.func}" if function else e.name)

    def refuse(self, e: Any, why: str = "has no place in a request") -> ConvertError:
        text = str(e)
        return ConvertError(f"{text if len(text) < 80 else text[:77] + '...'} {why}")

    def number(self, e: Any) -> Piece:
        if e.is_Integer or e.is_Rational:
            text, rank = str(e), 5 if e.is_Integer else 2
        elif e.is_Float:
            text, rank = (repr(float(e)) if e._prec <= 53 else str(e)), 5
            if "inf" in text or "nan" in text:
                raise self.refuse(e, "is no number")
        else:
            raise self.refuse(e)
        return (text, rank) if text[0] != "-" else (text, 1)

    def write(self, e: Any) -> Piece:
        if e.is_Number:
            return self.number(e)
        if e == self.sp.pi:
            return "pi", 5
        if e == self.sp.E:
            return "exp(1)", 5
        if e.is_Symbol:
            return self.name(e), 5
        if e.is_Derivative:
            return self.derivative(e)
        if e.is_Add:
            return self.sum(e)
        if e.is_Mul:
            return self.product(e)
        if e.is_Pow:
            return self.power(e)
        if e.is_Function:
            return self.function(e)
        if e.is_number:
            raise self.refuse(e, "is no real number of the grammar")
        raise self.refuse(e)

    def derivative(self, e: Any) -> Piece:
        of, orders = e.expr, [int(n) for s, n in e.variable_count if s == self.time]
        if not isinstance(of, self.sp.core.function.AppliedUndef) or len(orders) != len(e.variable_count):
            raise self.refuse(e, "is no derivative by time of a function of time")
        return self.write(of)[0] + "'" * sum(orders), 5

    def sum(self, e: Any) -> Piece:
        out = ""
        for a in e.as_ordered_terms():
            negative = a.could_extract_minus_sign()
            text = put(self.write(-a if negative else a), 2)
            out += (" - " if negative else " + ") + text if out else ("-" if negative else "") + text
        return out, 1

    def product(self, e: Any) -> Piece:
        sign, above, below = "", [], []
        for a in e.as_ordered_factors():
            if a.is_Rational and not a.is_Integer:
                above += [self.sp.Integer(a.p)] if abs(a.p) != 1 or a.p < 0 else []
                below.append(self.sp.Integer(a.q))
            elif a.is_Pow and a.exp.is_number and a.exp.is_negative:
                below.append(self.sp.Pow(a.base, -a.exp))
            else:
                above.append(a)
        if above and above[0].is_Number and above[0] < 0:
            sign, above[0] = "-", -above[0]
            above = above[1:] if above[0] == 1 and len(above) > 1 else above
        text = "*".join(put(self.write(a), 4 if k else 3) for k, a in enumerate(above)) or "1"
        for b in below:
            text += f"/{put(self.write(b), 4)}"
        return sign + text, 1 if sign else 2

    def power(self, e: Any) -> Piece:
        base, exponent = e.as_base_exp() if not e.is_Pow else (e.base, e.exp)
        if base == self.sp.E:
            return f"exp({self.write(exponent)[0]})", 5
        if exponent.is_number and exponent.is_negative:
            return f"1/{put(self.write(self.sp.Pow(base, -exponent)), 4)}", 2
        if exponent == self.sp.Rational(1, 2):
            return f"sqrt({self.write(base)[0]})", 5
        return f"{put(self.write(base), 5)}^{put(self.write(exponent), 5)}", 4

    def function(self, e: Any) -> Piece:
        if isinstance(e, self.sp.core.function.AppliedUndef):
            if e.args != (self.time,):
                raise self.refuse(e, "is no function of time alone")
            return self.name(e), 5
        name = type(e).__name__
        if name not in _FUNCTIONS and name not in _BY_SINE and name not in ("log", "Min", "Max"):
            raise self.refuse(e)
        args = [self.write(a)[0] for a in e.args]
        if name == "log":
            return (f"log({args[0]})", 5) if len(args) == 1 else (f"log({args[0]})/log({args[1]})", 2)
        if name in ("Min", "Max"):
            text = args[0]
            for a in args[1:]:
                text = f"{name.lower()}({text}, {a})"
            return text, 5
        if name in _BY_SINE and len(args) == 1:
            return f"({_BY_SINE[name].format(args[0])})", 5
        return f"{_FUNCTIONS[name]}({', '.join(args)})", 5


def _flat(equations: Any) -> List[Any]:
    sp = _sympy()
    if isinstance(equations, (sp.Basic, sp.MatrixBase)) or not isinstance(equations, Iterable):
        equations = [equations]
    out: List[Any] = []
    for e in equations:
        if isinstance(e, sp.Eq) and isinstance(e.lhs, sp.MatrixBase):
            out += [sp.Eq(a, b, evaluate=False) for a, b in zip(e.lhs, e.rhs)]
        elif isinstance(e, sp.MatrixBase):
            out += list(e)
        elif e is True or e == sp.true:
            raise ConvertError("one of the equations is True: it says nothing")
        elif e is False or e == sp.false:
            raise ConvertError("one of the equations is False: nothing fulfils it")
        else:
            out.append(sp.sympify(e))
    return out


def _time_of(objects: Iterable[Any]) -> Any:
    sp = _sympy()
    found: Set[Any] = set()
    for e in objects:
        for f in e.atoms(sp.core.function.AppliedUndef):
            found |= set(f.args)
    symbols = {s for s in found if s.is_Symbol}
    if len(symbols) > 1 or found - symbols:
        raise ConvertError(f"functions have different arguments: {', '.join(sorted(map(str, found)))}; say which is time")
    return symbols.pop() if symbols else None


def _parameters(writer: _Writer, values: Optional[Mapping[Any, Any]]) -> Dict[str, Optional[str]]:
    sp = writer.sp
    given = {sp.Symbol(k) if isinstance(k, str) else k: v for k, v in (values or {}).items()}
    by_name = {k.name: v for k, v in given.items()}
    out: Dict[str, Optional[str]] = {}
    for s in writer.symbols:
        value = given.get(s, by_name.get(s.name))
        text = None if value is None else value if isinstance(value, str) else writer.write(sp.sympify(value))[0]
        out[writer.name(s)] = text
    return out


def _variables(writer: _Writer, named: Optional[Iterable[Any]]) -> List[str]:
    return [writer.name(v) for v in named] if named is not None else []


def request(equations: Any, variables: Optional[Iterable[Any]] = None, parameters: Optional[Mapping[Any, Any]] = None, time: Any = None, **more: Any) -> Dict[str, Any]:
    """The request of equations (Eq, expressions that are 0, matrices of them). variables: functions of time, in the order that is meant; else as they
    come. Symbols are parameters: those without a value in `parameters` stay symbolic. more: members of the request (trajectory, want)."""
    sp = _sympy()
    listed = _flat(equations)
    named = list(variables) if variables is not None else None
    time = time if time is not None else _time_of([*listed, *(named or [])])
    writer = _Writer(time)
    names = _variables(writer, named)
    texts = []
    try:
        for e in listed:
            left, right = (e.lhs, e.rhs) if isinstance(e, sp.Eq) else (e, sp.Integer(0))
            if isinstance(e, sp.core.relational.Relational) and not isinstance(e, sp.Eq):
                raise writer.refuse(e, "is no equation")
            sides = [writer.write(s.doit() if s.has(sp.Derivative) else s)[0] for s in (left, right)]
            texts.append(" = ".join(sides))
    except RecursionError:
        raise ConvertError("an equation is nested too deeply") from None
    if named is None:
        names = [writer.name(v) for v in writer.variables]
    elif len(writer.variables) > len(named):
        raise ConvertError(f"{writer.variables[len(named)]} is in the equations and not among the variables")
    if not names:
        raise ConvertError("there is no function of time in the equations")
    system: Dict[str, Any] = {"form": "equations", "variables": names, "equations": texts}
    values = _parameters(writer, parameters)
    if values:
        system["parameters"] = values
    if time is not None and writer.names.take(time.name) != "t":
        system["time"] = writer.names.take(time.name)
    return {"system": system, **more}


def lagrangian(function: Any, coordinates: Iterable[Any], holonomic: Iterable[Any] = (), forces: Iterable[Any] = (), parameters: Optional[Mapping[Any, Any]] = None,
               **more: Any) -> Dict[str, Any]:
    """The request of a Lagrangian of the coordinates (functions of time) and their derivatives, with holonomic constraints (each 0) and forces."""
    sp = _sympy()
    q, bound, pushed = list(coordinates), list(map(sp.sympify, holonomic)), list(map(sp.sympify, forces))
    writer = _Writer(_time_of([sp.sympify(function), *q, *bound, *pushed]))
    system: Dict[str, Any] = {"form": "lagrangian", "coordinates": [writer.name(v) for v in q], "lagrangian": writer.write(sp.sympify(function).doit())[0]}
    if bound:
        system["holonomic"] = [writer.write(c)[0] for c in bound]
    if pushed:
        system["forces"] = [writer.write(f.doit())[0] for f in pushed]
    if len(writer.variables) > len(q):
        raise ConvertError(f"{writer.variables[len(q)]} is no coordinate")
    values = _parameters(writer, parameters)
    if values:
        system["parameters"] = values
    if writer.time is not None and writer.names.take(writer.time.name) != "t":
        system["time"] = writer.names.take(writer.time.name)
    return {"system": system, **more}


# -- out --

def _derivatives(t: Tree, found: Dict[str, Tree]) -> Tree:
    """The tree with der(expression) as names of their own."""
    args = tuple(_derivatives(a, found) for a in t.args)
    if t.op == "call" and t.value == "der":
        found[f"#{len(found)}"] = Tree("call", "der", args)
        return Tree("name", f"#{len(found) - 1}")
    return Tree(t.op, t.value, args)


def equations(request_: Mapping[str, Any]) -> System:
    """The equations of a request of the form `equations` in SymPy. ConvertError: another form, tables, or a text that is none."""
    sp = _sympy()
    system = request_["system"] if "system" in request_ else request_
    if system.get("form", "equations") != "equations":
        raise ConvertError(f"only systems of the form `equations` are taken, not {system.get('form')!r}")
    if system.get("tables"):
        raise ConvertError("tables are not taken")
    given = system["variables"]
    listed = [given] if isinstance(given, str) else list(given)
    texts = [system["equations"]] if isinstance(system["equations"], str) else system["equations"]
    time = sp.Symbol(system.get("time", "t"), real=True)
    functions = {v: sp.Function(v, real=True)(time) for v in listed}
    parameters = {p: sp.Symbol(p, real=True) for p in system.get("parameters") or {}}
    out: List[Any] = []
    for text in texts:
        found: Dict[str, Tree] = {}
        try:
            tree = _derivatives(expressions.parse(text), found)
            names = _names_of([tree, *found.values()])
            known: Dict[str, Any] = {time.name: time, **functions, **parameters}
            for n in names:
                base = n.rstrip("'")
                if base != n and base in functions:
                    known[n] = sp.Derivative(functions[base], (time, len(n) - len(base)))
            for key, call in found.items():       # inner ones come first
                order = int(call.args[1].value) if len(call.args) > 1 else 1
                known[key] = sp.Derivative(expressions.sympy(call.args[0], known), (time, order)).doit()
            unknown = sorted(n for n in names if n not in known and n != "pi")
            if unknown:
                raise ConvertError(f"{unknown[0]} in {text!r} is no variable, no parameter and not time")
            sides = tree.args if tree.op == "=" else (tree, Tree("number", "0"))
            out.append(sp.Eq(*(expressions.sympy(s, known) for s in sides), evaluate=False))
        except (ValueError, KeyError, AttributeError) as e:
            raise e if isinstance(e, ConvertError) else ConvertError(f"{text!r}: {e}") from None
    values = {parameters[p]: None if v is None else expressions.sympy(expressions.parse(v)) for p, v in (system.get("parameters") or {}).items()}
    return System(out, list(functions.values()), values, time)


def _names_of(trees: List[Tree]) -> Set[str]:
    out: Set[str] = set()
    stack = list(trees)
    while stack:
        t = stack.pop()
        stack.extend(t.args)
        if t.op == "name":
            out.add(t.value)
    return out
