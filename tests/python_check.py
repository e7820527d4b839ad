"""The Python client against a daemon: python_check.py BUILD_DIR

What a client says is compared with the library's command (`sga solve`), with NumPy's and SymPy's own values, and with identities of the
motion; the client is taken from its wheel. Bad input must end in an exception that names its place."""
import json
import math
import os
import random
import re
import subprocess
import sys
import tempfile
import threading
import time
import zipfile

HERE = os.path.dirname(os.path.abspath(__file__))
sys.path.insert(0, os.path.join(HERE, "api"))

from common import slow  # noqa: E402
from daemon import Daemon  # noqa: E402
from tally import ROOT, Tally, build_folder, seed  # noqa: E402

PENDULUM = {"system": {"name": "pendulum", "form": "equations", "variables": ["x", "y", "lam"], "parameters": {"g": "9.81", "L": "1/2*2"},
                       "equations": ["x'' = -lam*x", "y'' = -lam*y - g", "x^2 + y^2 = L^2"]},
            "trajectory": {"stop": 2, "samples": 41, "initial": {"x": 1, "y": 0}}}
FREE = {"system": {"form": "equations", "variables": ["x", "y", "z"], "equations": ["x' = y + z", "x + y = sin(t)"]}}


def example(name):
    with open(os.path.join(ROOT, "etc", "examples", name + ".json"), encoding="utf-8") as f:
        return json.load(f)


def wheel(build, tally):
    """The client, from its wheel; two builds are the same bytes."""
    made = []
    for k in range(2):
        folder = os.path.join(build, "python", str(k))
        out = subprocess.run([sys.executable, os.path.join(ROOT, "clients", "python", "backend.py"), folder], capture_output=True, text=True, check=True)
        made.append(out.stdout.strip())
    first, second = (open(p, "rb").read() for p in made)
    tally.check(first == second, "the same wheel twice")
    with zipfile.ZipFile(made[0]) as z:
        names = z.namelist()
        tally.check(z.testzip() is None and {"sga/__init__.py", "sga/py.typed"} <= set(names) and any(n.endswith("RECORD") for n in names), "what the wheel holds", str(names))
    sys.path.insert(0, made[0])
    return made[0]


def raises(tally, kind, label, what, **should):
    try:
        what()
    except kind as e:
        wrong = {k: getattr(e, k, None) for k, v in should.items() if getattr(e, k, None) != v}
        return tally.check(not wrong, label, str(wrong)) and e
    except Exception as e:
        return tally.check(False, label, f"{type(e).__name__}: {e}")
    return tally.check(False, label, "nothing was raised")


def runge_kutta(field, x, t, stop, steps):
    h = (stop - t) / steps
    add = lambda x, k, f: [a + f * b for a, b in zip(x, k)]
    for _ in range(steps):
        k1 = field(t, x)
        k2 = field(t + h / 2, add(x, k1, h / 2))
        k3 = field(t + h / 2, add(x, k2, h / 2))
        k4 = field(t + h, add(x, k3, h))
        x = [a + h / 6 * (p + 2 * q + 2 * r + s) for a, p, q, r, s in zip(x, k1, k2, k3, k4)]
        t += h
    return x


def answers(sga, client, build, tally):
    result = client.solve(PENDULUM)
    with tempfile.NamedTemporaryFile("w", suffix=".json") as f:
        json.dump(PENDULUM, f)
        f.flush()
        other = json.loads(subprocess.run([os.path.join(build, "sga"), "solve", f.name, "--json"], capture_output=True, text=True, check=True).stdout)
    for part in ("verdict", "dimensions", "constraints", "vector_field"):
        tally.check(result[part] == other[part], f"{part} is that of the command")
    tally.check(result.verdict == "unique" and [str(c) for c in result.constraints][0] == "x^2 + y^2 - L^2" or str(result.constraints[0]) == "x^2 + y^2 - 1", "attributes", repr(result))
    t = result.trajectory
    tally.check(t.columns == ["t", "x", "y", "lam", "x'", "y'"] and len(t) == 41 and t.array().shape == (41, 6) and list(t["x"]) == [r[1] for r in t.rows], "columns")
    tally.check(t.error_estimate == other["trajectory"]["error_estimate"] and t.ended is None, "other members of the trajectory")
    tally.check(client.job(result.job["id"]).csv().splitlines()[0] == "t,x,y,lam,x',y'", "CSV")
    tally.check(raises(tally, AttributeError, "no such member", lambda: result.nothing), "no such member")
    raises(tally, KeyError, "no such column", lambda: t["zz"])
    return result


def fields(sga, client, result, tally):
    """The field as a function: its flow is the motion, it is tangent to the constraints; free functions multiply the gauge fields."""
    field, residual, t = result.field(), result.residual(), result.trajectory
    end = runge_kutta(field, t.rows[0][1:], 0.0, 2.0, 4000)
    tally.check(max(abs(a - b) for a, b in zip(end, t.rows[-1][1:])) < 1e-8, "the flow of the field is the motion", str(end))
    worst = max(abs(v) for row in t.rows for v in residual(row[0], row[1:]))
    tally.check(worst < 1e-8, "constraints hold along the motion", worst)
    for row in t.rows[1::7]:
        x, h = row[1:], 1e-5
        rate = field(row[0], x)
        moved = [(a - b) / (2 * h) for a, b in zip(residual(0, [v + h * r for v, r in zip(x, rate)]), residual(0, [v - h * r for v, r in zip(x, rate)]))]
        tally.check(max(map(abs, moved)) < 1e-6, "the field is tangent", str(moved))
    free = client.solve(FREE)
    f, n, draw = free.field(), len(free.names), random.Random(seed(17))
    tally.check(free.verdict == "underdetermined" and len(free.vector_field["free"]) == 1, "free functions", repr(free))
    for _ in range(5):
        x, at, u = [draw.uniform(-1, 1) for _ in range(n)], draw.uniform(0, 3), draw.uniform(-2, 2)
        x[1] = math.sin(at) - x[0]
        rate = f(at, x, [u])
        tally.check(abs(rate[0] - x[1] - x[2]) < 1e-12 and abs(rate[0] + rate[1] - math.cos(at)) < 1e-12, "with any free function the equations hold", str(rate))
    tally.check(list(f(0, [0, 0, 0], [1.0])) != list(f(0, [0, 0, 0])), "the free function is used")
    raises(tally, ValueError, "too many free functions", lambda: f(0, [0, 0, 0], [1, 2]))
    symbolic = client.solve({"system": {"form": "equations", "variables": ["x"], "parameters": {"k": None}, "equations": ["x' = -k*x"]}})
    raises(tally, ValueError, "a parameter without value", symbolic.field)
    tally.check(symbolic.field(k=3.0)(0, [2.0])[0] == -6, "a parameter that is given")
    arm = client.solve(example("arm"))
    row = arm.trajectory.rows[50]
    tally.check(max(abs(v) for v in arm.residual()(row[0], row[1:])) < 1e-7, "constraints of the arm hold along its motion")


def formulas(sga, client, result, tally):
    """Each writer of expressions against another one: Python against SymPy at random points; LaTeX has the parts."""
    import sympy
    draw = random.Random(seed(5))
    texts = ["x^2 - y/(1 + x)^3", "-x^2*-y", "2*x - (y - 1) - 3e-2", "atan2(y, x) + sqrt(1 + x^2)", "exp(-x)*sin(y)^2/cbrt(3)", "x/y/2 - -y", "min(x, y) + max(x, abs(-y))", "x^-2 + 2^x^2", "sign(x)*log(2 + y)",
             "(x + y)*(x - y)/(x*y)", "cosh(x) - tanh(y)*pi"]
    for text in texts:
        code = compile(sga.expressions.python(text, {"x": "x", "y": "y"}), "", "eval")
        tree = sga.expressions.sympy(text, {"x": sympy.Symbol("x"), "y": sympy.Symbol("y")})
        for _ in range(5):
            x, y = draw.uniform(0.2, 2), draw.uniform(0.2, 2)
            a, b = eval(code, {"f": sga.result._functions(), "x": x, "y": y}), float(tree.subs({"x": x, "y": y}))
            tally.check(abs(a - b) <= 1e-12 * max(1, abs(b)), f"{text}: Python and SymPy agree", f"{a} {b}")
        tex = sga.expressions.latex(text)
        tally.check(tex.count("{") == tex.count("}") and tex.count(r"\left") == tex.count(r"\right") and "*" not in tex, f"{text}: LaTeX", tex)
    tally.check(sga.expressions.latex("x' + lambda_1*tau2''/2") == r"\dot{x} + \frac{\lambda_{1} \, \ddot{\tau}_{2}}{2}", "LaTeX of names", sga.expressions.latex("x' + lambda_1*tau2''/2"))
    long = " + ".join(f"{k}*x" for k in range(3000))
    tally.check(eval(sga.expressions.python(long, {"x": "x"}), {"x": 2.0, "f": sga.result._functions()}) == 3000 * 2999 and sga.expressions.sympy(long).coeff(sympy.Symbol("x", real=True)) == 3000 * 2999 // 2
                and sga.expressions.latex(long).count("+") == 2999, "a long sum")
    for bad in ("-" * 5000 + "x", "", "x +", "(x", "x)", "x y", "f(x", "x $ y", "(" * 500 + "x"):
        raises(tally, ValueError, f"no expression: {bad[:9]!r}", lambda: sga.expressions.parse(bad))
    raises(tally, KeyError, "Python of an unknown name", lambda: sga.expressions.python("__import__(x)", {"x": "x"}))
    s = result.sympy()
    x, y, dx, dy = (sympy.Symbol(n, real=True) for n in ("x", "y", "x'", "y'"))
    of_rate = {x: s.field["x"], y: s.field["y"]}
    second = sum(sympy.diff(s.constraints[0], v) * r for v, r in of_rate.items())
    tally.check(sympy.simplify(second - 2 * (x * dx + y * dy)) == 0, "SymPy differentiates the first constraint along the field", str(second))
    tally.check(r"\begin{aligned}" in result.latex() and result._repr_latex_().startswith("$") and result.latex().count("generation") == 3, "LaTeX of the answer")


def jobs(sga, client, tally):
    job = client.submit(slow())
    stages = []
    for progress in job.events():
        stages.append(progress["stage"])
        if "trajectory" in stages:
            break
    tally.check("trajectory" in stages, "events tell the stage", str(stages))
    raises(tally, TimeoutError, "a wait that is too short", lambda: job.wait(1))
    tally.check(job.refresh().status == "running", "after it the job runs on")
    tally.check(any(j.id == job.id for j in client.jobs("running")), "it is in the list")
    job.cancel()
    tally.check(job.status == "cancelled", "cancelled", job.status)
    raises(tally, sga.Cancelled, "the answer of a cancelled job", lambda: job.result)
    other = slow()
    raises(tally, TimeoutError, "solve in too short a time", lambda: client.solve(other, timeout=1))
    tally.check(client.submit(other).cancel() is None, "cancelled and asked again")
    ended = client.submit(PENDULUM)
    ended.wait()
    tally.check(list(ended.events()) == [] and ended.request == PENDULUM and client.job(ended.id).request == PENDULUM, "a job that has ended")
    tally.check(len(list(client.jobs(limit=2))) >= 4, "pages of the list")
    answers = client.solve_all([{"system": {"form": "equations", "variables": ["x"], "equations": [f"x' = -{k}*x"]}} for k in range(2, 8)])
    tally.check([a.vector_field["components"]["x"] for a in answers] == [f"-{k}*x" for k in range(2, 8)], "many at a time, in order")
    found = []
    threads = [threading.Thread(target=lambda k=k: found.append((k, client.solve({"system": {"form": "equations", "variables": ["x"], "equations": [f"x' = {k}*x"]}}).vector_field["components"]["x"]))) for k in range(11, 17)]
    for th in threads:
        th.start()
    for th in threads:
        th.join()
    tally.check(sorted(found) == [(k, f"{k}*x") for k in range(11, 17)], "threads share a client", str(found))


def sweeps(client, tally):
    request = {"system": {"form": "equations", "variables": ["x"], "parameters": {"k": 1}, "equations": ["x' = -k*x"]}, "trajectory": {"stop": 1, "samples": 3, "initial": {"x": 1}}}
    many = client.sweep(request, [{"parameters": {"k": k}} for k in (1, 2, 3)] + [{"initial": {"x": 5}}])
    ends = [t["x"][-1] for t in many]
    tally.check(len(many) == 4 and all(abs(a - b) < 1e-7 for a, b in zip(ends, [math.exp(-1), math.exp(-2), math.exp(-3), 5 * math.exp(-1)])), "a sweep against the closed form", str(ends))


def refusals(sga, client, tally):
    wrong = {"system": {"form": "equations", "variables": ["x", "y"], "equations": ["x' = y", "y' = 1 +* x"]}}
    e = raises(tally, sga.RequestError, "a refusal says where", lambda: client.solve(wrong), code="expression_syntax", pointer="/system/equations/1", column=9, status=422)
    tally.check(e and e.explain(wrong).endswith("\n  y' = 1 +* x\n          ^"), "with a caret", e and e.explain(wrong))
    said = client.check({**wrong, "want": ["indx"]})
    tally.check(said["valid"] is False and len(said["problems"]) == 2, "check lists all", str(said))
    tally.check(client.check("{")["problems"][0]["code"] == "json_syntax", "check of what is no JSON")
    raises(tally, sga.JobError, "a job that fails", lambda: client.solve({**PENDULUM, "trajectory": {"stop": 1, "initial": {"x": 5, "y": 5}, "hold": ["x", "y"]}}), code="inconsistent_initial", stage="initial")
    raises(tally, sga.RequestError, "a job that is none", lambda: client.job("0" * 32), code="not_found")
    raises(tally, sga.ServiceError, "nobody is there", lambda: sga.Client("http://127.0.0.1:1").version(), code="unreachable")
    raises(tally, ValueError, "no address", lambda: sga.Client("ftp://x"))
    raises(tally, ValueError, "a token over plain HTTP", lambda: sga.Client("http://example.org", token="x"))
    raises(tally, ValueError, "NaN is no JSON", lambda: client.solve({"system": math.nan}))


def known(d, token):
    """A daemon notices new tokens after a while."""
    for _ in range(100):
        if d.get("/v1/jobs", Authorization="Bearer " + token).status == 200:
            return True
        time.sleep(0.1)
    return False


def tokens(sga, build, tally):
    with Daemon(build, "--access", "tokens") as d:
        state = os.path.join(d.state, "sgad")
        made = subprocess.run([os.path.join(build, "sgad"), "token", "create", "--state", state, "--name", "py", "--scope", "submit,read"], capture_output=True, text=True, check=True)
        token = next(w for w in made.stdout.split() if w.startswith("sgad_"))
        raises(tally, sga.AccessError, "no token", lambda: sga.Client(d.url()).solve(PENDULUM), code="unauthenticated", status=401)
        tally.check(known(d, token) and sga.Client(d.url(), token=token).solve(PENDULUM).verdict == "unique", "with a token")
    with tempfile.TemporaryDirectory() as folder:
        path = os.path.join(folder, "s")
        p = subprocess.Popen([os.path.join(build, "sgad"), "--listen", "unix:" + path, "--state", os.path.join(folder, "state")], stdout=subprocess.PIPE, stderr=subprocess.DEVNULL)
        try:
            p.stdout.readline()
            tally.check(sga.Client("unix:" + path).solve(PENDULUM).verdict == "unique", "by a UNIX socket")
        finally:
            p.terminate()
            p.wait()


def pictures(result, tally):
    import matplotlib
    matplotlib.use("Agg")
    ax = result.trajectory.plot("x", "y")
    tally.check([line.get_label() for line in ax.lines] == ["x", "y"] and len(ax.lines[0].get_xdata()) == 41, "a plot")
    tally.check(result.trajectory.plot("y", against="x").get_xlabel() == "x", "a phase plane")


def without(build, url, path, tally):
    """Without NumPy, SymPy, matplotlib: lists in place of arrays, the same numbers."""
    code = ("import sys; sys.modules['numpy'] = None; sys.modules['sympy'] = None\n"
            f"sys.path.insert(0, {path!r}); import sga, json\nr = sga.Client({url!r}).solve(json.load(sys.stdin))\n"
            "t = r.trajectory; print(json.dumps([t['x'], r.field()(0, t.rows[3][1:]), r.latex() != '']))")
    done = subprocess.run([sys.executable, "-c", code], input=json.dumps(PENDULUM), capture_output=True, text=True, check=False)
    tally.check(done.returncode == 0, "without NumPy", done.stderr[-500:])
    return json.loads(done.stdout) if done.returncode == 0 else None


def documents(url, path, tally):
    """Each block of Python in doc/python.md runs, and prints what the block after it shows, digits as far as they are shown."""
    with open(os.path.join(ROOT, "doc", "python.md"), encoding="utf-8") as f:
        blocks = re.findall(r"^```python\n(.*?)^```\n(?:\n```text\n(.*?)^```)?", f.read(), re.M | re.S)
    env = {**os.environ, "SGA_SERVER": url, "PYTHONPATH": path, "MPLBACKEND": "Agg"}
    before = ""
    tally.check(len(blocks) >= 5, "blocks of the page")
    for code, shown in blocks:
        with tempfile.TemporaryDirectory() as folder:
            done = subprocess.run([sys.executable, "-c", before + "print('-----')\n" + code], cwd=folder, env=env, capture_output=True, text=True, check=False)
        printed = done.stdout.rpartition("-----\n")[2]
        tally.check(done.returncode == 0, f"python.md runs: {code[:40]!r}", done.stderr[-400:])
        if shown:
            tally.check(printed == shown, f"python.md shows what is printed: {code[:40]!r}", printed)
        before += code


def types(tally):
    done = subprocess.run([sys.executable, "-m", "mypy", "--strict", "--cache-dir", os.devnull, "--ignore-missing-imports", "sga"], cwd=os.path.join(ROOT, "clients", "python"), capture_output=True, text=True, check=False)
    tally.check(done.returncode == 0, "types", done.stdout[-1500:] + done.stderr[-300:])


def main():
    tally, build = Tally("python"), build_folder()
    path = wheel(build, tally)
    import sga
    with Daemon(build) as d:
        client = sga.Client(d.url())
        result = answers(sga, client, build, tally)
        fields(sga, client, result, tally)
        formulas(sga, client, result, tally)
        jobs(sga, client, tally)
        sweeps(client, tally)
        refusals(sga, client, tally)
        plain = without(build, d.url(), path, tally)
        tally.check(plain and plain[0] == list(result.trajectory["x"]) and all(abs(a - b) < 1e-12 for a, b in zip(plain[1], result.field()(0, result.trajectory.rows[3][1:]))), "the same numbers without NumPy")
        pictures(result, tally)
        documents(d.url(), path, tally)
    tokens(sga, build, tally)
    types(tally)
    return tally.end()


if __name__ == "__main__":
    sys.exit(main())
