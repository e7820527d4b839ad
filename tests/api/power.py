"""power.py BUILD_DIR [IMAGES]: the power fails.

A daemon's writes, syncs and changes of names below its state folder are recorded (shim.c) while clients post, wait and cancel, and what
each client heard is noted with the record's length at that moment. Then the disk is made as a loss of power at some moment may leave it: what was
synced is there; of what was not, each write is there whole, not at all, or in some of its sectors, and the folder's changes are there
up to some point. On each such disk a daemon is started: what clients had been told by that moment still holds, and every job that was
accepted ends with its own answer. SGA_TEST_SEED sets the seed, which is printed."""
import json
import os
import random
import struct
import sys
import tempfile
import threading

HERE = os.path.dirname(os.path.abspath(__file__))
sys.path[:0] = [HERE, os.path.dirname(HERE)]

from common import slow  # noqa: E402
from daemon import Daemon  # noqa: E402
from history import History  # noqa: E402
from kill import GONE, request  # noqa: E402
from shim import Shim, sanitized  # noqa: E402
from tally import Tally  # noqa: E402

HEAD = struct.Struct("<IIQQQ")
MADE, WROTE, CUT, SYNCED, UNLINKED, RENAMED = range(1, 7)
SECTOR = 512


def operations(data):
    """(place in the record, what, name, at, bytes or length, begun) one after the other."""
    at = 0
    while at + HEAD.size <= len(data):
        what, path, where, length, begun = HEAD.unpack_from(data, at)
        name = data[at + HEAD.size:at + HEAD.size + path].decode()
        end = at + HEAD.size + path + (length if what == WROTE else 0)
        yield at, what, name, where, data[end - length:end] if what == WROTE else length, begun
        at = end


class File:
    def __init__(self):
        self.durable, self.pending = bytearray(), []      # pending: (place, at or new length, bytes or None)

    @staticmethod
    def put(content, at, data):
        if data is None:
            del content[at:]
            content.extend(bytes(at - len(content)))
            return
        if len(content) < at + len(data):
            content.extend(bytes(at + len(data) - len(content)))
        content[at:at + len(data)] = data

    def synced(self, begun):
        for _, at, data in [p for p in self.pending if p[0] < begun]:
            self.put(self.durable, at, data)
        self.pending = [p for p in self.pending if p[0] >= begun]

    def after(self, rng, share):
        """Content that a loss of power may leave; share: how likely a piece of what was not synced is there."""
        content = bytearray(self.durable)
        for _, at, data in self.pending:
            if data is None:
                if rng.random() < share:
                    self.put(content, at, None)
                continue
            torn = rng.random() < 0.3
            whole = rng.random() < share
            for k in range(0, len(data), SECTOR):
                if (rng.random() < share) if torn else whole:
                    self.put(content, at + k, data[k:k + SECTOR])
        return content


class Disk:
    """What the record says up to a place."""

    def __init__(self, record, upto, syncs=True):
        """syncs: False for a disk that says it did and did not, which must be noticed."""
        self.now, self.durable, self.changes = {}, {}, []       # names: as the daemon sees them, as they are safe; changes: (place, names after it)
        for place, what, name, at, data, begun in operations(record):
            if place >= upto:
                break
            if what in (MADE, UNLINKED, RENAMED):
                self.rename(place, what, name)
            elif what == SYNCED and not syncs:
                continue
            elif what == SYNCED and name == ".":
                for changed, names in [c for c in self.changes if c[0] < begun]:
                    self.durable = names
                self.changes = [c for c in self.changes if c[0] >= begun]
            elif name in self.now:
                f = self.now[name]
                if what == SYNCED:
                    f.synced(begun)
                else:
                    f.pending.append((place, at, data if what == WROTE else None))

    def rename(self, place, what, name):
        names = dict(self.now)
        if what == MADE:
            names[name] = File()
        elif what == UNLINKED:
            names.pop(name, None)
        else:
            old, new = name.split("\0")
            if old in names:
                names[new] = names.pop(old)
        self.now = names
        self.changes.append((place, names))

    def write(self, folder, rng, share):
        names = ([self.durable] + [names for _, names in self.changes])[min(len(self.changes), int((len(self.changes) + 1) * rng.random() ** (1.01 - share)))]
        for name, f in names.items():
            with open(os.path.join(folder, name), "wb") as out:
                out.write(f.after(rng, share))
            os.chmod(os.path.join(folder, name), 0o600)


class Listener:
    """Notes what is heard, with the record's length when it was."""

    def __init__(self, record):
        self.record, self.lock, self.events = record, threading.Lock(), []

    def env(self):
        return {}

    def heard(self, _, method, path, answer, headers=None):
        place = os.stat(self.record).st_size
        with self.lock:
            self.events.append((place, method, path, answer, headers))

    def began(self, d):
        pass

    ended = left = lost = lambda *_: None


def scene(d, rng, numbers):
    """Clients post, wait, cancel and look; some jobs wait behind a long one."""
    def one(seed):
        own = random.Random(seed)
        for _ in range(25):
            k = next(numbers)
            try:
                way = own.random()
                if way < 0.5:
                    d.ask("POST", "/v1/solve", request(k))
                elif way < 0.8:
                    d.ask("POST", "/v1/jobs", request(k))
                else:
                    job = d.ask("POST", "/v1/jobs", slow()).json()
                    d.ask("DELETE", "/v1/jobs/" + job["id"])
            except GONE:
                pass
    threads = [threading.Thread(target=one, args=(rng.random(),)) for _ in range(3)]
    for t in threads:
        t.start()
    for t in threads:
        t.join()


def record_of(build, folder, rng):
    """The record of a daemon's whole life, and what was heard."""
    state, path = os.path.join(folder, "state"), os.path.join(folder, "record")
    os.makedirs(os.path.join(state, "sgad"))
    listener = Listener(path)
    shim = Shim(folder)
    env = {**shim.env, "SHIM_RECORD": path, "SHIM_FOLDER": os.path.join(state, "sgad")}
    with Daemon(build, "--workers", "2", state=state, env=env) as d:
        d.guest = listener
        scene(d, rng, iter(range(2, 10**9)))
        d.guest = None
    with open(path, "rb") as f:
        return f.read(), listener.events


def check_image(build, check, disk, heard, upto, rng, share, note):
    with tempfile.TemporaryDirectory(prefix="sgad-power-") as state:
        os.makedirs(os.path.join(state, "sgad"), mode=0o700)
        disk.write(os.path.join(state, "sgad"), rng, share)
        history = History(check, lambda: True)      # results may be dropped: they are not synced
        for place, method, path, answer, headers in heard:
            if place <= upto:
                history.heard(method, path, answer, headers)
        try:
            with Daemon(build, state=state) as d:
                history.holds(lambda id_, headers: d.ask("GET", "/v1/jobs/" + id_, headers=headers), note)
                # those whose answer nobody heard are accepted too: a long one among them holds a worker
                for id_ in [i for i in {**history.promised, **there(d)} if not long_one(d, check, i, note)]:
                    right(d, check, id_, note)
        except (*GONE, RuntimeError) as e:
            check(False, "it starts after a loss of power", (note, type(e).__name__, e))


def asked_for(d, check, id_, note):
    """The system that the job is about; None: it is not there."""
    a = d.get(f"/v1/jobs/{id_}/request")
    return json.loads(a.body)["system"] if check(a.status == 200, "the request is there", (note, id_, a.status, a.body[:200])) else None


def there(d):
    """The jobs that the daemon lists (fewer than a page), by id."""
    return {job["id"]: job for job in d.get("/v1/jobs?limit=500").json()["jobs"]}


def long_one(d, check, id_, note):
    """Those are ended, so that the others have their turn; what is not there is nothing to wait for either."""
    system = asked_for(d, check, id_, note)
    if system and system["form"] == "quasilinear":
        return False
    d.ask("DELETE", "/v1/jobs/" + id_)
    return True


def right(d, check, id_, note):
    """It ends with the answer to its own request."""
    system = asked_for(d, check, id_, note)
    job = d.wait(id_)
    answer = (job.get("result") or {}).get("vector_field", {}).get("components", {}).get("x")
    check(system and job["status"] == "done" and answer == system["alpha"][0], "the job's own answer", (note, job["status"], answer, system))


def losses(build, check, images):
    seed = int(os.environ.get("SGA_TEST_SEED", "20261125"))
    print(f"seed {seed}, {images} losses of power", flush=True)
    rng = random.Random(seed)
    with tempfile.TemporaryDirectory(prefix="sgad-power-") as folder:
        record, heard = record_of(build, folder, rng)
    syncs = [place for place, what, *_ in operations(record) if what == SYNCED]
    check(len(syncs) > 20 and heard, "there is something to lose", (len(record), len(syncs), len(heard)))
    for k in range(images):
        upto = rng.choice(syncs) + rng.choice((0, 1)) if k % 2 else rng.randrange(len(record))
        upto = next((place for place, *_ in operations(record) if place >= upto), len(record))     # an operation is there or not
        check_image(build, check, Disk(record, upto), heard, upto, rng, rng.choice((0, 0.2, 0.5, 0.9, 1)), f"image {k}, {upto} of {len(record)} bytes")
    lies(build, check, record, heard, rng)


def lies(build, check, record, heard, rng):
    """The check itself: what a disk that does not sync loses is seen."""
    found = []
    check_image(build, lambda ok, *_: bool(ok) or found.append(ok) or False, Disk(record, len(record), syncs=False), heard, len(record), rng, 0, "no syncs")
    check(found, "a disk that does not sync is noticed")


def power(build, c):
    """Some losses among the tests of the API."""
    if not sanitized(build):
        losses(build, c, int(os.environ.get("SGA_TEST_POWER", "12")))


ALL = [power]

if __name__ == "__main__":
    TALLY = Tally("power")
    losses(sys.argv[1], lambda ok, label, detail="": TALLY.check(ok, label, str(detail)[:900]), int(sys.argv[2]) if len(sys.argv) > 2 else 300)
    sys.exit(TALLY.end())
