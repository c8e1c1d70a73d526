"""Verdicts: proved, refuted or unknown; how they are trusted; what margin they keep."""

from __future__ import annotations

from enum import IntEnum
from fractions import Fraction

from haverify.text.record import record


class Trust(IntEnum):
    """Who must be right for a verdict to be right; a claim has its weakest part's."""

    SOLVER = 1
    ENCLOSED = 2
    CHECKED = 3


@record
class Margin:
    """Signed distance to the bound, `low <= margin <= high`, in `unit`; `at` says where it occurs, for people.

    `strict` tells a margin of zero that violates a strict bound from one that meets a closed bound.
    """

    low: Fraction
    high: Fraction
    unit: str
    at: str = ""
    strict: bool = False


@record
class Proved:
    """True on every admissible run (`can reach`: on some run), by the evidence named beside it."""

    margin: Margin | None = None
    trust: Trust | None = None


@record
class Refuted:
    """False on one admissible run, which is in the evidence."""

    margin: Margin | None = None
    trust: Trust | None = None


@record
class Unknown:
    """Not decided: `kind` is a word scripts can test, `reason` is for people.

    Kinds are vacuous, budget, fragment, grade, window, jumps, dependency and others.
    """

    kind: str
    reason: str
    reached: str = ""
    nearest: str = ""
    next_step: str = ""


Verdict = Proved | Refuted | Unknown
