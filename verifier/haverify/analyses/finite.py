"""Claims without time about cells, rules, relations and constants: decided by trying all values of the bound names."""

from __future__ import annotations

from collections.abc import Mapping
from fractions import Fraction
from typing import Any

from haverify.analyses.finite_params import admissible, denied_at, ranges_of, shown_on_boxes, tried
from haverify.analyses.finite_telling import Telling
from haverify.analyses.holds import Held
from haverify.analyses.poly_range import ENOUGH
from haverify.evidence.verdict import Proved, Refuted, Unknown
from haverify.maths.digits import rational_text
from haverify.maths.exact import decimal_text
from haverify.model.claim import Claim, Goal
from haverify.model.expression import Expr, nodes
from haverify.model.spec import Spec
from haverify.obligations.obligation import goal_digest
from haverify.obligations.translate import OutsideFragmentError
from haverify.solvers.finite_truth import USUAL, Finite
from haverify.solvers.finite_world import Cell, NotFiniteError, TooMuchError, World
from haverify.text.record import replace

Json = Any
Point = Mapping[str, Fraction]
CELLS = frozenset({"forall", "exists", "unique", "next", "unique_rule", "apply", "related", "field", "cell", "sym"})
NO_POINT = "no values of the params were found under which everything assumed holds"
OURS = frozenset({"exact", "enumeration"})


def decide_finite(spec: Spec, claim: Claim, goal: Goal, core: Mapping[str, Json], units: int) -> Held:
    """A goal for all values of its bound names and of the params, under what is assumed."""
    held = _decided(spec, claim, goal, units)
    return replace(held, entry={**held.entry, "hash": goal_digest(core, claim, goal)}) if held.entry else held


def _decided(spec: Spec, claim: Claim, goal: Goal, units: int) -> Held:
    if claim.which:
        return _outside("`for which` needs a split of the params' range, which this version does not have")
    if claim.method is not None and claim.method[0] not in OURS:
        return _outside(f"`method {claim.method[0]}` does not decide goals without time; leave it out")
    try:
        assumed = (*spec.assumptions, *claim.assume)
        point = admissible(spec, claim.on, assumed)
        if point is None:
            return Held(Unknown("vacuous", NO_POINT if ranges_of(spec, claim.on) else "what is assumed does not hold"))
        return _either(spec, claim, goal.condition, point, units)
    except (NotFiniteError, OutsideFragmentError) as e:
        return _outside(str(e))


def _either(spec: Spec, claim: Claim, e: Expr, point: Point, units: int) -> Held:
    """By trying all values of the bound names; where numbers decide that are not rational, or params, on boxes."""
    try:
        return _enumerated(spec, claim, e, point, units)
    except TooMuchError as reason:
        return Held(Unknown("budget", str(reason), next_step="use fewer quantifiers inside each other, or `--budget`"))
    except NotFiniteError as reason:
        if any(n.op in CELLS for n in nodes(e)):
            return _outside(f"{reason}, in a goal about cells or relations")
        return _for_all_params(spec, claim, e, units)


def _outside(reason: str) -> Held:
    return Held(Unknown("fragment", reason))


def _enumerated(spec: Spec, claim: Claim, e: Expr, point: Point, units: int) -> Held:
    finite = Finite(World(spec, claim.on), USUAL * units // ENOUGH)
    telling = Telling(spec, finite)
    truth = finite.truth(e, {})
    if truth is None:
        return Held(telling.undefined(e), text=telling.text(e))
    if truth and telling.is_vacuous(e):
        return Held(Unknown("vacuous", "the premise is never true", next_step="correct the premise"))
    path = _path(finite, e, truth)
    witness = tuple((name, finite.world.label(cell)) for name, cell in path)
    facts = () if truth else telling.facts(e)
    verdict = Proved() if truth else Refuted()
    return Held(verdict, _entry(path, point), telling.text(e), witness, facts, telling.orbits(claim.on))


def _entry(path: list[tuple[str, Cell]], point: Point) -> Json:
    if not path:
        return {"kind": "enumerated", "params": _numbers(point)}
    return {"kind": "witness", "params": _numbers(point), "values": [[name, bits] for name, (_, bits) in path]}


def _path(finite: Finite, e: Expr, truth: bool) -> list[tuple[str, Cell]]:
    """Values of the first quantifiers that decide the goal: of `forall` where it is false, `exists` where true."""
    kind = "exists" if truth else "forall"
    path: list[tuple[str, Cell]] = []
    env: dict[str, Cell] = {}
    while e.op == kind:
        body = finite.body(e, env)
        at = body.yes if truth else body.no
        cell = finite.world.cells(str(e.args[1])).cells[(at & -at).bit_length() - 1]
        path.append((e.name, cell))
        env = {**env, e.name: cell}
        (e,) = e.children
    return path


def _for_all_params(spec: Spec, claim: Claim, e: Expr, units: int) -> Held:
    """A goal that params decide: false at a point that is tried, or shown on the whole box."""
    assumed = (*spec.assumptions, *claim.assume)
    text = Telling(spec, Finite(World(spec, claim.on))).text(e)
    truth, point = tried(spec, claim.on, assumed, e)
    if truth is None and point:
        where = ", ".join(f"{p} = {v}" for p, v in _values(spec, point))
        return Held(Unknown("undefined", f"something in it has no value for {where}"), text=text)
    if truth is False:
        finite = Finite(World(spec, claim.on, dict(point)), USUAL * units // ENOUGH)
        path = _path(finite, e, truth=False)
        witness = (*((name, finite.world.label(cell)) for name, cell in path), *_values(spec, point))
        entry = {"kind": "witness", "params": _numbers(point), "values": [[n, bits] for n, (_, bits) in path]}
        return Held(Refuted(), entry, text, witness)
    at = admissible(spec, claim.on, assumed, bool(ranges_of(spec, claim.on)))
    if at is None:
        return Held(Unknown("vacuous", NO_POINT), text=text)
    tree = shown_on_boxes(spec, claim.on, assumed, e, units)
    if tree is not None:
        return Held(Proved(), _boxes("proved", at, tree), text)
    tree = denied_at(spec, claim.on, at, e, units)
    if tree is not None:
        return Held(Refuted(), _boxes("refuted", at, tree), text, _values(spec, at))
    return Held(Unknown("budget", "neither a proof for all params nor values that refute it were found"), text=text)


def _boxes(verdict: str, point: Point, tree: Json) -> Json:
    return {"kind": "boxes", "verdict": verdict, "params": _numbers(point), "proof": tree}


def _numbers(point: Point) -> dict[str, str]:
    return {p: rational_text(q) for p, q in point.items()}


def _values(spec: Spec, point: Point) -> tuple[tuple[str, str], ...]:
    """Values of params with their units, as people read them."""
    named = [(p.name, p.unit) for group in (spec.params, *(a.params for a in spec.automata)) for p in group]
    units = {name: str(unit) for name, unit in named if unit is not None and str(unit) != "1"}
    return tuple((p, f"{decimal_text(q) or rational_text(q)} {units.get(p, '')}".strip()) for p, q in point.items())
