"""Cost of chains and grids of up to 10^5 unknowns: constraints and index, CPU seconds, memory, and the power of the size by which time grows
from each size to the next."""
import json
import math
import os
import resource
import subprocess

import large

SIZES = (1000, 3000, 10000, 30000, 100000)
LONGEST = 60       # seconds of CPU: larger members of a family that takes longer are left out, which is said


def one(build, folder, name, unknowns):
    request, expected = large.FAMILIES[name](large.sized(name, unknowns))
    path = os.path.join(folder, "large.json")
    with open(path, "w", encoding="utf-8") as f:
        json.dump(request, f)
    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    run = subprocess.run(["/bin/sh", "-c", f"ulimit -t {LONGEST}; exec /usr/bin/time -f '%M' \"$0\" solve --json \"$1\"", os.path.join(build, "sga"), path],
                         capture_output=True, text=True, check=False)
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    seconds = after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime
    if run.returncode:
        return seconds, None, None
    answer = json.loads(run.stdout)
    right = answer["verdict"] == expected["verdict"] and answer["dimensions"]["generations"] == expected["generations"]
    return seconds, int(run.stderr.split()[-1]) / 1024, right


def run(build, folder, show):
    print("chains, ladders and grids of many unknowns: index and constraints")
    for name in large.FAMILIES:
        last = None
        for unknowns in SIZES:
            seconds, memory, right = one(build, folder, name, unknowns)
            if memory is None:
                show(f"{name}, {unknowns} unknowns", f"over {LONGEST} s")
                break
            power = math.log(seconds / last[1]) / math.log(unknowns / last[0]) if last else None
            most = 1.5 if name in large.PLANAR else 1.1
            show(f"{name}, {unknowns} unknowns", f"{seconds:.2f} s", note=f"{memory:.0f} MiB{'' if right else ', WRONG'}")
            if power is not None:
                show(f"{name}, power of the size from {last[0]} on", f"{power:.2f}", f"<= {most}", power <= most)
            last = (unknowns, seconds)
