"""What rules about fuzzy systems share: the systems that can be unfolded, and points sought with little work."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from fractions import Fraction
from functools import partial
from typing import TYPE_CHECKING

from haverify.lint._facts import Facts
from haverify.model.expression import Expr, nodes
from haverify.model.fuzzy import FuzzyController, FuzzyRule
from haverify.model.spec import Spec

if TYPE_CHECKING:
    from haverify.analyses.fuzzy_meaning import Meaning
    from haverify.analyses.regions import Truth

NODES = 20_000
_OPS = frozenset({"fuzzyinput", "strength", "max_firing", "covered", "fuzzy"})
Premise = tuple[object, ...]


class UndecidedError(Exception):
    """Whether a truth holds somewhere was not found out."""


def unfolded(spec: Spec, facts: Facts) -> Iterator[tuple[FuzzyController, Meaning]]:
    """The fuzzy systems whose terms and inference can be unfolded, their real inputs known by name."""
    if not spec.fuzzy:
        return
    from haverify.obligations.translate import OutsideFragmentError

    for system in spec.fuzzy:
        try:
            yield system, facts.remembered(("fuzzy", system.name), partial(_meaning, spec, system.name))
        except OutsideFragmentError:
            continue  # corners out of order have a finding of their own; other inference is decided by claims


def _meaning(spec: Spec, name: str) -> Meaning:
    from haverify.analyses.fuzzy_meaning import Meaning

    meaning = Meaning(spec, name)
    at = meaning.at(name)
    for output, _ in meaning.systems.system(name).outputs:
        meaning.systems.strength(name, output, None, at)
    for i in meaning.systems.system(name).inputs:
        for term in meaning.systems.terms(name, i.name):
            meaning.systems.degree(name, i.name, term, at)
    return meaning


def somewhere(facts: Facts, code: str, system: FuzzyController, meaning: Meaning, truth: Truth) -> Point | None:
    """A point of the inputs at which a truth holds; None where there certainly is none.

    Raises
    ------
    UndecidedError             when little work does not decide it, which is noted
    """
    from haverify.analyses.regions import denied
    from haverify.analyses.regions_search import SpentError, settle

    try:
        found = settle(denied(truth), meaning.ranges, NODES)
    except SpentError:
        facts.leave_open(code, f"fuzzy system {system.name}", "more regions than lint looks at", system.span)
        raise UndecidedError from None
    return found if isinstance(found, dict) else None


Point = dict[str, Fraction]


def shown(meaning: Meaning, point: Mapping[str, Fraction]) -> str:
    """A point as text."""
    from haverify.analyses.fuzzy_telling import quantity

    return ", ".join(f"{v} = {quantity(q, meaning.units[v])}" for v, q in sorted(point.items()))


def speaks_of_fuzzy(e: Expr) -> bool:
    """Does a condition read fuzzy systems? Then the claim itself says where it cannot hold (unknown, vacuous)."""
    return any(n.op in _OPS for n in nodes(e))


def rule_name(system: FuzzyController, rule: FuzzyRule) -> str:
    """A rule's name, or its place in the list."""
    return rule.name or f"rule {system.rules.index(rule) + 1}"


def normal(e: Expr) -> Premise:
    """A premise up to the order of its parts, repetitions and double negation."""
    if e.op == "is":
        return "is", *e.args
    if e.op == "not":
        inner = normal(e.children[0])
        return inner[1] if inner[0] == "not" else ("not", inner)  # type: ignore[return-value]
    parts = {p for c in e.children for p in _flat(e.op, normal(c))}
    return (e.op, *sorted(parts, key=repr)) if len(parts) > 1 else next(iter(parts))


def _flat(op: str, p: Premise) -> Iterator[Premise]:
    if p[0] == op:
        for part in p[1:]:
            assert isinstance(part, tuple)
            yield part
    else:
        yield p
