"""A concrete execution of a system, with exact numbers."""

from __future__ import annotations

from fractions import Fraction
from typing import Any

from haverify.maths.digits import rational_text
from haverify.text.record import record

Json = Any


@record
class Moment:
    """A state just entered, and how long (in s) the run stays.

    `names`: the interaction that led here and what else fired with it, none at the start; `modes`: of each part;
    `values`: of each variable, on entry.
    """

    names: tuple[str, ...]
    modes: tuple[tuple[str, str], ...]
    values: tuple[tuple[str, Fraction], ...]
    dwell: Fraction


@record
class NetworkRun:
    """The states of a run, from a start to the one in which it shows what it should."""

    moments: tuple[Moment, ...]
    end: tuple[tuple[str, Fraction], ...]  # the values of all variables at the last instant

    def json(self) -> dict[str, Json]:
        """The run as certificates have it (docs/core.md section 7)."""
        first = self.moments[0]
        steps = [
            {"dwell": rational_text(a.dwell), "names": list(b.names), "values": _numbers(b.values)}
            for a, b in zip(self.moments, self.moments[1:], strict=False)
        ]
        start = {"modes": dict(first.modes), "values": _numbers(first.values)}
        return {"start": start, "steps": steps, "last": rational_text(self.moments[-1].dwell)}


def _numbers(values: tuple[tuple[str, Fraction], ...]) -> dict[str, str]:
    return {n: rational_text(q) for n, q in values}
