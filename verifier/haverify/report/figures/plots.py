"""All figures of a report, from its files alone: of the model first, then claim by claim."""

from __future__ import annotations

import json
from collections.abc import Iterator

from haverify.report.figures import fuzzy, graphs, of_claims, orbits
from haverify.report.figures.material import Figure, Json, Material
from haverify.report.figures.of_claims import drawn
from haverify.report.report import Report

_AUTOMATA = 8


def of_model(material: Material) -> list[Figure]:
    """Mode graphs and outputs of the automata, orbits of the rules, terms and conclusions of the fuzzy systems."""
    return list(_of_model(material))


def _of_model(material: Material) -> Iterator[Figure]:
    seen = set[str]()
    for automaton in material.listed("automata")[:_AUTOMATA]:
        if _shape(automaton) in seen:
            continue  # the same with other constants
        seen.add(_shape(automaton))
        yield from drawn(graphs.of_automaton, automaton)
        yield from drawn(of_claims.of_automaton, material, automaton)
    for rule in material.listed("cellular"):
        yield from drawn(orbits.of_rule, material, rule)
    systems = fuzzy.chain(material)
    for system in material.listed("fuzzy"):
        yield from drawn(fuzzy.memberships, system)
        yield from drawn(fuzzy.conclusions, systems, system)


def _shape(automaton: Json) -> str:
    """What the figures of an automaton are drawn from, constants aside."""
    modes, edges = automaton.get("modes", []), automaton.get("edges", [])
    if not isinstance(modes, list) or not isinstance(edges, list):
        return ""
    told = [[m.get(key) for key in ("name", "domain", "lets")] for m in modes if isinstance(m, dict)]
    ends = [[e.get(key) for key in ("name", "source", "target", "guard")] for e in edges if isinstance(e, dict)]
    try:
        return json.dumps([told, ends, automaton.get("lets"), automaton.get("init")])
    except RecursionError:
        return ""


def every(report: Report, material: Material) -> list[Figure]:
    """The figures of the model and of all claims."""
    return of_model(material) + [f for c in report.claims for f in of_claims.of_claim(material, c)]
