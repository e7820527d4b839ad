"""SPICE netlists of R, L, C, V, I, E, F, G, H as requests: modified nodal analysis, nothing eliminated.

Unknowns are v_NODE for each node but ground (0, gnd) and i_NAME, the current from the first node through the element to the second, for V, L, E and
H. Values of R, C, L are parameters with their exact decimals. Sources are DC, SIN, PULSE and PWL; the last two become tables. A .tran makes a
trajectory, which starts as SPICE does: in the operating point (with .ic: as far as it allows), or, with uic, from the ic= of C and L. Reference:
Quarles, Newton, Pederson, Sangiovanni-Vincentelli, SPICE3 Version 3f3 User's Manual (1993)."""
from __future__ import annotations

import math
import re
import warnings
from dataclasses import dataclass, field
from fractions import Fraction
from typing import Any, Dict, List, NamedTuple, Optional, Set, Tuple

from .errors import ConvertError, ConvertWarning

_SCALE: Dict[str, Fraction] = {"t": Fraction(10**12), "g": Fraction(10**9), "meg": Fraction(10**6), "k": Fraction(1000), "mil": Fraction(254, 10**7), "m": Fraction(1, 1000),
                               "u": Fraction(1, 10**6), "n": Fraction(1, 10**9), "p": Fraction(1, 10**12), "f": Fraction(1, 10**15)}
_NUMBER = re.compile(r"([+-]?(?:\d+\.?\d*|\.\d+)(?:e[+-]?\d+)?)([a-z]*)")
_OTHERS = {"b": "a behavioural source", "d": "a diode", "j": "a JFET", "k": "coupled inductors", "m": "a MOSFET", "o": "a transmission line", "q": "a transistor", "s": "a switch",
           "t": "a transmission line", "u": "a distributed line", "w": "a switch", "x": "a subcircuit", "z": "a MESFET", "a": "a code model", "p": "a coupled line", "y": "a transmission line", "n": "a device"}
_PRINTED = {".print", ".plot", ".probe", ".save", ".width", ".option", ".options", ".op", ".four", ".meas", ".measure", ".title", ".temp"}
_ASKED = {".ac": "a sweep of frequencies (ask for `transfer`)", ".dc": "a sweep", ".noise": "noise", ".tf": "a transfer function (ask for `transfer`)", ".sens": "sensitivities", ".pz": "poles (ask for `transfer`)", ".disto": "distortion"}
MOST_KNOTS = 100000          # of one source: a pulse that is shorter is a mistake in units


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


def number(text: str) -> Optional[Fraction]:
    """The value of a SPICE number (4.7k, 10uF, 1e-3, 2meg), exactly; None where it is none."""
    m = _NUMBER.fullmatch(text.lower())
    if not m:
        return None
    scale = next((_SCALE[s] for s in ("meg", "mil", *"tgkmunpf") if m[2].startswith(s)), Fraction(1))
    return Fraction(m[1]) * scale


def decimal(value: Fraction) -> str:
    """As the grammar writes it: a decimal where there is one, else a quotient."""
    rest, twos, fives = value.denominator, 0, 0
    while rest % 2 == 0:
        rest, twos = rest // 2, twos + 1
    while rest % 5 == 0:
        rest, fives = rest // 5, fives + 1
    if rest != 1:
        return f"{value.numerator}/{value.denominator}"
    places = max(twos, fives)
    power: int = 10**places
    digits: str = str(abs(value.numerator) * power // value.denominator).rjust(places + 1, "0")
    whole, part = digits[:len(digits) - places], digits[len(digits) - places:].rstrip("0")
    text: str = whole + ("." + part if part else "")
    if len(text) > 12:                      # a power of ten reads better
        shown = digits.lstrip("0").rstrip("0")
        exponent = len(digits) - len(digits.rstrip("0")) - places
        if len(shown) < 12:
            text = f"{shown}e{exponent}"
    return "-" + text if value < 0 else text


class _Formula:
    """Values in braces and .param: + - * / ( ) over numbers and parameters, exactly."""

    def __init__(self, text: str, names: Dict[str, Fraction], line: int) -> None:
        self.tokens: List[str] = re.findall(r"(?:\d+\.?\d*|\.\d+)(?:e[+-]?\d+)?[a-z]*|[a-z_]\w*|\S", text.lower())
        self.names, self.line, self.at, self.depth = names, line, 0, 0

    def fail(self) -> ConvertError:
        return ConvertError(f"{' '.join(self.tokens) or 'nothing'!r} is no value: numbers, parameters, + - * / ( )", self.line)

    def peek(self) -> str:
        return self.tokens[self.at] if self.at < len(self.tokens) else ""

    def take(self) -> str:
        self.at += 1
        return self.tokens[self.at - 1] if self.at <= len(self.tokens) else ""

    def whole(self) -> Fraction:
        value = self.sum()
        if self.at < len(self.tokens):
            raise self.fail()
        return value

    def sum(self) -> Fraction:
        self.depth += 1
        if self.depth > 100:
            raise self.fail()
        value = self.product()
        while self.peek() in ("+", "-"):
            value = value + self.product() if self.take() == "+" else value - self.product()
        self.depth -= 1
        return value

    def product(self) -> Fraction:
        value = self.signed()
        while self.peek() in ("*", "/"):
            op, other = self.take(), self.signed()
            if op == "/" and other == 0:
                raise ConvertError("a division by 0", self.line)
            value = value * other if op == "*" else value / other
        return value

    def signed(self) -> Fraction:
        sign = 1
        while self.peek() in ("+", "-"):
            sign = -sign if self.take() == "-" else sign
        return sign * self.atom()

    def atom(self) -> Fraction:
        word = self.take()
        if word == "(":
            value = self.sum()
            if self.take() != ")":
                raise self.fail()
            return value
        if word in self.names:
            return self.names[word]
        value_ = number(word)
        if value_ is None:
            raise ConvertError(f"{word!r} is no number and no parameter", self.line) if re.match(r"[a-z_]", word) else self.fail()
        return value_


def _lines(text: str) -> Tuple[str, List[Line]]:
    """The title, and the statements with the lines where they begin: + goes on, * and ; and $ are comments."""
    title, out, raw = "", [], text.splitlines()
    if raw:
        title = raw[0].strip().lstrip("*").strip()
    joined: List[Tuple[int, str]] = []
    for i, line in enumerate(raw[1:], 2):
        line = re.split(r";|\$\s", line)[0].rstrip()
        if not line.strip() or line.lstrip().startswith("*"):
            continue
        if line.lstrip().startswith("+"):
            if not joined:
                raise ConvertError("this line goes on with nothing", i)
            joined[-1] = (joined[-1][0], joined[-1][1] + " " + line.lstrip()[1:])
        else:
            joined.append((i, line.strip()))
    for i, line in joined:
        pieces = re.findall(r"\{[^}]*\}|[^\s(),={}]+|[(),={}]", line.lower())
        if any(p in "{}" for p in pieces):
            raise ConvertError("a brace is not closed, or opened twice", i)
        out.append(Line(i, [p for p in pieces if p != ","]))
    return title, out


class _Reader:
    def __init__(self, text: str) -> None:
        self.circuit = Circuit()
        self.names: Dict[str, int] = {}
        self.given: List[Tuple[str, str, int]] = []     # parameters that are not known yet: name, value, line
        self.circuit.title, lines = _lines(text)
        self.body: List[Line] = []
        for line in lines:                  # parameters first: they may stand behind their use
            if line.words[0] == ".end":
                break
            self.body.append(line)
        for line in self.body:
            if line.words[0] == ".param":
                self.param(line)
        self.settle()
        for line in self.body:
            if line.words[0] == ".tran":
                self.tran(line)
        for line in self.body:
            self.statement(line)
        self.controls()

    # -- values --

    def value(self, word: str, line: int) -> Fraction:
        inside = word[1:-1] if word.startswith("{") else word
        if not word.startswith("{"):
            plain = number(word)
            if plain is not None:
                return plain
            if word.strip("'") not in self.circuit.parameters:
                raise ConvertError(f"{word!r} is no number and no parameter", line)
            inside = word.strip("'")
        return _Formula(inside, self.circuit.parameters, line).whole()

    def param(self, line: Line) -> None:
        words, at = line.words[1:], 0
        if not words:
            raise ConvertError(".param needs NAME=VALUE", line.number)
        while at < len(words):
            if at + 2 >= len(words) or words[at + 1] != "=" or not re.fullmatch(r"[a-z_]\w*", words[at]):
                raise ConvertError(".param needs NAME=VALUE; a formula stands in braces", line.number)
            self.given.append((words[at], words[at + 2], line.number))
            at += 3

    def settle(self) -> None:
        """Parameters may stand before those that they use."""
        while self.given:
            left: List[Tuple[str, str, int]] = []
            why: Optional[ConvertError] = None
            for name, word, line in self.given:
                try:
                    self.circuit.parameters[name] = self.value(word, line)
                except ConvertError as e:
                    left.append((name, word, line))
                    why = why or e
            if why and len(left) == len(self.given):
                raise why
            self.given = left

    def tran(self, line: Line) -> None:
        uic = "uic" in line.words
        numbers = [self.value(w, line.number) for w in line.words[1:] if w != "uic"]
        if len(numbers) < 2 or numbers[0] <= 0 or numbers[1] <= 0:
            raise ConvertError(".tran needs a step and a stop time above 0", line.number)
        if self.circuit.tran:
            raise ConvertError("a second .tran", line.number)
        if len(numbers) > 2 and numbers[2] != 0:
            warnings.warn(f"line {line.number}: samples before the start of printing are kept", ConvertWarning, stacklevel=4)
        self.circuit.tran = numbers[0], numbers[1], uic

    def ic(self, line: Line) -> None:
        words, at = line.words[1:], 0
        while at < len(words):
            if len(words) < at + 6 or words[at:at + 2] != ["v", "("] or words[at + 3:at + 5] != [")", "="]:
                raise ConvertError(".ic needs v(NODE)=VALUE", line.number)
            node = self.node(words[at + 2])
            if not node:
                raise ConvertError(".ic of the ground", line.number)
            self.circuit.held[node] = line.number, self.value(words[at + 5], line.number)
            at += 6

    # -- statements --

    def statement(self, line: Line) -> None:
        word = line.words[0]
        if word in (".param", ".tran"):
            return
        if word == ".ic":
            self.ic(line)
        elif word in _PRINTED:
            warnings.warn(f"line {line.number}: {word} is left out", ConvertWarning, stacklevel=4)
        elif word in _ASKED:
            warnings.warn(f"line {line.number}: {word} asks for {_ASKED[word]}; it is left out", ConvertWarning, stacklevel=4)
        elif word.startswith("."):
            raise ConvertError(f"{word} is not known here", line.number)
        elif word[0] in "rlcviefgh":
            self.element(line)
        elif word[0] in _OTHERS:
            raise ConvertError(f"{word}: {_OTHERS[word[0]]}, and only R, L, C, V, I, E, F, G and H are known here", line.number)
        else:
            raise ConvertError(f"{word!r} is no element", line.number)

    @staticmethod
    def node(word: str) -> str:
        return "" if word in ("0", "gnd") else word

    def element(self, line: Line) -> None:
        name = line.words[0].upper()
        nodes = 4 if name[0] in "EG" else 2
        words = line.words[1:]
        if name in self.names:
            raise ConvertError(f"{name} is there already, in line {self.names[name]}", line.number)
        if name[0] in "EFGH" and any(w in ("poly", "value", "table", "laplace", "vol", "cur") for w in words):
            raise ConvertError(f"{name}: only linear control is known here", line.number)
        if len(words) < nodes + (name[0] not in "VI") or any(w in "()=" for w in words[:nodes]):
            what = {"V": "two nodes", "I": "two nodes", "E": "four nodes and a gain", "G": "four nodes and a transconductance", "F": "two nodes, a voltage source and a gain",
                    "H": "two nodes, a voltage source and a resistance"}.get(name[0], "two nodes and a value")
            raise ConvertError(f"{name} needs {what}", line.number)
        e = Element(line.number, name, tuple(self.node(w) for w in words[:nodes]))
        self.names[name] = line.number
        rest = words[nodes:]
        if name[0] in "VI":
            self.source(e, rest)
        elif name[0] in "FH":
            if len(rest) != 2:
                raise ConvertError(f"{name} needs a voltage source and one number", line.number)
            e.control, e.value = rest[0].upper(), self.value(rest[1], line.number)
        else:
            e.value = self.value(rest[0], line.number)
            self.options(e, rest[1:])
        if name[0] in "RLC" and e.value == 0:
            raise ConvertError(f"{name} has the value 0: " + ("leave it out" if name[0] == "C" else "write a source, V 0, for a wire"), line.number)
        self.circuit.elements.append(e)

    def options(self, e: Element, words: List[str]) -> None:
        if e.kind in "LC" and len(words) == 3 and words[:2] == ["ic", "="]:
            e.initial = self.value(words[2], e.line)
        elif words:
            raise ConvertError(f"{e.name}: {' '.join(words)} is not known here", e.line)

    def controls(self) -> None:
        known = {e.name: e for e in self.circuit.elements}
        for e in self.circuit.elements:
            if e.control and (e.control not in known or e.control[0] != "V"):
                raise ConvertError(f"{e.name}: there is no voltage source {e.control}", e.line)

    # -- sources --

    def source(self, e: Element, words: List[str]) -> None:
        constant: Optional[Fraction] = None
        shape: Optional[Tuple[str, List[Fraction]]] = None
        at = 0
        while at < len(words):
            w = words[at]
            if w in ("dc", "ac") and at + 1 < len(words) and words[at + 1] not in ("sin", "pulse", "pwl", "ac", "dc"):
                v = self.value(words[at + 1], e.line)
                if w == "dc":
                    constant = v
                else:
                    if at + 2 < len(words) and number(words[at + 2]) is not None:       # the phase
                        at += 1
                    warnings.warn(f"line {e.line}: the AC value of {e.name} is left out", ConvertWarning, stacklevel=5)
                at += 2
            elif w in ("sin", "pulse", "pwl"):
                if shape:
                    raise ConvertError(f"{e.name} has two shapes", e.line)
                if at + 1 < len(words) and words[at + 1] == "(":
                    end = words.index(")", at) if ")" in words[at:] else -1
                    if end < 0:
                        raise ConvertError(f"{e.name}: the parenthesis of {w} is not closed", e.line)
                    inside, at_next = words[at + 2:end], end + 1
                else:
                    inside, at_next = words[at + 1:], len(words)
                shape = w, [self.value(x, e.line) for x in inside]
                at = at_next
            elif w in ("exp", "sffm", "am", "trnoise", "trrandom", "external"):
                raise ConvertError(f"{e.name}: the shape {w} is not known here, only SIN, PULSE and PWL", e.line)
            elif at == 0:
                constant = self.value(w, e.line)
                at += 1
            else:
                raise ConvertError(f"{e.name}: {w} is not understood", e.line)
        if shape is None:
            e.at_start = constant or Fraction(0)
            e.source = decimal(e.at_start)
        else:
            {"sin": self.sine, "pulse": self.pulse, "pwl": self.pieces}[shape[0]](e, shape[1])

    def sine(self, e: Element, v: List[Fraction]) -> None:
        stop = self.circuit.tran[1] if self.circuit.tran else None
        if not 2 <= len(v) <= 6 or (len(v) == 2 and not stop):
            raise ConvertError(f"{e.name}: SIN needs offset, amplitude and frequency, and may have delay, damping and phase", e.line)
        offset, amplitude = v[:2]
        frequency = v[2] if len(v) > 2 and v[2] != 0 else 1 / stop if stop else None
        if frequency is None or frequency < 0:
            raise ConvertError(f"{e.name}: SIN needs a frequency above 0", e.line)
        delay, damping, phase = (v[3:] + [Fraction(0)] * 3)[:3]
        if delay < 0 or (delay and phase):
            raise ConvertError(f"{e.name}: SIN with a delay and a phase jumps at the end of the delay, or the delay is negative", e.line)
        time = f"max(t - {decimal(delay)}, 0)" if delay else "t"
        angle = f"2*pi*{_times(frequency)}*{time}" + (f" + pi*{_times(phase / 180)}" if phase else "")
        decay = f"*exp(-{_times(damping)}*{time})" if damping else ""
        e.source = f"{decimal(offset)} + {_times(amplitude)}*sin({angle}){decay}"
        e.at_start = offset + amplitude * (Fraction(math.sin(math.pi * float(phase) / 180)) if phase else 0)

    def pulse(self, e: Element, v: List[Fraction]) -> None:
        if not self.circuit.tran:
            raise ConvertError(f"{e.name}: PULSE needs a .tran, which says how long", e.line)
        step, stop, _ = self.circuit.tran
        if not 2 <= len(v) <= 7:
            raise ConvertError(f"{e.name}: PULSE needs two values, and may have delay, rise, fall, width and period", e.line)
        given: List[Optional[Fraction]] = [*v[2:], *[None] * (7 - len(v))]
        delay = given[0] or Fraction(0)
        rise, fall = (g or step for g in given[1:3])
        width, period = (g or stop for g in given[3:5])
        if min(delay, rise, fall, width, period) < 0 or rise + width + fall > period and period < stop:
            raise ConvertError(f"{e.name}: a time of PULSE is negative, or the period is shorter than rise, width and fall", e.line)
        points, start = [(Fraction(0), v[0])], delay
        while start < stop:
            for time, value in ((start, v[0]), (start + rise, v[1]), (start + rise + width, v[1]), (start + rise + width + fall, v[0])):
                if time > points[-1][0]:
                    points.append((time, value))
            if len(points) > MOST_KNOTS:
                raise ConvertError(f"{e.name}: more than {MOST_KNOTS} bends of PULSE before the stop time", e.line)
            start += period
        self.table(e, points)

    def pieces(self, e: Element, v: List[Fraction]) -> None:
        if len(v) < 2 or len(v) % 2:
            raise ConvertError(f"{e.name}: PWL needs pairs of time and value", e.line)
        points = list(zip(v[::2], v[1::2]))
        if points[0][0] < 0 or any(a[0] >= b[0] for a, b in zip(points, points[1:])):
            raise ConvertError(f"{e.name}: the times of PWL must increase, from 0 on", e.line)
        if points[0][0] > 0:
            points.insert(0, (Fraction(0), points[0][1]))
        self.table(e, points)

    def table(self, e: Element, points: List[Tuple[Fraction, Fraction]]) -> None:
        if not self.circuit.tran:
            raise ConvertError(f"{e.name}: PULSE and PWL need a .tran, which says how long", e.line)
        stop = self.circuit.tran[1]
        kept = [p for p in points if p[0] < stop]
        after = next((p for p in points if p[0] >= stop), None)
        last = kept[-1]
        kept.append((stop, last[1] + (after[1] - last[1]) * (stop - last[0]) / (after[0] - last[0]) if after else last[1]))
        name = re.sub(r"\W", "_", e.name, flags=re.ASCII) + "_source"
        self.circuit.tables[name] = {"times": [float(t) for t, _ in kept], "values": [float(v) for _, v in kept], "interpolation": "linear"}
        e.source, e.at_start = name, kept[0][1]


def _times(value: Fraction) -> str:
    """A factor."""
    text = decimal(value)
    return f"({text})" if text[0] == "-" or "/" in text else text


# -- equations --

def _names(circuit: Circuit) -> Tuple[Dict[str, str], Dict[str, str]]:
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


def _difference(voltage: Dict[str, str], a: str, b: str, dash: str = "") -> str:
    return " - ".join(filter(None, [voltage[a] + dash if a else "", voltage[b] + dash if b else ""])) if a else "-" + voltage[b] + dash if b else "0"


def _equations(circuit: Circuit, parameter: Dict[str, str]) -> Tuple[List[str], List[str]]:
    """Variables and equations: the currents that leave each node sum up to 0; a law for each branch with a current of its own."""
    voltage, current = _names(circuit)
    leaving: Dict[str, List[str]] = {n: [] for n in voltage}
    laws: List[str] = []
    for e in circuit.elements:
        a, b = e.nodes[:2]
        u, dash = _difference(voltage, a, b), _difference(voltage, a, b, "'")
        if e.kind == "R":
            flow = f"({u})/{parameter[e.name]}"
        elif e.kind == "C":
            flow = f"{parameter[e.name]}*({dash})"
        elif e.kind == "I":
            flow = f"({e.source})"
        elif e.kind == "G":
            flow = f"{parameter[e.name]}*({_difference(voltage, *e.nodes[2:])})"
        elif e.kind == "F":
            flow = f"{parameter[e.name]}*{current[e.control]}"
        else:
            flow = current[e.name]
            right = (e.source if e.kind == "V" else f"{parameter[e.name]}*{flow}'" if e.kind == "L" else
                     f"{parameter[e.name]}*({_difference(voltage, *e.nodes[2:])})" if e.kind == "E" else f"{parameter[e.name]}*{current[e.control]}")
            laws.append(f"{u} = {right}")
        if a == b:
            continue
        if a:
            leaving[a].append("+ " + flow)
        if b:
            leaving[b].append("- " + flow)
    sums = [" ".join(parts).removeprefix("+ ").replace("- ", "-", 1) if parts[0][0] == "-" else " ".join(parts).removeprefix("+ ") for parts in leaving.values() if parts]
    return [*voltage.values(), *current.values()], [f"{s} = 0" for s in sums] + laws


# -- the start --

def _solve(rows: List[Dict[int, Fraction]], n: int) -> Optional[List[Fraction]]:
    """Sparse elimination over the rationals; column n is the right side. None: no solution, or many."""
    pivots: Dict[int, Dict[int, Fraction]] = {}
    left = [dict(r) for r in rows]
    while left:
        left.sort(key=len, reverse=True)
        row = left.pop()
        column = next((c for c in sorted(row) if c < n and row[c]), None)
        if column is None:
            if row.get(n):
                return None
            continue
        scale = row[column]
        row = {c: v / scale for c, v in row.items() if v}
        for other in [*left, *pivots.values()]:
            factor = other.pop(column, None)
            if factor:
                for c, v in row.items():
                    if c != column:
                        other[c] = other.get(c, Fraction(0)) - factor * v
                        if not other[c]:
                            del other[c]
        pivots[column] = row
    return [pivots[c].get(n, Fraction(0)) for c in range(n)] if len(pivots) == n else None


def _start(circuit: Circuit, uic: bool) -> Optional[Dict[str, float]]:
    """The operating point at time 0 (capacitors carry no current, inductors no voltage, nodes of .ic are held), or with uic the state in which
    capacitors have the voltage and inductors the current of their ic=, 0 unless given. None: there is none, or it is not one."""
    voltage, current = _names(circuit)
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
    return {v: float(found[k]) for v, k in place.items()} if found else None


def request(text: str) -> Dict[str, Any]:
    """The request of a netlist. ConvertError says the line; directives that only print, and analyses that a request does not ask for so, are
    warned of."""
    circuit = _Reader(text).circuit
    if not circuit.elements:
        raise ConvertError("there are no elements: the first line is the title")
    if not any(not n for e in circuit.elements for n in e.nodes):
        raise ConvertError("no element is connected to the ground, node 0")
    for node, (line, _) in circuit.held.items():
        if not any(node in e.nodes for e in circuit.elements):
            raise ConvertError(f"there is no node {node}", line)
    parameter = {e.name: e.name for e in circuit.elements if e.kind not in "VI"}
    parameter = {k: re.sub(r"\W", "_", v, flags=re.ASCII) for k, v in parameter.items()}
    if len(set(parameter.values())) < len(parameter):
        raise ConvertError("names of elements differ in letters alone that the grammar does not have")
    variables, equations = _equations(circuit, parameter)
    system: Dict[str, Any] = {"form": "equations", "variables": variables,
                              "parameters": {parameter[e.name]: decimal(e.value) for e in circuit.elements if e.name in parameter}, "equations": equations}
    if circuit.title:
        system["name"] = circuit.title
    if not system["parameters"]:
        del system["parameters"]
    if circuit.tables:
        system["tables"] = circuit.tables
    out: Dict[str, Any] = {"system": system}
    if circuit.tran:
        step, stop, uic = circuit.tran
        start = _start(circuit, uic)
        if start is None:
            warnings.warn("there is no one operating point" if not uic else "the values of ic= contradict each other, or leave something open", ConvertWarning, stacklevel=2)
            names = _names(circuit)[0]
            start = {names[n]: float(v) for n, (_, v) in circuit.held.items()}
        samples = min(max(2, math.floor(stop / step) + 1), 1000000)
        out["trajectory"] = {"stop": decimal(stop), "samples": samples, "initial": start}
    return out
