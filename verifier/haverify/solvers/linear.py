"""Linear systems over the rationals, decided by Gauss and Fourier-Motzkin elimination, with a point or a core."""

from __future__ import annotations

from fractions import Fraction

from haverify.maths.polynomial import Polynomial
from haverify.text.record import record

MAX_ROWS = 400


@record
class Row:
    """`poly relation 0` with a linear polynomial; relation `<`, `<=` or `==`; `origins`: the rows it follows from."""

    poly: Polynomial
    relation: str
    origins: frozenset[int]


@record
class Infeasible:
    """No point satisfies the rows; those numbered in `core` alone have none."""

    core: frozenset[int]


@record
class TooLarge:
    """The elimination passed its limit."""


def solve(rows: list[Row]) -> dict[str, Fraction] | Infeasible | TooLarge:
    """A point that satisfies all rows, or why there is none. Exact; strict rows are kept strict."""
    eliminated: list[tuple[str, list[Row]]] = []
    while True:
        rows, failed = _without_constants(rows)
        if failed is not None:
            return Infeasible(failed)
        if not rows:
            return _point(eliminated)
        if len(rows) > MAX_ROWS:
            return TooLarge()
        if not eliminated and len({v for r in rows for v in r.poly.variables}) == 1:
            return _on_a_line(rows[0].poly.variables[0], rows)
        name, used, rows = _eliminate(rows)
        eliminated.append((name, used))


def _on_a_line(name: str, rows: list[Row]) -> dict[str, Fraction] | Infeasible:
    """The same for rows with one unknown, which are bounds on it: two that contradict each other, or a point."""
    bounds = [(_bound(name, r), r.relation == "<", r) for r in rows]
    lower = [b for b in bounds if _factor(name, b[2]) < 0 or b[2].relation == "=="]
    upper = [b for b in bounds if _factor(name, b[2]) > 0 or b[2].relation == "=="]
    if lower and upper:
        low, is_above, below = max(lower, key=lambda b: b[:2])
        high, is_below, above = min(upper, key=lambda b: (b[0], not b[1]))
        if low > high or (low == high and (is_above or is_below)):
            return Infeasible(below.origins | above.origins)
    return {name: _choice(name, rows)}


def _without_constants(rows: list[Row]) -> tuple[list[Row], frozenset[int] | None]:
    """Rows that mention an unknown, each once; or the origins of a constant row that is false."""
    kept: dict[object, Row] = {}
    for row in rows:
        value = row.poly.constant
        if value is None:
            normal = _normal(row)
            kept.setdefault((normal.poly, normal.relation), normal)
        elif not _holds(value, row.relation):
            return [], row.origins
    return list(kept.values()), None


def _normal(row: Row) -> Row:
    first = min(m for m in row.poly.whole if m)
    return Row(row.poly.scaled(1 / abs(row.poly.terms[first])), row.relation, row.origins)


def _holds(value: Fraction, relation: str) -> bool:
    return value < 0 or (value == 0 and relation != "<") if relation != "==" else value == 0


def _eliminate(rows: list[Row]) -> tuple[str, list[Row], list[Row]]:
    """An unknown, the rows that mention it, and the projection of the system without it."""
    equality = next((r for r in rows if r.relation == "=="), None)
    if equality is not None:
        name = equality.poly.variables[0]
        return name, [equality], [_replaced(r, name, equality) for r in rows if r is not equality]
    name = min(sorted({v for r in rows for v in r.poly.variables}), key=lambda n: _cost(n, rows))
    lower, upper, rest = _split(name, rows)
    return name, lower + upper, rest + [_combined(name, a, b) for a in lower for b in upper]


def _coefficient(name: str, row: Row) -> Fraction:
    return Fraction(_factor(name, row), row.poly.divisor)


def _factor(name: str, row: Row) -> int:
    """A positive multiple of the coefficient."""
    return row.poly.whole.get(((name, 1),), 0)


def _cost(name: str, rows: list[Row]) -> int:
    lower, upper, _ = _split(name, rows)
    return len(lower) * len(upper) - len(lower) - len(upper)


def _split(name: str, rows: list[Row]) -> tuple[list[Row], list[Row], list[Row]]:
    """Rows that bound `name` from below, from above, not at all."""
    lower = [r for r in rows if _factor(name, r) < 0]
    upper = [r for r in rows if _factor(name, r) > 0]
    return lower, upper, [r for r in rows if not _factor(name, r)]


def _replaced(row: Row, name: str, equality: Row) -> Row:
    c = _coefficient(name, row)
    if not c:
        return row
    poly = row.poly - equality.poly.scaled(c / _coefficient(name, equality))
    return Row(poly, row.relation, row.origins | equality.origins)


def _combined(name: str, lower: Row, upper: Row) -> Row:
    poly = lower.poly.scaled(_coefficient(name, upper)) - upper.poly.scaled(_coefficient(name, lower))
    relation = "<" if "<" in (lower.relation, upper.relation) else "<="
    return Row(poly, relation, lower.origins | upper.origins)


def _point(eliminated: list[tuple[str, list[Row]]]) -> dict[str, Fraction]:
    """Values from the last unknown eliminated back to the first; one that nothing constrains is 0."""
    point: dict[str, Fraction] = {}
    for name, rows in reversed(eliminated):
        for other in {v for r in rows for v in r.poly.variables} - {name}:
            point.setdefault(other, Fraction(0))
        point[name] = _choice(name, [Row(r.poly.fix(point), r.relation, r.origins) for r in rows])
    return point


def _choice(name: str, rows: list[Row]) -> Fraction:
    """A value between all bounds, a simple one where possible."""
    bounds = [(_bound(name, r), _factor(name, r), r.relation) for r in rows]
    for value, _, relation in bounds:
        if relation == "==":
            return value
    low = max((b for b in bounds if b[1] < 0), key=lambda b: (b[0], b[2] == "<"), default=None)
    high = min((b for b in bounds if b[1] > 0), key=lambda b: (b[0], b[2] != "<"), default=None)
    return _between(low and low[0], low is None or low[2] != "<", high and high[0], high is None or high[2] != "<")


def _between(low: Fraction | None, low_in: bool, high: Fraction | None, high_in: bool) -> Fraction:
    if _is_above(Fraction(0), low, low_in) and _is_below(Fraction(0), high, high_in):
        return Fraction(0)
    if low is not None and low_in:
        return low
    if high is not None and high_in:
        return high
    if low is not None and high is not None:
        return (low + high) / 2
    return low + 1 if low is not None else (high - 1 if high is not None else Fraction(0))


def _is_above(value: Fraction, low: Fraction | None, closed: bool) -> bool:
    return low is None or value > low or (closed and value == low)


def _is_below(value: Fraction, high: Fraction | None, closed: bool) -> bool:
    return high is None or value < high or (closed and value == high)


def _bound(name: str, row: Row) -> Fraction:
    """Where a row of one unknown is met with equality."""
    return Fraction(-row.poly.whole.get((), 0), _factor(name, row))
