"""What the claims on one automaton share: cells, ranges, runs, hashes; each computed when first asked for."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from fractions import Fraction
from functools import cached_property
from typing import Any

from haverify.analyses.cell import Cell
from haverify.analyses.clock_model import ClockModel, clock_model
from haverify.analyses.clocked import Cells, explore
from haverify.analyses.motion import Motion, State
from haverify.analyses.poly_range import Ranges
from haverify.analyses.questions import rounding_box, symbolic_model
from haverify.analyses.violation import Explorers
from haverify.evidence.certificate import end_json, start_json
from haverify.model.expression import Expr
from haverify.model.hybrid import HybridAutomaton
from haverify.model.spec import Spec
from haverify.obligations.formula import literals
from haverify.obligations.obligation import Hashes, hashes
from haverify.obligations.translate import OutsideFragmentError
from haverify.text.record import field, holder

Q = Fraction
Json = Any


@holder
class Context:
    """One automaton of a spec, as the analyses see it.

    Raises
    ------
    OutsideFragmentError    by `model`, where the automaton is not clock-driven
    """

    spec: Spec
    automaton: HybridAutomaton
    core: Mapping[str, Json] | None = None
    ranges: Ranges = field(default_factory=Ranges)
    _cells: dict[tuple[Q | None, int | None], Cells] = field(default_factory=dict)

    starts: dict[tuple[Expr, ...], tuple[State, dict[str, Q]] | None] = field(default_factory=dict)
    instants: dict[str, Q] = field(default_factory=dict)  # by claim: up to when its goals need cells
    # What the flowpipe analysis shares among claims: `hybrid.shared.Trees`, once there are any.
    trees: Any = None
    _values: dict[tuple[Q | None, int | None], Json] = field(default_factory=dict)

    @cached_property
    def model(self) -> ClockModel:
        """The automaton, compiled."""
        return clock_model(self.spec, self.automaton)

    @cached_property
    def hashes(self) -> Hashes:
        """The hashes of its obligations."""
        return hashes(self.spec, self.automaton, self.core)

    @cached_property
    def explorers(self) -> Explorers:
        """Its runs, as far as they were followed."""
        return Explorers(self.model)

    def cells(self, time: Q | None = None, jumps: int | None = None) -> Cells:
        """The cells up to a horizon."""
        if (time, jumps) not in self._cells:
            self._cells[time, jumps] = explore(self.model, time, jumps)
        return self._cells[time, jumps]

    def cells_value(self, found: Cells) -> Json:
        """The file of cells as a JSON value, one for all claims that rest on them."""
        key = (found.time, found.jumps)
        if key not in self._values:
            self._values[key] = cells_json(found)
        return self._values[key]

    def known_cells(self) -> Iterator[tuple[tuple[Q | None, int | None], Cells]]:
        """All cells computed so far, with their horizons."""
        yield from self._cells.items()

    @cached_property
    def rounding(self) -> dict[str, tuple[Q, Q]]:
        """The boxes of the constants that were printed with limited digits."""
        return rounding_box(self.model)

    @cached_property
    def rounded(self) -> ClockModel | None:
        """The automaton with those constants left open, None where its cells would depend on them."""
        names = frozenset(self.rounding)
        model = symbolic_model(self.model, names)
        try:
            for i in range(len(self.automaton.modes)):
                if any(names & set(leaf.polynomial.variables) for leaf in literals(model.mode(i).domain)):
                    return None
            for k in range(len(self.automaton.edges)):
                edge = model.edge(k)
                read = {v for leaf in literals(edge.guard) for v in leaf.polynomial.variables}
                read |= {v for r in edge.resets.values() for p in (r.low, r.high) for v in p.variables}
                if names & read:
                    return None
        except OutsideFragmentError:
            return None
        return model

    @cached_property
    def open_constants(self) -> ClockModel:
        """The automaton with every number among its constants left open, for sensitivities."""
        names = [n for n, c in self.model.values.constants.items() if c.type == "real"]
        return symbolic_model(self.model, frozenset(names))

    def start(self, params: Mapping[str, Q]) -> State | None:
        """An admissible start under these params."""
        return next(Motion(self.model, params).starts(), None)


def cells_name(automaton: str, time: Q | None, jumps: int | None) -> str:
    """The name of a file of cells: `Gait`, `Gait-2s`, `Gait-3-jumps`."""
    name = automaton
    if time is not None:
        name += "-" + end_text(time) + "s"
    if jumps is not None:
        name += f"-{jumps}-jumps"
    return name


def end_text(q: Q) -> str:
    """A number as part of a file name."""
    return str(q).replace("/", "_")[:60]


def cells_json(found: Cells, meets: Mapping[int, Q] | None = None) -> Json:
    """The cells as their file holds them."""
    meets = meets or {}
    return {
        "schema": "haverify.cells/1",
        "automaton": found.model.automaton.name,
        "rho": found.tracked,
        "time": end_json(found.time) if found.tracked else None,
        "jumps": found.jumps,
        "cells": [_cell_json(found, c, meets.get(i)) for i, c in enumerate(found.cells)],
    }


def _cell_json(found: Cells, cell: Cell, meet: Q | None) -> Json:
    value: dict[str, Json] = {
        "mode": found.model.automaton.modes[cell.mode].name,
        "entry": {v: [end_json(x.low), end_json(x.high)] for v, x in cell.entry.items()},
        "dwell": end_json(cell.dwell),
    }
    if cell.sigma is not None:
        value["sigma"] = [end_json(cell.sigma.low), end_json(cell.sigma.high)]
    if cell.jumps is not None:
        value["jumps"] = cell.jumps
    if meet is not None:
        value["meet"] = end_json(meet)
    return value


def state_json(model: ClockModel, state: State, params: Mapping[str, Q]) -> Json:
    """A start, as certificates name it."""
    return start_json(model.automaton.modes[state.mode].name, state.values, params)
