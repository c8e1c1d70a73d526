"""A concrete execution: a counterexample, or the witness of `can reach`. Start and choices are exact numbers."""

from __future__ import annotations

from fractions import Fraction

from haverify.text.record import record


@record
class Step:
    """Dwell for `dwell` seconds, then take edge number `edge`; `values` are those chosen by set-valued resets."""

    dwell: Fraction
    edge: int
    values: tuple[tuple[str, Fraction], ...] = ()


@record
class Passage:
    """An instant of a run along flows, enclosed: the mode, the edge that led there, ends of time and of values."""

    mode: str
    edge: str | None
    time: tuple[float, float]
    values: tuple[tuple[str, float, float], ...]


@record
class Run:
    """A run that starts in `mode` with `values` under `params`, makes `steps` and dwells `last` seconds more.

    Along flows only enclosures are known: `path` has the start, each landing and the end, and the dwells are numbers
    inside their enclosures. Elsewhere it is empty and the dwells are exact.
    """

    mode: str
    values: tuple[tuple[str, Fraction], ...]
    params: tuple[tuple[str, Fraction], ...]
    steps: tuple[Step, ...]
    last: Fraction
    path: tuple[Passage, ...] = ()
