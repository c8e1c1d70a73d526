"""`report.json`: the report's facts as they are, keys sorted, the same bytes for the same facts."""

from __future__ import annotations

import json
from collections.abc import Iterable
from functools import cache
from json.encoder import encode_basestring
from typing import Any

from haverify.report.report import Finding, Report


def as_json(report: Report) -> str:
    """The text of `report.json`."""
    return _laid_out(report, "\n") + "\n"


def as_line(report: Report) -> str:
    """The report on one line: several specs make several lines."""
    return json.dumps(_plain(report), sort_keys=True, ensure_ascii=False) + "\n"


def findings_as_json(findings: Iterable[Finding]) -> str:
    """Findings alone, for `lint --format json`."""
    return _laid_out(list(findings), "\n") + "\n"


def facts_as_json(facts: Any) -> str:
    """Facts of another kind, laid out like a report."""
    return _laid_out(facts, "\n") + "\n"


def _plain(value: Any) -> Any:
    """Records as objects."""
    if isinstance(value, dict):
        return {key: _plain(v) for key, v in value.items()}
    if isinstance(value, list | tuple):
        return [_plain(v) for v in value]
    names = getattr(value, "__match_args__", None)
    return value if names is None else {name: _plain(getattr(value, name)) for name in names}


def _laid_out(value: Any, margin: str) -> str:
    """`json.dumps` of the plain value with an indent of 1 and sorted keys, which is slow in Python.

    `margin` begins a line.
    """
    if isinstance(value, str):
        return encode_basestring(value)
    if value is None:
        return "null"
    inner = margin + " "
    if isinstance(value, (list, tuple)):
        return f"[{inner}{f',{inner}'.join([_laid_out(v, inner) for v in value])}{margin}]" if value else "[]"
    if isinstance(value, dict):
        rows = [f"{encode_basestring(k)}: {_laid_out(v, inner)}" for k, v in sorted(value.items())]
    elif names := _sorted_fields(value.__class__):
        rows = [f'"{name}": {_laid_out(getattr(value, name), inner)}' for name in names]
    else:
        return json.dumps(value)
    return f"{{{inner}{f',{inner}'.join(rows)}{margin}}}" if rows else "{}"


@cache
def _sorted_fields(cls: type) -> tuple[str, ...]:
    """The fields of a class of records in order of name; none of any other class."""
    return tuple(sorted(getattr(cls, "__match_args__", ())))
