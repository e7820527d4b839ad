"""Answers: the object that the service gave, and what one does with it in Python."""
from __future__ import annotations

import functools
import math
import operator
from types import SimpleNamespace
from typing import Any, Callable, Dict, Iterator, List, Mapping, Optional, Sequence, Union

from . import expressions
from .families import whole


def _have(name: str) -> Any:
    try:
        return __import__(name)
    except ImportError:
        return None


def _total(parts: Sequence[Any]) -> Any:
    return functools.reduce(operator.add, parts)


def _functions() -> SimpleNamespace:
    """sin, cos and so on: NumPy's where it is, so that arrays go through; otherwise those of the standard library."""
    np = _have("numpy")
    if np:
        return SimpleNamespace(**{n: getattr(np, n) for n in "sin cos tan sinh cosh tanh exp log sqrt cbrt abs sign hypot log10 log2 pi".split()}, asin=np.arcsin, acos=np.arccos, atan=np.arctan,
                               atan2=np.arctan2, asinh=np.arcsinh, acosh=np.arccosh, atanh=np.arctanh, min=np.minimum, max=np.maximum, total=_total, step=lambda x: np.heaviside(x, 1.0))
    return SimpleNamespace(**{n: getattr(math, n) for n in "sin cos tan asin acos atan atan2 sinh cosh tanh asinh acosh atanh exp log sqrt hypot log10 log2 pi".split()}, abs=abs, min=min, max=max, total=_total,
                           sign=lambda x: float((x > 0) - (x < 0)), cbrt=lambda x: math.copysign(abs(x) ** (1 / 3), x), step=lambda x: float(x >= 0))


def _vector(values: List[Any]) -> Any:
    np = _have("numpy")
    return np.array(values, dtype=float) if np else [float(v) for v in values]


class Constraint(dict):  # type: ignore[type-arg]
    """{"generation": 1, "expression": "x^2 + y^2 - 1"}; prints as its expression."""

    def __str__(self) -> str:
        return str(self["expression"])

    def latex(self) -> str:
        return expressions.latex(self["expression"]) + " = 0"

    def _repr_latex_(self) -> str:
        return f"$\\displaystyle {self.latex()}$"


class Trajectory:
    """Samples of a motion: `t["x"]` is a column (an array where NumPy is), `t.t` the times, `t.rows` all as lists. Other members of the answer
    are attributes: `error_estimate`, `constraint_residual`, `ended`, `events`, ... A member of a sweep that has no motion has `error`."""

    def __init__(self, data: Mapping[str, Any]) -> None:
        self.data = dict(data)
        self.columns: List[str] = list(data.get("columns", []))
        self.rows: List[List[Optional[float]]] = data.get("rows", [])

    def __getattr__(self, name: str) -> Any:
        if name.startswith("__") or name == "data":
            raise AttributeError(name)
        return self.data.get(name)

    def __len__(self) -> int:
        return len(self.rows)

    def __getitem__(self, column: str) -> Any:
        if column not in self.columns:
            raise KeyError(f"{column!r} is none of the columns {self.columns}")
        k = self.columns.index(column)
        values = [math.nan if r[k] is None else r[k] for r in self.rows]
        return _vector(values) if _have("numpy") else values

    @property
    def t(self) -> Any:
        return self[self.columns[0]]

    def array(self) -> Any:
        """All rows as one array of NumPy: rows are times, the first column is time."""
        import numpy as np
        return np.array([[math.nan if v is None else v for v in r] for r in self.rows], dtype=float)

    def plot(self, *columns: str, against: Optional[str] = None, ax: Any = None) -> Any:
        """Columns (all unless named) against time, or against another column, by matplotlib. Returns the axes."""
        import matplotlib.pyplot as plt
        ax = ax or plt.subplots()[1]
        across = against or self.columns[0]
        for c in columns or [c for c in self.columns[1:] if c != across]:
            ax.plot(self[across], self[c], label=c)
        ax.set_xlabel(across)
        ax.legend()
        return ax

    def __repr__(self) -> str:
        return f"<Trajectory {self.columns}, {len(self)} rows>" if self.columns else f"<Trajectory without motion: {(self.error or {}).get('detail')}>"


SAMPLES = ("trajectory", "trajectories")    # numbers, and many of them: nothing in them is said once


class Result(Mapping[str, Any]):
    """An answer. It is the service's object (`result["verdict"]`) with what it says once for many entries written out; its members are attributes
    too (`result.verdict`), and beside:"""

    def __init__(self, data: Mapping[str, Any], request: Optional[Mapping[str, Any]] = None, job: Optional[Mapping[str, Any]] = None) -> None:
        self.data, self.request, self.job = {k: v if k in SAMPLES else whole(v) for k, v in data.items()}, dict(request or {}), dict(job or {})

    def __getitem__(self, key: str) -> Any:
        return self.data[key]

    def __iter__(self) -> Iterator[str]:
        return iter(self.data)

    def __len__(self) -> int:
        return len(self.data)

    def __getattr__(self, name: str) -> Any:
        if name.startswith("_") or name == "data" or name not in self.data:
            raise AttributeError(f"the answer has no {name!r}; it has {', '.join(self.data)}" if name != "data" else name)
        return self.data[name]

    @property
    def names(self) -> List[str]:
        """The variables that the answer is about, in the order of `field`."""
        return [v["name"] for v in self.data["variables"]]

    @property
    def constraints(self) -> List[Constraint]:
        return [Constraint(c) for c in self.data.get("constraints", [])]

    @property
    def trajectory(self) -> Optional[Trajectory]:
        return Trajectory(self.data["trajectory"]) if "trajectory" in self.data else None

    @property
    def trajectories(self) -> List[Trajectory]:
        """Those of a sweep, in its order."""
        return [Trajectory(t) for t in self.data.get("trajectories", [])]

    @property
    def sets(self) -> List[Dict[str, Any]]:
        """What else was asked of the sets of a sweep, in its order: `parameters` where they are swept, and `linearization`, `transfer`, `equilibria`, `fit`, `sensitivities`, or `error`."""
        return list(self.data.get("sets", []))

    # -- Numbers --

    def _time(self) -> str:
        return str(self.request.get("system", {}).get("time", "t"))

    def _compile(self, texts: Sequence[str], parameters: Mapping[str, float], free: Sequence[str] = ()) -> Callable[..., List[Any]]:
        system = self.request.get("system", {})
        if system.get("tables"):
            raise NotImplementedError("the system has tables: their values are the service's alone")
        f = _functions()
        known: Dict[str, Any] = {k: v for k, v in (system.get("parameters") or {}).items() if v is not None}
        known.update(parameters)
        values = {k: v if isinstance(v, (int, float)) else eval(expressions.python(v, {}), {"__builtins__": {}, "f": f}) for k, v in known.items()}  # of numbers and functions alone: see expressions.python
        place = {self._time(): "t", **{n: f"x[{i}]" for i, n in enumerate(self.names)}, **{k: f"p[{k!r}]" for k in values}, **{k: f"u[{i}]" for i, k in enumerate(free)}}
        for i, d in enumerate(self.data.get("definitions") or []):
            place[d["name"]] = f"d[{i}]"
        try:
            shared = [compile(expressions.python(d["expression"], place), "<definition>", "eval") for d in self.data.get("definitions") or []]
            wanted = [compile(expressions.python(t, place), "<answer>", "eval") for t in texts]
        except KeyError as e:
            raise ValueError(f"{e.args[0]} has no value: give it in parameters={{...}}") from None

        def values_at(t: Any, x: Any, u: Sequence[Any] = ()) -> List[Any]:
            d: List[Any] = []
            names = {"__builtins__": {}, "f": f, "t": t, "x": x, "u": u, "p": values, "d": d}
            for code in shared:
                d.append(eval(code, names))
            return [eval(code, names) for code in wanted]
        return values_at

    def field(self, **parameters: float) -> Callable[..., Any]:
        """The reduced field as a function f(t, x, u=None) of time and the variables in the order of `names`: dx/dt, as SciPy's solve_ivp
        takes it. u: values of the free functions, 0 unless given."""
        field, free = self.data["vector_field"], list(self.data["vector_field"].get("free", []))
        texts = [field["components"].get(n, "0") for n in self.names]
        gauge = [[g.get(n, "0") for n in self.names] for g in (self.data.get("gauge") or {}).get("fields", [])] if free else []
        values = self._compile(texts + [e for row in gauge for e in row], parameters, free)
        n = len(texts)

        def rate(t: float, x: Sequence[float], u: Optional[Sequence[float]] = None) -> Any:
            all_values = values(t, x, u if u is not None else [0.0] * len(free))
            if u is not None and len(u) != len(free):
                raise ValueError(f"u has {len(u)} values, but the free functions are {free}")
            return _vector([all_values[i] + sum(u[k] * all_values[n * (k + 1) + i] for k in range(len(free))) if u is not None else all_values[i] for i in range(n)])
        return rate

    def residual(self, **parameters: float) -> Callable[..., Any]:
        """The constraints as a function c(t, x), zero where x is consistent."""
        values = self._compile([c["expression"] for c in self.constraints], parameters)
        return lambda t, x: _vector(values(t, x))

    # -- Formulas --

    def latex(self) -> str:
        """Constraints and field as LaTeX: an aligned block."""
        lines = [rf"0 &= {expressions.latex(c['expression'])} && \text{{generation {c['generation']}}}" for c in self.constraints]
        lines += [rf"{expressions.latex(n + chr(39))} &= {expressions.latex(e)}" for n, e in (self.data.get("vector_field") or {}).get("components", {}).items() if e != n + "'"]
        return "\\begin{aligned}\n" + " \\\\\n".join(lines) + "\n\\end{aligned}"

    def _repr_latex_(self) -> str:
        return f"$\\displaystyle {self.latex()}$"

    def sympy(self) -> SimpleNamespace:
        """constraints: a list; field: by variable; gauge: a list of such. As SymPy's expressions, parameters as symbols."""
        gauge = (self.data.get("gauge") or {}).get("fields", [])
        field = (self.data.get("vector_field") or {}).get("components", {})
        return SimpleNamespace(constraints=[expressions.sympy(c["expression"]) for c in self.constraints], field={n: expressions.sympy(e) for n, e in field.items()},
                               gauge=[{n: expressions.sympy(e) for n, e in g.items()} for g in gauge])

    def __repr__(self) -> str:
        d: Dict[str, Any] = self.data.get("dimensions") or {}
        sizes = " -> ".join(map(str, [d.get("ambient"), *d.get("generations", [])]))
        return f"<Result {self.data.get('verdict')}: dimensions {sizes}; {', '.join(self.data)}>"


Request = Union[Mapping[str, Any], str, bytes]
