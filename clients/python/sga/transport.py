"""HTTP by the standard library: http, https, and UNIX sockets."""
from __future__ import annotations

import http.client
import json
import socket
import ssl
import time
from typing import Any, Dict, Iterator, Optional, Tuple
from urllib.parse import urlsplit

from .errors import ServiceError, of_response

RETRIES = 4                 # of what the service asked to be tried later
LONGEST_PAUSE = 10.0        # seconds, whatever it asked for


class _UnixConnection(http.client.HTTPConnection):
    def __init__(self, path: str, timeout: Optional[float]) -> None:
        super().__init__("localhost", timeout=timeout)
        self._path = path

    def connect(self) -> None:
        self.sock = socket.socket(socket.AF_UNIX, socket.SOCK_STREAM)
        self.sock.settimeout(self.timeout)
        self.sock.connect(self._path)


class Transport:
    """One connection for each request, so that threads may share it."""

    def __init__(self, url: str, token: Optional[str], ca: Optional[str], timeout: float) -> None:
        self.token, self.timeout = token, timeout
        self.path = url[5:] if url.startswith("unix:") else None
        parts = urlsplit(url if "://" in url or self.path else "http://" + url)
        if not self.path and (parts.scheme not in ("http", "https") or not parts.hostname):
            raise ValueError(f"{url!r} is no address: http://HOST:PORT, https://HOST:PORT or unix:PATH")
        self.parts, self.prefix = parts, "" if self.path else parts.path.rstrip("/")
        self.context = ssl.create_default_context(cafile=ca) if parts.scheme == "https" else None
        if token and parts.scheme == "http" and parts.hostname not in ("localhost", "127.0.0.1", "::1"):
            raise ValueError("a token is not sent to another machine without https")

    def _connection(self, timeout: float) -> http.client.HTTPConnection:
        if self.path:
            return _UnixConnection(self.path, timeout)
        if self.context:
            return http.client.HTTPSConnection(self.parts.hostname or "", self.parts.port, timeout=timeout, context=self.context)
        return http.client.HTTPConnection(self.parts.hostname or "", self.parts.port, timeout=timeout)

    def _send(self, method: str, path: str, body: Any, headers: Optional[Dict[str, str]], timeout: float) -> Tuple[http.client.HTTPConnection, http.client.HTTPResponse]:
        sent = dict(headers or {})
        data = None
        if body is not None:
            data = body if isinstance(body, bytes) else json.dumps(body, allow_nan=False).encode()
            sent["Content-Type"] = "application/json"
        if self.token:
            sent["Authorization"] = "Bearer " + self.token
        connection = self._connection(timeout)
        try:
            connection.request(method, self.prefix + path, data, sent)
            return connection, connection.getresponse()
        except (OSError, http.client.HTTPException) as e:
            connection.close()
            raise ServiceError({"code": "unreachable", "title": "The service cannot be reached", "detail": f"{e or type(e).__name__}"}) from e

    def ask(self, method: str, path: str, body: Any = None, headers: Optional[Dict[str, str]] = None, timeout: Optional[float] = None) -> Tuple[int, Dict[str, str], bytes]:
        """(status, headers, body) of a reply below 400. What the service asks to try later is tried later, a few times."""
        for attempt in range(RETRIES + 1):
            connection, response = self._send(method, path, body, headers, timeout or self.timeout)
            try:
                content = response.read()
            except (OSError, http.client.HTTPException) as e:
                raise ServiceError({"code": "unreachable", "title": "The reply was cut", "detail": str(e)}) from e
            finally:
                connection.close()
            given = {k.lower(): v for k, v in response.getheaders()}
            if response.status < 400:
                return response.status, given, content
            pause = given.get("retry-after", "")
            if response.status != 503 or not pause.isdigit() or attempt == RETRIES:
                break
            time.sleep(min(float(pause), LONGEST_PAUSE))
        try:
            problem = json.loads(content)
        except ValueError:
            problem = {"code": "", "detail": f"status {response.status} {response.reason}"}
        raise of_response(problem, response.status)

    def lines(self, path: str, timeout: float) -> Iterator[str]:
        """The lines of a reply that comes piece by piece."""
        connection, response = self._send("GET", path, None, {"Accept": "text/event-stream"}, timeout)
        try:
            if response.status >= 400:
                raise of_response(json.loads(response.read()), response.status)
            while True:
                line = response.readline()
                if not line:
                    return
                yield line.decode("utf-8").rstrip("\n")
        finally:
            connection.close()
