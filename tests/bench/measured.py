"""Run a command; print its CPU seconds and peak memory, children included, and its exit code."""

from __future__ import annotations

import resource
import subprocess
import sys


def main() -> None:
    """`python -m tests.bench.measured COMMAND ARGUMENT...`; peak memory is that of the largest process."""
    done = subprocess.run(sys.argv[1:], stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL, check=False)
    used = resource.getrusage(resource.RUSAGE_CHILDREN)
    print(f"{used.ru_utime + used.ru_stime:.4f} {used.ru_maxrss / 1024:.1f} {done.returncode}")


if __name__ == "__main__":
    main()
