"""Proofs of parts by steps: lemmas are cut in one after the other, each shown from those before it."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from haverify.analyses.induction.prove import prove
from haverify.analyses.induction.refute import Effort, refute
from haverify.analyses.zeno.roots import Lemma, by_identity
from haverify.obligations.formula import negation
from haverify.obligations.premises import Premises, formula_json, primitive

Json = Any
GLANCE = Effort(32, 8)


def staged(premises: Premises, lemmas: Sequence[Lemma], effort: Effort) -> Json | None:
    """A PROOF that the premises have no common point; lemmas that are not shown are left out."""
    if not lemmas:
        return prove(premises, effort)
    first, rest = primitive(lemmas[0].formula), lemmas[1:]
    against = premises.with_(negation(first))
    why = None if first is True else by_identity(against, lemmas[0]) or refute(against, GLANCE)
    if why is None:
        return staged(premises, rest, effort)
    inner = staged(premises.with_(first), rest, effort)
    return None if inner is None else ["cut", formula_json(first), inner, why]
