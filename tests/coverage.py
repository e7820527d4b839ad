"""Which lines were run, by folder: coverage.py BUILD_DIR [--write | FOLDER]

Reads what a build with --coverage counted (make coverage). With a folder: the functions in it that never ran. --write puts the table
into doc/developer.md. Lines of the daemon's children are not counted: their sandbox lets them write no files.
"""
import collections
import gzip
import json
import os
import subprocess
import sys
import tempfile

import developer_figures

ROOT = os.path.dirname(os.path.dirname(os.path.abspath(__file__)))


def counted(build):
    """By source file: {line: runs}, and {function: runs}."""
    lines, functions = collections.defaultdict(dict), collections.defaultdict(dict)
    notes = [os.path.join(at, f) for at, _, files in os.walk(build) for f in files if f.endswith(".gcno") and "/unit/" not in at + "/"]
    with tempfile.TemporaryDirectory() as here:
        for k in range(0, len(notes), 50):
            subprocess.run(["gcov", "--json-format", "--preserve-paths", *map(os.path.abspath, notes[k:k + 50])], cwd=here, capture_output=True, check=False)
        for name in os.listdir(here):
            with gzip.open(os.path.join(here, name), "rt", encoding="utf-8") as f:
                for file in json.load(f)["files"]:
                    path = os.path.relpath(os.path.join(ROOT, file["file"]), ROOT)
                    for line in file["lines"]:
                        lines[path][line["line_number"]] = lines[path].get(line["line_number"], 0) + line["count"]
                    for function in file["functions"]:
                        functions[path][function["name"]] = functions[path].get(function["name"], 0) + function["execution_count"]
    return lines, functions


def main():
    lines, functions = counted(sys.argv[1])
    folders = collections.defaultdict(lambda: [0, 0, 0, 0])
    for path, found in lines.items():
        if path.startswith(("..", "tests", "build")):
            continue
        at = folders[os.path.dirname(path)]
        at[0] += len(found)
        at[1] += sum(n > 0 for n in found.values())
        at[2] += len(functions[path])
        at[3] += sum(n > 0 for n in functions[path].values())
    table = ["| folder | lines | run | functions | run |", "| --- | --- | --- | --- | --- |"]
    for folder, (a, b, c, d) in sorted(folders.items()) + [("all", [sum(v[k] for v in folders.values()) for k in range(4)])]:
        table.append(f"| `{folder}` | {a} | {100 * b / max(a, 1):.0f} % | {c} | {100 * d / max(c, 1):.0f} % |")
    print("\n".join(table))
    if sys.argv[2:] == ["--write"]:
        return 0 if developer_figures.rewrite("coverage", table) else 1
    for path in sorted(functions) if len(sys.argv) > 2 else []:
        if path.startswith(sys.argv[2]):
            never = [name for name, n in functions[path].items() if not n]
            if never:
                print(f"{path}: {', '.join(never)}")
    return 0 if folders else 1


if __name__ == "__main__":
    sys.exit(main())
