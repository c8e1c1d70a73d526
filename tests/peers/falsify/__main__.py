"""How many simulated runs a violation takes, for each claim of the models here and five seeds."""

from __future__ import annotations

from pathlib import Path
from statistics import median

from haverify.elaborate.elaborate import elaborate
from haverify.run.load import load
from haverify.simulate.certify import certified
from haverify.simulate.falsify import searched, subject

BUDGET, SEEDS = 2000, 5


def main() -> None:
    for path in sorted(Path(__file__).parent.glob("*.ha")):
        read, _ = load(str(path))
        assert read is not None
        spec, _ = elaborate(read.tree, read.files)
        assert spec is not None
        for claim in spec.claims:
            runs, certain = [], 0
            for seed in range(SEEDS):
                asked = subject(spec, spec.automata[0], claim, claim.goals[0], 10.0, "earliest", seed)
                found = searched(asked, BUDGET, seed)
                if found.is_violated and found.run is not None:
                    runs.append(found.found_after)
                    certain += certified(found.run, claim, claim.goals[0]).run is not None
            taken = f"median {median(runs):.0f}, most {max(runs)}" if runs else "-"
            print(f"{path.stem:14} {claim.name:10} found {len(runs)} of {SEEDS}, certified {certain}: runs {taken}")


if __name__ == "__main__":
    main()
