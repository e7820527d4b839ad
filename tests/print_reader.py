"""What the prints of an export say: LaTeX and MathML read back into the grammar of expressions, each by a small reader.

A print becomes a list of rows (what, text). `what` is ("rate", variable), ("constraint", i), ("slope", i, variable), ("gauge", k, variable),
("part", k) or ("value", parameter); in the texts gauge functions are F__k and shared parts W__k. Anything that is not known raises Unreadable."""
import re
import xml.etree.ElementTree

FUNCTIONS = {"arcsin": "asin", "arccos": "acos", "arctan": "atan", "arsinh": "asinh", "arcosh": "acosh", "artanh": "atanh", "ln": "log",
             **{k: k for k in ("sin", "cos", "tan", "sinh", "cosh", "tanh", "sign", "atan2", "min", "max")}}
NS = "{http://www.w3.org/1998/Math/MathML}"


class Unreadable(Exception):
    pass


class Latex:
    def __init__(self, text):
        self.symbols = dict(re.findall(r"^% (.*): ([A-Za-z_]\S*)$", text, re.M))
        self.by_length = sorted(self.symbols, key=len, reverse=True)
        self.rows = [self.row(a, b) for a, b in re.findall(r"^  (.*?) &= (.*?)(?: \\\\)?$", text, re.M)]

    def row(self, left, right):
        patterns = (("rate", r"\\frac{\\mathrm{d} (.*)}{\\mathrm{d} .*}"), ("slope", r"\\frac{\\partial \\mathcal{C}_{(\d+)}}{\\partial (.*)}"),
                    ("constraint", r"\\mathcal{C}_{(\d+)}"), ("gauge", r"\\mathcal{G}_{(\d+), (.*)}"), ("part", r"\\mathcal{W}_{(\d+)}"))
        for what, pattern in patterns:
            m = re.fullmatch(pattern, left)
            if m:
                return (what, *(int(g) if g.isdigit() else self.symbols[g] for g in m.groups())), self.text(right)
        return ("value", self.symbols[left]), self.text(right)

    def group(self, s, at):
        """The text between the braces that begin at `at`, and what comes after."""
        depth = 0
        for k in range(at, len(s)):
            if s[k] == "\\":
                continue
            depth += (s[k] == "{" and s[k - 1] != "\\") - (s[k] == "}" and s[k - 1] != "\\")
            if depth == 0:
                return s[at + 1:k], k + 1
        raise Unreadable(s[at:])

    def symbol(self, s, at):
        for name in self.by_length:
            end = at + len(name)
            if s.startswith(name, at) and not (name[0] == "\\" and name[-1].isalpha() and s[end:end + 1].isalpha()):
                return name
        return None

    def text(self, s):
        out, at = [], 0
        simple = (("\\left(", "("), ("\\right)", ")"), ("\\left|", "abs("), ("\\right|", ")"), ("\\, ", "*"), ("\\cdot ", "*"), (", ", ","), (" + ", "+"), (" - ", "-"), ("-", "-"))
        while at < len(s):
            known = next((p for p in simple if s.startswith(p[0], at)), None)
            number = re.compile(r"\d+(\.\d+)?").match(s, at)
            shared = re.compile(r"\\mathcal{([FW])}_{(\d+)}").match(s, at)
            function = re.compile(r"\\(?:operatorname{(\w+)}|(\w+))\\left\(").match(s, at)
            if known:
                out.append(known[1])
                at += len(known[0])
            elif s[at] == " ":
                at += 1
            elif s.startswith("e^{", at):
                inner, at = self.group(s, at + 2)
                out.append(f"exp({self.text(inner)})")
            elif s.startswith("\\frac{", at):
                top, at = self.group(s, at + 5)
                below, at = self.group(s, at)
                out.append(f"(({self.text(top)})/({self.text(below)}))")
            elif s.startswith("\\sqrt", at):
                cube = s.startswith("\\sqrt[3]", at)
                inner, at = self.group(s, at + (8 if cube else 5))
                out.append(f"{'cbrt' if cube else 'sqrt'}({self.text(inner)})")
            elif s[at] == "{":
                inner, at = self.group(s, at)
                if s[at] != "^":
                    raise Unreadable(s[at:])
                power, at = self.group(s, at + 1)
                out.append(f"({self.text(inner)})^({self.text(power)})")
            elif shared:
                out.append(f"{shared[1]}__{shared[2]}")
                at = shared.end()
            elif function and (function[1] or function[2]) in FUNCTIONS:
                out.append(FUNCTIONS[function[1] or function[2]] + "(")
                at = function.end()
            elif self.symbol(s, at):
                out.append(self.symbols[self.symbol(s, at)])
                at += len(self.symbol(s, at))
            elif number:
                out.append(number[0])
                at = number.end()
            elif s.startswith("\\pi", at):
                out.append("pi")
                at += 3
            else:
                raise Unreadable(s[at:])
        return "".join(out)


def canonical(e):
    """An element as a text that equal ones share."""
    return f"<{e.tag.removeprefix(NS)}{sorted(e.attrib.items())}>" + (e.text or "") + "".join(canonical(c) for c in e)


class Mathml:
    def __init__(self, text):
        self.symbols = {}
        for s, name in re.findall(r"^  (<m.*>): (\S+)$", text, re.M):
            self.symbols[canonical(xml.etree.ElementTree.fromstring(f'<math xmlns="{NS[1:-1]}">{s}</math>')[0])] = name
        root = xml.etree.ElementTree.fromstring(text)
        self.rows = [self.row(*(list(cell) for cell in (r[0], r[2]))) for r in root.iter(NS + "mtr") if len(r) == 3]

    def script(self, e):
        """(letter, parts below) of a letter with an index."""
        if e.tag == NS + "msub" and e[0].get("mathvariant") == "script":
            below = [e[1]] if e[1].tag == NS + "mn" else [c for c in e[1] if c.tag != NS + "mo"]
            return e[0].text, [int(c.text) if c.tag == NS + "mn" else self.symbols[canonical(c)] for c in below]
        return None, None

    def row(self, left, right):
        (e,) = left
        letter, below = self.script(e)
        if letter:
            return ({"C": "constraint", "G": "gauge", "W": "part"}[letter], *below), self.text(right)
        if canonical(e) in self.symbols:
            return ("value", self.symbols[canonical(e)]), self.text(right)
        top, bottom = list(e[0]), list(e[1])
        if top[0].text == "d" and top[0].get("mathvariant") == "normal":
            return ("rate", self.symbols[canonical(top[1])]), self.text(right)
        if top[0].text == "\u2202":
            return ("slope", self.script(top[1])[1][0], self.symbols[canonical(bottom[1])]), self.text(right)
        raise Unreadable(canonical(e))

    def text(self, elements):
        if len(elements) > 1 and all(e.tag == NS + "mo" and e.text == "|" for e in (elements[0], elements[-1])):
            return f"abs({self.text(elements[1:-1])})"
        return "".join(self.one(e, elements[i + 1] if i + 1 < len(elements) else None) for i, e in enumerate(elements))

    def one(self, e, following):
        tag, children = e.tag.removeprefix(NS), list(e)
        letter, below = self.script(e)
        if letter in ("F", "W"):
            return f"{letter}__{below[0]}"
        if tag == "mi" and following is not None and following.text == "\u2061":
            return FUNCTIONS[e.text]
        if canonical(e) in self.symbols:
            return self.symbols[canonical(e)]
        if tag == "msup":
            if children[0].tag == NS + "mi" and children[0].text == "e":
                return f"exp({self.text([children[1]])})"
            return f"({self.text([children[0]])})^({self.text([children[1]])})"
        if tag == "mfrac":
            return f"(({self.text([children[0]])})/({self.text([children[1]])}))"
        if tag == "mroot" and children[1].text == "3":
            return f"cbrt({self.text([children[0]])})"
        if tag == "msqrt":
            return f"sqrt({self.text(children)})"
        if tag == "mrow":
            return self.text(children)
        if tag == "mn":
            return e.text
        if tag == "mo" and e.text in "+-(),":
            return e.text
        if tag == "mo" and e.text in ("\u22c5", "\u2061"):
            return "*" if e.text == "\u22c5" else ""
        if tag == "mi" and e.text == "\u03c0":
            return "pi"
        raise Unreadable(canonical(e))
