"""Builds the wheel with the standard library alone (PEP 517, PEP 427): `make python`, or `pip install clients/python` without a network.

The same files give the same bytes: times are those of SOURCE_DATE_EPOCH, or none."""
import base64
import hashlib
import os
import re
import sys
import time
import zipfile

HERE = os.path.dirname(os.path.abspath(__file__))
EARLIEST = 315532800      # 1980: the zip format knows nothing before


def _project():
    with open(os.path.join(HERE, "pyproject.toml"), encoding="utf-8") as f:
        return dict(re.findall(r'^(name|version|description|requires-python) = "(.*)"$', f.read(), re.M))


def _files():
    for folder, folders, names in os.walk(os.path.join(HERE, "sga")):
        folders.sort()
        for name in sorted(names):
            if name.endswith(".py") or name == "py.typed":
                path = os.path.join(folder, name)
                with open(path, "rb") as f:
                    yield os.path.relpath(path, HERE).replace(os.sep, "/"), f.read()


def build_wheel(wheel_directory, config_settings=None, metadata_directory=None):
    p = _project()
    stem = f"{p['name'].replace('-', '_')}-{p['version']}"
    info = stem + ".dist-info/"
    metadata = (f"Metadata-Version: 2.1\nName: {p['name']}\nVersion: {p['version']}\nSummary: {p['description']}\n"
                f"License: GPL-3.0-or-later\nRequires-Python: {p['requires-python']}\n")
    files = [*_files(), (info + "METADATA", metadata.encode()), (info + "WHEEL", b"Wheel-Version: 1.0\nGenerator: sga\nRoot-Is-Purelib: true\nTag: py3-none-any\n")]
    record = "".join(f"{n},sha256={base64.urlsafe_b64encode(hashlib.sha256(c).digest()).rstrip(b'=').decode()},{len(c)}\n" for n, c in files)
    files.append((info + "RECORD", (record + info + "RECORD,,\n").encode()))
    date = time.gmtime(max(EARLIEST, int(os.environ.get("SOURCE_DATE_EPOCH", EARLIEST))))[:6]
    wheel = stem + "-py3-none-any.whl"
    with zipfile.ZipFile(os.path.join(wheel_directory, wheel), "w") as z:
        for name, content in files:
            entry = zipfile.ZipInfo(name, date)
            entry.external_attr = 0o644 << 16
            z.writestr(entry, content, zipfile.ZIP_DEFLATED)
    return wheel


if __name__ == "__main__":
    os.makedirs(sys.argv[1], exist_ok=True)
    print(os.path.join(sys.argv[1], build_wheel(sys.argv[1])))
