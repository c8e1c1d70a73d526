"""From syntax trees to the exact model: the one entry of elaboration."""

from __future__ import annotations

from typing import Any

from haverify.diagnostics.diagnostic import Diagnostic
from haverify.elaborate.claims import LostClaim, elaborate_claims
from haverify.elaborate.context import Context
from haverify.elaborate.deep import deep_recursion
from haverify.elaborate.file import FileScope, elaborate_files
from haverify.elaborate.files import Files
from haverify.elaborate.unused import unused
from haverify.model.claim import Claim
from haverify.model.hybrid import Constant, Input, Param
from haverify.model.spec import Spec
from haverify.syntax import tree as t


def elaborate(tree: t.Tree, files: Files) -> tuple[Spec | None, list[Diagnostic]]:
    """The model of a spec and the findings about its names, types and units.

    An element with an error is missing from the model, together with what depends on it; claims lost so are listed
    in `Spec.lost`. The model is None only where the text has no item at all.
    """
    if not tree.items:
        return None, []
    with deep_recursion():
        return _elaborate(tree, files)


def _elaborate(tree: t.Tree, files: Files) -> tuple[Spec, list[Diagnostic]]:
    header = next((i.body for i in tree.items if isinstance(i.body, t.SpecHeader)), None)
    ctx = Context(files, tree.path, header is not None and header.unitless)
    scopes = elaborate_files(ctx, tree)
    claims, lost = elaborate_claims(ctx, scopes)
    if not ctx.has_losses and not any(d.code not in ("HA203", "HA215") for d in ctx.diagnostics):
        ctx.diagnostics += unused(ctx, scopes)
    return _spec(ctx, tree, header, scopes, (claims, lost)), ctx.diagnostics


def _spec(
    ctx: Context, tree: t.Tree, header: t.SpecHeader | None, scopes: list[FileScope],
    claims: tuple[tuple[Claim, ...], tuple[LostClaim, ...]],
) -> Spec:  # fmt: skip
    def made(kind: str) -> tuple[Any, ...]:
        return tuple(m for s in scopes for m in s.entries.made(kind))

    def of(kind: type) -> tuple[Any, ...]:
        return tuple(m for s in scopes for m in s.entries.of(kind))

    return Spec(
        header.title if header else tree.path, header.version if header else "1.0", ctx.unitless, tuple(ctx.unit_defs),
        tuple(ctx.enums.values()), of(Constant), of(Param), of(Input), made("data"), made("network"),
        tuple(a for s in scopes for a in s.assumptions), made("automaton"), made("system"), made("cellular"),
        made("relation"), made("fuzzy"), claims[0], tuple(ctx.cells), tuple(ctx.allowed), claims[1],
    )  # fmt: skip
