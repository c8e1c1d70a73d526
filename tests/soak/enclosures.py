"""What the analysis of a spec says of its runs, taken down while it decides the claims."""

from __future__ import annotations

from contextlib import suppress
from pathlib import Path

from tests.bench.flowpipes import Call, Enough, recorded
from tests.soak.campaign import Enclosure, Piece

from haverify.analyses.portfolio import decide_all
from haverify.run.examine import read

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
    """The enclosure that a flowpipe is."""
    pieces = [Piece(0, 0, (s.start[0], s.start[1] + s.length), s.states) for s in call.segments]
    last = call.segments[-1]
    until = call.horizon[0] if call.last else last.start[0] + last.length
    return Enclosure(call.box, 0, until, pieces, last=call.last)
