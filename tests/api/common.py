"""Requests and checks that the API tests share."""
import itertools

import schemas

COUNTER = itertools.count(1)


def trivial(k=None):
    """A request that was not made before: x' = k x."""
    k = next(COUNTER) if k is None else k
    return {"system": {"form": "quasilinear", "variables": ["x"], "A": [[1]], "alpha": [f"{k}*x"]}}


def moving(k=None, samples=5):
    k = next(COUNTER) if k is None else k
    return {"system": {"form": "equations", "variables": ["x", "y"], "equations": ["x' = y", "y' = -x", f"x^2 + y^2 = {k}^2"]},
            "trajectory": {"start": 0, "stop": 1, "samples": samples, "initial": {"x": 0, "y": k}}}


def slow(seconds=120):
    """A job that goes on until it is stopped: many cheap steps of a costly field."""
    field = f"-{next(COUNTER) + 1000}*x + (" + " + ".join(f"sin(x + {k})" for k in range(400)) + ")*1e-15"
    return {"system": {"form": "equations", "variables": ["x"], "equations": [f"x'' = {field}"]}, "want": ["trajectory"],
            "trajectory": {"start": 0, "stop": 8000, "samples": 2, "initial": {"x": 1, "x'": 0}}, "limits": {"seconds": seconds}}


class Checks:
    """Checks of answers against the schemas."""

    def __init__(self, tally):
        self.tally = tally
        self.job_schema = schemas.validator("openapi#Job")
        self.list_schema = schemas.validator("openapi#JobList")
        self.problem_schema = schemas.validator("problem")
        self.result_schema = schemas.validator("result")

    def __call__(self, ok, label, detail=""):
        return self.tally.check(ok, label, str(detail)[:600])

    def status(self, answer, should, label):
        allowed = should if isinstance(should, tuple) else (should,)
        return self(answer.status in allowed, f"{label}: status {should}", f"{answer.status} {answer.body[:300]!r}")

    def job(self, answer, label):
        """The job in an answer, valid; {} otherwise."""
        self(answer.headers.get("content-type", "").split(";")[0] == "application/json", f"{label}: media type", answer.headers)
        try:
            job = answer.json()
        except ValueError as e:
            self(False, f"{label}: is JSON", e)
            return {}
        fault = schemas.faults(self.job_schema, job)
        self(not fault, f"{label}: job schema", fault)
        return job

    def problem(self, answer, status, code, label):
        """The problem in an answer, valid, with its status and code."""
        self.status(answer, status, label)
        self(answer.headers.get("content-type", "").split(";")[0] == "application/problem+json", f"{label}: media type", answer.headers)
        try:
            problem = answer.json()
        except ValueError as e:
            self(False, f"{label}: is JSON", f"{e}: {answer.body[:200]!r}")
            return {}
        fault = schemas.faults(self.problem_schema, problem)
        self(not fault, f"{label}: problem schema", fault)
        codes = code if isinstance(code, tuple) else (code,)
        self(problem.get("code") in codes, f"{label}: code {code}", problem)
        self(problem.get("status") == answer.status, f"{label}: status member", problem)
        return problem
