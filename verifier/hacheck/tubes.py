"""How far the solutions of `x' = f(x)` are from given polynomials: one step, without integrating again.

With `x = P(t, z) + e`, t in [0, 1] over a step of length h(z), and `P' = h f(P) + d`: `e' = h J e - d`, where J is a
mean of Df between P and x. The error is written `e = U(t, z) w` with any invertible U, here near a solution of
`U' = h J U`; so `w' = U^-1 ((h J U - U') w - d)`. If the w found from `|w| <= guess` stay inside the guess, they never
leave it: there is no first instant at which they would.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, NamedTuple

from hacheck.enclosures import ZERO, Model, Space, add, at_end, lowered, middle, norm, slope, widened
from hacheck.rational import Beyond, spend
from hacheck.scope import Scope
from hacheck.tapes import Tape

Matrix = list[list[Model]]
Numbers = list[list[int]]
ATTEMPTS, ROUNDS, LOSS = 6, 30, 6


class Front(NamedTuple):
    """A set: `centre(z) + frame(z) w` for z in the set variables' range and |w| <= radii, one w for each variable."""

    centre: dict[str, Model]
    frame: Matrix
    radii: list[int]


class Field:
    """The flow of a mode and its derivatives, in a fine space for the field and a coarse one for errors."""

    def __init__(self, scope: Scope, mode: str, fine: Space, coarse: Space) -> None:
        self.tape, self.names, self.fine, self.coarse = Tape(scope, mode), list(scope.types), fine, coarse
        lines: dict[str, Any] = {line["var"]: line for line in scope.modes[mode]["flow"]}
        if not all(v in lines and "rate" in lines[v] for v in self.names):
            raise Beyond("flows that are inclusions")
        self.rates = [self.tape.value(lines[v]["rate"]) for v in self.names]
        self.slopes = [[self.tape.slope(r, v) for v in self.names] for r in self.rates]

    def front(self, centre: dict[str, Model], radii: list[int]) -> Front:
        """A set whose errors are a box."""
        one = self.coarse.constant(self.coarse.one)
        return Front(centre, [[one if i == j else ZERO for j in range(len(radii))] for i in range(len(radii))], radii)

    def step(self, start: Front, env: Mapping[str, Model], h: Model) -> tuple[list[int], Front]:
        """Bounds of each variable's error along the polynomials in env, in a step from `start`; the set at its end."""
        defects, back = self._defects(env, h), self._back(start.frame)
        first = self._spread(back, defects)
        guess = [r + (r >> 3) + 2 * a + 4 for r, a in zip(start.radii, first, strict=True)]
        room = [2 * x for x in self._spread(start.frame, guess)]
        for _ in range(ATTEMPTS):
            slopes = self._slopes(env, room, h)
            frame = self._moved(start.frame, slopes)
            tube = self._spread(frame, guess)
            if any(t > r for t, r in zip(tube, room, strict=True)):
                room = [2 * t for t in tube]
                continue
            grown = self._grown(frame, slopes, self._undone(back, slopes), guess, defects)
            found = [r + s for r, s in zip(start.radii, grown, strict=True)]
            if all(f < g for f, g in zip(found, guess, strict=True)):
                end = [[at_end(m) for m in row] for row in frame]
                return self._spread(frame, found), self._front({v: at_end(env[v]) for v in self.names}, end, found)
            guess = [max(g, 2 * f) for f, g in zip(found, guess, strict=True)]
            room = [max(r, 2 * t) for r, t in zip(room, self._spread(frame, guess), strict=True)]
        raise Beyond("no bound of the errors of a recorded flow is found")

    def _defects(self, env: Mapping[str, Model], h: Model) -> list[int]:
        values = self.tape.values(self.rates, env, self.fine)
        return [norm(add(slope(env[v]), self.fine.mul(values[r], h), -1))
                for v, r in zip(self.names, self.rates, strict=True)]  # fmt: skip

    def _slopes(self, env: Mapping[str, Model], room: list[int], h: Model) -> Matrix:
        """`h Df` over the polynomials with `room` around them, where the field is thereby defined."""
        wide = dict(zip(self.names, room, strict=True))
        space = self.coarse
        low = {v: widened(lowered(m, space.time, space.degree), wide.get(v, 0)) for v, m in env.items()}
        found = [p for row in self.slopes for p in row if p is not None]
        values = self.tape.values([*self.rates, *found], low, space)
        h = lowered(h, 0, space.degree)
        return [[ZERO if p is None else space.mul(values[p], h) for p in row] for row in self.slopes]

    def _moved(self, frame: Matrix, slopes: Matrix) -> Matrix:
        """Near the solution of `U' = h Df U` that begins with the frame: its series, radii left out."""
        space, n = self.coarse, range(len(frame))
        by_power = [[[_coefficient(m, i) for m in row] for row in slopes] for i in range(space.time)]
        series = [frame]
        for k in range(space.time):
            terms = [[space.sum((by_power[i][a][c], series[k - i][c][b]) for i in range(k + 1) for c in n) for b in n]
                     for a in n]  # fmt: skip
            series.append([[_divided(m, k + 1) for m in row] for row in terms])
        return [[Model({k: s[a][b].parts.get(0, {}) for k, s in enumerate(series)}, 0) for b in n] for a in n]

    def _undone(self, back: Matrix, slopes: Matrix) -> Matrix:
        """Near the inverse of a moved frame: `W' = -h W Df`."""
        return _turned(self._moved(_turned(back), [[add(ZERO, m, -1) for m in row] for row in _turned(slopes)]))

    def _back(self, frame: Matrix) -> Matrix:
        """Near the inverse of a frame at t = 0: that of its middle, and one step of Newton's iteration."""
        space, n = self.coarse, range(len(frame))
        found = constants(space, inverted([[middle(m) for m in row] for row in frame], space))
        rest = off(space, found, frame)
        more = [[space.sum((rest[i][k], found[k][j]) for k in n) for j in n] for i in n]
        return [[Model(add(found[i][j], more[i][j]).parts, 0) for j in n] for i in n]

    def _spread(self, frame: Matrix, radii: list[int]) -> list[int]:
        """Bounds of `frame w`."""
        return _applied(self.coarse, [[norm(m) for m in row] for row in frame], radii)

    def _grown(self, frame: Matrix, slopes: Matrix, back: Matrix, guess: list[int], defects: list[int]) -> list[int]:
        """Bounds of `w'`, given those of w."""
        space, n = self.coarse, range(len(frame))
        rest = [[add(space.sum((slopes[i][k], frame[k][j]) for k in n), slope(frame[i][j]), -1) for j in n] for i in n]
        pull = [r + d for r, d in zip(self._spread(rest, guess), defects, strict=True)]
        return solved(space, frame, back, self._spread(back, pull))

    def _front(self, centre: dict[str, Model], frame: Matrix, radii: list[int]) -> Front:
        """The set at the end of a step, its frame made anew where its columns become alike or depend on z too much."""
        space, n = self.coarse, range(len(frame))
        numbers = [[middle(m) for m in row] for row in frame]
        if self._serves(frame, constants(space, inverted(numbers, space)), radii):
            return Front(centre, frame, radii)
        made = constants(space, orthogonal(numbers, radii, space))
        back = constants(space, inverted([[middle(m) for m in row] for row in made], space))
        turned = [[space.sum((back[i][k], frame[k][j]) for k in n) for j in n] for i in n]
        return Front(centre, made, solved(space, made, back, self._spread(turned, radii)))

    def _serves(self, frame: Matrix, back: Matrix, radii: list[int]) -> bool:
        """Do boxes fit into the frame without becoming much larger, at all z?"""
        size = self._spread(frame, radii)
        boxed = self._spread(frame, self._spread(back, size))
        try:
            apart = solved(self.coarse, frame, back, radii)
        except Beyond:
            return False
        near = all(a <= r + (r >> 2) + 8 for a, r in zip(apart, radii, strict=True))
        return near and all(b <= LOSS * s + 8 for b, s in zip(boxed, size, strict=True))


def constants(space: Space, a: Numbers) -> Matrix:
    """A matrix that does not depend on anything."""
    return [[space.constant(x) for x in row] for row in a]


def _turned(a: Matrix) -> Matrix:
    return [list(column) for column in zip(*a, strict=True)]


def _coefficient(m: Model, power: int) -> Model:
    """A coefficient of the powers of t."""
    return Model({0: m.parts[power]}, 0) if m.parts.get(power) else ZERO


def _divided(m: Model, by: int) -> Model:
    return Model({part: {k: c // by for k, c in t.items()} for part, t in m.parts.items()}, 0) if m.parts else ZERO


def _applied(space: Space, a: Numbers, x: list[int]) -> list[int]:
    """A matrix of bounds times a vector of bounds."""
    return [space.up(sum(map(int.__mul__, row, x))) for row in a]


def off(space: Space, back: Matrix, frame: Matrix) -> Matrix:
    """`1 - back frame`."""
    n, one = range(len(frame)), space.constant(space.one)
    made = [[space.sum((back[i][k], frame[k][j]) for k in n) for j in n] for i in n]
    return [[add(one if i == j else ZERO, made[i][j], -1) for j in n] for i in n]


def solved(space: Space, frame: Matrix, back: Matrix, a: list[int]) -> list[int]:
    """Bounds of the x with `frame x = y`, given bounds a of `back y`.

    As `x = back y + E x` with `E = 1 - back frame`, `a + |E| b < b` for some b shows `|x| < b` (|E| has no eigenvalue
    from 1 on, because `|E| b < b`).
    """
    shares = [[norm(m) for m in row] for row in off(space, back, frame)]
    b = [x + 1 for x in a]
    for _ in range(ROUNDS):
        wanted = [x + y + 1 for x, y in zip(a, _applied(space, shares, b), strict=True)]
        if all(w <= x for w, x in zip(wanted, b, strict=True)):
            return b
        b = [w + (w >> 6) for w in wanted]
    raise Beyond("the errors of a recorded flow turn too much in a step")


def inverted(a: Numbers, space: Space) -> Numbers:
    """A matrix near the inverse, by elimination; nothing rests on it."""
    n = len(a)
    spend(n**3)
    rows = [[*row, *(space.one if i == j else 0 for j in range(n))] for i, row in enumerate(a)]
    for c in range(n):
        best = max(range(c, n), key=lambda i: abs(rows[i][c]))
        rows[c], rows[best] = rows[best], rows[c]
        pivot = rows[c][c]
        if not pivot:
            raise Beyond("the errors of a recorded flow lose a direction")
        rows[c] = [x * space.one // pivot for x in rows[c]]
        for i in range(n):
            if i != c and rows[i][c]:
                rows[i] = [x - (rows[i][c] * y >> space.bits) for x, y in zip(rows[i], rows[c], strict=True)]
    return [row[n:] for row in rows]


def orthogonal(a: Numbers, radii: list[int], space: Space) -> Numbers:
    """Columns near orthogonal ones, the first along the longest column times its radius (R. Lohner's choice)."""
    n = range(len(a))
    columns = [[row[j] for row in a] for j in n]
    sizes = [sum(abs(row[j]) for row in a) * (radii[j] + 1) for j in n]
    found: Numbers = []
    for j in sorted(n, key=lambda j: -sizes[j]):
        column = columns[j]
        for other in found:
            along = sum(map(int.__mul__, column, other)) * space.one // (sum(x * x for x in other) or 1)
            column = [x - (along * y >> space.bits) for x, y in zip(column, other, strict=True)]
        most = max(map(abs, column))
        if not most:
            raise Beyond("the errors of a recorded flow lose a direction")
        found.append([x * space.one // most for x in column])
    return [[c[i] for c in found] for i in n]
