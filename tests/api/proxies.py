"""The sites of etc/proxy/ in front of a daemon: nginx and Caddy, those of this machine or taken from Debian's packages without installing them."""
import gzip
import http.client
import json
import os
import shutil
import socket
import ssl
import subprocess
import tempfile
import time

from access import certificate
from common import moving, slow
from daemon import Daemon
from tally import ROOT

NAME = "sga.example.org"
PROGRAMS = {"nginx": ("nginx", "usr/sbin/nginx"), "caddy": ("caddy", "usr/bin/caddy")}


def program(name, folder):
    """Its path; None where it can be had neither here nor from a mirror."""
    package, place = PROGRAMS[name]
    if found := shutil.which(name):
        return found
    try:
        os.mkdir(f"{folder}/{name}")
        subprocess.run(["apt-get", "-q", "download", package], cwd=f"{folder}/{name}", capture_output=True, timeout=120, check=True)
        for deb in os.listdir(f"{folder}/{name}"):
            subprocess.run(["dpkg", "-x", f"{folder}/{name}/{deb}", f"{folder}/{name}"], capture_output=True, check=True)
    except (OSError, subprocess.SubprocessError):
        return None
    return f"{folder}/{name}/{place}"


def free_port():
    with socket.socket() as s:
        s.bind(("127.0.0.1", 0))
        return s.getsockname()[1]


def site(file, *changes):
    """The shipped text, at the test's addresses; each change must be one."""
    with open(os.path.join(ROOT, "etc/proxy", file), encoding="utf-8") as f:
        text = f.read()
    for old, new in changes:
        assert old in text, (file, old)
        text = text.replace(old, new)
    return text


def nginx(path, folder, port, behind, cert, key):
    text = site("nginx.conf", ("server 127.0.0.1:8080;", f"server 127.0.0.1:{behind};"), ("    listen 443 ssl;", f"    listen 127.0.0.1:{port} ssl;"),
                ("    listen [::]:443 ssl;\n", ""), ("/etc/ssl/certs/sga.example.org.pem", cert), ("/etc/ssl/private/sga.example.org.key", key))
    temp = "".join(f"{kind}_temp_path {folder}/temp-{kind};" for kind in ("client_body", "proxy", "fastcgi", "uwsgi", "scgi"))
    with open(f"{folder}/nginx.conf", "w", encoding="utf-8") as f:
        f.write(f"daemon off; pid {folder}/pid; user root; error_log stderr; worker_processes 1; events {{}} http {{ access_log off; {temp}\n{text}\n}}")
    return [path, "-p", folder, "-c", f"{folder}/nginx.conf", "-e", "stderr"]


def caddy(path, folder, port, behind, cert, key):
    text = site("Caddyfile", ("127.0.0.1:8080 {", f"127.0.0.1:{behind} {{"), ("reverse_proxy 127.0.0.1:8080\n", f"reverse_proxy 127.0.0.1:{behind}\n"),
                (f"{NAME} {{\n", f"https://{NAME}:{port} {{\n\tbind 127.0.0.1\n\ttls {cert} {key}\n"))
    with open(f"{folder}/Caddyfile", "w", encoding="utf-8") as f:
        f.write("{\n\tadmin off\n\tauto_https off\n}\n" + text)
    return [path, "run", "--config", f"{folder}/Caddyfile", "--adapter", "caddyfile"]


class Through:
    """A client that knows the site by its name."""

    def __init__(self, port, cert):
        self.port, self.trust = port, ssl.create_default_context(cafile=cert)

    def connect(self, seconds=60):
        c = http.client.HTTPConnection(NAME, timeout=seconds)
        c.sock = self.trust.wrap_socket(socket.create_connection(("127.0.0.1", self.port), timeout=seconds), server_hostname=NAME)
        return c

    def ask(self, method, path, body=None, headers=None, connection=None):
        c = connection or self.connect()
        c.request(method, path, body if isinstance(body, bytes) else json.dumps(body) if body else None, {"Content-Type": "application/json", **(headers or {})})
        r = c.getresponse()
        answer = r.status, {k.lower(): v for k, v in r.getheaders()}, r.read()
        if not connection:
            c.close()
        return answer


def served(t, process):
    for _ in range(600):
        try:
            if t.ask("GET", "/healthz")[0] == 200:
                return True
        except (OSError, http.client.HTTPException):
            pass
        if process.poll() is not None:
            return False
        time.sleep(0.05)
    return False


def events(t, c, name):
    """Events come while the job runs, not when the proxy has gathered enough."""
    id_ = json.loads(t.ask("POST", "/v1/jobs", slow())[2])["id"]
    stream = t.connect(30)
    stream.request("GET", f"/v1/jobs/{id_}/events")
    r = stream.getresponse()
    first = b""
    while b"data:" not in first:
        first += r.read1(4096) or b"data: it ended"
    c(r.status == 200 and b"it ended" not in first, f"{name}: an event comes while the job runs", first[-200:])
    c(t.ask("DELETE", f"/v1/jobs/{id_}")[0] in (200, 202), f"{name}: cancelled")
    c(b"event: end" in r.read(), f"{name}: and its end")
    stream.close()


def asked(t, d, c, name):
    status, headers, body = t.ask("POST", "/v1/solve", moving(samples=400))
    job = json.loads(body)
    c(status == 200 and job["status"] == "done", f"{name}: solve", body[:300])
    there = d.get("/v1/jobs/" + job["id"])
    status, packed, body = t.ask("GET", "/v1/jobs/" + job["id"], headers={"Accept-Encoding": "gzip"})
    c(status == 200 and packed.get("content-encoding") == "gzip" and json.loads(gzip.decompress(body)) == there.json(), f"{name}: packed, and the same", packed)
    with open(os.path.join(d.state, "test.log"), encoding="utf-8") as f:
        c(f'"request_id":"{headers["x-request-id"]}"' in f.read(), f"{name}: the log of the daemon has the id that the client was told", headers)
    one = t.connect()
    c([t.ask("GET", "/version", connection=one)[0] for _ in range(20)] == [200] * 20, f"{name}: twenty requests on one connection")
    one.close()
    waited = json.loads(t.ask("POST", "/v1/jobs", moving(), {"Prefer": "wait=30"})[2])
    c(waited["status"] == "done", f"{name}: waiting", waited)
    c(t.ask("GET", "/metrics")[0] == 200 and t.ask("GET", "/readyz")[0] == 200, f"{name}: metrics and readiness, for this machine")
    try:
        status = t.ask("POST", "/v1/jobs", b" " * (5 << 20))[0]
    except OSError:                   # it does not read what it has refused
        status = 413
    c(status == 413, f"{name}: a body that is too large", status)
    status, headers, body = t.ask("POST", "/v1/jobs", {"system": {}})
    c(status >= 400 and headers["content-type"] == "application/problem+json" and json.loads(body)["code"], f"{name}: problems go through", body[:200])
    events(t, c, name)


def proxies(build, c):
    with tempfile.TemporaryDirectory(prefix="sgad-proxies-") as folder:
        cert, key = certificate(folder, NAME)
        for name, start in (("nginx", nginx), ("caddy", caddy)):
            path = program(name, folder)
            if not path:
                print(f"# no {name} here, and no package of it: its site is not tried")
                continue
            with Daemon(build, "--workers", "1", "--allow-host", NAME) as d, open(f"{folder}/{name}.log", "w+b") as log:
                port = free_port()
                process = subprocess.Popen(start(path, folder, port, d.port, cert, key), stdout=log, stderr=log, env={**os.environ, "HOME": folder})
                try:
                    t = Through(port, cert)
                    log.seek(0)
                    if c(served(t, process), f"{name}: it serves the site", log.read()[-1500:]):
                        asked(t, d, c, name)
                finally:
                    process.terminate()
                    process.wait(30)


ALL = [proxies]
