"""Where a flow leaves its domain: the instant as a polynomial of the set, the states there, how far both are off.

In the last step of a stretch some quantity g of the domain (`g <= 0` or `g >= 0`) moves one way, at least at some
speed, from an instant on. So it is 0 at one instant at most, a run is out of the domain afterwards, and where g of a
state that is known well is small, that instant is near. Only there are jumps possible.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import NamedTuple

from hacheck.elementary import inverse
from hacheck.enclosures import ZERO, Model, Space, add, bounds, middle, norm, slope, widened
from hacheck.tapes import Tape, Truth
from hacheck.tubes import Field

States = dict[str, Model]
LATEST = (0, 1, 2, 3, 4, 5)  # a quantity moves one way from 1 - 2^-k of the step on
ROUNDS, PARTS = 8, 8


class Crossing(NamedTuple):
    """States where a quantity, at a place of the tape, is 0; `sign` times it rises from the instant `since` on."""

    place: int
    sign: int
    states: States
    since: int


def borders(domain: Truth) -> Iterator[tuple[int, int]]:
    """Quantities at whose zero the domain ends, with the sign under which they rise there."""
    members = domain[1:] if not isinstance(domain, bool) and domain[0] == "and" else (domain,)
    for f in members:
        if not isinstance(f, bool) and f[0] in ("<=", ">="):
            yield f[1], 1 if f[0] == "<=" else -1


def crossed(field: Field, place: int, sign: int, states: States, h: Model) -> Crossing | None:
    """The states of a step where a quantity is 0, if all have left at its end; None where that is not known."""
    space, tape = field.fine, field.tape
    if sign_at(tape, place, during(space, states, space.one, 0), space) != sign:
        return None
    moves = rate(field, place)
    if moves is None:
        return None
    for k in LATEST:
        since = space.one - (space.one >> k)
        late = during(space, states, since, space.one - since)
        found = _least(tape, moves, sign, late, space)
        if found > 0:
            return _solved(field, place, sign, states, late, since, found * bounds(h)[0] >> space.bits, h)
    return None


def during(space: Space, states: Mapping[str, Model], start: int, length: int) -> States:
    """The states of a part of a step, again over [0, 1]."""
    return {v: space.moved(m, -1, start, length) for v, m in states.items()}


def sign_at(tape: Tape, place: int, states: States, space: Space) -> int:
    """The sign that a quantity has for all states, or 0."""
    low, high = bounds(tape.values([place], states, space)[place])
    return 1 if low > 0 else -1 if high < 0 else 0


def rate(field: Field, place: int) -> int | None:
    """The place of a quantity's derivative along the flow; None where it does not move."""
    tape, rates = field.tape, [*field.rates, field.tape.put("number", 1)]
    terms = [(tape.slope(place, v), moved) for v, moved in zip([*field.names, "time"], rates, strict=True)]
    found = [tape.times(s, moved) for s, moved in terms if s is not None]
    if not found:
        return None
    out = found[0]
    for p in found[1:]:
        out = tape.put("+", out, p)
    return out


def _least(tape: Tape, moves: int, sign: int, states: States, space: Space) -> int:
    """A lower bound of how fast a quantity rises, part by part."""
    share = space.one // PARTS
    found = (during(space, states, n * share, share) for n in range(PARTS))
    ends = [bounds(tape.values([moves], part, space)[moves]) for part in found]
    return min(low if sign > 0 else -high for low, high in ends)


def _solved(
    field: Field, place: int, sign: int, states: States, late: States, since: int, speed: int, h: Model
) -> Crossing | None:
    """With g of the states at a guessed instant t(z), and its least speed, the true instant is within `g / speed`."""
    space, tape = field.fine, field.tape
    exact = {v: Model(m.parts, 0) for v, m in states.items()}
    instant = _guess(tape.values([place], exact, space)[place], space)
    low, high = bounds(instant)
    if speed <= 0 or not since <= low <= high <= space.one:
        return None
    near = {v: space.replaced(m, -1, instant) for v, m in states.items()}
    off = norm(tape.values([place], near, space)[place]) * space.one // speed + 1
    values = tape.values(field.rates, late, space)
    fast = {v: norm(values[r]) for v, r in zip(field.names, field.rates, strict=True)} | {"time": space.one}
    moved = {v: space.up(space.up(norm(h) * s) * off) + 1 for v, s in fast.items()}
    found = {v: widened(m, moved.get(v, 0)) for v, m in near.items()}
    return Crossing(place, sign, {**found, **_settled(tape, place, found, space)}, since)


def _settled(tape: Tape, place: int, states: States, space: Space) -> States:
    """What is known of a variable where a quantity is 0: of v where it is `v + w`, or v alone."""
    op, *args = tape.ops[place]
    if op == "name":
        return {args[0]: ZERO}
    for a, rest in (args, args[::-1]) if op == "+" else ():
        if tape.ops[a][0] == "name" and tape.ops[a][1] in tape.scope.types and a not in tape.used((rest,)):
            other = tape.values([rest], states, space)[rest]
            if other.radius <= states[tape.ops[a][1]].radius:
                return {tape.ops[a][1]: add(ZERO, other, -1)}
    return {}


def _guess(g: Model, space: Space) -> Model:
    """A polynomial t(z) with g(t(z), z) near 0: by halving in the middle of the set, then by Newton's iteration."""
    low, high = 0, space.one
    line = Model({i: {0: terms.get(0, 0)} for i, terms in g.parts.items()}, 0)
    rising = middle(space.moved(line, -1, high, 0)) > 0
    for _ in range(space.bits):
        half = (low + high) >> 1
        above = middle(space.moved(line, -1, half, 0)) > 0
        low, high = (low, half) if above is rising else (half, high)
    found, flat = space.constant(low), Model(g.parts, 0)
    for _ in range(ROUNDS):
        value, speed = space.replaced(flat, -1, found), space.replaced(slope(flat), -1, found)
        change = space.mul(value, inverse(space, speed))
        found = Model(add(found, change, -1).parts, 0)
        if norm(change) < space.one >> space.bits // 2:
            break
    return found if found.parts else ZERO
