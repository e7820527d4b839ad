"""What can go wrong, by who can mend it."""
from __future__ import annotations

from typing import Any, Mapping, Optional


class SgaError(Exception):
    """What the service said: `code` does not change between versions, `detail` is for people, `pointer`, `line` and `column` say where in
    the request. `problem` is the whole object (RFC 9457)."""

    def __init__(self, problem: Mapping[str, Any], status: Optional[int] = None) -> None:
        self.problem = dict(problem)
        self.code: str = self.problem.get("code", "")
        self.title: str = self.problem.get("title", "")
        self.detail: str = self.problem.get("detail", "") or self.title
        self.pointer: str = self.problem.get("pointer", "")
        self.line: Optional[int] = self.problem.get("line")
        self.column: Optional[int] = self.problem.get("column")
        self.stage: str = self.problem.get("stage", "")
        self.status: Optional[int] = status if status is not None else self.problem.get("status")
        super().__init__(self._text())

    def _text(self) -> str:
        where = f" at {self.pointer}" if self.pointer else ""
        if self.column:
            where += f", line {self.line}, column {self.column}"
        return f"{self.detail} ({self.code}{where})"

    def explain(self, request: Any) -> str:
        """The text with the expression it is about, and a caret under the column."""
        node = request
        try:
            for key in self.pointer.split("/")[1:]:
                key = key.replace("~1", "/").replace("~0", "~")
                node = node[int(key)] if isinstance(node, list) else node[key]
        except (KeyError, IndexError, ValueError, TypeError):
            return str(self)
        if not isinstance(node, str) or not self.column:
            return str(self)
        line = node.split("\n")[(self.line or 1) - 1]
        return f"{self}\n  {line}\n  {' ' * (self.column - 1)}^"


class RequestError(SgaError):
    """The request is refused: it has to be changed."""


class JobError(SgaError):
    """The job failed: a limit was met, a start is inconsistent, a question could not be decided. `job` is the whole job."""

    def __init__(self, job: Mapping[str, Any]) -> None:
        self.job = dict(job)
        super().__init__(job.get("error") or {"code": str(job.get("status")), "detail": f"the job was {job.get('status')}"})


class Cancelled(JobError):
    """The job was cancelled before its end."""


class AccessError(SgaError):
    """A token is missing, not valid, or does not allow this."""


class ServiceError(SgaError):
    """The service cannot answer now: it is full, busy, stopping, or cannot be reached. Later it may."""


def of_response(problem: Mapping[str, Any], status: int) -> SgaError:
    kind = AccessError if status in (401, 403) else ServiceError if status >= 500 or status == 429 else RequestError
    return kind(problem, status)
