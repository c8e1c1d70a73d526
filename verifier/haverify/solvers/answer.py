"""What is known of the question whether conditions can hold together."""

from __future__ import annotations

from fractions import Fraction

from haverify.model.expression import Expr
from haverify.text.record import record


@record
class Holds:
    """The conditions hold together at `point`; where `is_exact` is False the point depends on stand-ins."""

    point: dict[str, Fraction]
    is_exact: bool = True


@record
class Contradiction:
    """The conditions never hold together; those in `core` are the reason."""

    core: tuple[Expr, ...]


@record
class Undecided:
    """Neither was found."""

    reason: str


Answer = Holds | Contradiction | Undecided
