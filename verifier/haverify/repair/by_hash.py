"""Files that changed since their hash was recorded, by one slip: undone, they have the recorded hash again."""

from __future__ import annotations

from collections.abc import Iterator

from haverify.diagnostics.diagnostic import Edit
from haverify.diagnostics.edits import edited_source
from haverify.repair.cells import cells_by_line, line_changes
from haverify.repair.change import Change
from haverify.repair.subject import Subject, pinned
from haverify.text.record import replace
from haverify.text.source import Source

MOST_TRIED = 20_000


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
    tried = 0
    for (path, _), places in cells_by_line(subject.spec).items():
        for change in line_changes(places, subject.text.sources) if path == source.path else ():
            for spelled in _spellings(change):
                tried += 1
                if edited_source(source, spelled.edits).sha256 == wanted:
                    return spelled
        if tried > MOST_TRIED:
            return None
    return None


def _spellings(change: Change) -> Iterator[Change]:
    """The change, and the same with a plus sign in front of a number that has no sign."""
    yield change
    if len(change.edits) == 1 and change.edits[0].text[:1] not in "+-":
        yield replace(change, edits=(Edit(change.edits[0].span, "+" + change.edits[0].text),))
