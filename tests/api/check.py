"""POST /v1/check and GET /v1/jobs/ID/request: what is said of a request before and after it runs."""
import json
import os

import schemas
from cases import load
from common import moving, slow, trivial
from tally import ROOT


def review(d, c, body, label):
    """What is said of a body, valid by the schema."""
    a = d.ask("POST", "/v1/check", body)
    c.status(a, 200, label)
    said = a.json()
    fault = schemas.faults(schemas.validator("check"), said)
    c(not fault, f"{label}: check schema", fault)
    return said


def places(said):
    return [(p["code"], p.get("pointer", ""), p.get("column")) for p in said["problems"]]


def check_all(d, c):
    """Each of several problems, with its place, in one answer; mended one by one they go one by one."""
    system = {"form": "equations", "variables": ["x", "y"], "parameters": {"g": "1 +"}, "equations": ["x' = y +* 2", "y' = -g*zz", "x' + y' = 1)"]}
    request = {"system": system, "trajectory": {"stop": 1, "initial": {"x": "2*"}, "outputs": ["x", "x -"], "wat": 1},
               "accuracy": {"rtol": 3, "arithmetic": "quad"}, "want": ["index", "indx"], "strata": "all", "limit": {}}
    mend = [(("limit",), None), (("system", "parameters", "g"), "9.81"), (("system", "equations", 0), "x' = y"), (("system", "equations", 1), "y' = -g*x"),
            (("system", "equations", 2), "x' + y' = 1"), (("want", 1), "gauge"), (("trajectory", "wat"), None), (("trajectory", "initial", "x"), 1),
            (("trajectory", "outputs", 1), "y"), (("accuracy", "arithmetic"), "auto"), (("accuracy", "rtol"), 1e-6), (("strata",), "list")]
    left = ["/" + "/".join(map(str, path)) for path, _ in mend]
    for path, value in mend:
        said = review(d, c, request, f"before {path} is mended")
        c([p["pointer"] for p in said["problems"]] == left, f"all problems are listed before {path} is mended", places(said))
        c(said["valid"] is False and said["form"] == "equations" and said["variables"] is None, "not valid", said)
        posted = d.ask("POST", "/v1/jobs", request).json()
        c(posted["pointer"] in left and posted in said["problems"], f"what posting says of it is among them: {path}", posted)
        at = request
        for key in path[:-1]:
            at = at[key]
        if value is None:
            del at[path[-1]]
        else:
            at[path[-1]] = value
        left.remove("/" + "/".join(map(str, path)))
    said = review(d, c, request, "mended")
    c(said["valid"] is True and not said["problems"], "nothing is left", said)
    columns = {p["pointer"]: p.get("column") for p in review(d, c, {"system": {**system, "equations": ["x' = y", "y' = 1 -* x"]}}, "columns")["problems"]}
    c(columns == {"/system/equations/1": 9}, "columns", columns)


def check_bodies(d, c):
    """No JSON, no request, and far too many problems."""
    for body, code in (("", "json_syntax"), ('{"system": ', "json_syntax"), ("[" * 100, "json_too_deep"), ("[]", "invalid_request"), ("{}", "missing_member")):
        said = review(d, c, body, f"body {body[:12]!r}")
        c(said["valid"] is False and [p["code"] for p in said["problems"]] == [code] and said["form"] is None, f"body {body[:12]!r}", said)
    wide = {"system": {"form": "quasilinear", "variables": ["x"], "A": [[1]] * 300, "alpha": ["x +"] * 300}}
    said = review(d, c, wide, "300 problems")
    c(len(said["problems"]) == 100 and [w["code"] for w in said["warnings"]] == ["list_cut"], "as many as are listed", len(said["problems"]))
    c.problem(d.ask("POST", "/v1/check", "{}", {"Content-Type": "text/plain"}), 415, "unsupported_media_type", "check: content type")
    c.problem(d.get("/v1/check"), 405, "method_not_allowed", "check: GET")
    c.problem(d.ask("POST", "/v1/check?x=1", "{}"), 400, "bad_request", "check: query")
    nested = {"system": {**trivial()["system"], "alpha": ["(" * 100000 + "x" + ")" * 100000]}}
    c(places(review(d, c, nested, "deep"))[0][0] in ("expression_too_deep", "expression_too_large"), "a deep expression")


def check_warnings(d, c):
    before = len(d.get("/v1/jobs?limit=500").json()["jobs"])
    said = review(d, c, {"system": {"form": "equations", "variables": ["x", "y", "z"], "parameters": {"k": 2, "u": 1}, "equations": ["x' = k*y"]}}, "unused")
    c(said["valid"] and (said["equations"], said["unknowns"]) == (1, 3), "counts", said)
    c([(w["code"], "z" in w["detail"] or "u" in w["detail"]) for w in said["warnings"]] == [("unused_name", True)] * 2 + [("fewer_equations", True)], "warnings", said)
    said = review(d, c, moving(), "more equations")
    c([w["code"] for w in said["warnings"]] == ["more_equations"] and (said["equations"], said["unknowns"]) == (3, 2), "more equations than unknowns", said)
    c(len(d.get("/v1/jobs?limit=500").json()["jobs"]) == before, "a check makes no job")


def check_hints(d, c):
    """Spellings of other languages: the advice is the spelling that is taken."""
    base = {"form": "equations", "variables": ["x", "lam"]}
    for text, advice in (("dx/dt = lam", "x' or der(x)"), ("xdot = lam", "x' or der(x)"), ("x_dot = lam", "x'"), ("xddot = lam", "x''"), ("Dx = lam", "x'"),
                         ("D(x) = lam", "der(x)"), ("x' = lambda", "'lam'"), ("x' = time", "t here"), ("x' = ln(lam)", "log(x)"), ("x' = diff(x)", "der(x)")):
        p = review(d, c, {"system": {**base, "equations": [text]}}, text)["problems"]
        c(len(p) == 1 and p[0]["code"] == "unknown_name" and advice in p[0]["detail"], f"hint for {text}", p)
    p = review(d, c, {"system": {"form": "linear", "variables": ["x"], "E": [[1]], "A": [[1]], "B": [[1]]}}, "E")["problems"]
    c(p and p[0]["pointer"] == "/system/E" and "A x' = B x" in p[0]["detail"], "hint for E", p)
    for text in ("x' = lam", "der(x) = lam", "x'' = lam", "x' = t"):
        c(review(d, c, {"system": {**base, "equations": [text]}}, text)["valid"], f"what is advised is taken: {text}")


def check_corpus(d, c):
    """The cases of the corpus: what is refused at the post is not valid, with that problem; all others are. Variables are the answer's."""
    every = int(os.environ.get("SGA_TEST_EVERY", "1")) * 10
    for case in [x for x in load(()) if "request" in x][::every]:
        said = review(d, c, case["request"], case["name"])
        a = d.ask("POST", "/v1/jobs", case["request"])
        if a.status in (200, 202):
            c(said["valid"] is not False, f"{case['name']}: accepted and valid", said["problems"][:1])
            d.ask("DELETE", "/v1/jobs/" + a.json()["id"])
        else:
            c(said["valid"] is False and a.json() in said["problems"], f"{case['name']}: refused and not valid", said["problems"][:1])


def check_same_variables(d, c):
    for request in (trivial(), moving(), json.load(open(os.path.join(ROOT, "etc", "examples", "pendulum.json"), encoding="utf-8"))):
        said, result = review(d, c, request, "variables"), d.ask("POST", "/v1/solve", request).json()["result"]
        c(said["variables"] == result["variables"], "variables are those of the answer", said)


def request_of_job(d, c):
    request = moving()
    job = d.ask("POST", "/v1/solve", request).json()
    a = d.get(f"/v1/jobs/{job['id']}/request")
    c.status(a, 200, "request of a job")
    c(a.json() == request and job["links"]["request"] == f"/v1/jobs/{job['id']}/request", "it is what was posted", a.body[:300])
    c(d.get(f"/v1/jobs/{job['id']}/request", If_None_Match=a.headers["etag"]).status == 304, "it never changes")
    c(d.ask("POST", "/v1/jobs", a.body).json()["id"] == job["id"], "posted again it is the same job")
    running = d.ask("POST", "/v1/jobs", slow()).json()["id"]
    c.status(d.get(f"/v1/jobs/{running}/request"), 200, "request of a running job")
    d.ask("DELETE", "/v1/jobs/" + running)
    c.problem(d.get("/v1/jobs/" + "0" * 32 + "/request"), 404, "not_found", "request of an unknown job")
    c.problem(d.get("/v1/jobs/x/request"), 404, "not_found", "request of no id")


def list_names(d, c):
    request = moving()
    for name in ("a pendulum", "\u00e9" * 200, None):
        if name:
            request["system"]["name"] = name
        else:
            request["system"].pop("name")
        id_ = d.ask("POST", "/v1/jobs", request).json()["id"]
        a = d.get("/v1/jobs?limit=5")
        row = next(j for j in a.json()["jobs"] if j["id"] == id_)
        c(not schemas.faults(schemas.validator("openapi#JobList"), a.json()), "list schema", a.body[:300])
        c(row["form"] == "equations" and (row["name"] == name if not name or len(name) < 40 else name.startswith(row["name"]) and row["name"]), "lists have names and forms", row)
    done = d.ask("POST", "/v1/solve", moving()).json()
    row = next(j for j in d.get("/v1/jobs?status=done&limit=5").json()["jobs"] if j["id"] == done["id"])
    c(row["verdict"] == done["result"]["verdict"] == "unique", "lists have verdicts", row)
    long = {**request, "trajectory": {**request["trajectory"], "outputs": ["x"] * 9000}}
    long["system"]["name"] = "long"
    id_ = d.ask("POST", "/v1/jobs", long).json()["id"]
    row = next(j for j in d.get("/v1/jobs?limit=5").json()["jobs"] if j["id"] == id_)
    failed = d.ask("POST", "/v1/solve", {**moving(), "trajectory": {"stop": 1, "initial": {"x": 5, "y": 5000}, "hold": ["x", "y"]}}).json()
    bad = next(j for j in d.get("/v1/jobs?status=failed&limit=5").json()["jobs"] if j["id"] == failed["id"])
    c(bad["verdict"] is None, "a failed job has none", bad)
    c(row["name"] is None and row["form"] is None, "a long request is not read for a list", row)


ALL = [list_names, check_all, check_bodies, check_warnings, check_hints, check_corpus, check_same_variables, request_of_job]
