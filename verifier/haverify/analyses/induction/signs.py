"""Premises that exclude each other as they stand (docs/core.md section 9, proof `t`)."""

from __future__ import annotations

from collections.abc import Iterable

from haverify.maths.polynomial import Polynomial
from haverify.obligations.formula import HOLDS, Formula, Literal, truth
from haverify.obligations.functions import factors

SIGNS = (-1, 0, 1)


def absurd(entries: Iterable[Formula]) -> bool:
    """Whether an entry is false when literals count as false that exclude another entry, a literal."""
    known = list(entries)
    left: dict[Polynomial, set[int]] = {}
    for f in known:
        if isinstance(f, Literal):
            key, allowed = _signs(f)
            left[key] = left.get(key, set(SIGNS)) & allowed

    def possible(leaf: Literal) -> bool | None:
        key, allowed = _signs(leaf)
        return None if left.get(key, set(SIGNS)) & allowed else False

    return any(truth(f, possible) is False for f in known)


def _signs(f: Literal) -> tuple[Polynomial, set[int]]:
    """The polynomial up to sign, and the signs that the literal allows it."""
    p = f.polynomial
    first = min(p.whole, key=factors, default=())
    flip = -1 if p.whole.get(first, 1) < 0 else 1
    return (-p if flip < 0 else p), {flip * s for s in SIGNS if HOLDS[f.op](s)}  # type: ignore[arg-type]
