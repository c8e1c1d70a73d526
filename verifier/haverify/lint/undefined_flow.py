"""HA403: a flow that is undefined, or not Lipschitz, somewhere in its domain."""

from __future__ import annotations

from collections.abc import Iterator

from haverify.diagnostics.diagnostic import Diagnostic, Label
from haverify.lint._facts import Facts
from haverify.lint._registry import rule
from haverify.lint._wording import mentioned, point_text
from haverify.model.expression import Expr, nodes, number
from haverify.model.hybrid import HybridAutomaton, Mode
from haverify.model.spec import Spec
from haverify.solvers.answer import Holds
from haverify.solvers.conditions import Condition
from haverify.solvers.frame import Frame

_ORDER = ("<", "<=", ">", ">=")


@rule("HA403")
def undefined_flow(spec: Spec, facts: Facts) -> Iterator[Diagnostic]:
    """Divisors that may be 0, arguments outside a function's domain, switches that jump at their boundary."""
    for automaton in spec.automata:
        for mode in automaton.modes:
            for line in mode.flow:
                rates = (line.rate,) if isinstance(line.rate, Expr) else (line.rate.low, line.rate.high)
                for rate in rates:
                    yield from _check(facts, automaton, mode, rate, ())


def _check(
    facts: Facts, automaton: HybridAutomaton, mode: Mode, rate: Expr, branch: tuple[Condition, ...]
) -> Iterator[Diagnostic]:
    """The faults of an expression in the branches of `if` that lead to it, lets looked into."""
    frame = facts.frame(automaton, mode)
    for trouble, what in _troubles(rate):
        yield from _decide(facts, automaton, mode, rate, (Condition(trouble, frame), *branch), what)
    if rate.op == "let":
        inner = frame.let(rate.name)
        yield from _check(facts, automaton, mode, inner, branch) if inner is not None else ()
    elif rate.op == "if":
        condition, yes, no = rate.children
        yield from _switch(facts, automaton, mode, rate, frame)
        yield from _check(facts, automaton, mode, yes, (*branch, Condition(condition, frame)))
        yield from _check(facts, automaton, mode, no, (*branch, Condition(condition, frame, holds=False)))
    else:
        for child in rate.children:
            yield from _check(facts, automaton, mode, child, branch)


def _troubles(e: Expr) -> Iterator[tuple[Expr, str]]:
    """Conditions under which the value of this node is undefined or its slope unbounded."""
    if e.op == "/" and _varies(e.children[1]):
        yield Expr("==", (e.children[1], number(0))), "the divisor is 0"
    if e.op == "sqrt" and _varies(e.children[0]):
        yield Expr("<=", (e.children[0], number(0))), "the root has no finite slope"
    if e.op == "log" and _varies(e.children[0]):
        yield Expr("<=", (e.children[0], number(0))), "the logarithm is undefined"


def _varies(e: Expr) -> bool:
    return any(n.op in ("var", "param", "input", "let", "time") for n in nodes(e))


def _switch(facts: Facts, automaton: HybridAutomaton, mode: Mode, e: Expr, frame: Frame) -> Iterator[Diagnostic]:
    """An `if` on one comparison of continuous values whose branches differ where its two sides are equal."""
    condition, yes, no = e.children
    if condition.op not in _ORDER or not _is_continuous(facts, automaton, condition):
        return
    boundary = Condition(Expr("==", condition.args), frame)
    differ = Condition(Expr("!=", (yes, no)), frame)
    yield from _decide(facts, automaton, mode, e, (boundary, differ), "the branches of `if` differ on its boundary")


def _is_continuous(facts: Facts, automaton: HybridAutomaton, e: Expr) -> bool:
    scope = facts.scope(automaton)
    named = [scope.vars[n.name] for n in nodes(e) if n.op == "var" and n.name in scope.vars]
    return any(v.type == "real" for v in named) or any(n.op in ("let", "time") for n in nodes(e))


def _decide(
    facts: Facts, automaton: HybridAutomaton, mode: Mode, e: Expr, conditions: tuple[Condition, ...], what: str
) -> Iterator[Diagnostic]:
    frame = facts.frame(automaton, mode)
    windows = [Condition(w, frame) for w in _windows(facts, automaton)]
    domain = Condition(mode.domain, frame, closed=True)
    answer = facts.decide("HA403", f"mode {mode.name}", e.span, [domain, *windows, *conditions])
    if isinstance(answer, Holds) and answer.is_exact:
        at = point_text(answer.point, facts.scope(automaton), _involved(facts, automaton, mode, e))
        yield Diagnostic(
            "HA403",
            f"mode {mode.name}: {what}" + (f" at {at}" if at else ""),
            span=e.span,
            labels=(Label(mode.span),) if mode.span and e.span is None else (),
            notes=("this point lies in the domain and in the declared ranges of the variables and params",),
            help="narrow the domain or a range so that the point is left out",
            key=f"{automaton.name}, mode {mode.name}: {what} in `{facts.text(e.span)}`",
        )


def _windows(facts: Facts, automaton: HybridAutomaton) -> Iterator[Expr]:
    """The declared ranges of the variables."""
    for v in facts.scope(automaton).vars.values():
        if v.range is not None:
            var = Expr("var", (v.name,))
            yield Expr("and", (Expr("<=", (v.range.low, var)), Expr("<=", (var, v.range.high))))


def _involved(facts: Facts, automaton: HybridAutomaton, mode: Mode, e: Expr) -> list[str]:
    """The names an expression depends on, through one level of lets."""
    frame = facts.frame(automaton, mode)
    lets = [inner for n in nodes(e) if n.op == "let" and (inner := frame.let(n.name)) is not None]
    return [name for part in (e, *lets) for name in mentioned(part)]
