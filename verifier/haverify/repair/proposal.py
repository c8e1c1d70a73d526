"""What a repair comes to: proposals with their reasons, and what no small change mends."""

from __future__ import annotations

from haverify.diagnostics.diagnostic import Edit
from haverify.repair.change import Change
from haverify.repair.effect import Effect
from haverify.text.record import record


@record
class Proposal:
    """A change that was tried and found to help.

    `notes` say what is the case now and then; `equals` are changes that nothing here tells from this
    one, `more` how many further ones there are, `next` says in words how good the best of the others is.
    """

    change: Change
    effect: Effect
    notes: tuple[str, ...] = ()
    equals: tuple[Change, ...] = ()
    more: int = 0
    next: str = ""


@record
class Outcome:
    """Proposals in order of place, what they do together, the problems that are left, and remarks.

    `edits` are those of all proposals and the recorded hashes of edited files, which follow.
    """

    proposals: tuple[Proposal, ...]
    together: Effect | None
    edits: tuple[Edit, ...]
    left: tuple[str, ...]
    remarks: tuple[str, ...] = ()
