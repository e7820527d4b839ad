"""Bytes on a connection: each refusal is one problem with one status line, however the bytes come, and nothing is read after it."""
import json
import re
import socket
import ssl
import subprocess
import tempfile
import time

from common import trivial
from daemon import Daemon

GET = "GET /version HTTP/1.1\r\nHost: localhost\r\n\r\n"
HEAD = "Host: localhost\r\nContent-Type: application/json\r\n"
CHUNKED = f"POST /v1/solve HTTP/1.1\r\n{HEAD}Transfer-Encoding: chunked\r\n\r\n"


def refused():
    post = f"POST /v1/solve HTTP/1.1\r\n{HEAD}"
    return {
        "a bare line feed after a chunk's size": (CHUNKED + "2\n{}\r\n0\r\n\r\n", 400),
        "a bare line feed after a chunk's data": (CHUNKED + "2\r\n{}\n0\r\n\r\n", 400),
        "a bare line feed in an extension": (CHUNKED + "2;a\n\r\n{}\r\n0\r\n\r\n", 400),
        "data longer than their size": (CHUNKED + "2\r\n{}}\r\n0\r\n\r\n", 400),
        "no size": (CHUNKED + "\r\n", 400),
        "a size with junk": (CHUNKED + "2x\r\n{}\r\n0\r\n\r\n", 400),
        "a size with a sign": (CHUNKED + "+2\r\n{}\r\n0\r\n\r\n", 400),
        "a size with 0x": (CHUNKED + "0x2\r\n{}\r\n0\r\n\r\n", 400),
        "an overlong size": (CHUNKED + "00000000000000002\r\n{}\r\n0\r\n\r\n", 400),
        "a size past all": (CHUNKED + "ffffffffffffffff\r\n{}", 400),
        "a trailer without a colon": (CHUNKED + "2\r\n{}\r\n0\r\nGET / HTTP/1.1\r\n\r\n", 400),
        "long trailers": (CHUNKED + "2\r\n{}\r\n0\r\n" + "a: b\r\n" * 2000, 431),
        "long extensions": (CHUNKED + "2;" + "a" * 9000 + "\r\n{}\r\n0\r\n\r\n", 431),
        "chunked and a zero": (post + "Transfer-Encoding: chunked\0\r\n\r\n0\r\n\r\n", 400),
        "chunked in HTTP/1.0": (CHUNKED.replace("HTTP/1.1", "HTTP/1.0") + "0\r\n\r\n", 400),
        "no host": ("GET /version HTTP/1.1\r\n\r\n", 400),
        "no length": (post + "Content-Length: x\r\n\r\n", 400),
        "a length past all": (post + "Content-Length: 99999999999999999999999\r\n\r\n", 400),
        "a folded header": (f"GET /version HTTP/1.1\r\n{HEAD} more\r\n\r\n", 400),
        "bare line feeds": (GET.replace("\r\n", "\n"), 400),
        "no version": ("GET /version\r\n\r\n", 400),
        "another version": (GET.replace("1.1", "2.0"), 505),
        "the preface of HTTP/2": ("PRI * HTTP/2.0\r\n\r\nSM\r\n\r\n", 505),
        "a zero in a parameter": (GET.replace("/version", "/v1/jobs?limit=1%00"), 400),
        "TLS where none is": ("\x16\x03\x01\x02\x00\x01\x00", 400),
        "a long target": (GET.replace("/version", "/" + "a" * 100000), 414),
        "many parameters": (GET.replace("/version", "/v1/jobs?" + "&".join(f"a{i}=1" for i in range(3000))), 414),
        "many headers": (GET.replace("\r\n\r\n", "\r\n" + "".join(f"x{i}: y\r\n" for i in range(1000)) + "\r\n"), 431),
        "a long header": (GET.replace("\r\n\r\n", "\r\nx: " + "y" * 60000 + "\r\n\r\n"), 431),
        "many cookies": (GET.replace("\r\n\r\n", "\r\nCookie: " + "a=b; " * 2000 + "\r\n\r\n"), 431),
    }


def replies(text):
    """The statuses of all replies in the text, taken apart by their lengths; None where they are not whole."""
    found = []
    while text:
        head, _, rest = text.partition(b"\r\n\r\n")
        length = re.search(rb"\r\nContent-Length: (\d+)", head)
        if not head.startswith(b"HTTP/1.1 ") or not length or len(rest) < int(length[1]):
            return None
        found.append((int(head[9:12]), head, rest[:int(length[1])]))
        text = rest[int(length[1]):]
    return found


def talk(connection, pieces):
    """Sends the pieces; all that comes until the other side closes."""
    out = b""
    with connection as s:
        for p in pieces:
            try:
                s.sendall(p)
            except OSError:
                break
        try:
            while piece := s.recv(65536):
                out += piece
        except ssl.SSLEOFError:
            pass
    return out


def one_each(c, connect, label):
    for name, (text, status) in refused().items():
        data = text.encode("latin1")
        ways = {"": [data + GET.encode()], " after another": [GET.encode() + data + GET.encode()]}
        if len(data) < 400:
            ways[" byte by byte"] = [data[i:i + 1] for i in range(len(data))]
        for way, pieces in ways.items():
            got = replies(talk(connect(), pieces))
            expected = [200, status] if way == " after another" else [status]
            if not c(got is not None and [g[0] for g in got] == expected, f"{label}{name}{way}: {expected}", got):
                continue
            _, head, body = got[-1]
            problem = json.loads(body)
            c(problem["status"] == status and b"application/problem+json" in head and b"Connection: close" in head and b"X-Request-Id: " in head,
              f"{label}{name}{way}: a problem", got[-1])


def refusals_framed(d, c):
    def connect():
        s = socket.create_connection(("127.0.0.1", d.port), timeout=10)
        s.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
        return s
    one_each(c, connect, "framing: ")
    # who writes on while it is refused gets the refusal, and no reset in its place
    got = replies(talk(connect(), [(CHUNKED + "2\n").encode()] + [b"x" * 65536] * 40))
    c(got and [g[0] for g in got] == [400], "framing: a client that writes on", got)
    got = talk(connect(), [b"HEAD / HTTP/1.1\r\nHost: localhost\r\nx\r\n\r\n"])
    c(got.startswith(b"HTTP/1.1 400") and got.endswith(b"\r\n\r\n"), "framing: a refusal of HEAD has no body", got)
    counts = d.get("/metrics").body.decode()
    for code in ("target_too_long", "header_too_large", "http_version"):
        c(re.search(rf'sgad_refusals_total{{code="{code}"}} [1-9]', counts), f"framing: {code} is counted")


def well_framed(d, c):
    """What is allowed goes through, and means nothing else: extensions, trailers, heads as large as they may be."""
    body = json.dumps(trivial())
    parts = [body[i:i + 7] for i in range(0, len(body), 7)]
    exts = [";a", ";a=b", " ; a = \"x;\\\"\"", ""]
    text = CHUNKED + "".join(f"{len(p):x}{exts[i % 4]}\r\n{p}\r\n" for i, p in enumerate(parts)) + "0;z\r\nContent-Length: 5\r\nHost: evil\r\n\r\n"
    end = GET.replace("\r\n\r\n", "\r\nConnection: close\r\n\r\n")
    for pieces in ([text + end], [*text, end], ["\r\n" + text, "\r\n", end]):
        got = replies(talk(socket.create_connection(("127.0.0.1", d.port), timeout=20), [p.encode() for p in pieces]))
        c(got and [g[0] for g in got] == [200, 200], "framing: extensions and trailers", got)
    largest = {
        "a target": "/v1/jobs/" + "a" * 7991,
        "parameters": "/v1/jobs?" + "&".join(f"a{i}=1" for i in range(100)),
        "parameters without names": "/v1/jobs?" + "&" * 99,
    }
    for name, target in largest.items():
        got = replies(talk(socket.create_connection(("127.0.0.1", d.port), timeout=10), [end.replace("/version", target).encode()]))
        c(got and len(got) == 1 and got[0][0] in (400, 404) and b"problem#" in got[0][2], f"framing: as large as it may be: {name}", got)
    for name, fields in {"headers": "".join(f"x{i}: y\r\n" for i in range(98)), "bytes": "x: " + "y" * 16300 + "\r\n", "cookies": "Cookie: " + "a=b;" * 100 + "\r\n",
                         "all": "Cookie: " + "a=b;" * 100 + "\r\n" + "".join(f"x{i}: {'y' * 100}\r\n" for i in range(97))}.items():
        target = "/v1/jobs?" + "&".join(f"a{i}=1" for i in range(100)) if name == "all" else "/version"
        got = replies(talk(socket.create_connection(("127.0.0.1", d.port), timeout=10), [(f"GET {target} HTTP/1.1\r\nHost: a\r\n" + fields + "\r\n").encode()]))
        c(got and len(got) == 1 and b"problem#forbidden_host" in got[0][2], f"framing: as large as they may be: {name}", got)
    c.problem(d.get("/healthz", Host="localhost:99999999"), 403, "forbidden_host", "a port that is none")


def framed_secure(build, c):
    """The same behind TLS; the log names the peer."""
    with tempfile.TemporaryDirectory() as folder:
        cert, key = f"{folder}/cert.pem", f"{folder}/key.pem"
        subprocess.run(["openssl", "req", "-x509", "-newkey", "ec", "-pkeyopt", "ec_paramgen_curve:P-256", "-nodes", "-keyout", key, "-out", cert,
                        "-days", "2", "-subj", "/CN=localhost", "-addext", "subjectAltName=DNS:localhost"], check=True, capture_output=True)
        d = Secure(build, "--tls-cert", cert, "--tls-key", key, "--allow-host", "localhost")
        with d:
            context = ssl.create_default_context(cafile=cert)

            def connect():
                return context.wrap_socket(socket.create_connection(("127.0.0.1", d.port), timeout=10), server_hostname="localhost")
            one_each(c, connect, "framing, TLS: ")
            got = replies(talk(connect(), [GET.encode() * 3 + b"x\n"]))
            c(got and [g[0] for g in got] == [200, 200, 200, 400], "framing, TLS: three, and a fault", got)
            time.sleep(0.2)
            d.stop()
        c('"code":"http_version"' in d.log_text and '"peer":"127.0.0.1"' in d.log_text and "request_past_front" not in d.log_text,
          "framing: the log says who was refused", d.log_text[-500:])


class Secure(Daemon):
    """A daemon that speaks TLS; log_text: what it logged."""

    def start(self):
        try:
            super().start()
        except RuntimeError as e:
            port = re.search(r"listening on https://127\.0\.0\.1:(\d+)", str(e))
            if not port:
                raise
            self.port = int(port[1])

    def ended(self, seconds=30):
        status = super().ended(seconds)
        with open(f"{self.state}/test.log", encoding="utf-8") as f:
            self.log_text = f.read()
        return status


SHARED = [refusals_framed, well_framed]
ALL = [framed_secure]
