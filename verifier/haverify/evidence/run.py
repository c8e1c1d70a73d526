"""A concrete execution with exact numbers: a counterexample, or the witness of `can reach`."""

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
class Run:
    """A run that starts in `mode` with `values` under `params`, makes `steps` and dwells `last` seconds more."""

    mode: str
    values: tuple[tuple[str, Fraction], ...]
    params: tuple[tuple[str, Fraction], ...]
    steps: tuple[Step, ...]
    last: Fraction
