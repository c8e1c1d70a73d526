"""Functions that come from data: interpolated tables, networks, fuzzy outputs, relations, rules of cells."""

from __future__ import annotations

from collections.abc import Callable

from haverify.elaborate.calls import arguments
from haverify.elaborate.cellular import Subject
from haverify.elaborate.context import Context
from haverify.elaborate.expressions import Env, denote, of_type, real, type_phrase, typed
from haverify.elaborate.scope import Symbol, Typed
from haverify.elaborate.units import plain, to_unit
from haverify.model.expression import Expr
from haverify.model.fuzzy import FuzzyController
from haverify.model.tables import DataTable, Network
from haverify.model.unit import Unit
from haverify.syntax import tree as t


def apply(env: Env, callee: Symbol, node: t.Call) -> Typed:
    """The value of a call of something that data define."""
    return _APPLY[callee.kind](env, callee, node)


def _measured(env: Env, node: t.Call, wanted: tuple[tuple[str, Unit | None], ...], name: str) -> list[Expr]:
    """The arguments, by position or by name, in the units declared."""
    positional = [a.value for a in node.arguments if a.name is None]
    by_name = {a.name: a.value for a in node.arguments if a.name is not None}
    rest = [n for n, _ in wanted[len(positional) :]]
    if len(positional) > len(wanted) or set(by_name) != set(rest):
        names = ", ".join(n for n, _ in wanted)
        env.ctx.fail("HA105", f"{name} takes {len(wanted)} arguments: {names}", node.span)
    given = positional + [by_name[n] for n in rest]
    pairs = zip(given, wanted, strict=True)
    return [to_unit(env.ctx, real(env, e), unit, f"argument '{n}' of {name}", e.span) for e, (n, unit) in pairs]


def _column(env: Env, callee: Symbol, node: t.Call) -> Typed:
    table: DataTable = callee.payload
    given = _measured(env, node, table.axes, f"{table.name}.{callee.name}")
    return Typed(Expr("table", (table.name, callee.name, *given), callee.unit, node.span), "real")


def _network(env: Env, callee: Symbol, node: t.Call) -> Typed:
    network: Network = callee.payload
    given = _measured(env, node, network.inputs, f"{network.name}.{callee.name}")
    return Typed(Expr("net", (network.name, callee.name, *given), callee.unit, node.span), "real")


def _fuzzy(env: Env, callee: Symbol, node: t.Call) -> Typed:
    controller, roots = callee.payload
    assert isinstance(controller, FuzzyController)
    given = _measured(env, node, roots, f"{controller.name}.{callee.name}")
    named = tuple((n, e) for (n, _), e in zip(roots, given, strict=True))
    terms = next(terms for name, terms in controller.outputs if name == callee.name)
    owners = [e.name for e in env.ctx.enums.values() if set(terms) <= set(e.values)]
    if not owners:
        told = f"the terms of {controller.name}.{callee.name} are no values of one enumeration"
        env.ctx.fail("HA105", told, node.span, help=f"declare `enum {callee.name.title()} {{ {', '.join(terms)} }}`")
    env.ctx.used_values.update((owners[0], term) for term in terms)
    return Typed(Expr("fuzzy", (controller.name, callee.name, named), None, node.span), owners[0])


def _relation(env: Env, callee: Symbol, node: t.Call) -> Typed:
    subject: Subject = callee.payload
    (argument,) = arguments(env, node, 1, callee.name)
    value = _related_argument(env, subject, argument)
    if value.type not in subject.right_of:
        assert subject.relation is not None
        right = {b for _, b in subject.relation.pairs}
        subject.right_of[value.type] = _enum_with(env.ctx, right, value.type)
    return Typed(Expr("apply", (callee.name, value.expr), None, node.span), subject.right_of[value.type])


def _related_argument(env: Env, subject: Subject, node: t.Expr) -> Typed:
    relation = subject.relation
    assert relation is not None
    value = typed(env, node)
    if value.type not in subject.left_of:
        enum = env.ctx.enums.get(value.type)
        subject.left_of[value.type] = enum is not None and {a for a, _ in relation.pairs} <= set(enum.values)
    if not subject.left_of[value.type]:
        left = ", ".join(sorted({a for a, _ in relation.pairs})[:4])
        told = f"{relation.name} relates {left}, ...; this is {type_phrase(env.ctx, value.type)}"
        env.ctx.fail("HA105", told, node.span)
    return value


def _enum_with(ctx: Context, names: set[str], first: str) -> str:
    candidates = [first, *ctx.enums]
    return next((n for n in candidates if names <= set(ctx.enums[n].values)), first)


# ---- words of claims ------------------------------------------------------------


def special(env: Env, node: t.Call, name: str) -> Typed:
    """`related(R, a)` and `defined(e)`; the other words belong to a subject that is missing."""
    if name == "related":
        return _is_related(env, node)
    if name == "defined":
        (argument,) = arguments(env, node, 1, name)
        return Typed(Expr("defined", (typed(env, argument).expr,), None, node.span), "bool")
    subject = "a cellular automaton" if name in ("next", "unique_rule") else "a fuzzy system"
    return env.ctx.fail("HA105", f"{name}() has a meaning in claims on {subject}", node.span)


def _is_related(env: Env, node: t.Call) -> Typed:
    relation, argument = arguments(env, node, 2, "related")
    found = denote(env, relation)
    if not isinstance(found, Symbol) or found.kind != "relation":
        env.ctx.fail("HA105", "related(R, a): R must be a relation", relation.span)
    value = _related_argument(env, found.payload, argument)
    return Typed(Expr("related", (found.name, value.expr), None, node.span), "bool")


def _next(env: Env, callee: Symbol, node: t.Call) -> Typed:
    automaton, cell = callee.payload
    (argument,) = arguments(env, node, 1, callee.name)
    e = of_type(env, argument, f"cell {cell}", None, f"the argument of {callee.name}()")
    if callee.name == "unique_rule":
        return Typed(Expr("unique_rule", (automaton, e), None, node.span), "bool")
    return Typed(Expr("next", (automaton, e), None, node.span), f"cell {cell}")


def _covered(env: Env, callee: Symbol, node: t.Call) -> Typed:
    controller: FuzzyController = callee.payload
    if not env.is_claim:
        env.ctx.fail("HA105", f"{callee.name}() has a meaning in claims only", node.span)
    if callee.name == "covered":
        return _covers(env, controller, node)
    (argument,) = arguments(env, node, 1, callee.name)
    word = argument.id if isinstance(argument, t.Name) else ""
    outputs = dict(controller.outputs)
    known = outputs if callee.name == "max_firing" else {term: 0 for terms in outputs.values() for term in terms}
    if word not in known:
        what = "output" if callee.name == "max_firing" else "term"
        env.ctx.unknown(what, word, controller.name, argument.span, known)
    return Typed(Expr(callee.name, (controller.name, word), env.ctx.one, node.span), "real")


def _covers(env: Env, controller: FuzzyController, node: t.Call) -> Typed:
    name, level = arguments(env, node, 2, "covered")
    word = name.id if isinstance(name, t.Name) else ""
    known = [i.name for i in controller.inputs]
    if word not in known:
        env.ctx.unknown("input", word, controller.name, name.span, known)
    e = plain(env.ctx, real(env, level), "a level", level.span)
    return Typed(Expr("covered", (controller.name, word, e), None, node.span), "bool")


_APPLY: dict[str, Callable[[Env, Symbol, t.Call], Typed]] = {
    "column": _column, "net": _network, "fuzzyout": _fuzzy, "relation": _relation, "cellword": _next,
    "fuzzyword": _covered,
}  # fmt: skip
