"""What clients were told, and whether it stays true: a history without exceptions.

A 202 is a promise that the job is there, and ends; an end that was told stays as it was told; a refusal is a problem
with its code; nothing ends by a signal but by that of a test."""
import json


class History:
    def __init__(self, check, dropped=lambda: False, pruned=False):
        """dropped() tells whether the log says that results were dropped, as they may be: then a job that was done is done once more.
        pruned: jobs that have ended go; what else is told of them stays true."""
        self.check, self.dropped, self.pruned = check, dropped, pruned
        self.promised, self.told = {}, {}      # by id: the token of its owner, as a header; (status, finished)

    def heard(self, method, path, answer, headers=None):
        """An answer, in the order in which one client hears them."""
        kind = answer.headers.get("content-type", "").split(";")[0]
        if answer.status >= 400 and answer.body:
            self.refused(method, path, answer, kind)
            return
        place = path.partition("?")[0]
        id_ = place[len("/v1/jobs/"):] if place.startswith("/v1/jobs/") else None
        if method == "DELETE" and id_:
            if answer.status == 204:
                self.forget(id_)
        if kind != "application/json" or answer.status not in (200, 202) or not (method == "POST" and place in ("/v1/jobs", "/v1/solve") or id_ and "/" not in id_):
            return
        if method == "POST" and "location" not in answer.headers:
            return                             # an answer for who waited, of a job that could not be kept
        job = json.loads(answer.body)
        if answer.status == 202 and method == "POST":
            self.promised.setdefault(job["id"], {k: v for k, v in (headers or {}).items() if k == "Authorization"})
            self.told.pop(job["id"], None)      # one that had failed or was cancelled begins anew
        if method == "POST" and self.told.get(job["id"], ("done",))[0] != "done":
            self.told.pop(job["id"])            # posted once more, it is run once more
        if job["finished"] is not None:
            end = (job["status"], job["finished"])
            first = self.told.setdefault(job["id"], end)
            if first != end and first[0] == "done" and end[0] == "done" and self.dropped():
                self.told[job["id"]] = end
            else:
                self.check(first == end, "an end that was told stays as it is", (method, path, first, end))

    def lost(self, method, path):
        """A question whose answer did not come: nobody knows whether it was done. What a DELETE was asked for may be gone."""
        id_ = path.partition("?")[0][len("/v1/jobs/"):] if path.startswith("/v1/jobs/") else None
        if method == "DELETE" and id_:
            self.forget(id_)

    def refused(self, method, path, answer, kind):
        try:
            problem = json.loads(answer.body) if kind == "application/problem+json" else None
        except ValueError:
            problem = None
        if answer.status >= 500 or problem:
            self.check(problem and problem.get("status") == answer.status and problem.get("code") not in (None, "internal"), "a refusal says why",
                       (method, path, answer.status, answer.body[:200]))

    def forget(self, id_):
        self.promised.pop(id_, None)
        self.told.pop(id_, None)

    def holds(self, ask, note=""):
        """All promises, asked by ask(id, headers), which answers as Daemon.ask does."""
        for id_, headers in list(self.promised.items()):
            a = ask(id_, headers)
            if a.status == 401 or (a.status == 404 and self.pruned):                # its token was revoked; it ended and went
                continue
            if not self.check(a.status == 200, "what was accepted is there", (note, id_, a.status, a.body[:200])):
                continue
            job = json.loads(a.body)
            if id_ in self.told and not (self.told[id_][0] == "done" and job["status"] in ("queued", "running", "done") and self.dropped()):
                self.check((job["status"], job["finished"]) == self.told[id_], "an end that was told is there", (note, self.told[id_], job["status"], job["finished"]))
