"""Runs `sga solve` in process and returns what it says."""
import json
import os
import re
import subprocess
import tempfile

# The line on standard error: "sga: CODE at POINTER, line L, column C: detail"
LINE = re.compile(r"^sga: ([a-z_]+)(?: at (/\S*?))?(?:(?:,| at) line (\d+), column (\d+))?: (.*)", re.S)


class Digits(float):
    """A number with more digits than a float holds: a float, with its text."""

    def __new__(cls, text):
        number = super().__new__(cls, text)
        number.text = text
        return number


def parse_float(text):
    digits = sum(c.isdigit() for c in text.lower().partition("e")[0])
    return Digits(text) if digits > 17 else float(text)


class Crash(Exception):
    pass


def shortened(text, most=1200):
    """Its beginning and its end."""
    return text if len(text) <= most else text[:most // 2] + " [...] " + text[-most // 2:]


class Solver:
    def __init__(self, build, seconds=120, number=parse_float):
        """number: how decimals of the answer are read."""
        self.program, self.seconds, self.number = os.path.join(build, "sga"), seconds, number
        self.environment = {k: v for k, v in os.environ.items() if k != "SGA_SERVER"}

    def solve(self, request):
        """(result, None) or (None, problem). request: an object, or the text of one."""
        text = request if isinstance(request, (str, bytes)) else json.dumps(request)
        data = text.encode() if isinstance(text, str) else text
        with tempfile.NamedTemporaryFile(suffix=".json") as f:
            f.write(data)
            f.flush()
            try:
                run = subprocess.run([self.program, "solve", f.name, "--json"], capture_output=True,
                                     timeout=self.seconds, env=self.environment, check=False)
            except subprocess.TimeoutExpired as e:
                raise Crash(f"no answer within {self.seconds} s") from e
        if run.returncode < 0 or run.returncode > 125:
            raise Crash(f"ended with {run.returncode}: {run.stderr.decode(errors='replace')[-800:]}")
        for stream in (run.stdout, run.stderr):
            try:
                answer = json.loads(stream, parse_constant=lambda c: c, parse_float=self.number)
            except ValueError:
                continue
            if isinstance(answer, dict) and "code" in answer:
                if run.returncode == 0:
                    raise Crash("a problem with exit status 0")
                return None, answer
            if isinstance(answer, dict) and "verdict" in answer:
                if run.returncode:
                    raise Crash(f"a result with exit status {run.returncode}: {run.stderr.decode(errors='replace')[-1500:]}")
                return answer, None
        said = LINE.match(run.stderr.decode(errors="replace"))
        if said and run.returncode == 1:
            code, pointer, line, column, detail = said.groups()
            place = {"line": int(line), "column": int(column)} if line else {}
            return None, {"code": code, "pointer": pointer or "", "detail": detail.strip(), **place}
        raise Crash(f"exit status {run.returncode}, neither result nor problem: "
                    f"{run.stdout.decode(errors='replace')[:300]} {shortened(run.stderr.decode(errors='replace'))}")
