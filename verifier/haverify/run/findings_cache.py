"""What the rules found in a spec, kept between runs under the hash of all its texts and of haverify's own code.

Findings come from nothing else, so the same key means the same findings. They are no evidence: no verdict rests on
them, and `--no-cache` looks anew. A damaged or edited file costs the time to look again.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import Any

from haverify.diagnostics.codes import CATALOGUE
from haverify.diagnostics.diagnostic import Diagnostic, Edit, Fix, Label, Severity
from haverify.run import kept
from haverify.run.keys import code_hash, digest
from haverify.text.source import Source
from haverify.text.span import Span

_SCHEMA = "haverify.findings/1"
_SHELF = "findings"  # of its own: a spec that is linted after each change does not push evidence out


def found_once(sources: Mapping[str, Source], look: Callable[[], list[Diagnostic]]) -> list[Diagnostic]:
    """What `look` finds in the texts; it is called where that is not known from an earlier run."""
    key = digest([_SCHEMA, code_hash(), sorted([s.path, s.sha256] for s in sources.values())])
    known = _findings(kept.load(key, _SHELF), sources)
    if known is not None:
        return known
    found = look()
    kept.store(key, {"schema": _SCHEMA, "findings": [_to(d) for d in found]}, _SHELF)
    return found


def _findings(value: Any, sources: Mapping[str, Source]) -> list[Diagnostic] | None:
    if not isinstance(value, dict) or value.get("schema") != _SCHEMA:
        return None
    try:
        return [_from(d, sources) for d in value["findings"]]
    except (KeyError, TypeError, ValueError):
        return None


def _to(d: Diagnostic) -> list[Any]:
    fix = d.fix and [d.fix.description, [[_place(e.span), e.text] for e in d.fix.edits], d.fix.safe]
    labels = [[_place(x.span), x.text] for x in d.labels]
    severity = d.severity and d.severity.value
    return [d.code, d.message, _place(d.span), d.label, labels, list(d.notes), d.help, fix, d.key, severity]


def _place(span: Span | None) -> list[Any] | None:
    return None if span is None else [span.path, span.start, span.end]


def _from(value: Any, sources: Mapping[str, Source]) -> Diagnostic:
    code, message, span, label, labels, notes, help_, fix, key, severity = value
    if code not in CATALOGUE:
        raise ValueError(code)
    return Diagnostic(
        code,
        _text(message),
        span and _span(span, sources),
        _text(label),
        tuple(Label(_span(at, sources), _text(text)) for at, text in labels),
        tuple(map(_text, notes)),
        help_ and _text(help_),
        fix and _fix(fix, sources),
        _text(key),
        severity and Severity(severity),
    )


def _fix(value: Sequence[Any], sources: Mapping[str, Source]) -> Fix:
    description, edits, is_safe = value
    changes = tuple(Edit(_span(at, sources), _text(text)) for at, text in edits)
    return Fix(_text(description), changes, bool(is_safe))


def _span(value: Sequence[Any], sources: Mapping[str, Source]) -> Span:
    path, start, end = value
    if not 0 <= int(start) <= int(end) <= len(sources[path].text):
        raise ValueError(value)
    return Span(path, int(start), int(end))


def _text(value: Any) -> str:
    if not isinstance(value, str):
        raise TypeError(value)
    return value
