"""The Octave client against a daemon: octave_check.py BUILD_DIR

One Octave solves, submits, waits, cancels and makes mistakes; what it has then is held against what the daemon tells this script. The
decoder reads hard JSON and the encoder writes it, against Python's."""
import json
import os
import re
import subprocess
import sys
import tempfile

HERE = os.path.dirname(os.path.abspath(__file__))
sys.path.insert(0, os.path.join(HERE, "api"))

from access import bearer, new_token, until  # noqa: E402
from common import slow  # noqa: E402
from daemon import Daemon  # noqa: E402
from tally import ROOT, Tally, build_folder  # noqa: E402

PENDULUM = {"system": {"form": "equations", "variables": ["x", "y", "lam"], "parameters": {"g": "9.81"},
                       "equations": ["x'' = -lam*x", "y'' = -lam*y - g", "x^2 + y^2 = 1"]},
            "trajectory": {"stop": 2, "samples": 41, "initial": {"x": 1, "x'": 0}}}
# What the client has, as JSON by the client's own encoder; errors as [identifier, message].
SCRIPT = r"""
addpath(getenv('CLIENT'));
function show(name, f)
  try
    v = f();
    printf('%s %s\n', name, sga.encode(v));
  catch e
    printf('%s %s\n', name, sga.encode({'error', e.identifier, e.message}));
  end
end
function v = verdict(r), v = r.verdict; end
function v = fields(r), v = r.gauge.fields; end
initial = containers.Map(); initial('x') = 1; initial('x''') = 0;
request = struct('system', struct('form', 'equations', 'variables', {{'x', 'y', 'lam'}}, 'parameters', struct('g', '9.81'), ...
  'equations', {{'x'''' = -lam*x', 'y'''' = -lam*y - g', 'x^2 + y^2 = 1'}}), 'trajectory', struct('stop', 2, 'samples', 41, 'initial', initial));
r = sga.solve(request);
show('request', @() request);
show('verdict', @() r.verdict);
show('generations', @() r.dimensions.generations.');
show('components', @() r.vector_field.components);
show('columns', @() r.trajectory.columns);
show('rows', @() r.trajectory.rows);
show('size', @() size(r.trajectory.rows));
show('column', @() sga.column(r.trajectory, 'y''').');
show('nocolumn', @() sga.column(r.trajectory, 'z'));
show('text', @() fields(sga.solve(getenv('GAUGE'))));
job = sga.submit(request);
show('id', @() job.id);
show('again', @() verdict(sga.wait(job)));
show('result', @() verdict(sga.result(job)));
request.system.equations{3} = 'x^2 + y^2 = é + q';
show('mistake', @() sga.solve(request));
show('nan', @() sga.encode(Inf));
slow = sga.submit(getenv('SLOW'));
show('pending', @() sga.result(slow));
show('timeout', @() sga.wait(slow, 1));
sga.cancel(slow);
show('cancelled', @() sga.wait(slow));
show('nowhere', @() sga.solve(request, 'server', 'http://127.0.0.1:1'));
show('option', @() sga.solve(request, 'sever', 'x'));
setenv('SGA_TOKEN', '');
show('token', @() sga.solve(request));
hard = sga.decode(getenv('HARD'));
show('hard', @() hard);
show('broken', @() sga.decode('{"a": [1, 2'));
show('classes', @() {class(hard.rows), class(hard.mixed), class(hard.names), size(hard.rows), class(hard.components), class(hard.nested)});
clear -all
"""
HARD = {"rows": [[1, 2.5, -3e-7], [4, None, 1e300]], "mixed": [[1, 2], [3]], "uneven": [[1, 2], [3], [4, 5, 6]], "texts": ["a\"b\\", "\\\"", "", "x[[1]]", "tab\t", "é ∂", "\u0001"],
        "names": {"x'": 1, "x_": 2, "y''": [1, 2]}, "components": {"x": "y"}, "deep": {"list": [{"a": [[["b"]]]}, {"c": True}]},
        "nested": [[[1, 2], [3, 4]], [[5, 6], [7, 8]]], "one": 1.7976931348623157e308, "tiny": 5e-324, "third": 1 / 3}


def run(d, token, gauge):
    with tempfile.TemporaryDirectory() as folder:
        path = os.path.join(folder, "script.m")
        with open(path, "w", encoding="utf-8") as f:
            f.write("1;\n" + SCRIPT)
        env = {**os.environ, "TMPDIR": folder, "CLIENT": os.path.join(ROOT, "clients", "octave"), "SGA_SERVER": d.url() + "/", "SGA_TOKEN": token, "GAUGE": json.dumps(gauge),
               "SLOW": json.dumps(slow()), "HARD": json.dumps(HARD, ensure_ascii=False, indent=1)}
        done = subprocess.run(["octave-cli", "--quiet", "--norc", path], capture_output=True, text=True, timeout=300, check=False, env=env)
        left = [name for name in os.listdir(folder) if name != "script.m"]
    return done, left


def plain(v):
    """As the client has it: lists of one number and the number are one."""
    if isinstance(v, list):
        v = [plain(e) for e in v]
        return v[0] if len(v) == 1 and not isinstance(v[0], (list, dict, str)) else v
    return {k: plain(e) for k, e in v.items()} if isinstance(v, dict) else [] if v is None else v


def answers(c, said, d, headers, gauge):
    there = d.ask("POST", "/v1/solve", PENDULUM, headers).json()["result"]
    c(said.get("request") == PENDULUM, "the request is written as it should be", said.get("request"))
    for name, true in (("verdict", there["verdict"]), ("generations", there["dimensions"]["generations"]), ("components", there["vector_field"]["components"]),
                       ("columns", there["trajectory"]["columns"]), ("rows", there["trajectory"]["rows"]), ("size", [41, len(there["trajectory"]["columns"])]),
                       ("column", [r[there["trajectory"]["columns"].index("y'")] for r in there["trajectory"]["rows"]]), ("again", there["verdict"]), ("result", there["verdict"])):
        c(said.get(name) == true, f"{name} is the daemon's", str(said.get(name))[:300])
    fields = d.ask("POST", "/v1/solve", gauge, headers).json()["result"]["gauge"]["fields"]
    c(fields and said.get("text") == fields, "gauge fields of a request as text", said.get("text"))
    c(any(j["id"] == said.get("id") for j in d.ask("GET", "/v1/jobs", headers=headers).json()["jobs"]), "a job's id", said.get("id"))


def documented(c, d, token):
    """What the page of the client does, and what it says comes of it."""
    with open(os.path.join(ROOT, "doc", "octave.md"), encoding="utf-8") as f:
        text = f.read()
    blocks = re.findall(r"```octave\n(.*?)```", text, re.S)
    printed = re.findall(r"```text\n(.*?)```", text, re.S)
    with tempfile.TemporaryDirectory() as folder:
        path = os.path.join(folder, "doc.m")
        with open(path, "w", encoding="utf-8") as f:
            f.write("\n".join(blocks))
        done = subprocess.run(["octave-cli", "--quiet", "--norc", path], capture_output=True, text=True, timeout=300, check=False, cwd=ROOT,
                              env={**os.environ, "SGA_SERVER": d.url(), "SGA_TOKEN": token})
    c(done.returncode == 0 and blocks and done.stdout == "".join(printed), "doc/octave.md: what it prints", done.stdout + done.stderr)


def mistakes(c, said):
    for name, identifier, words in (("mistake", "sga:expression_syntax", ["/system/equations/2", "column 13"]), ("nocolumn", "sga:column", ["z", "lam"]), ("nan", "sga:usage", []),
                                    ("pending", "sga:pending", []), ("timeout", "sga:timeout", ["1 seconds"]), ("cancelled", "sga:cancelled", []), ("nowhere", "sga:connection", []),
                                    ("option", "sga:usage", ["sever"]), ("token", "sga:unauthenticated", []), ("broken", "", [])):
        got = said.get(name)
        c(isinstance(got, list) and got[0] == "error" and got[1].startswith(identifier) and all(w in got[2] for w in words), f"an error: {name}", got)


def main():
    tally, build = Tally("octave"), build_folder()
    c = tally.check
    with open(os.path.join(ROOT, "etc", "examples", "arm.json"), encoding="utf-8") as f:
        gauge = json.load(f)
    with Daemon(build, "--access", "tokens") as d:
        token = new_token(build, d, "one")
        c(until(lambda: d.ask("GET", "/v1/jobs", headers=bearer(token)).status == 200), "token")
        done, left = run(d, token, gauge)
        said = {}
        for line in done.stdout.splitlines():
            name, _, text = line.partition(" ")
            said[name] = json.loads(text)
        # Octave 7 says this of any error that was caught, when it ends
        stderr = done.stderr.replace("error: ignoring const execution_exception& while preparing to exit\n", "")
        c(done.returncode == 0 and not stderr, "Octave ends well", stderr[-800:])
        documented(c, d, token)
        answers(c, said, d, bearer(token), gauge)
        c(not left, "no files are left", left)
    mistakes(c, said)
    hard = said.get("hard", {})
    for name, true in HARD.items():
        got = hard.get(name)
        c(plain(got) == plain(true) or name == "rows" and got == true, f"hard JSON: {name}", got)
    c(said.get("classes") == ["double", "cell", "containers.Map", [2, 3], "containers.Map", "cell"], "hard JSON: classes", said.get("classes"))
    listed(c)
    return tally.end()


def listed(c):
    """The decoder's list of objects by name is the schema's."""
    with open(os.path.join(ROOT, "schema", "result.json"), encoding="utf-8") as f:
        schema = json.load(f)
    named = {"#/$defs/" + k for k, v in schema["$defs"].items() if isinstance(v.get("additionalProperties"), dict)}
    found = set()

    def walk(name, o):
        for v in o if isinstance(o, list) else []:
            walk(name, v)
        if not isinstance(o, dict):
            return
        if o.get("$ref") in named or isinstance(o.get("additionalProperties"), dict):
            found.add(name)
        for k, v in o.items():
            if k == "properties":
                for m, s in v.items():
                    walk(m, s)
            elif k in ("items", "anyOf", "oneOf", "allOf", "then", "else", "prefixItems"):
                walk(name, v)
    walk("", schema)
    for k, v in schema["$defs"].items():
        if "#/$defs/" + k not in named:
            walk(k, v)
    with open(os.path.join(ROOT, "clients", "octave", "+sga", "decode.m"), encoding="utf-8") as f:
        text = f.read().split("strcmp(member, {", 1)[1].split("}", 1)[0]
    has = {w.strip(" '") for w in text.replace("...", "").replace("\n", "").split(",")}
    c(found <= has and has <= found, "the members by name are the schema's", sorted(found ^ has))


if __name__ == "__main__":
    sys.exit(main())
