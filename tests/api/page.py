"""The page as files: what is served, how, and to whom. What it does in a browser is tests/page."""
import glob
import gzip
import hashlib
import os
import re

from daemon import Daemon
from tally import ROOT

FOLDER = os.path.join(ROOT, "clients", "page")


def files():
    found = [f for end in ("*.html", "*.css", "*.js", "*.svg", os.path.join("uplot", "*.js"), os.path.join("uplot", "*.css")) for f in glob.glob(os.path.join(FOLDER, end))]
    return {os.path.basename(f): open(f, "rb").read() for f in found}


def page_files(d, c):
    """Each file, as it is and packed; all of them, packed, are small."""
    sizes = 0
    for name, content in files().items():
        path = "/" if name == "index.html" else "/page/" + name
        a, z = d.get(path), d.get(path, Accept_Encoding="br, gzip;q=0.5")
        c(a.status == 200 and a.body == content and "content-encoding" not in a.headers, f"{name} as it is", a.headers)
        c(z.status == 200 and z.headers.get("content-encoding") == "gzip" and gzip.decompress(z.body) == content, f"{name} packed", z.headers)
        c(a.headers["etag"] != z.headers["etag"] and z.headers["vary"] == "Accept-Encoding", f"{name}: the two are told apart", z.headers)
        c(d.get(path, If_None_Match=a.headers["etag"]).status == 304, f"{name}: 304")
        c("content-encoding" not in d.get(path, Accept_Encoding="gzip;q=0, br").headers, f"{name}: gzip refused")
        policy = a.headers["content-security-policy"]
        c("default-src 'none'" in policy and "unsafe" not in policy and "http" not in policy and a.headers["x-content-type-options"] == "nosniff", f"{name}: policy", policy)
        sizes += len(z.body)
    c(sizes <= 60000, "the page is 60 kB, packed", sizes)
    kinds = {"/": "text/html", "/page/main.js": "text/javascript", "/page/page.css": "text/css", "/page/pendulum.json": "application/json"}
    for path, kind in kinds.items():
        c(d.get(path).headers["content-type"].startswith(kind), f"{path}: media type")
    for path in ("/page/", "/page/nothing", "/page/..%2Fmain.js", "/page/main.js/x", "/page/index.html/"):
        c.problem(d.get(path), 404, "not_found", path)
    c.problem(d.ask("POST", "/", "{}"), 405, "method_not_allowed", "POST /")


def page_sources(_, c):
    """Nothing of another host, no script or style inside the page, no eval, no text of others as HTML."""
    for name, content in files().items():
        text = content.decode()
        if name.startswith("uPlot"):
            continue
        others = set(re.findall(r"https?://[\w.]+", text)) - {"http://www.w3.org"}
        c(not others, f"{name}: no other host", others)
        c(not re.search(r"innerHTML|outerHTML|insertAdjacentHTML|document\.write|\beval\(|new Function|localStorage", text), f"{name}: no ways in")
        c(not re.search(r"<style|\sstyle=|<script(?![^>]*\ssrc=)|\son\w+=\"", text), f"{name}: nothing inside the page")


VENDORED = {"uPlot.iife.min.js": "19c8d4c6ad88929a79f4ae49d6f7161566dfd0ba3d15cc495e974f787eb78f1f",      # of uplot-1.6.32.tgz of npm
            "uPlot.min.css": "df630c6a8d6f8eeaff264b50f73ce5b114f646ffd9a0bb74f049b0a00135fa04"}


def page_vendored(_, c):
    for name, content in files().items():
        if name.startswith("uPlot"):
            c(hashlib.sha256(content).hexdigest() == VENDORED[name], f"{name} is the package's")


def page_examples(d, c):
    listed = re.findall(r'\["(\w+)", "', files()["examples.js"].decode())
    kept = {os.path.basename(f)[:-5] for f in glob.glob(os.path.join(ROOT, "etc", "examples", "*.json"))}
    c(set(listed) == kept and len(listed) == len(kept), "each example is in the list", set(listed) ^ kept)
    for name in listed:
        with open(os.path.join(ROOT, "etc", "examples", name + ".json"), "rb") as f:
            c(d.get(f"/page/{name}.json").body == f.read(), f"example {name}")


def page_or_none(build, c):
    with Daemon(build, "--ui", "no") as d:
        for path in ("/", "/page/main.js"):
            c.problem(d.get(path), 404, "not_found", f"--ui no: {path}")
        c.status(d.get("/healthz"), 200, "--ui no: the rest")


SHARED = [page_files, page_sources, page_vendored, page_examples]
ALL = [page_or_none]
