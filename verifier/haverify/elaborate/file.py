"""A file and the files it imports: what is declared at top level."""

from __future__ import annotations

from collections.abc import Callable
from contextlib import suppress
from fractions import Fraction
from typing import Any

from haverify.diagnostics.diagnostic import Label, Severity
from haverify.elaborate.attributes import allowances
from haverify.elaborate.automaton import Machine, declare_member, elaborate_automaton
from haverify.elaborate.context import Context, Lost
from haverify.elaborate.declare import Entries
from haverify.elaborate.expressions import Env, boolean, real
from haverify.elaborate.instances import Base, elaborate_instance
from haverify.elaborate.naming import once
from haverify.elaborate.scope import Scope, Symbol
from haverify.elaborate.tables import enter_table
from haverify.maths.exact import PiRational
from haverify.model.expression import Expr
from haverify.model.spec import EnumType, UnitDef
from haverify.model.unit import BUILTIN, NamedUnit
from haverify.syntax import tree as t
from haverify.text.record import field, holder


@holder
class FileScope:
    """A file being elaborated; `prefix` is put before its names in the core."""

    tree: t.Tree
    env: Env
    entries: Entries
    prefix: str
    is_root: bool
    machines: list[tuple[t.Item, Symbol]] = field(default_factory=list)
    assumptions: list[Expr] = field(default_factory=list)


def elaborate_files(ctx: Context, tree: t.Tree) -> list[FileScope]:
    """All files, imported ones first, each once."""
    found: dict[str, FileScope] = {}
    for known in (tree, *ctx.files.trees.values()):
        _reserve_names(ctx, known)
    _enter_file(ctx, tree, "", found)
    scopes = list(found.values())
    found[tree.path].is_root = True
    for scope in scopes:
        _assumptions(scope)
        scope.entries.settle()
    return scopes


def _enter_file(ctx: Context, tree: t.Tree, prefix: str, found: dict[str, FileScope]) -> Scope:
    if tree.path in found:
        return found[tree.path].env.scope
    scope = Scope("", items=tree.items)
    env = Env(ctx, scope)
    file = FileScope(tree, env, Entries(env, _namer(ctx, prefix)), prefix, False)
    for item in tree.items:
        if isinstance(item.body, t.Import):
            _enter_import(ctx, file, item.body, found)
    found[tree.path] = file
    _enter_items(file)
    return scope


def _namer(ctx: Context, prefix: str) -> Callable[[str], str]:
    return once(lambda name: ctx.fresh(f"{prefix}_{name}") if prefix else name)


def _enter_import(ctx: Context, file: FileScope, decl: t.Import, found: dict[str, FileScope]) -> None:
    tree = ctx.files.trees.get((file.tree.path, decl.path))
    scope = file.env.scope
    if tree is None:
        if decl.alias is not None:
            scope.names[decl.alias] = Symbol("import", decl.alias, decl.span, state="lost")
        return
    header = next((i.body for i in tree.items if isinstance(i.body, t.SpecHeader)), None)
    if header is not None and header.unitless != ctx.unitless:
        kinds = ("without units", "with units") if header.unitless else ("with units", "without units")
        ctx.report("HA101", f"{decl.path} is a file {kinds[0]}, this is one {kinds[1]}", decl.path_span)
        return
    prefix = f"{file.prefix}_{decl.alias}" if file.prefix and decl.alias else decl.alias or file.prefix
    inner = _enter_file(ctx, tree, prefix, found)
    if decl.alias is not None:
        ctx.define(scope.names, decl.alias, Symbol("import", decl.alias, decl.span, payload=_Import(inner)), "import")
        return
    for name, symbol in inner.names.items():
        if scope.names.get(name) is not symbol:
            ctx.define(scope.names, name, symbol, "name")


@holder
class _Import:
    scope: Scope


def _reserve_names(ctx: Context, tree: t.Tree) -> None:
    """Names that the text declares anywhere are not given to table cells."""
    stack: list[object] = [tree]
    while stack:
        at = stack.pop()
        if isinstance(at, t.Declared):
            ctx.taken.add(at.name)
        elif isinstance(
            at, t.Tree | t.Automaton | t.System | t.Mode | t.Var | t.Let | t.Const | t.Param | t.Input | t.Item
        ):
            stack.extend(_inside(at))


def _inside(at: object) -> list[object]:
    if isinstance(at, t.Tree):
        return list(at.items)
    if isinstance(at, t.Item):
        return [at.body]
    if isinstance(at, t.Automaton | t.System | t.Mode):
        return list(at.members)
    if isinstance(at, t.Var):
        return list(at.names)
    return [at.declared] if isinstance(at, t.Let | t.Const | t.Param | t.Input) else []


def _enter_items(file: FileScope) -> None:
    """Enter units and enumerations, then everything else in the order of the text."""
    for item in file.tree.items:
        _try(_enter_unit_or_enum, file, item)
    for item in file.tree.items:
        file.env.ctx.allowed.extend(allowances(item))
        _try(_enter_item, file, item)


def _try(act: Callable[[FileScope, Any], None], file: FileScope, what: Any) -> None:
    """Do something; what has an error is left out, the rest goes on."""
    with suppress(Lost):
        act(file, what)


def _enter_unit_or_enum(file: FileScope, item: t.Item) -> None:
    if isinstance(item.body, t.UnitDecl):
        _enter_unit(file, item.body)
    elif isinstance(item.body, t.EnumDecl):
        _enter_enum(file, item.body)


# ---- units ----------------------------------------------------------------------


def _enter_unit(file: FileScope, decl: t.UnitDecl) -> None:
    ctx = file.env.ctx
    if ctx.unitless:
        ctx.fail("HA101", f"unit '{decl.name}' in a unitless file", decl.span)
    if decl.name in BUILTIN or any(u.name == decl.name for u in ctx.own_units):
        ctx.fail("HA004", f"unit '{decl.name}' is defined twice", decl.span)
    if decl.value is None:
        made = NamedUnit(decl.name, Fraction(1), 0, ((decl.name, 1),), False)
        ctx.unit_defs.append(UnitDef(decl.name, None))
    else:
        made = _derived_unit(file, decl, decl.value)
        dims = tuple((n, Fraction(e)) for n, e in made.dimensions)
        ctx.unit_defs.append(UnitDef(decl.name, (made.scale, made.pi, dims)))
    ctx.own_units = (*ctx.own_units, made)


def _derived_unit(file: FileScope, decl: t.UnitDecl, value: t.Expr) -> NamedUnit:
    e = real(file.env, value)
    size = _pi_rational(e)
    if size is None or size.rational <= 0 or e.unit is None:
        file.env.ctx.fail("HA105", f"unit '{decl.name}' must be a positive number with a unit", value.span)
    scale = size.rational * e.unit.scale
    return NamedUnit(decl.name, scale, size.power + e.unit.pi, e.unit.dimensions, False)


def _pi_rational(e: Expr) -> PiRational | None:
    """The exact value of products of numbers and pi."""
    if e.op == "num":
        value = e.args[0]
        assert isinstance(value, Fraction)
        return PiRational(value)
    if e.op == "pi":
        return PiRational(Fraction(1), 1)
    if e.op not in ("*", "/"):
        return None
    parts = [_pi_rational(c) for c in e.children]
    total = parts[0]
    for p in parts[1:]:
        if total is None or p is None or (e.op == "/" and p.rational == 0):
            return None
        total = total * p if e.op == "*" else total / p
    return total


# ---- enumerations ---------------------------------------------------------------


def _enter_enum(file: FileScope, decl: t.EnumDecl) -> None:
    ctx = file.env.ctx
    name = file.entries.name_of(decl.name)
    enum = _integers(ctx, name, decl) if decl.low is not None else _named(ctx, name, decl)
    symbol = Symbol("enum", name, decl.span, type=name, payload=enum)
    if len(enum.values) < len(decl.values) and any(_codes(decl, v) for v in enum.values):
        symbol.state, ctx.has_losses = "lost", True
    if not ctx.define(file.env.scope.names, decl.name, symbol, "enum"):
        return
    ctx.enums[name] = enum
    for value in enum.values:
        ctx.values.setdefault(value, []).append(name)


def _named(ctx: Context, name: str, decl: t.EnumDecl) -> EnumType:
    seen: dict[str, t.EnumValue] = {}
    for value in decl.values:
        first = seen.setdefault(value.name, value)
        if first is value:
            continue
        if named := _codes(decl, value.name):  # a name for two codes says nothing about either
            labels = (Label(first.span, "first named here"),)
            told = f"{decl.name}: '{value.name}' names {' and '.join(named)}"
            ctx.report("HA506", told, value.span, labels=labels, severity=Severity.ERROR)
        else:
            ctx.report("HA004", f"value '{value.name}' of {decl.name} is defined twice", value.span)
    return EnumType(name, tuple(seen), tuple(v.code for v in seen.values()), None, None, decl.span)


def _codes(decl: t.EnumDecl, value: str) -> list[str]:
    """The codes that a value is given, where these are two or more."""
    found = dict.fromkeys(v.code for v in decl.values if v.name == value and v.code is not None)
    return list(found) if len(found) > 1 else []


def _integers(ctx: Context, name: str, decl: t.EnumDecl) -> EnumType:
    assert decl.low is not None and decl.high is not None
    low, high = decl.low.value, decl.high.value
    if low.denominator != 1 or high.denominator != 1 or high < low:
        ctx.fail(
            "HA105", f"{decl.name} = {decl.low.text}..{decl.high.text}: two integers in order are needed", decl.span
        )
    if high - low > 100_000:
        ctx.fail("HA105", f"{decl.name} has more than 100000 values", decl.span)
    values = tuple(str(k) for k in range(int(low), int(high) + 1))
    return EnumType(name, values, (None,) * len(values), low, high, decl.span)


# ---- the rest -------------------------------------------------------------------


def _enter_item(file: FileScope, item: t.Item) -> None:
    body = item.body
    if isinstance(body, t.Const | t.Param | t.Input | t.Function):
        if not isinstance(body, t.Function):
            file.env.ctx.shared.add(file.entries.name_of(body.declared.name))
        declare_member(file.entries, item)
    elif isinstance(body, t.Table):
        enter_table(file.entries, body, file.tree.path)
    elif isinstance(body, t.Automaton | t.Instance | t.System):
        _enter_machine(file, item, body)
    elif isinstance(body, t.Cellular | t.Relation | t.Fuzzy | t.Network):
        from haverify.elaborate.finite import enter_finite

        enter_finite(file.entries, item, file.tree.path)


def _enter_machine(file: FileScope, item: t.Item, body: t.Automaton | t.Instance | t.System) -> None:
    kind = "system" if isinstance(body, t.System) else "automaton"
    symbol = Symbol(kind, file.entries.name_of(body.name), body.name_span, state="pending")

    def make() -> None:
        machine = _machine(file, item, body, symbol)
        symbol.payload = machine
        file.entries.models[symbol] = machine.model
        if machine.model is None:
            raise Lost

    symbol.make = make
    if file.env.ctx.define(file.env.scope.names, body.name, symbol, kind):
        file.entries.symbols.append(symbol)
        file.machines.append((item, symbol))


def _machine(file: FileScope, item: t.Item, body: t.Automaton | t.Instance | t.System, symbol: Symbol) -> Machine:
    doc = "\n".join(item.docs)
    if isinstance(body, t.Automaton):
        made = elaborate_automaton(file.env, symbol.name, body.members, doc, body.name_span)
        made.base = Base(body, file.env, ())
        return made
    if isinstance(body, t.Instance):
        return elaborate_instance(file.env, symbol.name, body, doc)
    from haverify.elaborate.system import elaborate_system

    return elaborate_system(file.env, symbol.name, body, doc)


def _assumptions(file: FileScope) -> None:
    for item in file.tree.items:
        if isinstance(item.body, t.Assume):
            _try(_assume, file, item.body)


def _assume(file: FileScope, decl: t.Assume) -> None:
    file.assumptions.append(boolean(file.env, decl.condition))
