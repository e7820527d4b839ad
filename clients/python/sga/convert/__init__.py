"""Requests from other tools' texts, and back: `spice`, `modelica`, `matlab`, `symbolic` (SymPy).

    from sga.convert import spice
    request = spice.request(open("filter.cir").read())

`python3 -m sga.convert FILE` prints the request of a file (.cir, .mo, .m). What cannot be taken raises ConvertError with its line; what is left
out without changing the system is told by `warnings`."""
from .errors import ConvertError, ConvertWarning

__all__ = ["ConvertError", "ConvertWarning"]
