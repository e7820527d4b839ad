"""Every endpoint as it is meant to be used."""
import csv
import glob
import hashlib
import io
import json
import os
import re
import subprocess
import tempfile
import time
import xml.etree.ElementTree as ElementTree
import zipfile

import schemas
from common import moving, trivial
from tally import ROOT


PRODUCT = "0.3.0"


def sources():
    """A digest of all that answers may change with, as lib/run/version.sh has it."""
    files = sorted(f for end in ("*.c", "*.h", "*.def") for f in glob.glob(os.path.join("lib", "**", end), root_dir=ROOT, recursive=True))
    whole = hashlib.sha256()
    for f in files:
        with open(os.path.join(ROOT, f), "rb") as source:
            whole.update(source.read())
    return whole.hexdigest()[:12]


def about(d, c):
    for path, status in (("/healthz", "ok"), ("/readyz", "ready")):
        a = d.get(path)
        c.status(a, 200, path)
        c(a.json().get("status") == status, path, a.body)
    version = d.get("/version").json()
    c(version["name"] == "sgad" and version["version"] == f"{PRODUCT}+{sources()}", "version: the product's, and what answers come from", version)
    request = trivial()
    job = d.ask("POST", "/v1/jobs", request).json()["id"]
    text = json.dumps(request, sort_keys=True, separators=(",", ":"))
    c(job == hashlib.sha256(f"{version['version']}\n{text}".encode()).hexdigest()[:len(job)], "jobs of other versions have other names", job)
    for name in schemas.NAMES:
        a = d.get("/v1/schema/" + name)
        c.status(a, 200, f"schema {name}")
        c(a.headers["content-type"].startswith("application/schema+json"), f"schema {name}: media type")
        c(a.json() == schemas.load(name), f"schema {name} is the file")
    a = d.get("/openapi.json")
    c(a.status == 200 and a.json() == schemas.load("openapi"), "openapi.json is the file")


def metrics(d, c):
    d.ask("POST", "/v1/solve", trivial())
    a = d.get("/metrics")
    c.status(a, 200, "metrics")
    c(a.headers["content-type"].startswith("text/plain"), "metrics: media type")
    line = re.compile(r'^(# (HELP|TYPE) \S+ .*|[a-zA-Z_:][a-zA-Z0-9_:]*(\{([a-zA-Z_]\w*="[^"]*",?)*\})? [-+0-9.eE]+(inf|nan)?)$')
    text = a.body.decode()
    bad = [l for l in text.splitlines() if l and not line.match(l)]
    c(not bad, "metrics: lines", bad[:3])
    named = set(re.findall(r"^# TYPE (\S+)", text, re.M))
    used = {re.sub(r"_(bucket|sum|count)$", "", l.split("{")[0].split(" ")[0]) for l in text.splitlines() if l and l[0] != "#"}
    c(used and used <= named | {u for u in used if u in named}, "metrics: each has a type", used - named)
    c(not re.search(r"[0-9a-f]{32}", text), "metrics: no ids in labels")


def job(d, c):
    request = moving()
    a = d.ask("POST", "/v1/jobs", request)
    c.status(a, (202, 200), "post")
    posted = c.job(a, "post")
    c(a.headers.get("location") == "/v1/jobs/" + posted["id"], "post: Location", a.headers)
    if posted["status"] in ("queued", "running"):
        c("retry-after" in a.headers, "post: Retry-After", a.headers)
    ended = d.wait(posted["id"])
    c(ended["status"] == "done", "job is done", ended)
    c(ended["result"]["verdict"] == "unique", "result")
    a = d.get("/v1/jobs/" + posted["id"])
    c.job(a, "get")
    etag = a.headers.get("etag", "")
    c(re.match(r'^"[^"]+"$', etag), "get: strong ETag", etag)
    b = d.get("/v1/jobs/" + posted["id"], If_None_Match=etag)
    c(b.status == 304 and b.body == b"", "get: 304", b.status)
    b = d.get("/v1/jobs/" + posted["id"], If_None_Match='"other"')
    c.status(b, 200, "get with another ETag")


def cache(d, c):
    request = moving()
    first = d.ask("POST", "/v1/solve", request)
    c.status(first, 200, "solve")
    one = c.job(first, "solve")
    c(one.get("cached") is False, "solve: not cached at first", one.get("cached"))
    for label, text in (("the same", json.dumps(request)), ("with blanks", json.dumps(request, indent=3)),
                        ("in another order", json.dumps({k: request[k] for k in reversed(request)}))):
        a = d.ask("POST", "/v1/solve", text)
        c.status(a, 200, f"cache: {label}")
        two = c.job(a, f"cache: {label}")
        c(two.get("cached") is True and two.get("id") == one.get("id"), f"cache: {label}", {k: two.get(k) for k in ("cached", "id")})
        c(two.get("result") == one.get("result"), f"cache: {label}: the same result")
    a = d.ask("POST", "/v1/jobs", request)
    c(a.status == 200 and a.json()["cached"] is True, "POST /v1/jobs answers from the cache", a.status)
    other = d.ask("POST", "/v1/solve", moving()).json()
    c(other["id"] != one["id"], "another request is another job")


def waiting(d, c):
    a = d.ask("POST", "/v1/jobs", trivial(), {"Prefer": "wait=20"})
    c(a.status == 200 and c.job(a, "Prefer")["status"] == "done", "Prefer: wait", a.status)
    c("wait" in a.headers.get("preference-applied", ""), "Preference-Applied", a.headers)
    a = d.ask("POST", "/v1/solve", trivial(), {"Prefer": "wait=0"})
    c.status(a, (200, 202), "solve without waiting")
    d.wait(a.json()["id"])


def listing(d, c):
    ids = [d.ask("POST", "/v1/solve", trivial()).json()["id"] for _ in range(5)]
    time.sleep(0.05)
    a = d.get("/v1/jobs?limit=3")
    c.status(a, 200, "list")
    page = a.json()
    fault = schemas.faults(c.list_schema, page)
    c(not fault, "list: schema", fault)
    c([j["id"] for j in page["jobs"]] == ids[:1:-1], "list: newest first", [j["id"] for j in page["jobs"]])
    second = d.get(f"/v1/jobs?limit=2&cursor={page['next']}").json()
    c([j["id"] for j in second["jobs"]] == ids[1::-1], "list: the next page", second)
    seen, cursor = [], ""
    for _ in range(200):
        page = d.get("/v1/jobs?limit=2" + (f"&cursor={cursor}" if cursor else "")).json()
        seen += [j["id"] for j in page["jobs"]]
        cursor = page.get("next")
        if not cursor:
            break
    c(len(seen) == len(set(seen)) and set(ids) <= set(seen) and not cursor, "list: all pages", len(seen))
    done = d.get("/v1/jobs?status=done").json()["jobs"]
    c(done and all(j["status"] == "done" for j in done), "list: filter by status")
    queued = d.get("/v1/jobs?status=queued").json()["jobs"]
    c(queued == [], "list: nothing is queued", queued)
    for query in ("limit=0", "limit=x", "status=asleep", "cursor=x"):
        c.problem(d.get("/v1/jobs?" + query), 400, "bad_request", f"list: {query}")


def trajectory(d, c):
    asked = moving(samples=7)
    job_ = d.ask("POST", "/v1/solve", asked).json()
    path = f"/v1/jobs/{job_['id']}/trajectory"
    t = job_["result"]["trajectory"]
    a = d.get(path)
    c(a.status == 200 and a.headers["content-type"].startswith("application/json") and a.json() == t, "trajectory: JSON", a.body[:200])
    for label, b in (("Accept", d.get(path, Accept="text/csv")), ("format", d.get(path + "?format=csv"))):
        c(b.headers.get("content-type", "").startswith("text/csv"), f"csv by {label}: media type", b.headers)
        rows = [line.split(",") for line in b.body.decode().splitlines()]
        c(rows[0] == t["columns"], f"csv by {label}: columns", rows[0])
        c([[float(x) for x in r] for r in rows[1:]] == t["rows"], f"csv by {label}: rows")
    for label, b in (("Accept", d.get(path, Accept="application/x-ndjson")), ("format", d.get(path + "?format=ndjson"))):
        c("ndjson" in b.headers.get("content-type", ""), f"ndjson by {label}: media type", b.headers)
        rows = [json.loads(line) for line in b.body.decode().splitlines()]
        c(rows == [dict(zip(t["columns"], r)) for r in t["rows"]], f"ndjson by {label}: rows", rows[:1])
    b = d.get(path, Accept="text/csv;q=0.1, application/json")
    c(b.headers["content-type"].startswith("application/json"), "trajectory: qualities of Accept", b.headers)
    etag = a.headers.get("etag", "")
    c(etag and d.get(path, If_None_Match=etag).status == 304, "trajectory: 304")
    tags = {etag}
    for form, type_, start in (("npy", "application/x-npy", b"\x93NUMPY"), ("mat", "application/x-matlab-data", b"MATLAB 5.0 MAT-file"), ("svg", "image/svg+xml", b"<?xml")):
        with tempfile.TemporaryDirectory() as folder:
            file = os.path.join(folder, "request.json")
            with open(file, "w", encoding="utf-8") as f:
                json.dump(asked, f)
            made = subprocess.run([os.path.join(d.build, "sga"), "solve", file, f"--{form}"], capture_output=True, check=False).stdout
        for label, b in (("Accept", d.get(path, Accept=type_)), ("format", d.get(path + "?format=" + form))):
            c(b.status == 200 and b.headers.get("content-type") == type_, f"{form} by {label}: media type", b.headers)
            c(b.body == made and made.startswith(start), f"{form} by {label}: what the command makes", b.body[:100])
            tags.add(b.headers["etag"])
    c(len(tags) == 4, "trajectory: a tag for each form", tags)
    chosen = d.get(path + "?format=svg&x=x&columns=y")
    c(chosen.status == 200 and chosen.body.count(b"<polyline") == 1, "svg: columns", chosen.body[:200])
    c("no column q" in c.problem(d.get(path + "?format=svg&columns=y,q"), 400, "bad_request", "svg: no such column").get("detail", ""), "svg: which columns there are")
    c.problem(d.get(path + "?format=npy&columns=y"), 400, "bad_request", "npy: columns")
    c.problem(d.get(path + "?format=png"), 400, "bad_request", "trajectory: png")
    c.problem(d.get(path, Accept="image/png"), 406, "not_acceptable", "trajectory: image")
    none = d.ask("POST", "/v1/solve", trivial()).json()
    c.problem(d.get(f"/v1/jobs/{none['id']}/trajectory"), 409, "no_trajectory", "trajectory: not asked for")


def tradeoff(d, c):
    request = {"system": {"form": "equations", "variables": ["x"], "equations": ["x'' = -x"]}, "want": ["tradeoff"],
               "trajectory": {"stop": 1, "samples": 2, "initial": {"x": 1, "x'": 0}}}
    job_ = d.ask("POST", "/v1/solve", request).json()
    path = f"/v1/jobs/{job_['id']}/tradeoff"
    t = job_["result"]["tradeoff"]
    a = d.get(path)
    c(a.status == 200 and a.headers["content-type"].startswith("application/json") and a.json() == t, "tradeoff: JSON", a.body[:200])
    again = d.ask("POST", "/v1/solve", request).json()
    c(again["cached"] and again["result"]["tradeoff"] == t, "tradeoff: what was measured is cached")
    for label, b in (("Accept", d.get(path, Accept="text/csv")), ("format", d.get(path + "?format=csv"))):
        c(b.headers.get("content-type", "").startswith("text/csv"), f"tradeoff csv by {label}: media type", b.headers)
        rows = list(csv.DictReader(b.body.decode().splitlines()))
        c([(r["method"], float(r["rtol"]), float(r["seconds"])) for r in rows] == [(r["method"], r["rtol"], r["seconds"]) for r in t["rows"]],
          f"tradeoff csv by {label}: rows", rows[:1])
    for label, b in (("Accept", d.get(path, Accept="image/svg+xml")), ("format", d.get(path + "?format=svg"))):
        c(b.headers.get("content-type", "") == "image/svg+xml", f"tradeoff svg by {label}: media type", b.headers)
        c(ElementTree.fromstring(b.body).tag.endswith("}svg"), f"tradeoff svg by {label}: an image")
    etag = a.headers.get("etag", "")
    c(etag and d.get(path, If_None_Match=etag).status == 304 and d.get(path + "?format=svg").headers["etag"] != etag, "tradeoff: ETag")
    c.problem(d.get(path, Accept="application/x-ndjson"), 406, "not_acceptable", "tradeoff: ndjson")
    c.problem(d.get(path + "?format=png"), 400, "bad_request", "tradeoff: png")
    none = d.ask("POST", "/v1/solve", trivial()).json()
    c.problem(d.get(f"/v1/jobs/{none['id']}/tradeoff"), 409, "no_tradeoff", "tradeoff: not asked for")


def conditional(d, c):
    """What has not changed is not sent again: jobs, trajectories in each form, descriptions."""
    id_ = d.ask("POST", "/v1/solve", moving(samples=5)).json()["id"]
    job_, tags = f"/v1/jobs/{id_}", {}
    for path in (job_, job_ + "/trajectory", job_ + "/trajectory?format=csv", job_ + "/trajectory?format=ndjson", "/openapi.json", "/v1/schema/result",
                 "/v1/schema/request"):
        a = d.get(path)
        tag = tags[path] = a.headers.get("etag", "")
        c(a.status == 200 and re.fullmatch(r'"[^"]+"', tag), f"{path}: a strong ETag", a.headers)
        for given in (tag, "*", f'"other", {tag}', f'W/{tag}', f'"a,b" ,W/"x",{tag}'):
            b = d.get(path, If_None_Match=given)
            c(b.status == 304 and not b.body and b.headers.get("etag") == tag, f"{path}: 304 for {given}", (b.status, b.headers))
        for given in ('"other"', tag[1:-1], tag[:-2] + '"', f'"x{tag[1:]}', f'W/"other{tag[1:]}', "", '"'):
            c.status(d.get(path, If_None_Match=given), 200, f"{path}: 200 for {given!r}")
        b = d.ask("HEAD", path)
        c(b.status == 200 and b.headers.get("etag") == tag and not b.body, f"{path}: HEAD", b.headers)
    c(len(set(tags.values())) == len(tags), "each form has a tag of its own", tags)
    busy = d.ask("POST", "/v1/jobs", moving()).json()["id"]
    a = d.get("/v1/jobs/" + busy, Prefer="wait=20", If_None_Match="*")
    c.status(a, 304, "304 also after waiting for the end")
def sweep(d, c):
    """Trajectories of a sweep: the list as JSON, one more column as lines; a set without a trajectory has no rows."""
    system = {"form": "equations", "variables": ["set"], "parameters": {"p": 1}, "equations": ["set' = set/p"]}
    asked = {"system": system, "trajectory": {"stop": 1, "samples": 3, "initial": {"set": 1}},
             "sweep": [{"parameters": {"p": p}} for p in (1, 0, 2)]}
    job_ = d.ask("POST", "/v1/solve", asked).json()
    path, list_ = f"/v1/jobs/{job_['id']}/trajectory", job_["result"]["trajectories"]
    a = d.get(path)
    c(a.status == 200 and a.json() == list_ and "error" in list_[1], "sweep: JSON", a.body[:200])
    rows = [line.split(",") for line in d.get(path + "?format=csv").body.decode().splitlines()]
    c(rows[0] == ["set_", "t", "set"], "sweep: csv columns", rows[0])
    should = [[k] + r for k in (0, 2) for r in list_[k]["rows"]]
    c([[float(x) for x in r] for r in rows[1:]] == should, "sweep: csv rows", rows)
    lines = [json.loads(line) for line in d.get(path + "?format=ndjson").body.decode().splitlines()]
    named = [{"set_": k, "t": r[0], "set": r[1]} for k in (0, 2) for r in list_[k]["rows"]]
    c(lines == named[:3] + [{"set_": 1, "error": list_[1]["error"]}] + named[3:], "sweep: ndjson", lines)


def events(d, c):
    id_ = d.ask("POST", "/v1/jobs", moving(samples=9)).json()["id"]
    a = d.get(f"/v1/jobs/{id_}/events")
    c(a.status == 200 and a.headers["content-type"].startswith("text/event-stream"), "events", a.headers)
    blocks = [b for b in a.body.decode().split("\n\n") if "event:" in b]
    fields = [dict(line.split(": ", 1) for line in b.splitlines() if ": " in line and line[0] != ":") for b in blocks]
    c(fields and fields[-1]["event"] == "end", "events: the last is the end", a.body[-300:])
    c(all(f["event"] == "progress" for f in fields[:-1]), "events: progress before")
    c(all("id" in f for f in fields), "events: ids")
    for f in fields:
        fault = schemas.faults(c.job_schema, json.loads(f["data"]))
        c(not fault, "events: job schema", fault)
    c(json.loads(fields[-1]["data"])["status"] == "done", "events: done")
    c.status(d.get(f"/v1/jobs/{id_}/events", Last_Event_ID=fields[-1]["id"]), 204, "events: nothing after the end")
    for seen in ("1", "999999", "-3", "other", ""):
        a = d.get(f"/v1/jobs/{id_}/events", Last_Event_ID=seen)
        c(a.status == 200 and a.body.count(b"event: end") == 1 and b"id: end" in a.body, f"events: the end for who saw {seen!r}", a.body[-200:])


def examples(d, c):
    """The project's examples, and an answer sent back as a request."""
    for name in ("arm", "pendulum", "circuit"):
        with open(os.path.join(ROOT, "etc", "examples", name + ".json"), encoding="utf-8") as f:
            asked = f.read()
        a = d.ask("POST", "/v1/solve", asked)
        c.status(a, 200, name)
        j = c.job(a, name)
        c(j.get("status") == "done" and j["result"]["trajectory"]["ended"] is None, f"example {name}", j.get("error"))
        if j.get("status") != "done":
            continue
        r = j["result"]
        names = [v["name"].replace("'", "_") for v in r["variables"]]
        texts = {k.replace("'", "_"): v.replace("'", "_") for k, v in r["vector_field"]["components"].items()}
        free = r["vector_field"]["free"]
        if r.get("definitions"):
            continue
        back = {"system": {"form": "quasilinear", "variables": names + free, "parameters": json.loads(asked)["system"].get("parameters", {}),
                           "A": {"rows": len(names), "cols": len(names + free), "entries": [[i, i, 1] for i in range(len(names))]},
                           "alpha": [texts[n] for n in names],
                           "restrict": [k["expression"].replace("'", "_") for k in r["constraints"]]}}
        again = c.job(d.ask("POST", "/v1/solve", back), f"{name} sent back")
        c(again.get("status") == "done", f"{name} sent back", again.get("error"))
        if again.get("status") == "done" and not free:
            c(again["result"]["dimensions"]["final"] == r["dimensions"]["final"], f"{name} sent back: dimension",
              again["result"]["dimensions"])


def code(d, c):
    """What the sources compute is checked by tests/export_check.py; here they are resources of jobs."""
    with open(os.path.join(ROOT, "etc", "examples", "sliding.json"), encoding="utf-8") as f:
        job_ = d.ask("POST", "/v1/solve", json.load(f)).json()
    path = f"/v1/jobs/{job_['id']}/code"
    for language, kind in (("c", "text/x-c"), ("python", "text/x-python"), ("matlab", "text/x-matlab"), ("julia", "text/x-julia"), ("casadi", "text/x-python"),
                           ("modelica", "text/x-modelica"), ("latex", "text/x-tex"), ("mathml", "application/mathml+xml")):
        a = d.get(path + "?language=" + language)
        c(a.status == 200 and a.headers["content-type"].startswith(kind), f"code in {language}: media type", a.headers)
        c(job_["id"].encode() in a.body and len(a.body) > 500, f"code in {language}: names its job", a.body[:200])
        c(d.get(path + "?language=" + language, If_None_Match=a.headers["etag"]).status == 304, f"code in {language}: ETag")
    c.problem(d.get(path), 400, "bad_request", "code without a language")
    c.problem(d.get(path + "?language=cobol"), 400, "bad_request", "code in another language")
    c.problem(d.get("/v1/jobs/" + "0" * len(job_["id"]) + "/code?language=c"), 404, "not_found", "code of no job")
    request = {"system": {"form": "equations", "variables": ["x"], "equations": ["x' = -x"]}, "want": ["index"]}
    none = d.ask("POST", "/v1/solve", request).json()
    c.problem(d.get(f"/v1/jobs/{none['id']}/code?language=c"), 409, "no_code", "code without a field")
    a, b = d.get(path.replace("/code", "/fmu")), d.get(path + "?language=fmu")
    with zipfile.ZipFile(io.BytesIO(a.body)) as z:
        described = z.read("modelDescription.xml").decode()
    c(a.status == 200 and a.headers["content-type"] == "application/zip" and "sga_model.fmu" in a.headers.get("content-disposition", ""), "fmu: media type", a.headers)
    c(job_["id"] in described and b.body == a.body and b.headers["etag"] == a.headers["etag"], "fmu: names its job, and is one", described[:300])
    c(d.get(path.replace("/code", "/fmu"), If_None_Match=a.headers["etag"]).status == 304, "fmu: ETag")
    c.problem(d.get(path.replace("/code", "/fmu?language=c")), 400, "bad_request", "fmu: no query")
    c.problem(d.get(f"/v1/jobs/{none['id']}/fmu"), 409, "no_code", "fmu without a field")


ALL = [code, about, metrics, job, cache, waiting, listing, trajectory, sweep, tradeoff, conditional, events, examples]
