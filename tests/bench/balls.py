"""What a proof costs: trajectories in ball arithmetic beside double, CPU time without the analysis."""

EQUATIONS = {
    "oscillator to 50": (["x"], ["x'' = -x"], "50", {"x": 1, "x'": 0}),
    "lorenz to 3": (["x", "y", "z"], ["x' = 10*(y - x)", "y' = x*(28 - z) - y", "z' = x*y - 8*z/3"], "3", {"x": 1, "y": 1, "z": 20}),
    "kepler to 6": (["x", "y", "u", "v"], ["x' = u", "y' = v", "u' = -x/(x^2 + y^2)^(3/2)", "v' = -y/(x^2 + y^2)^(3/2)"], "6",
                    {"x": "0.4", "y": 0, "u": 0, "v": 2}),
    "pendulum, index 3, to 10": (["x", "y", "l"], ["x'' = -l*x", "y'' = -l*y - 1", "x^2 + y^2 = 1"], "10", {"x": 1, "y": 0}),
}
RUNS = [("double", 1e-10), ("ball", 1e-10), ("ball", 1e-30), ("ball", 1e-60)]


def request(name, want, arithmetic, tolerance):
    variables, equations, stop, initial = EQUATIONS[name]
    return {"system": {"form": "equations", "variables": variables, "equations": equations}, "want": [want],
            "trajectory": {"start": 0, "times": [stop], "initial": initial},
            "accuracy": {"rtol": tolerance, "atol": tolerance, "arithmetic": arithmetic}}


def balls(folder, measure, show):
    """measure(folder, request, runs): {"best": CPU seconds}"""
    print("ball arithmetic beside double at 1e-10 (CPU time)")
    for name in EQUATIONS:
        analysis = measure(folder, request(name, "consistent_initial", "double", 1e-10), 20)["best"]
        seconds = [measure(folder, request(name, "trajectory", a, tol), 20 if a == "double" else 2)["best"] - analysis for a, tol in RUNS]
        for (_, tolerance), took in zip(RUNS[1:], seconds[1:]):
            show(f"{name}: ball at {tolerance:g} / double", f"{took / seconds[0]:.0f}", note=f"{1e3 * took:.1f} ms, {1e3 * seconds[0]:.2f} ms")
