"""chaos.py BUILD_DIR [JOBS]: daemons that share a database of PostgreSQL, and everything that can happen to them while clients post.

Three daemons are killed, stopped for longer than a lease, and cut off; their server crashes, its connections stall, and once, half way, it is lost
with its disk and its synchronous standby takes its place. Whatever was accepted ends, once, with its own answer, and no end is taken back.
SGA_TEST_SEED sets the seed, which is printed."""
import http.client
import os
import random
import shutil
import signal
import sys
import threading
import time

HERE = os.path.dirname(os.path.abspath(__file__))
sys.path[:0] = [HERE, os.path.dirname(HERE)]

from cluster import Cluster  # noqa: E402
from common import trivial  # noqa: E402
from daemon import Daemon  # noqa: E402
from shared import ENDS, Relay, flags, prepared, until  # noqa: E402
from tally import Tally, scaled, seed  # noqa: E402

KINDS = ["kill", "kill", "kill", "stand", "cut", "stall", "crash"]


class Clients:
    """They post to one daemon after the other and note what was accepted; of some they see the end, and note that."""

    def __init__(self, daemons, count, wrong):
        self.daemons, self.wrong, self.accepted, self.ends, self.stop = daemons, wrong, {}, {}, threading.Event()
        self.threads = [threading.Thread(target=self.client, args=(n,)) for n in range(count)]
        for t in self.threads:
            t.start()

    def client(self, n):
        chance = random.Random(n)
        while not self.stop.is_set():
            request = trivial()
            try:
                a = chance.choice(self.daemons).ask("POST", "/v1/jobs", request, seconds=20)
                if a.status not in (200, 202):
                    continue
                id_ = a.json()["id"]
                self.accepted[id_] = request
                if chance.random() < 0.2:
                    self.look(chance.choice(self.daemons), id_, {"Prefer": "wait=5"})
            except (OSError, http.client.HTTPException, ValueError):
                time.sleep(0.05)

    def look(self, d, id_, headers=None):
        a = d.ask("GET", "/v1/jobs/" + id_, headers=headers, seconds=20)
        if a.status != 200:
            return None
        job = a.json()
        if job["finished"]:
            end = (job["status"], job["finished"])
            first = self.ends.setdefault(id_, end)
            if first != end:
                self.wrong.append((id_, first, end))
        return job

    def end(self):
        self.stop.set()
        for t in self.threads:
            t.join()


class Chaos:
    def __init__(self, build, first, second, relay, address):
        self.server, self.spare, self.relay = first, second, relay
        self.daemons = [Daemon(build, *flags(address, "--log-level", "warn", "--queue", "100000")) for _ in range(3)]

    def sql(self, text):
        return self.server.sql(text, "chaos")

    @staticmethod
    def start(d):
        """As a supervisor does: one that finds no database at its start is started again."""
        for left in reversed(range(10)):
            try:
                d.start()
                return
            except RuntimeError:
                if not left:
                    raise
                d.process.wait(10)
                time.sleep(0.5)

    def happen(self, what, d):
        if what == "kill":
            d.process.kill()
            d.ended()
            self.start(d)
        elif what == "stand":
            d.process.send_signal(signal.SIGSTOP)
            time.sleep(4)
            d.process.send_signal(signal.SIGCONT)
        elif what == "cut":
            self.relay.cut()
        elif what == "stall":
            self.relay.open.clear()
            time.sleep(4)
            self.relay.open.set()
        elif what == "crash":
            self.server.stop(signal.SIGQUIT)
            self.server.start()
        else:
            self.promote()

    def promote(self):
        self.server.stop(signal.SIGQUIT)
        shutil.rmtree(self.server.data)
        self.spare.promote()
        self.server = self.spare
        self.relay.to = os.path.join(self.server.folder, ".s.PGSQL.5432")
        self.relay.cut()
        self.sql("ALTER SYSTEM SET synchronous_standby_names = ''")      # nobody stands by the new one
        self.sql("SELECT pg_reload_conf()")


def checked(chaos, clients, c):
    """After it all."""
    c(until(lambda: chaos.sql("SELECT count(*) FROM sgad.jobs WHERE status < 2") == [["0"]], 300), "all that was accepted ends")
    rows = {r[0]: r[1] for r in chaos.sql("SELECT id, status FROM sgad.jobs")}
    lost = [i for i in clients.accepted if i not in rows]
    c(len(clients.accepted) > 20 and not lost, "none is lost", (len(clients.accepted), lost[:5]))
    twice = chaos.sql("SELECT id FROM ends GROUP BY id HAVING count(*) > 1")
    c(twice == [], "none ends twice", twice[:5])
    c(chaos.sql("SELECT id FROM sgad.jobs WHERE status = 2 AND id NOT IN (SELECT id FROM sgad.results)") == [], "each has its result")
    mixed = []
    for n, (id_, request) in enumerate(clients.accepted.items()):
        job = clients.look(chaos.daemons[n % 3], id_)
        if job and job["status"] == "done" and request["system"]["alpha"][0].replace("*", " ").split()[0] in str(job["result"]):
            continue
        if not job or job["status"] != "failed" or job["error"]["code"] != "worker_died":
            mixed.append((id_, job))
    c(not mixed, "each has its own", mixed[:3])
    c(not clients.wrong, "no end that was told is taken back", clients.wrong[:3])
    again = chaos.sql("SELECT count(*) FROM sgad.jobs WHERE attempts > 0")[0][0]
    print(f"{len(clients.accepted)} accepted, {len(lost)} lost, {len(twice)} ended twice, {len(mixed)} mixed up; {sum(s == '2' for s in rows.values())} done,"
          f" {sum(s == '3' for s in rows.values())} died three times, {again} ran again, {len(clients.ends)} ends told", flush=True)


def run(build, c, rounds, jobs, count):
    """Until so many rounds are over and so many jobs were accepted."""
    chance, happened = random.Random(seed(20261125)), {}
    with Cluster() as first:
        address = prepared(build, first, "chaos")
        first.sql(ENDS, "chaos")
        second, relay = first.standby(), Relay(first)
        chaos = Chaos(build, first, second, relay, address.replace(first.folder, relay.folder))
        clients = None
        try:
            second.start()
            first.sql("ALTER SYSTEM SET synchronous_standby_names = '*'")
            first.sql("SELECT pg_reload_conf()")
            c(until(lambda: first.sql("SELECT sync_state FROM pg_stat_replication") == [["sync"]]), "a synchronous standby")
            for d in chaos.daemons:
                d.start()
            clients = Clients(chaos.daemons, count, [])
            done = 0
            while done < rounds or len(clients.accepted) < jobs:
                time.sleep(chance.uniform(0.3, 1.2))
                half = chaos.server is first and 2 * done >= rounds and 2 * len(clients.accepted) >= jobs
                what = "promote" if half else chance.choice(KINDS)
                happened[what] = happened.get(what, 0) + 1
                chaos.happen(what, chance.choice(chaos.daemons))
                done += 1
            clients.end()
            print("happened:", happened, flush=True)
            checked(chaos, clients, c)
        finally:
            if clients:
                clients.end()
            for d in chaos.daemons:
                d.__exit__()
            relay.close()
            second.__exit__()


def shared_chaos(build, c):
    """Some rounds among the tests of the API."""
    run(build, c, scaled(30), 0, 3)


ALL = [shared_chaos]

if __name__ == "__main__":
    TALLY = Tally("chaos")
    run(sys.argv[1], lambda ok, label, detail="": TALLY.check(ok, label, str(detail)[:900]), 60, int(sys.argv[2]) if len(sys.argv) > 2 else 10000, 8)
    sys.exit(TALLY.end())
