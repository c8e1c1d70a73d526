"""Fuzzy systems: inputs with terms, outputs, rules."""

from __future__ import annotations

from fractions import Fraction
from itertools import pairwise

from haverify.diagnostics.diagnostic import Label
from haverify.elaborate import arithmetic as A
from haverify.elaborate.calls import declared_type
from haverify.elaborate.declare import Entries
from haverify.elaborate.expressions import Env, range_in, real
from haverify.elaborate.scope import Scope, Symbol
from haverify.elaborate.units import to_unit
from haverify.elaborate.values import exact_value
from haverify.model.expression import Expr
from haverify.model.fuzzy import FuzzyController, FuzzyInput, FuzzyRule, Term
from haverify.model.unit import Unit
from haverify.syntax import tree as t
from haverify.text.record import holder

_CORNERS = {"tri": 3, "trap": 4, "ramp": 2, "point": 1}


@holder
class Controller:
    """A fuzzy system in scope: `scope` for `F.output(...)`, `claim_scope` for claims on it."""

    model: FuzzyController
    scope: Scope
    claim_scope: Scope
    roots: tuple[tuple[str, Unit | None], ...]
    sources: dict[str, str]


def enter_fuzzy(entries: Entries, item: t.Item, decl: t.Fuzzy) -> None:
    """Enter a fuzzy system."""
    env = entries.env
    symbol = Symbol("fuzzy", entries.name_of(decl.name), decl.name_span, state="pending")

    def make() -> None:
        symbol.payload = _controller(env, symbol, item, decl)
        entries.models[symbol] = symbol.payload.model

    symbol.make = make
    if env.ctx.define(env.scope.names, decl.name, symbol, "fuzzy system"):
        entries.symbols.append(symbol)


def _lines(decl: t.Fuzzy, *kinds: str) -> list[t.FuzzyLine]:
    return [line for line in decl.lines if line.kind in kinds]


def _controller(env: Env, symbol: Symbol, item: t.Item, decl: t.Fuzzy) -> Controller:
    inputs, chained = [], {}
    for line in _lines(decl, "input", "chain"):
        if line.kind == "chain":
            before = _source(env, line)
            chained[line.name] = before
            inputs.append(
                FuzzyInput(line.name, env.ctx.one, None, None, (), (before.model.name, line.output), line.span)
            )
        else:
            inputs.append(_input(env, line))
    outputs = tuple((line.name, line.values) for line in _lines(decl, "output"))
    logic = _lines(decl, "logic")
    terms = _known_terms(inputs, chained)
    rules = tuple(_rule(env, line, terms, dict(outputs)) for line in _lines(decl, "rule"))
    words = (logic[0].values[0], logic[0].values[1]) if logic else ("min", "max")
    model = FuzzyController(symbol.name, tuple(inputs), outputs, words, rules, "\n".join(item.docs), decl.name_span)
    return _scoped(env, model, chained)


def _source(env: Env, line: t.FuzzyLine) -> Controller:
    symbol = env.scope.lookup(line.source)
    if symbol is None or symbol.kind != "fuzzy":
        env.ctx.unknown("fuzzy system", line.source, "", line.span, env.scope.visible())
    found: Controller = env.ctx.use(symbol, line.span).payload
    outputs = dict(found.model.outputs)
    if line.output not in outputs:
        env.ctx.unknown("output", line.output, line.source, line.span, outputs)
    return found


def _input(env: Env, line: t.FuzzyLine) -> FuzzyInput:
    unit = declared_type(env, line.type)[1] if line.type else env.ctx.one
    assert line.range is not None
    bounds = range_in(env, line.range, unit, f"input {line.name}")
    low, high = (_exact(env, e, line) for e in (bounds.low, bounds.high))
    terms = tuple(_term(env, term, unit) for term in line.terms)
    return FuzzyInput(line.name, unit, low, high, terms, None, line.span)


def _exact(env: Env, e: Expr, line: t.FuzzyLine | t.FuzzyTerm) -> Fraction:
    value = exact_value(env.ctx, e)
    if value is None:
        env.ctx.fail("HA105", "a number is needed here", e.span or line.span)
    return value


def _term(env: Env, term: t.FuzzyTerm, unit: Unit | None) -> Term:
    if term.shape not in _CORNERS:
        env.ctx.unknown("shape", term.shape, "fuzzy terms", term.span, _CORNERS)
    if len(term.corners) != _CORNERS[term.shape]:
        env.ctx.fail("HA105", f"{term.shape}() takes {_CORNERS[term.shape]} corners", term.span)
    given = [to_unit(env.ctx, real(env, c), unit, f"term {term.name}", c.span) for c in term.corners]
    corners = tuple(_exact(env, c, term) for c in given)
    _check_order(env, term, corners)
    return Term(term.name, term.shape, corners, term.span)


def _check_order(env: Env, term: t.FuzzyTerm, corners: tuple[Fraction, ...]) -> None:
    """The corners of a triangle or trapezoid ascend; a ramp rises or falls."""
    if term.shape == "ramp":
        if corners[0] == corners[1]:
            env.ctx.report("HA201", f"ramp of {term.name}: its two corners are equal", term.corners[1].span)
        return
    for k, (a, b) in enumerate(pairwise(corners)):
        if a > b:
            told = f"corners of {term.name} do not ascend"
            labels = (Label(term.corners[k].span),)
            env.ctx.report("HA201", told, term.corners[k + 1].span, label="below the corner before", labels=labels)
            return


def _known_terms(inputs: list[FuzzyInput], chained: dict[str, Controller]) -> dict[str, tuple[str, ...]]:
    found = {i.name: tuple(term.name for term in i.terms) for i in inputs}
    for i in inputs:
        if i.source is not None:
            found[i.name] = dict(chained[i.name].model.outputs)[i.source[1]]
    return found


def _rule(
    env: Env, line: t.FuzzyLine, terms: dict[str, tuple[str, ...]], outputs: dict[str, tuple[str, ...]]
) -> FuzzyRule:
    if line.output not in outputs:
        env.ctx.unknown("output", line.output, "this fuzzy system", line.span, outputs)
    if line.values[0] not in outputs[line.output]:
        env.ctx.unknown("term", line.values[0], line.output, line.span, outputs[line.output])
    assert line.condition is not None
    return FuzzyRule(line.name, _premise(env, line.condition, terms), line.output, line.values[0], line.span)


def _premise(env: Env, node: t.Expr, terms: dict[str, tuple[str, ...]]) -> Expr:
    while isinstance(node, t.Paren):
        node = node.inner
    if isinstance(node, t.Binary) and node.op in ("and", "or"):
        parts = [_premise(env, n, terms) for n in (node.left, node.right)]
        return (A.every if node.op == "and" else A.some)(parts, node.span)
    if isinstance(node, t.Unary) and node.op == "not":
        return A.negation(_premise(env, node.operand, terms), node.span)
    if isinstance(node, t.Comparison) and node.ops == ("is",):
        left, right = node.operands
        if isinstance(left, t.Name) and isinstance(right, t.Name):
            return _fact(env, left, right, terms)
    return env.ctx.fail("HA105", "a premise is built of `input is term`, and, or, not", node.span)


def _fact(env: Env, left: t.Name, right: t.Name, terms: dict[str, tuple[str, ...]]) -> Expr:
    if left.id not in terms:
        env.ctx.unknown("input", left.id, "this fuzzy system", left.span, terms)
    if right.id not in terms[left.id]:
        env.ctx.unknown("term", right.id, left.id, right.span, terms[left.id])
    return Expr("is", (left.id, right.id), None, left.span.to(right.span))


def _scoped(env: Env, model: FuzzyController, chained: dict[str, Controller]) -> Controller:
    """The names that stand for parts of the system, the inputs of systems it is chained to included."""
    roots: dict[str, Unit | None] = {}
    for i in model.inputs:
        roots.update(chained[i.name].roots if i.name in chained else {i.name: i.unit})
    inner = Scope(f"fuzzy system {model.name}", env.scope)
    claims = Scope(f"fuzzy system {model.name}", env.scope, is_machine=True)
    named = tuple(roots.items())
    for name, unit in named:
        claims.names[name] = Symbol("fuzzyinput", name, unit=unit, payload=(model.name, name), used=True)
    for name, terms in model.outputs:
        inner.names[name] = Symbol("fuzzyout", name, payload=(model, named), used=True)
        for term in terms:
            env.ctx.used_values.update((o, term) for o in env.ctx.values.get(term, []))
    for word in ("covered", "max_firing", "strength"):
        claims.names[word] = Symbol("fuzzyword", word, payload=model, used=True)
        inner.names.setdefault(word, claims.names[word])
    return Controller(model, inner, claims, named, {})
