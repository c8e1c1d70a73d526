"""HA603: assumptions that cannot hold together."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

from haverify.diagnostics.diagnostic import Diagnostic, Label
from haverify.lint._facts import Facts
from haverify.lint._fuzzy import speaks_of_fuzzy
from haverify.lint._registry import rule
from haverify.model.claim import Claim
from haverify.model.expression import Expr
from haverify.model.spec import Spec
from haverify.solvers.answer import Contradiction
from haverify.solvers.conditions import Condition, decide
from haverify.solvers.frame import Frame


@rule("HA603")
def contradictory_assumptions(spec: Spec, facts: Facts) -> Iterator[Diagnostic]:
    """Those of the file first; then each claim's own with them. One that contradicts itself is HA202."""
    top = facts.frame(None)
    clash = _clash(facts, "the assumptions", spec.assumptions, top)
    if clash is not None:
        yield _finding(facts, "every claim", clash)
        return
    for claim in spec.claims:
        yield from _of_claim(facts, spec, claim)


def _of_claim(facts: Facts, spec: Spec, claim: Claim) -> Iterator[Diagnostic]:
    if claim.assume and not any(map(speaks_of_fuzzy, claim.assume)):
        frame = facts.frame(facts.automata.get(claim.on or ""))
        clash = _clash(facts, f"the assumptions of {claim.name}", (*spec.assumptions, *claim.assume), frame)
        if clash is not None:
            yield _finding(facts, f"{claim.kind} {claim.name}", clash)


def _clash(facts: Facts, place: str, assumptions: Sequence[Expr], frame: Frame) -> tuple[Expr, ...] | None:
    """The parts that clash; None where the assumptions can hold, that is not known, or one clashes with itself."""
    if any(isinstance(decide([Condition(a, frame)]), Contradiction) for a in assumptions):
        return None
    if len(assumptions) < 2:
        return None
    answer = facts.decide("HA603", place, assumptions[0].span, [Condition(a, frame) for a in assumptions])
    return answer.core if isinstance(answer, Contradiction) else None


def _finding(facts: Facts, who: str, core: tuple[Expr, ...]) -> Diagnostic:
    spans = [e.span for e in core if e.span]
    texts = " and ".join(f"`{facts.text(s)}`" for s in spans)
    return Diagnostic(
        "HA603",
        f"contradictory assumptions: {texts} cannot hold together",
        span=spans[-1] if spans else None,
        labels=tuple(Label(s) for s in spans[:-1]),
        notes=(f"no run satisfies them, so {who} would be 'proved'",),
        key=f"contradictory assumptions of {who}",
    )
