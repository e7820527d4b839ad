"""What can be said of the Julia client without a Julia: julia_check.py BUILD_DIR

Its blocks and brackets close, each path and method that it asks for is in the service's description, what it exports is defined and documented, and the
members that it reads are in the schemas."""
import json
import os
import re

from tally import ROOT, Tally

OPEN = re.compile(r"^\s*(?:module|struct|function|if|for|while|try|let|begin|macro|quote|mutable struct)\b|\bdo\b(?=\s*(?:\w+\s*)?$)|=\s*if\b|=\s*begin\b")


def bare(text):
    """Without texts and comments."""
    text = re.sub(r'""".*?"""', '""', text, flags=re.S)
    text = re.sub(r'"(?:\\\\.|[^"\\\\])*"', '""', text)
    return re.sub(r"#.*", "", re.sub(r"'.'", "' '", text))


def main():
    tally = Tally("julia")
    with open(os.path.join(ROOT, "clients", "julia", "SgaClient.jl"), encoding="utf-8") as f:
        text = f.read()
    depth, wrong = 0, []
    for number, line in enumerate(bare(text).split("\n"), 1):
        depth += bool(OPEN.search(line)) - len(re.findall(r"^\s*end\b", line))
        if depth < 0 or (line and not line.startswith((" ", "end", ")")) and depth > 2):
            wrong.append((number, line))
    tally.check(depth == 0 and not wrong, "blocks close", (depth, wrong[:3]))
    plain = bare(text)
    tally.check(all(plain.count(a) == plain.count(b) for a, b in ("()", "[]", "{}")), "brackets close")
    with open(os.path.join(ROOT, "schema", "openapi.json"), encoding="utf-8") as f:
        paths = json.load(f)["paths"]
    asked = re.findall(r'ask\(client, "(\w+)", "([^"]+)"( \* id(?: \* "([^"]*)")?)?', text)
    tally.check(len(asked) == text.count("ask(client, ") == 5, "every place that asks is looked at", (len(asked), text.count("ask(client, ")))
    for method, path, with_id, rest in asked:
        known = path + ("{id}" if with_id else "") + (rest or "").split("?")[0]
        tally.check(method.lower() in paths.get(known, {}), f"{method} {known} is the service's", list(paths))
        for name in re.findall(r"[?&](\w+)=", rest or ""):
            tally.check(any(p["name"] == name for p in paths[known]["get"]["parameters"]), f"{known} takes {name}")
    exported = re.search(r"^export (.*)$", text, re.M)[1].split(", ")
    with open(os.path.join(ROOT, "doc", "julia.md"), encoding="utf-8") as f:
        page = f.read()
    for name in exported:
        tally.check(re.search(rf"^(?:function {name}\(|{name}\(|struct {name}\b)", text, re.M), f"{name} is defined")
        tally.check(re.search(rf"\b{name}\b", page), f"{name} is documented")
    with open(os.path.join(ROOT, "schema", "result.json"), encoding="utf-8") as f:
        members = json.load(f)["properties"]["trajectory"]["properties"]
    tally.check({"columns", "rows"} <= set(members), "members of a trajectory")
    return tally.end()


if __name__ == "__main__":
    raise SystemExit(main())
