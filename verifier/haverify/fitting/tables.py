"""The data files of a fitted walk: phases, polynomials, samples; exact decimals throughout."""

from __future__ import annotations

from collections.abc import Collection, Iterable, Sequence
from fractions import Fraction

from haverify.fitting.curve import Curve
from haverify.fitting.knots import Knots
from haverify.maths.exact import decimal_text
from haverify.recordings.cycles import Cycle
from haverify.recordings.phases import PHASES
from haverify.recordings.recording import JOINTS

Q = Fraction
Place = tuple[int, int]  # a cycle and a sample of it

MOST = 32
"""Samples of a phase that a spec states at most; all samples count for the residual."""

_SHARES = 10**8


def phases(knots: Knots) -> str:
    """When each phase begins and how long it lasts."""
    rows = zip(PHASES, knots.at, knots.lengths, strict=False)
    return _csv("phase,begin,length", ([name, text(a), text(b)] for name, a, b in rows))


def polynomials(curve: Curve) -> str:
    """The coefficients of a joint, one row per phase."""
    labels = "phase," + ",".join(f"c{i}" for i in range(curve.degree + 1))
    return _csv(labels, ([name, *map(text, row)] for name, row in zip(PHASES, curve.rows, strict=True)))


Row = tuple[str, int, Q, dict[str, Q]]


def picked(cycles: Sequence[Cycle], knots: Knots, first: Collection[Place] = ()) -> list[Row]:
    """The samples of some cycles with all six angles: phase, number, local time, angles; as many in each phase.

    Of more than `MOST` in a phase the `first` ones (cycle, index) are taken and others as even as can be; of fewer than
    in other phases the last one is repeated. Local time is rounded to a hundred-millionth; nothing else is.
    """
    phases: list[list[tuple[Place, Q, dict[str, Q]]]] = [[] for _ in PHASES]
    for n, c in enumerate(cycles):
        for i, share in enumerate(c.at):
            row = {j: v for j in JOINTS if (v := c.angles[j][i]) is not None}
            t = share * knots.period
            k = knots.phase(t)
            if len(row) == len(JOINTS):
                u = Q(round((t - knots.at[k]) / knots.lengths[k] * _SHARES), _SHARES)
                phases[k].append(((n, i), u, row))
    if not all(phases):
        return []
    kept = [_thinned(rows, first) for rows in phases]
    most = max(map(len, kept))
    return [
        (name, i, *rows[min(i, len(rows) - 1)][1:])
        for name, rows in zip(PHASES, kept, strict=True)
        for i in range(most)
    ]


def _thinned(
    rows: list[tuple[Place, Q, dict[str, Q]]], first: Collection[Place]
) -> list[tuple[Place, Q, dict[str, Q]]]:
    """At most `MOST` rows, in order."""
    if len(rows) > MOST:
        chosen = [r for r in rows if r[0] in first][:MOST]
        others = [r for r in rows if r[0] not in first]
        room = MOST - len(chosen)
        chosen += [others[(2 * k + 1) * len(others) // (2 * room)] for k in range(room)]
        rows = chosen
    return sorted(rows, key=lambda r: (r[1], r[0]))


def samples(rows: Sequence[Row]) -> str:
    """Recorded samples by phase and number."""
    labels = "phase,pick,u," + ",".join(JOINTS)
    return _csv(labels, ([name, str(i), text(t), *(text(row[j]) for j in JOINTS)] for name, i, t, row in rows))


def text(q: Q) -> str:
    """A finite decimal; of another number the nearest with nine decimals."""
    exact = decimal_text(q)
    return exact if exact is not None else decimal_text(Q(round(q * 10**9), 10**9)) or "0"


def _csv(labels: str, rows: Iterable[Sequence[str]]) -> str:
    return "\n".join([labels, *(",".join(row) for row in rows)]) + "\n"
