"""What is declared and never read (HA005), and names that look like units in quantities (HA107)."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

from haverify.diagnostics.diagnostic import Diagnostic, Edit, Fix
from haverify.elaborate.context import Context
from haverify.elaborate.file import FileScope
from haverify.elaborate.scope import Scope, Symbol
from haverify.model.unit import BUILTIN
from haverify.syntax import tree as t
from haverify.text.span import Span

_WORDS = {"const": "constant", "set": "constant", "param": "parameter", "input": "input", "var": "variable"}


def unused(ctx: Context, files: Sequence[FileScope]) -> list[Diagnostic]:
    """Warnings about a file with automata (one without is there to be imported); asked for when there is no error."""
    root = next(f for f in files if f.is_root)
    if not root.machines:
        return []
    scopes = [root.env.scope, *(s.payload.scope for _, s in root.machines if s.payload is not None)]
    found = list(_unread(ctx, scopes, _items(root.tree.items))) + list(_values(ctx, root))
    return found + list(_shadows(root, scopes))


def _items(items: Sequence[t.Item]) -> dict[Span, Span]:
    """The whole declaration that each constant or param is, by the span of its name."""
    found: dict[Span, Span] = {}
    for item in items:
        if isinstance(item.body, t.Const | t.Param | t.Input):
            found[item.body.declared.span] = item.span
        elif isinstance(item.body, t.Automaton | t.System):
            found.update(_items(item.body.members))
    return found


def _symbols(scope: Scope) -> Iterator[tuple[str, Symbol, bool]]:
    for name, symbol in scope.names.items():
        if symbol.kind == "family":
            members = list(symbol.payload.by_value.values())
            if members:
                yield name, members[0], any(m.used for m in members)
        else:
            yield name, symbol, symbol.used


def _unread(ctx: Context, scopes: Sequence[Scope], items: dict[Span, Span]) -> Iterator[Diagnostic]:
    found: dict[Span, tuple[str, Symbol]] = {}
    read: set[Span] = set()
    for scope in scopes:
        for name, symbol, is_used in _symbols(scope):
            if symbol.kind not in _WORDS or symbol.span is None or symbol.span.path != ctx.root:
                continue
            found.setdefault(symbol.span, (name, symbol))
            if is_used:
                read.add(symbol.span)
    for span, (name, symbol) in sorted(found.items(), key=lambda f: f[0].start):
        if span not in read:
            whole = items.get(span)
            fix = Fix(f"remove {name}", (Edit(whole, ""),), safe=True) if whole else None
            yield Diagnostic("HA005", f"{_WORDS[symbol.kind]} {name} is never read", span, fix=fix)


def _values(ctx: Context, root: FileScope) -> Iterator[Diagnostic]:
    """Values of enumerations that nothing mentions."""
    for item in root.tree.items:
        body = item.body
        if not isinstance(body, t.EnumDecl) or body.name not in ctx.enums or body.name in ctx.used_enums:
            continue
        for value in body.values:
            if (body.name, value.name) not in ctx.used_values:
                yield Diagnostic("HA005", f"value {value.name} of {body.name} is never used", value.span)


# ---- names like units -----------------------------------------------------------


def _shadows(root: FileScope, scopes: Sequence[Scope]) -> Iterator[Diagnostic]:
    names = {n for s in scopes for n in s.names if n in BUILTIN}
    if not names:
        return
    for number in _numbers(root.tree):
        units = (number.unit or "").replace(".", "/").split("/")
        for unit in units[1:]:
            name = unit.split("^")[0]
            if name in names:
                shown = f"{number.text} {number.unit}"
                names.discard(name)
                told = f"'{name}' is declared here, yet `{shown}` is one quantity, not an operation with '{name}'"
                yield Diagnostic("HA107", told, number.span)


def _numbers(tree: t.Tree) -> Iterator[t.Number]:
    stack: list[object] = [tree.items]
    found: list[t.Number] = []
    while stack:
        at = stack.pop()
        if isinstance(at, t.Number):
            found.append(at)
        elif isinstance(at, tuple):
            stack.extend(at)
        elif type(at).__module__ == t.__name__:
            stack.extend(getattr(at, s) for s in at.__slots__)  # type: ignore[attr-defined]
    yield from sorted(found, key=lambda n: n.span.start)
