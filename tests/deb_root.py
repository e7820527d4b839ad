"""The Debian packages where a user has them: deb_root.py BUILD_DIR [PACKAGES]         (make deb-test; as root, with a Debian mirror)

Two builds (not where a folder of packages is given) in two folders, by other users' habits (umask, language, time zone), give the same bytes. Then in a fresh root, made by
debootstrap from the mirror that apt has here: installed by apt, programs and example run, the service is started by its ExecStart as its
user, keeps its jobs and settings over an upgrade and a removal, and a purge leaves nothing. The last stage of the container file is
carried out in such a root too; with FULL=1 in the environment its first stage as well. No systemd runs there: what only it does
(starting units, credentials, its sandbox) is not tried here.
"""
import glob
import hashlib
import json
import os
import re
import shlex
import shutil
import stat
import subprocess
import sys
import tempfile

from deb_check import ROOT, build, packages, run, text_of, version
from tally import Tally, build_folder

ADDRESS = "http://127.0.0.1:8080"
# What any installing changes, and no package of ours owns.
ANYONES = re.compile(r"(proc|sys|dev|run|tmp|root|pkg|later|var/log|var/cache|var/lib/apt|var/lib/dpkg|var/tmp)(/|$)|etc/(passwd|group|shadow|gshadow|subuid|subgid)-$|etc/ld\.so\.cache$|etc/\.pwd\.lock$|"
                     r"var/lib/systemd/(catalog|random-seed)")


def digests(out):
    found = {}
    for path in sorted(glob.glob(os.path.join(out, "*.deb")) + glob.glob(os.path.join(out, "*.tar.*"))):
        with open(path, "rb") as f:
            found[os.path.basename(path)] = hashlib.sha256(f.read()).hexdigest()
    return found


def same_twice(tally, folder):
    """The packages; None: there are none."""
    one, two = os.path.join(folder, "one"), os.path.join(folder, "another place", "deeper")
    copy = os.path.join(folder, "copy")
    shutil.copytree(ROOT, copy, ignore=lambda at, names: [n for n in names if at == ROOT and n.startswith(("build", ".git")) or n == "__pycache__"])
    made = build(one, copy)
    if not tally.check(made.returncode == 0, "make deb", (made.stdout + made.stderr)[-2000:]):
        return None
    two = two.replace(" ", "-")
    made = run("bash", "-c", 'umask 077 && exec make -C "$1" --no-print-directory DEB="$2" deb', "bash", copy, two, timeout=1700,
               env={**os.environ, "TZ": "Asia/Tokyo", "LC_ALL": "C.UTF-8", "HOME": folder, "DEB_BUILD_OPTIONS": "parallel=1", "CCACHE_DISABLE": "1"})
    tally.check(made.returncode == 0, "make deb elsewhere", (made.stdout + made.stderr)[-2000:])
    a, b = digests(one), digests(two)
    tally.check(len(a) >= 8 and a == b, "two builds give the same bytes", str([name for name in a if a[name] != b.get(name)]))
    return one


class Root:
    """A Debian in a folder."""

    def __init__(self, tally, path):
        self.tally, self.path = tally, path

    def make(self):
        site = run("apt-get", "indextargets", "--format", "$(SITE) $(RELEASE)", "Created-By: Packages").stdout.split()
        here = dict(line.split("=", 1) for line in open("/etc/os-release", encoding="utf-8").read().split("\n") if "=" in line)["VERSION_CODENAME"].strip('"')
        mirror = next(s for s, release in zip(site[::2], site[1::2]) if release == here)
        made = run("debootstrap", "--variant=minbase", here, self.path, mirror, timeout=1700)
        return self.tally.check(made.returncode == 0, "debootstrap", made.stdout[-500:] + made.stderr[-500:])

    def sh(self, script, net=False):
        """A script in it. Without net: loopback of its own; what it starts ends with it."""
        prepare = ("" if net else "ip link set lo up && ") + 'mount -t proc proc "$1/proc" && exec chroot "$1" /bin/sh -ec "$2"'
        return run("unshare", "--mount", "--pid", "--fork", *([] if net else ["--net"]), "sh", "-ec", prepare, "sh", self.path, script, timeout=1700,
                   env={"PATH": "/usr/sbin:/usr/bin:/sbin:/bin", "LC_ALL": "C.UTF-8", "DEBIAN_FRONTEND": "noninteractive", **{k: v for k, v in os.environ.items() if k.endswith("_proxy")}})

    def good(self, label, script, net=False):
        done = self.sh(script, net)
        self.tally.check(done.returncode == 0, label, done.stdout[-800:] + done.stderr[-800:])
        return done.stdout

    def text(self, path):
        with open(os.path.join(self.path, path), encoding="utf-8") as f:
            return f.read()

    def snapshot(self):
        found = {}
        for at, folders, files in os.walk(self.path):
            for name in folders + files:
                path = os.path.join(at, name)
                short = os.path.relpath(path, self.path)
                if ANYONES.match(short):
                    continue
                s = os.lstat(path)
                held = os.readlink(path) if stat.S_ISLNK(s.st_mode) else ""
                if stat.S_ISREG(s.st_mode):
                    with open(path, "rb") as f:
                        held = hashlib.sha256(f.read()).hexdigest()
                found[short] = (s.st_mode, s.st_uid, s.st_gid, held)
            folders[:] = [f for f in folders if not ANYONES.match(os.path.relpath(os.path.join(at, f), self.path) + "/")]
        return found


def raised(folder, there):
    """The same packages, of a later version."""
    out = os.path.join(folder, "later")
    os.makedirs(out)
    for name, path in there.items():
        place = os.path.join(folder, "raised-" + name)
        run("dpkg-deb", "-R", path, place)
        control = os.path.join(place, "DEBIAN/control")
        with open(control, encoding="utf-8") as f:
            text = f.read()
        v = version()
        text = text.replace(f"Version: {v}\n", f"Version: {v}+later\n").replace(f"(= {v})", f"(= {v}+later)")
        with open(control, "w", encoding="utf-8") as f:
            f.write(text)
        run("dpkg-deb", "--root-owner-group", "-b", place, out)
    return out


# $1...: what is asked once it listens.
SERVICE = r"""
unit=/lib/systemd/system/sgad.service
line=$(sed -n 's/^ExecStart=//p' $unit) user=$(sed -n 's/^User=//p' $unit)
[ "$user" = sgad ]
: >/tmp/out                              # what an earlier one said is not taken for this one's
setpriv --reuid=$user --regid=$user --init-groups --bounding-set=-all --inh-caps=-all --no-new-privs env -i PATH=/usr/bin:/bin STATE_DIRECTORY=/var/lib/sgad \
    $line >/tmp/out 2>/tmp/err &
pid=$!
n=0
until grep -q 'listening on' /tmp/out; do n=$((n + 1)); [ $n -lt 600 ] || { cat /tmp/err; exit 1; }; sleep 0.1; done
[ "$(cat /tmp/out)" = "listening on http://127.0.0.1:8080" ] || { cat /tmp/out; exit 1; }
sga ready --server http://127.0.0.1:8080 >&2
%s
kill $pid
wait $pid
grep -q '"event":"formulas"' /tmp/err
"""
PYTHON = "import sga, sys\nr = sga.Client(sys.argv[1]).solve({'system': {'form': 'equations', 'variables': ['x', 'y'], 'equations': [\"x' = y\", 'x^2 + y^2 = 1']}})\nprint(r.verdict)\n"


def in_a_root(tally, folder, out, root):
    there = packages(out)
    there.pop("octave-sga")            # as files only: Octave is large
    os.makedirs(os.path.join(root.path, "pkg"))
    for path in there.values():
        shutil.copy(path, os.path.join(root.path, "pkg"))
    later = raised(folder, there)
    shutil.copytree(later, os.path.join(root.path, "later"))
    depends = set()
    for path in there.values():
        for field in ("Depends", "Pre-Depends"):
            depends |= {d.strip() for d in run("dpkg-deb", "-f", path, field).stdout.split(",") if d.strip() and not d.strip().startswith("libsga0")}
    root.good("dependencies can be had", f"apt-get -qq update; apt-get -qq satisfy -y --no-install-recommends {shlex.quote(', '.join(sorted(depends)))}; "
              "apt-get -qq install -y --no-install-recommends gcc libc6-dev libjansson-dev pkg-config", net=True)
    before = root.snapshot()
    root.good("apt install ./*.deb", "cd /pkg; apt-get -qq install -y --no-install-recommends ./*.deb", net=True)
    root.good("programs run", "sga version; sgad --version; sgad --check-config --config /etc/sgad.conf --state /var/lib/sgad; sga solve /usr/share/doc/sga/examples/pendulum.json --json | grep unique")
    tally.check(os.lstat(os.path.join(root.path, "var/lib/sgad")).st_mode & 0o7777 == 0o700, "the folder of state is there, closed")
    said = root.good("the example is built against libsga-dev", "cc -Wall -Wextra -Werror /usr/share/doc/sga/examples/pendulum.c $(pkg-config --cflags --libs sga) -ljansson -o /tmp/pendulum; /tmp/pendulum")
    tally.check(re.fullmatch(r"constraints: 3, index 3\nx\(1\) = -?0\.\d{6}, y\(1\) = -?0\.\d{6}\n", said), "the example runs", said)
    said = root.good("the units are sound", "systemd-analyze verify --man=no sgad.service sgad.socket 2>&1; getent group sga")
    tally.check("sgad" not in said.replace("sga:x", ""), "systemd-analyze verify says nothing", said)
    said = root.good("the service answers", SERVICE % (f"sga solve /usr/share/doc/sga/examples/pendulum.json --server {ADDRESS} --json\n"
                                                       f"python3 -c {shlex.quote(PYTHON)} {ADDRESS} >/tmp/python\n[ \"$(cat /tmp/python)\" = unique ]\ntr '\\0' '\\n' </proc/$pid/status >/tmp/status"))
    tally.check(said.startswith("{") and json.loads(said)["verdict"] == "unique", "it solves", said[:300])
    tally.check(re.search(r"^CapEff:\s+0+$", root.text("tmp/status"), re.M) and not re.search(r"^Uid:\s+0\b", root.text("tmp/status"), re.M), "as its user, with no capability")
    root.good("a token before the next start, the settings changed", "sgad token create --state /var/lib/sgad --name ann --scope read >/tmp/token; echo 'workers = 1' >>/etc/sgad.conf; chown -c sgad /var/lib/sgad/tokens.db")
    root.good("upgrade", "cd /later; apt-get -qq install -y --no-install-recommends ./*.deb; dpkg-query -W -f '${Version}' sgad | grep later; grep -q '^workers = 1' /etc/sgad.conf", net=True)
    said = root.good("after the upgrade", SERVICE % f"sga list --server {ADDRESS} --json")
    tally.check([j["name"] for j in json.loads(said)["jobs"] if j["name"]] == ["pendulum"], "the jobs are there", said[:300])
    root.good("removal keeps settings and state", "apt-get -qq remove -y sgad; test -e /etc/sgad.conf; test -e /var/lib/sgad/queue.db; test ! -e /usr/bin/sgad; test ! -e /lib/systemd/system/sgad.service", net=True)
    root.good("installed again", "cd /later; apt-get -qq install -y --no-install-recommends ./sgad_*.deb", net=True)
    said = root.good("after the removal", SERVICE % f"sga list --server {ADDRESS} --json")
    tally.check(len(json.loads(said)["jobs"]) == 2, "the jobs are there still", said[:300])
    root.good("purge", "dpkg --purge " + " ".join(["sgad", *(p for p in there if p != "sgad")]), net=True)
    shutil.rmtree(os.path.join(root.path, "pkg"))
    shutil.rmtree(os.path.join(root.path, "later"))
    after = root.snapshot()
    left = sorted(p for p in set(before) | set(after) if before.get(p) != after.get(p) and not (p in before and p in after and stat.S_ISDIR(before[p][0])))
    tally.check(not left, "a purge leaves nothing", str(left[:20]))


def instructions(stage):
    """[(word, rest)] of a stage of the container file."""
    lines = re.sub(r"\\\n\s*", "", "\n".join(line for line in stage.splitlines() if not line.startswith("#"))).splitlines()
    return [(line.split(" ", 1)[0], line.split(" ", 1)[1]) for line in lines[1:] if line.strip()]


def container(tally, build_dir, root, folder, full):
    """The commands of the container file, in roots like its base."""
    first, last = text_of("etc/Containerfile").split("\nFROM ")[1:]
    base = sizes(root.path)
    if full:
        source = Root(tally, os.path.join(folder, "stage"))
        run("cp", "-a", root.path, source.path)
        taken = [line[1:] for line in text_of(".dockerignore").splitlines() if line.startswith("!")]
        for t in taken:
            os.makedirs(os.path.dirname(os.path.join(source.path, "src", t)), exist_ok=True)
            run("cp", "-r", os.path.join(ROOT, t), os.path.join(source.path, "src", t))
        for word, rest in instructions(first):
            if word == "RUN":
                source.good(f"container, first stage: {rest[:40]}", rest, net=True)
        build_dir = os.path.join(source.path, "src/build")
    for program in ("sgad", "sga"):
        run("strip", "-o", os.path.join(root.path, "usr/bin", program), os.path.join(build_dir, program))
    entry = health = user = None
    for word, rest in instructions(last):
        if word == "RUN":
            root.good("container: " + rest[:40], rest, net=True)
        user = rest if word == "USER" else user
        entry = json.loads(rest) if word == "ENTRYPOINT" else entry
        health = json.loads(rest[rest.index("["):]) if word == "HEALTHCHECK" else health
    state = os.path.join(root.path, "var/lib/sgad")
    run("openssl", "req", "-x509", "-newkey", "ec", "-pkeyopt", "ec_paramgen_curve:P-256", "-nodes", "-days", "2", "-subj", "/CN=localhost", "-addext", "subjectAltName=DNS:localhost",
        "-keyout", state + "/key.pem", "-out", state + "/cert.pem")
    owner = os.stat(state)
    for name in ("key.pem", "cert.pem"):
        os.chown(os.path.join(state, name), owner.st_uid, owner.st_gid)
    as_user = f"setpriv --reuid={user} --regid={user} --init-groups --bounding-set=-all --inh-caps=-all --no-new-privs "
    command = as_user + shlex.join(entry + ["--tls-cert", "/var/lib/sgad/cert.pem", "--tls-key", "/var/lib/sgad/key.pem", "--allow-host", "localhost"])
    probe = as_user + shlex.join(health)
    root.good("container: the entry starts, its health is seen", f"""
{command} >/tmp/out 2>/tmp/err &
pid=$!
n=0
until grep -q 'listening on' /tmp/out; do n=$((n + 1)); [ $n -lt 600 ] || {{ cat /tmp/err; exit 1; }}; sleep 0.1; done
{probe}
kill $pid
wait $pid
! {probe}
""")
    grown = sizes(root.path) - base
    print(f"container: {base:.0f} MB of the base and {grown:.0f} MB", flush=True)
    tally.check(grown < 80 and not os.path.exists(os.path.join(root.path, "usr/bin/gcc")), "container: small", f"{grown:.0f} MB")


def sizes(path):
    """Megabytes, without what every image leaves out: lists and archives of apt."""
    total = 0
    for at, folders, files in os.walk(path):
        if os.path.relpath(at, path) in ("proc", "var/lib/apt/lists", "var/cache/apt"):
            folders[:], files = [], []
        total += sum(s.st_size for s in (os.lstat(os.path.join(at, f)) for f in files) if stat.S_ISREG(s.st_mode))
    return total / 1e6


def main():
    tally, build_dir = Tally("deb-root"), build_folder()
    if os.geteuid() != 0:
        sys.exit("deb_root.py: debootstrap and chroot need root")
    with tempfile.TemporaryDirectory(prefix="sgad-root-") as folder:
        out = os.path.abspath(sys.argv[2]) if len(sys.argv) > 2 else same_twice(tally, folder)
        root = Root(tally, os.path.join(folder, "root"))
        if out and root.make():
            base = Root(tally, os.path.join(folder, "base"))
            run("cp", "-a", root.path, base.path)
            in_a_root(tally, folder, out, root)
            container(tally, build_dir, base, folder, bool(os.environ.get("FULL")))
    return tally.end()


if __name__ == "__main__":
    sys.exit(main())
