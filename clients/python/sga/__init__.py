"""A client of sgad: differential-algebraic systems, solved by a service.

    import sga
    client = sga.Client("http://127.0.0.1:8080")
    result = client.solve({"system": {"form": "equations", "variables": ["x", "y"], "equations": ["x' = y", "x + y = 1"]}})
    print(result.verdict, [str(c) for c in result.constraints])

It needs nothing but Python. Where NumPy is, columns are arrays; matplotlib plots, SymPy takes formulas on.
"""
from . import expressions
from .client import Client, Job
from .errors import AccessError, Cancelled, JobError, RequestError, ServiceError, SgaError
from .result import Constraint, Result, Trajectory

__version__ = "0.3.0"
__all__ = ["Client", "Job", "Result", "Trajectory", "Constraint", "SgaError", "RequestError", "JobError", "Cancelled", "AccessError", "ServiceError", "expressions", "__version__"]
