"""Changes tried: the changed text read again, linted, and its claims decided again, exactly."""

from __future__ import annotations

from haverify.diagnostics.diagnostic import Edit
from haverify.repair.change import Change
from haverify.repair.effect import Effect, effect
from haverify.repair.reads import touched
from haverify.repair.subject import Subject
from haverify.text.record import holder


@holder
class Trials:
    """Trials of changes to one subject, which is linted and decided; `count` is how many there were."""

    before: Subject
    count: int = 0

    def of(self, change: Change) -> Effect | None:
        """What a change does, None where it leaves the text without meaning."""
        names = list(self.before.claims)
        if change.numbers and self.before.spec is not None:
            names = touched(self.before.spec, [n for n, _ in change.numbers])
        after = self.after(change.edits, names)
        return effect(self.before, after, names) if after is not None else None

    def after(self, edits: tuple[Edit, ...], names: list[str]) -> Subject | None:
        """The subject after edits, linted, with the named claims decided; None where it has no meaning."""
        self.count += 1
        after = self.before.edited(edits)
        if not after.has_meaning:
            return None
        after.lint()
        after.decide(names)
        return after
