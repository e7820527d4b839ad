"""The schemas themselves: schema_check.py BUILD_DIR

They are valid, their examples and those of the project fit them, what must not pass does
not, and the list of error codes is the one table of lib/base/error.h.
"""
import copy
import glob
import json
import os
import re
import sys

from jsonschema import Draft202012Validator

import cases
import schemas
from tally import ROOT, Tally

BAD_REQUESTS = {
    "no system": {},
    "no form": {"system": {"variables": ["x"]}},
    "unknown form": {"system": {"form": "magic"}},
    "unknown member": {"system": {"form": "equations", "variables": ["x"], "equations": ["x' = 1"]}, "wants": []},
    "unknown member of system": {"system": {"form": "equations", "variables": ["x"], "equations": ["x' = 1"], "A": 1}},
    "unknown want": {"system": {"form": "equations", "variables": ["x"], "equations": ["x' = 1"]}, "want": ["all"]},
    "no alpha": {"system": {"form": "quasilinear", "variables": ["x"], "A": [[1]]}},
    "a name with a blank": {"system": {"form": "quasilinear", "variables": ["x y"], "A": [[1]], "alpha": [1]}},
    "duplicate variables": {"system": {"form": "quasilinear", "variables": ["x", "x"], "A": [[1, 1]], "alpha": [1]}},
    "object as expression": {"system": {"form": "quasilinear", "variables": ["x"], "A": [[{}]], "alpha": [1]}},
    "short entry": {"system": {"form": "quasilinear", "variables": ["x"],
                               "A": {"rows": 1, "cols": 1, "entries": [[0, 0]]}, "alpha": [1]}},
}
OTHER_FORMS = [
    {"form": "linear", "variables": ["x"], "A": [[1]], "B": [[2]], "C": [[1]], "inputs": ["u"], "D": [[0]]},
    {"form": "control", "variables": ["x"], "inputs": ["u"], "F": ["x"], "G": [["1"]], "constraints": ["x"]},
    {"form": "hamiltonian", "variables": ["q", "p"], "hamiltonian": "p^2/2 + q^2/2", "restrict": ["q"]},
    {"form": "lagrangian", "coordinates": ["q"], "lagrangian": "q'^2/2", "second_order": False, "holonomic": ["q"]},
    {"form": "mechanical", "coordinates": ["x"], "masses": [1], "forces": ["-x"], "constraints": ["x'"]},
    {"form": "operator", "unknowns": ["y"], "coefficients": [[["t"]], [["1"]]], "sources": ["e"]},
]


def error_table():
    with open(os.path.join(ROOT, "lib", "base", "error.h"), encoding="utf-8") as f:
        return dict(re.findall(r'X\(\w+,\s*"(\w+)",\s*(\d+)', f.read()))


def examples(node, path=""):
    """Every schema with examples inside a document."""
    if isinstance(node, dict):
        if "examples" in node and isinstance(node["examples"], list):
            yield path, node["examples"]
        for k, v in node.items():
            yield from examples(v, f"{path}/{k}")


def references(node):
    if isinstance(node, dict):
        if isinstance(node.get("$ref"), str):
            yield node["$ref"]
        for v in node.values():
            yield from references(v)
    elif isinstance(node, list):
        for v in node:
            yield from references(v)


def resolves(ref, home, documents):
    base, _, pointer = ref.partition("#")
    node = documents.get(base or home)
    for part in pointer.split("/")[1:]:
        node = node.get(part) if isinstance(node, dict) else None
    return node is not None


def check_documents(tally):
    documents = schemas.store()
    for name in schemas.NAMES:
        try:
            Draft202012Validator.check_schema(schemas.load(name))
            tally.check(True, name)
        except Exception as e:
            tally.check(False, f"{name} is a schema", str(e)[:300])
        for example in schemas.load(name).get("examples", []):
            fault = schemas.faults(schemas.validator(name), example)
            tally.check(not fault, f"example of {name}", fault)
    for home, document in documents.items():
        for ref in references(document):
            tally.check(resolves(ref, home, documents), f"{home}: {ref} resolves")


def check_openapi(tally):
    document = schemas.load("openapi")
    tally.check(document["openapi"].startswith("3.1."), "OpenAPI 3.1")
    for name, schema in document["components"]["schemas"].items():
        Draft202012Validator.check_schema(schema)
        for example in schema.get("examples", []):
            fault = schemas.faults(schemas.validator("openapi#" + name), example)
            tally.check(not fault, f"example of {name}", fault)
    wanted = {"/v1/jobs": "post get", "/v1/jobs/{id}": "get delete", "/v1/jobs/{id}/events": "get",
              "/v1/jobs/{id}/trajectory": "get", "/v1/jobs/{id}/tradeoff": "get", "/v1/jobs/{id}/code": "get", "/v1/solve": "post", "/v1/check": "post", "/v1/jobs/{id}/request": "get", "/v1/schema/{name}": "get", "/openapi.json": "get",
              "/healthz": "get", "/readyz": "get", "/metrics": "get", "/version": "get"}
    for path, verbs in wanted.items():
        for verb in verbs.split():
            operation = document["paths"].get(path, {}).get(verb)
            tally.check(operation and operation.get("responses"), f"{verb} {path} is described")
            media = (operation or {}).get("requestBody", {}).get("content", {}).get("application/json", {})
            if "example" in media:
                fault = schemas.faults(schemas.validator("request"), media["example"])
                tally.check(not fault, f"example of {verb} {path}", fault)


def check_requests(tally):
    request = schemas.validator("request")
    for case in cases.load([]):
        if "error" not in case["expect"]:
            fault = schemas.faults(request, case["request"])
            tally.check(not fault, f"request of the case {case['name']}", fault)
    for path in sorted(glob.glob(os.path.join(ROOT, "etc", "examples", "*.json"))):
        with open(path, encoding="utf-8") as f:
            fault = schemas.faults(request, json.load(f))
        tally.check(not fault, os.path.basename(path), fault)
    for system in OTHER_FORMS:
        fault = schemas.faults(request, {"system": system})
        tally.check(not fault, f"form {system['form']}", fault)
        broken = copy.deepcopy(system)
        broken["surplus"] = 1
        tally.check(schemas.faults(request, {"system": broken}), f"form {system['form']} refuses other members")
    for name, bad in BAD_REQUESTS.items():
        tally.check(schemas.faults(request, bad), f"the request schema refuses: {name}")


def main():
    tally = Tally("schema")
    check_documents(tally)
    check_openapi(tally)
    check_requests(tally)
    codes = set(error_table()) - {"ok"}
    listed = schemas.load("problem")["$defs"]["code"]["enum"]
    tally.check(len(listed) == len(set(listed)) and set(listed) == codes, "error codes",
                f"only in schema: {sorted(set(listed) - codes)}; only in error.h: {sorted(codes - set(listed))}")
    problem, result = schemas.validator("problem"), schemas.validator("result")
    tally.check(schemas.faults(problem, {"type": "x", "title": "x", "status": 400, "code": "no_such_code", "detail": "x"}),
                "the problem schema refuses an unknown code")
    warned = re.findall(r'^X\(\w+, "(\w+)"', open(os.path.join(ROOT, "lib", "base", "warning.def"), encoding="utf-8").read(), re.M)
    tally.check(warned == schemas.load("result")["properties"]["warnings"]["items"]["properties"]["code"]["enum"], "warning codes", str(warned))
    limits = re.findall(r'^X\((\w+), ', open(os.path.join(ROOT, "lib", "base", "limits.def"), encoding="utf-8").read(), re.M)
    source = "".join(open(p, encoding="utf-8").read() for p in glob.glob(os.path.join(ROOT, "lib", "**", "*.[ch]"), recursive=True))
    for name in limits:
        tally.check(f"SGA_LIMIT_{name}" in source, f"the limit {name} raises its warning somewhere")
        tally.check(f"SGA_MOST_{name}" in source, f"the limit {name} is used by its name")
    tally.check(len(limits) == len(set(limits)), "each limit stands once", str(limits))
    with open(os.path.join(ROOT, "doc", "limits.md"), encoding="utf-8") as f:
        listed = f.read()
    tally.check(all(f"| `{code}` |" in listed for code in warned), "doc/limits.md lists the warning codes", str(warned))
    tally.check(schemas.faults(result, {"verdict": "unique"}), "an answer without warnings is refused")
    tally.check(schemas.faults(result, {"verdict": "unique", "equilibrium": True}), "equilibrium beside unique is refused")
    tally.check(schemas.faults(result, {"verdict": "unique", "dimensions": {"ambient": 1, "generations": [], "final": None}}),
                "final null beside unique is refused")
    return tally.end()


if __name__ == "__main__":
    sys.exit(main())
