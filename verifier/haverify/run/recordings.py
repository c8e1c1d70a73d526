"""Reading recordings from files: the bytes, as text where the format is one."""

from __future__ import annotations

import contextlib
import hashlib
from collections.abc import Collection, Iterable
from pathlib import Path

from haverify.diagnostics.diagnostic import Diagnostic
from haverify.recordings.read import SUFFIXES, read
from haverify.recordings.recording import Forces, Read, Recording
from haverify.run.load import MAX_BYTES
from haverify.text.record import record
from haverify.text.source import Source
from haverify.text.span import Span


@record
class Recorded:
    """What some files hold, with what is odd about them and the texts that findings point into."""

    recordings: tuple[Recording, ...]
    forces: tuple[Forces, ...]
    found: tuple[Diagnostic, ...]
    sources: dict[str, Source]


def recorded(paths: Iterable[str], angles: str = "", absent: Collection[str] = ()) -> Recorded:
    """The recordings and ground forces in some files, in order; joints of `absent` may have no column."""
    reads, sources = [], dict[str, Source]()
    for path in dict.fromkeys(Path(p).as_posix() for p in paths):
        one, source = _read(path, angles, absent)
        reads.append(one)
        if source is not None:
            sources[path] = source
    return Recorded(
        tuple(r.recording for r in reads if r.recording is not None),
        tuple(r.forces for r in reads if r.forces is not None),
        tuple(d for r in reads for d in r.found),
        sources,
    )


def _read(path: str, angles: str, absent: Collection[str]) -> tuple[Read, Source | None]:
    file = Path(path)
    if file.suffix.lower() not in SUFFIXES:
        message = f"{path}: recordings end in {', '.join(SUFFIXES)}"
        return Read(None, None, (Diagnostic("HA210", message),)), None
    try:
        if file.stat().st_size > MAX_BYTES:
            return Read(None, None, (Diagnostic("HA006", f"{path}: larger than {MAX_BYTES} bytes"),)), None
        raw = file.read_bytes()
    except OSError as e:
        return Read(None, None, (Diagnostic("HA006", f"cannot read {path}: {e.strerror}"),)), None
    if file.suffix.lower() == ".c3d":
        from haverify.recordings.c3d import c3d

        made, found = c3d(path, hashlib.sha256(raw).hexdigest())
        return Read(made, None, tuple(found)), None
    text = _decoded(raw)
    source = Source(path, text, raw)
    zero = text.find("\0")
    if zero >= 0:
        message = "a zero byte: a binary file, no text"
        return Read(None, None, (Diagnostic("HA210", message, Span(path, zero, zero + 1)),)), source
    return read(source, angles, absent), source


def _decoded(raw: bytes) -> str:
    """The text, as UTF-8, as UTF-16 where zeros or a mark at its begin show it, else in Latin letters.

    All line ends become one character.
    """
    text = ""
    for coding in _codings(raw[:200]):
        with contextlib.suppress(UnicodeDecodeError):
            text = raw.decode(coding)
            break
    return text.replace("\r\n", "\n").replace("\r", "\n")


def _codings(head: bytes) -> tuple[str, ...]:
    """How a text may be coded, by its first bytes: in UTF-16 every other byte of numbers and labels is zero."""
    if head.startswith((b"\xff\xfe", b"\xfe\xff")):
        return ("utf-16", "latin-1")
    for first, coding in ((1, "utf-16-le"), (0, "utf-16-be")):
        if len(head) > 3 and not any(head[first::2]) and all(head[1 - first :: 2]):
            return (coding, "latin-1")
    return ("utf-8-sig", "latin-1")
