"""Proposals for bounds that are table cells and stand the wrong way round."""

from __future__ import annotations

from haverify.lint._facts import Facts
from haverify.lint._wording import quantity
from haverify.repair.backwards import Backwards, backwards
from haverify.repair.change import Change
from haverify.repair.effect import Effect
from haverify.repair.proposal import Proposal
from haverify.repair.trial import Trials

MOST_SHOWN = 3


def bound_repairs(trials: Trials, taken: set[str]) -> list[Proposal]:
    """A proposal for each pair of cells, except where one of them is among the constants `taken` by another."""
    subject = trials.before
    assert subject.spec is not None
    found = []
    for pair in backwards(Facts(subject.spec, subject.text.sources)):
        if {pair.low.constant, pair.high.constant} & taken:
            continue
        proposal = _proposal(trials, pair)
        if proposal is not None:
            found.append(proposal)
            taken |= {n for n, _ in proposal.change.numbers}
    return found


def _proposal(trials: Trials, pair: Backwards) -> Proposal | None:
    """The exchange if it makes a claim come true; else the change that does; else whatever puts the two in order."""
    sound: list[tuple[Change, Effect]] = []
    for change in pair.changes(trials.before.text.sources):
        effect = trials.of(change)
        if effect is not None and effect.findings and not effect.worse:
            sound.append((change, effect))
            if change.kind == "bounds" and _proves(effect):
                break
    if not sound:
        return None
    most = max(_proves(e) for _, e in sound)
    best = [(c, e) for c, e in sound if _proves(e) == most]
    first, effect = min(best, key=lambda b: b[0].order())
    equals = [c for c, _ in best if c is not first and (c.kind == first.kind or first.kind != "bounds")]
    return Proposal(
        first, effect, (_now(pair), _then(most)), tuple(equals[:MOST_SHOWN]), max(0, len(equals) - MOST_SHOWN)
    )


def _proves(effect: Effect) -> int:
    """How many violated parts are gone: the evidence beyond the order of the two."""
    return len(effect.mended) + len(effect.better) + len(effect.fewer)


def _now(pair: Backwards) -> str:
    low, high = pair.low, pair.high
    return f"{low.column} = {quantity(low.number, None)} is above {high.column} = {quantity(high.number, None)}"


def _then(proved: int) -> str:
    if proved:
        return "then the range holds what the model does there"
    return "then they are in order; no claim tells whether they are right"
