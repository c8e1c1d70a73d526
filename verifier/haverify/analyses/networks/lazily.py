"""A system of many modes, put together as far as its runs come: what flowpipes show of it.

The product is listed in the modes that flowpipes came to, and one jump further. Where they come to a mode whose edges
are not listed, these are, and all flowpipes are followed again; so what is shown in the end rests on no such mode.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from fractions import Fraction
from typing import Any

from haverify.analyses.hybrid.decide import decide_flow
from haverify.analyses.hybrid.question import OpenModesError
from haverify.analyses.hybrid.shared import Trees
from haverify.analyses.networks.product import Product, TooManyError
from haverify.analyses.networks.whole import told
from haverify.evidence.evidence import Evidence
from haverify.model.claim import Claim
from haverify.model.core import to_core
from haverify.model.spec import Spec
from haverify.obligations.translate import OutsideFragmentError
from haverify.text.record import field, holder, replace

Json = Any
FEW = 40  # modes that are all listed at once
LISTED = 400  # modes whose edges are listed, at most


@holder
class Listed:
    """A system as far as it is listed, with what is known of it, for all claims on it."""

    product: Product
    trees: Trees = field(default_factory=Trees)
    spec: Spec | None = None
    core: Json = None

    def list_edges(self, modes: Iterable[str]) -> None:
        """List the edges of some modes and of no others; fields that are compiled stay so."""
        self.product.list_edges(modes)
        self.trees, self.spec = Trees(compiled=self.trees.compiled), None

    def shown(self, claim: Claim, budget: Fraction) -> Evidence:
        """What flowpipes show of a claim, if they do not come to other modes."""
        if self.spec is None:
            self.spec = told(self.product, [])
            self.core = to_core(self.spec)
        self.trees.seen.clear()
        asked = self.product.claim(claim)
        spec = replace(self.spec, claims=(asked,))
        return decide_flow(spec, spec.automata[0], asked, self.core, budget, self.trees)


def listed(spec: Spec, core: Mapping[str, Json], name: str) -> Listed | None:
    """A system of which only the modes should be listed to which runs come; None where it is small, or of clocks."""
    try:
        Product(spec, core, name, most=FEW)
    except TooManyError:
        product = Product(spec, core, name, frozenset())
        return Listed(product) if _has_flows(product) else None
    return None


def _has_flows(product: Product) -> bool:
    """Whether some rate is not a number."""
    modes = [m for p in product.parts for m in p.model["modes"]]
    return any(not isinstance(f.get("rate"), str) for m in modes for f in m["flow"])


def decide_lazily(
    known: dict[str, Listed | None], spec: Spec, core: Mapping[str, Json], claim: Claim, budget: Fraction
) -> Evidence | None:
    """What flowpipes show of a claim with a horizon on a system; None where it is small, or flowpipes do not serve.

    `known` are the systems looked at before, by name.
    """
    if claim.inductive or claim.using or claim.which:
        return None
    name = claim.on or ""
    try:
        if name not in known:
            known[name] = listed(spec, core, name)
        found = known[name]
        return None if found is None else _decided(found, claim, budget)
    except OutsideFragmentError:
        return None


def _decided(found: Listed, claim: Claim, budget: Fraction) -> Evidence:
    """What is shown along flowpipes, in as many rounds as it takes until they come to listed modes only."""
    for _ in range(2 * LISTED):
        if len(found.product.left or ()) > LISTED:
            break
        try:
            shown = found.shown(claim, budget)
        except OpenModesError as e:
            found.list_edges({*(found.product.left or ()), *e.modes})
            continue
        needed = found.product.started | found.trees.seen
        if needed != found.product.left:  # others were listed for other claims
            found.list_edges(needed)
            continue
        made = shown.certificate
        return shown if made is None else replace(shown, certificate={**made, "whole": sorted(needed)})
    raise OutsideFragmentError(f"runs come to more than {LISTED} modes of all parts together")
