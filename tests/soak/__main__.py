"""`python -m tests.soak [RUNS] [NAME...]`: sampled runs against the enclosures of every problem of tests/peers/nln."""

from __future__ import annotations

import sys
import time

from tests.soak.campaign import Tally, campaign
from tests.soak.enclosures import enclosures
from tests.soak.problems import PROBLEMS

RUNS = 100_000
MOST = 8  # enclosures for each claim
CLAIMS = 3


def soak(name: str, count: int, most: int = MOST, claims: int = CLAIMS) -> Tally:
    """`count` runs of a problem, shared evenly by its enclosures."""
    found, total = enclosures(name, most, claims), Tally()
    for seed, enclosure in enumerate(found):
        total.add(campaign(PROBLEMS[name], enclosure, -(-count // len(found)), seed * 1_000_003))
    return total


def main() -> int:
    """A line for each problem; exit code 1 if a run was found outside."""
    numbers = [int(a) for a in sys.argv[1:] if a.isdigit()]
    names = [a for a in sys.argv[1:] if not a.isdigit()] or list(PROBLEMS)
    escapes = 0
    for name in names:
        started = time.process_time()
        tally = soak(name, numbers[0] if numbers else RUNS)
        escapes += len(tally.escapes)
        said = f"{tally.runs} runs, {tally.looks} states, {tally.jumps} jumps, {len(tally.escapes)} outside"
        print(
            f"{name:<24} {said if tally.runs else 'no enclosures'} ({time.process_time() - started:.0f} s)", flush=True
        )
        for text in tally.escapes[:5]:
            print(f"    {text}", flush=True)
    return 1 if escapes else 0


if __name__ == "__main__":
    sys.exit(main())
