"""Who decides which claim: everything this version can decide is clock-driven; the rest is `unknown`, and why."""

from __future__ import annotations

from collections.abc import Iterable
from fractions import Fraction
from typing import Any

from haverify.analyses.context import Context
from haverify.analyses.goals import Answer, decide_always, decide_can_reach
from haverify.analyses.inevitable import decide_reach
from haverify.analyses.patience import OutOfTimeError, allowed
from haverify.analyses.poly_range import ENOUGH, Work
from haverify.analyses.questions import Setting
from haverify.analyses.rounding import decide_rounding
from haverify.analyses.sensitivity import with_sensitivities
from haverify.evidence.certificate import certificate
from haverify.evidence.evidence import Evidence
from haverify.evidence.verdict import Proved, Refuted, Unknown, Verdict
from haverify.model.claim import Claim
from haverify.model.expression import Expr, nodes
from haverify.model.spec import Spec
from haverify.obligations.constants import values_of
from haverify.obligations.translate import OutsideFragmentError
from haverify.text.record import field, holder, replace

METHOD = "clocked"
SECONDS = 60  # of CPU time that the usual work may take
OURS = frozenset({"clocked", "poly_range", "poly-range", "exact", "taylor"})
MISSING = {
    "cycle": "`cycle through` beside other goals; write two properties",
    "holds": "`holds` beside goals about runs; write two properties",
}


@holder
class Contexts:
    """The contexts of a spec's automata, made when first asked for."""

    spec: Spec
    known: dict[str, Context] = field(default_factory=dict)
    core: Any = None
    decided: dict[tuple[str, int], Evidence] = field(default_factory=dict)
    # Whether it is a part of the values that a claim asks for.
    is_piece: bool = False
    # The same for systems that are put together, each a spec of its own; those of many modes as far as runs come.
    wholes: dict[tuple[str, bool], Contexts] = field(default_factory=dict)
    parts: dict[str, Any] = field(default_factory=dict)

    def get(self, name: str) -> Context | None:
        """The context of an automaton, None where the name is of something else."""
        if name not in self.known:
            automaton = next((a for a in self.spec.automata if a.name == name), None)
            if automaton is None:
                return None
            self.known[name] = Context(self.spec, automaton, self.core_value())
        return self.known[name]

    def core_value(self) -> Any:
        """The spec's core."""
        from haverify.model.core import to_core

        if self.core is None:
            self.core = to_core(self.spec)
        return self.core


_LAST: list[Contexts] = []


def contexts_of(spec: Spec, core: Any = None) -> Contexts:
    """The contexts of a spec; those of the spec asked for last are kept, because its claims come in shares."""
    if not _LAST or _LAST[0].spec is not spec:
        _LAST[:] = [Contexts(spec, core=core)]
    return _LAST[0]


def decide_all(
    spec: Spec, names: Iterable[str] | None = None, budget: Fraction | None = None, core: Any = None
) -> dict[str, Evidence]:
    """What the analyses propose for the named claims (None: all); `budget` scales the work for each, 1 being usual.

    `core` is the spec's core, where it is at hand.
    """
    wanted = None if names is None else set(names)
    contexts = contexts_of(spec, core)
    units = max(1, int(ENOUGH * (budget if budget is not None else Fraction(1))))
    return {c.name: _decide_once(spec, c, contexts, units) for c in spec.claims if wanted is None or c.name in wanted}


def _decide_once(spec: Spec, claim: Claim, contexts: Contexts, units: int) -> Evidence:
    """What is proposed for a claim; others may use it, and ask again."""
    key = claim.name, units
    if key not in contexts.decided:
        contexts.decided[key] = _in_time(spec, claim, contexts, units)
    return contexts.decided[key]


def _in_time(spec: Spec, claim: Claim, contexts: Contexts, units: int) -> Evidence:
    """What is proposed for a claim, in the time that its work may take at most."""
    seconds = SECONDS * units / ENOUGH
    try:
        with allowed(seconds):
            return decide(spec, claim, contexts, units)
    except OutOfTimeError:
        reason = f"nothing was shown in the {seconds:.2g} s of CPU time allowed"
        return Evidence(Unknown("timeout", reason, next_step="a larger `--budget`"), (), METHOD)


def decide(spec: Spec, claim: Claim, contexts: Contexts | None = None, units: int = ENOUGH) -> Evidence:
    """What the analyses propose for one claim.

    Goals that bring their own horizon (LANGUAGE S21) are looked at up to a shorter one of the property, HA606: what is
    met by then is met, and what is not may still be.
    """
    contexts = contexts or contexts_of(spec)
    found = _proposed(spec, claim, contexts, units)
    if isinstance(found.verdict, Refuted) and _ends_early(contexts, claim):
        reason = "not met up to the horizon of the property, which ends before that of its goal"
        return Evidence(Unknown("horizon", reason, next_step="leave `within` out of the property"), (), found.method)
    return found


def _ends_early(contexts: Contexts, claim: Claim) -> bool:
    """Whether the property's horizon ends before that of a goal that asks for something to be reached."""
    context = contexts.get(claim.on or "")
    goals = [g for g in claim.goals if g.kind in ("reach", "can_reach") and g.within is not None]
    if claim.time is None or not goals or context is None:
        return False
    values = values_of(context.spec, context.automaton)
    last = values.number(claim.time)
    return any(values.number(g.within) > last for g in goals if g.within is not None)


def _proposed(spec: Spec, claim: Claim, contexts: Contexts, units: int) -> Evidence:
    """What the analyses propose."""
    if all(g.kind == "holds" for g in claim.goals):
        from haverify.analyses.holds import decide_holds

        return decide_holds(spec, claim, contexts.core_value(), units)
    if any(s.name == claim.on for s in spec.systems):
        return _of_system(contexts, claim, units)
    context = contexts.get(claim.on or "")
    if context is not None and all(g.kind == "cycle" for g in claim.goals) and not claim.which:
        return _by_return(context, claim)
    missing = _missing(spec, claim)
    if missing is not None:
        return Evidence(Unknown("fragment", missing), (), METHOD)
    assert context is not None, "claims about no automaton are sorted out before"
    if claim.which:
        return _by_pieces(contexts, context, claim, units)
    try:
        found = _decide(context, claim, units)
    except OutsideFragmentError as e:
        return _by_flows(contexts, context, claim, str(e), units)
    if isinstance(found.verdict, Unknown) and not claim.inductive:
        found = _by_closing(contexts, context, claim, units, False) or found
    return _by_induction(contexts, context, claim, found, units) if claim.inductive else found


def _by_return(context: Context, claim: Claim) -> Evidence:
    """What is shown of periodic orbits."""
    from haverify.analyses.orbits.decide import METHOD as RETURN
    from haverify.analyses.orbits.decide import decide_cycle

    try:
        return decide_cycle(context.spec, context.automaton, claim, context.core)
    except OutsideFragmentError as e:
        return Evidence(Unknown("fragment", str(e)), (), RETURN)


def _of_system(contexts: Contexts, claim: Claim, units: int) -> Evidence:
    """What is shown of a system: as one of clocks, or put together as one automaton."""
    from haverify.analyses.zones import decide_network

    found = decide_network(claim, contexts.core_value(), Fraction(units, ENOUGH))
    if not isinstance(found.verdict, Unknown) or found.verdict.kind != "fragment":
        return found
    name = claim.on or ""
    lazily = None if _is_endless(claim) else _lazily(contexts, claim, units)
    if lazily is not None and not isinstance(lazily.verdict, Unknown):
        return lazily
    try:
        inner = _whole(contexts, name, claim.inductive)
        told = next(c for c in inner.spec.claims if c.name == claim.name)
        whole = decide(inner.spec, told, inner, units)
    except OutsideFragmentError as e:
        if lazily is not None:
            return lazily
        return replace(found, verdict=replace(found.verdict, reason=f"{found.verdict.reason}; put together: {e}"))
    if isinstance(whole.verdict, Unknown) and whole.verdict.kind == "fragment":
        more = f"{found.verdict.reason}; put together: {whole.verdict.reason}"
        return replace(whole, verdict=replace(whole.verdict, reason=more))
    made = whole.certificate
    return whole if made is None else replace(whole, certificate={**made, "whole": True})


def _whole(contexts: Contexts, name: str, everywhere: bool) -> Contexts:
    """A system put together, with modes that no edge leads to if `everywhere`."""
    if (name, everywhere) not in contexts.wholes:
        from haverify.analyses.networks.whole import whole_of

        spec = whole_of(contexts.spec, name, contexts.core_value(), everywhere=everywhere)
        contexts.wholes[name, everywhere] = Contexts(spec)
    return contexts.wholes[name, everywhere]


def _lazily(contexts: Contexts, claim: Claim, units: int) -> Evidence | None:
    """What is shown of a system of which only the modes are listed to which runs come; None where it is another."""
    from haverify.analyses.networks.lazily import decide_lazily

    budget = Fraction(units, ENOUGH)
    return decide_lazily(contexts.parts, contexts.spec, contexts.core_value(), claim, budget)


def _by_pieces(contexts: Contexts, context: Context, claim: Claim, units: int) -> Evidence:
    """What is shown for which values of a param; invariants that the claim uses are those of the whole range."""
    from haverify.analyses.which import decide_which

    used = {(n, units): _decide_once(contexts.spec, c, contexts, units) for c in contexts.spec.claims
            if (n := c.name) in claim.using}  # fmt: skip

    def piece(spec: Spec, alone: Claim) -> Evidence:
        return decide(spec, alone, Contexts(spec, decided=dict(used), is_piece=True), units)

    return decide_which(contexts.spec, context.automaton, claim, piece)


def _by_closing(contexts: Contexts, context: Context, claim: Claim, units: int, is_deep: bool) -> Evidence | None:
    """What is shown by an end of all runs, where jumps accumulate; None where that decides nothing."""
    from haverify.analyses.induction.refute import Effort
    from haverify.analyses.zeno.decide import decide_closing

    if not context.automaton.edges or _unproved(contexts, context, claim, units) is not None:
        return None
    try:
        return decide_closing(context.spec, context.automaton, claim, context.core, Effort(is_deep=is_deep))
    except OutsideFragmentError:
        return None


def _by_following(context: Context, claim: Claim) -> Evidence | None:
    """What is shown by flowpipes through some jumps and an end of all runs after them; None where that is nothing."""
    from haverify.analyses.induction.refute import Effort
    from haverify.analyses.zeno.following import decide_following

    if not context.automaton.edges:
        return None
    try:
        return decide_following(context.spec, context.automaton, claim, context.core, Effort())
    except OutsideFragmentError:
        return None


def _by_laws(context: Context, claim: Claim, units: int) -> Evidence | None:
    """What flowpipes show where comparisons of what all runs keep are decided by the starts; None where nothing."""
    from haverify.analyses.hybrid.conserved import decides
    from haverify.analyses.hybrid.decide import decide_flow

    if claim.inductive or claim.using:
        return None
    try:
        if not decides(context.spec, context.automaton, claim):
            return None
        budget = Fraction(units, ENOUGH)
        found = decide_flow(context.spec, context.automaton, claim, context.core, budget, context.trees, with_laws=True)
    except OutsideFragmentError:
        return None
    return None if isinstance(found.verdict, Unknown) else found


def _by_induction(contexts: Contexts, context: Context, claim: Claim, before: Evidence, units: int) -> Evidence:
    """What an invariant shows of a claim that was not decided before."""
    if not isinstance(before.verdict, Unknown) or any(g.kind not in ("always", "can_reach") for g in claim.goals):
        return before
    from haverify.analyses.induction.decide import decide_invariant

    unproved = _unproved(contexts, context, claim, units)
    if unproved is not None:
        return Evidence(unproved, (), before.method)
    try:
        found = decide_invariant(context.spec, context.automaton, claim, context.core, Fraction(units, ENOUGH))
    except OutsideFragmentError:
        return before
    if claim.inductive or not isinstance(found.verdict, Unknown):
        return found
    if _is_steady(context) or found.verdict.kind == "vacuous":
        return before
    more = f"{before.verdict.reason}; no invariant was found that shows it"
    return replace(before, verdict=replace(before.verdict, reason=more))


def _unproved(contexts: Contexts, context: Context, claim: Claim, units: int) -> Unknown | None:
    """Why the invariants that a claim uses may not be used: one of them is not proved."""
    for used in (c for c in context.spec.claims if c.name in claim.using):
        if not isinstance(_decide_once(context.spec, used, contexts, units).verdict, Proved):
            return Unknown("dependency", f"it uses `{used.name}`, which is not proved")
    return None


def _by_flows(contexts: Contexts, context: Context, claim: Claim, reason: str, units: int) -> Evidence:
    """What is shown by an end of all runs, and by flowpipes or an invariant; what takes less comes first."""
    if contexts.is_piece:
        return _by_pipes(contexts, context, claim, reason, units)
    is_endless, is_first = _is_endless(claim), not claim.using and _may_be_closed(claim)
    ended = _by_closing(contexts, context, claim, units, is_endless) if is_first else None
    if ended is not None:
        return ended
    found = _by_pipes(contexts, context, claim, reason, units)
    if not isinstance(found.verdict, Unknown):
        return found
    ended = None if is_endless and is_first else _by_closing(contexts, context, claim, units, True)
    return ended or _by_following(context, claim) or _by_laws(context, claim, units) or found


def _may_be_closed(claim: Claim) -> bool:
    """Whether an end of all runs may show what is claimed; what one run does it does not show."""
    by_a_run = {"proved": "can_reach", "refuted": "always"}
    expected = claim.expect.verdict if claim.expect is not None else "proved"
    return all(g.kind != by_a_run.get(expected) for g in claim.goals)


def _by_pipes(contexts: Contexts, context: Context, claim: Claim, reason: str, units: int) -> Evidence:
    """What flowpipes show, or an invariant; that comes first where there is no horizon, or others are used."""
    if not claim.using and not _is_endless(claim):
        return _by_induction(contexts, context, claim, _by_flowpipe(context, claim, reason, units), units)
    unproved = _unproved(contexts, context, claim, units)
    if unproved is not None:
        return Evidence(unproved, (), METHOD)
    found = _by_induction(contexts, context, claim, Evidence(Unknown("fragment", reason), (), METHOD), units)
    if claim.inductive or not isinstance(found.verdict, Unknown) or found.verdict.kind in ("dependency", "vacuous"):
        return found
    flow = _by_flowpipe(context, claim, reason, units)
    if not isinstance(flow.verdict, Unknown) or found.verdict.reason == reason:
        return flow
    more = f"{flow.verdict.reason}; no invariant was found that shows it"
    return replace(flow, verdict=replace(flow.verdict, reason=more))


def _is_endless(claim: Claim) -> bool:
    """Whether all goals speak of all time."""
    has_end = any(g.within is not None or g.window is not None or g.kind in ("reach", "stl") for g in claim.goals)
    return claim.time is None and claim.jumps is None and not has_end


def _is_steady(context: Context) -> bool:
    """Whether every rate is a number."""
    lines = [line for m in context.automaton.modes for line in m.flow]
    return all(isinstance(line.rate, Expr) and line.rate.op == "num" for line in lines)


def _by_flowpipe(context: Context, claim: Claim, reason: str, units: int) -> Evidence:
    """What flowpipes show of a claim that the analysis of clocks cannot decide for the reason given."""
    if _is_steady(context):
        return Evidence(Unknown("fragment", reason), (), METHOD)
    from haverify.analyses.hybrid.decide import METHOD as TAYLOR
    from haverify.analyses.hybrid.decide import decide_flow
    from haverify.analyses.hybrid.shared import Trees

    context.trees = context.trees or Trees()
    budget = Fraction(units, ENOUGH)
    try:
        found = decide_flow(context.spec, context.automaton, claim, context.core, budget, context.trees)
    except OutsideFragmentError as e:
        found = Evidence(Unknown("fragment", str(e)), (), TAYLOR)
    return _by_rates(context, claim, budget, found) if isinstance(found.verdict, Unknown) else found


def _by_rates(context: Context, claim: Claim, budget: Fraction, before: Evidence) -> Evidence:
    """What flowpipes show where bounds of the rates of inputs count; before that, what their ranges show."""
    from haverify.analyses.hybrid.decide import decide_flow
    from haverify.analyses.hybrid.rated import with_rates

    rated = with_rates(context.spec, context.automaton, claim)
    if rated is None:
        return before
    try:
        stated = context.hashes, claim
        found = decide_flow(rated.spec, rated.automaton, rated.claim, context.core, budget, stated=stated)
    except OutsideFragmentError:
        return before
    is_known = isinstance(before.verdict, Unknown) and before.verdict.kind != "fragment"
    return before if is_known and isinstance(found.verdict, Unknown) else found


def _missing(spec: Spec, claim: Claim) -> str | None:
    """What a claim asks for that no analysis here does."""
    kinds = [g.kind for g in claim.goals if g.kind in MISSING]
    if kinds:
        return MISSING[kinds[0]]
    if claim.on is None or all(a.name != claim.on for a in spec.automata):
        named = f"`{claim.on}` is no automaton" if claim.on else "the claim names no automaton"
        return f"{named}: systems, rules and fuzzy controllers are not decided in this version"
    if claim.method is not None and claim.method[0] not in OURS:
        return f"`method {claim.method[0]}` is not in this version; without it the exact analysis of clocks is used"
    return None


def _decide(context: Context, claim: Claim, units: int) -> Evidence:
    answers: list[Answer] = []
    settings: list[Setting] = []
    context.explorers.allow(Fraction(units, ENOUGH))
    for number, goal in enumerate(claim.goals):
        setting = Setting(context.model, claim, goal, context.ranges, units=units)
        settings.append(setting)
        answers.append(_goal(context, setting, number, Work(units)))
    verdict = _combined(claim, answers)
    parts = tuple(with_sensitivities(context, settings, answers, isinstance(verdict, Refuted)))
    notes = tuple(n for a in answers for n in a.notes)
    if isinstance(verdict, Unknown):
        return Evidence(verdict, parts, METHOD, notes=notes)
    word = "proved" if isinstance(verdict, Proved) else "refuted"
    second, rounding = decide_rounding(context, settings, answers, word, units)
    entries = [a.entry for a in answers]
    cells = {k: v for a in answers for k, v in a.cells.items()}
    run = min((a.run for a in answers if a.run is not None), key=lambda r: len(r.steps), default=None)
    return Evidence(verdict, parts, METHOD, certificate(claim.name, word, entries, second), cells, rounding, run, notes)


def _goal(context: Context, setting: Setting, number: int, work: Work) -> Answer:
    if setting.goal.kind in ("stl", "can_always"):
        from haverify.analyses.signals import decide_signals

        return decide_signals(context, setting, number, work)
    if any(n.op == "stuck" for n in nodes(setting.goal.condition)) and not _is_stuck_goal(setting):
        raise OutsideFragmentError("`stuck` inside a larger condition; `never stuck` and `can reach stuck` are decided")
    if setting.goal.kind == "always":
        return decide_always(context, setting, number, work)
    if setting.goal.kind == "can_reach":
        return decide_can_reach(context, setting, number, work)
    return decide_reach(context, setting, number, work)


def _is_stuck_goal(setting: Setting) -> bool:
    e = setting.goal.condition
    if setting.goal.kind == "always":
        return e.op == "not" and e.children[0].op == "stuck"
    return setting.goal.kind == "can_reach" and e.op == "stuck"


def _combined(claim: Claim, answers: list[Answer]) -> Verdict:
    """Goals are a conjunction: refuted if one is, proved if all are (LANGUAGE S26)."""
    margins = [a.margin for a in answers if a.margin is not None]
    worst = min(margins, key=lambda m: m.low, default=None)
    if any(a.verdict == "refuted" for a in answers):
        return Refuted(
            min((a.margin for a in answers if a.margin and a.verdict == "refuted"), key=lambda m: m.low, default=None)
        )
    open_ = next((a for a in answers if a.verdict == "unknown"), None)
    if open_ is not None:
        return open_.unknown or Unknown("budget", "not decided")
    if claim.inductive:
        return Unknown(
            "fragment",
            "true on all runs, but whether it is inductive (LANGUAGE S22) is not decided in this version",
            next_step="leave out `inductive`",
        )
    return Proved(worst)
