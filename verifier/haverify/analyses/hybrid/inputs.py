"""What drives a flow from outside: inputs, and rates that inclusions leave open, at each instant a value of a range."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from fractions import Fraction
from itertools import product

from haverify.analyses.hybrid.model import HybridModel
from haverify.model.expression import Expr, nodes
from haverify.model.hybrid import Input, Mode, Range
from haverify.obligations.residual import Situation, residual
from haverify.obligations.translate import OutsideFragmentError
from haverify.text.record import record

Q = Fraction
Chosen = Mapping[str, tuple[Q, Q]]
MOST_CORNERS = 3  # quantities


@record
class Driven:
    """Any measurable function of time from `low` to `high`; constant ones are tried where they are admissible.

    The rate of an input may not allow them; a share of an inclusion is one only where `order` is not negative.
    """

    name: str
    low: Q
    high: Q
    may_be_constant: bool = True
    order: Expr | None = None


def fields(model: HybridModel, mode: Mode) -> tuple[dict[str, Expr], list[Driven]]:
    """The rates in a mode, and what drives them: inputs, and for each inclusion a rate or a share of its width.

    Raises
    ------
    OutsideFragmentError    if the range of an input or an inclusion is empty or no range of numbers
    """
    rates, driven = dict[str, Expr](), dict[str, Driven]()
    at = Situation(model.places[model.mode(mode.name)].mode)
    for line in mode.flow:
        if isinstance(line.rate, Range):
            rates[line.var], left_open = _included(model, at, f"{line.var}'", line.rate)
            driven[left_open.name] = left_open
        else:
            rates[line.var] = residual(line.rate, at)
    declared = {i.name: i for i in (*model.spec.inputs, *model.automaton.inputs)}
    for name in sorted(_inputs(model, mode, rates.values())):
        if name in declared:
            driven[name] = _input(model, declared[name])
    return rates, list(driven.values())


def _included(model: HybridModel, at: Situation, name: str, line: Range) -> tuple[Expr, Driven]:
    """A rate between two expressions; where these are numbers it is driven itself."""
    free = Expr("input", (name,))
    try:
        first, last = model.values.interval(line)
    except OutsideFragmentError:
        free = Expr("input", (share := f"share of the range of {name}",))
        low, high = (residual(e, at) for e in (line.low, line.high))
        half = Expr("num", (Q(1, 2),))
        middle, width = (Expr("*", (half, Expr(op, (high, low)))) for op in "+-")
        return Expr("+", (middle, Expr("*", (width, free)))), Driven(share, Q(-1), Q(1), order=Expr("-", (high, low)))
    if first > last:
        raise OutsideFragmentError(f"a rate between {first} and {last}, of which there is none") from None
    return free, Driven(name, first, last)


def _inputs(model: HybridModel, mode: Mode, rates: Iterable[Expr]) -> set[str]:
    """The inputs that rates read, directly or through lets."""
    known = model.definitions[model.mode(mode.name)]
    waiting, found, seen = list(rates), set[str](), set[str]()
    while waiting:
        for n in nodes(waiting.pop()):
            if n.op == "input":
                found.add(n.name)
            elif n.op == "let" and n.name not in seen and ("let", n.name) in known:
                seen.add(n.name)
                waiting.append(known["let", n.name])
    return found


def _input(model: HybridModel, declared: Input) -> Driven:
    if declared.range is None or declared.type != "real":
        raise OutsideFragmentError(f"the input `{declared.name}` without a range of numbers")
    low, high = model.values.interval(declared.range)
    if low > high:
        raise OutsideFragmentError(f"the input `{declared.name}` between {low} and {high}, of which there is none")
    rates = model.values.interval(declared.rate) if declared.rate is not None else (Q(0), Q(0))
    return Driven(declared.name, low, high, may_be_constant=rates[0] <= 0 <= rates[1])


def choices(model: HybridModel) -> Iterator[Chosen]:
    """Constant choices of all that drives some mode: middles, then corners; where nothing is driven, none is needed."""
    driven = list({d.name: d for m in model.modes for d in fields(model, m)[1]}.values())
    if not all(d.may_be_constant for d in driven):
        return
    yield {d.name: ((d.low + d.high) / 2,) * 2 for d in driven}
    if 0 < len(driven) <= MOST_CORNERS:
        for ends in product(*((d.low, d.high) for d in driven)):
            yield {d.name: (q, q) for d, q in zip(driven, ends, strict=True)}
