"""A goal that one start never meets: the automaton from that start alone, where the negation always holds."""

from __future__ import annotations

from collections.abc import Mapping
from fractions import Fraction
from typing import Any

from haverify.model.claim import Claim, Goal
from haverify.model.expression import Expr
from haverify.model.hybrid import Assign, HybridAutomaton, Init, Param, Range
from haverify.model.spec import Spec
from haverify.text.record import replace

Q = Fraction
Json = Any


def alone(
    spec: Spec, automaton: HybridAutomaton, mode: str, values: Mapping[str, Q], params: Mapping[str, Q]
) -> tuple[Spec, HybridAutomaton]:
    """The spec in which an automaton starts in one state only, with these values of params."""
    assigns = tuple(Assign(v.name, _number(values[v.name])) for v in automaton.vars)
    line = Init(mode, Expr("true"), assigns)
    own = replace(automaton, init=(line,), params=tuple(_fixed(p, params) for p in automaton.params))
    named = {p.name for p in automaton.params}
    top = tuple(p if p.name in named else _fixed(p, params) for p in spec.params)
    automata = tuple(own if a is automaton else a for a in spec.automata)
    return replace(spec, params=top, automata=automata), own


def _fixed(p: Param, params: Mapping[str, Q]) -> Param:
    if p.name not in params:
        return p
    q = _number(params[p.name])
    return replace(p, range=Range(q, q))


def _number(q: Q) -> Expr:
    return Expr("num", (q,))


def missed(claim: Claim, goal: Goal) -> tuple[Claim, Goal]:
    """The claim that a goal to be reached never is, up to where it had to be."""
    never = replace(goal, kind="always", condition=Expr("not", (goal.condition,)))
    return replace(claim, goals=(never,), time=None, jumps=None, using=(), inductive=False), never


def numbers(start: Json) -> dict[str, Q] | None:
    """The numbers of a start; None where one of them is no rational."""
    told = {**start["values"], **start["params"]}
    return {n: Q(x) for n, x in told.items()} if all(isinstance(x, str) for x in told.values()) else None
