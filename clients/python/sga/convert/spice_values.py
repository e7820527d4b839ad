"""Numbers of SPICE: 4.7k, 10uF, {2*r}; and exact decimals of the grammar."""
from __future__ import annotations

import re
from fractions import Fraction
from typing import Dict, List, Optional

from .errors import ConvertError

_SCALE: Dict[str, Fraction] = {"t": Fraction(10**12), "g": Fraction(10**9), "meg": Fraction(10**6), "k": Fraction(1000), "mil": Fraction(254, 10**7), "m": Fraction(1, 1000),
                               "u": Fraction(1, 10**6), "n": Fraction(1, 10**9), "p": Fraction(1, 10**12), "f": Fraction(1, 10**15)}
_NUMBER = re.compile(r"([+-]?(?:\d+\.?\d*|\.\d+)(?:e[+-]?\d+)?)([a-z]*)")


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


class Formula:
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
