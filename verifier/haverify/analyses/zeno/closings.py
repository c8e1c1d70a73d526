"""What may end all runs of an automaton, and the proof that it does."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

from haverify.analyses.induction.decide import Shown
from haverify.analyses.induction.keep import Keeper
from haverify.analyses.induction.prove import is_defined
from haverify.analyses.induction.refute import Effort
from haverify.analyses.zeno.closing import Closing, Last
from haverify.analyses.zeno.drains import drains
from haverify.analyses.zeno.impacts import impacts
from haverify.analyses.zeno.roots import identity
from haverify.analyses.zeno.staged import staged
from haverify.obligations.formula import Literal, compare
from haverify.obligations.induction import Induction, Obligation
from haverify.obligations.premises import formula_json, members, primitive, whole

Json = Any


def closings(induction: Induction) -> Iterator[Closing]:
    """What may end all runs."""
    if not induction.automaton.edges or induction.has_inputs:
        return
    for kind in (impacts, drains):
        found = next((c for c in kind(induction) if _begins(induction, c)), None)
        if found is not None:
            yield found


def _begins(induction: Induction, closing: Closing) -> bool:
    """Whether the formulas are shown at all starts."""
    first = (ob for ob in induction.parts(closing.formulas) if ob.kind == "init")
    return all(staged(ob.premises, [], Effort()) is not None for ob in first)


def shown_by(induction: Induction, closing: Closing, effort: Effort) -> Shown:
    """A proof of each part up to the first one that has none; only what the goal needs is searched for with effort."""
    parts: list[tuple[Obligation, Json]] = []
    for ob in induction.parts(closing.formulas):
        is_open = bool(parts) and parts[-1][1] is None
        parts.append((ob, None if is_open else _proof(induction, closing, ob, effort)))
    return Shown(induction, closing.formulas, parts)


def _proof(induction: Induction, closing: Closing, ob: Obligation, effort: Effort) -> Json | None:
    if not is_defined(ob):
        return None
    if ob.kept is not None:
        return _flow(induction, ob, closing.last.get(ob.mode), Effort())
    if ob.edge is not None:
        return staged(ob.premises, closing.landing.get(ob.edge, []), Effort())
    is_use = ob.kind == "use"
    return staged(ob.premises, closing.lemmas[ob.mode] if is_use else [], effort if is_use else Effort())


def _flow(induction: Induction, ob: Obligation, last: Last | None, effort: Effort) -> Json | None:
    """Why the flow keeps the formula: what comes before the last literal, then that."""
    keeper = Keeper(induction.field(ob.mode), effort, induction.functions, [], False)
    assert ob.kept is not None
    if last is None or not isinstance(last.literal, Literal):
        return keeper.flow(ob.premises, ob.kept)
    first = keeper.flow(ob.premises, last.before)
    if first is None or not isinstance(first, dict):
        return None
    p = whole(last.literal.polynomial)
    slope = induction.derivative(p, ob.mode)
    known = ob.premises.with_(*members(primitive(last.before), is_and=True))
    if slope.whole:
        rising = compare(">", induction.derivative(last.literal.polynomial, ob.mode))
        proof = identity(known.with_(compare(">", p), rising), last.terms, [rising])
        rule = None if proof is None else {"rule": "growth", "cofactor": [], "band": None, "proof": proof}
    else:
        rule = {"rule": "darboux", "matrix": [[[]]], "ideal": [[]]}
    if rule is None:
        return None
    cut = {"formula": formula_json(primitive(last.literal)), "start": "t", "keep": rule}
    return {"cuts": [*first["cuts"], cut], "end": "t"}
