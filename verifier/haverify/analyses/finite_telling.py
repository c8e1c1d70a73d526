"""What a reader is told about a goal over cells: which fail, and of how many; what is undefined; how rules lead on."""

from __future__ import annotations

from collections.abc import Iterator

from haverify.analyses.finite_orbits import orbits
from haverify.elaborate.notation import Notation
from haverify.evidence.verdict import Unknown
from haverify.model.expression import Expr, nodes, operands
from haverify.model.spec import Spec
from haverify.solvers.finite_truth import COMPARED, QUANTIFIERS, Env, Finite
from haverify.solvers.finite_world import Cell

LISTED = 16
_LONGEST = 160
_TERMS = ("next", "apply", "field")


class Telling:
    """Texts about goals of one spec; evaluations are those of the analysis."""

    def __init__(self, spec: Spec, finite: Finite) -> None:
        words = {(e.name, v): v for e in spec.enums for v in e.values}
        self.spec, self.finite, self.write = spec, finite, Notation(words).text

    def text(self, e: Expr) -> str:
        """A goal in a line, without its middle where it is long."""
        text = self.write(e) if sum(1 for _ in nodes(e)) < 200 else f"a formula of {sum(1 for _ in nodes(e))} nodes"
        return text if len(text) <= _LONGEST else f"{text[: _LONGEST // 2]} ... {text[-_LONGEST // 2 :]}"

    # ---- which cells fail --------------------------------------------------------------

    def facts(self, e: Expr) -> tuple[str, ...]:
        """How many cells of the first quantifier fail, and which; members of a conjunction without quantifiers."""
        found = self._culprit(e)
        if found is None:
            return self._members(e) if e.op == "and" else ()
        body = self.finite.body(found, {})
        failing = [self._failing(found, c) for c in _at(body.no, self._cells(found))[: LISTED + 1]]
        return (_counted(body.no.bit_count(), self._concerned(found), failing),)

    def _members(self, e: Expr) -> tuple[str, ...]:
        """Which members of a conjunction are false, of those that have no premise or a true one."""
        concerned = [c for c in e.children if c.op != "implies" or self.finite.truth(c.children[0], {}) is True]
        failing = [c for c in concerned if self.finite.truth(c, {}) is False]
        return (_counted(len(failing), len(concerned), [self._member(c) for c in failing[: LISTED + 1]]),)

    def _member(self, e: Expr) -> str:
        sides = next(self._broken(e, {}), None)
        return self._told(sides, {}) if sides else self.text(e)

    def _culprit(self, e: Expr) -> Expr | None:
        """The quantifier `forall` that fails."""
        if e.op == "forall":
            return e
        if e.op == "and":
            return next((self._culprit(c) for c in e.children if self.finite.truth(c, {}) is False), None)
        return None

    def _cells(self, e: Expr) -> tuple[Cell, ...]:
        return self.finite.world.cells(str(e.args[1])).cells

    def _concerned(self, e: Expr) -> int:
        """The cells a quantifier speaks of: those for which the premise holds, where there is one."""
        (body,) = e.children
        count = len(self._cells(e))
        if body.op == "implies":
            premise = Expr(e.op, (e.name, str(e.args[1]), body.children[0]))
            count = self.finite.body(premise, {}).yes.bit_count()
        return count

    def _failing(self, e: Expr, cell: Cell) -> str:
        """A cell that fails, with the sides of the comparison that it breaks."""
        label, env = self.finite.world.label(cell), {e.name: cell}
        sides = next(self._broken(e.children[0], env), None)
        return f"{label}: {self._told(sides, env)}" if sides else label

    def _told(self, sides: tuple[Expr, ...], env: Env) -> str:
        """What the sides of a comparison come to."""
        label, value = self.finite.world.label, self.finite.value
        return " and ".join(dict.fromkeys(f"{self.write(s)} is {label(value(s, env))}" for s in sides))

    def _broken(self, e: Expr, env: Env) -> Iterator[tuple[Expr, ...]]:
        """The sides of the comparisons that make a condition false, terms only."""
        if self.finite.truth(e, env) is not False:
            return
        if e.op in COMPARED:
            yield tuple(c for c in e.children if c.op in _TERMS)
        elif e.op == "implies":
            yield from self._broken(e.children[1], env)
        elif e.op in ("and", "or"):
            for c in e.children:
                yield from self._broken(c, env)

    # ---- what decides nothing ------------------------------------------------------------

    def is_vacuous(self, e: Expr) -> bool:
        """Whether each part of a goal is an implication whose premise is true for no cell, or no value.

        A single implication about nothing that varies is not: it may be one of a family.
        """
        parts = e.children if e.op == "and" else (e,)
        varies = len(parts) > 1 or e.op == "forall"
        return varies and all(self._is_empty(p) for p in parts)

    def _is_empty(self, e: Expr) -> bool:
        names: list[tuple[str, str]] = []
        while e.op == "forall":
            names.append((e.name, str(e.args[1])))
            (e,) = e.children
        if e.op != "implies":
            return False
        some = e.children[0]
        for name, of in reversed(names):
            some = Expr("exists", (name, of, some))
        return self.finite.truth(some, {}) is False

    def undefined(self, e: Expr) -> Unknown:
        """The reason for a goal that something undefined decides."""
        place = self._undecided(e, {})
        what = next((t for t in self._terms(place[0]) if self._lacks(t, place[1])), None) if place else None
        if place is None or what is None:
            return Unknown("undefined", "something undefined decides it")
        label = self.finite.world.label
        where = ", ".join(f"{n} = {label(c)}" for n, c in place[1].items())
        reason = f"{self.write(what)} has no value for {where}" if where else f"{self.write(what)} has no value"
        guard = f"say for which it is meant: `defined({self.write(what)}) implies ...`"
        return Unknown("undefined", reason, next_step=guard)

    def _undecided(self, e: Expr, env: dict[str, Cell]) -> tuple[Expr, dict[str, Cell]] | None:
        """A condition without quantifiers that is neither true nor false, with the values of its names."""
        if e.op in QUANTIFIERS:
            body = self.finite.body(e, env)
            cells = _at(body.everywhere & ~(body.yes | body.no), self._cells(e))
            return self._undecided(e.children[0], {**env, e.name: cells[0]}) if cells else None
        for c in operands(e):
            if c.op in QUANTIFIERS and self.finite.truth(c, env) is None:
                return self._undecided(c, env)
        return e, env

    def _terms(self, e: Expr) -> list[Expr]:
        """All terms, the innermost first."""
        return [n for n in reversed(list(nodes(e))) if n.op in ("next", "apply", "/", "^")]

    def _lacks(self, term: Expr, env: Env) -> bool:
        return self.finite.free(term) <= set(env) and self.finite.value(term, env) is None

    # ---- where rules lead ------------------------------------------------------------------

    def orbits(self, on: str | None) -> tuple[str, ...]:
        """How the automaton a claim is about leads from cell to cell."""
        return (orbits(self.finite.world, on),) if on in self.finite.world.automata else ()


def _counted(count: int, concerned: int, failing: list[str]) -> str:
    more = f"; and {count - LISTED} more" if count > LISTED else ""
    return f"{count} of {concerned} fail: {'; '.join(failing[:LISTED])}{more}"


def _at(bits: int, cells: tuple[Cell, ...]) -> list[Cell]:
    return [c for k, c in enumerate(cells) if bits >> k & 1]
