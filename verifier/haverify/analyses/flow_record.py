"""What a certificate records of flowpipes: polynomials with rounded coefficients, which a second checker can follow.

They prove nothing by themselves: the checker bounds how far solutions are from them (docs/core.md section 8).
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from fractions import Fraction
from math import ceil, frexp, ldexp
from typing import Any

from haverify.analyses.flow_model import Box, FlowModel
from haverify.maths.digits import rational_text
from haverify.maths.interval import Fault, Interval
from haverify.solvers.kernel import Listing, Pair, Settings, Step, flow_record
from haverify.text.record import replace

Q = Fraction
Json = Any
DIGITS = 18  # of an integer in a certificate, at most
PRECISION, COARSEST = 36, 8


LOOKS = 16  # a recorded step is at most this part of the horizon


def record_name(claim: str, goal: int) -> str:
    """The name of the file of a goal's recorded flow."""
    return f"flow {claim.replace('[', '(').replace(']', ')')} {goal}"


def flow_json(
    model: FlowModel, field: Listing, until: Q, boxes: Sequence[Box], pieces: Sequence[Box], settings: Settings
) -> Json | None:
    """A file of recorded flows from boxes, each split in halves down to given pieces; None where it would not do."""
    longer = replace(settings, longest=float(until) / LOOKS)
    try:
        found = {piece: _steps(field, piece, until, longer) for piece in pieces}
    except Fault:
        return None
    monomials = next(iter(found.values()))[0]
    most = max((abs(c) for _, s in found.values() for _, x in s for v in x for row in v for c in row), default=1.0)
    bits = min(PRECISION, int(DIGITS * 3.32) - 1 - frexp(most)[1])
    wide = [v for v, (low, high) in zip(model.names, pieces[0], strict=True) if _is_wide(low, high)]
    if bits < COARSEST or any(len(m) != len(wide) for m in monomials):
        return None
    moving = len(model.automaton.vars)
    leaves = {piece: {"steps": list(_rows(s, moving, until, bits))} for piece, (_, s) in found.items()}
    return {
        "schema": "haverify.flow/1", "automaton": model.automaton.name, "bits": bits, "order": settings.order,
        "set": wide, "monomials": monomials,
        "starts": [{"box": _ends(model, box), "pieces": _tree(model, box, leaves)} for box in boxes],
    }  # fmt: skip


def _steps(field: Listing, piece: Box, until: Q, settings: Settings) -> tuple[list[list[int]], list[Step]]:
    pairs: list[Pair] = []
    for low, high in piece:
        x = Interval.between(low, high)
        pairs.append((x.low, x.high))
    return flow_record(field, pairs, Interval.at(until), settings)


def _is_wide(low: Q, high: Q) -> bool:
    """As the kernel sees it: what it takes for one number is no set variable."""
    x = Interval.between(low, high)
    return x.high - x.low > 1e-14 * max(abs(x.low), abs(x.high))


def _ends(model: FlowModel, box: Box) -> Json:
    return {v: [rational_text(q) for q in ends] for v, ends in zip(model.names, box, strict=True)}


def _tree(model: FlowModel, box: Box, leaves: dict[Box, Json]) -> Json:
    if box in leaves:
        return leaves[box]
    v, low, high = halves(box)
    return {"split": model.names[v], "low": _tree(model, low, leaves), "high": _tree(model, high, leaves)}


def halves(box: Box) -> tuple[int, Box, Box]:
    """The box cut in two across its widest side, whose position comes first."""
    widths = [high - low for low, high in box]
    v = max(range(len(box)), key=lambda i: widths[i] / (1 + abs(box[i][0] + box[i][1]) / 2))
    low, high = box[v]
    middle = (low + high) / 2
    return v, (*box[:v], (low, middle), *box[v + 1 :]), (*box[:v], (middle, high), *box[v + 1 :])


def _rows(steps: Sequence[Step], moving: int, until: Q, bits: int) -> Iterator[Json]:
    """Each step: its length, and coefficients of t from the first power on, t being 1 at its end."""
    last, time, exact = ceil(until * 2**bits), 0, Q(0)
    for number, (length, series) in enumerate(steps):
        exact += Q(length)
        end = round(exact * 2**bits)
        end = max(end, last) if number == len(steps) - 1 else end
        h = end - time
        if h > 0:
            yield {"h": h, "x": [_polynomial(x, ldexp(h, -bits), bits) for x in series[:moving]]}
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
