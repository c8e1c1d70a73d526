"""Changes tried: the changed text read again, linted, and its claims decided again, exactly."""

from __future__ import annotations

from collections.abc import Sequence

from haverify.diagnostics.diagnostic import Edit
from haverify.repair.change import Change
from haverify.repair.effect import Effect, effect
from haverify.repair.reads import touched
from haverify.repair.subject import Subject
from haverify.text.record import field, holder


@holder
class Trials:
    """Trials of changes to one subject, which is linted and decided; what was tried is not tried again."""

    before: Subject
    _known: dict[tuple[Edit, ...], Subject] = field(default_factory=dict)

    def of(self, change: Change) -> Effect | None:
        """What a change does, None where it leaves the text without meaning."""
        after = self.after([change])
        return effect(self.before, after) if after is not None else None

    def after(self, changes: Sequence[Change]) -> Subject | None:
        """The subject after changes, linted and decided; None where it has no meaning."""
        edits = tuple(e for c in changes for e in c.edits)
        if edits not in self._known:
            self._known[edits] = self._tried(changes, edits)
        after = self._known[edits]
        return after if after.has_meaning else None

    def _tried(self, changes: Sequence[Change], edits: tuple[Edit, ...]) -> Subject:
        after = self.before.edited(edits)
        if after.has_meaning:
            after.lint()
        if after.has_meaning:
            after.evidence |= {n: e for n, e in self.before.evidence.items() if n not in self.touched(changes)}
            after.decide(after.claims)
        return after

    def touched(self, changes: Sequence[Change]) -> set[str]:
        """The claims that changes of table cells can touch; all where the text changes."""
        spec = self.before.spec
        if spec is None or not all(c.numbers for c in changes):
            return set(self.before.claims)
        return set(touched(spec, [n for c in changes for n, _ in c.numbers]))
