"""Zones as difference-bound matrices of integers, and formulas about clocks.

A bound `x_i - x_j <= c` is the integer 2 c + 1, `x_i - x_j < c` is 2 c; clock 0 is always 0. A zone is the tuple of all
bounds, row by row, closed under the triangle inequality; there is no empty zone.

Source          D. Dill, CAV 1989; the extrapolation is Extra+LU of G. Behrmann, P. Bouyer, K. Larsen, R. Pelanek,
                STTT 8(3), 2006
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from operator import le
from typing import Any

from haverify.text.record import holder

Zone = tuple[int, ...]
Formula = Any  # bool | ("and", f, ...) | ("or", f, ...) | (i, j, bound)
FREE, AT_MOST_ZERO = 1 << 62, 1


class SpentError(Exception):
    """The work that an exploration may cost is used up."""


@holder
class Effort:
    """Elementary steps left."""

    left: int

    def spend(self, steps: int) -> None:
        """Count steps; raise SpentError when there are none left."""
        self.left -= steps
        if self.left < 0:
            raise SpentError


def plus(a: int, b: int) -> int:
    """The sum of two bounds."""
    return FREE if a == FREE or b == FREE else a + b - ((a | b) & 1)


def conjunction(members: Iterable[Formula]) -> Formula:
    """All of them, with truth constants folded."""
    found = [f for f in members if f is not True]
    if any(f is False for f in found):
        return False
    return True if not found else found[0] if len(found) == 1 else ("and", *found)


def disjunction(members: Iterable[Formula]) -> Formula:
    """One of them at least, with truth constants folded."""
    found = [f for f in members if f is not False]
    if any(f is True for f in found):
        return True
    return False if not found else found[0] if len(found) == 1 else ("or", *found)


def negation(f: Formula) -> Formula:
    """The opposite; that of `x - y <= c` is `y - x < -c`."""
    if isinstance(f, bool):
        return not f
    if f[0] in ("and", "or"):
        return (disjunction if f[0] == "and" else conjunction)(negation(g) for g in f[1:])
    return (f[1], f[0], 1 - f[2])


def literals(f: Formula) -> list[tuple[int, int, int]]:
    """All bounds that a formula mentions."""
    if isinstance(f, bool):
        return []
    return [x for g in f[1:] for x in literals(g)] if f[0] in ("and", "or") else [f]


@holder
class Space:
    """The zones over clocks 1 .. n - 1."""

    n: int
    effort: Effort

    @property
    def everything(self) -> Zone:
        """All values of all clocks, negative ones too."""
        return tuple(AT_MOST_ZERO if i == j else FREE for i in range(self.n) for j in range(self.n))

    def bounded(self, z: Zone, i: int, j: int, bound: int) -> Zone | None:
        """The part of a zone with `x_i - x_j` below a bound; None where there is none."""
        n = self.n
        if bound >= z[i * n + j]:
            return z
        if plus(bound, z[j * n + i]) < AT_MOST_ZERO:
            return None
        self.effort.spend(n)
        row = z[j * n : j * n + n]
        out = list(z)
        for k in range(n):
            to = plus(z[k * n + i], bound)
            if to != FREE:
                at = k * n
                for m, step in enumerate(row):
                    new = plus(to, step)
                    if new < out[at + m]:
                        out[at + m] = new
        return tuple(out)

    def meet(self, z: Zone, f: Formula) -> list[Zone]:
        """Zones whose union is the part of a zone where a formula holds."""
        self.effort.spend(1)
        if isinstance(f, bool):
            return [z] if f else []
        if f[0] == "or":
            return list(dict.fromkeys(p for g in f[1:] for p in self.meet(z, g)))
        if f[0] == "and":
            parts = [z]
            for g in f[1:]:
                parts = [q for p in parts for q in self.meet(p, g)]
            return parts
        part = self.bounded(z, *f)
        return [] if part is None else [part]

    def formula(self, z: Zone) -> Formula:
        """The bounds of a zone."""
        n = self.n
        return conjunction((k // n, k % n, b) for k, b in enumerate(z) if b != FREE and k // n != k % n)

    def without(self, z: Zone, other: Zone) -> list[Zone]:
        """Disjoint zones whose union is what is in one zone and not in another."""
        parts: list[Zone] = []
        for k, bound in enumerate(other):
            if bound >= z[k]:
                continue
            i, j = divmod(k, self.n)
            outside, inside = self.bounded(z, j, i, 1 - bound), self.bounded(z, i, j, bound)
            parts += [outside] if outside is not None else []
            if inside is None:
                break
            z = inside
        return parts

    def later(self, z: Zone) -> Zone:
        """All that a zone becomes as time passes."""
        return self._with(z, {i * self.n: FREE for i in range(1, self.n)})

    def earlier(self, z: Zone) -> Zone:
        """All that becomes a zone as time passes."""
        return self._with(z, dict.fromkeys(range(1, self.n), FREE))

    def strictly_later(self, z: Zone) -> Zone:
        """All that a zone becomes after a time that is not 0."""
        return self._with(self.later(z), {i: z[i] & ~1 for i in range(1, self.n) if z[i] != FREE})

    def about_to_enter(self, z: Zone) -> list[Zone]:
        """Where all states right after now are in a zone."""
        n = self.n
        lower = [(0, i, z[i] | 1) for i in range(1, n) if z[i] != FREE]
        upper = [(i, 0, z[i * n] & ~1) for i in range(1, n) if z[i * n] != FREE]
        return self.meet(self.earlier(self.later(z)), conjunction([*lower, *upper]))

    def forget(self, z: Zone, clock: int) -> Zone:
        """The same with any value of a clock."""
        n = self.n
        return self._with(z, {k: FREE for m in range(n) if m != clock for k in (clock * n + m, m * n + clock)})

    def assigned(self, z: Zone, sets: Sequence[tuple[int, int, int]]) -> Zone:
        """The zone after clocks have been set: (clock, least value, greatest value)."""
        for clock, low, high in sets:
            part = self.bounded(self.forget(z, clock), 0, clock, 1 - 2 * low)
            assert part is not None
            part = self.bounded(part, clock, 0, 1 + 2 * high)
            assert part is not None
            z = part
        return z

    def _with(self, z: Zone, new: dict[int, int]) -> Zone:
        out = list(z)
        for k, bound in new.items():
            out[k] = bound
        return tuple(out)

    def renamed(self, z: Zone, order: Sequence[int]) -> Zone:
        """The zone in which clock i is called order[i]."""
        n = self.n
        old = [0] * n
        for i, new in enumerate(order):
            old[new] = i
        self.effort.spend(n)
        return tuple([z[i * n + j] for i in old for j in old])

    def extrapolated(self, z: Zone, lower: Sequence[int | None], upper: Sequence[int | None]) -> Zone:
        """A zone around `z` that no bound x > c with c <= lower[x], or x < c with c <= upper[x], tells from it.

        None: the clock is not compared in that direction before it is set. Soundness: it contains `z`; with bounds on
        single clocks only, what can happen from it can happen from `z`.
        """
        n, out = self.n, list(z)
        self.effort.spend(n * n)
        floor = [0, *(-(z[i] >> 1) if z[i] != FREE else -FREE for i in range(1, n))]
        for i in range(n):
            for j in range(n):
                k = i * n + j
                if i == j or z[k] == FREE:
                    continue
                high = i and (_above(z[k] >> 1, lower[i]) or _above(floor[i], lower[i]))
                if high or (i and _above(floor[j], upper[j])):
                    out[k] = FREE
                elif not i and _above(floor[j], upper[j]):
                    top = upper[j]
                    out[k] = FREE if top is None else -2 * top
        return tuple(out) if tuple(out) == z else self.closed(out)

    def closed(self, out: list[int]) -> Zone:
        """The zone of some bounds that leave something."""
        n = self.n
        self.effort.spend(n * n)
        for k in range(n):
            row = out[k * n : k * n + n]
            for i in range(n):
                to = out[i * n + k]
                if to == FREE:
                    continue
                for j, step in enumerate(row):
                    new = plus(to, step)
                    if new < out[i * n + j]:
                        out[i * n + j] = new
        return tuple(out)


def _above(value: int, bound: int | None) -> bool:
    return bound is None or value > bound


def inside(a: Zone, b: Zone) -> bool:
    """Is the first zone part of the second?"""
    return all(map(le, a, b))
