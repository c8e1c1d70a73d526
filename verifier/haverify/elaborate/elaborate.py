"""From syntax trees to the exact model: the one entry of elaboration."""

from __future__ import annotations

from haverify.diagnostics.diagnostic import Diagnostic
from haverify.elaborate.claims import elaborate_claims
from haverify.elaborate.context import Context
from haverify.elaborate.deep import deep_recursion
from haverify.elaborate.file import elaborate_files
from haverify.elaborate.files import Files
from haverify.elaborate.unused import unused
from haverify.model.cellular import CellularAutomaton, Relation
from haverify.model.fuzzy import FuzzyController
from haverify.model.hybrid import Constant, HybridAutomaton, Input, Param
from haverify.model.spec import Spec
from haverify.model.system import System
from haverify.model.tables import DataTable, Network
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
    if not any(d.code not in ("HA203", "HA215") for d in ctx.diagnostics):
        ctx.diagnostics += unused(ctx, scopes)

    def of(kind: type) -> tuple[object, ...]:
        return tuple(m for s in scopes for m in s.entries.of(kind))

    spec = Spec(
        header.title if header else tree.path, header.version if header else "1.0", ctx.unitless, tuple(ctx.unit_defs),
        tuple(ctx.enums.values()), of(Constant), of(Param), of(Input), of(DataTable), of(Network),  # type: ignore[arg-type]
        tuple(a for s in scopes for a in s.assumptions), of(HybridAutomaton), of(System), of(CellularAutomaton),  # type: ignore[arg-type]
        of(Relation), of(FuzzyController), claims, tuple(ctx.cells), tuple(ctx.allowed), lost,  # type: ignore[arg-type]
    )  # fmt: skip
    return spec, ctx.diagnostics
