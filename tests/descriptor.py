"""Form descriptor in the letters of form linear: E x' = A x + B u is A x' = B x + C u there. Outputs are left out."""


def as_linear(system):
    """The same system, of form linear; others as they are."""
    if system.get("form") != "descriptor":
        return system
    states = system["states"] if isinstance(system["states"], list) else [system["states"]]
    n = len(states)
    out = {k: v for k, v in system.items() if k in ("name", "parameters", "time", "tables", "inputs")}
    out.update(form="linear", variables=states, A=system.get("E", [[int(i == k) for k in range(n)] for i in range(n)]), B=system["A"])
    if "B" in system:
        out["C"] = system["B"]
    return out
