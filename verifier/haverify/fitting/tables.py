"""The data files of a fitted walk: phases, polynomials, samples; exact decimals throughout."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from fractions import Fraction

from haverify.fitting.curve import Curve
from haverify.fitting.knots import Knots
from haverify.maths.exact import decimal_text
from haverify.recordings.cycles import Cycle
from haverify.recordings.phases import PHASES
from haverify.recordings.recording import JOINTS

Q = Fraction

PICKS = 3
"""Samples of each phase that a spec states; all samples count for the residual."""


def phases(knots: Knots) -> str:
    """When each phase begins and how long it lasts."""
    rows = zip(PHASES, knots.at, knots.lengths, strict=False)
    return _csv("phase,begin,length", ([name, text(a), text(b)] for name, a, b in rows))


def polynomials(curve: Curve) -> str:
    """The coefficients of a joint, one row per phase."""
    labels = "phase," + ",".join(f"c{i}" for i in range(curve.degree + 1))
    return _csv(labels, ([name, *map(text, row)] for name, row in zip(PHASES, curve.rows, strict=True)))


def picked(c: Cycle, knots: Knots) -> list[tuple[str, int, Q, dict[str, Q]]]:
    """Samples of a cycle that lie best in each phase, `PICKS` of them: phase, number, instant, angles.

    Only samples with all six angles count. An instant is rounded to a millionth of a second; nothing else is.
    """
    whole = [(share * knots.period, {j: c.angles[j][i] for j in JOINTS}) for i, share in enumerate(c.at)]
    whole = [(t, row) for t, row in whole if all(v is not None for v in row.values())]
    near = [float(t) for t, _ in whole]
    found = []
    for k, name in enumerate(PHASES):
        begin, length = knots.at[k], knots.lengths[k]
        for i in range(PICKS):
            aim = float(begin + length * Q(2 * i + 1, 2 * PICKS))
            t, row = whole[min(range(len(near)), key=lambda n: abs(near[n] - aim))]
            inside = min(max(Q(round(t * 1_000_000), 1_000_000), begin), begin + length)
            if abs(inside - t) <= Q(1, 1_000_000):
                found.append((name, i, inside, {j: v for j, v in row.items() if v is not None}))
    return found


def samples(rows: Sequence[tuple[str, int, Q, dict[str, Q]]]) -> str:
    """Recorded samples by phase and number."""
    labels = "phase,pick,x," + ",".join(JOINTS)
    return _csv(labels, ([name, str(i), text(t), *(text(row[j]) for j in JOINTS)] for name, i, t, row in rows))


def text(q: Q) -> str:
    """A finite decimal; of another number the nearest with nine decimals."""
    exact = decimal_text(q)
    return exact if exact is not None else decimal_text(Q(round(q * 10**9), 10**9)) or "0"


def _csv(labels: str, rows: Iterable[Sequence[str]]) -> str:
    return "\n".join([labels, *(",".join(row) for row in rows)]) + "\n"
