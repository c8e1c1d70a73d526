"""The order in which findings are shown: the same for the same spec, one message per cause."""

from __future__ import annotations

from collections.abc import Iterable

from haverify.diagnostics.diagnostic import Diagnostic

_SYNTAX = ("HA001", "HA003")
_NOWHERE = ("", -1, -1)


def settle(found: Iterable[Diagnostic]) -> list[Diagnostic]:
    """The findings without repetitions (same code, place and message), by place, then code, then message.

    What is wrong with the text comes first: others may follow from it. Of the others those without a place come
    first: they concern the whole file.
    """
    first: dict[tuple[object, ...], Diagnostic] = {}
    for d in found:
        first.setdefault((d.code not in _SYNTAX, *_place(d), d.code, d.message), d)
    return [first[key] for key in sorted(first)]


def _place(d: Diagnostic) -> tuple[str, int, int]:
    return (d.span.path, d.span.start, d.span.end) if d.span else _NOWHERE
