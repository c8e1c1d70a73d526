"""Which literals among the premises a proof or a rule reads."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

from haverify.obligations.formula import Literal
from haverify.obligations.premises import Premises


def used(told: Any, premises: Premises) -> set[Literal]:
    """The literals that a PROOF or a RULE names by their places; what it adds to the premises is left out.

    A proof `t` names none: of those, the literals that have a polynomial in common with others are taken.
    """
    entries = premises.entries
    found = {e for i in _places(told) if i < len(entries) and isinstance(e := entries[i], Literal)}
    return found | (_twins(premises) if "t" in _words(told) else set())


def _places(told: Any) -> Iterator[int]:
    if isinstance(told, int):
        yield told
    elif isinstance(told, dict):
        yield from (i for v in told.values() for i in _places(v))
    elif isinstance(told, list):
        yield from (i for v in told for i in _places(v))


def _words(told: Any) -> Iterator[str]:
    if isinstance(told, str):
        yield told
    elif isinstance(told, dict):
        yield from (w for v in told.values() for w in _words(v))
    elif isinstance(told, list):
        yield from (w for v in told for w in _words(v))


def _twins(premises: Premises) -> set[Literal]:
    """Literals whose polynomial is, up to its sign, that of another."""
    literals = [e for e in premises.entries if isinstance(e, Literal)]
    return {q for q in literals if sum(o.polynomial in (q.polynomial, -q.polynomial) for o in literals) > 1}
