"""Limits that answers tell of: one that counts constraints or variables is not told of a system that has fewer."""
import os
import re

from tally import ROOT

COUNTED = set("COMPONENT_ROWS REDUCED_BY USED_UP ELSEWHERE PROOF_ROWS DOMAIN_GIVEN DETERMINED STRATA_OFF_VARIABLES SIGN_VARIABLES NOETHER MAP_VARIABLES TENSOR "
              "CLOSED SCALED ROWS_ASKED LOST_PARTS_VARIABLES CONDITIONED GUESS_DISTANCE SQUARES_REDUCED".split())


def counted():
    """Text and size of the limits that count constraints or variables."""
    with open(os.path.join(ROOT, "lib", "base", "limits.def"), encoding="utf-8") as f:
        rows = re.findall(r'^X\((\w+), (\d+), \w+, "((?:[^"\\]|\\.)*)"', f.read(), re.M)
    found = {name: (text.replace('\\"', '"'), int(most)) for name, most, text in rows if name in COUNTED}
    assert set(found) == COUNTED, COUNTED - set(found)
    return list(found.values())


LIMITS = counted()


def told_too_early(result):
    """Details of warnings of limits that nothing in the answer comes near to: its constraints, those that may wait beside them, derivatives and all."""
    size = len(result.get("constraints", [])) + 4 * result.get("work", {}).get("variables", len(result.get("variables", [])))
    return [w["detail"] for w in result.get("warnings", []) for text, most in LIMITS if w["detail"].startswith(text) and size < most]
