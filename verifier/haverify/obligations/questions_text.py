"""The questions that a claim comes down to, as text for `obligations/<claim>.txt`."""

from __future__ import annotations

from haverify.evidence.evidence import Evidence
from haverify.evidence.verdict import Proved, Refuted
from haverify.model.claim import Claim


def obligations_text(claim: Claim, evidence: Evidence) -> str:
    """One line for each part: goal, kind, place, output, and what became of it."""
    lines = [f"claim {claim.name}" + (f" on {claim.on}" if claim.on else "")]
    lines += [f"    {line.strip()}" for line in claim.text.splitlines() if line.strip()]
    for p in evidence.parts:
        word = "proved" if isinstance(p.verdict, Proved) else "refuted" if isinstance(p.verdict, Refuted) else "unknown"
        lines.append(f"goal {p.goal + 1}  {p.kind:5}  {p.text}: {word}")
    return "\n".join(lines) + "\n"
