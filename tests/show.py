"""Prints a finished job for reading: show.py FILE"""
import json
import sys
import textwrap


def long_line(label, text, indent="    "):
    lines = textwrap.wrap(text, 108, break_long_words=False, break_on_hyphens=False) or [""]
    print(f"{indent}{label}{lines[0]}")
    for line in lines[1:]:
        print(indent + " " * len(label) + line)


def main():
    with open(sys.argv[1], encoding="utf-8") as f:
        job = json.load(f)
    r = job["result"]
    names = [v["name"] for v in r["variables"]]
    dims = r["dimensions"]
    print(f"{r.get('name', 'system')}: {dims['ambient']} variables ({', '.join(names)})")
    print(f"verdict: {r['verdict']}, dimension of Pf {dims['final']}, index: {r['index']['generations']} generations")
    for k, d in enumerate(dims["generations"], 1):
        print(f"\nP{k}, dimension {d}")
        for c in r["constraints"]:
            if c["generation"] == k:
                long_line("0 = ", c["expression"])
    if r.get("definitions"):
        print("\nwith")
        for d in r["definitions"]:
            long_line(f"{d['name']} = ", d["expression"])
    print("\nreduced vector field on Pf" + (f" ({', '.join(r['vector_field']['free'])} arbitrary)" if r["vector_field"]["free"] else ""))
    for n in names:
        long_line(f"{'der(' + n + ')':11}= ", r["vector_field"]["components"].get(n, "0"))
    for k, z in enumerate(r["gauge"]["fields"]):
        print(f"\ngauge field {k + 1} (multiplied by {r['vector_field']['free'][k]})")
        for n in names:
            if n in z and z[n] != "0":
                long_line(f"d/d{n}: ", z[n])
    t = r.get("trajectory")
    if t:
        print(f"\ntrajectory: {len(t['rows'])} samples, method {t['method']}, error estimate {t['error_estimate']}, "
              f"constraint residual {t['constraint_residual']}")
        if t["initial"]["moved"]:
            print(f"the start was moved by {t['initial']['moved']:.3g} onto Pf")
        print(" ".join(f"{c:>11}" for c in t["columns"]))
        for row in t["rows"]:
            print(" ".join(f"{x:11.6g}" if x is not None else f"{'-':>11}" for x in row))
        if t["ended"]:
            print(f"ended at {t['ended']['t']}: {t['ended']['reason']} ({t['ended']['detail']})")


if __name__ == "__main__":
    main()
