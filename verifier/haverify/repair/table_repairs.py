"""Proposals for rows of tables that do not fit: located and chosen by exact ranges and steps, then tried."""

from __future__ import annotations

from fractions import Fraction

from haverify.lint._facts import Facts
from haverify.repair.by_hash import restoring
from haverify.repair.change import Change
from haverify.repair.choice import Choice, Chooser, Hopeless
from haverify.repair.curves import Curves
from haverify.repair.effect import Effect
from haverify.repair.fit import Fit
from haverify.repair.proposal import Proposal
from haverify.repair.stated import limits
from haverify.repair.told import change_text, near, row_notes
from haverify.repair.trial import Trials

Q = Fraction

MOST_SHOWN = 3


def table_repairs(trials: Trials, only: str | None) -> tuple[list[Proposal], list[Hopeless]]:
    """Proposals for lines of tables, and the lines that no single change makes fit; with `only`, those it speaks of."""
    subject = trials.before
    assert subject.spec is not None
    facts = Facts(subject.spec, subject.text.sources)
    fit = Fit(Curves(facts), limits(facts, subject.recorded))
    choices, hopeless = Chooser(fit, subject.text.sources).choose()
    restored = restoring(subject)
    found = [p for change in restored.values() if (p := _restored(trials, change)) is not None]
    wanted = [c for c in choices if c.line[0] not in restored and _is_about(c, only)]
    numbers = {n: v for c in wanted for n, v in c.change.numbers}
    for c in wanted:
        proposal = _proposal(trials, fit, c, numbers)
        if proposal is None:
            hopeless.append(Hopeless((c.line,), c.troubles))
        else:
            found.append(proposal)
    return found, [h for h in hopeless if not all(line[0] in restored for line in h.lines)]


def _is_about(choice: Choice, only: str | None) -> bool:
    claims = {t.limit.claim if t.limit else "" for t in choice.troubles}
    return only is None or any(only in (c, c.split("[")[0]) for c in claims)


def _restored(trials: Trials, change: Change) -> Proposal | None:
    effect = trials.of(change)
    return Proposal(change, effect, ("the file then has the sha256 that the spec records",)) if effect else None


def _proposal(trials: Trials, fit: Fit, choice: Choice, numbers: dict[str, Q]) -> Proposal | None:
    """The best of a choice's changes that a trial confirms."""
    candidates = [choice.change, *choice.equals, *([choice.next[0]] if choice.next else [])]
    for change in candidates:
        effect = trials.of(change)
        if effect is not None and effect.helps and not effect.worse:
            return _told(fit, choice, change, effect, numbers)
    return None


def _told(fit: Fit, choice: Choice, change: Change, effect: Effect, numbers: dict[str, Q]) -> Proposal:
    others = [c for c in choice.equals if c is not change]
    mine = {**numbers, **dict(change.numbers)}
    is_first = change is choice.change
    return Proposal(
        change,
        effect,
        row_notes(fit, choice, mine),
        tuple(others[:MOST_SHOWN]) if is_first else (),
        max(0, len(others) - MOST_SHOWN) if is_first else 0,
        _next(fit, choice) if is_first and not others else "",
    )


def _next(fit: Fit, choice: Choice) -> str:
    """The best of the changes that fit less well, in words."""
    if choice.next is None:
        return "no other change of this size makes the row fit"
    unit = fit.curves.rows[choice.keys[0]].unit
    other, misfit = choice.next
    sums = f"{near(misfit, unit)} instead of {near(choice.misfit, unit)}"
    return f"the next best change, {change_text(other)}, has steps of {sums} in sum"
