"""What a certificate says of a periodic orbit: a section around it, and a recorded lap of that with derivatives.

They prove nothing by themselves: the checker bounds how far solutions are from what is recorded, follows the jumps, and
derives how all of it depends on the start (docs/core.md section 8). Of automata without params.
"""

from __future__ import annotations

from collections.abc import Sequence
from fractions import Fraction
from typing import Any

from haverify.analyses.orbits.basin import Part
from haverify.analyses.orbits.laps import Cut, Frame
from haverify.analyses.orbits.linear import basis_of, inverse, middle, times
from haverify.analyses.orbits.newton import Fixed
from haverify.analyses.orbits.orbit import Passed, Plane
from haverify.analyses.orbits.passing import Crossed
from haverify.analyses.orbits.recording import Basin, Recording
from haverify.analyses.orbits.returns import Track, finely
from haverify.maths.digits import rational_text
from haverify.maths.interval import Fault, Interval
from haverify.model.expression import Expr, number
from haverify.text.record import record

Q = Fraction
Json = Any
Exact = list[list[Q]]
NEAR = Q(1, 400_000)  # of a variable's size: sections with a fixed point
ROUND = (10, 40, 100, 250, 600, 1000, 1600, 2500, 4000)  # parts of a variable's size: sections to which runs come
LARGEST = 0.95  # share of a section to which a lap contracts it
MOST_MOVING = 16  # variables, derivatives among them; the checker takes no more
LATE = (0.95, 0.8)  # of a lap: the plane that P names counts from then on


@record
class Recorded:
    """What the certificate says of an orbit, and the files of its records."""

    entry: dict[str, Json]
    files: dict[str, Json]


@record
class Sliced:
    """The plane `variable = value` of a mode, a state of the orbit there, the derivative of the return at it."""

    mode: str
    variable: str
    value: Q
    centre: dict[str, Q]
    slopes: Exact


def recorded_orbit(plane: Plane, fixed: Fixed, passed: Passed, areas: Sequence[Part], attracting: bool,
                   name: str) -> Recorded | None:  # fmt: skip
    """The certificate's part about an orbit that is proved; None where the checker would not follow."""
    if plane.model.names[:-1] != plane.names or len(plane.names) ** 2 > MOST_MOVING:
        return None
    if any(m.terminal for m in plane.model.automaton.modes):
        return None
    try:
        sliced = _own(plane, fixed) if not isinstance(passed.section, Crossed) else _pinned(plane, passed, areas)
        return None if sliced is None else _written(plane, sliced, areas if attracting else (), attracting, name)
    except Fault:
        return None


def _written(plane: Plane, sliced: Sliced, areas: Sequence[Part], attracting: bool,
             name: str) -> Recorded | None:  # fmt: skip
    found = _contraction(plane, sliced, areas) if attracting else _newton(plane, sliced)
    if found is None:
        return None
    recording, shown, basin = found
    files = {name: recording.lap()}
    if files[name] is None or (attracting and basin is None):
        return None
    entry: dict[str, Json] = {
        "mode": sliced.mode, "section": [sliced.variable, rational_text(sliced.value)], "flow": name, **shown,
        "centre": {v: rational_text(q) for v, q in sliced.centre.items()}, "basis": _texts(recording.frame.basis),
        "period": [rational_text(Q(t)) for t in recording.period()],
    }  # fmt: skip
    if basin is not None:
        entry |= {"basin": f"{name} basin", "shares": [rational_text(Q(x)) for x in basin.shares]}
        files[f"{name} basin"] = basin.into
    if basin is not None and basin.narrower is not None:
        entry["narrower"] = f"{name} narrower"
        files[f"{name} narrower"] = basin.narrower
    return Recorded(entry, files)


Shown = tuple[Recording, dict[str, Json], Basin | None]  # a lap, what is said of it, ways that lead to it


def _newton(plane: Plane, sliced: Sliced) -> Shown | None:
    """A section around the orbit, and a matrix near the inverse of what its derivative is less one."""
    sizes = [Q(plane.sizes[v]) for v in sliced.centre]
    apart = [[d * (i == j) for j in range(len(sizes))] for i, d in enumerate(sizes)]
    recording = _recording(plane, sliced, apart, NEAR)
    if recording is None:
        return None
    slopes = times(times([*map(list, recording.frame.back)], sliced.slopes), [*map(list, recording.frame.basis)])
    back = inverse([[x - (i == j) for j, x in enumerate(row)] for i, row in enumerate(slopes)])
    return None if back is None else (recording, {"back": _texts([[Q(float(q)) for q in row] for row in back])}, None)


def _contraction(plane: Plane, sliced: Sliced, areas: Sequence[Part]) -> Shown | None:
    """A section that a lap contracts, and by how much: the largest of a few; ways to it from all states with P."""
    sizes = [plane.sizes[v] for v in sliced.centre]
    turned = [[Q(x) for x in row] for row in basis_of([[float(q) for q in row] for row in sliced.slopes], sizes)]
    for part in ROUND:
        recording = _recording(plane, sliced, turned, Q(1, part))
        if recording is not None:
            factor = recording.contracts()
            if factor <= LARGEST:
                shown = {"factor": rational_text(Q(round((1 + factor) / 2 * 1000), 1000))}
                basin = recording.basin(areas)
                return None if basin is None else (recording, shown, basin)
    return None


def _recording(plane: Plane, sliced: Sliced, directions: Exact, share: Q) -> Recording | None:
    basis = tuple(tuple(Q(float(share * x)) for x in row) for row in directions)
    back = inverse([*map(list, basis)])
    if back is None:
        return None
    frame = Frame(sliced.centre, basis, tuple(map(tuple, back)), {sliced.variable: sliced.value})
    return Recording(plane, sliced.mode, frame, share)


def _own(plane: Plane, fixed: Fixed) -> Sliced:
    """The plane on which the orbit was found."""
    centre = {v: Q(x.midpoint) for v, x in fixed.box.items()}
    return Sliced(plane.mode, plane.variable, Q(plane.value), centre, _exact(fixed.lap.slopes))


def _pinned(plane: Plane, passed: Passed, areas: Sequence[Part]) -> Sliced | None:
    """The plane that P names; None where it names none."""
    mine = [a for a in areas if a.section == passed.section]
    flat = [(v, low) for a in mine for v, (low, high) in zip(plane.names, a.box, strict=True) if low == high]
    if len(flat) != 1:
        return None
    (variable, value), mode = flat[0], mine[0].mode
    columns = tuple(v for v in plane.names if v != variable)
    centre = {v: Q(passed.state[v].midpoint) for v in columns}
    quantity = Expr("-", (Expr("var", (variable,)), number(value)))
    start = {variable: Interval.between(value, value), **{v: Interval.at(float(q)) for v, q in centre.items()}}
    settings = finely({}, plane.orbit.period, plane.size)
    for share in LATE:
        cut = Cut(mode, mode, quantity, Q(share * plane.orbit.period), columns, dict(plane.borders()))
        lap = Track(plane.model, cut, plane.orbit.period, plane.size).lap(start, settings)
        if lap is not None:
            return Sliced(mode, variable, value, centre, _exact(lap.slopes))
    return None


def _exact(slopes: Sequence[Sequence[Interval]]) -> Exact:
    return [[Q(x) for x in row] for row in middle([list(row) for row in slopes])]


def _texts(rows: Sequence[Sequence[Q]]) -> list[list[str]]:
    return [[rational_text(q) for q in row] for row in rows]
