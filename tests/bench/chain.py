"""A chain of N planar pendulums in Cartesian coordinates with multipliers (5 N variables of
first order), unit masses and lengths, released at rest from a slope of 3 to 4."""


def request(n, want=("index", "trajectory"), stop="1/10", samples=11):
    variables, equations, initial = [], [], {}
    for i in range(1, n + 1):
        variables += [f"x{i}", f"y{i}", f"l{i}"]
        dx, dy = (f"(x{i} - x{i - 1})", f"(y{i} - y{i - 1})") if i > 1 else ("x1", "y1")
        ex, ey = (f" + l{i + 1}*(x{i + 1} - x{i})", f" + l{i + 1}*(y{i + 1} - y{i})") if i < n else ("", "")
        equations += [f"x{i}'' = -l{i}*{dx}{ex}", f"y{i}'' = -l{i}*{dy}{ey} - 10", f"{dx}^2 + {dy}^2 = 1"]
        initial.update({f"x{i}": f"{3 * i}/5", f"y{i}": f"-{4 * i}/5", f"x{i}'": 0, f"y{i}'": 0})
    return {"system": {"name": f"{n} pendulums", "form": "equations", "variables": variables, "equations": equations},
            "want": list(want), "trajectory": {"start": 0, "stop": stop, "samples": samples, "initial": initial},
            "limits": {"seconds": 600}}
