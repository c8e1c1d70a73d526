"""Files that changed since their hash was recorded, by one slip: undone, they have the recorded hash again."""

from __future__ import annotations

from collections.abc import Iterator
from itertools import islice

from haverify.diagnostics.diagnostic import Edit
from haverify.diagnostics.edits import edited_source
from haverify.repair.cells import cells_by_line, line_changes
from haverify.repair.change import Change
from haverify.repair.subject import Subject, pinned
from haverify.text.record import replace
from haverify.text.source import Source

MOST_HASHED = 100_000_000  # bytes


def restoring(subject: Subject) -> dict[str, Change]:
    """The change, by file, that gives a file the hash its spec records and that it does not have."""
    found: dict[str, Change] = {}
    for line, source in pinned(subject.text):
        if line.text != source.sha256 and source.path not in found and subject.spec is not None:
            change = _restoring(subject, source, line.text)
            if change is not None:
                found[source.path] = change
    return found


def _restoring(subject: Subject, source: Source, wanted: str) -> Change | None:
    assert subject.spec is not None
    left = MOST_HASHED // max(1, len(source.raw))
    lines = (places for (path, _), places in cells_by_line(subject.spec).items() if path == source.path)
    changes = (
        c for places in lines for change in line_changes(places, subject.text.sources) for c in _spellings(change)
    )
    return next((c for c in islice(changes, left) if edited_source(source, c.edits).sha256 == wanted), None)


def _spellings(change: Change) -> Iterator[Change]:
    """The change, and the same with a plus sign in front of a number that has no sign."""
    yield change
    if len(change.edits) == 1 and change.edits[0].text[:1] not in "+-":
        yield replace(change, edits=(Edit(change.edits[0].span, "+" + change.edits[0].text),))
