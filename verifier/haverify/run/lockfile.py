"""`haverify.lock` on disk: a TOML file, beside the spec or above it, in one fixed layout."""

from __future__ import annotations

import os
import re
from collections.abc import Mapping
from itertools import pairwise
from json import loads
from json.encoder import encode_basestring
from pathlib import Path
from typing import Any

from haverify.errors import UsageError
from haverify.report.baseline import Baseline, FindingEntry, RefutedEntry
from haverify.text.source import Source
from haverify.text.span import Span

NAME = "haverify.lock"

_HEAD = """\
# Accepted findings, and the parts in which claims are known to be violated; each with its reason.
# Written by `haverify accept`; a line `expires = 2030-12-31` ends an acceptance.
version = 1
"""

_LINE = re.compile(r'^(\w+) = ("[^\n]*"|\[(?:\n  "[^\n]*)*\n\])$', re.MULTILINE)
_FINDING_KEYS = ("spec", "code", "key", "text", "reason")


def nearest(spec: Path) -> Path | None:
    """The lock file beside a spec, else the first one above it."""
    folder = spec.resolve().parent
    return next((at / NAME for at in (folder, *folder.parents) if (at / NAME).is_file()), None)


def name_in(lock: Path, spec: Path) -> str:
    """How entries of `lock` name a spec: its path from the folder of the lock file, with `/`."""
    return Path(os.path.relpath(spec.resolve(), lock.resolve().parent)).as_posix()


def read(path: Path) -> tuple[Baseline, Source]:
    """The entries of a lock file, each with its place in it.

    Raises
    ------
    UsageError      if it is no lock file of version 1
    """
    shown = os.path.relpath(path)
    try:
        text = path.read_text(encoding="utf-8")
    except (OSError, UnicodeDecodeError) as e:
        raise UsageError(f"{shown}: cannot be read as a lock file: {e}") from e
    return _as_written(shown, text) or _parsed(shown, text), Source.of_text(shown, text)


def _as_written(shown: str, text: str) -> Baseline | None:
    """The entries of a text in the layout of `written`, in any order, else None: much faster than a parser.

    What is read is a guess, which counts where writing it gives the text.
    """
    kinds: list[str] = []
    content: dict[str, list[dict[str, Any]]] = {"finding": [], "refuted": []}
    try:
        for block in text.split("\n[[")[1:]:
            kind, _, lines = block.partition("]]\n")
            content[kind].append({key: loads(value) for key, value in _LINE.findall(lines.replace(",\n]", "\n]"))})
            kinds.append(kind)
        found = _entries(shown, text, content)
    except (KeyError, TypeError, ValueError, RecursionError):
        return None
    texts = {"finding": map(_finding_text, found.findings), "refuted": map(refuted_text, found.refuted)}
    return found if "\n".join([_HEAD, *(next(texts[kind]) for kind in kinds)]) == text else None


def _parsed(shown: str, text: str) -> Baseline:
    import tomllib

    try:
        content = tomllib.loads(text)
    except (tomllib.TOMLDecodeError, RecursionError) as e:
        raise UsageError(f"{shown}: cannot be read as a lock file: {e}") from e
    if content.get("version") != 1 or not content.keys() <= {"version", "finding", "refuted"}:
        raise UsageError(f"{shown}: not a lock file of version 1")
    try:
        return _entries(shown, text, content)
    except (KeyError, TypeError, ValueError, AttributeError) as e:
        raise UsageError(f"{shown}: an entry is not as `haverify accept` writes it: {e}") from e


def _entries(shown: str, text: str, content: Mapping[str, Any]) -> Baseline:
    places = {kind: _places(shown, text, kind) for kind in ("finding", "refuted")}
    findings = tuple(_finding(e, s) for e, s in zip(content.get("finding", []), places["finding"], strict=True))
    refuted = tuple(_refuted(e, s) for e, s in zip(content.get("refuted", []), places["refuted"], strict=True))
    return Baseline(findings, refuted)


def _places(path: str, text: str, kind: str) -> list[Span]:
    """The span of each `[[kind]]` block, the empty lines after it included."""
    starts = [m.start() for m in re.finditer(r"^\[\[", text, re.MULTILINE)] + [len(text)]
    return [Span(path, a, b) for a, b in pairwise(starts) if text.startswith(f"[[{kind}]]", a)]


def _finding(entry: dict[str, Any], span: Span) -> FindingEntry:
    if (expires := entry.get("expires")) is not None:
        from datetime import date

        if type(expires) is not date:
            raise ValueError(f"expires is {expires!r}, not a date")
    spec, code, key, text, reason = (_text(entry, name) for name in _FINDING_KEYS)
    return FindingEntry(spec, code, key, text, reason, expires, span)


def _refuted(entry: dict[str, Any], span: Span) -> RefutedEntry:
    parts = entry["parts"]
    if not isinstance(parts, list) or not all(isinstance(p, str) for p in parts):
        raise ValueError("parts is no list of strings")
    return RefutedEntry(_text(entry, "spec"), _text(entry, "claim"), tuple(parts), _text(entry, "reason"), span)


def _text(entry: dict[str, Any], key: str) -> str:
    if not isinstance(entry[key], str):
        raise ValueError(f"{key} is no string")
    return str(entry[key])


def written(baseline: Baseline) -> str:
    """The text of a lock file, the same for the same entries."""
    findings = sorted(baseline.findings, key=lambda e: (e.spec, e.code, e.key, e.text))
    refuted = sorted(baseline.refuted, key=lambda e: (e.spec, e.claim))
    return "\n".join([_HEAD, *map(_finding_text, findings), *map(refuted_text, refuted)])


def _finding_text(e: FindingEntry) -> str:
    lines = ["[[finding]]", *(f"{key} = {quoted(getattr(e, key))}" for key in _FINDING_KEYS)]
    if e.expires:
        lines.append(f"expires = {e.expires.isoformat()}")
    return "\n".join(lines) + "\n"


def refuted_text(e: RefutedEntry) -> str:
    """An entry about a refuted claim, as it stands in the file."""
    lines = ["[[refuted]]", *(f"{key} = {quoted(getattr(e, key))}" for key in ("spec", "claim", "reason"))]
    lines += ["parts = [", *(f"  {quoted(part)}," for part in e.parts), "]"]
    return "\n".join(lines) + "\n"


def quoted(text: str) -> str:
    """A TOML string in double quotes."""
    return encode_basestring(text).replace("\x7f", "\\u007f")


def write(path: Path, baseline: Baseline) -> None:
    """Put the entries in place of the file, in one step."""
    beside = path.with_name(f".{path.name}.{os.getpid()}")
    beside.write_text(written(baseline), encoding="utf-8")
    beside.replace(path)
