"""What the rules about rule tables share: the tables of a spec, and cells as readers know them."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import TYPE_CHECKING

from haverify.lint._facts import Facts
from haverify.model.cellular import CellularAutomaton
from haverify.model.spec import Spec

if TYPE_CHECKING:  # most specs have no rules: what reads them is loaded for those that do
    from haverify.solvers.finite_world import Cell, Step, World

NAMED = 4  # cells that are named in a message; all of them, up to `KEYED`, are in its key
KEYED = 64


def world_of(spec: Spec, facts: Facts) -> World:
    """The finite things of a spec, read once."""
    from haverify.solvers.finite_world import World

    return facts.remembered("finite world", lambda: World(spec))


def tables(spec: Spec, facts: Facts) -> Iterator[tuple[CellularAutomaton, dict[Cell, Step]]]:
    """Each automaton with what its lines say of each cell; without those whose codes clash."""
    if not spec.cellular:
        return
    from haverify.solvers.finite_world import NotFiniteError

    for automaton in spec.cellular:
        try:
            yield automaton, world_of(spec, facts).steps(automaton.name)
        except NotFiniteError:
            continue


def reader_name(world: World, cell: Cell) -> str:
    """`0b0110 (Left MSW)`."""
    name, _, bits = world.label(cell).rpartition(" ")
    return f"{bits.strip('()')} ({name})"


def listed(texts: Sequence[str], most: int = NAMED) -> str:
    """The first of them, and how many more there are."""
    more = len(texts) - most
    return ", ".join(texts[:most]) + (f" and {more} more" if more > 0 else "")
