"""`python -m tests.peers.hstp`: what haverify says about each problem of this folder, as a table.

--seconds N     of CPU for each problem, all told (default 60)
--only TEXT     problems with the text in their file's name, several times
--samples N     runs of each proved problem that are simulated in floats; none may leave the goal (default 1000)
"""

from __future__ import annotations

import argparse
import json
import os
import resource
import signal
import subprocess
import sys
import tempfile
from dataclasses import dataclass
from math import ceil
from pathlib import Path
from statistics import median
from time import monotonic

from tests.peers.hstp.simulated import violations

HERE = Path(__file__).parent
ROOT = HERE.parents[2]


@dataclass(frozen=True)
class Answer:
    """What was said about a problem, in how many seconds by the clock and of CPU; `again`: the re-check alone (CPU)."""

    name: str
    verdict: str
    trust: str
    seconds: float
    cpu: float
    again: float = 0.0
    wrong: int = 0


def _cpu() -> float:
    """The CPU seconds of all processes that were started and have ended."""
    used = resource.getrusage(resource.RUSAGE_CHILDREN)
    return used.ru_utime + used.ru_stime


def asked(path: Path, seconds: float, samples: int) -> Answer:
    """One problem, decided in a process of its own, then re-checked in another."""

    def limited() -> None:
        resource.setrlimit(resource.RLIMIT_CPU, (ceil(seconds), ceil(seconds) + 5))

    with tempfile.TemporaryDirectory() as work:
        began, before = monotonic(), _cpu()
        environment = {**os.environ, "HAVERIFY_CACHE": f"{work}/cache", "PYTHONPATH": str(ROOT / "verifier")}
        called = [sys.executable, "-m", "haverify", "check", str(path), "--no-cache", "--report", f"{work}/report"]
        try:
            done = subprocess.run(
                called, env=environment, capture_output=True, check=False, timeout=20 * seconds, preexec_fn=limited
            )
        except subprocess.TimeoutExpired:
            return Answer(path.stem, "unknown", "", monotonic() - began, _cpu() - before)
        took, cpu = monotonic() - began, _cpu() - before
        report = Path(work, "report", "report.json")
        if done.returncode == -signal.SIGXCPU:
            return Answer(path.stem, "unknown", "", took, cpu)
        if not report.exists():
            return Answer(path.stem, "fault", "", took, cpu)
        claim = json.loads(report.read_text())["claims"][0]
        before = _cpu()
        subprocess.run(
            [sys.executable, "-S", "-m", "hacheck", f"{work}/report"], env=environment, capture_output=True, check=False
        )
        again = _cpu() - before
    wrong = violations(path, samples) if claim["verdict"] == "proved" and samples else 0
    return Answer(path.stem, claim["verdict"], claim["trust"] or "", took, cpu, again, wrong)


def main() -> int:
    """Print the table and its last lines; the exit code is 1 where a simulated run contradicts a proof."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--seconds", type=float, default=60.0)
    parser.add_argument("--only", action="append", default=[])
    parser.add_argument("--samples", type=int, default=1000)
    options = parser.parse_args()
    paths = [p for p in sorted(HERE.glob("*.ha")) if not options.only or any(t in p.name for t in options.only)]
    answers = []
    for path in paths:
        answers.append(asked(path, options.seconds, options.samples))
        a = answers[-1]
        told = f"   {a.wrong} SIMULATED RUNS VIOLATE IT" if a.wrong else ""
        print(
            f"{a.name:<8} {a.verdict:<8} {a.trust:<9}{a.seconds:7.1f} s   CPU {a.cpu:5.1f} s   "
            f"re-check {a.again:4.1f} s{told}",
            flush=True,
        )
    closing(answers)
    return 1 if any(a.wrong or a.verdict == "fault" for a in answers) else 0


def closing(answers: list[Answer]) -> None:
    """The counts, and the times."""
    counts = {f"{a.verdict} {a.trust}".strip() for a in answers}
    told = [f"{sum(f'{a.verdict} {a.trust}'.strip() == c for a in answers)} {c}" for c in sorted(counts)]
    print(f"{len(answers)} problems: {', '.join(told)}")
    if answers:
        for name, times in (("clock", [a.seconds for a in answers]), ("CPU", [a.cpu for a in answers])):
            print(f"{name}: median {median(times):.1f} s, all {sum(times):.0f} s")
        print(f"re-check of all: CPU {sum(a.again for a in answers):.1f} s")


if __name__ == "__main__":
    sys.exit(main())
