"""python3 -m sga.convert FILE: the request of a netlist (.cir, .net, .sp, .spice), of Modelica (.mo) or of MATLAB's symbolic text (.m), as JSON."""
from __future__ import annotations

import importlib
import json
import sys
import warnings
from typing import List

from .errors import ConvertError

KINDS = {"cir": "spice", "net": "spice", "sp": "spice", "spice": "spice", "mo": "modelica", "m": "matlab"}


def main(arguments: List[str]) -> int:
    if len(arguments) != 1 or arguments[0].rpartition(".")[2].lower() not in KINDS:
        print("usage: python3 -m sga.convert FILE.(" + "|".join(KINDS) + ")", file=sys.stderr)
        return 2
    module = importlib.import_module(f"sga.convert.{KINDS[arguments[0].rpartition('.')[2].lower()]}")
    try:
        with open(arguments[0], encoding="utf-8") as f, warnings.catch_warnings(record=True) as said:
            warnings.simplefilter("always")
            request = module.request(f.read())
    except (ConvertError, OSError, UnicodeDecodeError) as e:
        print(f"{arguments[0]}: {e}", file=sys.stderr)
        return 1
    for w in said:
        print(f"{arguments[0]}: warning: {w.message}", file=sys.stderr)
    print(json.dumps(request, indent=2))
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
