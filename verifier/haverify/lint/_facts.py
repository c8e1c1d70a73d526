"""What rules share: scopes, outcomes of edges, texts of spans, decisions, and the findings nobody could decide."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from fractions import Fraction
from functools import cached_property
from typing import Any, TypeVar

from haverify.diagnostics.diagnostic import Diagnostic
from haverify.lint._wording import edge_name
from haverify.maths.polynomial import Polynomial, constant, variable
from haverify.model.expression import Expr
from haverify.model.hybrid import Assign, Edge, HybridAutomaton, Init, Mode
from haverify.model.spec import Spec
from haverify.solvers.answer import Answer, Contradiction, Holds, Undecided
from haverify.solvers.conditions import Condition, decide
from haverify.solvers.frame import Frame, Scope
from haverify.solvers.literals import Case, Literal, TooManyCasesError, terms
from haverify.text.record import field, holder, record
from haverify.text.source import Source
from haverify.text.span import Span

T = TypeVar("T")

AFTER = "'"  # ends the name of the value an edge chooses


@record
class Outcome:
    """What assignments make of the variables: `values`, under the condition `case`, both read before them."""

    values: Mapping[str, Polynomial]
    case: Case


@record
class EdgeState:
    """`kind`: live, never enabled, lands outside, target empty, or empty by itself (guard or source's domain).

    `answer` says why; `leaving` is a state in which the guard holds though every outcome lies outside.
    """

    kind: str
    answer: Answer
    leaving: Answer | None = None


@holder
class Facts:
    """Derived facts about one spec, computed when first asked for."""

    spec: Spec
    sources: Mapping[str, Source] = field(default_factory=dict)
    undecided: list[Diagnostic] = field(default_factory=list)
    _scopes: dict[str, Scope] = field(default_factory=dict)
    _memory: dict[object, Any] = field(default_factory=dict)

    def remembered(self, key: object, compute: Callable[[], T]) -> T:
        """The value computed when `key` was first asked for."""
        if key not in self._memory:
            self._memory[key] = compute()
        found: T = self._memory[key]
        return found

    # ---- texts -------------------------------------------------------------------

    def text(self, span: Span | None) -> str:
        """The text of a span, empty where it is not known."""
        source = self.sources.get(span.path) if span else None
        return source.at(span) if source and span else ""

    # ---- names -------------------------------------------------------------------

    def scope(self, automaton: HybridAutomaton | None) -> Scope:
        """The scope of an automaton, or of the top level."""
        name = automaton.name if automaton else ""
        if name not in self._scopes:
            self._scopes[name] = Scope(self.spec, automaton)
        return self._scopes[name]

    def frame(self, automaton: HybridAutomaton | None, mode: Mode | None = None) -> Frame:
        """How names are read in a mode of an automaton."""
        return Frame(self.scope(automaton), mode)

    @cached_property
    def automata(self) -> dict[str, HybridAutomaton]:
        return {a.name: a for a in self.spec.automata}

    @cached_property
    def synced(self) -> frozenset[str]:
        """Names of edges that some interaction mentions: they do not fire alone."""
        named = (e for s in self.spec.systems for sync in s.syncs for e in (*sync.edges, *sync.listeners))
        return frozenset(e.rsplit(".", 1)[-1] for e in named)

    def modes(self, automaton: HybridAutomaton) -> dict[str, Mode]:
        """The modes of an automaton by name."""
        return self.remembered(("modes", automaton.name), lambda: {m.name: m for m in automaton.modes})

    # ---- resets ------------------------------------------------------------------

    def outcomes(self, frame: Frame, assigns: Sequence[Assign], mark: str = AFTER) -> list[Outcome]:
        """The values of the variables after assignments whose right sides are read in `frame`.

        A value chosen from a set is an unknown: the variable's name with `mark`.

        Raises
        ------
        TooManyCasesError       where the right sides have too many cases
        """
        found = [Outcome(frame.values, ())]
        for assign in assigns:
            found = [
                Outcome({**o.values, assign.var: value}, o.case + case)
                for o in found
                for case, value in _assigned(assign, frame, mark)
            ]
        return found

    # ---- decisions ---------------------------------------------------------------

    def decide(
        self, code: str, place: str, span: Span | None, conditions: Sequence[Condition], case: Case = ()
    ) -> Answer:
        """`decide`, with a HA900 for what stays open: `place` says where the check named by `code` was made."""
        answer = decide(conditions, case)
        if isinstance(answer, Undecided):
            self.leave_open(code, place, answer.reason, span)
        elif isinstance(answer, Holds) and not answer.is_exact:
            self.leave_open(code, place, "a part of the condition is no polynomial", span)
        return answer

    def leave_open(self, code: str, place: str, reason: str, span: Span | None) -> None:
        """Say once that a check could not decide."""
        message = f"{code} for {place}: {reason}"
        if all(d.message != message for d in self.undecided):
            self.undecided.append(Diagnostic("HA900", message, span))

    def edge(self, automaton: HybridAutomaton, edge: Edge) -> EdgeState:
        """How far an edge of the automaton gets, from some state of its source's domain."""
        return self.remembered(("edge", automaton.name, id(edge)), lambda: self.edge_state(automaton, edge))

    def edge_state(self, automaton: HybridAutomaton, edge: Edge) -> EdgeState:
        """The same for an edge that need not be one of the automaton's."""
        modes = self.modes(automaton)
        source, target = self.frame(automaton, modes[edge.source]), modes[edge.target]
        domain, guard = Condition(modes[edge.source].domain, source, closed=True), Condition(edge.guard, source)
        outcomes = self.reset("HA306", edge, source)
        landings = [
            decide([domain, guard, Condition(target.domain, source.after(target, o.values), closed=True)], o.case)
            for o in outcomes
        ]
        if not landings or not all(isinstance(a, Contradiction) for a in landings):
            self._note_open(landings, "HA306", edge)
            return EdgeState("live", any_of(landings) if landings else Undecided("too many cases"))
        leaving = decide([domain, guard])
        if not isinstance(leaving, Contradiction):
            into = decide([Condition(target.domain, self.frame(automaton, target), closed=True)])
            is_fault = not isinstance(into, Contradiction)
            return EdgeState("lands outside" if is_fault else "target empty", any_of(landings), leaving)
        alone = [decide([domain]), decide([guard])]
        is_empty = any(isinstance(a, Contradiction) for a in alone)
        return EdgeState("empty by itself" if is_empty else "never enabled", leaving)

    def _note_open(self, answers: Sequence[Answer], code: str, edge: Edge) -> None:
        for a in answers:
            if isinstance(a, Undecided) and not any(isinstance(b, Holds) for b in answers):
                self.leave_open(code, edge_name(edge), a.reason, edge.span)

    def reset(self, code: str, edge: Edge, frame: Frame) -> list[Outcome]:
        """The outcomes of an edge; none, and the check left open, where there are too many."""
        try:
            return self.outcomes(frame, edge.resets)
        except TooManyCasesError:
            self.leave_open(code, edge_name(edge), "the reset has too many cases", edge.span)
            return []

    # ---- starts ------------------------------------------------------------------

    def has_start(self, automaton: HybridAutomaton) -> bool:
        """Whether a start may exist; where there is certainly none nothing else of the automaton is worth reporting."""
        return self.remembered(
            ("start", automaton.name),
            lambda: any(
                not isinstance(self.start(automaton, mode, init), Contradiction)
                for init in automaton.init
                for mode in allowed(automaton, init)
            ),
        )

    def start(self, automaton: HybridAutomaton, mode: Mode, init: Init, in_domain: bool | None = True) -> Answer:
        """Whether `init` allows a start in `mode` that is in the domain (`in_domain`), outside, or anywhere (None)."""
        frame = self.frame(automaton, mode)
        try:
            outcomes = self.outcomes(frame, init.assigns)
        except TooManyCasesError:
            return Undecided("the start has too many cases")
        answers = []
        for o in outcomes:
            after = frame.after(mode, o.values)
            conditions = [Condition(init.where, after)]
            if in_domain is not None:
                conditions.append(Condition(mode.domain, after, holds=in_domain, closed=True))
            answers.append(decide(conditions, (*o.case, Literal(variable("time"), "=="))))
        return any_of(answers)

    def is_start(self, automaton: HybridAutomaton, mode: Mode, point: Mapping[str, Fraction]) -> bool:
        """Whether a state certainly is one that an init line allows."""
        here = tuple(
            Literal(variable(n) - constant(v), "==") for n, v in point.items() if n in self.scope(automaton).vars
        )
        for init in automaton.init:
            if init.mode in (None, mode.name) and not init.assigns:
                frame = self.frame(automaton, mode)
                answer = decide([Condition(init.where, frame), Condition(mode.domain, frame, closed=True)], here)
                if isinstance(answer, Holds) and answer.is_exact:
                    return True
            elif init.mode in (None, mode.name) and self._assigns(automaton, mode, init, point):
                return True
        return False

    def _assigns(self, automaton: HybridAutomaton, mode: Mode, init: Init, point: Mapping[str, Fraction]) -> bool:
        frame = self.frame(automaton, mode)
        for o in self.outcomes(frame, init.assigns):
            names = self.scope(automaton).vars.keys() & point.keys()
            same = all((o.values[n].constant if n in o.values else None) == point[n] for n in names)
            inside = decide([Condition(mode.domain, frame.after(mode, o.values), closed=True)], o.case)
            if same and init.where.op == "true" and isinstance(inside, Holds) and inside.is_exact:
                return True
        return False


def allowed(automaton: HybridAutomaton, init: Init) -> list[Mode]:
    """The modes in which an init line allows to start."""
    return [m for m in automaton.modes if init.mode in (None, m.name)]


def any_of(answers: Sequence[Answer]) -> Answer:
    """The answer for a disjunction of questions."""
    for wanted in (Holds, Undecided):
        for a in answers:
            if isinstance(a, wanted):
                return a
    core = [e for a in answers if isinstance(a, Contradiction) for e in a.core]
    return Contradiction(tuple(dict.fromkeys(core)))


def _assigned(assign: Assign, frame: Frame, mark: str) -> list[tuple[Case, Polynomial]]:
    if isinstance(assign.to, Expr):
        return terms(assign.to, frame)
    chosen = variable(assign.var + mark)
    low, high = terms(assign.to.low, frame), terms(assign.to.high, frame)
    return [((*a, *b, Literal(p - chosen, "<="), Literal(chosen - q, "<=")), chosen) for a, p in low for b, q in high]
