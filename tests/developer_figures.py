"""Puts figures of the tests into doc/developer.md: between `<!-- figures NAME: when -->` and `<!-- end -->`."""
import datetime
import os
import re

from tally import ROOT

PAGE = os.path.join(ROOT, "doc", "developer.md")


def rewrite(name, lines):
    with open(PAGE, encoding="utf-8") as f:
        page = f.read()
    new = "\n".join([f"<!-- figures {name}: {datetime.date.today()} -->", *lines, "<!-- end -->"])
    page, count = re.subn(rf"<!-- figures {name}.*?-->.*?<!-- end -->", lambda _: new, page, flags=re.S)
    if count:
        with open(PAGE, "w", encoding="utf-8") as f:
            f.write(page)
    return count == 1
