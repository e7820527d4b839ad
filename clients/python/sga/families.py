"""What long lists of an answer say once, with a loop, written out."""
from __future__ import annotations

import re
from typing import Any, Dict, Iterator, List, Mapping, Tuple

LOOP = {"for", "count", "place"}
INDEXED = re.compile(r"([A-Za-z_]\w*)\[([^\[\]]*)\]|(?<![\w.])[A-Za-z_]\w*")
RANGE = re.compile(r"([A-Za-z_]\w*)\[([^\[\]]*:[^\[\]]*)\]('*)")
SUM = re.compile(r"([+-]?)([^+-]+)")
CONSTRAINT = re.compile(r"constraints\[(\d+)\]")


def _whole(text: str, values: Mapping[str, int]) -> int:
    """2*i-1: sums of products of whole numbers and names."""
    total = 0
    for sign, product in SUM.findall(text):
        factors = 1
        for factor in product.split("*"):
            name = factor.strip()
            factors *= values[name] if name in values else int(name)
        total += -factors if sign == "-" else factors
    return total


def _put(value: Any, values: Mapping[str, int]) -> Any:
    def one(m: "re.Match[str]") -> str:
        if m[1]:
            return m[1] + "[" + ",".join(str(_whole(e, values)) for e in m[2].split(",")) + "]"
        return str(values.get(m[0], m[0]))
    if isinstance(value, str):
        return INDEXED.sub(one, value)
    if isinstance(value, list):
        return [_put(v, values) for v in value]
    if isinstance(value, dict):
        put = {_put(k, values): _put(v, values) for k, v in value.items()}
        place = CONSTRAINT.fullmatch(put["tangency_of"]) if isinstance(put.get("tangency_of"), str) else None
        return {**put, "tangency_of": int(place[1])} if place else put
    return value


def _passes(parts: List[Tuple[str, int, int]], values: Dict[str, int]) -> Iterator[Dict[str, int]]:
    if not parts:
        yield values
        return
    name, low, high = parts[0]
    for v in range(low, high + 1):
        yield from _passes(parts[1:], {**values, name: v})


def _loop(text: str) -> List[Tuple[str, int, int]]:
    parts = []
    for part in text.split(","):
        name, _, bounds = part.partition("=")
        low, _, high = bounds.partition(":")
        parts.append((name.strip(), int(low), int(high)))
    return parts


def _is_family(entry: Any) -> bool:
    return isinstance(entry, dict) and LOOP <= set(entry) and isinstance(entry["for"], str) and isinstance(entry["count"], int)


def _list(entries: List[Any]) -> List[Any]:
    """Families say where their entries stand; the others have the places that are left."""
    placed: Dict[int, Any] = {}
    for e in entries:
        if _is_family(e):
            body = {k: v for k, v in e.items() if k not in LOOP}
            for values in _passes(_loop(e["for"]), {}):
                placed[_whole(e["place"], values)] = _put(body["expression"] if set(body) == {"expression"} else body, values)
    others = (whole(e) for e in entries if not _is_family(e))
    total = len(placed) + sum(not _is_family(e) for e in entries)
    return [placed[k] if k in placed else next(others) for k in range(total)]


def _object(value: Mapping[str, Any]) -> Dict[str, Any]:
    out: Dict[str, Any] = {}
    for key, v in value.items():
        m = RANGE.fullmatch(key)
        if not m:
            out[key] = whole(v)
            continue
        ranges = [e.strip() for e in m[2].split(",")]
        for values in _passes([p for e in ranges if ":" in e for p in _loop(e)], {}):
            indices = ",".join(str(values[e.partition("=")[0].strip()]) if ":" in e else e for e in ranges)
            out[f"{m[1]}[{indices}]{m[3]}"] = _put(v, values)
    return out


def whole(value: Any) -> Any:
    """An answer, or a part of one, with every family written out."""
    if isinstance(value, list):
        return _list(value) if any(_is_family(e) for e in value) else [whole(v) for v in value] if any(isinstance(v, (dict, list)) for v in value) else value
    return _object(value) if isinstance(value, dict) else value
