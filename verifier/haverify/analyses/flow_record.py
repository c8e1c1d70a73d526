"""What a certificate records of flowpipes: polynomials with rounded coefficients, which a second checker can follow.

They prove nothing by themselves: the checker bounds how far solutions are from them (docs/core.md section 8).
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from fractions import Fraction
from math import ceil, frexp, ldexp
from typing import Any

from haverify.maths.digits import rational_text
from haverify.maths.interval import Fault, Interval
from haverify.solvers.kernel import Listing, Pair, Settings, Step, flow_record
from haverify.text.record import record

Q = Fraction
Json = Any
Box = tuple[tuple[Q, Q], ...]
DIGITS = 18  # of an integer in a certificate, at most
PRECISION, COARSEST = 36, 8


@record
class Followed:
    """A flow to be recorded: the tape of its field, the names of its state, how many of them move, until when."""

    field: Listing
    names: tuple[str, ...]
    moving: int
    horizon: Q
    settings: Settings


def record_name(claim: str, goal: int) -> str:
    """The name of the file of a goal's recorded flow."""
    return f"flow {claim.replace('[', '(').replace(']', ')')} {goal}"


def flow_json(automaton: str, flow: Followed, boxes: Sequence[Box], pieces: Sequence[Box]) -> Json | None:
    """A file of recorded flows from boxes, each split in halves down to given pieces; None where it would not do."""
    try:
        found = {piece: _steps(flow, piece) for piece in pieces}
    except Fault:
        return None
    monomials = next(iter(found.values()))[0]
    most = max((abs(c) for _, s in found.values() for _, x in s for v in x for row in v for c in row), default=1.0)
    bits = min(PRECISION, int(DIGITS * 3.32) - 1 - frexp(most)[1])
    wide = [v for v, (low, high) in zip(flow.names, pieces[0], strict=True) if _is_wide(low, high)]
    if bits < COARSEST or any(len(m) != len(wide) for m in monomials):
        return None
    leaves = {piece: {"steps": list(_rows(flow, s, bits))} for piece, (_, s) in found.items()}
    return {
        "schema": "haverify.flow/1", "automaton": automaton, "bits": bits, "order": flow.settings.order,
        "set": wide, "monomials": monomials,
        "starts": [{"box": _ends(flow, box), "pieces": _tree(flow, box, leaves)} for box in boxes],
    }  # fmt: skip


def _steps(flow: Followed, piece: Box) -> tuple[list[list[int]], list[Step]]:
    pairs: list[Pair] = []
    for low, high in piece:
        x = Interval.between(low, high)
        pairs.append((x.low, x.high))
    return flow_record(flow.field, pairs, Interval.at(flow.horizon), flow.settings)


def _is_wide(low: Q, high: Q) -> bool:
    """As the kernel sees it: what it takes for one number is no set variable."""
    x = Interval.between(low, high)
    return x.high - x.low > 1e-14 * max(abs(x.low), abs(x.high))


def _ends(flow: Followed, box: Box) -> Json:
    return {v: [rational_text(q) for q in ends] for v, ends in zip(flow.names, box, strict=True)}


def _tree(flow: Followed, box: Box, leaves: dict[Box, Json]) -> Json:
    if box in leaves:
        return leaves[box]
    v, low, high = halves(box)
    return {"split": flow.names[v], "low": _tree(flow, low, leaves), "high": _tree(flow, high, leaves)}


def halves(box: Box) -> tuple[int, Box, Box]:
    """The box cut in two across its widest side, whose position comes first."""
    widths = [high - low for low, high in box]
    v = max(range(len(box)), key=lambda i: widths[i] / (1 + abs(box[i][0] + box[i][1]) / 2))
    low, high = box[v]
    middle = (low + high) / 2
    return v, (*box[:v], (low, middle), *box[v + 1 :]), (*box[:v], (middle, high), *box[v + 1 :])


def _rows(flow: Followed, steps: Sequence[Step], bits: int) -> Iterator[Json]:
    """Each step: its length, and coefficients of t from the first power on, t being 1 at its end."""
    until, time, exact = ceil(flow.horizon * 2**bits), 0, Q(0)
    for number, (length, series) in enumerate(steps):
        exact += Q(length)
        end = round(exact * 2**bits)
        end = max(end, until) if number == len(steps) - 1 else end
        h = end - time
        if h > 0:
            yield {"h": h, "x": [_polynomial(x, ldexp(h, -bits), bits) for x in series[: flow.moving]]}
        time = end


def _polynomial(series: list[list[float]], h: float, bits: int) -> list[list[int]]:
    found = [_trimmed([round(ldexp(c * h**k, bits)) for c in row]) for k, row in enumerate(series) if k]
    while found and not found[-1]:
        found.pop()
    return found


def _trimmed(row: list[int]) -> list[int]:
    while row and not row[-1]:
        row.pop()
    return row
