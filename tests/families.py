"""What long lists of an answer say once with a loop (`families`), for loops_check.py: written out by a reader of its own, and by those of the
clients, it is the answer that "whole" gives; exports are the same; short answers have no loops."""
import json
import os
import shutil
import subprocess
import sys

from tally import ROOT

HEAT = {"system": {
    "form": "equations", "sizes": {"n": 20}, "variables": ["u[0:n+1,0:n+1]"],
    "equations": [{"for": "i = 1:n, j = 1:n", "equation": "u[i,j]' = u[i-1,j] + u[i+1,j] + u[i,j-1] + u[i,j+1] - 4*u[i,j]"},
                  {"for": "i = 1:n", "equation": "u[0,i] = 0"}, {"for": "i = 1:n", "equation": "u[n+1,i] = 1"},
                  {"for": "i = 0:n+1", "equation": "u[i,0] = u[i,1]"}, {"for": "i = 0:n+1", "equation": "u[i,n+1] = sin(t)"}]}}
CHAIN = {"system": {
    "form": "equations", "sizes": {"n": 60}, "variables": ["x[1:n]", "y[1:n]", "l[1:n]"],
    "equations": ["x[1]'' = -l[1]*x[1] + l[2]*(x[2] - x[1])", {"for": "i = 2:n-1", "equation": "x[i]'' = -l[i]*(x[i] - x[i-1]) + l[i+1]*(x[i+1] - x[i])"}, "x[n]'' = -l[n]*(x[n] - x[n-1])",
                  "y[1]'' = -l[1]*y[1] + l[2]*(y[2] - y[1]) - 10", {"for": "i = 2:n-1", "equation": "y[i]'' = -l[i]*(y[i] - y[i-1]) + l[i+1]*(y[i+1] - y[i]) - 10"},
                  "y[n]'' = -l[n]*(y[n] - y[n-1]) - 10", "x[1]^2 + y[1]^2 = 1", {"for": "i = 2:n", "equation": "(x[i] - x[i-1])^2 + (y[i] - y[i-1])^2 = 1"}]}}
# coefficients that are the loop's number, and one that repeats nothing; names as loops would have them are taken
MASSES = {"system": {
    "form": "equations", "sizes": {"n": 40}, "variables": ["i[1:n]", "j[1:n]", "k", "m"],
    "equations": [{"for": "a = 1:n", "equation": "i[a]' = a*j[a] - i[a]"}, {"for": "a = 1:n-1", "equation": "j[a] = a*i[a+1] + k"}, "j[n] = 2.5*i[1]^3", "k' = -k", "m = k + i[7]"]}}
FREE = {"system": {"form": "equations", "sizes": {"n": 60}, "variables": ["x[1:n]", "w[1:n]"], "equations": [{"for": "i = 1:n", "equation": "x[i]' = w[i]"}, {"for": "i = 1:n-58", "equation": "w[i] = 3*x[i+1]"}]}}
PLAIN = {"system": {"form": "equations", "variables": [f"x{i}" for i in range(1, 61)], "equations": [f"x{i}' = x{i % 60 + 1}" for i in range(1, 60)] + ["x60 = 1"]}}


def is_family(e):
    return isinstance(e, dict) and {"for", "count", "place"} <= set(e)


def text_of(value, put):
    if isinstance(value, str):
        return put(value)
    if isinstance(value, list):
        return [text_of(v, put) for v in value]
    return {put(k): text_of(v, put) for k, v in value.items()} if isinstance(value, dict) else value


def tangency(value):
    """Whole numbers again."""
    for part in value.get("combination", []) if isinstance(value, dict) else []:
        if isinstance(part.get("tangency_of"), str):
            part["tangency_of"] = int(part["tangency_of"][len("constraints["):-1])
    return value


def written(value, reader):
    """By the reader of requests that loops_check.py has of its own: reader.put, reader.passes, reader.dims_of, reader.names."""
    if isinstance(value, list) and any(map(is_family, value)):
        placed, others = {}, [e for e in value if not is_family(e)]
        for e in filter(is_family, value):
            body = {k: v for k, v in e.items() if k not in ("for", "count", "place")}
            body = body["expression"] if set(body) == {"expression"} else body
            passes = [env for _, env in reader.passes(reader.dims_of(e["for"]), {})]
            assert len(passes) == e["count"]
            for env in passes:
                place = reader.whole(e["place"], env)
                assert place not in placed
                placed[place] = tangency(text_of(body, lambda t: reader.put(t, env)))
        left = iter(others)
        return [placed[k] if k in placed else next(left) for k in range(len(placed) + len(others))]
    if isinstance(value, list):
        return [written(v, reader) for v in value]
    if isinstance(value, dict):
        made = {}
        for key, v in value.items():
            if reader.ranged(key):
                made.update({name: reader.put(v, env) for name, env in reader.names(key, {})})
            else:
                made[key] = written(v, reader)
        return made
    return value


def by_python(answer):
    sys.path.insert(0, os.path.join(ROOT, "clients", "python"))
    from sga.families import whole
    return whole(answer)


def by_page(answer):
    text = "import { whole } from %s; import fs from 'fs'; console.log(JSON.stringify(whole(JSON.parse(fs.readFileSync(0)))));" % json.dumps("file://" + os.path.join(ROOT, "clients", "page", "families.js"))
    run = subprocess.run(["node", "--input-type=module", "-e", text], input=json.dumps(answer), capture_output=True, text=True, timeout=120)
    return json.loads(run.stdout) if run.returncode == 0 else run.stderr


def by_octave(answer):
    text = f"addpath('{os.path.join(ROOT, 'clients', 'octave')}'); printf('%s\\n', sga.encode(sga.whole(sga.decode(fileread('/dev/stdin')))));"
    run = subprocess.run(["octave-cli", "--norc", "--eval", text], input=json.dumps(answer), capture_output=True, text=True, timeout=300)
    return json.loads(run.stdout) if run.returncode == 0 else run.stderr


def asked(c, label, request, families):
    answer = c.solve(f"{label}, {families}", {**request, "families": families} if families != "left out" else request)
    said = [w["code"] for w in answer["warnings"]]
    answer["warnings"] = [w for w in answer["warnings"] if w["code"] != "families"]
    return answer, "families" in said


def entries(answer):
    return len(answer["constraints"]) + len(answer["vector_field"]["components"])


def exports(c, label, request):
    for language in ("c", "python", "latex"):
        one, two = (c.code(label, {**request, "families": f}, language) for f in ("auto", "whole"))
        differ = [(a, b) for a, b in zip(one.splitlines(), two.splitlines()) if a != b and "sga" not in a]
        c.tally.check(one and not differ and len(one) == len(two), f"{label}: the same export to {language}", str(differ[:1]))


def check(c, reader, small):
    """c: the Check of loops_check; small: requests whose answers have short lists only."""
    most = {"heat": 30, "chain": 150, "masses": 100, "free": 40}
    for label, request in (("heat", HEAT), ("chain", CHAIN), ("masses", MASSES), ("free", FREE)):
        whole, said = asked(c, label, request, "whole")
        c.tally.check(not said and "\"for\"" not in json.dumps(whole), f"{label}: whole is whole")
        for families in ("left out", "auto", "fold"):
            answer, said = asked(c, label, request, families)
            c.tally.check(said == (families != "fold"), f"{label}, {families}: it is said")
            names = len(answer["variables"])
            c.tally.check(names < len(whole["variables"]) / 4 if families == "fold" else names == len(whole["variables"]), f"{label}, {families}: variables", str(names))
            c.tally.check(entries(answer) <= most[label], f"{label}, {families}: it is short", f"{entries(answer)} of {entries(whole)}")
            ways = [("this reader", lambda a: written(a, reader)), ("the Python client", by_python)]
            if families == "auto" and shutil.which("node"):
                ways.append(("the page", by_page))
            for name, way in ways:
                made = way(answer)
                c.tally.check(made == whole, f"{label}, {families}: {name} writes out the same", str([k for k in whole if not isinstance(made, dict) or made.get(k) != whole[k]]))
            if families == "auto" and shutil.which("octave-cli"):
                parts = lambda a: {"variables": a["variables"], "constraints": a["constraints"], "components": a["vector_field"]["components"], "evidence": a["evidence"]["constraints"]}
                made = by_octave(parts(answer))
                c.tally.check(made == parts(whole), f"{label}: Octave writes out the same", str(made)[:300])
    for label, request in small.items():
        whole, _ = asked(c, label, request, "whole")
        answer, said = asked(c, label, request, "left out")
        c.tally.check(not said and answer == whole, f"{label}: a short answer has no loops")
        answer, said = asked(c, label, request, "fold")
        c.tally.check(written(answer, reader) == whole, f"{label}, fold: written out")
    whole, said = asked(c, "plain names", PLAIN, "left out")
    c.tally.check(not said and "\"for\"" not in json.dumps(whole), "plain names: no loop can say them")
    exports(c, "heat", HEAT)
    exports(c, "chain", {**CHAIN, "system": {**CHAIN["system"], "sizes": {"n": 18}}})
    c.refused("families", {**HEAT, "families": "short"}, "invalid_request", "/families", "known are \"auto\"")
