"""HA510: values of a fuzzy input that belong to no term."""

from __future__ import annotations

from collections.abc import Iterator
from fractions import Fraction
from itertools import pairwise

from haverify.diagnostics.diagnostic import Diagnostic
from haverify.lint._facts import Facts
from haverify.lint._fuzzy import unfolded
from haverify.lint._registry import rule
from haverify.model.fuzzy import FuzzyInput
from haverify.model.spec import Spec

Gap = tuple[Fraction, bool, Fraction, bool]  # from, is it in, to, is it in


@rule("HA510")
def fuzzy_gap(spec: Spec, facts: Facts) -> Iterator[Diagnostic]:
    """Exact: between corners all degrees are linear. A lone end of the range, where ramps begin, is no gap."""
    for system, _ in unfolded(spec, facts):
        for i in system.inputs:
            found = [g for g in gaps(i) if g[0] != g[2] or g[0] not in (i.low, i.high)]
            if found and i.source is None and i.terms:
                yield _finding(system.name, i, found)


def gaps(i: FuzzyInput) -> Iterator[Gap]:
    """Maximal intervals of the input's range in which every term is 0."""
    if i.low is None or i.high is None or i.low > i.high:
        return
    from haverify.analyses.fuzzy_systems import membership
    from haverify.analyses.regions import named, value_at

    degrees = [membership(t, named(i.name)) for t in i.terms]
    corners = sorted({i.low, i.high} | {c for t in i.terms for c in t.corners if i.low < c < i.high})
    cells: list[Gap] = [(corners[0], True, corners[0], True)]
    for a, b in pairwise(corners):
        cells += [(a, False, b, False), (b, True, b, True)]
    open_: Gap | None = None
    for cell in cells:
        middle = {i.name: (cell[0] + cell[2]) / 2}
        if any(value_at(d, middle) > 0 for d in degrees):
            if open_ is not None:
                yield open_
            open_ = None
        else:
            open_ = cell if open_ is None else (*open_[:2], *cell[2:])
    if open_ is not None:
        yield open_


def _text(i: FuzzyInput, gap: Gap) -> str:
    from haverify.analyses.fuzzy_telling import quantity

    low, low_in, high, high_in = gap
    if low == high:
        return f"{i.name} = {quantity(low, i.unit)}"
    left, right = quantity(low, i.unit), quantity(high, i.unit)
    return f"{i.name} in {'[' if low_in else '('}{left}, {right}{']' if high_in else ')'}"


def _finding(system: str, i: FuzzyInput, found: list[Gap]) -> Diagnostic:
    texts = [_text(i, g) for g in found]
    more = (f"also {', '.join(texts[1:])}",) if len(texts) > 1 else ()
    return Diagnostic(
        "HA510",
        f"{texts[0]}: no term above 0",
        span=i.span,
        notes=(*more, f"no rule of {system} that reads `{i.name}` through a term fires there"),
        help="widen a term, or narrow the range that the input is declared over",
        key=f"{system}: no term for {', '.join(texts)}",
    )
