"""What a text cannot be taken for."""
from __future__ import annotations

from typing import Optional


class ConvertError(ValueError):
    """The text is wrong, or says what a request cannot say. `line` and `column` count from 1; None: it is about the whole."""

    def __init__(self, detail: str, line: Optional[int] = None, column: Optional[int] = None) -> None:
        self.detail, self.line, self.column = detail, line, column
        where = "" if line is None else f"line {line}: " if column is None else f"line {line}, column {column}: "
        super().__init__(where + detail)


class ConvertWarning(UserWarning):
    """Something was left out that is no part of the system, as what is to be printed."""
