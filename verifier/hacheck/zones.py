"""Zones: sets of clock values given by bounds on differences of two clocks, as matrices of whole numbers.

A bound `x_i - x_j <= c` is the number 2 c + 1, `x_i - x_j < c` is 2 c; clock 0 is always 0. A zone is the tuple of all
bounds, row by row, each as tight as the others make it; an empty zone is None.
"""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

from hacheck.rational import Refused, spend

Zone = tuple[int, ...]
Formula = Any  # bool | ("and", f, ...) | ("or", f, ...) | (i, j, bound)
NO_BOUND, ZERO = 1 << 62, 1
LARGEST = 1 << 50


def plus(a: int, b: int) -> int:
    """The sum of two bounds."""
    return NO_BOUND if NO_BOUND in (a, b) else a + b - ((a | b) & 1)


def both(members: Iterable[Formula]) -> Formula:
    """The conjunction."""
    found = [f for f in members if f is not True]
    return False if False in found else True if not found else found[0] if len(found) == 1 else ("and", *found)


def either(members: Iterable[Formula]) -> Formula:
    """The disjunction."""
    found = [f for f in members if f is not False]
    return True if True in found else False if not found else found[0] if len(found) == 1 else ("or", *found)


def opposite(f: Formula) -> Formula:
    """The negation: `x - y <= c` becomes `y - x < -c`."""
    if isinstance(f, bool):
        return not f
    if f[0] in ("and", "or"):
        return (either if f[0] == "and" else both)(opposite(g) for g in f[1:])
    i, j, bound = f
    return (j, i, 1 - bound)


class Space:
    """The zones over some clocks."""

    def __init__(self, clocks: int) -> None:
        self.n = clocks + 1
        self.all: Zone = tuple(ZERO if i == j else NO_BOUND for i in range(self.n) for j in range(self.n))
        self.uppers = [i * self.n for i in range(1, self.n)]
        self.lowers = list(range(1, self.n))

    def read(self, bounds: Any) -> Zone:
        """A zone from its bounds, null where there is none."""
        n = self.n
        if not isinstance(bounds, list) or len(bounds) != n * n:
            raise Refused("a zone has another number of bounds than there are differences of clocks")
        z = tuple(NO_BOUND if b is None else b for b in bounds)
        if any(type(b) is not int or (abs(b) > LARGEST and b != NO_BOUND) for b in z):
            raise Refused("a bound of a zone is no whole number, or too large")
        spend(n**3 // 4 + 1)
        tight = all(z[i * n + j] <= plus(z[i * n + k], z[k * n + j])
                    for k in range(n) for i in range(n) for j in range(n))  # fmt: skip
        if not tight or any(z[i * n + i] != ZERO for i in range(n)):
            raise Refused("a zone is empty, or its bounds are not as tight as they could be")
        return z

    def within(self, z: Zone, i: int, j: int, bound: int) -> Zone | None:
        """The part of a zone with `x_i - x_j` below a bound; None where there is none."""
        n = self.n
        if bound >= z[i * n + j]:
            return z
        if plus(bound, z[j * n + i]) < ZERO:
            return None
        spend(n * n // 4 + 1)
        row = z[j * n : j * n + n]
        out: list[int] = []
        for k in range(n):
            to = plus(z[k * n + i], bound)
            old = z[k * n : k * n + n]
            out += old if to == NO_BOUND else [min(o, plus(to, r)) for o, r in zip(old, row, strict=True)]
        return tuple(out)

    def cut(self, z: Zone, f: Formula) -> list[Zone]:
        """Zones whose union is the part of a zone where a formula holds."""
        spend(1)
        if isinstance(f, bool):
            return [z] if f else []
        if f[0] == "or":
            return [part for g in f[1:] for part in self.cut(z, g)]
        if f[0] == "and":
            parts = [z]
            for g in f[1:]:
                parts = [q for p in parts for q in self.cut(p, g)]
            return parts
        part = self.within(z, *f)
        return [] if part is None else [part]

    def formula(self, z: Zone) -> Formula:
        """The bounds of a zone as a formula."""
        n = self.n
        return both((k // n, k % n, b) for k, b in enumerate(z) if b != NO_BOUND and k // n != k % n)

    def minus(self, z: Zone, other: Zone) -> list[Zone]:
        """Zones whose union is what is in one zone and not in another."""
        parts = []
        for k, bound in enumerate(other):
            if bound < z[k]:
                outside = self.within(z, k % self.n, k // self.n, 1 - bound)
                if outside is not None:
                    parts.append(outside)
                inside = self.within(z, k // self.n, k % self.n, bound)
                if inside is None:
                    return parts
                z = inside
        return parts

    def later(self, z: Zone) -> Zone:
        """Everything a zone becomes as time passes."""
        return self._replaced(z, dict.fromkeys(self.uppers, NO_BOUND))

    def earlier(self, z: Zone) -> Zone:
        """Everything that becomes a zone as time passes."""
        return self._replaced(z, dict.fromkeys(self.lowers, NO_BOUND))

    def after(self, z: Zone) -> Zone:
        """Everything a zone becomes after some time that is not zero."""
        return self._replaced(self.later(z), {k: z[k] & ~1 for k in self.lowers if z[k] != NO_BOUND})

    def about_to(self, z: Zone) -> list[Zone]:
        """Where one is inside a zone at all times right after now."""
        found = self._replaced(self.later(z), dict.fromkeys(self.lowers, NO_BOUND))
        now = [(k // self.n, k % self.n, z[k] | 1 if k < self.n else z[k] & ~1)
               for k in (*self.lowers, *self.uppers) if z[k] != NO_BOUND]  # fmt: skip
        return self.cut(found, both(now))

    def forget(self, z: Zone, clock: int) -> Zone:
        """The same with any value of a clock."""
        n = self.n
        ends = {k: NO_BOUND for m in range(n) if m != clock for k in (clock * n + m, m * n + clock)}
        return self._replaced(z, ends)

    def _replaced(self, z: Zone, new: dict[int, int]) -> Zone:
        spend(self.n)
        out = list(z)
        for k, bound in new.items():
            out[k] = bound
        return tuple(out)

    def permuted(self, z: Zone, order: list[int]) -> Zone:
        """The zone in which clock i is called order[i]."""
        n, old = self.n, [0] * self.n
        for i, new in enumerate(order):
            old[new] = i
        spend(n * n // 8 + 1)
        return tuple(z[i * n + j] for i in old for j in old)


def inside(a: Zone, b: Zone) -> bool:
    """Is the first zone part of the second?"""
    return all(x <= y for x, y in zip(a, b, strict=True))
