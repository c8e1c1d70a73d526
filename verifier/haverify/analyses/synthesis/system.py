"""What an invariant is sought for: a flow in one mode, its starts, its domain and the goal."""

from __future__ import annotations

from typing import Any

from haverify.maths.polynomial import Polynomial
from haverify.obligations.formula import Formula, Literal
from haverify.obligations.premises import Premises
from haverify.text.record import record


@record
class System:
    """`common`: what holds at all times; `starts`: premises of the starts of each init line, `common` included.

    Names that the field does not have are constant.
    """

    common: Premises
    starts: tuple[Premises, ...]
    goal: Formula
    field: dict[str, Polynomial]
    sight: tuple[Polynomial, ...] = ()  # sums that the text of the flow has, which may be worth a look


@record
class Cut:
    """A conjunction that the flow keeps, by `rule`, under the common premises and the cuts before it."""

    literals: tuple[Literal, ...]
    rule: dict[str, Any]


@record
class Jump:
    """An edge: what holds when it is taken, and the values that it gives to names."""

    source: str
    target: str
    known: Premises
    landing: dict[str, Polynomial]


@record
class Hybrid:
    """The systems of the modes, and the edges between them."""

    systems: dict[str, System]
    jumps: tuple[Jump, ...]
