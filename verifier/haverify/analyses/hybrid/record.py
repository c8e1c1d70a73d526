"""What a certificate records of flowpipes: polynomials with rounded coefficients, which a second checker can follow.

They prove nothing by themselves: the checker bounds how far solutions are from them, and solves crossings again
(docs/core.md section 8).
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from fractions import Fraction
from math import ceil, comb, frexp, ldexp
from typing import Any

from haverify.analyses.hybrid.model import HybridModel, Start
from haverify.analyses.hybrid.question import Piece, Question, follow_record, recorded_settings, sides
from haverify.analyses.hybrid.starts import Box, halves
from haverify.maths.digits import rational_text
from haverify.maths.interval import Fault
from haverify.solvers.kernel import RecordedStretch, Step, units

Q = Fraction
Json = Any
Names = tuple[str, ...]
DIGITS = 18  # of an integer in a certificate, at most
PRECISION, COARSEST = 36, 8
MOST = 1500  # coefficients of a step
MOST_MOVING = 16  # variables; the checker takes no more
ENDS = ("horizon", "jumped", "left")


def record_name(claim: str, goal: int) -> str:
    """The name of the file of a goal's recorded flow."""
    return f"flow {claim.replace('[', '(').replace(']', ')')} {goal}"


def proof_record(question: Question, proof: Sequence[Piece]) -> Json | None:
    """A file of recorded flows and jumps from all starts, split down to the pieces; None where it would not do.

    Stretches have to come to the horizon or to jumps at the border of their domain; sets are not cut on their way.
    """
    model = question.model
    if len(model.starts) != len(model.automaton.init):
        return None
    return _file(question, [(s.box, [p for p in proof if p.start is s]) for s in model.starts], question.asked.last)


def run_record(question: Question, start: Start, box: Box, until: Q) -> Json | None:
    """A file of the recorded flow from one start (or one in a box) up to an instant; None where it would not do."""
    return _file(question, [(box, [Piece(start, box)])], until)


def _file(question: Question, given: Sequence[tuple[Box, Sequence[Piece]]], until: Q) -> Json | None:
    """A file for all claims whose proofs rest on the same pieces."""
    pieces = [p for _, some in given for p in some]
    same = tuple((p.start.mode, p.box, recorded_settings(question, p, until)) for p in pieces)
    asked = question.asked
    key = question.model.automaton.name, question.model.names, until, asked.jumps, asked.last_jump, same
    files = question.trees.files
    if key not in files:
        files[key] = _new_file(question, given, until)
    return files[key]


def _new_file(question: Question, given: Sequence[tuple[Box, Sequence[Piece]]], until: Q) -> Json | None:
    model, moving = question.model, len(question.model.automaton.vars)
    first = next(piece for _, pieces in given for piece in pieces)
    settings, varied = recorded_settings(question, first, until), set_of(model.names, first.box)
    if moving > MOST_MOVING or moving * settings.order * comb(len(varied) + settings.degree, settings.degree) > MOST:
        return None
    try:
        grown = [{p.box: follow_record(question, p, until) for p in pieces} for _, pieces in given]
    except Fault:
        return None
    rows = [row for trees in grown for found in trees.values() for row in found]
    steps = [step for row in rows for step in row.steps]
    monomials = steps[0][0] if steps else []
    if any(m != monomials for m, _ in steps) or not all(row.steps and row.end in ENDS for row in rows):
        return None
    bits = precision([step for _, step in steps])
    if bits is None or any(len(m) != len(varied) for m in monomials):
        return None
    last = ceil(until * 2**bits)
    order = max(len(row) - 1 for _, (_, x) in steps for row in x)  # stiff parts have steps of their own
    try:
        starts = [_start(model, box, trees, bits, last) for (box, _), trees in zip(given, grown, strict=True)]
    except Fault:
        return None
    return {
        "schema": "haverify.flow/1", "automaton": model.automaton.name, "bits": bits,
        "order": order, "set": varied, "monomials": monomials, "starts": starts,
    }  # fmt: skip


def set_of(names: Names, piece: Box) -> list[str]:
    """The set variables as the kernel sees them: what it takes for one number is none."""
    pairs = zip(names, sides(piece), strict=True)
    return [v for v, (low, high) in pairs if high - low > max(1e-14 * max(abs(low), abs(high)), 1e-305)]


def precision(steps: Sequence[Step], finest: int = PRECISION) -> int | None:
    """How many bits behind the point coefficients may have; None where their numbers would be too long.

    What counts is how large they are in the record, where a step is the unit of time: those of a fast flow grow with
    the power of time as its steps shrink.
    """
    sizes = ((max(max(row), -min(row)), h, k) for h, x in steps for v in x for k, row in enumerate(v) if row)
    most = max((size * h**k for size, h, k in sizes), default=1.0)
    bits = min(finest, int(DIGITS * 3.32) - 1 - frexp(most)[1])
    return bits if bits >= COARSEST else None


def _start(model: HybridModel, box: Box, trees: Mapping[Box, Sequence[RecordedStretch]], bits: int, last: int) -> Json:
    """A start of a file: a box and its pieces."""
    ends = {v: [rational_text(q) for q in pair] for v, pair in zip(model.names, box, strict=True)}
    leaves = {piece: _stretch(model, rows, 0, bits, last) for piece, rows in trees.items()}
    return {"box": ends, "pieces": _pieces(model.names, box, leaves)}


def _pieces(names: Names, box: Box, leaves: Mapping[Box, Json]) -> Json:
    if box in leaves:
        return leaves[box]
    v, low, high = halves(box)
    return {"split": names[v], "low": _pieces(names, low, leaves), "high": _pieces(names, high, leaves)}


def _stretch(model: HybridModel, rows: Sequence[RecordedStretch], number: int, bits: int, last: int) -> Json:
    """A stretch with its steps; where it ends at the border of its domain, its jumps and what follows each."""
    row, moving = rows[number], len(model.automaton.vars)
    steps, time = [], 0
    for k, (_, (h, series)) in enumerate(row.steps):
        if time >= last:
            break  # a little more than the horizon was followed
        pace = series[len(model.names)][0] if len(series) > len(model.names) else None
        length = max(1, round(ldexp(h, bits)))
        if not model.jumps and k == len(row.steps) - 1:
            length = max(length, last - time)  # rounded lengths add up to the horizon
        steps.append(step_json(length, series[:moving], bits, pace))
        time += 0 if pace is not None else length
    if row.end == "horizon":
        return {"steps": steps}
    jumps = []
    for i, after in enumerate(rows):
        if after.parent == number and after.edge is not None:
            begun = [polynomial(x[0], 1.0, bits) for x in after.steps[0][1][1][:moving]]
            edge = model.edges[row.mode][after.edge]
            jumps.append({"edge": edge, "x": begun, **_stretch(model, rows, i, bits, last)})
    return {"steps": steps, "jumps": jumps}


def step_json(h: int, series: list[list[list[float]]], bits: int, pace: list[float] | None = None) -> Json:
    """A step of h units: for each variable the coefficients of t from the first power on, t being 1 at its end.

    With a pace, a polynomial of the set, that is how fast time passes: h times it is the step's length.
    """
    length = ldexp(h, -bits)
    return {"h": h if pace is None else polynomial(pace, length, bits), "x": units(series, length, bits)}


def polynomial(row: list[float], factor: float, bits: int) -> list[int]:
    """Coefficients in units."""
    found = [round(ldexp(c * factor, bits)) for c in row]
    while found and not found[-1]:
        found.pop()
    return found
