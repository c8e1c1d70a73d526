"""Which claims a change of constants can touch: those that read one of them."""

from __future__ import annotations

from collections.abc import Iterable, Iterator

from haverify.model.claim import Claim
from haverify.model.expression import Expr, nodes
from haverify.model.hybrid import Assign, FlowLine, HybridAutomaton, Range
from haverify.model.spec import Spec


def touched(spec: Spec, constants: Iterable[str]) -> list[str]:
    """The claims that read one of the constants, in what they say or in what moves their automaton."""
    changed, automata = set(constants), {a.name: a for a in spec.automata}
    return [c.name for c in spec.claims if changed & _read(c, automata.get(c.on or ""))]


def stated(spec: Spec, claim: Claim) -> set[str]:
    """The constants in what a claim says and in what moves its automaton, those of outputs left aside."""
    automaton = next((a for a in spec.automata if a.name == claim.on), None)
    return {n.name for e in _parts(claim, automaton) for n in nodes(e) if n.op == "const"}


def _read(claim: Claim, automaton: HybridAutomaton | None) -> set[str]:
    found, seen, todo = set[str](), set[str](), _parts(claim, automaton)
    while todo:
        here = [n for e in todo for n in nodes(e)]
        found |= {n.name for n in here if n.op == "const"}
        names = {n.name for n in here if n.op == "let"} - seen
        seen |= names
        todo = list(_lets(automaton, names)) if automaton is not None else []
    return found


def _parts(claim: Claim, automaton: HybridAutomaton | None) -> list[Expr]:
    parts = [*(g.condition for g in claim.goals), *claim.assume]
    parts += [e for g in claim.goals for e in (*(g.window or ()), *([g.within] if g.within else []))]
    parts += [claim.time] if claim.time is not None else []
    return parts + (_dynamics(automaton) if automaton is not None else [])


def _lets(automaton: HybridAutomaton, names: set[str]) -> Iterator[Expr]:
    own = [o for m in automaton.modes for o in m.lets]
    yield from (o.expr for o in (*automaton.lets, *own) if o.name in names)


def _dynamics(automaton: HybridAutomaton) -> list[Expr]:
    """The expressions that decide when and where a run goes."""
    found = [e for i in automaton.init for e in (i.where, *_assigned(i.assigns))]
    found += [e for m in automaton.modes for e in (m.domain, *_assigned(m.flow))]
    found += [e for k in automaton.edges for e in (k.guard, *_assigned(k.resets))]
    found += [p.when for p in automaton.priorities]
    return found + [e for p in automaton.params for e in (p.range.low, p.range.high)]


def _assigned(lines: Iterable[Assign | FlowLine]) -> Iterator[Expr]:
    for line in lines:
        value = line.to if isinstance(line, Assign) else line.rate
        yield from (value.low, value.high) if isinstance(value, Range) else (value,)
