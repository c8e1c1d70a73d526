"""What the analysis of a spec says of its runs, taken down while it decides the claims."""

from __future__ import annotations

from contextlib import suppress
from pathlib import Path

from tests.bench.flowpipes import Call, Enough, Stretch, recorded
from tests.soak.campaign import Crossing, Enclosure, Piece

from haverify.analyses.portfolio import decide_all
from haverify.run.examine import read

SETTLED = ("horizon", "jumped", "left", "cut")
FOLDER = Path(__file__).parents[1] / "peers" / "nln"


def enclosures(name: str, most: int, claims: int) -> list[Enclosure]:
    """The enclosures that decide the first claims of a spec of tests/peers/nln: of wide boxes, `most` for each claim.

    They are true whether or not they are what a claim is decided by in the end.
    """
    spec, _, _ = read(str(FOLDER / f"{name}.ha"))
    assert spec is not None
    found: list[Enclosure] = []
    for claim in spec.claims[:claims]:
        with recorded(most) as calls, suppress(Enough):
            decide_all(spec, [claim.name])
        found += [of_call(c) for c in calls if not c.is_point and c.segments]
    return found


def of_call(call: Call) -> Enclosure:
    """Up to the horizon, or to the first instant at which a stretch was not followed to its end."""
    pieces = [
        Piece(s.mode, s.jumps, (g.start[0], g.start[0] + g.length), g.states) for s in call.tree for g in s.segments
    ]
    crossings = []
    for s in call.tree:
        if s.jump is not None and s.parent is not None and s.edge is not None:
            crossings.append(Crossing((call.tree[s.parent].mode, s.edge), s.jumps, *s.jump))
    until = min([call.horizon[0], *(_given_up(s) for s in call.tree if s.end not in SETTLED)])
    return Enclosure(call.box, call.mode, until, pieces, crossings, last=call.last)


def _given_up(s: Stretch) -> float:
    """No run is in the stretch after this instant without being in one of its pieces."""
    if s.segments:
        return s.segments[-1].start[0] + s.segments[-1].length
    return s.jump[0][0] if s.jump is not None else 0.0
