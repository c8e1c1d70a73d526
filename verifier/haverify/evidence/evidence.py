"""What an analysis proposes about a claim: verdict, parts, certificate; `grant` decides how far it is believed."""

from __future__ import annotations

from fractions import Fraction
from typing import Any

from haverify.evidence.network_run import NetworkRun
from haverify.evidence.run import Run
from haverify.evidence.verdict import Margin, Verdict
from haverify.text.record import field, record


@record
class Sensitivity:
    """How the margin of a part depends on one constant.

    `slope` is d(margin)/d(value), `to_zero` the change that brings the margin to 0, `rounding` the share of its
    rounding box.
    """

    constant: str
    slope: Fraction
    to_zero: Fraction | None
    rounding: Fraction | None  # slope * half, the most that rounding of this constant can move the margin


@record
class PartResult:
    """A part of a claim (docs/core.md section 4) with a verdict of its own.

    `text` is the part as people read it; `extremes` are (output, low, high, instant) facts, as text, of outputs that
    leave their bounds; `constants` the constants its outputs read in that mode.
    """

    goal: int
    kind: str
    where: str
    output: str
    text: str
    verdict: Verdict
    run: Run | None = None
    facts: tuple[str, ...] = ()
    constants: tuple[str, ...] = ()
    sensitivities: tuple[Sensitivity, ...] = ()


@record
class Rounding:
    """The second verdict of a claim: for every model that rounds to the printed numbers."""

    verdict: Verdict
    margin: Margin | None


@record
class Evidence:
    """An analysis' proposal for a claim; `certificate` and `cells` are JSON values as docs/core.md section 5 has it."""

    verdict: Verdict
    parts: tuple[PartResult, ...]
    method: str
    certificate: dict[str, Any] | None = None
    cells: dict[str, dict[str, Any]] = field(default_factory=dict)  # NAME -> haverify.cells/1
    rounding: Rounding | None = None
    run: Run | None = None
    notes: tuple[str, ...] = ()
    witness: tuple[tuple[str, str], ...] = ()  # names and values that decide a claim without time
    trace: NetworkRun | None = None  # the run of a system
    flowpipe: dict[str, Any] | None = None  # haverify.flowpipe/1, to be drawn; nothing rests on it
