"""What the house measures: house.py [--write | --reach [FILE...]]

Lines of files and functions, by folder; exports (functions that a header declares) of each file; reach: the project's headers that a file pulls in,
directly or not. --write puts its last rows into doc/developer.md; --reach lists files that reach more than MOST, farthest first, with what they include, or what
the files named reach. Ends with 1 where headers include each other in a circle, or two have one name.
"""
import collections
import os
import re
import sys

import developer_figures
from tally import ROOT

MOST = 15
INCLUDE = re.compile(r'^#include "([^"]+\.h)"', re.M)
FUNCTION = re.compile(r"^(?!typedef|struct [^()]*\{|enum|union|#)[A-Za-z][^;{}]*\)\n\{\n(.*?)^\}", re.M | re.S)


def read():
    """The text of each file of lib/, server/ and clients/."""
    texts = {}
    for top in ("lib", "server", "clients"):
        for at, _, names in os.walk(os.path.join(ROOT, top)):
            for name in names:
                if name.endswith((".c", ".h")):
                    with open(os.path.join(at, name), encoding="utf-8") as f:
                        texts[os.path.relpath(os.path.join(at, name), ROOT)] = f.read()
    return texts


def reach(path, include):
    seen, waiting = set(), list(include[path])
    while waiting:
        h = waiting.pop()
        if h not in seen:
            seen.add(h)
            waiting += include[h]
    return seen


def at_part(values, part):
    values = sorted(values)
    return values[min(len(values) - 1, int(part * len(values)))] if values else 0


def three(values):
    return f"{at_part(values, 0.5)} / {at_part(values, 0.95)} / {max(values, default=0)}"


def exports(text, declared):
    """Functions of a file that some header declares."""
    return sum(name in declared for name in re.findall(r"^(?!static)[A-Za-z][\w *]*?\b(\w+)\([^;{}]*\)\n\{", text, re.M))


def main():
    texts = read()
    headers = collections.defaultdict(list)
    for path in texts:
        if path.endswith(".h"):
            headers[os.path.basename(path)].append(path)
    include = {path: [headers[h][0] for h in INCLUDE.findall(text) if h in headers] for path, text in texts.items()}
    wrong = [f"two headers are called {h}" for h, paths in headers.items() if len(paths) > 1]
    wrong += [f"{path} includes itself" for path in texts if path in reach(path, include)]
    reached = {path: reach(path, include) for path in texts if path.endswith(".c")}
    far = sorted((path for path in reached if len(reached[path]) > MOST), key=lambda path: -len(reached[path]))
    if "--reach" in sys.argv:
        named = sys.argv[sys.argv.index("--reach") + 1:]
        for path in named or far:
            print(len(reached[path]), path, *(sorted(map(os.path.basename, reached[path])) if named else map(os.path.basename, include[path])))
    declared = {name for path, text in texts.items() if path.endswith(".h") for name in re.findall(r"\b(\w+)\(", text)}
    folders = collections.defaultdict(list)
    for path in texts:
        if path.endswith(".c"):
            at = os.path.dirname(path).split("/")
            folders["/".join(at[:3 if at[:2] in (["lib", "run"], ["lib", "traj"]) else 2])].append(path)
            folders["all"].append(path)
            folders[f"`{at[0]}/`, all"].append(path)
    rows = ["| folder | lines | of a file | of a function | reach | above 15 | exports |", "| --- | --- | --- | --- | --- | --- | --- |"]
    for folder in sorted(folders, key=lambda f: (f == "all", "all" in f, f)):
        paths = folders[folder]
        inside = [path for path in texts if folder == "all" or (folder[0] == "`" and path.startswith(folder[1:folder.index("/") + 1])) or any(os.path.dirname(path) == os.path.dirname(p) for p in paths)]
        functions = [body.count("\n") + 3 for path in paths for body in FUNCTION.findall(texts[path])]
        lengths, outside = [texts[path].count("\n") for path in inside], [exports(texts[path], declared) for path in paths]
        name = folder if folder == "all" or folder[0] == "`" else f"`{folder}`"
        rows.append(f"| {name} | {sum(lengths)} | {three(lengths)} | {three(functions)} | {at_part([len(reached[p]) for p in paths], 0.5)} / {max(len(reached[p]) for p in paths)} "
                    f"| {sum(p in far for p in paths)} | {three(outside)} |")
    if "--write" in sys.argv:
        developer_figures.rewrite("house", rows[:2] + [row for row in rows if re.match(r"\| (`\w+/`, )?all ", row)])
    elif "--reach" not in sys.argv:
        print("\n".join(rows))
    print("\n".join(wrong) or f"{len(far)} files reach more than {MOST} headers, the farthest {max(map(len, reached.values()))}")
    return 1 if wrong else 0


if __name__ == "__main__":
    sys.exit(main())
