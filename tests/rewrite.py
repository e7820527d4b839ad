"""The rewritings by name, and a request rewritten."""
from rewrite_order import equations, signs, variables
from rewrite_signals import signals
from rewrite_words import names, spelling, units
from said import Said

KINDS = {"equations": equations, "variables": variables, "signs": signs, "names": names, "units": units,
         "spelling": spelling, "signals": signals}


def rewrite(rng, request, kinds):
    """The request with these rewritings, one after another."""
    said = Said(request)
    for kind in kinds:
        if KINDS[kind](rng, said):
            said.done.append(kind)
    return said
