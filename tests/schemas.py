"""The project's JSON Schemas, loaded for validation."""
import json
import os

from jsonschema import Draft202012Validator, RefResolver

from tally import ROOT

FOLDER = os.path.join(ROOT, "schema")
NAMES = ("request", "result", "problem", "check")


def load(name):
    with open(os.path.join(FOLDER, name + ".json"), encoding="utf-8") as f:
        return json.load(f)


def store():
    out = {}
    for n in NAMES:
        s = load(n)
        out[s["$id"]] = s
    out["/openapi.json"] = load("openapi")
    return out


def validator(name):
    """Of a schema file, or of a component of the OpenAPI description ("openapi#Job")."""
    documents = store()
    if name.startswith("openapi#"):
        schema = {"$ref": "/openapi.json#/components/schemas/" + name[8:]}
        return Draft202012Validator(schema, resolver=RefResolver("", schema, store=documents))
    schema = load(name)
    return Draft202012Validator(schema, resolver=RefResolver(schema["$id"], schema, store=documents))


def faults(check, value, most=3):
    """The first few faults as one text; "" if there are none."""
    out = []
    for e in check.iter_errors(value):
        while e.context:    # the branch of an anyOf that came furthest
            e = max(e.context, key=lambda c: len(c.absolute_path))
        out.append(f"/{'/'.join(map(str, e.absolute_path))}: {e.message[:200]}")
        if len(out) == most:
            break
    return "; ".join(out)
