"""What an expression means where it stands: each kind of node is read by the function registered for it."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, TypeVar

from haverify.diagnostics.diagnostic import Severity
from haverify.elaborate import arithmetic as A
from haverify.elaborate.context import Context
from haverify.elaborate.scope import Cases, Row, Scope, SetValue, Symbol, Typed
from haverify.elaborate.units import to_unit
from haverify.model.expression import Expr
from haverify.model.unit import Unit
from haverify.syntax import tree as t
from haverify.text.record import record, replace
from haverify.text.span import Span


@record
class Env:
    """Where an expression stands: its scope, and what may occur in it besides values.

    `is_claim`: `jump`, `jumped`, `pre`, `der`, `stuck` have a meaning; `is_stl`: temporal operators too.
    `split` makes one expression of its values in the modes of a family, where no mode is given.
    """

    ctx: Context
    scope: Scope
    is_claim: bool = False
    is_stl: bool = False
    split: Callable[[Env, t.Expr, Symbol], Expr] | None = None

    def bind(self, **values: Typed) -> Env:
        """The same place with local names."""
        return replace(self, scope=self.scope.bind(values))


Found = Typed | Symbol | Row | SetValue | Cases


Reader = Callable[[Env, Any, str | None], Typed]
R = TypeVar("R", bound=Reader)

_READERS: dict[type, Reader] = {}


def reads(*kinds: type) -> Callable[[R], R]:
    """Register the function that reads nodes of some kinds; `expressions` imports all modules that have such."""

    def register(reader: R) -> R:
        _READERS.update(dict.fromkeys(kinds, reader))
        return reader

    return register


def typed(env: Env, node: t.Expr, expect: str | None = None) -> Typed:
    """The value of an expression; a bare name is first looked for in the enumeration `expect`."""
    while type(node) is t.Paren:
        node = node.inner
    return _READERS[type(node)](env, node, expect)


def real(env: Env, node: t.Expr) -> Expr:
    """The value of an expression that must be a number."""
    e, type_ = typed(env, node)
    if not env.ctx.is_number(type_):
        env.ctx.fail("HA105", f"a number is needed here, this is {type_phrase(env.ctx, type_)}", node.span)
    return e


def boolean(env: Env, node: t.Expr) -> Expr:
    """The value of an expression that must be a truth value."""
    e, type_ = typed(env, node)
    if type_ != "bool":
        env.ctx.fail("HA105", f"a truth value is needed here, this is {type_phrase(env.ctx, type_)}", node.span)
    return e


def of_type(env: Env, node: t.Expr, type_: str, unit: Unit | None, what: str, code: str = "HA101") -> Expr:
    """The value of an expression that must have a type and, if a number, fit a unit."""
    e, found = typed(env, node, type_ if type_ != "real" else None)
    both_numbers = env.ctx.is_number(type_) and env.ctx.is_number(found)
    if found != type_ and not both_numbers:
        env.ctx.fail(
            "HA105", f"{what} is {type_phrase(env.ctx, type_)}, this is {type_phrase(env.ctx, found)}", node.span
        )
    return to_unit(env.ctx, e, unit, what, node.span, code) if both_numbers else e


def type_phrase(ctx: Context, type_: str) -> str:
    """A type in a sentence."""
    if type_ == "real":
        return "a number"
    if type_ == "bool":
        return "a truth value"
    return f"a value of {type_.removeprefix('cell ')}"


def exact(env: Env, span: Span, build: Callable[[], Expr]) -> Expr:
    """What `build` gives; a number too large or a division by zero is a finding."""
    try:
        return build()
    except A.TooLarge:
        env.ctx.fail("HA105", "this number is too large: exact numbers have at most 4,200 digits", span)
    except A.DividedByZero:
        env.ctx.fail("HA403", "division by zero: this expression has no value", span, severity=Severity.ERROR)
