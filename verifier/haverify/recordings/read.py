"""A file of any known format to what it holds, by its suffix."""

from __future__ import annotations

from collections.abc import Collection

from haverify.diagnostics.diagnostic import Diagnostic
from haverify.recordings.angles import Stated, recording
from haverify.recordings.recording import Read, Recording
from haverify.text.source import Source
from haverify.text.span import Span

SUFFIXES = (".mot", ".sto", ".csv", ".tsv", ".txt", ".trc", ".c3d", ".json")


def read(source: Source, angles: str = "", absent: Collection[str] = ()) -> Read:
    """What a text file holds; `angles` (`deg`, `rad` or empty) is the unit the caller states.

    Columns of the joints of `absent` may be missing.
    """
    suffix = "." + source.path.rsplit(".", 1)[-1].lower()
    if suffix in (".mot", ".sto"):
        return _storage(source, angles, absent)
    made, found = _others(source, suffix, angles, absent)
    return Read(made, None, tuple(found))


def _others(
    source: Source, suffix: str, angles: str, absent: Collection[str]
) -> tuple[Recording | None, list[Diagnostic]]:
    if suffix == ".trc":
        from haverify.recordings.trc import trc

        return trc(source)
    if suffix == ".json":
        from haverify.recordings.landmarks import landmarks

        return landmarks(source)
    from haverify.recordings.delimited import delimited

    return delimited(source, angles, absent)


def _storage(source: Source, angles: str, absent: Collection[str]) -> Read:
    """Angles, or ground forces where the file holds these only."""
    from haverify.recordings.forces import forces
    from haverify.recordings.labels import joints
    from haverify.recordings.storage import storage

    header, columns, found = storage(source)
    if columns is None or any(d.code == "HA210" for d in found):
        return Read(None, None, tuple(found))
    if not joints(columns.labels):
        ground, more = forces(columns)
        if ground is not None or more:
            return Read(None, ground, (*found, *more))
    place = Span(source.path, 0, len(source.line(1)))
    stated = Stated(angles, f"--angles {angles}", place) if angles else Stated(header.unit, header.why, place)
    time = next((i for i, label in enumerate(columns.labels) if label.lower() == "time"), 0)
    made, more = recording(columns, time, stated, absent=absent)
    return Read(made, None, (*found, *more))
