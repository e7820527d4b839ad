#!/usr/bin/python3
"""Makes the reference pages: doc/make.py [--check]

Each page doc/NAME.md that has a part doc/parts/NAME.md is that text with its lines and words in braces filled in:

    {{members request:/$defs/trajectory}}            a table of the members of an object: type, default, meaning
    {{members result:/properties/trajectory events/items}}   and under them those of the objects named
    {{count request:/$defs/tables/maxProperties}}    a number of a schema, in digits
    {{constant lib/expr/parse.c DEFAULT_DEPTH}}      a number of the sources; {{setting NAME}} of the daemon, {{limit NAME}} of limits.def
    {{errors}} {{warnings}} {{limits}}               the tables of lib/base (error.h, warning.def, limits.def)
    {{forms}} {{functions}}                          the forms of a system; the functions of expressions (lib/expr/expr.h)

The schemas, those tables and doc/parts/errors.json (cause and cure of each code) are the only sources. The anchors of
schema/problem.json, which the member `type` of a problem points to, are made from the same table. With --check nothing is written:
what would change is named, and the exit status is 1.
"""
import json
import os
import re
import sys

ROOT = os.path.dirname(os.path.dirname(os.path.abspath(__file__)))
DOC = os.path.join(ROOT, "doc")
NOTE = "<!-- Made by doc/make.py from doc/parts/{}, schema/ and the tables of lib/base. Edit those, then run it. -->\n\n"
COMMON = ("name", "form", "parameters", "time", "tables")     # of every system: they have one table


def text_of(*path):
    with open(os.path.join(ROOT, *path), encoding="utf-8") as f:
        return f.read()


def schemas():
    names = ("request", "result", "problem", "openapi")
    return {name: json.loads(text_of("schema", name + ".json")) for name in names}


# Schemas

def at(document, pointer):
    node = document
    for part in pointer.split("/")[1:]:
        part = part.replace("~1", "/").replace("~0", "~")
        node = node[int(part)] if isinstance(node, list) else node[part]
    return node


class Schema:
    """One document; nodes are followed through $ref, within it and into the others."""

    def __init__(self, documents, name):
        self.documents, self.name, self.document = documents, name, documents[name]

    def target(self, ref):
        home, _, pointer = ref.partition("#")
        name = home.rsplit("/", 1)[-1].replace(".json", "") if home else self.name
        other = self if name == self.name else Schema(self.documents, name)
        return other, pointer

    def said(self, node, key):
        while key not in node and "$ref" in node:
            schema, pointer = self.target(node["$ref"])
            return schema.said(at(schema.document, pointer), key)
        return node.get(key)

    def object(self, node):
        """The object that holds members, through lists and references; None: there is none."""
        if "properties" in node:
            return node
        if "$ref" in node:
            schema, pointer = self.target(node["$ref"])
            return schema.object(at(schema.document, pointer))
        for key in ("items", "additionalProperties"):
            if isinstance(node.get(key), dict):
                return self.object(node[key])
        for choice in node.get("anyOf", []) + node.get("oneOf", []):
            found = self.object(choice)
            if found:
                return found
        return None

    NAMED = {"expression": "expression", "expressions": "expressions", "names": "names", "name": "name", "variableName": "name", "matrix": "matrix",
             "denseMatrix": "matrix, rows only", "sparseMatrix": "matrix, entries", "values": "values by name", "equation": "equation", "count": "whole number",
             "numbers": "numbers by name", "numberOrNull": "number or null", "truth": "true, false or null", "field": "expressions by name",
             "fieldTexts": "expressions by name", "expressionMatrix": "matrix", "operatorMatrix": "matrix of operators", "operator": "operator",
             "parameters": "values by name", "samples": "numbers", "tables": "tables by name", "systemName": "text", "timeName": "name", "Time": "time",
             "Id": "text", "equationOrLoop": "equation or loop", "expressionOrLoop": "expression or loop", "sizes": "whole numbers", "coefficients": "whole numbers, as texts"}
    PLAIN = {"string": "text", "number": "number", "integer": "whole number", "boolean": "true or false", "object": "object", "array": "list", "null": "null"}

    def kind(self, node):
        """A few words for the table."""
        if "$ref" in node:
            name = node["$ref"].rsplit("/", 1)[-1]
            if node["$ref"] == "#":
                return "answer"
            if name in self.NAMED:
                return self.NAMED[name]
            schema, pointer = self.target(node["$ref"])
            if not pointer:
                return name
            return schema.kind(at(schema.document, pointer))
        if len(node.get("enum", ())) > 12:
            return "text"
        if "enum" in node:
            return ", ".join(f"`{json.dumps(v)}`" for v in node["enum"])
        if "const" in node:
            return f"`{json.dumps(node['const'])}`"
        for key in ("anyOf", "oneOf"):
            if key in node:
                kinds = list(dict.fromkeys(self.kind(n) for n in node[key]))
                if len(kinds) > 1 and f"list of {kinds[0]}" in kinds:
                    kinds.remove(f"list of {kinds[0]}")
                    kinds[0] += ", one or a list"
                return " or ".join(kinds)
        types = node.get("type", "object")
        if isinstance(types, list):
            return " or ".join(self.kind({**node, "type": t}) for t in types)
        if types == "array" and isinstance(node.get("items"), dict) and node["items"]:
            inner = self.kind(node["items"])
            return "list of " + {"object": "objects", "name": "names", "text": "texts", "whole number": "whole numbers", "number": "numbers",
                                 "expression": "expressions"}.get(inner, inner)
        if types == "object" and isinstance(node.get("additionalProperties"), dict) and "properties" not in node:
            return "by name: " + self.kind(node["additionalProperties"])
        return self.PLAIN[types]

    def rows(self, node, prefix, inside, skip=()):
        found = self.object(node)
        for name, member in found["properties"].items():
            if name in skip:
                continue
            default = self.said(member, "default")
            first = "required" if prefix == "" and name in found.get("required", []) else "" if default is None else f"`{json.dumps(default)}`"
            yield f"{prefix}{name}", self.kind(member), first, self.said(member, "description") or ""
            if name in inside:
                deeper = inside[name]
                object_ = self.object(member)
                if object_ is None:
                    raise SystemExit(f"doc/make.py: {prefix}{name} has no members")
                yield from self.rows(member, f"{prefix}{name}{'[]' if self.listed(member) else ''}.", deeper)

    def listed(self, node):
        if "$ref" in node:
            schema, pointer = self.target(node["$ref"])
            return schema.listed(at(schema.document, pointer))
        return node.get("type") == "array" or node.get("type") == ["array", "null"]


def cell(text):
    return re.sub(r"\s+", " ", str(text)).replace("|", "\\|")


def prose(text):
    """Stars of products are no emphasis."""
    return cell(text).replace("*", "\\*").replace("<", "&lt;")


def table(head, rows):
    rows = list(rows)
    keep = [i for i in range(len(head)) if i == 0 or any(r[i] for r in rows)]
    lines = ["| " + " | ".join(head[i] for i in keep) + " |", "|" + " --- |" * len(keep)]
    lines += ["| " + " | ".join(r[i] for i in keep) + " |" for r in rows]
    return "\n".join(lines)


def nested(words):
    """`events events.values` as a tree of the members whose own members are listed."""
    tree = {}
    for word in words:
        at_ = tree
        for part in word.split("."):
            at_ = at_.setdefault(part, {})
    return tree


def members(documents, place, *words):
    name, _, pointer = place.partition(":")
    schema = Schema(documents, name)
    skip = {w[1:] for w in words if w.startswith("-")}
    if "-common" in words:
        skip |= set(COMMON)
    only = [w[1:] for w in words if w.startswith("+")]
    inside = nested(w for w in words if w[0] not in "-+")
    rows = list(schema.rows(at(schema.document, pointer), "", inside, skip))
    if only:
        rows = [r for r in rows if re.split(r"[.\[]", r[0])[0] in only]
        missing = set(only) - {re.split(r"[.\[]", r[0])[0] for r in rows}
        if missing:
            raise SystemExit(f"doc/make.py: {place} has no {missing}")
    required = name == "request"
    head = ("member", "kind", "default" if required else "", "meaning")
    return table(head, [(f"`{a}`", cell(b), c if required else "", prose(d)) for a, b, c, d in rows])


def count(documents, place):
    name, _, pointer = place.partition(":")
    value = at(documents[name], pointer)
    return f"{value:,}" if isinstance(value, int) else str(value)


# Numbers of the sources

def constant(_, path, name):
    """NAME = number, or a << b."""
    found = re.search(rf"\b{name} = (\d+)(?: << (\d+))?", text_of(path))
    if not found:
        raise SystemExit(f"doc/make.py: {path} has no {name}")
    return f"{int(found[1]) << int(found[2] or 0):,}"


def setting(_, name):
    """The default of a setting in bytes."""
    found = re.search(rf'\("{name}", \w+, (\d+) \* MB,', text_of("server", "settings", "settings.c"))
    if not found:
        raise SystemExit(f"doc/make.py: there is no setting {name} in MB")
    return f"{found[1]} MiB"


def limit(_, name):
    return next(f"{int(row[1]):,}" for row in definitions("limits.def") if row[0] == name)


# The tables of lib/base

def strings(text):
    return "".join(json.loads(s) for s in re.findall(r'"(?:[^"\\]|\\.)*"', text))


def error_rows():
    """(code, status, title) in the table's order, without `ok`."""
    rows = re.findall(r'X\(\w+,\s*"(\w+)",\s*(\d+),\s*("(?:[^"\\]|\\.)*")\)', text_of("lib", "base", "error.h"))
    return [(code, int(status), json.loads(title)) for code, status, title in rows if code != "ok"]


def causes():
    said = json.loads(text_of("doc", "parts", "errors.json"))
    codes = [code for code, _, _ in error_rows()]
    if set(said) != set(codes):
        raise SystemExit(f"doc/parts/errors.json: without cause and cure: {sorted(set(codes) - set(said))}; no code: {sorted(set(said) - set(codes))}")
    return said


def errors(_):
    said = causes()
    out = []
    for code, status, title in error_rows():
        cause, cure = said[code]
        out.append(f"### {code}\n\n{status}. {title}.\n\n- Cause: {cause}\n- Cure: {cure}")
    return "\n\n".join(out)


def error_list(_):
    said = {}
    for code, status, _ in error_rows():
        said.setdefault(status, []).append(f"[`{code}`](#{code})")
    return table(("status", "codes"), [(str(s), ", ".join(c)) for s, c in sorted(said.items())])


def definitions(name):
    """Rows of a .def table, comments left out: lists of arguments, texts joined."""
    text = re.sub(r"/\*.*?\*/", "", text_of("lib", "base", name), flags=re.S)
    for row in re.findall(r"^X\(((?:[^\"()]|\"(?:[^\"\\]|\\.)*\")*)\)", text, flags=re.M):
        parts = re.findall(r'(?:"(?:[^"\\]|\\.)*"\s*)+|[^,"\s][^,"]*', row)
        yield [strings(p) if p.startswith('"') else p.strip() for p in parts]


def warnings(_):
    return table(("`code`", "what it says"), [(f"`{code}`", prose(text)) for _, code, text in definitions("warning.def")])


def limits(_):
    codes = {symbol: code for symbol, code, _ in definitions("warning.def")}
    return table(("limit", "value", "warning", "what is cut", "why this value"),
                 [(f"`{name}`", f"{int(value):,}", f"`{codes[w]}`", prose(what), prose(why)) for name, value, w, what, why in definitions("limits.def")])


def functions(_):
    """Names of functions, from the table of operators."""
    rows = re.findall(r'X\(\w+,\s*"([a-z]\w*)",\s*([12]),', text_of("lib", "expr", "expr.h"))
    return " ".join(name for name, _ in rows)


def forms(documents):
    defs = documents["request"]["$defs"]
    return table(("`form`", "the system"), [(f"[`{name}`](#{name})", prose(defs[name]["title"])) for name in defs["system"]["properties"]["form"]["enum"]])


FILLS = {"functions": functions, "forms": forms, "members": members, "count": count, "errors": errors, "error_list": error_list, "warnings": warnings, "limits": limits, "constant": constant, "setting": setting,
         "limit": limit}


def filled(documents, text):
    def fill(m):
        word, *rest = m[1].split()
        return FILLS[word](documents, *rest)
    return re.sub(r"\{\{([^{}]+)\}\}", fill, text)


def problem_schema():
    """schema/problem.json with an anchor for each code: `type` is /v1/schema/problem#CODE."""
    document = json.loads(text_of("schema", "problem.json"))
    said = causes()
    document["$defs"] = {"code": {"enum": [code for code, _, _ in error_rows()]}}
    for code, status, title in error_rows():
        cause, cure = (re.sub(r"\[([^\]]*)\]\([^)]*\)", r"\1", text) for text in said[code])
        document["$defs"][code] = {"$anchor": code, "title": title, "description": f"Status {status}. Cause: {cause} Cure: {cure}", "const": code}
    return json.dumps(document, indent=2, ensure_ascii=False) + "\n"


def pages():
    """(path, text) of everything that is made."""
    yield os.path.join("schema", "problem.json"), problem_schema()
    documents = schemas()
    for part in sorted(os.listdir(os.path.join(DOC, "parts"))):
        if part.endswith(".md"):
            yield os.path.join("doc", part), NOTE.format(part) + filled(documents, text_of("doc", "parts", part))


def main():
    check, stale = "--check" in sys.argv[1:], []
    for path, text in pages():
        where = os.path.join(ROOT, path)
        if not os.path.exists(where) or text_of(path) != text:
            stale.append(path)
            if not check:
                with open(where, "w", encoding="utf-8") as f:
                    f.write(text)
    for path in stale:
        print(f"{path}: {'is not what its sources make; run doc/make.py' if check else 'made'}")
    return 1 if check and stale else 0


if __name__ == "__main__":
    sys.exit(main())
