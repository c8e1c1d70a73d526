"""Claims: properties and invariants, one per value of a family."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from contextlib import suppress
from fractions import Fraction
from typing import Any

from haverify.diagnostics.diagnostic import Label
from haverify.elaborate import arithmetic as A
from haverify.elaborate.attributes import allowed_codes
from haverify.elaborate.automaton import Machine
from haverify.elaborate.context import Context, Lost, NeedsMode
from haverify.elaborate.definedness import check_claim
from haverify.elaborate.expressions import Env, boolean, denote, later, range_in, real, source_name
from haverify.elaborate.file import FileScope
from haverify.elaborate.limits import LONGEST_NAME, MOST_JUMPS, whole
from haverify.elaborate.paths import target_mode
from haverify.elaborate.resets import bound_text, placed
from haverify.elaborate.scope import Scope, Symbol, Typed
from haverify.elaborate.values import exact_value
from haverify.model.claim import Claim, Expectation, Goal
from haverify.model.expression import Expr
from haverify.model.hybrid import Range
from haverify.syntax import tree as t
from haverify.text.record import field, holder, replace
from haverify.text.span import Span

LostClaim = tuple[str, Span, str]


@holder
class _Claims:
    ctx: Context
    claims: list[Claim] = field(default_factory=list)
    lost: list[LostClaim] = field(default_factory=list)
    names: dict[str, Span] = field(default_factory=dict)


def elaborate_claims(ctx: Context, files: Sequence[FileScope]) -> tuple[tuple[Claim, ...], tuple[LostClaim, ...]]:
    """The claims of the root file and those lost to errors, with the reason."""
    work = _Claims(ctx)
    root = next(f for f in files if f.is_root)
    machines = {id(item): symbol for item, symbol in root.machines}
    for item in root.tree.items:
        if isinstance(item.body, t.Property | t.Invariant):
            _enter(work, root.env, item, item.body, None)
        elif id(item) in machines:
            _inner_invariants(work, root.env, machines[id(item)])
    _check_using(work, root)
    return tuple(work.claims), tuple(work.lost)


def _inner_invariants(work: _Claims, env: Env, symbol: Symbol) -> None:
    machine = symbol.payload
    if isinstance(machine, Machine):
        for item in machine.invariants:
            assert isinstance(item.body, t.Invariant)
            _enter(work, env, item, item.body, symbol)


def _enter(work: _Claims, env: Env, item: t.Item, decl: t.Property | t.Invariant, inside: Symbol | None) -> None:
    """One claim per value; an error loses the claim, and its name with it."""
    head = decl.declared
    if len(head.name) > LONGEST_NAME:
        told = f"a name of {len(head.name)} letters: the name of a claim has at most {LONGEST_NAME}"
        work.ctx.report("HA001", told, head.span)
        work.lost.append((head.name[:LONGEST_NAME], head.span, "its name is too long"))
        return
    try:
        places = list(placed(env, head.family))
    except Lost:
        work.lost.append((head.name, head.span, "its family has an error"))
        return
    values = [_value(p, head) for p in places]
    for place, value in zip(places, values, strict=True):
        name = f"{head.name}[{value}]" if value else head.name
        if inside is not None and name in work.names:
            name = f"{inside.name}_{name}"
        if name in work.names:
            labels = (Label(work.names[name], "first defined here"),)
            work.ctx.report("HA004", f"claim '{name}' is defined twice", head.span, labels=labels)
            work.lost.append((name, head.span, "its name is defined twice"))
            continue
        work.names[name] = head.span
        _one(work, place, item, decl, name, inside)


def _value(env: Env, head: t.Declared) -> str:
    if head.family is None:
        return head.index or ""
    return bound_text(env, head.family.name)


def _one(
    work: _Claims, env: Env, item: t.Item, decl: t.Property | t.Invariant, name: str, inside: Symbol | None
) -> None:
    before = len(work.ctx.diagnostics)
    work.ctx.bindings = 0
    try:
        symbol = inside or _subject(env, decl.on)
        place = _claim_env(env, symbol, decl)
        made = _property(place, item, decl, name, symbol) if isinstance(decl, t.Property) else _invariant(
            place, item, decl, name, symbol)  # fmt: skip
        missing = getattr(symbol.payload, "missing", None) if symbol is not None else None
        if missing and not check_claim(work.ctx, [g.condition for g in made.goals], missing):
            raise Lost
        work.claims.append(made)
    except NeedsMode as need:
        told = f"'{need.symbol.name}' has a value only in a comparison of a claim, or inside a mode"
        work.ctx.report("HA105", told, decl.declared.span)
        work.lost.append((name, decl.declared.span, told))
    except Lost:
        new = work.ctx.diagnostics[before:]
        same = (r for _, span, r in reversed(work.lost) if span == decl.declared.span)
        reason = new[0].message if new else next(same, _blame(env, decl))
        work.lost.append((name, decl.declared.span, reason))


def _blame(env: Env, decl: t.Property | t.Invariant) -> str:
    where = f"{source_name(decl.on)} has" if decl.on is not None else "what it is about has"
    return f"{where} errors"


def _subject(env: Env, on: t.Expr | None) -> Symbol | None:
    if on is None:
        return None
    found = denote(env, on)
    kinds = ("automaton", "system", "fuzzy", "cellular", "relation", "network")
    if not isinstance(found, Symbol) or found.kind not in kinds:
        env.ctx.fail("HA105", f"'{source_name(on)}' is nothing that claims are about", on.span)
    return found


def _claim_env(env: Env, symbol: Symbol | None, decl: t.Property | t.Invariant) -> Env:
    """Names of the subject, and over them the value of the claim's family."""
    scope = env.scope
    if symbol is not None:
        symbol = env.ctx.use(symbol, None)
        inner = getattr(symbol.payload, "claim_scope", None) or symbol.payload.scope
        assert isinstance(inner, Scope)
        scope = inner
        if decl.declared.family is not None:
            name = decl.declared.family.name
            scope = inner.bind({name: env.scope.names[name].payload})
    machine = symbol.payload if symbol is not None and isinstance(symbol.payload, Machine) else None
    return replace(env, scope=scope, is_claim=True, split=_splitter(machine))


def _splitter(machine: Machine | None) -> Any:
    """A comparison that uses the parameter of a mode family: one implication per mode of the family."""

    def split(env: Env, node: t.Expr, symbol: Symbol) -> Expr:
        assert machine is not None
        parts = []
        for mode in machine.modes:
            if mode.param == symbol.name:
                value = mode.scope.names[symbol.name].payload
                inner = replace(env, scope=env.scope.bind({symbol.name: value}))
                at = Expr("at", (mode.name,), None, node.span)
                parts.append((at, boolean(inner, node)))
        if all(p.op in ("true", "false") for _, p in parts):
            return A.some([at for at, p in parts if p.op == "true"], node.span)
        return A.every([A.implication(at, p, node.span) for at, p in parts], node.span)

    return split if machine is not None else None


# ---- properties -----------------------------------------------------------------


def _lines(decl: t.Property, kind: Any) -> Iterator[Any]:
    return (i.body for i in decl.lines if isinstance(i.body, kind))


def _property(env: Env, item: t.Item, decl: t.Property, name: str, symbol: Symbol | None) -> Claim:
    assume = tuple(boolean(env, a.condition) for a in _lines(decl, t.Assume))
    goals = tuple(_goal(env, g) for g in _lines(decl, t.Goal))
    if not goals:
        env.ctx.fail(
            "HA105", f"property {name} claims nothing: a goal such as `always ...` is missing", decl.declared.span
        )
    time, jumps = _horizon(env, list(_lines(decl, t.Horizon)))
    which = tuple(_which(env, w) for w in _lines(decl, t.Which))
    using = tuple(n.id for u in _lines(decl, t.Using) for n in u.names)
    methods = [_method(env, m) for m in _lines(decl, t.Method)]
    expects = [_expectation(env, e) for e in _lines(decl, t.Expectation)]
    return Claim(
        name, symbol.name if symbol else None, "property", goals, time, jumps, assume, which, using,
        methods[0] if methods else None, expects[0] if expects else None, False, "\n".join(item.docs),
        _text(env, decl.span), decl.declared.span, allowed_codes(item),
    )  # fmt: skip


def _text(env: Env, span: Span) -> str:
    source = env.ctx.files.sources.get(span.path)
    return source.at(span) if source is not None else ""


def _goal(env: Env, goal: t.Goal) -> Goal:
    place = replace(env, is_stl=goal.kind == "stl")
    condition = boolean(place, goal.condition)
    if goal.kind == "never":
        condition = A.negation(condition, goal.condition.span)
    window = None
    if goal.window is not None:
        window = (later(env, goal.window[0], "a time"), later(env, goal.window[1], "a time"))
    within = later(env, goal.within, "a time") if goal.within is not None else None
    kind = "always" if goal.kind == "never" else goal.kind
    return Goal(kind, condition, window, within, goal.attracting, goal.span)


def _horizon(env: Env, lines: list[t.Horizon]) -> tuple[Expr | None, int | None]:
    time, jumps = None, None
    for line in lines:
        if line.time is not None:
            time = later(env, line.time, "a horizon")
        if line.jumps is not None:
            jumps = whole(env.ctx, line.jumps, "a number of jumps", 0, MOST_JUMPS)
    return time, jumps


def _which(env: Env, line: t.Which) -> tuple[str, Range]:
    found = denote(env, t.Name(line.name, line.span))
    if not isinstance(found, Typed) or found.expr.op != "param":
        env.ctx.fail("HA105", f"`for which` splits the range of a param; '{line.name}' is none", line.span)
    return found.expr.name, range_in(env, line.range, found.expr.unit, f"param {line.name}")


def _method(env: Env, line: t.Method) -> tuple[str, tuple[tuple[str, str], ...]]:
    arguments = []
    for a in line.arguments:
        value = f'"{a.value}"' if isinstance(a.value, str) else _argument_text(a.value)
        arguments.append((a.name or "", value))
    return line.name, tuple(arguments)


def _argument_text(value: t.Expr) -> str:
    if isinstance(value, t.Number):
        return value.text + (f" {value.unit}" if value.unit else "")
    return source_name(value)


def _expectation(env: Env, e: t.Expectation) -> Expectation:
    margin = (e.margin[0], real(env, e.margin[1])) if e.margin is not None else None
    share = (e.share[0], _share(env, e.share[1])) if e.share is not None else None
    return Expectation(e.verdict, margin, share, e.because, e.span)


def _share(env: Env, node: t.Expr) -> Fraction:
    e = real(env, node)
    value = exact_value(env.ctx, e)
    if value is None:
        env.ctx.fail("HA105", "a share is a number", node.span)
    return value * e.unit.scale if e.unit is not None else value


def _invariant(env: Env, item: t.Item, decl: t.Invariant, name: str, symbol: Symbol | None) -> Claim:
    condition = boolean(env, decl.condition)
    if decl.mode is not None:
        at = A.some([Expr("at", (m.name,), None, decl.mode.span) for m in target_mode(env, decl.mode)], decl.mode.span)
        condition = A.implication(at, condition, decl.span)
    goal = Goal("always", condition, None, None, False, decl.span)
    expect = _expectation(env, decl.expect) if decl.expect is not None else None
    return Claim(
        name, symbol.name if symbol else None, "invariant", (goal,), None, None, (), (), (), None, expect,
        decl.inductive, "\n".join(item.docs), _text(env, decl.span), decl.declared.span, allowed_codes(item),
    )  # fmt: skip


# ---- using ----------------------------------------------------------------------


def _check_using(work: _Claims, root: FileScope) -> None:
    """`using` names invariants; else HA608. The name of a family stands for all its members."""
    kinds = {c.name: c.kind for c in work.claims}
    members: dict[str, list[str]] = {}
    for claim in work.claims:
        members.setdefault(claim.name.split("[")[0], []).append(claim.name)
    spans = _using_spans(root)
    kept = []
    for claim in work.claims:
        names = tuple(m for n in claim.using for m in ([n] if n in kinds else members.get(n, [n])))
        bad = next((n for n in names if kinds.get(n) != "invariant"), None)
        if bad is None:
            kept.append(claim if names == claim.using else replace(claim, using=names))
        else:
            _blame_using(work, claim, bad, kinds, spans)
    work.claims = kept


def _using_spans(root: FileScope) -> dict[tuple[Span, str], Span]:
    """Where each property names what it uses."""
    return {
        (item.body.declared.span, name.id): name.span
        for item in root.tree.items if isinstance(item.body, t.Property)
        for line in _lines(item.body, t.Using) for name in line.names
    }  # fmt: skip


def _blame_using(
    work: _Claims, claim: Claim, bad: str, kinds: dict[str, str], spans: dict[tuple[Span, str], Span]
) -> None:
    assert claim.span is not None
    span = spans.get((claim.span, bad), claim.span)
    reported = any(d.span == span for d in work.ctx.diagnostics)
    if bad in kinds and not reported:
        work.ctx.report("HA608", f"'{bad}' is a property; `using` takes invariants", span)
    elif bad not in {n for n, _, _ in work.lost} and not reported:
        with suppress(Lost):
            work.ctx.unknown("invariant", bad, "", span, [n for n, k in kinds.items() if k == "invariant"])
    work.lost.append((claim.name, claim.span, f"it uses '{bad}', which is no invariant of this file"))
