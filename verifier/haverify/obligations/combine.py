"""From parts to a claim: all proved, or one refuted, else unknown; the weakest trust."""

from __future__ import annotations

from collections.abc import Sequence

from haverify.evidence.verdict import Margin, Proved, Refuted, Trust, Unknown, Verdict


def combine(parts: Sequence[Verdict]) -> Verdict:
    """The verdict of a conjunction of parts: refuted if one is, proved if all are, else the first that is unknown.

    Its margin is the least of those that share the verdict, its trust the weakest.
    """
    refuted = [p for p in parts if isinstance(p, Refuted)]
    if refuted:
        return Refuted(_least(refuted), _weakest(refuted))
    unknown = next((p for p in parts if isinstance(p, Unknown)), None)
    if unknown is not None:
        return unknown
    proved = [p for p in parts if isinstance(p, Proved)]
    if not proved:
        return Unknown("vacuous", "there is nothing to show")
    return Proved(_least(proved), _weakest(proved))


def _least(verdicts: Sequence[Proved] | Sequence[Refuted]) -> Margin | None:
    margins = [v.margin for v in verdicts if v.margin is not None]
    return min(margins, key=lambda m: m.low, default=None)


def _weakest(verdicts: Sequence[Proved] | Sequence[Refuted]) -> Trust | None:
    trusts = [v.trust for v in verdicts]
    return None if None in trusts else min(t for t in trusts if t is not None)
