"""The weights of speeds in a time to go: the sum of what comes after a jump, geometric where jumps go in circles."""

from __future__ import annotations

from collections.abc import Mapping
from fractions import Fraction

from haverify.model.hybrid import Edge

Q = Fraction


def weights_of(
    edges: tuple[Edge, ...], bends: Mapping[str, Fraction], shares: Mapping[int, Fraction]
) -> dict[str, Fraction] | None:
    """The least weights w with `w_m >= 1/b_m + share (1/b_n + w_n)` for every edge; None where the sum has no end."""
    weights = {m: 1 / b for m, b in bends.items()}
    chosen: dict[str, int] = {}
    for _ in range(4 * len(edges) + 4):
        now = {m: k for m in bends if (k := _worst(m, edges, bends, shares, weights)) is not None}
        if now == chosen:
            return weights
        chosen = now
        solved = {m: _weight(m, chosen, edges, bends, shares) for m in bends}
        weights = {m: w for m, w in solved.items() if w is not None}
        if len(weights) < len(solved):
            return None
    return None


def _worst(
    mode: str, edges: tuple[Edge, ...], bends: Mapping[str, Fraction], shares: Mapping[int, Fraction],
    weights: Mapping[str, Fraction],
) -> int | None:  # fmt: skip
    """The edge of a mode after which most is to come."""
    own = [k for k in shares if edges[k].source == mode]
    return max(own, default=None, key=lambda k: shares[k] * (1 / bends[edges[k].target] + weights[edges[k].target]))


def _weight(
    mode: str, chosen: Mapping[str, int], edges: tuple[Edge, ...], bends: Mapping[str, Fraction],
    shares: Mapping[int, Fraction],
) -> Fraction | None:  # fmt: skip
    """The weight of a mode where each mode has one edge at most: what comes before a circle, then a geometric sum."""
    path = [mode]
    while path[-1] in chosen and (after := edges[chosen[path[-1]]].target) not in path:
        path.append(after)
    loop = path.index(edges[chosen[path[-1]]].target) if path[-1] in chosen else len(path)
    lines = [_line(m, chosen, edges, bends, shares) for m in path]
    around, factor = Q(0), Q(1)
    for plus, share in lines[loop:]:
        around, factor = around + factor * plus, factor * share
    if loop < len(path) and factor >= 1:
        return None
    weight = around / (1 - factor) if loop < len(path) else Q(0)
    for plus, share in reversed(lines[:loop]):
        weight = plus + share * weight
    return weight


def _line(
    mode: str, chosen: Mapping[str, int], edges: tuple[Edge, ...], bends: Mapping[str, Fraction],
    shares: Mapping[int, Fraction],
) -> tuple[Fraction, Fraction]:  # fmt: skip
    """What a mode adds for a unit of speed, and what is left of that after its edge."""
    if mode not in chosen:
        return 1 / bends[mode], Q(0)
    share = shares[chosen[mode]]
    return 1 / bends[mode] + share / bends[edges[chosen[mode]].target], share
