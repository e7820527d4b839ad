"""Debian packages: deb_check.py BUILD_DIR

`make deb` from the sources as they are; lintian has no error and no warning; each package holds what it should and nothing of the
machine that built it; the units are sound and shut in; versions agree wherever one stands. In a fresh root they are tried by
tests/deb_root.py (`make deb-test`).
"""
import glob
import json
import os
import re
import shutil
import subprocess
import sys
import tempfile

from tally import ROOT, Tally

BINARY = {"sgad": "any", "sga": "any", "libsga0": "any", "libsga-dev": "any", "sga-doc": "all", "python3-sga": "all", "octave-sga": "all"}
FILES = {
    "sgad": {"usr/bin/sgad", "etc/sgad.conf", "lib/systemd/system/sgad.service", "lib/systemd/system/sgad.socket", "usr/lib/sysusers.d/sgad.conf", "usr/lib/tmpfiles.d/sgad.conf",
             "usr/share/sgad/prometheus/sgad.rules.yml", "usr/share/sgad/grafana/sgad.json", "usr/share/sgad/proxy/nginx.conf", "usr/share/sgad/proxy/Caddyfile",
             "usr/share/man/man8/sgad.8.gz", "usr/share/man/man5/sgad.conf.5.gz", "usr/share/bash-completion/completions/sgad"},
    "sga": {"usr/bin/sga", "usr/share/man/man1/sga.1.gz", "usr/share/bash-completion/completions/sga"},
    "libsga-dev": {"usr/include/sga.h", "usr/share/man/man3/sga.3.gz"},
    "sga-doc": {"usr/share/doc/sga/README.md", "usr/share/doc/sga/doc/tutorial.md", "usr/share/doc/sga/schema/request.json", "usr/share/doc/sga/examples/pendulum.c"},
    "python3-sga": {"usr/lib/python3/dist-packages/sga/__init__.py", "usr/lib/python3/dist-packages/sga/py.typed"},
    "octave-sga": {"usr/share/octave/site/m/+sga/solve.m"},
}


def run(*command, **more):
    return subprocess.run(command, capture_output=True, text=True, check=False, **more)


def text_of(path):
    with open(os.path.join(ROOT, path), encoding="utf-8") as f:
        return f.read()


def version():
    return re.search(r"^VERSION := (\S+)$", text_of("Makefile"), re.M)[1]


def build(out, source=ROOT, **env):
    """The packages of the sources in a folder; the run of make."""
    return run("make", "-C", source, "--no-print-directory", f"DEB={out}", "deb", timeout=1700, env={**os.environ, **env})


def packages(out):
    """Paths by name of package; those with symbols for debuggers left out."""
    found = {os.path.basename(p).split("_")[0]: p for p in glob.glob(os.path.join(out, "*.deb"))}
    return {name: path for name, path in found.items() if not name.endswith("-dbgsym")}


def check_versions(tally):
    v = version()
    tally.check(re.match(rf"sgad \({re.escape(v)}\) ", text_of("etc/debian/changelog")), "etc/debian/changelog begins with the version", v)
    headings = re.findall(r"^## (.*)$", text_of("CHANGELOG.md"), re.M)
    tally.check(headings[0] == "Unreleased" and re.fullmatch(rf"{re.escape(v)} \(\d{{4}}-\d\d-\d\d\)", headings[1]), "CHANGELOG.md: first what is not released, then the version with its date", str(headings))
    tally.check(f'version = "{v}"' in text_of("clients/python/pyproject.toml") and f'__version__ = "{v}"' in text_of("clients/python/sga/__init__.py"), "the Python client's version", v)
    day = re.search(r" -- .*>  \w{3}, (\d\d) (\w{3}) (\d{4}) ", text_of("etc/debian/changelog"))
    months = "Jan Feb Mar Apr May Jun Jul Aug Sep Oct Nov Dec".split()
    tally.check(headings[1].endswith(f"({day[3]}-{months.index(day[2]) + 1:02d}-{day[1]})"), "both changelogs have one date", headings[1])
    for name in re.findall(r"^Package: (\S+)$", text_of("etc/debian/control"), re.M):
        tally.check(name in BINARY, f"{name} is looked at here")
    wanted = set(re.search(r'^build="(.*?)"', text_of("tests/setup"), re.M | re.S)[1].split()) - {"gcc", "make", "libc6-dev"}
    given = set(re.split(r"[\s,]+", re.search(r"^Build-Depends: (.*?)^\S", text_of("etc/debian/control"), re.M | re.S)[1]))
    tally.check(wanted <= given, "Build-Depends has what tests/setup has", str(wanted - given))


def check_container(tally):
    """What can be told without an engine for containers; its commands are run by deb_root.py."""
    text = text_of("etc/Containerfile")
    stages = text.split("\nFROM ")[1:]
    tally.check(len(stages) == 2 and "apt-get" not in stages[0] and "COPY . " not in stages[1] and "HEALTHCHECK" in stages[1] and "USER sgad" in stages[1], "the container's stages")
    taken = [line[1:] for line in text_of(".dockerignore").splitlines() if line.startswith("!")]
    lines = [line for line in text_of(".dockerignore").splitlines() if line and line[0] not in "#!"]
    tally.check(lines[0] == "*" and all(os.path.exists(os.path.join(ROOT, t)) for t in taken), "the ignore file takes what it names, and nothing else", str(taken))
    tally.check(not any(t.startswith(("build", ".")) for t in taken) and {"Makefile", "lib", "server", "clients", "schema", "etc", "tests/setup"} <= set(taken), "no leftovers of a build", str(taken))


def check_lintian(tally, out):
    found = run("lintian", "--allow-root", "--tag-display-limit", "0", "--fail-on", "error,warning", *glob.glob(os.path.join(out, "*.changes")), timeout=600)
    tally.check(found.returncode == 0, "lintian", found.stdout + found.stderr)


def check_files(tally, out, there, folder):
    control = {}
    for name, path in sorted(there.items()):
        place = os.path.join(folder, name)
        tally.check(run("dpkg-deb", "-R", path, place).returncode == 0, f"{name} can be unpacked")
        with open(os.path.join(place, "DEBIAN/control"), encoding="utf-8") as f:
            control[name] = dict(re.findall(r"^([\w-]+): (.*)$", f.read(), re.M))
        held = {os.path.relpath(os.path.join(at, f), place) for at, _, files in os.walk(place) for f in files}
        missing = {p for p in FILES.get(name, ()) if not os.path.isfile(os.path.join(place, p))}       # a link that leads nowhere is none
        tally.check(not missing, f"{name} has its files", str(missing))
        tally.check(control[name]["Version"] == version() and (control[name]["Architecture"] == "all") == (BINARY[name] == "all"), f"{name}: version and architecture", str(control[name]))
        foreign = [p for p in held if not re.match(r"DEBIAN/|usr/|etc/sgad\.conf$|lib/systemd/", p)]
        tally.check(not foreign, f"{name} keeps to its places", str(foreign))
        named = run("grep", "-rlE", re.escape(os.path.basename(out)) + "|" + re.escape(ROOT) + "/", place).stdout
        tally.check(not named, f"{name} has no name of the folder that it was built in", named[:300])
        scripts = run("grep", "-c", "rm -rf", os.path.join(place, "DEBIAN/postrm")) if name == "sgad" else None
        tally.check(not scripts or scripts.stdout.strip() == "1", f"{name}: purge removes its state")
    lib = glob.glob(os.path.join(folder, "libsga0/usr/lib/*/libsga.so.0*"))
    tally.check(len(lib) == 2, "libsga0 has the library", str(lib))
    tally.check(len(glob.glob(os.path.join(folder, "libsga-dev/usr/lib/*/libsga.a"))) == 1 and len(glob.glob(os.path.join(folder, "libsga-dev/usr/lib/*/pkgconfig/sga.pc"))) == 1, "libsga-dev has static library and pkg-config file")
    tally.check("libcurl3-gnutls" in control["sga"]["Depends"] and "libcurl" not in control["sgad"]["Depends"] and "sysusers" in control["sgad"]["Depends"], "what they depend on", str(control))
    for program in ("sgad/usr/bin/sgad", "sga/usr/bin/sga"):
        said = run("readelf", "-hld", "--wide", os.path.join(folder, program)).stdout
        tally.check("DYN" in said and "GNU_RELRO" in said and "BIND_NOW" in said, f"{program} is hardened", said[:200])


def check_words(tally, folder):
    """What the units say that nothing here can try: keys by credentials, no address shut out, a socket for a group, a closed folder of state."""
    def words(path):
        with open(os.path.join(folder, "sgad", path), encoding="utf-8") as f:
            return [line.strip() for line in f if line.strip() and line[0] not in "#;"]
    service, socket = words("lib/systemd/system/sgad.service"), words("lib/systemd/system/sgad.socket")
    tally.check({"LoadCredential=sgad.tls-cert", "LoadCredential=sgad.tls-key"} <= set(service), "keys come by LoadCredential", str(service))
    tally.check(not [line for line in service if line.startswith("IPAddress")], "no client is shut out by its address", str(service))
    tally.check(not [line for line in service if line.startswith("MemoryDenyWriteExecute=") and not line.endswith("no")], "machine code is allowed", str(service))
    tally.check({"SocketGroup=sga", "SocketMode=0660"} <= set(socket), "the socket is for a group", str(socket))
    tally.check(words("usr/lib/tmpfiles.d/sgad.conf") == ["d /var/lib/sgad 0700 sgad sgad -"], "systemd-tmpfiles makes a closed folder")


def check_units(tally, folder):
    if not shutil.which("systemd-analyze"):
        return
    place = os.path.join(folder, "sgad")
    root = os.path.join(folder, "root")
    run("cp", "-a", place, root)
    for name in ("basic.target", "sysinit.target", "network.target", "multi-user.target", "sockets.target", "shutdown.target", "-.slice", "system.slice"):
        path = os.path.join("/lib/systemd/system", name)
        if os.path.exists(path):
            shutil.copy(path, os.path.join(root, "lib/systemd/system", name))
    os.makedirs(os.path.join(root, "bin"), exist_ok=True)
    shutil.copy("/bin/kill", os.path.join(root, "bin"))
    found = run("systemd-analyze", "verify", "--man=no", f"--root={root}", "sgad.service", "sgad.socket", timeout=60)
    tally.check(found.returncode == 0 and "sgad" not in found.stderr, "systemd-analyze verify", found.stderr)
    found = run("systemd-analyze", "security", "--offline=true", os.path.join(place, "lib/systemd/system/sgad.service"), timeout=60)
    level = re.search(r"exposure level for sgad.service: ([0-9.]+)", found.stdout)
    tally.check(level and float(level[1]) < 2, "systemd-analyze security: exposure below 2", found.stdout[-200:] + found.stderr)
    found = run("systemd-sysusers", f"--root={root}", timeout=60)
    with open(os.path.join(root, "etc/passwd"), encoding="utf-8") as users, open(os.path.join(root, "etc/group"), encoding="utf-8") as groups:
        tally.check(re.search(r"^sgad:[^:]*:\d+:\d+:.*:/usr/sbin/nologin$", users.read(), re.M) and {"sga", "sgad"} <= {g.split(":")[0] for g in groups}, "systemd-sysusers makes user and groups", found.stderr)


def main():
    tally = Tally("deb")
    check_versions(tally)
    check_container(tally)
    with tempfile.TemporaryDirectory(prefix="sgad-deb-") as out, tempfile.TemporaryDirectory() as folder:
        made = build(out, DEB_BUILD_OPTIONS="noopt parallel=2")      # half of the time; tests/deb_root.py tries those that are optimised
        there = packages(out)
        if tally.check(made.returncode == 0 and set(there) == set(BINARY), "make deb", str(sorted(there)) + (made.stdout + made.stderr)[-2000:]):
            check_lintian(tally, out)
            check_files(tally, out, there, folder)
            check_words(tally, folder)
            check_units(tally, folder)
            with open(os.path.join(folder, "sgad/usr/share/sgad/grafana/sgad.json"), encoding="utf-8") as f:
                tally.check(json.load(f).get("panels"), "the dashboard is one")
    return tally.end()


if __name__ == "__main__":
    sys.exit(main())
