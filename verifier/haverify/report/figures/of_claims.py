"""The figures of claims on automata: what a claim bounds over the clock, and the run that decides it."""

from __future__ import annotations

import re
from collections.abc import Callable, Sequence
from typing import Any

from haverify.report.figures import flows, lanes, maps, panels, portraits, runs
from haverify.report.figures.bands import MOST
from haverify.report.figures.curves import clock_of, curves
from haverify.report.figures.material import Figure, Json, Material, Undrawable
from haverify.report.figures.quantities import Quantity, mentioned, outputs, quantities
from haverify.report.report import Claim, Part
from haverify.report.terminal import with_unit

_PANELS = 6
_INSTANT = re.compile(r"(?:^|, )(\w+) = (-?[\d.]+(?:e[-+]?\d+)?)")


def of_claim(material: Material, c: Claim) -> list[Figure]:
    """The figures of one claim; none where nothing about it can be drawn."""
    claim, automaton = material.named("claims", c.name), material.named("automata", c.automaton)
    if any(p.kind == "piece" for p in c.parts):
        return drawn(maps.of_pieces, c)
    if material.named("systems", c.automaton) is not None:
        return drawn(lanes.of_run, c)
    if claim is None or automaton is None:
        return []
    if material.flowpipes.get(c.name, {}).get("kind") == "portrait":
        return drawn(portraits.of_leaving, material.flowpipes[c.name], c)
    if c.name in material.flowpipes:
        return drawn(flows.of_claim, material, automaton, claim, c)
    found = drawn(_bounded, material, automaton, claim, c)
    if found and c.run and len(c.run.states[0]) < 2:
        return found  # the run would show the clock alone
    return found + drawn(runs.of_run, material, automaton, c)


def drawn(draw: Callable[..., Figure | list[Figure]], *of: Any) -> list[Figure]:
    """What a function draws; nothing where that is no drawing, or the files have another shape than expected.

    The tables of a report say all there is, so a figure that is missing hides nothing.
    """
    try:
        found = draw(*of)
    except (Undrawable, ArithmeticError, LookupError, TypeError, ValueError, AttributeError, RecursionError):
        return []
    return found if isinstance(found, list) else [found]


def of_automaton(material: Material, automaton: Json) -> Figure:
    """All outputs of an automaton over its clock.

    Raises
    ------
    Undrawable      if it has none, or they are no functions of one clock
    """
    wanted = outputs(automaton)[:_PANELS]
    if not wanted or len(automaton["modes"]) > MOST:
        raise Undrawable
    svg = _draw(material, automaton, wanted, [], f"the outputs of {automaton['name']}")
    left = len(outputs(automaton)) - len(wanted)
    return Figure(
        f"outputs_{automaton['name']}",
        f"Outputs of {automaton['name']}",
        "over the clock, the modes as bands" + (f"; {left} more outputs are left out" if left else ""),
        svg,
    )


def _bounded(material: Material, automaton: Json, claim: Json, c: Claim) -> Figure:
    if len(automaton["modes"]) > MOST:
        raise Undrawable
    every = quantities(claim, automaton)
    wanted = every[:_PANELS]
    if not wanted:
        raise Undrawable
    svg = _draw(material, automaton, wanted, c.parts, f"{c.name}: {c.verdict}")
    said = [_shown(wanted)]
    said += ["violations red"] if c.verdict == "refuted" and _is_bounded(wanted) else []
    said += [f"{len(every) - len(wanted)} more quantities are left out"] if len(every) > len(wanted) else []
    return Figure(f"claim_{c.name}", f"What {c.name} is about", "; ".join(said), svg, c.name)


def _shown(wanted: Sequence[Quantity]) -> str:
    """What is drawn beside the curves."""
    if not _is_bounded(wanted):
        return "what the values are compared with dashed"
    return "bounds dashed" if any(q.bounds for q in wanted) else "the steps are what the claim bounds"


def _is_bounded(wanted: Sequence[Quantity]) -> bool:
    """Whether a claim bounds its quantities at all times, rather than compare them at some."""
    return not any(b.op == "level" for q in wanted for b in q.bounds)


def _draw(material: Material, automaton: Json, wanted: Sequence[Quantity], parts: Sequence[Part], title: str) -> str:
    clock = clock_of(material, automaton, list(wanted))
    drawn = []
    for q in wanted:
        names = set(mentioned(q.expr))
        own = [p for p in parts if p.output and names.issuperset(p.output.split(","))]
        marks = _marks(own, clock)
        lines = curves(material, automaton, q, clock)
        bad = frozenset(p.mode.partition(" (")[0] for p in own if p.verdict == "refuted")
        drawn.append(panels.Panel(q, lines, marks, bad))
    every = sorted(dict.fromkeys(c.band for p in drawn for c in p.curves), key=lambda b: (b.low, b.high))
    unit = next((v.get("unit") or "1" for v in automaton["vars"] if v["name"] == clock), "1")
    return panels.draw(drawn, every, clock, unit, title)


def _marks(parts: Sequence[Part], clock: str) -> list[panels.Mark]:
    """The instant of the smallest margin, and of every violation."""
    known = [(p, at) for p in parts if p.margin and (at := _instant(p.margin.at, clock)) is not None]
    if not known:
        return []
    worst = min(known, key=lambda found: float(found[0].margin.decimal) if found[0].margin else 0.0)
    marks = []
    for p, at in known:
        if p.verdict == "refuted" or p is worst[0]:
            text = f"margin {with_unit(p.margin)}" if p is worst[0] and p.margin else ""
            marks.append(panels.Mark(_modes(p), at, text, p.verdict == "refuted"))
    return marks


def _modes(p: Part) -> tuple[str, ...]:
    """The modes in whose bands a part's instant may lie: of a jump its target, then its source."""
    source, _, target = p.mode.partition(" (")[0].rpartition(" -> ")
    return (target, source) if source else (target,)


def _instant(at: str, clock: str) -> float | None:
    found = dict(_INSTANT.findall(at))
    return float(found[clock]) if clock in found else None
