"""Writes tests/cases/double_double.json: the references of trajectory_reference.py that are not stiff, and some of their
own, to 36 digits, asked for in double-double arithmetic.

    /usr/bin/python3 tests/double_double_reference.py"""
import json
import os

import mpmath as mp

import jets
import trajectory_reference as reference

DIGITS = 36
mp.mp.dps = 60


def text(v):
    return mp.nstr(mp.mpf(v), DIGITS, min_fixed=-3, max_fixed=20)


def twice(field, x, times):
    a, b = jets.taylor(field, 0, x, times, 40), jets.taylor(field, 0, x, times, 45)
    for p, q in zip(a, b):
        assert max(abs(u - v) / (1 + abs(u)) for u, v in zip(p, q)) < mp.mpf(10) ** -(DIGITS - 1), "does not agree"
    return b


def own():
    closed, explicit = reference.closed, reference.explicit
    root = mp.sqrt(5)
    turning = {"form": "quasilinear", "variables": ["x", "y"], "restrict": ["x^2 + y^2 - 1"], "A": [[1, 0], [0, 1]], "alpha": ["-y", "x"]}
    closed("the nearest start", "both values given, off the circle: the nearest point of it, to all digits", turning, [0, 1, 10],
           {"x": 2, "y": 1}, ["x", "y"], lambda t: [(2 * mp.cos(t) - mp.sin(t)) / root, (mp.cos(t) + 2 * mp.sin(t)) / root])
    closed("a held start", "x stays 3/10 exactly, y follows", turning, [0, 1, 10], {"x": "3/10", "y": 1}, ["x", "y"],
           lambda t: [mp.mpf(3) / 10 * mp.cos(t) - mp.sqrt(mp.mpf(91)) / 10 * mp.sin(t),
                      mp.mpf(3) / 10 * mp.sin(t) + mp.sqrt(mp.mpf(91)) / 10 * mp.cos(t)])
    reference.CASES[-1]["request"]["trajectory"]["hold"] = ["x"]
    closed("exact constants", "a start, a rate and times that no double is", explicit(["x"], ["x/10 + pi"]), ["1/10", "1/3", "7.7"],
           {"x": "sqrt(2)"}, ["x"], lambda t: [(mp.sqrt(2) + 10 * mp.pi) * mp.exp(t / 10) - 10 * mp.pi])
    closed("a slope that turns", "abs ends the series where the state gets there", explicit(["x", "y"], ["1 + x/3", "abs(x - 1)"]), ["1/2", 1, 2],
           {"x": 0, "y": 0}, ["x", "y"], turn)
    closed("backwards", "negative steps", explicit(["x"], ["x*cos(t)"]), [-1, -5], {"x": 1}, ["x"], lambda t: [mp.exp(mp.sin(t))])
    closed("functions of time", "quadratures of the elementary functions", explicit(
        ["a", "b", "c", "d"], ["tan(t/2) + tanh(t)", "atan(t) + asin(t/3)", "log(2 + t) + sqrt(1 + t)", "(1 + t)^(1/3) + asinh(t)"]),
           ["1/2", 2], {"a": 0, "b": 0, "c": 0, "d": 0}, ["a", "b", "c", "d"], quadratures)


def turn(t):
    # x = 3 (exp(t/3) - 1) passes 1 at s = 3 log(4/3); y' = |x - 1|
    def area(u):       # of x - 1
        return 9 * mp.exp(u / 3) - 4 * u
    s = 3 * mp.log(mp.mpf(4) / 3)
    y = area(0) - area(t) if t <= s else area(0) - 2 * area(s) + area(t)
    return [3 * mp.expm1(t / 3), y]


def quadratures(t):
    a = -2 * mp.log(mp.cos(t / 2)) + mp.log(mp.cosh(t))
    b = t * mp.atan(t) - mp.log(1 + t * t) / 2 + t * mp.asin(t / 3) + mp.sqrt(9 - t * t) - 3
    c = (2 + t) * mp.log(2 + t) - t - 2 * mp.log(2) + (mp.sqrt(1 + t) ** 3 - 1) * 2 / 3
    d = ((1 + t) * mp.cbrt(1 + t) - 1) * 3 / 4 + t * mp.asinh(t) - mp.sqrt(1 + t * t) + 1
    return [a, b, c, d]


def main():
    reference.text, reference.twice = text, twice
    reference.closed_forms()
    reference.linear()
    reference.by_series()
    own()
    cases = []
    for case in reference.CASES:
        if "stiff" in case["name"]:
            continue
        case["name"] = case["name"].replace("reference: ", "double-double: ")
        case["source"] = "own: " + case["source"]
        case["request"]["accuracy"] = {"rtol": 1e-26, "atol": 1e-26, "arithmetic": "double-double"}
        cases.append(case)
    path = os.path.join(os.path.dirname(os.path.abspath(__file__)), "cases", "double_double.json")
    with open(path, "w", encoding="utf-8") as f:
        json.dump(cases, f, indent=1)
        f.write("\n")
    print(len(cases), "cases")


if __name__ == "__main__":
    main()
