"""`sample n every T do ...`: a hidden clock and in every mode a self-edge that resets it."""

from __future__ import annotations

from haverify.elaborate import arithmetic as A
from haverify.elaborate.declare import Entries
from haverify.elaborate.expressions import Env, interval, seconds
from haverify.elaborate.resets import resets
from haverify.elaborate.scope import SetValue, Symbol
from haverify.elaborate.units import to_unit
from haverify.model.expression import Expr, number
from haverify.model.hybrid import Assign, Edge, FlowLine, Variable
from haverify.model.unit import SECOND
from haverify.syntax import tree as t
from haverify.text.record import record
from haverify.text.span import Span


@record
class Clock:
    """The hidden clock of a sample: fires from `low` on, at the latest at `high`."""

    name: str
    var: str
    low: Expr
    high: Expr
    is_exact: bool
    decl: t.Sample
    domain: Expr
    flow: FlowLine
    start: Assign
    span: Span


def clock_of(entries: Entries, sample: t.Sample) -> Clock:
    """Enter the clock of a sample as a variable."""
    env = entries.env
    low, high, is_exact = _period(env, sample)
    unit = None if env.ctx.unitless else SECOND
    name = f"{sample.name}_clock"
    while name in env.scope.names or name in env.ctx.shared:
        name += "_2"
    symbol = Symbol("var", name, sample.span, unit=unit, used=True)
    env.scope.names[name] = symbol
    entries.symbols.append(symbol)
    entries.models[symbol] = Variable(name, "real", unit, None, sample.span)
    x = Expr("var", (name,), unit, sample.span)
    zero = number(0, unit, sample.span)
    one = number(1, env.ctx.one, sample.span)
    return Clock(sample.name, name, low, high, is_exact, sample, A.compare("<=", x, high, sample.span),
                 FlowLine(name, one, sample.span), Assign(name, zero, sample.span), sample.span)  # fmt: skip


def _period(env: Env, sample: t.Sample) -> tuple[Expr, Expr, bool]:
    node = sample.period
    while isinstance(node, t.Paren):
        node = node.inner
    if isinstance(node, t.Interval) or (isinstance(node, t.Binary) and node.op == "+-"):
        found: SetValue = interval(env, node)
        target = None if env.ctx.unitless else SECOND
        ends = [to_unit(env.ctx, e, target, "a period", node.span) for e in (found.range.low, found.range.high)]
        return ends[0], ends[1], False
    period = seconds(env, node, "a period")
    return period, period, True


def sample_edge(env: Env, clock: Clock, mode: str) -> Edge:
    """The self-edge of a sample in one mode."""
    x = Expr("var", (clock.var,), clock.low.unit, clock.span)
    guard = A.compare(">=", x, clock.low, clock.span)
    assigns = (clock.start, *resets(env, clock.decl.assignments))
    return Edge(clock.name, mode, mode, clock.is_exact, guard, assigns, clock.span)
