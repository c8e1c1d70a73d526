"""The known name that a misspelt one most likely means."""

from __future__ import annotations

from collections.abc import Iterable


def nearest(name: str, known: Iterable[str]) -> str | None:
    """The known name that is one slip away, for longer names two; else one that differs in capitals only."""
    allowed = 0 if len(name) < 2 or len(name) > 60 else 1 if len(name) < 5 else 2
    candidates = sorted({k for k in known if abs(len(k) - len(name)) <= allowed and k != name})
    best = min(((slips(name, k), k) for k in candidates), default=(allowed + 1, ""))
    if best[0] <= allowed:
        return best[1]
    return next((k for k in candidates if k.lower() == name.lower()), None)


def slips(a: str, b: str) -> int:
    """How many letters must be inserted, left out, replaced or swapped with their neighbour to turn `a` into `b`."""
    before: list[int] = []
    row = list(range(len(b) + 1))
    for i, x in enumerate(a, 1):
        older, before, row = before, row, [i]
        for j, y in enumerate(b, 1):
            cost = min(before[j] + 1, row[j - 1] + 1, before[j - 1] + (x != y))
            if i > 1 and j > 1 and x == b[j - 2] and a[i - 2] == y:
                cost = min(cost, older[j - 2] + 1)
            row.append(cost)
    return row[-1]
