"""A server of PostgreSQL of our own: a folder, a UNIX socket in it, no network; ended by its process id."""
import glob
import os
import pwd
import shutil
import signal
import subprocess
import tempfile
import time


class Cluster:
    """Used as a context. The server refuses to run as root: there it is the user postgres of Debian's package."""

    def __init__(self, **settings):
        found = sorted(glob.glob("/usr/lib/postgresql/*/bin"))
        if not found:
            raise RuntimeError("PostgreSQL is not installed (tests/setup)")
        self.bin, self.process, self.settings = found[-1], None, {"listen_addresses": "", "max_connections": "60", "fsync": "on", **settings}
        self.folder = tempfile.mkdtemp(prefix="sgad-pg-")
        self.user = "postgres" if os.geteuid() == 0 else pwd.getpwuid(os.geteuid()).pw_name
        if os.geteuid() == 0:
            os.chown(self.folder, pwd.getpwnam("postgres").pw_uid, -1)
        os.chmod(self.folder, 0o755)
        self.data = os.path.join(self.folder, "data")

    def address(self, database="postgres"):
        return f"postgresql://{self.user}@/{database}?host={self.folder}"

    def command(self, *words):
        as_user = ["setpriv", "--reuid=postgres", "--regid=postgres", "--clear-groups"] if os.geteuid() == 0 else []
        return [*as_user, os.path.join(self.bin, words[0]), *words[1:]]

    def run(self, *words, **more):
        return subprocess.run(self.command(*words), capture_output=True, text=True, timeout=60, check=True, cwd=self.folder, **more)

    def __enter__(self):
        self.run("initdb", "-D", self.data, "-A", "trust", "-U", self.user, "-E", "UTF8", "--no-locale")
        self.start()
        return self

    def __exit__(self, *_):
        try:
            self.stop()
        finally:
            shutil.rmtree(self.folder, ignore_errors=True)

    def start(self):
        options = [w for k, v in self.settings.items() for w in ("-c", f"{k}={v}")]
        with open(os.path.join(self.folder, "log"), "ab") as log:
            self.process = subprocess.Popen(self.command("postgres", "-D", self.data, "-k", self.folder, *options), stdout=log, stderr=log, cwd=self.folder)
        end = time.monotonic() + 30
        while subprocess.run(self.command("pg_isready", "-q", "-h", self.folder), check=False, cwd=self.folder).returncode != 0:
            if time.monotonic() > end or self.process.poll() is not None:
                with open(os.path.join(self.folder, "log"), encoding="utf-8") as f:
                    raise RuntimeError("the server does not start: " + f.read()[-1000:])
            time.sleep(0.05)

    def stop(self, how=signal.SIGINT):
        """SIGINT: fast; SIGQUIT: immediate, as after a crash."""
        if self.process and self.process.poll() is None:
            self.process.send_signal(how)
            self.process.wait(30)

    def standby(self):
        """A copy that follows this one; not started yet."""
        other = Cluster()
        self.run("pg_basebackup", "-D", other.data, "-h", self.folder, "-U", self.user, "-R", "-X", "stream", "-c", "fast")
        return other

    def promote(self):
        self.run("pg_ctl", "-D", self.data, "-w", "promote")

    def database(self, name):
        self.sql(f"CREATE DATABASE {name}")
        return self.address(name)

    def sql(self, text, database="postgres"):
        """The rows, each a list of texts."""
        out = self.run("psql", "-h", self.folder, "-U", self.user, "-d", database, "-X", "-A", "-t", "-q", "-F", "\t", "-c", text).stdout
        return [line.split("\t") for line in out.splitlines()]
