"""Units: products of named units with exact scales (`rational * pi^k`) and dimensions.

`rad` and `1` are the same dimension; an angle in another unit (`deg`, `rpm`) becomes a plain number only by dividing
by an angle. So `deg` converts to `rad`, `rad` to `1`, but `deg` not to `1`.
"""

from __future__ import annotations

import re
from collections.abc import Mapping
from fractions import Fraction
from functools import cached_property, lru_cache

from haverify.text.record import field, record

Exponent = int | Fraction
Dimensions = tuple[tuple[str, Exponent], ...]


@record
class NamedUnit:
    """A unit with a name: `scale * pi^pi` of the base units `dimensions`."""

    name: str
    scale: Fraction
    pi: int
    dimensions: Dimensions
    is_builtin: bool = True

    def __hash__(self) -> int:
        return hash(self.name)

    @property
    def is_scaled_angle(self) -> bool:
        """Whether it measures angles in something else than radians."""
        return (self.scale != 1 or self.pi != 0) and any(n == "rad" for n, _ in self.dimensions)


@record
class Unit:
    """A product of powers of named units, in canonical order: made by `parse_unit`, `ONE`, `*`, `/`, `power`."""

    factors: tuple[tuple[NamedUnit, Exponent], ...] = ()
    _hash: int = field(default=0, compare=False, repr=False)

    def __post_init__(self) -> None:
        object.__setattr__(self, "_hash", hash(self.factors))

    def __hash__(self) -> int:
        return self._hash

    @cached_property
    def dimensions(self) -> Dimensions:
        """Base units with exponents, sorted by name, `rad` included."""
        total: dict[str, Exponent] = {}
        for unit, e in self.factors:
            for name, d in unit.dimensions:
                total[name] = _plain(total.get(name, 0) + d * e)
        return tuple(sorted((n, e) for n, e in total.items() if e != 0))

    @cached_property
    def without_angle(self) -> Dimensions:
        """`dimensions` without `rad`."""
        return tuple(d for d in self.dimensions if d[0] != "rad")

    @cached_property
    def scale(self) -> Fraction:
        """The rational part of what one of this unit is in base units; exponents of scaled factors are integers."""
        q = Fraction(1)
        for unit, e in self.factors:
            if unit.scale != 1:
                q *= unit.scale ** int(e)
        return q

    @cached_property
    def pi(self) -> int:
        """The power of pi in what one of this unit is in base units."""
        return sum(unit.pi * int(e) for unit, e in self.factors)

    @cached_property
    def has_scaled_angle(self) -> bool:
        """Whether a factor is an angle in something else than radians."""
        return any(u.is_scaled_angle for u, _ in self.factors)

    @cached_property
    def is_plain(self) -> bool:
        """Whether quantities in this unit are plain numbers as they stand: `1`, `rad`, products that cancel."""
        return not self.without_angle and not self.has_scaled_angle and self.scale == 1

    @cached_property
    def is_coherent(self) -> bool:
        """Whether one of this unit is one of the base units."""
        return self.scale == 1 and self.pi == 0

    @cached_property
    def text(self) -> str:
        """The unit as one writes it after a number; `1` when there is nothing to write."""
        return _text(self.factors) or "1"

    @cached_property
    def is_writable(self) -> bool:
        """Whether `text` is one token of the language: at most one unit of the file, alone, and integer exponents."""
        if any(e != int(e) for _, e in self.factors):
            return False
        own = [u for u, _ in self.factors if not u.is_builtin]
        leading = [u for u, _ in self.factors if u.name in _FIRST_ONLY]
        return (not own or (len(self.factors) == 1 and self.factors[0][1] == 1)) and len(leading) <= 1

    def __mul__(self, other: Unit) -> Unit:
        return _multiply(self, other)

    def __truediv__(self, other: Unit) -> Unit:
        return _multiply(self, power(other, -1))

    def __str__(self) -> str:
        return self.text


_BASE = ("kg", "m", "s", "rad", "K", "A")
_FIRST_ONLY = ("%", "Pa")


_DERIVED: Mapping[str, tuple[Fraction | int, Mapping[str, int]]] = {
    "N": (1, {"kg": 1, "m": 1, "s": -2}),
    "J": (1, {"kg": 1, "m": 2, "s": -2}),
    "W": (1, {"kg": 1, "m": 2, "s": -3}),
    "Pa": (1, {"kg": 1, "m": -1, "s": -2}),
    "V": (1, {"kg": 1, "m": 2, "s": -3, "A": -1}),
    "Nm": (1, {"kg": 1, "m": 2, "s": -2}),
    "Hz": (1, {"s": -1}),
    "us": (Fraction(1, 10**6), {"s": 1}),
    "ms": (Fraction(1, 1000), {"s": 1}),
    "min": (60, {"s": 1}),
    "h": (3600, {"s": 1}),
    "mm": (Fraction(1, 1000), {"m": 1}),
    "cm": (Fraction(1, 100), {"m": 1}),
    "km": (1000, {"m": 1}),
    "%": (Fraction(1, 100), {}),
}


def _table() -> dict[str, NamedUnit]:
    units = {n: NamedUnit(n, Fraction(1), 0, ((n, 1),)) for n in _BASE}
    for name, (scale, dims) in _DERIVED.items():
        units[name] = NamedUnit(name, Fraction(scale), 0, tuple(sorted(dims.items())))
    units["deg"] = NamedUnit("deg", Fraction(1, 180), 1, (("rad", 1),))
    return units


BUILTIN: Mapping[str, NamedUnit] = _table()
_ORDER = {n: i for i, n in enumerate(("%", "Pa", "N", "J", "W", "V", "Nm", "deg", "kg", "km", "m", "cm", "mm", "rad"))}


def _rank(factor: tuple[NamedUnit, Exponent]) -> tuple[bool, bool, int, str]:
    unit, e = factor
    return (unit.name not in _FIRST_ONLY, e < 0, _ORDER.get(unit.name, 99), unit.name)


def _plain(e: Exponent) -> Exponent:
    return int(e) if e == int(e) else e


@lru_cache(maxsize=4096)
def _unit(factors: tuple[tuple[NamedUnit, Exponent], ...]) -> Unit:
    return Unit(factors)


def _of(total: Mapping[NamedUnit, Exponent]) -> Unit:
    return _unit(tuple(sorted(((u, _plain(e)) for u, e in total.items() if e != 0), key=_rank)))


ONE = _of({})


def named(unit: NamedUnit) -> Unit:
    """The unit that is one named unit."""
    return _of({unit: 1})


SECOND = named(BUILTIN["s"])
RADIAN = named(BUILTIN["rad"])


@lru_cache(maxsize=8192)
def _multiply(a: Unit, b: Unit) -> Unit:
    total = dict(a.factors)
    for u, e in b.factors:
        total[u] = total.get(u, 0) + e
    return _of(total)


@lru_cache(maxsize=4096)
def power(unit: Unit, exponent: Exponent) -> Unit:
    """`unit ^ exponent`; a fractional exponent needs a coherent unit or even factors."""
    return _of({u: e * exponent for u, e in unit.factors})


@lru_cache(maxsize=4096)
def coherent(unit: Unit) -> Unit:
    """The product of base units with the same dimension."""
    total: dict[NamedUnit, Exponent] = {}
    for name, e in unit.dimensions:
        base = BUILTIN.get(name) or NamedUnit(name, Fraction(1), 0, ((name, 1),), False)
        total[base] = e
    return _of(total)


@lru_cache(maxsize=8192)
def conversion(source: Unit, target: Unit) -> tuple[Fraction, int] | None:
    """`(q, k)` such that `x source = q * pi^k * x target`; None when they measure different things."""
    if not is_compatible(source, target):
        return None
    return source.scale / target.scale, source.pi - target.pi


def is_compatible(a: Unit, b: Unit) -> bool:
    """Whether the units measure the same; degrees and plain numbers do not."""
    if a.without_angle != b.without_angle:
        return False
    return a.dimensions == b.dimensions or not (a.has_scaled_angle or b.has_scaled_angle)


def differs_by_angle(a: Unit, b: Unit) -> bool:
    """Whether the units would be compatible if degrees were plain numbers."""
    return a.without_angle == b.without_angle and not is_compatible(a, b)


def _text(factors: tuple[tuple[NamedUnit, Exponent], ...]) -> str:
    out = ""
    for unit, exponent in factors:
        for e in _digits(exponent):
            if not out:
                out = unit.name + _exponent(e)
            elif e < 0:
                out += "/" + unit.name + _exponent(-e)
            else:
                out += "." + unit.name + _exponent(e)
    return out


def _digits(e: Exponent) -> list[Exponent]:
    """`e` as a sum of exponents of one digit, because the language has no longer ones."""
    if e != int(e) or -9 <= e <= 9:
        return [e]
    sign = 1 if e > 0 else -1
    nines, rest = divmod(abs(int(e)), 9)
    digits: list[Exponent] = [9 * sign] * nines
    return [*digits, rest * sign] if rest else digits


def _exponent(e: Exponent) -> str:
    if e == 1:
        return ""
    return f"^{e}" if e == int(e) else f"^({e})"


_FACTOR = re.compile(r"([./]?)([A-Za-z_%][A-Za-z0-9_]*|1)(?:\^(-?\d+|\(-?\d+/\d+\)))?")


@lru_cache(maxsize=1024)
def _parse(text: str, known: tuple[NamedUnit, ...]) -> Unit | None:
    own = {u.name: u for u in known}
    total: dict[NamedUnit, Exponent] = {}
    at = 0
    while at < len(text):
        m = _FACTOR.match(text, at)
        if m is None or (at == 0) != (m[1] == ""):
            return None
        unit = own.get(m[2]) or BUILTIN.get(m[2])
        if unit is None and m[2] != "1":
            return None
        e = Fraction((m[3] or "1").strip("()")) * (-1 if m[1] == "/" else 1)
        if unit is not None:
            total[unit] = _plain(total.get(unit, 0) + e)
        at = m.end()
    return _of(total)


def parse_unit(text: str, known: tuple[NamedUnit, ...] = ()) -> Unit | None:
    """The unit that `text` (`deg/s^2`, `kg.m^2`, `1/s`, `1`) names; `known` are the units the file made."""
    return _parse(text.replace(" ", ""), known) if text else None
