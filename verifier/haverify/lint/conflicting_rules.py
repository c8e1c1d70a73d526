"""HA502: rules that send one cell to different cells."""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING

from haverify.diagnostics.diagnostic import Diagnostic, Label
from haverify.lint._facts import Facts
from haverify.lint._finite import reader_name, tables, world_of
from haverify.lint._registry import rule
from haverify.model.cellular import CellularAutomaton
from haverify.model.spec import Spec

if TYPE_CHECKING:
    from haverify.solvers.finite_world import Cell, Step, World


@rule("HA502")
def conflicting_rules(spec: Spec, facts: Facts) -> Iterator[Diagnostic]:
    """One finding for each cell; a formula beside rules is one more rule."""
    for automaton, steps in tables(spec, facts):
        for cell, step in steps.items():
            if len(set(step.results)) > 1:
                yield _finding(world_of(spec, facts), automaton, cell, step)


def _finding(world: World, automaton: CellularAutomaton, cell: Cell, step: Step) -> Diagnostic:
    other = next(k for k, target in enumerate(step.results) if target != step.results[0])
    first, second = (reader_name(world, step.results[k]) for k in (0, other))
    by_rule = other < len(step.rules)
    return Diagnostic(
        "HA502",
        f"{automaton.name}: {'rules send' if by_rule else 'a rule and next() send'} {reader_name(world, cell)} "
        f"to different cells, {first} and {second}",
        span=step.rules[other].span if by_rule else step.rules[0].span,
        label=f"to {second}" if by_rule else f"to {first}",
        labels=tuple(Label(r.span, f"to {first}") for r in step.rules[:1] if r.span and by_rule),
        key=f"{automaton.name}: {cell[1]} leads to {step.results[0][1]} and {step.results[other][1]}",
    )
