"""Fixes applied to files: whole fixes only, and never two to one place."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from pathlib import Path

from haverify.diagnostics.diagnostic import Diagnostic, Edit, Fix
from haverify.diagnostics.edits import edited
from haverify.text.source import Source


def apply(found: Iterable[Diagnostic], sources: Mapping[str, Source], unsafe: bool) -> list[str]:
    """Apply the safe fixes (with `unsafe`, all) to the files; what was done, in words.

    A fix that overlaps one already taken waits for the next call. A file that changed since it was read is left alone.
    """
    taken: list[Edit] = []
    done = []
    for d in found:
        if d.fix is not None and (d.fix.safe or unsafe) and not _overlaps(d.fix, taken):
            taken += d.fix.edits
            done.append(f"{d.code}: {d.fix.description}")
    for path in sorted({e.span.path for e in taken}):
        _rewrite(sources[path], [e for e in taken if e.span.path == path])
    return done


def _overlaps(fix: Fix, taken: Iterable[Edit]) -> bool:
    return any(_meet(a, b) for a in fix.edits for b in taken)


def _meet(a: Edit, b: Edit) -> bool:
    """Whether two edits touch one place; two insertions at one point do."""
    if a.span.path != b.span.path:
        return False
    return (a.span.start < b.span.end and b.span.start < a.span.end) or a.span.start == b.span.start


def _rewrite(source: Source, edits: list[Edit]) -> None:
    """Write the edited text in one step, keeping a byte order mark and the kind of line ends."""
    path = Path(source.path)
    raw = path.read_bytes()
    had_mark, had_crlf = raw.startswith(b"\xef\xbb\xbf"), b"\r\n" in raw
    if raw.decode("utf-8-sig").replace("\r\n", "\n").replace("\r", "\n") != source.text:
        return
    text = edited(source.text, edits).replace("\n", "\r\n" if had_crlf else "\n")
    beside = path.with_name(f".{path.name}.fix")
    beside.write_bytes((b"\xef\xbb\xbf" if had_mark else b"") + text.encode())
    beside.chmod(path.stat().st_mode)
    beside.replace(path)
