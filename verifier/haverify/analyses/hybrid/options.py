"""`method taylor(order = 8, degree = 3, tolerance = 1e-7, step = 50 ms, cuts = 2)`: how finely flowpipes are computed.

What is left out is chosen by the analysis. None of it decides whether a verdict is true.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from fractions import Fraction
from math import comb

from haverify.model.claim import Claim
from haverify.obligations.translate import OutsideFragmentError
from haverify.solvers.kernel import Settings
from haverify.text.record import replace

NAME = "taylor"
_SECONDS = {"s": Fraction(1), "ms": Fraction(1, 1000), "min": Fraction(60), "": Fraction(1)}
_MOST_MONOMIALS = 3000
_ALLOWED = "order (2 to 30), degree (1 to 8), tolerance (above 0), step (a time above 0), cuts (0 to 6)"


def tuned(settings: Settings, claim: Claim, wide: int) -> Settings:
    """The settings with what the claim's method says; `wide` variables of the set are no points.

    Raises
    ------
    OutsideFragmentError    if an option is unknown, or its value of no use
    """
    if claim.method is None or claim.method[0] != NAME:
        return settings
    changes: dict[str, float] = {}
    for name, value in claim.method[1]:
        if name not in _READ:
            raise OutsideFragmentError(f"`method taylor` has no option `{name}`; it has {_ALLOWED}")
        field, read = _READ[name]
        found = _checked(name, value, read)
        if field != "cuts":
            changes[field] = found
    if wide == 0:
        changes.pop("degree", None)
    if comb(wide + int(changes.get("degree", 1)), wide) > _MOST_MONOMIALS:
        raise OutsideFragmentError(f"polynomials of degree {changes['degree']} in {wide} variables are too large")
    return replace(settings, **changes)


def cuts(claim: Claim) -> int:
    """How often boxes of starts are halved before they are followed.

    Raises
    ------
    OutsideFragmentError    if the claim's method says something else than a small number
    """
    given = dict(claim.method[1]) if claim.method is not None and claim.method[0] == NAME else {}
    return int(_checked("cuts", given["cuts"], _READ["cuts"][1])) if "cuts" in given else 0


def _checked(name: str, value: str, read: Callable[[str], float | None]) -> float:
    found = read(value)
    if found is None:
        raise OutsideFragmentError(f"`{name} = {value}` in `method taylor`: it has {_ALLOWED}")
    return found


def _whole(low: int, high: int) -> Callable[[str], float | None]:
    return lambda text: int(text) if text.isdecimal() and low <= int(text) <= high else None


def _number(text: str, units: Mapping[str, Fraction]) -> float | None:
    digits, _, unit = text.partition(" ")
    try:
        value = float(Fraction(digits) * units[unit])
    except (ValueError, KeyError, ZeroDivisionError, OverflowError):
        return None
    return value if 1e-30 <= value <= 1e9 else None


_READ: dict[str, tuple[str, Callable[[str], float | None]]] = {
    "order": ("order", _whole(2, 30)),
    "degree": ("degree", _whole(1, 8)),
    "tolerance": ("tolerance", lambda text: _number(text, {"": Fraction(1)})),
    "cuts": ("cuts", _whole(0, 6)),
    "step": ("longest", lambda text: _number(text, _SECONDS)),
}
