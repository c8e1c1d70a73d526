"""`python -m tests.soak.specs [RUNS] [FILE.ha...]`: simulated runs beside every claim of the specs that is proved.

Each run has to keep the claim, in dense time, and where a flowpipe was found to stay inside of it. What lies outside by
more than rounding is followed again in enclosures; either is an alarm here.
"""

from __future__ import annotations

import sys
import time
from collections.abc import Iterator
from pathlib import Path

from haverify.analyses.portfolio import decide_all
from haverify.elaborate.elaborate import elaborate
from haverify.evidence.verdict import Proved
from haverify.model.claim import Claim
from haverify.model.spec import Spec
from haverify.obligations.translate import OutsideFragmentError
from haverify.run.load import load
from haverify.simulate.crosscheck import Beside
from haverify.text.record import replace

ROOT = Path(__file__).parents[2]
RUNS = 10_000
SECONDS = 1e9


def asked(spec: Spec) -> Iterator[tuple[Claim, Beside]]:
    """The proved claims of a spec that runs can be put to, one goal at a time, with what enclosed them."""
    automata = {a.name: a for a in spec.automata}
    for name, evidence in decide_all(spec).items():
        claim = next((c for c in spec.claims if c.name == name), None)
        if claim is None or claim.on not in automata or not isinstance(evidence.verdict, Proved):
            continue
        for goal in claim.goals:
            alone = replace(claim, goals=(goal,))
            flowpipe = evidence.flowpipe if len(claim.goals) == 1 else None
            try:
                yield claim, Beside(spec, automata[claim.on], alone, flowpipe)
            except OutsideFragmentError:
                continue


def soaked(path: Path, runs: int) -> tuple[int, int, int]:
    """How many claims, runs and alarms there were; runs are shared evenly by the claims."""
    read, _ = load(str(path))
    assert read is not None
    spec, _ = elaborate(read.tree, read.files)
    assert spec is not None
    found, checked, alarms = list(asked(spec)), 0, 0
    for seed, (claim, beside) in enumerate(found):
        alarm = beside.disagreement(SECONDS, -(-runs // len(found)), seed=1_000_003 * seed)
        checked += beside.checked
        if alarm is not None:
            alarms += 1
            print(f"    {claim.name}: {alarm.text} (certain: {alarm.is_certain})", flush=True)
    return len(found), checked, alarms


def main() -> int:
    """A line for each spec; exit code 1 after an alarm."""
    numbers = [int(a) for a in sys.argv[1:] if a.isdigit()]
    named = [Path(a) for a in sys.argv[1:] if not a.isdigit()]
    every = 0
    for path in named or sorted((ROOT / "spec").glob("*.ha")):
        started = time.process_time()
        claims, runs, alarms = soaked(path, numbers[0] if numbers else RUNS)
        every += alarms
        seconds = time.process_time() - started
        print(f"{path.name:22} {claims:4} claims {runs:7} runs {alarms:3} alarms ({seconds:.0f} s)", flush=True)
    return 1 if every else 0


if __name__ == "__main__":
    sys.exit(main())
