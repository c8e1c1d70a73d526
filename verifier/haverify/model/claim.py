"""Claims: what should be true, for how long, under which assumptions, and which verdict is expected."""

from __future__ import annotations

from fractions import Fraction
from typing import TYPE_CHECKING

from haverify.model.expression import Expr
from haverify.model.hybrid import Range
from haverify.text.record import record
from haverify.text.span import Span

if TYPE_CHECKING:
    from haverify.model.unit import Unit


@record
class Goal:
    """One goal line; `kind` is always, reach, can_reach, can_always, stl, holds or cycle."""

    kind: str
    condition: Expr
    window: tuple[Expr, Expr] | None = None
    within: Expr | None = None
    attracting: bool = False
    span: Span | None = None


@record
class Expectation:
    """The verdict a claim is expected to have; `margin` and `share` are (comparison, bound)."""

    verdict: str
    margin: tuple[str, Expr] | None = None
    share: tuple[str, Fraction] | None = None
    because: str | None = None
    span: Span | None = None


@record
class Claim:
    """A property or an invariant. `using` names invariants it may assume, `which` params whose range is to be split."""

    name: str
    on: str | None
    kind: str  # "property" or "invariant"
    goals: tuple[Goal, ...]
    time: Expr | None
    jumps: int | None
    assume: tuple[Expr, ...]
    which: tuple[tuple[str, Range], ...]
    using: tuple[str, ...]
    method: tuple[str, tuple[tuple[str, str], ...]] | None
    expect: Expectation | None
    inductive: bool
    doc: str = ""
    text: str = ""  # as written, for people
    span: Span | None = None
    allow: tuple[str, ...] = ()

    def margin_unit(self) -> Unit | None:
        """The unit of the expected margin, where one is stated."""
        return self.expect.margin[1].unit if self.expect and self.expect.margin else None
