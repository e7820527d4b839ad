"""The shim between the daemon and the C library (shim.c): faults that are switched while the daemon runs, and the
record of what reached the disk."""
import contextlib
import mmap
import os
import struct
import subprocess
import tempfile

from daemon import Daemon

HERE = os.path.dirname(os.path.abspath(__file__))
WORDS = ("spawn", "write", "sync", "clock", "kind", "nth", "length", "failed")
KINDS = ("", "write", "sync", "open", "spawn", "memory", "clock", "log")
SIZE = 64 * 8
COUNTS = len(WORDS)


def sanitized(build):
    """Sanitizers want to be loaded before all else: there the shim is left out."""
    return "-" in os.path.basename(os.path.normpath(build))


class Shim:
    """`env` is for the daemon; each has a control file of its own."""

    def __init__(self, folder, library=None):
        self.library, self.file = library or compiled(folder), os.path.join(folder, "faults")
        with open(self.file, "wb") as f:
            f.write(bytes(SIZE))
        with open(self.file, "r+b") as f:
            self.words = mmap.mmap(f.fileno(), SIZE)
        self.env = {"LD_PRELOAD": self.library, "SHIM_FILE": self.file}

    def _put(self, at, value):
        self.words[8 * at:8 * at + 8] = struct.pack("<q", value)

    def _get(self, at):
        return struct.unpack_from("<q", self.words, 8 * at)[0]

    def set(self, **faults):
        """These faults and no others."""
        for at, name in enumerate(WORDS[:4]):
            self._put(at, faults.pop(name, 0))
        assert not faults, faults

    def arm(self, kind, nth, length=1):
        """The nth call from now fails, and so do those after it, `length` of them."""
        self._put(WORDS.index("failed"), 0)
        for k in range(1, len(KINDS)):
            self._put(COUNTS + k, 0)
        self._put(WORDS.index("nth"), nth)
        self._put(WORDS.index("length"), length)
        self._put(WORDS.index("kind"), KINDS.index(kind))

    def disarm(self):
        self.set()
        self._put(WORDS.index("kind"), 0)

    def count(self, kind):
        """Calls of this kind since arm()."""
        return self._get(COUNTS + KINDS.index(kind))

    def failed(self):
        return self._get(WORDS.index("failed"))


def compiled(folder):
    library = os.path.join(folder, "shim.so")
    subprocess.run(["cc", "-shared", "-fPIC", "-O1", "-Wall", "-Wextra", "-Werror", "-o", library, os.path.join(HERE, "shim.c"), "-ldl", "-lpthread"], check=True)
    return library


@contextlib.contextmanager
def shim():
    """For a test's own faults; under faults in turn (turns.py) these and that one."""
    if Daemon.guest:
        yield Daemon.guest.shim
        return
    with tempfile.TemporaryDirectory(prefix="sgad-shim-") as folder:
        yield Shim(folder)
