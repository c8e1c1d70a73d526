"""A small change to a spec or to one of its tables: what a slip of the pen, undone, comes to."""

from __future__ import annotations

from fractions import Fraction

from haverify.diagnostics.diagnostic import Edit
from haverify.text.record import record

KINDS = {
    "bounds": "two bounds swapped",
    "sign": "one sign",
    "point": "one decimal place",
    "digits": "two digits swapped",
    "cells": "two neighbouring cells swapped",
    "strictness": "one bound open or closed",
    "bit": "one bit of a rule",
    "fix": "what the finding proposes",
}
"""The kinds of change, the likelier ones first, and how they are told."""

_ORDER = {kind: rank for rank, kind in enumerate(KINDS)}


@record
class Change:
    """Edits that belong together; `numbers` are the values that constants of table cells have after them."""

    kind: str
    edits: tuple[Edit, ...]
    what: str  # the place in words: `p4 in row LR`
    numbers: tuple[tuple[str, Fraction], ...] = ()

    @property
    def rank(self) -> int:
        """Likelier kinds have a smaller rank."""
        return _ORDER[self.kind]

    def order(self) -> tuple[int, str, int, str]:
        """A fixed order of changes that nothing else distinguishes."""
        first = self.edits[0]
        return (self.rank, first.span.path, first.span.start, first.text)
