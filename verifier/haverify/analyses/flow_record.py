"""What a certificate records of flowpipes: polynomials with rounded coefficients, which a second checker can follow.

They prove nothing by themselves: the checker bounds how far solutions are from them (docs/core.md section 8).
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from fractions import Fraction
from math import ceil, comb, frexp, ldexp
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
MOST = 1500  # coefficients of a step
LOOKS = 16  # a recorded step is at most this part of the horizon
Names = tuple[str, ...]
MOST_MOVING = 16  # variables; the checker takes no more


def record_name(claim: str, goal: int) -> str:
    """The name of the file of a goal's recorded flow."""
    return f"flow {claim.replace('[', '(').replace(']', ')')} {goal}"


def flow_json(
    model: FlowModel, field: Listing, until: Q, boxes: Sequence[Box], pieces: Sequence[Box], settings: Settings
) -> Json | None:
    """A file of recorded flows from boxes, each split in halves down to given pieces; None where it would not do."""
    moving, varied = len(model.automaton.vars), set_of(model.names, pieces[0])
    monomials_to_come = comb(len(varied) + settings.degree, settings.degree)
    if moving > MOST_MOVING or moving * settings.order * monomials_to_come > MOST:
        return None
    longer = replace(settings, longest=float(until) / LOOKS)
    try:
        found = {piece: flow_record(field, sides(piece), Interval.at(until), longer) for piece in pieces}
    except Fault:
        return None
    names = model.names
    monomials = next(iter(found.values()))[0]
    bits = precision([step for _, steps in found.values() for step in steps])
    if bits is None:
        return None
    leaves = {piece: {"steps": list(_rows(s, moving, until, bits))} for piece, (_, s) in found.items()}
    starts = [tree(names, box, leaves) for box in boxes]
    return file_json(model.automaton.name, moving, bits, settings.order, varied, monomials, starts)


def file_json(
    automaton: str,
    moving: int,
    bits: int,
    order: int,
    varied: Sequence[str],
    monomials: list[list[int]],
    starts: list[Json],
) -> Json | None:
    """The file; None where its monomials are of other variables, or a step has more numbers than can be checked."""
    if any(len(m) != len(varied) for m in monomials) or moving * order * len(monomials) > MOST:
        return None
    return {
        "schema": "haverify.flow/1", "automaton": automaton, "bits": bits, "order": order, "set": list(varied),
        "monomials": monomials, "starts": starts,
    }  # fmt: skip


def sides(piece: Box) -> list[Pair]:
    """Enclosures of the sides of a box."""
    found = [Interval.between(low, high) for low, high in piece]
    return [(x.low, x.high) for x in found]


def set_of(names: Names, piece: Box) -> list[str]:
    """The set variables as the kernel sees them: what it takes for one number is none."""
    pairs = zip(names, sides(piece), strict=True)
    return [v for v, (low, high) in pairs if high - low > 1e-14 * max(abs(low), abs(high))]


def precision(steps: Sequence[Step]) -> int | None:
    """How many bits behind the point coefficients may have; None where their numbers would be too long."""
    most = max((abs(c) for _, x in steps for v in x for row in v for c in row), default=1.0)
    bits = min(PRECISION, int(DIGITS * 3.32) - 1 - frexp(most)[1])
    return bits if bits >= COARSEST else None


def tree(names: Names, box: Box, leaves: dict[Box, Json]) -> Json:
    """A start of a file: a box and its pieces."""
    ends = {v: [rational_text(q) for q in pair] for v, pair in zip(names, box, strict=True)}
    return {"box": ends, "pieces": _pieces(names, box, leaves)}


def _pieces(names: Names, box: Box, leaves: dict[Box, Json]) -> Json:
    if box in leaves:
        return leaves[box]
    v, low, high = halves(box)
    return {"split": names[v], "low": _pieces(names, low, leaves), "high": _pieces(names, high, leaves)}


def halves(box: Box) -> tuple[int, Box, Box]:
    """The box cut in two across its widest side, whose position comes first."""
    widths = [high - low for low, high in box]
    v = max(range(len(box)), key=lambda i: widths[i] / (1 + abs(box[i][0] + box[i][1]) / 2))
    low, high = box[v]
    middle = (low + high) / 2
    return v, (*box[:v], (low, middle), *box[v + 1 :]), (*box[:v], (middle, high), *box[v + 1 :])


def _rows(steps: Sequence[Step], moving: int, until: Q, bits: int) -> Iterator[Json]:
    """The steps, whose lengths add up to the horizon at least."""
    last, time, exact = ceil(until * 2**bits), 0, Q(0)
    for number, (length, series) in enumerate(steps):
        exact += Q(length)
        end = round(exact * 2**bits)
        end = max(end, last) if number == len(steps) - 1 else end
        if end > time:
            yield step_json(end - time, series[:moving], bits)
        time = end


def step_json(h: int, series: list[list[list[float]]], bits: int, pace: list[float] | None = None) -> Json:
    """A step of h units: for each variable the coefficients of t from the first power on, t being 1 at its end.

    With a pace, a polynomial of the set, that is how fast time passes: h times it is the step's length.
    """
    length = ldexp(h, -bits)
    paths = [_trimmed([polynomial(row, length**k, bits) for k, row in enumerate(x)][1:]) for x in series]
    return {"h": h if pace is None else polynomial(pace, length, bits), "x": paths}


def polynomial(row: list[float], factor: float, bits: int) -> list[int]:
    """Coefficients in units."""
    return _trimmed([round(ldexp(c * factor, bits)) for c in row])


def _trimmed(row: list[Any]) -> list[Any]:
    while row and not row[-1]:
        row.pop()
    return row
