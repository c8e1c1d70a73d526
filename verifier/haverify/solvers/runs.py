"""The simulator of the kernel: automata in floats, runs as records. Nothing a run shows is a proof."""

from __future__ import annotations

from haverify import _kernel
from haverify.maths import interval  # refuses a kernel built from other sources

Words = list[tuple[str, int]]
Operation = tuple[str, list[int], float]
# Variable, register, and another register where any value between both may be taken.
ResetListing = tuple[int, int, int | None]
# Target, urgent, enabled, resets, observed registers at the landing.
EdgeListing = tuple[int, bool, Words, list[ResetListing], list[int]]
# A formula, the operator before its members: its word, how many members or which quantity, a window.
FormulaWords = list[tuple[str, int, float, float]]
# Operations, how many move, slopes, conditions, domain, terminal, edges, observed registers, outputs.
ModeListing = tuple[list[Operation], int, list[int | None], list[Words], Words, bool, list[int], list[int], list[int]]
# Mode, state, horizon (s), limits (jumps, steps, order), policy, seed, given choices, writes (time, variable, value).
PlanListing = tuple[
    int, list[float], float, tuple[int, int, int], str, int, list[float], list[tuple[float, int, float]]
]
# Time, mode, jumps, state, outputs.
Row = tuple[float, int, int, list[float], list[float]]

Simulator = _kernel.Simulator
Record = _kernel.Record
FRESH = interval.Interval
