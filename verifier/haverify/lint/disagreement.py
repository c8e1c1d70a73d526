"""HA505: two descriptions of one relation, compared in a claim, that disagree."""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING

from haverify.diagnostics.diagnostic import Diagnostic
from haverify.lint._facts import Facts
from haverify.lint._finite import KEYED, listed, world_of
from haverify.lint._registry import rule
from haverify.model.claim import Claim
from haverify.model.expression import Expr, nodes
from haverify.model.spec import Spec
from haverify.text.record import record

if TYPE_CHECKING:
    from haverify.solvers.finite_truth import Env, Finite

NAMED = 4


@record
class Comparison:
    """Two sides that come from different descriptions, compared where all premises hold."""

    sides: tuple[Expr, Expr]
    sources: tuple[str, str]
    premises: tuple[Expr, ...]
    bound: tuple[str, str] | None  # the name and the set of the quantifier around it


@rule("HA505")
def disagreement(spec: Spec, facts: Facts) -> Iterator[Diagnostic]:
    """`forall c in Cell: P implies next(c).sub == Text(c.sub)` says that rules and relation describe the same."""
    if not spec.cellular and not spec.relations:
        return
    from haverify.solvers.finite_truth import Finite
    from haverify.solvers.finite_world import NotFiniteError

    finite = Finite(world_of(spec, facts))
    for claim in spec.claims:
        found: dict[tuple[str, str], list[Comparison]] = {}
        for goal in claim.goals:
            if goal.kind == "holds":
                for c in _comparisons(goal.condition, (), None):
                    found.setdefault(c.sources, []).append(c)
        for sources, compared in found.items():
            try:
                yield from _finding(spec, finite, claim, sources, compared)
            except NotFiniteError:
                continue


def _comparisons(e: Expr, premises: tuple[Expr, ...], bound: tuple[str, str] | None) -> Iterator[Comparison]:
    if e.op == "and":
        for c in e.children:
            yield from _comparisons(c, premises, bound)
    elif e.op == "implies":
        yield from _comparisons(e.children[1], (*premises, e.children[0]), bound)
    elif e.op == "forall" and bound is None and not premises:
        yield from _comparisons(e.children[0], (), (e.name, str(e.args[1])))
    elif e.op == "==":
        a, b = e.children
        first, second = _source(a), _source(b)
        if first and second and first != second:
            yield Comparison((a, b), (first, second), premises, bound)


def _source(e: Expr) -> str | None:
    """The one automaton or relation that a term reads."""
    names = {n.name for n in nodes(e) if n.op in ("next", "apply")}
    return names.pop() if len(names) == 1 else None


def _finding(
    spec: Spec, finite: Finite, claim: Claim, sources: tuple[str, str], compared: list[Comparison]
) -> Iterator[Diagnostic]:
    from haverify.elaborate.notation import Notation

    write = Notation({(e.name, v): v for e in spec.enums for v in e.values}).text
    told, keys, count = [], [], 0
    for c in compared:
        for env in _places(finite, c):
            a, b = (finite.value(s, env) for s in c.sides)
            if a is None or b is None:
                continue
            count += 1
            if a != b:
                cell = next((finite.world.label(v) for v in env.values()), "")
                x, y = (f"{write(s)} is {finite.world.label(v)}" for s, v in zip(c.sides, (a, b), strict=True))
                told.append(f"{cell}: {x}, {y}" if cell else f"{x}, {y}")
                keys.append(cell or write(c.sides[0]))
    if told:
        first, second = sources
        yield Diagnostic(
            "HA505",
            f"{first} and {second} disagree for {len(told)} of {count}: {told[0]}",
            span=claim.span,
            notes=tuple(told[1:NAMED]) + ((f"and {len(told) - NAMED} more",) if len(told) > NAMED else ()),
            key=f"{first} and {second} disagree: {listed(keys, KEYED)}",
        )


def _places(finite: Finite, c: Comparison) -> Iterator[Env]:
    """The values of the bound name for which all premises hold."""
    if c.bound is None:
        if all(finite.truth(p, {}) is True for p in c.premises):
            yield {}
        return
    name, of = c.bound
    for cell in finite.world.cells(of).cells:
        if all(finite.truth(p, {name: cell}) is True for p in c.premises):
            yield {name: cell}
