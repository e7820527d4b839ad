"""The documents do what they say: docs_check.py BUILD_DIR

Of README.md and doc/*.md: links and anchors lead somewhere; requests are solved and the answers beside them compared; commands are
run against a daemon of their own; snippets of C compile; pages that are made are current; the table of endpoints is that of the
daemon; each code of a problem leads to its cause and cure; figures of speed stand in one page; nothing stands twice.

An answer is shortened: what it shows must be there, numbers to the digits shown; "..." in a list stands for any number of elements.
"""
import decimal
import json
import os
import re
import shutil
import subprocess
import sys
import tempfile

from tally import ROOT, Tally, build_folder

sys.path.insert(1, os.path.join(os.path.dirname(os.path.abspath(__file__)), "api"))

import schemas  # noqa: E402
from daemon import Daemon  # noqa: E402
from solver import Solver  # noqa: E402

MOST_LINES = 200          # of README.md
# Estimates and roundings: not their digits, but that they are no larger than shown by much.
LOOSE = {"error_estimate": 10, "constraint_residual": 30, "error": 10, "moved": 10}
# Command lines that are not run, and why. Each must still be there.
NOT_RUN = [
    (r"make run\b", "installs packages and builds; the demo is run by hand and in continuous integration"),
    (r"make test\b|make FLOOR=|make SAN=|tests/run ", "would run this suite again"),
    (r"build/sgad --listen 127\.0\.0\.1:8080 --state /var/tmp/sgad &", "the suite starts a daemon of its own"),
    (r"build/sgad --listen 0\.0\.0\.0:8443", "listens off loopback; the suite api has TLS and tokens"),
    (r"curl -H \"Authorization: Bearer", "needs that daemon"),
    (r"make install\b", "the suite install does it"),
    (r"systemd-sysusers && systemctl daemon-reload", "needs a booted systemd; the suite api speaks to the service as systemd does"),
    (r"make deb\b", "the suite deb does it"),
    (r"cc etc/examples/pendulum\.c", "the suite install does it, from the installed copy"),
    (r"doc/make\.py$", "writes; doc/make.py --check is run"),
    (r"tests/bench/|make bench\b", "measures: it takes minutes"),
]
LANGUAGES = {"json", "sh", "c", "matlab"}      # matlab is not run: there is none here
SPEED = re.compile(r"\b\d(?:[\d.,]*\d)?\s?(?:ns|us|µs|ms|s|seconds?|minutes?)\b|\b\d[\d.,]* times (?:less|more|faster|slower|longer|as)\b")
# Durations that are settings, and no figures of speed: (page, text)
SETTINGS = [("README.md", "30 s, or as"), ("doc/limits.md", "five seconds"), ("doc/limits.md", "usual 30 seconds"), ("doc/operations.md", "within two seconds"),
            ("doc/answer.md", "436 us")]
FENCE = re.compile(r"^```(\w*)\n(.*?)^```$", re.M | re.S)


def text_of(path):
    with open(os.path.join(ROOT, path), encoding="utf-8") as f:
        return f.read()


def pages():
    return ["README.md"] + sorted("doc/" + f for f in os.listdir(os.path.join(ROOT, "doc")) if f.endswith(".md"))


def without_code(text):
    return FENCE.sub("", text)


# Links

def slug(heading):
    """The anchor of a heading, as Markdown renderers make it."""
    words = re.sub(r"[`*]|\[([^\]]*)\]\([^)]*\)", lambda m: m[1] or "", heading).strip().lower()
    return re.sub(r"[^\w\- ]", "", words).replace(" ", "-")


def anchors(text):
    return [slug(h) for h in re.findall(r"^#+ (.*)$", without_code(text), re.M)]


def check_links(tally):
    linked = set()
    for page in pages():
        text = without_code(text_of(page))
        own = anchors(text_of(page))
        tally.check(len(own) == len(set(own)), f"{page}: headings have anchors of their own", str([a for a in own if own.count(a) > 1]))
        for target in re.findall(r"\]\(([^)\s]+)\)", re.sub(r"`[^`]*`", "", text)):
            if re.match(r"[a-z]+:", target):
                tally.check(False, f"{page}: a link out of the project", target)
                continue
            path, _, anchor = target.partition("#")
            where = os.path.normpath(os.path.join(os.path.dirname(page), path)) if path else page
            linked.add((page, where))
            if tally.check(os.path.exists(os.path.join(ROOT, where)), f"{page}: {target} exists") and anchor:
                tally.check(anchor in anchors(text_of(where)), f"{page}: {target} has its anchor")
    for page in pages()[1:]:
        tally.check(("README.md", page) in linked, f"README leads to {page}")
    for path in set(re.findall(r"`((?:lib|server|tests|etc|doc|schema|include|clients)/[\w./-]*\w\.\w+)`", "".join(map(text_of, pages())))):
        tally.check(re.search("NAME|FOLDER", path) or os.path.exists(os.path.join(ROOT, path)), f"{path} exists")


# Answers

def read(text):
    return json.loads(text, parse_float=decimal.Decimal)


def number(shown, is_, key):
    if isinstance(is_, bool) or not isinstance(is_, (int, float, decimal.Decimal)):
        return False
    is_ = decimal.Decimal(str(is_))
    if key in LOOSE:
        return abs(is_) <= LOOSE[key] * abs(decimal.Decimal(shown))
    if isinstance(shown, int):
        return is_ == shown or not isinstance(is_, int) and abs(is_ - shown) <= decimal.Decimal("1e-8") * max(1, abs(shown))
    return abs(is_ - shown) <= decimal.Decimal((0, (1,), shown.as_tuple().exponent))


def differences(shown, is_, path="", key=""):
    """Where what is shown is not in the answer."""
    if isinstance(shown, dict):
        if not isinstance(is_, dict):
            yield f"{path} is no object"
            return
        for k, v in shown.items():
            if k not in is_:
                yield f"{path}/{k} is not there"
            else:
                yield from differences(v, is_[k], f"{path}/{k}", k)
    elif isinstance(shown, list):
        if not isinstance(is_, list):
            yield f"{path} is no list"
            return
        cut = shown.index("...") if "..." in shown else None
        head, tail = (shown, []) if cut is None else (shown[:cut], shown[cut + 1:])
        if len(is_) < len(head) + len(tail) or cut is None and len(is_) != len(shown):
            yield f"{path} has {len(is_)} elements"
            return
        for i, v in enumerate(head):
            yield from differences(v, is_[i], f"{path}/{i}", key)
        for i, v in enumerate(tail, len(is_) - len(tail)):
            yield from differences(v, is_[i], f"{path}/{i}", key)
    elif isinstance(shown, bool) or shown is None or isinstance(shown, str):
        if shown != is_ or isinstance(shown, bool) != isinstance(is_, bool):
            yield f"{path} is {is_!r}"
    elif not number(shown, is_, key):
        yield f"{path} is {is_}, shown is {shown}"


def check_comparison(tally):
    """The comparison itself: a spoilt answer must not pass."""
    is_ = read('{"a": "x", "rows": [[0, 0.12345678912], [1, 2.5], [2, 3e-12]], "error_estimate": 2e-9, "n": 3, "t": true}')
    right = ['{"a": "x"}', '{"rows": [[0, 0.12345679], "..."]}', '{"rows": ["...", [2, 0]]}', '{"error_estimate": 1e-9}', '{"n": 3, "t": true}']
    wrong = ['{"a": "y"}', '{"b": 1}', '{"rows": [[0, 0.12345681], "..."]}', '{"rows": [[0, 0.123]]}', '{"error_estimate": 1e-11}', '{"n": 4}', '{"t": 1}', '{"n": true}']
    for texts, good in ((right, True), (wrong, False)):
        for text in texts:
            tally.check((not list(differences(read(text), is_))) == good, f"the comparison {'accepts' if good else 'refuses'} {text}")


# Commands

class Commands:
    """Runs the lines of sh blocks against one daemon."""

    def __init__(self, tally, build, daemon, folder):
        self.tally, self.folder, self.used = tally, folder, set()
        self.words = [("build/", build.rstrip("/") + "/"), ("127.0.0.1:8080", f"127.0.0.1:{daemon.port}"), (" DIR", " " + os.path.join(daemon.state, "sgad")),
                      (" FOLDER", " " + os.path.join(folder, "copy"))]

    def left_out(self, line):
        for i, (pattern, _) in enumerate(NOT_RUN):
            if re.match(pattern, line.split(" #")[0].strip()):
                self.used.add(i)
                return True
        return False

    def run(self, page, block):
        """What the lines that are run print; None: none is."""
        kept, ending = [], None
        for line in block.splitlines():
            if ending is None and self.left_out(line):
                continue
            kept.append(line)
            here = re.search(r"<<\s*'?(\w+)'?", line) if ending is None else None
            ending = here[1] if here else None if line == ending else ending
        if not kept:
            return None
        script = "\n".join(kept)
        for old, new in self.words:
            script = script.replace(old, new)
        run = subprocess.run(["bash", "-e", "-o", "pipefail", "-c", script], capture_output=True, text=True, cwd=ROOT, timeout=300, check=False,
                             env={**os.environ, "no_proxy": "*", "PYTHONDONTWRITEBYTECODE": "1"})
        label = f"{page}: {kept[0][:70]}"
        self.tally.check(run.returncode == 0 and (run.stdout.strip() or "--check" in script), f"{label}: runs", (run.stderr + run.stdout)[-600:])
        self.tally.check('"code":' not in run.stdout or '"verdict":' in run.stdout or '"valid":' in run.stdout, f"{label}: no problem", run.stdout[:400])
        return run.stdout

    def all_used(self):
        for i, (pattern, why) in enumerate(NOT_RUN):
            self.tally.check(i in self.used, f"a line that is not run is there: {pattern}", why)


# One page of five minutes for each kind of user.
STARTS = {f"doc/start-{who}.md" for who in ("curl", "python", "octave", "modelica", "mechanics", "control", "administrator", "teacher")}
# Interpreters of the pages of five minutes, and how they print a line of their own.
SCRIPTS = {"python": (["/usr/bin/python3", "-c"], "print('-----')\n"), "octave": (["octave-cli", "--quiet", "--norc", "--eval"], "disp('-----')\n")}


class Scripts:
    """Runs the blocks of one page in Python or Octave, each after those before it."""

    def __init__(self, tally, daemon):
        self.tally, self.before = tally, {}
        self.env = {**os.environ, "SGA_SERVER": daemon.url(), "PYTHONPATH": os.path.join(ROOT, "clients", "python"), "PYTHONDONTWRITEBYTECODE": "1", "no_proxy": "*"}

    def run(self, page, language, block):
        command, line = SCRIPTS[language]
        before = self.before.get(language, "")
        run = subprocess.run([*command, before + line + block], capture_output=True, text=True, cwd=ROOT, timeout=300, check=False, env=self.env)
        self.tally.check(run.returncode == 0 and run.stdout.strip(), f"{page}: {language} runs", (run.stderr + run.stdout)[-600:])
        self.before[language] = before + block
        return run.stdout.rpartition("-----\n")[2]


def compiles(build, snippet):
    """A snippet of C, as the body of a function."""
    program = f"#include <sga.h>\n#include <stdio.h>\n#include <string.h>\nvoid snippet(const char *text);\nvoid snippet(const char *text)\n{{\n{snippet}}}\n"
    return subprocess.run(["gcc", "-std=c11", "-Wall", "-Wextra", "-Werror", "-fsyntax-only", "-I", os.path.join(ROOT, "lib", "face"), "-x", "c", "-"],
                          input=program, capture_output=True, text=True, check=False)


def check_blocks(tally, build):
    solver = Solver(build, number=decimal.Decimal)
    request_schema = schemas.validator("request")
    with Daemon(build, "--log-level", "warn") as daemon, tempfile.TemporaryDirectory() as folder:
        commands = Commands(tally, build, daemon, folder)
        ran = dict.fromkeys(STARTS, 0)
        for page in pages():
            answer, what, printed = None, "", None       # of the block before
            scripts = Scripts(tally, daemon)
            for language, block in FENCE.findall(text_of(page)):
                ours = language in LANGUAGES or page.startswith("doc/start-") and language in ("text", *SCRIPTS) or (page, language) in (("doc/python.md", "python"), ("doc/python.md", "text"), ("doc/page.md", "text"), ("doc/octave.md", "octave"), ("doc/octave.md", "text"),
                                                                          ("doc/convert.md", "python"), ("doc/julia.md", "julia"), ("doc/convert.md", "text"))      # the suites python, page, octave and convert run these; nothing runs Julia
                tally.check(ours, f"{page}: blocks have a language that is looked at", f"{language!r}: {block[:60]}")
                if language == "sh":
                    said = commands.run(page, block)
                    printed = said
                    ran[page] = ran.get(page, 0) + (said is not None)
                    answer, what = None, block.strip().splitlines()[0]
                    if said and "jq" in block and said[0] in "{[":
                        answer = read(said)
                elif language in SCRIPTS and page.startswith("doc/start-"):
                    printed = scripts.run(page, language, block)
                    ran[page] = ran.get(page, 0) + 1
                elif language == "text" and page.startswith("doc/start-"):
                    tally.check(printed == block, f"{page}: what is printed after {what[:40]}", printed)
                elif language == "c":
                    made = compiles(build, block)
                    tally.check(made.returncode == 0, f"{page}: a snippet compiles", made.stderr[:300])
                elif language == "json":
                    value = read(block)
                    if "system" in value:
                        what = f"{page}: {value['system'].get('name') or value['system']['form']}"
                        fault = schemas.faults(request_schema, json.loads(block))
                        tally.check(not fault, f"{what}: a request", fault)
                        result, problem = solver.solve(block)
                        ran[page] = ran.get(page, 0) + 1
                        answer = {**problem, "type": f"/v1/schema/problem#{problem['code']}"} if problem else result
                    elif tally.check(answer is not None, f"{page}: an answer stands behind its request", block[:80]):
                        wrong = list(differences(value, answer))
                        tally.check(not wrong, f"{page}: the answer to {what}", "; ".join(wrong[:6]))
                        answer = None
        commands.all_used()
        tally.check(STARTS == {page for page in pages() if page.startswith("doc/start-")}, "a page of five minutes for each kind of user")
        for page in sorted(STARTS):
            tally.check(ran[page] >= 2, f"{page}: its blocks are run", str(ran[page]))
        check_types(tally, daemon)


# What programs rely on

def check_types(tally, daemon):
    """`type` of a problem leads to a place in the schema that is served, and the page of errors has it."""
    served = daemon.get("/v1/schema/problem").json()
    own = anchors(text_of("doc/errors.md"))
    places = {d.get("$anchor"): d for d in served["$defs"].values()}
    for code in served["$defs"]["code"]["enum"]:
        tally.check(places.get(code, {}).get("const") == code and "Cure:" in places[code]["description"], f"the schema says what {code} is")
        tally.check(code in own, f"doc/errors.md has {code}")
    problem = daemon.ask("POST", "/v1/solve", {"system": {"form": "equations", "variables": ["x"], "equations": ["x' = z"]}}).json()
    tally.check(problem["type"] == "/v1/schema/problem#unknown_name", "the type of a problem", problem.get("type", problem))


def check_endpoints(tally):
    """The table of the README has every path of the daemon, and no other."""
    paths = re.findall(r'^    X\("([^"]+)",\s*\w+,\s*(\w+),\s*(\w+),\s*(\w+), "[\w ]*"\)', text_of("server/http/routes.c"), re.M)
    section = text_of("README.md").partition("## Endpoints\n")[2].partition("\n## ")[0]
    named, verb = set(), ""
    for word in re.findall(r"`((?:[A-Z]+ )?/[^`]*)`", "\n".join(line.split("|")[1] for line in section.splitlines() if line.startswith("| `"))):
        verb, path = word.split(" ") if " " in word else (verb, word)
        named.add((verb, re.sub(r"/ID\b|(?<=schema)/\w+|(?<=page)/\w+", "/*", path)))
    there = {(verb, path) for path, *handlers in paths for verb, handler in zip(("GET", "POST", "DELETE"), handlers) if handler != "NULL"}
    tally.check(len(there) > 10 and named == there, "the table of endpoints", str(sorted(named ^ there)))


# Figures and repetitions

def check_figures(tally):
    for page in pages():
        if page == "doc/speed.md":
            continue
        text = text_of(page)
        for of, said in SETTINGS:
            if of == page:
                tally.check(said in text, f"{page}: {said!r} is there")
                text = text.replace(said, "")
        found = SPEED.findall(text)
        tally.check(not found, f"{page}: figures of speed stand in doc/speed.md", str(found))


def check_marks(tally):
    """Each block of figures names a part of the benchmarks, and says when it was measured."""
    text = text_of("doc/speed.md")
    marks = re.findall(r"^<!-- figures (\w+)(?:: [^>]*)? -->$(.*?)^<!-- end -->$", text, re.M | re.S)
    known = subprocess.run(["/usr/bin/python3", os.path.join(ROOT, "tests/bench/figures"), "--parts"], capture_output=True, text=True, check=False)
    parts = known.stdout.split()
    tally.check(sorted(name for name, _ in marks) == sorted(parts) and len(parts) > 10, "doc/speed.md has each part of the benchmarks", known.stderr[:300])
    for name, block in marks:
        tally.check("| --- |" in block, f"doc/speed.md: {name} has figures")
    outside = SPEED.findall(re.sub(r"^<!-- figures.*?^<!-- end -->$", "", text, flags=re.M | re.S))
    tally.check(not outside, "doc/speed.md: figures are written by the command", str(outside))


def check_repetitions(tally):
    seen = {}
    for page in pages():
        prose = re.sub(r"^\|.*$|^#.*$|^<!--.*?-->$", "\n", without_code(text_of(page)), flags=re.M)
        for paragraph in re.split(r"\n\s*\n|\n- |\n\d\. ", prose):
            for sentence in re.split(r"(?<=[.:;]) ", " ".join(paragraph.split())):
                if len(sentence) > 60:
                    seen.setdefault(sentence, []).append(page)
    for sentence, where in seen.items():
        tally.check(len(where) == 1, "a sentence stands once", f"{where}: {sentence[:120]}")


def check_made(tally):
    made = subprocess.run(["/usr/bin/python3", os.path.join(ROOT, "doc", "make.py"), "--check"], capture_output=True, text=True, check=False)
    tally.check(made.returncode == 0, "pages that are made are current", made.stdout + made.stderr)
    for page in ("doc/request.md", "doc/answer.md", "doc/errors.md"):
        empty = re.findall(r"^(\| `[^|]*`(?! \|\s*\|$).*)\|\s*\|$", text_of(page), re.M)
        tally.check(not empty, f"{page}: every member has a meaning", str(empty[:5]))
    lines = text_of("README.md").count("\n")
    tally.check(lines <= MOST_LINES, f"README has at most {MOST_LINES} lines", str(lines))


def check_homes(tally):
    """Where a refusal says that a misplaced member stands, it does stand (lib/request/reader.c)."""
    schema, source = json.loads(text_of("schema/request.json")), text_of("lib/request/reader.c")

    places = {home: [schema["properties"][home], *schema["$defs"].values()] if home == "system" else [schema["properties"][home]] for home in schema["properties"]}

    def has(home, name):
        nodes = (schema["$defs"][node["$ref"].split("/")[-1]] if "$ref" in node else node for node in places[home])
        return any(name in node.get("properties", {}) and (home != "system" or {"form", name} <= set(node["properties"])) for node in nodes)
    homes = re.findall(r'\{ "(\w+)", "(\w+)" \}', source[source.index("homes[] = {"):source.index("sizeof homes")])
    tally.check(len(homes) >= 15, "homes of members are found", str(homes))
    for name, home in homes:
        tally.check(has(home, name), f"{name} is a member of {home}")
    top = re.findall(r'"(\w+)"', source[source.index("top[] = {"):source.index("sizeof top")])
    tally.check(len(top) >= 10 and set(top) <= set(schema["properties"]), "members of a request", str(set(top) - set(schema["properties"])))


def main():
    tally = Tally("docs")
    build = build_folder()
    if not shutil.which("curl") or not shutil.which("jq"):
        tally.check(False, "curl and jq are there")
    check_comparison(tally)
    check_links(tally)
    check_made(tally)
    check_homes(tally)
    check_endpoints(tally)
    check_figures(tally)
    check_marks(tally)
    check_repetitions(tally)
    check_blocks(tally, build)
    return tally.end()


if __name__ == "__main__":
    sys.exit(main())
