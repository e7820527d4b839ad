"""Counting checks: a failure is printed and the suite goes on."""
import os
import sys
import time


class Tally:
    def __init__(self, suite):
        self.suite, self.passed, self.failed = suite, 0, 0
        self.start = time.time()

    def check(self, ok, label, detail=""):
        if ok:
            self.passed += 1
        else:
            self.failed += 1
            print(f"FAILED {self.suite}: {label}" + (f": {detail}" if detail else ""), flush=True)
        return ok

    def end(self):
        """Prints the line that tests/run adds up; the exit status."""
        print(f"{self.passed} passed, {self.failed} failed", flush=True)
        return 1 if self.failed or not self.passed else 0


def seed(otherwise):
    """SGA_TEST_SEED or the default; printed, so that a failure can be repeated."""
    value = int(os.environ.get("SGA_TEST_SEED", otherwise))
    print(f"seed {value}", flush=True)
    return value


def scale():
    return float(os.environ.get("SGA_TEST_SCALE", "1"))


def scaled(n):
    """n times SGA_TEST_SCALE, one at the least."""
    return max(1, int(n * scale()))


def build_folder():
    if len(sys.argv) < 2:
        sys.exit(f"usage: {sys.argv[0]} BUILD_DIR ...")
    return os.path.abspath(sys.argv[1])


ROOT = os.path.dirname(os.path.dirname(os.path.abspath(__file__)))
