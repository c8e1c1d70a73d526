"""How far the solutions of `x' = f(x)` are from given polynomials: one step, without integrating again.

With `x = P(t, z) + e`, t in [0, 1] over a step of length h(z), and `P' = h f(P) + d`: `e' = h J e - d`, where J is a
mean of Df between P and x. The error is written `e = U(t, z) w` with any invertible U, here near a solution of
`U' = h J U`; so `w' = U^-1 ((h J U - U') w - d)`. If the w found from `|w| <= guess` stay inside the guess, they never
leave it: there is no first instant at which they would.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, NamedTuple

from hacheck.enclosures import MAX_BITS, ZERO, Model, Space, add, at_end, lowered, norm, slope, widened
from hacheck.matrices import (
    Block,
    Matrix,
    added,
    applied,
    inverse,
    nothing,
    orthogonal,
    product,
    size,
    term,
    total,
    unit,
)
from hacheck.rational import Beyond
from hacheck.scope import Scope
from hacheck.tapes import Tape

ATTEMPTS, ROUNDS, LOSS, TURNED = 6, 30, 6, 4


class Front(NamedTuple):
    """A set: `centre(z) + frame(z) w` for z in the set variables' range and |w| <= radii, one w for each variable."""

    centre: dict[str, Model]
    frame: Block
    radii: list[int]


class Turn(NamedTuple):
    """What becomes of small errors in a step.

    `end` is U(1, z), `size` bounds U, `back` some V near its inverse, `apart` `1 - V U`, `rest` `h J U - U'`.
    Where it is rough, half a step is better.
    """

    end: Block
    back: Matrix
    size: Matrix
    apart: Matrix
    rest: Matrix
    is_rough: bool


class Field:
    """The flow of a mode and its derivatives, in a fine space for the field and a coarse one for errors."""

    def __init__(self, scope: Scope, mode: str, fine: Space, coarse: Space) -> None:
        scope.left(mode)
        self.tape, self.names, self.fine, self.coarse = Tape(scope, mode), list(scope.types), fine, coarse
        lines: dict[str, Any] = {line["var"]: line for line in scope.modes[mode]["flow"]}
        if not all(v in lines and "rate" in lines[v] for v in self.names):
            raise Beyond("flows that are inclusions")
        self.rates = [self.tape.value(lines[v]["rate"]) for v in self.names]
        self.slopes = [[self.tape.slope(r, v) for v in self.names] for r in self.rates]

    def front(self, centre: dict[str, Model], radii: list[int]) -> Front:
        """A set whose errors are a box."""
        return Front(centre, unit(len(radii), self.coarse.bits), radii)

    def step(self, start: Front, env: Mapping[str, Model], h: Model) -> tuple[list[int], Front]:
        """Bounds of each variable's error along the polynomials in env, in a step from `start`; the set at its end."""
        bits, defects, back = self.coarse.bits, self._defects(env, h), inverse(start.frame, self.coarse.bits)
        first = applied(size(back), defects, bits)
        guess = [r + (r >> 3) + 2 * a + 4 for r, a in zip(start.radii, first, strict=True)]
        room = [2 * x for x in applied(size(start.frame), guess, bits)]
        for _ in range(ATTEMPTS):
            if max(room).bit_length() > bits + MAX_BITS:
                break
            turn = self._turn(start.frame, back, self._slopes(env, room, h))
            if turn.is_rough:
                raise Beyond("the errors of a recorded flow turn too much in a step")
            tube = applied(turn.size, guess, bits)
            if any(t > r for t, r in zip(tube, room, strict=True)):
                room = [2 * t for t in tube]
                continue
            pull = [r + d for r, d in zip(applied(turn.rest, guess, bits), defects, strict=True)]
            grown = self._fixed(turn.apart, applied(turn.back, pull, bits))
            found = [r + s for r, s in zip(start.radii, grown, strict=True)]
            if all(f < g for f, g in zip(found, guess, strict=True)):
                ends = {v: at_end(env[v]) for v in self.names}
                return applied(turn.size, found, bits), self._front(ends, turn.end, found)
            guess = [max(g, 2 * f) for f, g in zip(found, guess, strict=True)]
            room = [max(r, 2 * t) for r, t in zip(room, applied(turn.size, guess, bits), strict=True)]
        raise Beyond("no bound of the errors of a recorded flow is found")

    def _defects(self, env: Mapping[str, Model], h: Model) -> list[int]:
        values = self.tape.values(self.rates, env, self.fine)
        return [norm(add(slope(env[v]), self.fine.mul(values[r], h), -1))
                for v, r in zip(self.names, self.rates, strict=True)]  # fmt: skip

    def _slopes(self, env: Mapping[str, Model], room: list[int], h: Model) -> tuple[list[Block], Matrix]:
        """`h Df` over the polynomials with `room` around them, where the field is thereby defined.

        Blocks by the power of t, and bounds of what is left out.
        """
        wide, space = dict(zip(self.names, room, strict=True)), self.coarse
        low = {v: widened(lowered(m, space.time, space.degree), wide.get(v, 0)) for v, m in env.items()}
        found = [p for row in self.slopes for p in row if p is not None]
        values = self.tape.values([*self.rates, *found], low, space)
        h = lowered(h, 0, space.degree)
        rows = [[ZERO if p is None else space.mul(values[p], h) for p in row] for row in self.slopes]
        keys = {k for row in rows for m in row for terms in m.parts.values() for k in terms} | {0}
        zeros = nothing(len(rows))
        by_power = [Block({k: [[m.parts.get(i, {}).get(k, 0) for m in row] for row in rows] for k in keys}, zeros)
                    for i in range(space.time + 1)]  # fmt: skip
        return by_power, [[m.radius for m in row] for row in rows]

    def _turn(self, frame: Block, undone: Block, found: tuple[list[Block], Matrix]) -> Turn:
        """The series of `U' = h Df U` and of `V' = -h V Df` from a frame and its inverse; how far they are off.

        What U' is, and what h Df U is, agree up to a power of t but for rounding: k units at most in each part at t^k.
        """
        (slopes, left_out), bits, top, n = found, self.coarse.bits, self.coarse.time, len(frame.rest)
        there, back = [frame], [undone]
        apart = [size(added([product(undone, frame, bits), unit(n, bits, -1)]))]
        rest = []
        for k in range(2 * top + 1):
            rates = term(slopes, there, k, bits)
            if k < top:
                rest.append([[c + k * len(rates.parts) for c in row] for row in rates.rest])
                there.append(_divided(rates, k + 1))
                back.append(_divided(term(back, slopes, k, bits), -k - 1))
            else:
                rest.append(size(rates))
            if k:
                apart.append(size(term(back, there, k, bits)))
        large = total([size(a) for a in there])
        rest.append(size(product(Block({}, left_out), Block({}, large), bits)))
        is_rough = max(map(max, total(apart[1:]))) >> bits - TURNED > 0
        return Turn(added(there), total([size(a) for a in back]), large, total(apart), total(rest), is_rough)

    def _fixed(self, a: Matrix, x: list[int]) -> list[int]:
        """Bounds of the y with `y = x + A y`, given bounds of x and A: A has no eigenvalue from 1 on, if `a y < y`."""
        y = [b + 1 for b in x]
        for _ in range(ROUNDS):
            wanted = [b + c + 1 for b, c in zip(x, applied(a, y, self.coarse.bits), strict=True)]
            if all(w <= b for w, b in zip(wanted, y, strict=True)):
                return y
            y = [w + (w >> 5) for w in wanted]
        raise Beyond("the errors of a recorded flow turn too much in a step")

    def _solved(self, frame: Block, back: Block, a: list[int]) -> list[int]:
        """Bounds of the x with `frame x = y`, given bounds of `back y`: `x = back y + (1 - back frame) x`."""
        bits = self.coarse.bits
        minus = unit(len(a), bits, -1)
        return self._fixed(size(added([product(back, frame, bits), minus])), a)

    def _front(self, centre: dict[str, Model], moved: Block, radii: list[int]) -> Front:
        """The set at the end of a step, `centre + moved w`; a frame of numbers where columns become alike."""
        frame = Block(moved.parts, nothing(len(radii)))
        try:
            found = self._framed(frame, moved, radii)
        except Beyond:
            found = None
        if found is None or not self._serves(frame, found, radii):
            frame = Block({0: orthogonal(moved.parts[0], radii, self.coarse)}, frame.rest)
            found = self._framed(frame, moved, radii)
        return Front(centre, frame, found)

    def _framed(self, frame: Block, moved: Block, radii: list[int]) -> list[int]:
        """Bounds of the v with `frame v = moved w`."""
        back, bits = inverse(frame, self.coarse.bits), self.coarse.bits
        return self._solved(frame, back, applied(size(product(back, moved, bits)), radii, bits))

    def _serves(self, frame: Block, found: list[int], radii: list[int]) -> bool:
        """Do boxes fit into the frame without becoming much larger, at all z?"""
        bits = self.coarse.bits
        wide = applied(size(frame), found, bits)
        boxed = applied(size(frame), applied(size(inverse(frame, bits)), wide, bits), bits)
        near = all(a <= r + (r >> 2) + 8 for a, r in zip(found, radii, strict=True))
        return near and all(b <= LOSS * s + 8 for b, s in zip(boxed, wide, strict=True))


def _divided(a: Block, by: int) -> Block:
    """Near a block over a number; what is left out of it is left out."""
    return Block({k: [[c // by for c in row] for row in m] for k, m in a.parts.items()}, nothing(len(a.rest)))
