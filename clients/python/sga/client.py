"""The client: requests in, answers out; jobs that can be followed and cancelled."""
from __future__ import annotations

import json
import os
import time
from typing import Any, Dict, Iterable, Iterator, List, Mapping, Optional, Sequence, Union

from .errors import Cancelled, JobError, ServiceError
from .result import Request, Result, Trajectory
from .transport import Transport

POLL = 20                 # seconds that one request waits for a job; the next one goes on waiting
ENDED = ("done", "failed", "cancelled")


def _object(request: Request) -> Dict[str, Any]:
    if isinstance(request, (str, bytes)):
        return dict(json.loads(request))
    return dict(request)


class Job:
    """A request at the service. `data` is what was last heard of it."""

    def __init__(self, client: "Client", data: Mapping[str, Any], request: Optional[Mapping[str, Any]] = None) -> None:
        self.client, self.data, self._request = client, dict(data), request

    @property
    def id(self) -> str:
        return str(self.data["id"])

    @property
    def status(self) -> str:
        """As last heard: queued, running, done, failed or cancelled."""
        return str(self.data["status"])

    @property
    def request(self) -> Dict[str, Any]:
        """What was asked, from the service unless it was posted here."""
        if self._request is None:
            self._request = self.client._json("GET", f"/v1/jobs/{self.id}/request")
        return dict(self._request)

    def refresh(self, wait: float = 0) -> "Job":
        """Asks anew; waits so many seconds for its end."""
        self.data = self.client._json("GET", f"/v1/jobs/{self.id}", headers={"Prefer": f"wait={int(wait)}"} if wait else None, timeout=wait + self.client.transport.timeout)
        return self

    def wait(self, timeout: Optional[float] = None) -> Result:
        """The answer, once it is there. JobError where the job failed, TimeoutError after so many seconds: then it runs on."""
        until = None if timeout is None else time.monotonic() + timeout
        while self.status not in ENDED or (self.status == "done" and "result" not in self.data):
            left = POLL if until is None else until - time.monotonic()
            if left <= 0:
                raise TimeoutError(f"job {self.id} is {self.status} after {timeout:g} seconds")
            self.refresh(wait=max(1, min(POLL, left)))
        return self.result

    @property
    def result(self) -> Result:
        if self.status == "cancelled":
            raise Cancelled(self.data)
        if self.status != "done":
            raise JobError(self.data)
        return Result(self.data["result"], self.request, self.data)

    def events(self) -> Iterator[Dict[str, Any]]:
        """Its progress as it comes, {"stage": ..., "fraction": ...}, until its end. A stream that breaks off is taken up again."""
        while self.status not in ENDED:
            kind, data = "", ""
            try:
                for line in self.client.transport.lines(f"/v1/jobs/{self.id}/events", timeout=self.client.transport.timeout):
                    if line.startswith("event:"):
                        kind = line[6:].strip()
                    elif line.startswith("data:"):
                        data += line[5:].strip()
                    elif not line and data:
                        self.data, data = json.loads(data), ""
                        if kind == "end":
                            return
                        yield dict(self.data["progress"])
            except ServiceError as e:
                if e.code != "unreachable":
                    raise
            self.refresh(wait=1)

    def cancel(self) -> None:
        """Withdraws: a job that nobody else wants is stopped; one that has ended leaves the list."""
        self.client.transport.ask("DELETE", f"/v1/jobs/{self.id}")
        try:
            self.refresh()
        except Exception as e:  # removed: there is nothing left to ask
            if getattr(e, "code", "") != "not_found":
                raise

    def csv(self) -> str:
        """The samples as CSV, as the service writes them."""
        return self.client.transport.ask("GET", f"/v1/jobs/{self.id}/trajectory?format=csv")[2].decode()

    def __repr__(self) -> str:
        return f"<Job {self.id[:12]} {self.status}>"


class Client:
    """A service at http://HOST:PORT, https://HOST:PORT or unix:PATH; SGA_SERVER, SGA_TOKEN and SGA_CA say what is not given. Threads may
    share a client."""

    def __init__(self, server: Optional[str] = None, token: Optional[str] = None, ca: Optional[str] = None, timeout: float = 60) -> None:
        url = server or os.environ.get("SGA_SERVER") or "http://127.0.0.1:8080"
        self.transport = Transport(url, token or os.environ.get("SGA_TOKEN"), ca or os.environ.get("SGA_CA"), timeout)

    def _json(self, method: str, path: str, body: Any = None, headers: Optional[Dict[str, str]] = None, timeout: Optional[float] = None) -> Any:
        return json.loads(self.transport.ask(method, path, body, headers, timeout)[2])

    def submit(self, request: Request) -> Job:
        """A job for the request; one that was asked before is done at once. RequestError says what is wrong with a request, and where."""
        posted = _object(request)
        return Job(self, self._json("POST", "/v1/jobs", posted), posted)

    def solve(self, request: Request, timeout: Optional[float] = None) -> Result:
        """The answer. A job that is waited for no longer (timeout, Ctrl-C) is cancelled."""
        job = self.submit(request)
        try:
            return job.wait(timeout)
        except (KeyboardInterrupt, TimeoutError):
            job.cancel()
            raise

    def solve_all(self, requests: Iterable[Request], timeout: Optional[float] = None) -> List[Union[Result, JobError]]:
        """Answers in the order of the requests, which run side by side as far as the service lets them; a job that failed is its JobError."""
        out: List[Union[Result, JobError]] = []
        for job in [self.submit(r) for r in requests]:
            try:
                out.append(job.wait(timeout))
            except JobError as e:
                out.append(e)
        return out

    def sweep(self, request: Request, sets: Sequence[Mapping[str, Any]], timeout: Optional[float] = None) -> List[Trajectory]:
        """One analysis, a motion for each set ({"initial": {...}} or {"parameters": {...}}), in their order; `error` where there is none."""
        return self.solve({**_object(request), "sweep": [dict(s) for s in sets]}, timeout).trajectories

    def check(self, request: Request) -> Dict[str, Any]:
        """All that there is to say of a request without running it: valid, problems (every one), warnings, form, variables, equations, unknowns."""
        body = request.encode() if isinstance(request, str) else request if isinstance(request, bytes) else dict(request)
        return dict(self._json("POST", "/v1/check", body))

    def job(self, id: str) -> Job:
        return Job(self, self._json("GET", f"/v1/jobs/{id}"))

    def jobs(self, *status: str, limit: int = 50) -> Iterator[Job]:
        """Jobs, newest first, page by page."""
        path = f"/v1/jobs?limit={limit}" + (f"&status={','.join(status)}" if status else "")
        cursor = None
        while True:
            page = self._json("GET", path + (f"&cursor={cursor}" if cursor else ""))
            yield from (Job(self, j) for j in page["jobs"])
            cursor = page["next"]
            if not cursor:
                return

    def version(self) -> str:
        return str(self._json("GET", "/version")["version"])
