"""Proposals as people read them, as JSON, and as a difference that `patch` applies."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from difflib import unified_diff
from typing import Any

from haverify.diagnostics.diagnostic import Diagnostic, Edit, Label
from haverify.diagnostics.edits import edited, edited_source
from haverify.diagnostics.render import places, where
from haverify.repair.change import KINDS, Change
from haverify.repair.effect import Effect
from haverify.repair.proposal import Outcome, Proposal
from haverify.text.source import Source

Sources = Mapping[str, Source]
_MOST_NAMED, _MOST_LEFT, _LONGEST = 4, 8, 100
_CARRIER = "HA212"  # any code: only the excerpt of a finding is used


def as_text(path: str, outcome: Outcome, sources: Sources) -> str:
    """The proposals one after the other, then what they come to."""
    if not outcome.proposals and not outcome.left:
        return "".join([*(f"note: {r}\n" for r in outcome.remarks), f"{path}: nothing to repair\n"])
    count = len(outcome.proposals)
    blocks = [
        "\n".join([f"repair {k} of {count}: {_title(p.change, sources)}", *_body(p, sources)]) + "\n"
        for k, p in enumerate(outcome.proposals, 1)
    ]
    return "\n".join([*blocks, "\n".join(_closing(path, outcome)) + "\n"])


def _title(change: Change, sources: Sources) -> str:
    """A change in a line: kind, place, old and new."""
    swaps = " and ".join(f"{sources[e.span.path].at(e.span)} -> {e.text}" for e in change.edits)
    return f"{KINDS[change.kind]}, {change.what}: {swaps}"


def _body(p: Proposal, sources: Sources) -> Iterator[str]:
    first, *rest = p.change.edits
    labels = tuple(Label(e.span, e.text) for e in rest)
    yield from places(Diagnostic(_CARRIER, "", first.span, first.text, labels), sources)
    yield from (f"   = note: {n}" for n in p.notes)
    yield from (f"   = {line}" for line in _reasons(p.effect))
    for c in p.equals:
        yield f"   = equally good: {where(c.edits[0].span, sources)}: {_title(c, sources)}"
    if p.more:
        yield f"   = equally good: {p.more} more; nothing here tells them apart"
    if p.next:
        yield f"   = note: {p.next}"
    yield from (f"   = line: {text}" for text in changed_lines(p.change.edits, sources))


def _reasons(e: Effect) -> Iterator[str]:
    if e.findings:
        yield f"finding gone: {_named(e.findings)}"
    if e.mended:
        yield f"as expected now: {_named(e.mended)}"
    if e.better:
        yield f"proved now, though `expect refuted` stands there: {_named(e.better)}"
    if e.fewer:
        yield f"no longer violated: {_named(e.fewer)}"
    if e.worse:
        yield f"worse: {_named(e.worse)}"
    if e.come:
        yield f"seen only then: {_named(e.come)}"


def _named(names: Iterable[str]) -> str:
    found = [_clipped(" ".join(n.split())) for n in names]
    more = len(found) - _MOST_NAMED
    return "; ".join(found[:_MOST_NAMED]) + (f"; and {more} more" if more > 0 else "")


def _clipped(text: str) -> str:
    return text if len(text) <= _LONGEST else text[: _LONGEST - 3] + "..."


def changed_lines(edits: Iterable[Edit], sources: Sources) -> Iterator[str]:
    """The lines that edits change, as they are afterwards; edits keep the number of lines."""
    edits = list(edits)
    for path in dict.fromkeys(e.span.path for e in edits):
        own = [e for e in edits if e.span.path == path]
        after = Source.of_text(path, edited(sources[path].text, own))
        lines = sorted({sources[path].position(e.span.start)[0] for e in own})
        yield from (after.line(n).strip() for n in lines)


def _closing(path: str, o: Outcome) -> Iterator[str]:
    yield from (f"note: {r}" for r in o.remarks)
    yield from (f"left: {_clipped(' '.join(text.split()))}" for text in o.left[:_MOST_LEFT])
    if len(o.left) > _MOST_LEFT:
        yield f"left: {len(o.left) - _MOST_LEFT} more (`--format json` lists all)"
    if not o.proposals:
        yield f"{path}: something is wrong, and no small change mends it"
        return
    if o.together is not None and len(o.proposals) > 1:
        yield "together:"
        yield from (f"   = {line}" for line in _reasons(o.together))
    s = "s" if len(o.proposals) > 1 else ""
    yield f"{path}: {len(o.proposals)} repair{s} proposed; nothing was written"
    yield f"    haverify repair --diff {path} | patch -p0"


def as_diff(outcome: Outcome, sources: Sources) -> str:
    """All proposals as one unified difference, with the recorded hashes that follow."""
    found: list[str] = []
    for path in sorted({e.span.path for e in outcome.edits}):
        old = sources[path]
        new = edited_source(old, [e for e in outcome.edits if e.span.path == path])
        found += _lines(unified_diff(_split(old.raw), _split(new.raw), path, path))
    return "".join(found)


def _split(raw: bytes) -> list[str]:
    """The lines of a file with their ends, byte order mark and carriage returns included."""
    lines = [line + "\n" for line in raw.decode("utf-8").split("\n")]
    return [*lines[:-1], *([lines[-1][:-1]] if lines[-1] != "\n" else [])]


def _lines(difference: Iterable[str]) -> Iterator[str]:
    for line in difference:
        yield line if line.endswith("\n") else line + "\n\\ No newline at end of file\n"


def as_json(path: str, outcome: Outcome, sources: Sources, exit_code: int) -> dict[str, Any]:
    """The same as data (`haverify.repair/1`)."""
    return {
        "schema": "haverify.repair/1",
        "spec": path,
        "repairs": [_proposal(p, sources) for p in outcome.proposals],
        "together": _effect(outcome.together) if outcome.together else None,
        "left": list(outcome.left),
        "remarks": list(outcome.remarks),
        "diff": as_diff(outcome, sources),
        "exit_code": exit_code,
    }


def _proposal(p: Proposal, sources: Sources) -> dict[str, Any]:
    return {
        **_change(p.change, sources),
        "notes": [*p.notes, *([p.next] if p.next else [])],
        "effect": _effect(p.effect),
        "equals": [_change(c, sources) for c in p.equals],
        "more_equals": p.more,
        "lines": list(changed_lines(p.change.edits, sources)),
    }


def _change(c: Change, sources: Sources) -> dict[str, Any]:
    return {"kind": c.kind, "what": c.what, "edits": [_edit(e, sources) for e in c.edits]}


def _edit(e: Edit, sources: Sources) -> dict[str, Any]:
    source = sources[e.span.path]
    (line, column), (end_line, end_column) = source.position(e.span.start), source.position(e.span.end)
    return {
        "path": e.span.path, "line": line, "column": column, "end_line": end_line, "end_column": end_column,
        "old": source.at(e.span), "new": e.text,
    }  # fmt: skip


def _effect(e: Effect) -> dict[str, Any]:
    return {
        "findings_gone": list(e.findings), "claims_mended": list(e.mended), "proved_unexpectedly": list(e.better),
        "no_longer_violated": list(e.fewer), "worse": list(e.worse),
        "findings_seen_then": list(e.come),
    }  # fmt: skip
