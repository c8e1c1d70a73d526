"""The seven phases of a cycle: four boundaries are events, three divide what lies between in the usual proportions.

Loading response ends with the opposite toe-off, terminal stance with the opposite heel strike, pre-swing with the own
toe-off; mid stance, initial and mid swing end at fixed shares of what lies between (J. Perry, J. M. Burnfield, Gait
Analysis, 2010: 10, 30, 50, 60, 73, 87 % of the cycle). Where an event is missing or out of order, these take its place.
"""

from __future__ import annotations

from collections.abc import Sequence
from fractions import Fraction

from haverify.diagnostics.diagnostic import Diagnostic
from haverify.recordings.cycles import Cycle

Q = Fraction

PHASES = ("LR", "MST", "TS", "PS", "IS", "MSW", "TSW")

USUAL = (Q(10, 100), Q(30, 100), Q(50, 100), Q(60, 100), Q(73, 100), Q(87, 100))
_ROOM = Q(4, 100)
_NAMES = {"off": "opposite toe-off", "strike": "opposite heel strike", "own": "toe-off"}
_AT = {"off": USUAL[0], "strike": USUAL[2], "own": USUAL[3]}
_NEAR = Q(17, 100)


def boundaries(cycles: Sequence[Cycle]) -> tuple[tuple[Q, ...], list[Diagnostic]]:
    """The six shares of the cycle at which phases hand over, means over the cycles; what is taken as usual is told."""
    means = {name: _mean([c.events[name] for c in cycles if name in c.events]) for name in _NAMES}
    unclear = [name for name, q in means.items() if q is None or abs(q - _AT[name]) > _NEAR]
    off, strike, own = (_AT[n] if n in unclear else means[n] or _AT[n] for n in _NAMES)
    if not (off >= _ROOM and off + 2 * _ROOM <= strike and strike + _ROOM <= own and own + 3 * _ROOM <= 1):
        unclear = list(_NAMES)
        off, strike, own = USUAL[0], USUAL[2], USUAL[3]
    found = []
    if unclear:
        shares = ", ".join(f"{_NAMES[n]} at {float(_AT[n]):.0%}" for n in unclear)
        message = f"{cycles[0].origin}: no clear {' and '.join(_NAMES[n] for n in unclear)}; taken as usual: {shares}"
        found.append(Diagnostic("HA226", message))
    middle = off + (strike - off) * (USUAL[1] - USUAL[0]) / (USUAL[2] - USUAL[0])
    swing = [own + (1 - own) * (q - USUAL[3]) / (1 - USUAL[3]) for q in USUAL[4:]]
    return (off, middle, strike, own, *swing), found


def _mean(values: Sequence[Q]) -> Q | None:
    return sum(values, Q(0)) / len(values) if values else None
