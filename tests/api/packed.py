"""Bodies packed by gzip: the same bytes once unpacked, a tag for each, nothing where it is not asked for."""
import gzip
import http.client
import json
import re
import socket

from common import moving, slow
from daemon import Daemon


def both(d, c, path, label, **headers):
    """The same as it is and packed."""
    plain = d.get(path, **headers)
    packed = d.get(path, Accept_Encoding="gzip", **headers)
    c(plain.status == packed.status == 200 and "content-encoding" not in plain.headers and packed.headers.get("content-encoding") == "gzip",
      f"{label}: packed where it is asked for", (plain.headers, packed.headers))
    c("Accept-Encoding" in plain.headers.get("vary", "") and "Accept-Encoding" in packed.headers.get("vary", ""), f"{label}: Vary", plain.headers)
    c(gzip.decompress(packed.body) == plain.body, f"{label}: the same", len(packed.body))
    c(len(packed.body) < len(plain.body), f"{label}: shorter", (len(packed.body), len(plain.body)))
    tags = plain.headers.get("etag"), packed.headers.get("etag")
    if tags[0]:
        c(tags[0] != tags[1] and not tags[1].startswith("W/"), f"{label}: a tag for each", tags)
        for tag, coding, status in ((tags[0], None, 304), (tags[1], "gzip", 304), (tags[1], None, 200), (tags[0], "gzip", 200),
                                    (f"{tags[0]}, {tags[1]}", "gzip", 304), ("*", "gzip", 304)):
            a = d.ask("GET", path, headers={"If-None-Match": tag, "Accept-Encoding": coding, **{k.replace("_", "-"): v for k, v in headers.items()}})
            c(a.status == status and (status == 200 or (not a.body and "content-encoding" not in a.headers and a.headers["etag"] in tags)),
              f"{label}: If-None-Match {tag}, {coding}: {status}", (a.status, a.headers))
    return plain, packed


def packing(d, c):
    job = d.ask("POST", "/v1/solve", moving(samples=2000)).json()
    path = "/v1/jobs/" + job["id"]
    both(d, c, path, "packed: a job")
    both(d, c, path + "/trajectory", "packed: samples")
    for kind in ("csv", "ndjson"):
        both(d, c, path + "/trajectory?format=" + kind, f"packed: samples as {kind}")
    both(d, c, path + "/code?language=c", "packed: code")
    both(d, c, "/v1/jobs?limit=20", "packed: the list")
    both(d, c, "/openapi.json", "packed: the description")
    both(d, c, "/v1/schema/request", "packed: a schema")
    both(d, c, "/page/main.js", "packed: the page")
    request = moving(samples=3000)
    first = d.ask("POST", "/v1/solve", request, {"Accept-Encoding": "gzip"})
    again = d.ask("POST", "/v1/solve", request, {"Accept-Encoding": "gzip"})
    plain = d.ask("POST", "/v1/solve", request)
    c(first.headers.get("content-encoding") == again.headers.get("content-encoding") == "gzip", "packed: answers to POST", first.headers)
    c(gzip.decompress(again.body) == plain.body and json.loads(gzip.decompress(first.body))["result"] == plain.json()["result"], "packed: a cache hit")
    for given, packs in (("gzip;q=0", False), ("gzip;q=0, *", False), ("br", False), ("*", True), ("*;q=0", False), ("deflate, GZIP;q=0.5", True), ("x-gzip", True),
                         ("gzip;q=0.4, identity;q=0.5", False), ("gzipped", False), ("identity", False), ("", False), ("br;q=1, gzip;q=0.001", True)):
        a = d.get(path, Accept_Encoding=given)
        c((a.headers.get("content-encoding") == "gzip") == packs, f"packed: Accept-Encoding: {given}: {packs}", a.headers)
    a = d.get("/v1/jobs/" + "0" * 32, Accept_Encoding="gzip")
    c("content-encoding" not in a.headers and c.problem(a, 404, "not_found", "packed: no problem is"), "packed: no problem is", a.headers)
    a = d.get("/healthz", Accept_Encoding="gzip")
    c("content-encoding" not in a.headers and "vary" not in a.headers, "packed: nothing small is", a.headers)


def packing_head(d, c):
    path = "/v1/jobs/" + d.ask("POST", "/v1/solve", moving(samples=500)).json()["id"]
    a, b = (d.ask(m, path, headers={"Accept-Encoding": "gzip"}) for m in ("GET", "HEAD"))
    c(b.status == 200 and not b.body and b.headers.get("content-encoding") == "gzip" and b.headers["etag"] == a.headers["etag"], "packed: HEAD", b.headers)
    # one connection, one after the other; and HTTP/1.0, where the end of the connection is that of the body
    h = http.client.HTTPConnection("127.0.0.1", d.port, timeout=20)
    for _ in range(3):
        h.request("GET", path, headers={"Accept-Encoding": "gzip"})
        c(gzip.decompress(h.getresponse().read()) == d.get(path).body, "packed: a connection goes on")
    h.close()
    with socket.create_connection(("127.0.0.1", d.port), timeout=20) as s:
        s.sendall(f"GET {path} HTTP/1.0\r\nHost: localhost\r\nAccept-Encoding: gzip\r\n\r\n".encode())
        out = b""
        while piece := s.recv(65536):
            out += piece
    head, _, body = out.partition(b"\r\n\r\n")
    c(b"Transfer-Encoding" not in head and gzip.decompress(body) == d.get(path).body, "packed: HTTP/1.0", head)


def packing_events(d, c):
    """Event streams are not: each event is to come when it is sent."""
    job = d.ask("POST", "/v1/jobs", slow(20)).json()
    h = http.client.HTTPConnection("127.0.0.1", d.port, timeout=20)
    h.request("GET", f"/v1/jobs/{job['id']}/events", headers={"Accept-Encoding": "gzip"})
    r = h.getresponse()
    first = r.read(30)
    c(r.getheader("content-encoding") is None and b"retry" in first + r.read(30), "packed: no event stream is", first)
    h.close()
    d.ask("DELETE", "/v1/jobs/" + job["id"])


def packing_much(build, c):
    """Many at a time, more than are packed at once, some given up; and what they hold is given back."""
    with Daemon(build, "--address-connections", "0") as d:
        path = "/v1/jobs/" + d.ask("POST", "/v1/solve", moving(samples=4000)).json()["id"]
        plain = d.get(path).body
        socks = []
        for _ in range(400):
            s = socket.create_connection(("127.0.0.1", d.port), timeout=30)
            s.sendall(f"GET {path} HTTP/1.1\r\nHost: localhost\r\nAccept-Encoding: gzip\r\nConnection: close\r\n\r\n".encode())
            socks.append(s)
        good = 0
        for i, s in enumerate(socks):
            if i % 5 == 0:
                s.close()
                continue
            r = http.client.HTTPResponse(s)
            r.begin()
            body = r.read()
            good += (gzip.decompress(body) if r.getheader("content-encoding") == "gzip" else body) == plain
            s.close()
        c(good == 320, "packed: many at a time", good)
        both(d, c, path, "packed: after many")
        c(re.search(r"sgad_event_streams 0\b", d.get("/metrics").body.decode()), "packed: the service goes on")
        c(d.stop() == 0, "packed: the daemon ends with 0")


SHARED = [packing, packing_head, packing_events]
ALL = [packing_much]
