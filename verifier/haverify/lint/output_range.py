"""HA212: an output that leaves, inside its own slot, the range that a claim states for it."""

from __future__ import annotations

from collections.abc import Iterator
from fractions import Fraction

from haverify.diagnostics.diagnostic import Diagnostic, Edit, Fix, Label
from haverify.lint._claims import always_goals, conjuncts, modes_of
from haverify.lint._clock import curve
from haverify.lint._facts import Facts
from haverify.lint._registry import rule
from haverify.lint._wording import quantity
from haverify.model.claim import Claim
from haverify.model.expression import Expr, nodes, rebuild
from haverify.model.hybrid import HybridAutomaton, Mode
from haverify.model.spec import Cell, Spec
from haverify.solvers.literals import number_of
from haverify.text.record import record

Q = Fraction


@record
class Stated:
    """The range that a claim states for an output in a mode."""

    claim: Claim
    output: Expr
    mode: Mode
    low: Q
    high: Q


@record
class Bound:
    """A number below (`side` is `>`) or above (`<`) which an output stays in a mode."""

    mode: str
    side: str
    value: Q
    output: Expr


@record
class Flip:
    """A coefficient whose sign, changed alone, brings an output from `low`..`high` on."""

    cell: Cell
    low: Q
    high: Q


@rule("HA212")
def output_range(spec: Spec, facts: Facts) -> Iterator[Diagnostic]:
    """For clocks. Where a refutation is expected, only what is off by more than the range is worth a word."""
    cells = {c.constant: c for c in spec.cells}
    seen: set[tuple[str, str, str]] = set()
    for claim in spec.claims:
        automaton = facts.automata.get(claim.on or "")
        if automaton is None or claim.assume:
            continue
        for stated in _stated(facts, automaton, claim):
            key = (automaton.name, stated.mode.name, stated.output.name)
            finding = None if key in seen else _check(facts, automaton, stated, cells)
            if finding is not None:
                seen.add(key)
                yield finding


def _stated(facts: Facts, automaton: HybridAutomaton, claim: Claim) -> Iterator[Stated]:
    """Pairs of constant bounds on one output, for each mode in which their premise is true."""
    for goal in always_goals(claim):
        if goal.window is not None:
            continue
        bounds: dict[str, dict[str, list[Bound]]] = {}
        for c in conjuncts(goal.condition):
            for bound in _bounds(facts, automaton, c):
                bounds.setdefault(bound.mode, {}).setdefault(bound.output.name, []).append(bound)
        for mode in map(facts.modes(automaton).__getitem__, bounds):
            for found in bounds[mode.name].values():
                low = max((b.value for b in found if b.side == ">"), default=None)
                high = min((b.value for b in found if b.side == "<"), default=None)
                if low is not None and high is not None and low < high:
                    yield Stated(claim, found[0].output, mode, low, high)


def _bounds(facts: Facts, automaton: HybridAutomaton, e: Expr) -> Iterator[Bound]:
    """What a conjunct `output < number` says, for each mode in which it applies while dwelling."""
    applies: frozenset[str] | None = None
    while e.op == "implies":
        premise, e = e.children
        modes = modes_of(automaton, premise)
        if modes is None:
            return
        applies = modes if applies is None else applies & modes
    if e.op not in ("<", "<=", ">", ">="):
        return
    left, right = e.children
    side = e.op[0]
    if right.op == "let":
        left, right, side = right, left, "<" if side == ">" else ">"
    if left.op == "let":
        modes_by_name = facts.modes(automaton)
        for name in modes_by_name if applies is None else sorted(applies & modes_by_name.keys()):
            value = number_of(right, facts.frame(automaton, modes_by_name[name]))
            if value is not None:
                yield Bound(name, side, value, left)


def _check(facts: Facts, automaton: HybridAutomaton, stated: Stated, cells: dict[str, Cell]) -> Diagnostic | None:
    found = _range(facts, automaton, stated)
    if found is None:
        return None
    width = stated.high - stated.low
    is_gross = found[0] < stated.low - width or found[1] > stated.high + width
    expected = stated.claim.expect.verdict if stated.claim.expect else "proved"
    if expected != "proved" and not is_gross:
        return None
    expr = facts.frame(automaton, stated.mode).let(stated.output.name)
    found_cells = _coefficients(expr, cells) if expr is not None else []
    flips = [f for cell in found_cells if expr and (f := _flipped(facts, automaton, stated, expr, cell))]
    return _finding(facts, stated, found, flips[0] if len(flips) == 1 else None)


def _range(facts: Facts, automaton: HybridAutomaton, stated: Stated) -> tuple[Q, Q] | None:
    """The exact range of the output where it leaves the one stated, None where it does not or that is not known."""
    mode, name = stated.mode, stated.output.name
    key = ("curve", automaton.name, mode.name, name)
    found = facts.remembered(key, lambda: curve(facts, automaton, mode, Expr("let", (name,))))
    if found is None or _is_within(facts.remembered(("bounds", *key), found.bounds), stated):
        return None
    exact: tuple[Q, Q] = found.extremes()
    return None if _is_within(exact, stated) else exact


def _is_within(found: tuple[Q, Q], stated: Stated) -> bool:
    return stated.low <= found[0] and found[1] <= stated.high


def _coefficients(expr: Expr, cells: dict[str, Cell]) -> list[Cell]:
    names = dict.fromkeys(n.name for n in nodes(expr) if n.op == "const" and n.name in cells)
    return [cells[n] for n in names]


def _flipped(facts: Facts, automaton: HybridAutomaton, stated: Stated, expr: Expr, cell: Cell) -> Flip | None:
    """The change of sign, if it brings the output into the stated range."""
    found = curve(facts, automaton, stated.mode, _negated(expr, cell.constant))
    exact = found.extremes() if found is not None else None
    return Flip(cell, *exact) if exact is not None and _is_within(exact, stated) else None


def _negated(e: Expr, name: str) -> Expr:
    if e.op == "const" and e.name == name:
        return Expr("neg", (e,), e.unit, e.span)
    return rebuild(e, lambda child: _negated(child, name))


def _finding(facts: Facts, stated: Stated, found: tuple[Q, Q], flip: Flip | None) -> Diagnostic:
    unit, name = stated.output.unit, stated.output.name
    runs = f"`{name}` runs from {quantity(found[0], unit)} to {quantity(found[1], unit)} in mode {stated.mode.name}"
    return Diagnostic(
        "HA212",
        f"`{name}` leaves its stated range in mode {stated.mode.name}",
        span=flip.cell.span if flip else stated.output.span,
        labels=(Label(stated.output.span, "stated here"),) if flip and stated.output.span else (),
        notes=(f"{runs}; stated {quantity(stated.low, unit)} .. {quantity(stated.high, unit)} by {stated.claim.name}",),
        help=_help(flip, stated) if flip else None,
        fix=_fix(facts, flip) if flip else None,
        key=f"{stated.claim.on}: {name} leaves its stated range in mode {stated.mode.name}",
    )


def _help(flip: Flip, stated: Stated) -> str:
    unit = stated.output.unit
    changed = quantity(-flip.cell.number, None)
    return (
        f"a single change of sign brings the row into the range: {flip.cell.column} = {changed} "
        f"(then {quantity(flip.low, unit)} .. {quantity(flip.high, unit)}); no other coefficient does"
    )


def _fix(facts: Facts, flip: Flip) -> Fix | None:
    text = facts.text(flip.cell.span).strip()
    if not text:
        return None
    changed = text[1:] if text.startswith("-") else "-" + text.removeprefix("+")
    return Fix(f"change the sign of {flip.cell.column}", (Edit(flip.cell.span, changed),))
