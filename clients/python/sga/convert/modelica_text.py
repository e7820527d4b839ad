"""Requests as Modelica's text."""
from __future__ import annotations

import re
from typing import Any, Dict, List, Mapping, Optional, Set, Tuple

from .. import expressions
from ..expressions import Tree
from .errors import ConvertError

_KEYWORDS = set("algorithm and annotation assert block break class connect connector constant constrainedby der discrete each else elseif elsewhen encapsulated end enumeration equation "
                "expandable extends external false final flow for function if import impure in initial inner input loop model not operator or outer output package parameter partial "
                "protected public pure record redeclare replaceable return stream then true type when while within time Real Integer Boolean String abs sign sqrt sin cos tan asin acos "
                "atan atan2 sinh cosh tanh exp log log10 min max mod rem div floor ceil integer pre edge change sum product size smooth noEvent homotopy delay sample reinit".split())
_CALLS = {"cbrt": "(sign({0})*abs({0})^(1/3))", "asinh": "(sign({0})*log(abs({0}) + sqrt({0}^2 + 1)))",
          "acosh": "log({0} + sqrt({0}^2 - 1))", "atanh": "0.5*log((1 + {0})/(1 - {0}))", "log2": "(log({0})/log(2))", "hypot": "sqrt({0}^2 + {1}^2)",
          "step": "(if {0} < 0 then 0 else 1)"}


def _text(t: Tree, names: Mapping[str, str]) -> str:
    if t.op == "number":
        return t.value if re.match(r"\d", t.value) else "0" + t.value
    if t.op == "name":
        if t.value == "pi" and "pi" not in names:
            return "3.14159265358979323846264338327950288"
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
