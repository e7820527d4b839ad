"""A circuit as a netlist says it, and its operating point at time 0."""
from __future__ import annotations

import heapq
import re
from dataclasses import dataclass, field
from fractions import Fraction
from typing import Any, Dict, List, NamedTuple, Optional, Set, Tuple


class Line(NamedTuple):
    number: int
    words: List[str]


@dataclass
class Element:
    line: int
    name: str
    nodes: Tuple[str, ...]
    value: Fraction = Fraction(0)
    control: str = ""                       # F and H: the source whose current it is
    initial: Optional[Fraction] = None      # ic=
    source: str = ""                        # V and I: an expression, or the name of a table
    at_start: Fraction = Fraction(0)        # the source's value at time 0

    @property
    def kind(self) -> str:
        return self.name[0]


@dataclass
class Circuit:
    title: str = ""
    elements: List[Element] = field(default_factory=list)
    parameters: Dict[str, Fraction] = field(default_factory=dict)
    held: Dict[str, Tuple[int, Fraction]] = field(default_factory=dict)     # .ic: node, its line and voltage
    tran: Optional[Tuple[Fraction, Fraction, bool]] = None                  # step, stop, uic
    tables: Dict[str, Dict[str, Any]] = field(default_factory=dict)


def names_of(circuit: Circuit) -> Tuple[Dict[str, str], Dict[str, str]]:
    """Names of nodes' voltages and of branches' currents: letters that the grammar has, each once."""
    taken: Set[str] = set()

    def name(text: str) -> str:
        made = re.sub(r"\W", "_", text, flags=re.ASCII)
        while made in taken:
            made += "_"
        taken.add(made)
        return made
    nodes = dict.fromkeys(n for e in circuit.elements for n in e.nodes if n)
    return {n: name("v_" + n) for n in nodes}, {e.name: name("i_" + e.name) for e in circuit.elements if e.kind in "VLEH"}


EXACT = 200              # unknowns up to which the operating point is found by fractions; they grow


def _solve(given: List[Dict[int, Fraction]], n: int) -> Optional[List[float]]:
    """Sparse elimination, short rows first; column n is the right side. Over the rationals, of large circuits in doubles with the largest entry of the row
    as pivot: the service projects what it gets. None: no solution, or many."""
    exact = n <= EXACT
    rows: List[Dict[int, Any]] = [{c: v if exact else float(v) for c, v in r.items() if v} for r in given]
    holders: Dict[int, Set[int]] = {}
    for i, r in enumerate(rows):
        for c in r:
            holders.setdefault(c, set()).add(i)
    heap = [(len(r), i) for i, r in enumerate(rows)]
    heapq.heapify(heap)
    done: Set[int] = set()
    steps: List[Tuple[int, int]] = []
    while heap:
        size, i = heapq.heappop(heap)
        if i in done or size != len(rows[i]):
            continue
        done.add(i)
        row = rows[i]
        unknowns = [c for c in row if c < n]
        if not unknowns:
            if row.get(n):
                return None
            continue
        column = min(unknowns, key=lambda c: (len(holders[c]), c)) if exact else max(unknowns, key=lambda c: float(abs(row[c])))
        steps.append((column, i))
        for k in holders[column] - done:
            other, factor = rows[k], rows[k][column] / row[column]
            for c, v in row.items():
                old = other.get(c, 0)
                new = old - factor * v
                if c == column or (not new if exact else abs(new) <= 1e-13 * max(abs(old), abs(factor * v))):
                    other.pop(c, None)
                    holders[c].discard(k)
                else:
                    other[c] = new
                    holders.setdefault(c, set()).add(k)
            heapq.heappush(heap, (len(other), k))
    if len(steps) < n:
        return None
    value: Dict[int, Any] = {}
    for column, i in reversed(steps):
        row = rows[i]
        value[column] = (row.get(n, 0) - sum(v * value[c] for c, v in row.items() if c != column and c < n)) / row[column]
    return [float(value[c]) for c in range(n)]


def operating_point(circuit: Circuit, uic: bool) -> Optional[Dict[str, float]]:
    """The operating point at time 0 (capacitors carry no current, inductors no voltage, nodes of .ic are held), or with uic the state in which
    capacitors have the voltage and inductors the current of their ic=, 0 unless given. None: there is none, or it is not one."""
    voltage, current = names_of(circuit)
    place = {v: k for k, v in enumerate([*voltage.values(), *current.values()])}
    extra = [e for e in circuit.elements if uic and e.kind == "C"]
    held = {} if uic else circuit.held
    n = len(place) + len(extra) + len(held)
    flows: Dict[str, Dict[int, Fraction]] = {v: {} for v in voltage}
    rows: List[Dict[int, Fraction]] = []

    def across(row: Dict[int, Fraction], a: str, b: str, factor: Fraction) -> None:
        for node, sign in ((a, 1), (b, -1)):
            if node:
                row[place[voltage[node]]] = row.get(place[voltage[node]], Fraction(0)) + sign * factor

    def flow(a: str, b: str, what: Dict[int, Fraction]) -> None:
        for node, sign in ((a, 1), (b, -1)):
            if node:
                for c, v in what.items():
                    flows[node][c] = flows[node].get(c, Fraction(0)) + sign * v
    for e in circuit.elements:
        a, b = e.nodes[:2]
        law: Dict[int, Fraction] = {}
        if e.kind in "VLEH":
            own = place[current[e.name]]
            flow(a, b, {own: Fraction(1)})
            if e.kind == "L" and uic:
                law = {own: Fraction(1), n: e.initial or Fraction(0)}
            else:
                across(law, a, b, Fraction(1))
                if e.kind == "V":
                    law[n] = e.at_start
                elif e.kind == "E":
                    across(law, e.nodes[2], e.nodes[3], -e.value)
                elif e.kind == "H":
                    c = place[current[e.control]]
                    law[c] = law.get(c, Fraction(0)) - e.value
            rows.append(law)
            continue
        if e.kind == "C":
            if uic:
                own = len(place) + extra.index(e)
                flow(a, b, {own: Fraction(1)})
                across(law, a, b, Fraction(1))
                rows.append({**law, n: e.initial or Fraction(0)})
            continue
        if e.kind == "R":
            across(law, a, b, 1 / e.value)
        elif e.kind == "G":
            across(law, e.nodes[2], e.nodes[3], e.value)
        elif e.kind == "F":
            law = {place[current[e.control]]: e.value}
        else:
            law = {n: -e.at_start}
        flow(a, b, law)
    for k, (node, (_, volts)) in enumerate(held.items()):
        flow(node, "", {len(place) + len(extra) + k: Fraction(1)})
        rows.append({place[voltage[node]]: Fraction(1), n: volts})
    found = _solve(rows + list(flows.values()), n)
    return {v: found[k] for v, k in place.items()} if found else None
