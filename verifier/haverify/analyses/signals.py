"""Bounded STL and `can always` on clock-driven automata: proofs on the ways through the cells, refutations by a run.

Where the cells are points everything is exact. Where params or starts are unknown, their range is split until every
share is proved, or a run in one of them violates the claim, or the budget is spent.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Set
from fractions import Fraction
from functools import cached_property
from itertools import islice
from typing import Any

from haverify.analyses.clock_model import ClockModel
from haverify.analyses.clocked import Cells, explore, start_box
from haverify.analyses.context import Context, cells_json, cells_name, state_json
from haverify.analyses.counterexample import choices
from haverify.analyses.goals import Answer, goal_hash, known_start, vacuous
from haverify.analyses.motion import Motion
from haverify.analyses.poly_range import Work, simple_between
from haverify.analyses.questions import Setting
from haverify.analyses.signals_cells import Reading, TooManyError, Way, ways
from haverify.analyses.signals_formula import Formula, formula_of
from haverify.analyses.signals_margin import Pairs, robustness
from haverify.analyses.signals_pieces import Item
from haverify.analyses.signals_runs import Followed, assumed, runs
from haverify.analyses.violation import on_params
from haverify.evidence.certificate import run_json
from haverify.evidence.evidence import PartResult
from haverify.evidence.run import Run
from haverify.evidence.verdict import Margin, Proved, Refuted, Unknown, Verdict
from haverify.maths.digits import rational_text
from haverify.model.core import canonical, expr_to_json
from haverify.model.expression import Expr, nodes, number
from haverify.obligations.translate import OutsideFragmentError
from haverify.text.record import field, holder, record, replace

Q = Fraction
Json = Any
FEW, AT_FIRST = 3, 1200  # runs looked at before a proof is sought, and jumps made for that
FURTHER, SLOW = 300, 20  # jumps made in search of a run in a share that is not proved, and when little work is left
SOME = 6  # choices of params for which a run's robustness is looked at
LONG = 80  # dwells of a run beyond which its robustness is not looked at
LEAVES = 48  # shares of the params' and starts' ranges


@record
class Cut:
    """Where a range was split: a param, or a variable of an init line (by its position)."""

    init: int | None
    name: str
    at: Q


@holder
class Share:
    """A part of the ranges of params and starts, with what is known there."""

    model: ClockModel
    reading: Reading | None = None
    proved: bool = False
    cut: Cut | None = None
    halves: tuple[Share, ...] = ()
    why: str = ""


@holder
class Search:
    """The search for a proof or a run, over shares of all ranges."""

    context: Context
    setting: Setting
    stl: Formula
    work: Work
    leaves: int = 0
    run: Followed | None = None
    trouble: tuple[str, str] = ("budget", "")
    roots: dict[object, Q] = field(default_factory=dict)

    @property
    def first_runs(self) -> bool:
        """Whether a run is likely: the order of proof and refutation decides nothing but the work."""
        expected = self.setting.claim.expect
        word = "refuted" if expected is None else expected.verdict
        return (word == "refuted") is (self.setting.goal.kind == "stl")

    @cached_property
    def used(self) -> frozenset[str]:
        """The params that the automaton or the formula reads."""
        machine = next(a for a in self.context.hashes.core["automata"] if a["name"] == self.context.automaton.name)
        text = canonical([machine, *map(expr_to_json, (self.stl.whole, *self.setting.claim.assume))]).decode()
        return frozenset(p for p in self.context.model.params if f'["param","{p}"]' in text)

    @property
    def plain(self) -> tuple[tuple[Expr, Expr], ...]:
        """The atoms as they are."""
        return tuple((a, a) for a in self.stl.atoms)

    def share(self, model: ClockModel, depth: int = 0) -> Share:
        """Prove the formula on a share, or split it; now and then a run that violates it is looked for."""
        found = Share(model)
        self.leaves += 1
        if depth == 0 and self.first_runs:
            self.run = self._violation(model, Work(AT_FIRST), 1, FEW)
        if self.run is None:
            self._prove(found)
        if found.proved or self.run is not None:
            return found
        cut = _widest(model, self.roots, self.used) if self.leaves < LEAVES and self.work.left > 0 else None
        if cut is None or depth % 3 == (0 if self.first_runs else 2):
            self.run = self._violation(model, Work(max(SLOW, min(FURTHER, self.work.left))))
        if cut is not None and self.run is None:
            found.cut = cut
            lower = self.share(_half(model, cut, lower=True), depth + 1)
            upper = [self.share(_half(model, cut, lower=False), depth + 1)] if lower.proved else []
            found.halves = (lower, *upper)
            found.proved = len(found.halves) == 2 and all(h.proved for h in found.halves)
        return found

    def _prove(self, found: Share) -> None:
        root = found.model is self.context.model
        until = self.stl.horizon * Q(17, 16) or Q(1)
        cells = self.context.cells(until) if root else explore(found.model, until)
        if cells.trouble is not None:
            self.trouble, self.leaves = cells.trouble, LEAVES  # shares would not be followed further
            return
        setting = replace(self.setting, model=found.model)
        reading = Reading(setting, cells, self.stl, self.plain, self.work)
        try:
            bad = next((w for w in self._met(reading) if reading.holds(w) is not True), None)
        except TooManyError as e:
            self.trouble = ("budget", str(e))
            return
        if bad is None:
            found.proved, found.reading = True, reading
        else:
            self.trouble = ("budget", _told(cells, [v.cell for v in bad.visits], bad.lost))

    def examples(self) -> Iterator[Followed]:
        """One run for each of a few choices of params."""
        model = self.context.model
        for params in islice(choices(model, {}, on_params(self.setting)), SOME):
            yield from islice(runs(Motion(model, params), self.stl.horizon, Work(AT_FIRST)), 1)

    def margin(self, some: Iterable[Followed], found: Share) -> Margin | None:
        """The robustness on some runs; where the formula is proved, with a bound for all runs."""
        if self.setting.goal.kind != "stl":
            return None

        def everywhere(atoms: Pairs) -> bool:
            return all(_kept(leaf, atoms) for leaf in leaves(found))

        some = (run for run in some if len(run.nodes) <= LONG)
        return robustness(self.stl, some, everywhere if found.proved else None, self.setting.ranges)

    def _met(self, reading: Reading) -> Iterator[Way]:
        """All ways, paid for."""
        for n, way in enumerate(ways(reading)):
            dwells = len(way.visits)
            if not self.work.spend(1 + dwells * (dwells + 100) // 400):
                raise TooManyError(f"the work for one claim is spent after {n} ways through the cells")
            yield way

    def _violation(self, model: ClockModel, jumps: Work, most: int = 24, each: int = 24) -> Followed | None:
        """A run in a share that violates the formula, for some choices of params and some runs for each."""
        self.work.spend(jumps.left // 4)
        setting = replace(self.setting, model=model)
        for params in islice(choices(model, {}, on_params(setting)), most):
            for run in islice(runs(Motion(model, params), self.stl.horizon, jumps), each):
                if run.holds(self.stl, self.plain) is False and assumed(setting, run):
                    return run
        return None


def leaves(share: Share) -> Iterator[Reading]:
    """The shares that were proved as they are."""
    if share.reading is not None:
        yield share.reading
    for half in share.halves:
        yield from leaves(half)


def _kept(reading: Reading, atoms: Pairs) -> bool:
    """Whether the formula holds on all ways with other atoms."""
    other = Reading(reading.setting, reading.cells, reading.stl, atoms, Work())
    return all(other.holds(way) is True for way in ways(other))


def _told(cells: Cells, visited: list[int], lost: bool) -> str:
    names = [cells.model.automaton.modes[cells.cells[i].mode].name for i in visited]
    way = " -> ".join(names[:6]) + (" -> ..." if len(names) > 6 else "")
    return f"not shown for runs through {way}" + (", which may be stuck there" if lost else "")


def decide_signals(context: Context, setting: Setting, number_: int, work: Work) -> Answer:
    """An `stl` goal, or (`can_always` by its negation) that some run keeps a condition."""
    if context.model.rho is None:
        raise OutsideFragmentError("the claim speaks of time, but the modes do not share one rate")
    condition = condition_of(setting)
    if any(n.op == "stuck" for n in nodes(condition)):
        raise OutsideFragmentError("`stuck` in a formula over time; `never stuck` and `can reach stuck` are decided")
    stl = formula_of(condition, context.model.values.number)
    start = known_start(context, setting)
    if start is None:
        return vacuous("no admissible start satisfies what is assumed")
    search = Search(context, setting, stl, work)
    found = search.share(context.model)
    digest = context.hashes.part(goal_hash(context, setting), "goal", "", "")
    answer = Answer("unknown", {})
    if search.run is not None:
        run = as_run(search.run)
        answer.entry = {"kind": "signals", "hash": digest, "run": run_json(run), "atoms": _walked(search.run, stl)}
        answer.verdict, answer.run = "refuted", run
        answer.margin = search.margin([search.run], found)
    elif found.proved:
        name = cells_name(context.automaton.name, *(stl.horizon * Q(17, 16) or Q(1), None))
        start_value = state_json(context.model, *start)
        answer.entry = {"kind": "signals", "hash": digest, "start": start_value, "tree": tree_json(found, name)}
        answer.verdict = "proved"
        answer.margin = search.margin(search.examples(), found)
        if not found.halves:
            answer.cells[name] = context.cells_value(context.cells(stl.horizon * Q(17, 16) or Q(1)))
    else:
        kind, reason = search.trouble
        answer.unknown = Unknown(kind, f"{reason}, and no run that violates it was found")
    return _told_as(setting, number_, answer)


def _told_as(setting: Setting, number_: int, answer: Answer) -> Answer:
    """The answer with its one part; of `can_always`, which the search denied, the other way round."""
    if setting.goal.kind == "can_always":
        answer.verdict = {"proved": "refuted", "refuted": "proved"}.get(answer.verdict, "unknown")
    text = "that some run keeps it" if setting.goal.kind == "can_always" else "the formula at the start of every run"
    decided: dict[str, Verdict] = {"proved": Proved(answer.margin), "refuted": Refuted(answer.margin)}
    verdict = decided.get(answer.verdict) or answer.unknown
    assert verdict is not None, "what is not decided says why"
    answer.parts = [PartResult(number_, "goal", "", "", text, verdict, answer.run)]
    return answer


def condition_of(setting: Setting) -> Expr:
    """The formula that has to hold at the start of every run; for `can_always` the one that no run shall keep."""
    goal, claim = setting.goal, setting.claim
    if goal.kind == "stl":
        return goal.condition
    if claim.time is None:
        raise OutsideFragmentError("`can always` without a horizon; add `within T`")
    return Expr("eventually", (number(0), claim.time, Expr("not", (goal.condition,))))


def as_run(found: Followed) -> Run:
    """The run as reports show it."""
    start = found.nodes[0].state
    mode = found.motion.model.automaton.modes[start.mode].name
    steps = tuple(n.step for n in found.nodes[1:] if n.step is not None)
    return Run(mode, tuple(start.values.items()), tuple(found.motion.params.items()), steps, found.last)


def _letter(value: bool | None) -> str:
    return "u" if value is None else "t" if value else "f"


def _items_json(items: list[Item], trees: bool) -> Json:
    """The shares of a dwell: `[end, closed, truth]`, with the tree where one is asked for."""
    found = []
    for item in items:
        head: list[Json] = [rational_text(item.end[0]), item.end[1] == 1, _letter(item.value)]
        found.append([*head, item.tree] if trees else head)
    return found


def _walked(run: Followed, stl: Formula) -> Json:
    return [[_items_json(x, False) for x in run.items(atom)] for atom in stl.atoms]


def tree_json(share: Share, name: str | None) -> Json:
    """The shares as certificates hold them; the cells of the whole are in a file, those of a share beside it."""
    if share.cut is not None:
        place = ["param", share.cut.name] if share.cut.init is None else ["start", share.cut.init, share.cut.name]
        return ["split", place, rational_text(share.cut.at), *(tree_json(h, None) for h in share.halves)]
    reading = share.reading
    assert reading is not None, "a proved share was read"
    cells: Json = name if name is not None else cells_json(reading.cells)
    return {"cells": cells, "atoms": [_atom_json(reading, a) for a in reading.stl.atoms]}


def _atom_json(reading: Reading, atom: Expr) -> Json:
    cells = reading.cells
    stays = [_items_json(reading.items(i, atom), True) for i in range(len(cells.cells))]
    landed = [(i, k, found) for (i, k, a), found in reading.landings.items() if a == atom and found is not None]
    jumps = [[i, k, _letter(found[0]), found[1]] for i, k, found in landed]
    return {"stays": stays, "jumps": jumps}


def _widest(model: ClockModel, roots: dict[object, Q], used: Set[str]) -> Cut | None:
    """The param that is used or the start whose range is widest, relative to the whole."""
    best: tuple[Q, Cut] | None = None
    for init, name, low, high in (x for x in _ranges(model) if x[0] is not None or x[1] in used):
        width = high - low
        whole = roots.setdefault((init, name), width)
        if width > 0 and (best is None or width / whole > best[0]):
            best = (width / whole, Cut(init, name, simple_between(low, high)))
    return None if best is None else best[1]


def _ranges(model: ClockModel) -> Iterator[tuple[int | None, str, Q, Q]]:
    for p, (low, high) in model.params.items():
        yield None, p, low, high
    for n, init in enumerate(model.automaton.init):
        fixed = {a.var for a in init.assigns if isinstance(a.to, Expr)}
        for mode in range(len(model.automaton.modes)) if init.mode is None else [model.index[init.mode]]:
            for v, x in (start_box(model, init, mode) or {}).items():
                if v in model.reals and v not in fixed and x.low is not None and x.high is not None:
                    yield n, v, x.low, x.high


def _half(model: ClockModel, cut: Cut, *, lower: bool) -> ClockModel:
    """The automaton with the lower or upper half of a range."""
    if cut.init is None:
        low, high = model.params[cut.name]
        ends = (low, cut.at) if lower else (cut.at, high)
        return ClockModel(model.spec, model.automaton, model.values, {**model.params, cut.name: ends})
    init = model.automaton.init[cut.init]
    bound = Expr("<=" if lower else ">=", (Expr("var", (cut.name,)), number(cut.at)))
    narrower = replace(init, where=Expr("and", (init.where, bound)))
    inits = tuple(narrower if n == cut.init else i for n, i in enumerate(model.automaton.init))
    return ClockModel(model.spec, replace(model.automaton, init=inits), model.values, model.params)
