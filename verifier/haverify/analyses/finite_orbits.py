"""Where the rules of an automaton lead in the long run: cycles, ways into them, cells without a next one."""

from __future__ import annotations

from collections import Counter

from haverify.solvers.finite_world import Cell, World
from haverify.text.record import record

LISTED = 4


@record
class Orbits:
    """The cycles in order of their first cell; cells that lead into one, that nothing leads to, that lead nowhere."""

    cycles: tuple[tuple[Cell, ...], ...]
    tails: tuple[Cell, ...]
    unreached: tuple[Cell, ...]
    dead: tuple[Cell, ...]


def orbits_of(world: World, automaton: str) -> Orbits:
    """The orbits of an automaton; its successor relation is a partial function, so every orbit ends or cycles."""
    follow = {c: s.target for c, s in world.steps(automaton).items()}
    cycles: list[tuple[Cell, ...]] = []
    seen: set[Cell] = set()
    for start in follow:
        path: dict[Cell, None] = {}
        at: Cell | None = start
        while at is not None and at not in seen:
            seen.add(at)
            path[at] = None
            at = follow[at]
        if at in path:
            way = list(path)
            cycles.append(tuple(way[way.index(at) :]))
    cyclic = {c for cycle in cycles for c in cycle}
    targets = set(follow.values())
    tails = tuple(c for c in follow if c not in cyclic and follow[c] is not None)
    unreached = tuple(c for c in follow if c not in targets)
    return Orbits(tuple(cycles), tails, unreached, tuple(c for c, t in follow.items() if t is None))


def orbits(world: World, automaton: str) -> str:
    """The orbits in a sentence: `16 cells, 8 cycles of 2 cells; every cell has a next one and one before it`."""
    found = orbits_of(world, automaton)
    lengths = sorted(Counter(map(len, found.cycles)).items())
    cycles = ", ".join(f"{n} cycle{'s' * (n > 1)} of {k} cell{'s' * (k > 1)}" for k, n in lengths) or "no cycle"
    parts = [f"{automaton}: {len(world.steps(automaton))} cells, {cycles}"]
    for what, cells in (("on the way to a cycle or an end", found.tails), ("with none before", found.unreached),
                        ("without a next one", found.dead)):  # fmt: skip
        if cells:
            named = ", ".join(world.label(c) for c in cells[:LISTED]) + (", ..." if len(cells) > LISTED else "")
            parts.append(f"{len(cells)} {what}: {named}")
    whole = not (found.tails or found.unreached or found.dead)
    return "; ".join([*parts, "each cell has one cell before it"] if whole else parts)
