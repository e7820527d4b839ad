"""Reads what `ode` prints (files given, or standard input) and compares at equal true error: report.py [--table] [FILE...]

Errors follow tolerances only roughly, and a curve that dips by accident would count as good luck, the more of it the
more methods there are: log error and log time are made monotone by pooling adjacent violators (the least-squares monotone
curve), then log time is interpolated over log error. The best peer is taken for each problem and each number of digits
anew; what is reported is the geometric mean of ours / best peer."""
import collections
import math
import sys

# what is asked: (stiff, digits): most that ours may take, in units of the best peer's time
TARGETS = {(0, 4): 2, (0, 6): None, (0, 8): 1, (0, 12): 0.5, (1, 4): None, (1, 6): 1, (1, 8): None}
OURS = ("ours", "ours+")


def monotone(values):
    """The nearest sequence that does not fall."""
    blocks = []
    for v in values:
        blocks.append([v, 1])
        while len(blocks) > 1 and blocks[-2][0] > blocks[-1][0]:
            (a, m), (b, n) = blocks[-2:]
            blocks[-2:] = [[(a * m + b * n) / (m + n), m + n]]
    return [v for v, n in blocks for _ in range(n)]


class Curve:
    def __init__(self):
        self.points = []

    def add(self, tolerance, seconds, error):
        if math.isfinite(error):
            self.points.append((tolerance, seconds, max(error, 1e-17)))

    def seconds(self, digits):
        """To reach an error of 10^-digits; None: it does not."""
        points = sorted(self.points, reverse=True)
        if not points:
            return None
        got = monotone([-math.log10(e) for _, _, e in points])
        work = monotone([math.log(s) for _, s, _ in points])
        if got[0] >= digits:
            return math.exp(work[0])
        for i in range(1, len(got)):
            if got[i] >= digits:
                part = (digits - got[i - 1]) / (got[i] - got[i - 1])
                return math.exp(work[i - 1] + part * (work[i] - work[i - 1]))
        return None


def read(files):
    curves = collections.defaultdict(lambda: collections.defaultdict(Curve))
    stiff = {}
    for f in files:
        for line in f:
            name, kind, method, tolerance, seconds, error = line.rstrip("\n").split(";")[:6]
            curves[name][method].add(float(tolerance), float(seconds), float(error))
            stiff[name] = int(kind)
    return curves, stiff


def own(method):
    return method in OURS or method[0].islower()     # peers have the names of their libraries


def compare(curves, stiff, kind, digits, method, out=None):
    """Ratios of one method of ours to the best peer, over the problems that both solve so accurately."""
    ratios, only, missed = [], 0, 0
    for name, by in curves.items():
        if stiff[name] != kind:
            continue
        mine = by[method].seconds(digits) if method in by else None
        peers = {m: c.seconds(digits) for m, c in by.items() if not own(m)}
        peers = {m: s for m, s in peers.items() if s}
        if mine and peers:
            best = min(peers, key=peers.get)
            ratios.append(mine / peers[best])
            if out is not None:
                out.append((ratios[-1], name, best, mine, peers[best]))
        else:
            only += bool(mine)
            missed += bool(peers) and not mine
    mean = math.exp(sum(map(math.log, ratios)) / len(ratios)) if ratios else math.nan
    return mean, len(ratios), only, missed


def lines(curves, stiff, methods=OURS):
    for (kind, digits), target in TARGETS.items():
        for method in methods:
            mean, count, only, missed = compare(curves, stiff, kind, digits, method)
            yield kind, digits, method, target if method == "ours" else None, mean, count, only, missed


def main():
    table = "--table" in sys.argv
    names = [a for a in sys.argv[1:] if not a.startswith("--")]
    curves, stiff = read([open(n, encoding="utf-8") for n in names] or [sys.stdin])
    methods = OURS + tuple(sorted({m for by in curves.values() for m in by if own(m) and m not in OURS}))
    for kind, digits, method, target, mean, count, only, missed in lines(curves, stiff, methods):
        print(f"{'stiff' if kind else 'smooth':6} {digits:2} digits  {method:8} {mean:6.2f}  ({count} problems, {only} reached by ours only, "
              f"{missed} by peers only){f'  target {target}' if target else ''}")
        rows = []
        if table and method == "ours":
            compare(curves, stiff, kind, digits, method, rows)
            for ratio, name, best, mine, peer in sorted(rows):
                print(f"      {ratio:6.2f} {name:28} {1e6 * mine:9.1f} us   {best} {1e6 * peer:.1f} us")


if __name__ == "__main__":
    main()
