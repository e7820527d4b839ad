"""What `make install` gives to others: install_check.py BUILD_DIR

Installed into an empty folder, as a package is. From there, and from there alone: the example in C is built against the shared
and the static library by what pkg-config says, and gives the closed form; the libraries show the names of sga.h and no
others; the header is C and C++; a host keeps its allocators of GMP and FLINT, calls from two threads, cancels and frees
everything; manual pages are well formed; uninstalling leaves nothing.
"""
import os
import re
import subprocess
import sys
import tempfile

from tally import Tally

ROOT = os.path.dirname(os.path.dirname(os.path.abspath(__file__)))
PREFIX = "/usr"
HOST = r'''
#include <flint/flint.h>
#include <gmp.h>
#include <pthread.h>
#include <sga.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static long calls;
static void *mine(size_t n) { calls++; return malloc(n); }
static void *again(void *p, size_t before, size_t n) { (void)before; calls++; return realloc(p, n); }
static void gone(void *p, size_t n) { (void)n; free(p); }
static int stop(void *context) { (void)context; return 1; }

static const char *const request = "{\"system\": {\"form\": \"equations\", \"variables\": [\"x\", \"y\"], \"equations\": [\"x' = y\", \"x^2 + y^2 = 2/3\"]}}";

static const char *const wrong = "{\"system\": {\"form\": \"equations\", \"variables\": [\"x\"], \"equations\": [\"x' = (x\"]}}";
static const char *const spaced = " {\"system\" : {\"variables\": [\"x\"], \"form\": \"equations\", \"equations\": [\"x' = 1\"]}}";

static void *solve(void *out)
{
    sga_answer *a = sga_solve(request, strlen(request), NULL);
    *(sga_answer **)out = a;
    flint_cleanup();
    return NULL;
}

/* The answer without what tells the time. */
static size_t until_work(const sga_answer *a)
{
    const char *at = strstr(sga_answer_text(a), "\"work\"");
    return at ? (size_t)(at - sga_answer_text(a)) : 0;
}

int main(void)
{
    void *(*m)(size_t), *(*r)(void *, size_t, size_t);
    void (*f)(void *, size_t);
    mp_set_memory_functions(mine, again, gone);
    sga_answer *a[2], *b;
    pthread_t t[2];
    for (int i = 0; i < 2; i++)
        pthread_create(t + i, NULL, solve, a + i);
    for (int i = 0; i < 2; i++)
        pthread_join(t[i], NULL);
    mp_get_memory_functions(&m, &r, &f);
    printf("own allocators: %d, used: %d\n", m == mine && r == again && f == gone, calls > 0);
    printf("solved: %d %d, alike: %d\n", sga_answer_ok(a[0]), sga_answer_ok(a[1]),
           until_work(a[0]) > 0 && until_work(a[0]) == until_work(a[1]) && memcmp(sga_answer_text(a[0]), sga_answer_text(a[1]), until_work(a[0])) == 0);
    for (int i = 0; i < 2; i++)
        sga_answer_free(a[i]);
    sga_options o = { .size = sizeof o };
    o.cancelled = stop;
    b = sga_solve(request, strlen(request), &o);
    printf("cancelled: %s\n", sga_answer_code(b));
    sga_answer_free(b);
    b = sga_solve(wrong, strlen(wrong), NULL);
    printf("wrong: %s at %s, column %d\n", sga_answer_code(b), sga_answer_pointer(b), sga_answer_column(b));
    sga_answer_free(b);
    b = sga_check(spaced, strlen(spaced));
    printf("canonical: %d %s\n", sga_answer_ok(b), sga_answer_text(b));
    sga_answer_free(b);
    sga_answer_free(NULL);
    printf("api: %d\n", sga_api() == SGA_API);
    flint_cleanup();
    return 0;
}
'''


def run(*command, env=None, **more):
    return subprocess.run(command, capture_output=True, text=True, env={**os.environ, **(env or {})}, timeout=600, **more)


def exported(text):
    return {line.split()[-1].split("@")[0] for line in text.splitlines() if re.search(r" [TDBRWV] ", line)} - {"SGA_1"}


class Installed:
    def __init__(self, tally, dest):
        self.tally, self.dest = tally, dest
        self.lib = os.path.join(dest, "usr/lib")
        self.env = {"PKG_CONFIG_PATH": os.path.join(self.lib, "pkgconfig"), "PKG_CONFIG_SYSROOT_DIR": dest, "PKG_CONFIG_LIBDIR": "/usr/lib/x86_64-linux-gnu/pkgconfig"}

    def flags(self, *more):
        found = run("pkg-config", "--cflags", "--libs", *more, "sga", env=self.env)
        self.tally.check(found.returncode == 0, "pkg-config", found.stderr)
        return found.stdout.split()

    def build(self, source, name, static, *flags):
        out = os.path.join(self.dest, name)
        # the shared library is not there to be taken
        libs = [f if f != "-lsga" else "-l:libsga.a" for f in self.flags("--static")] if static else self.flags()
        made = run("gcc", "-std=c11", "-Wall", "-Wextra", "-Werror", source, "-o", out, *libs, *flags)
        self.tally.check(made.returncode == 0, f"{name} is built", made.stderr[-600:])
        return run(out, env={"LD_LIBRARY_PATH": self.lib}) if made.returncode == 0 else None

    def names(self):
        with open(os.path.join(self.dest, "usr/include/sga.h"), encoding="utf-8") as f:
            declared = set(re.findall(r"^SGA_PUBLIC .*?\b(sga_\w+)\(", f.read(), re.M))
        shared = exported(run("nm", "-D", "--defined-only", os.path.join(self.lib, "libsga.so.0")).stdout)
        static = exported(run("nm", "-g", "--defined-only", os.path.join(self.lib, "libsga.a")).stdout)
        self.tally.check(len(declared) > 10 and shared == declared, "names of the shared library", str(shared ^ declared)[:300])
        self.tally.check(static == declared, "names of the static library", str(static ^ declared)[:300])
        soname = run("objdump", "-p", os.path.join(self.lib, "libsga.so")).stdout
        self.tally.check("SONAME               libsga.so.0" in soname, "soname", soname[:300])

    def header(self):
        for language, compiler in (("c", "gcc -std=c99 -pedantic"), ("c++", "g++ -std=c++11 -pedantic")):
            made = run(*compiler.split(), "-Wall", "-Wextra", "-Werror", "-fsyntax-only", "-x", language, "-I", os.path.join(self.dest, "usr/include"), "-",
                       input="#include <sga.h>\nint main(void) { return sga_api() - SGA_API; }\n")
            self.tally.check(made.returncode == 0, f"the header is {language}", made.stderr[:300])

    def host(self):
        source = os.path.join(self.dest, "host.c")
        with open(source, "w", encoding="utf-8") as f:
            f.write(HOST)
        for static in (False, True):
            said = self.build(source, f"host{static:d}", static, "-lflint", "-lgmp", "-lpthread")
            if said is None:
                continue
            for line in ("own allocators: 1, used: 1", "solved: 1 1, alike: 1", "cancelled: cancelled", "wrong: expression_syntax at /system/equations/0, column 6",
                         'canonical: 1 {"system":{"equations":["x\' = 1"],"form":"equations","variables":["x"]}}', "api: 1"):
                self.tally.check(line in said.stdout.splitlines(), f"host: {line}", said.stdout + said.stderr[:300])
            self.tally.check(said.returncode == 0, "host ends well", said.stderr[:300])
        leaks = run("valgrind", "--quiet", "--error-exitcode=9", "--leak-check=full", "--errors-for-leak-kinds=definite", os.path.join(self.dest, "host0"),
                    env={"LD_LIBRARY_PATH": self.lib})
        self.tally.check(leaks.returncode == 0, "host frees all", leaks.stderr[-600:])

    def example(self):
        source = os.path.join(self.dest, "usr/share/doc/sga/examples/pendulum.c")
        for static in (False, True):
            said = self.build(source, f"pendulum{static:d}", static, "-ljansson")
            # x'' = -l x, y'' = -l y - g from rest at (1, 0), integrated by the angle, 30 digits
            self.tally.check(said is not None and said.stdout == f"constraints: 3, index 3\nx(1) = {X:.6f}, y(1) = {Y:.6f}\n", "the example", said and said.stdout + said.stderr)

    def pages(self):
        folder = os.path.join(self.dest, "usr/share/man")
        found = [os.path.join(at, f) for at, _, files in os.walk(folder) for f in files]
        self.tally.check({os.path.basename(f) for f in found} >= {"sga.1", "sga.3", "sgad.8", "sgad.conf.5"}, "manual pages", str(found))
        for page in found:
            read = run("groff", "-man", "-Tutf8", "-ww", "-z", page)
            self.tally.check(read.returncode == 0 and not read.stderr, os.path.basename(page), read.stderr[:300])
        for page in ("README.md", "doc/tutorial.md", "doc/errors.md"):
            self.tally.check(os.path.exists(os.path.join(self.dest, "usr/share/doc/sga", page)), f"{page} is installed")
        with open(os.path.join(folder, "man3/sga.3"), encoding="utf-8") as f:
            text = f.read()
        for name in exported(run("nm", "-D", "--defined-only", os.path.join(self.lib, "libsga.so.0")).stdout):
            self.tally.check(re.search(rf"\b{name}\(", text), f"sga(3) names {name}")


    def completion(self):
        """What a shell offers, by the installed file and programs alone: all commands and languages that the program has."""
        usage = run(os.path.join(self.dest, "usr/bin/sga"), "--help").stdout
        commands = set(re.findall(r"\bsga ([a-z]+)", usage.split("\n\n")[0]))
        languages = {w for w in "c python matlab julia casadi modelica latex mathml fmu".split() if re.search(rf"\b{w}\b", usage.partition("--language")[2])}
        script = ('source "$1"; PATH=$2:$PATH; shift 2; COMP_WORDS=("$@"); COMP_CWORD=$(($# - 1)); _sga; printf "%s\\n" "${COMPREPLY[@]}"')
        for words, wanted, but in ((("sga", ""), commands, {"token"}), (("sga", "code", "--language", ""), languages, {"--text"}), (("sga", "solve", "--t"), {"--text", "--tradeoff-csv"}, {"--json"}),
                                   (("sgad", "--"), {"--listen", "--ui", "--config"}, {"--text"}), (("sgad", "--ui", ""), {"yes", "no"}, {"open"}),
                                   (("sgad", "token", "cr"), {"create"}, {"list"}), (("sga", "solve", "etc/examples/pen"), {"etc/examples/pendulum.json"}, {"etc/examples/arm.json"}),
                                   (("sga", "solve", "--zz"), {""}, {"--text"})):
            program = "sga" if words[0] == "sga" else "sgad"
            said = run("bash", "-c", script, "_", os.path.join(self.dest, "usr/share/bash-completion/completions", program), os.path.join(self.dest, "usr/bin"), *words, cwd=ROOT)
            offered = set(said.stdout.split("\n"))
            self.tally.check(said.returncode == 0 and not said.stderr and wanted <= offered and not but & offered, f"completion of {' '.join(words)}", said.stdout[:300] + said.stderr[:300])

    def commands(self):
        """Every command of the programs' own tables stands in --help, in the manual and in what a shell offers."""
        for program, page, table, row in (("sgad", "man8/sgad.8", "server/admin/command.c", r'\{ "([a-z]+)", command_'), ("sga", "man1/sga.1", "clients/arguments.c", r'\] = \{ "([a-z]+)", "')):
            with open(os.path.join(ROOT, table), encoding="utf-8") as f:
                names = set(re.findall(row, f.read()))
            with open(os.path.join(self.dest, "usr/share/man", page), encoding="utf-8") as f:
                manual = f.read()
            with open(os.path.join(self.dest, "usr/share/bash-completion/completions", program), encoding="utf-8") as f:
                offered = f.read()
            usage = run(os.path.join(self.dest, "usr/bin", program), "--help").stdout.split("\n\n")[0]
            self.tally.check(len(names) >= 6, f"commands of {program}", names)
            for name in names:
                for where, text in (("--help", usage), ("manual", manual), ("completion", offered)):
                    self.tally.check(re.search(rf"(?<![\w-]){name}(?![\w-])", text), f"{where} of {program} names {name}")


def service(tally, dest):
    """What the service and the clients of other languages are, where others look for them."""
    for path in ("usr/lib/systemd/system/sgad.service", "usr/lib/systemd/system/sgad.socket", "usr/lib/sysusers.d/sgad.conf", "usr/lib/tmpfiles.d/sgad.conf", "etc/sgad.conf",
                 "usr/share/sga/prometheus/sgad.rules.yml", "usr/share/sga/grafana/sgad.json", "usr/share/sga/proxy/nginx.conf", "usr/share/octave/site/m/+sga/solve.m"):
        tally.check(os.path.isfile(os.path.join(dest, path)), f"{path} is installed")
    with open(os.path.join(dest, "usr/lib/systemd/system/sgad.service"), encoding="utf-8") as f:
        tally.check("ExecStart=/usr/bin/sgad --config /etc/sgad.conf\n" in f.read(), "the unit starts what is installed")
    said = run("/usr/bin/python3", "-I", "-c", f"import sys; sys.path.insert(0, {os.path.join(dest, 'usr/lib/python3/dist-packages')!r}); import sga, importlib.metadata as m; print(sga.__version__, m.version('sga-client'))")
    tally.check(len(set(said.stdout.split())) == 1 and said.returncode == 0, "the Python client is a distribution", said.stdout + said.stderr[-300:])


def elsewhere(tally, build):
    """Below another prefix units and settings name the places that are there; settings that were changed outlive both commands."""
    with tempfile.TemporaryDirectory() as dest:
        def make(target):
            return run("make", "-C", ROOT, "--no-print-directory", "PREFIX=/opt/sga", f"DESTDIR={dest}", f"B={build}", target)
        tally.check(make("install").returncode == 0, "make install below another prefix")
        with open(os.path.join(dest, "opt/sga/lib/systemd/system/sgad.service"), encoding="utf-8") as f:
            tally.check("ExecStart=/opt/sga/bin/sgad --config /opt/sga/etc/sgad.conf\n" in f.read(), "the unit names the places")
        settings = os.path.join(dest, "opt/sga/etc/sgad.conf")
        with open(settings, "a", encoding="utf-8") as f:
            f.write("workers = 1\n")
        make("install")
        gone = make("uninstall")
        left = [os.path.join(at, f) for at, _, files in os.walk(dest) for f in files]
        with open(settings, encoding="utf-8") as f:
            tally.check(gone.returncode == 0 and left == [settings] and f.read().endswith("workers = 1\n"), "settings that were changed stay, and nothing else", str(left))


def clients(tally, dest):
    """The installed clients are found: Python's with its converters, Octave's on its path; Julia's file is there."""
    folder = os.path.join(dest, "usr/lib/python3/dist-packages")
    said = run("/usr/bin/python3", "-c", "import sga, sga.convert.spice as s; print(sga.__file__.startswith('%s'), s.number('4.7k'))" % folder, env={"PYTHONPATH": folder, "PYTHONDONTWRITEBYTECODE": "1"})
    tally.check(said.stdout == "True 4700\n", "the Python client", said.stdout + said.stderr[:300])
    said = run("octave-cli", "--quiet", "--norc", "--eval", f"addpath('{dest}/usr/share/octave/site/m'); disp(sga.encode(struct('a', 1)))")
    tally.check(said.stdout.strip() == '{"a":1}', "the Octave client", said.stdout + said.stderr[:300])
    tally.check(os.path.exists(os.path.join(dest, "usr/share/sga/julia/SgaClient.jl")), "the Julia client")


def pendulum():
    """x(1) and y(1) by elliptic functions: theta'' = -g sin(theta), theta from straight down, pi/2 at rest."""
    import mpmath
    with mpmath.workdps(30):
        g, k = mpmath.mpf("9.81"), mpmath.sin(mpmath.pi / 4)
        s = k * mpmath.ellipfun("sn", mpmath.ellipk(k ** 2) - mpmath.sqrt(g), m=k ** 2)      # sin(theta/2)
        theta = 2 * mpmath.asin(s)
        return mpmath.sin(theta), -mpmath.cos(theta)


X, Y = map(float, pendulum())


def main():
    tally = Tally("install")
    build = sys.argv[1]
    # the build folder's own flags, so that nothing is made anew
    with tempfile.TemporaryDirectory() as dest:
        made = run("make", "-C", ROOT, "--no-print-directory", f"PREFIX={PREFIX}", f"DESTDIR={dest}", f"B={build}", "install")
        tally.check(made.returncode == 0, "make install", made.stderr[-800:])
        i = Installed(tally, dest)
        i.names()
        i.header()
        i.example()
        i.host()
        i.pages()
        i.completion()
        i.commands()
        service(tally, dest)
        clients(tally, dest)
        for program in ("sga", "sgad"):
            said = run(os.path.join(dest, "usr/bin", program), "version" if program == "sga" else "--help")
            tally.check(said.returncode == 0, f"{program} runs", said.stderr[:300])
        gone = run("make", "-C", ROOT, "--no-print-directory", f"PREFIX={PREFIX}", f"DESTDIR={dest}", f"B={build}", "uninstall")
        left = [os.path.join(at, f) for at, _, files in os.walk(dest) for f in files if at == os.path.join(dest, "etc") or at.startswith(os.path.join(dest, "usr"))]
        tally.check(gone.returncode == 0 and not left, "make uninstall", str(left) + gone.stderr[:300])
    elsewhere(tally, build)
    return tally.end()


if __name__ == "__main__":
    sys.exit(main())
