"""`python -m tests.bench.decided SPEC`: the claims of a spec decided once in this process; what it took, as JSON."""

from __future__ import annotations

import json
import resource
import sys
from typing import Any

from tests.bench.flowpipes import Call, ends, impacts, recorded

from haverify.analyses.hybrid import decide
from haverify.analyses.induction import decide as induction
from haverify.analyses.portfolio import contexts_of
from haverify.analyses.portfolio import decide as decided
from haverify.evidence.verdict import Proved, Refuted
from haverify.run.examine import read


def user() -> float:
    """User CPU seconds of this process so far, threads included."""
    return resource.getrusage(resource.RUSAGE_SELF).ru_utime


def main() -> None:
    """Analyses run claim by claim and share what `haverify check` lets them share.

    `start` is all user time before the first: Python, imports, parsing.
    """
    assert decide.METHOD and induction.__doc__, "imported with the start"
    spec, _, _ = read(sys.argv[1])
    assert spec is not None
    start = user()
    claims, calls, contexts = [], list[Call](), contexts_of(spec)
    for claim in spec.claims:
        before = user()
        with recorded() as own:
            evidence = decided(spec, claim, contexts)
        claims.append({"name": claim.name, "verdict": word(evidence.verdict), "cpu": user() - before})
        calls = calls or (own if claims[-1]["verdict"] != "unknown" else [])
    states = [v.name for v in spec.automata[0].vars]
    last = ends(calls)
    boxes = dict(zip(states, last, strict=False)) if last is not None else impacts(calls)
    print(json.dumps({
        "start": start,
        "claims": claims,
        "pieces": len([c for c in calls if not c.is_point]),
        "steps": sum(len(c.segments) for c in calls),
        "last": boxes or None,
        "peak_mb": resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024,
    }))  # fmt: skip


def word(verdict: Any) -> str:
    """The verdict in one word."""
    return "proved" if isinstance(verdict, Proved) else "refuted" if isinstance(verdict, Refuted) else "unknown"


if __name__ == "__main__":
    main()
