"""What a child process may do: compute, and nothing else."""
import ctypes
import errno
import json
import mmap
import os
import platform
import signal
import subprocess
import tempfile
import time

from common import trivial
from daemon import Daemon
from tally import ROOT


def sanitized(build):
    """Sanitizers need what the sandbox forbids; there it is left out."""
    return "-" in os.path.basename(os.path.normpath(build))


def trials(build, c):
    if sanitized(build):
        return
    run = subprocess.run([os.path.join(build, "sgad"), "--check-sandbox"], capture_output=True, timeout=60, check=False)
    lines = run.stdout.decode().splitlines()
    c(run.returncode == 0 and len(lines) >= 10, "--check-sandbox", (run.returncode, run.stdout, run.stderr))
    code = [line for line in lines if line.startswith("machine code of formulas")]
    expected = "compiled" if platform.machine() == "x86_64" else "interpreted"
    c(len(code) == 1 and code[0].split()[-1] == expected, "sandbox: machine code", code)
    for line in lines:
        if line in code:
            continue
        c(line.endswith(" refused"), "sandbox: " + line.rsplit(" ", 1)[0].strip(), line)


def status(pid):
    with open(f"/proc/{pid}/status", encoding="ascii") as f:
        return dict(line.rstrip("\n").split(":\t", 1) for line in f if ":\t" in line)


def confined(pid):
    """Its status once it has entered the sandbox: it may just have been started."""
    for _ in range(500):
        s = status(pid)
        if s["Seccomp"] == "2":
            break
        time.sleep(0.02)
    return s


def gone(pid):
    for _ in range(500):
        try:
            if status(pid)["State"].startswith("Z"):
                return True
        except OSError:
            return True
        time.sleep(0.02)
    return False


def child(build, c):
    with Daemon(build, "--workers", "2") as d:
        for _ in range(4):
            c(d.ask("POST", "/v1/solve", trivial()).json()["status"] == "done", "a job inside the sandbox")
        pids = d.children()
        c(len(pids) == 4, "a child for each worker, and two that check requests", pids)
        for pid in pids:
            s = confined(pid) if not sanitized(build) else status(pid)
            if not sanitized(build):
                c(s["Seccomp"] == "2" and s["NoNewPrivs"] == "1", "the child has a filter and gets no privileges", s)
                names = [os.readlink(f"/proc/{pid}/fd/{fd}") for fd in sorted(os.listdir(f"/proc/{pid}/fd"))]
                c(len(names) <= 5 and names[0] == names[1] == "/dev/null" and names[3].startswith("socket:"),
                  "the child has its socket and no other descriptor to speak of", names)
                c(names[2].startswith("pipe:"), "what it says goes into a pipe of its own", names)
                with open(f"/proc/{pid}/environ", "rb") as f:
                    c(f.read().strip(b"\0") == b"", "and no environment")
        # without its parent it is gone, however the parent ended
        d.process.send_signal(signal.SIGKILL)
        d.ended()
        for pid in pids:
            c(gone(pid), "no child outlives its parent", pid)


def token(d, name):
    run = subprocess.run([os.path.join(d.build, "sgad"), "token", "create", *d.place(), "--name", name],
                         capture_output=True, check=True)
    return {"Authorization": "Bearer " + run.stdout.decode().strip()}


def known(d, *tokens):
    """Whether the daemon knows all of them: it looks every two seconds."""
    for _ in range(1000):
        if all(d.ask("GET", "/v1/jobs", headers=t).status == 200 for t in tokens):
            return True
        time.sleep(0.05)
    return False


def apart(build, c):
    """A child that ran or read what one token sent is not there for the next one's."""
    with Daemon(build, "--workers", "1", "--access", "tokens") as d:
        ann, bob = token(d, "ann"), token(d, "bob")
        c(known(d, ann, bob), "the tokens are known")
        for who in (ann, ann, bob):
            c(d.ask("POST", "/v1/solve", trivial(), who).json()["status"] == "done", "a job")
        before = set(d.children())
        c(d.ask("POST", "/v1/solve", trivial(), bob).json()["status"] == "done", "another job of the same token")
        c(len(before & set(d.children())) >= 2, "may have the same processes", (before, d.children()))
        started = d.children()
        for _ in range(4):                # both readers and the worker come by
            c(d.ask("POST", "/v1/solve", trivial(), ann).json()["status"] == "done", "a job of the other")
            c(d.ask("POST", "/v1/solve", trivial(), bob).json()["status"] == "done", "and back")
        c(len(set(started) & set(d.children())) <= 1, "another token's job has another process", (started, d.children()))


def executors(build, c):
    """Machine code and the interpreter: the same samples to the last digit."""
    request = {"system": {"form": "equations", "variables": ["x", "y", "l"], "equations": ["x'' = -l*x", "y'' = -l*y - 10 + sin(x)", "x^2 + y^2 = 1"]},
               "want": ["trajectory"], "trajectory": {"stop": 20, "samples": 41, "initial": {"x": 1, "y": 0}}}
    found = []
    for flags in ([], ["--interpret-only"]):
        with Daemon(build, "--workers", "1", *flags) as d:
            answer = d.ask("POST", "/v1/solve", request).json()
            c(answer["status"] == "done", "a trajectory inside the sandbox", answer)
            found.append(answer.get("result", {}).get("trajectory", {}).get("rows"))
    c(found[0] and len(found[0]) == 41 and found[0] == found[1], "machine code changes no digit", [f and f[-1] for f in found])


def without_code():
    """In a process about to start: as MemoryDenyWriteExecute= has it, memory is not made executable from here on."""
    lib = ctypes.CDLL("libseccomp.so.2")
    lib.seccomp_init.restype = ctypes.c_void_p

    class Compared(ctypes.Structure):
        _fields_ = [("argument", ctypes.c_uint), ("operation", ctypes.c_int), ("mask", ctypes.c_uint64), ("value", ctypes.c_uint64)]
    allow, refuse, masked, executable = 0x7FFF0000, 0x00050000 | errno.EPERM, 7, mmap.PROT_EXEC
    context = ctypes.c_void_p(lib.seccomp_init(ctypes.c_uint32(allow)))
    third = (Compared * 1)(Compared(2, masked, executable, executable))
    number = lib.seccomp_syscall_resolve_name(b"mprotect")
    assert lib.seccomp_rule_add_array(context, ctypes.c_uint32(refuse), number, 1, third) == 0 and lib.seccomp_load(context) == 0


def told(build, c):
    """A line at the start says whether formulas become machine code, and why not; jobs end either way."""
    if sanitized(build):
        return
    for flags, start, mode, level, why in (([], None, "compiled", "info", None), (["--interpret-only"], None, "interpreted", "info", "interpret-only"),
                                           ([], without_code, "interpreted", "warn", "MemoryDenyWriteExecute")):
        with tempfile.TemporaryDirectory() as folder:
            p = subprocess.Popen([os.path.join(build, "sgad"), "--listen", "127.0.0.1:0", "--state", folder, *flags], stdout=subprocess.PIPE, stderr=subprocess.PIPE,
                                 text=True, preexec_fn=start)
            url = p.stdout.readline().split()[-1]
            run = subprocess.run([os.path.join(build, "sga"), "solve", os.path.join(ROOT, "etc/examples/pendulum.json"), "--json", "--server", url], capture_output=True, check=False)
            p.send_signal(signal.SIGTERM)
            said = [json.loads(line) for line in p.communicate(timeout=60)[1].splitlines()]
            lines = [e for e in said if e["event"] == "formulas"]
            expected = mode if platform.machine() == "x86_64" else "interpreted"
            c(len(lines) == 1 and lines[0]["mode"] == expected and lines[0]["level"] == level and ("reason" in lines[0]) == bool(why) and (why or "") in lines[0].get("reason", ""),
              f"formulas are {mode}", lines or said)
            c(run.returncode == 0 and p.returncode == 0, f"formulas are {mode}: a job", run.stderr)


ALL = [trials, child, apart, executors, told]
