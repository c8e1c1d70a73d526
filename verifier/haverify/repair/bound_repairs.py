"""Proposals for bounds that are table cells and stand the wrong way round."""

from __future__ import annotations

from fractions import Fraction

from haverify.evidence.verdict import Margin, Refuted
from haverify.lint._facts import Facts
from haverify.lint._wording import quantity
from haverify.repair.backwards import Backwards, backwards
from haverify.repair.change import Change
from haverify.repair.effect import Effect
from haverify.repair.proposal import Proposal
from haverify.repair.subject import Subject
from haverify.repair.told import near
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
    """The exchange, if claims are violated less after it; else the change after which they are violated least."""
    written = _misses(trials.before)
    sound: list[tuple[Fraction, Change, Effect, str]] = []
    for change in pair.changes(trials.before.text.sources):
        effect, after = trials.of(change), trials.after([change])
        if effect is None or after is None or not effect.findings or effect.worse:
            continue
        then = _misses(after)
        moved = [k for k in written.keys() | then.keys() if written.get(k) != then.get(k)]
        gain = sum((_excess(written, k) - _excess(then, k) for k in moved), Fraction(0))
        sound.append((gain, change, effect, _told(written, then, moved)))
        if change.kind == "bounds" and gain > 0:
            break
    if not sound:
        return None
    most = max(s[0] for s in sound)
    best = sorted((s for s in sound if s[0] == most), key=lambda s: s[1].order())
    _, change, effect, told = best[0]
    equals = [s[1] for s in best[1:]]
    return Proposal(change, effect, (_now(pair), told), tuple(equals[:MOST_SHOWN]), len(equals[MOST_SHOWN:]))


_Misses = dict[tuple[str, int], Margin | None]


def _misses(subject: Subject) -> _Misses:
    """The margins of violated parts, by claim and number."""
    found: _Misses = {}
    for name, evidence in subject.evidence.items():
        for k, p in enumerate(evidence.parts):
            if isinstance(p.verdict, Refuted):
                found[name, k] = p.verdict.margin
    return found


def _excess(misses: _Misses, part: tuple[str, int]) -> Fraction:
    margin = misses.get(part)
    return -margin.low if margin is not None else Fraction(0)


def _told(written: _Misses, then: _Misses, moved: list[tuple[str, int]]) -> str:
    """What the claims that read the cells make of a change."""
    if not moved:
        return "no claim tells whether they are right then"
    worst = max((_excess(written, k), _unit(written, k)) for k in moved)
    left = max((_excess(then, k), _unit(then, k)) for k in moved)
    after = f"by at most {near(*left)} then" if any(k in then for k in moved) else "not at all then"
    return f"what claims state by them is violated by up to {near(*worst)} as written, {after}"


def _unit(misses: _Misses, part: tuple[str, int]) -> str:
    margin = misses.get(part)
    return margin.unit if margin is not None else ""


def _now(pair: Backwards) -> str:
    low, high = pair.low, pair.high
    return f"{low.column} = {quantity(low.number, None)} is above {high.column} = {quantity(high.number, None)}"
