"""The finite things of a spec as tables: cells with their parts, where rules lead, what relations relate."""

from __future__ import annotations

from fractions import Fraction
from typing import Any

from haverify.elaborate.cells import codes
from haverify.model.cellular import CellularAutomaton, Rule
from haverify.model.expression import Expr
from haverify.model.spec import EnumType, Spec
from haverify.text.record import holder, record

MOST_CELLS = 1 << 14

Cell = tuple[str, str]  # the name of the set, and the bits
Value = Cell | str | Fraction | bool | None  # `str`: a value of an enumeration; None where it is undefined


class NotFiniteError(Exception):
    """What is asked cannot be answered by trying values; the message says why."""


class TooMuchError(NotFiniteError):
    """There are more values to try than the budget allows."""


@record
class Step:
    """What the lines of an automaton say of one cell: the results in order, `rules` those that give them.

    The result of a formula comes last and has no rule.
    """

    results: tuple[Cell, ...]
    rules: tuple[Rule, ...]

    @property
    def target(self) -> Cell | None:
        """The cell that comes next, None where no line, or two that disagree, speak of this one."""
        return self.results[0] if len(set(self.results)) == 1 else None


@holder
class CellSet:
    """The cells of a set in order of their enumerations' values, with the name a reader knows each by."""

    name: str
    cells: tuple[Cell, ...]
    labels: dict[Cell, str]


class World:
    """Tables made when first asked for; `params` gives params values, without which none is known."""

    def __init__(self, spec: Spec, on: str | None = None, params: dict[str, Fraction] | None = None) -> None:
        self.spec, self.on, self.params = spec, on, params or {}
        self.enums = {e.name: e for e in spec.enums}
        self.automata = {c.name: c for c in spec.cellular}
        self._sets: dict[str, CellSet] = {}
        self._fields: dict[tuple[Cell, str], Value] = {}
        self._steps: dict[str, dict[Cell, Step]] = {}
        self._images: dict[str, dict[str, tuple[str, ...]]] = {}
        self._constants: dict[str, Value] = {}
        self._busy: set[str] = set()

    # ---- cells ---------------------------------------------------------------------

    def cells(self, name: str) -> CellSet:
        """The cells called `name`.

        Raises
        ------
        NotFiniteError       where there are too many, or codes clash
        """
        if name not in self._sets:
            owners = [c for c in self.spec.cellular if c.cell == name]
            if len({(c.first, c.second) for c in owners}) != 1:
                raise NotFiniteError(f"cells {name} are nothing, or two things")
            self._sets[name] = self._enter(owners[0])
        return self._sets[name]

    def _enter(self, owner: CellularAutomaton) -> CellSet:
        first, second = self.enums[owner.first], self.enums[owner.second]
        if len(first.values) * len(second.values) > MOST_CELLS:
            raise TooMuchError(f"{owner.cell} has more than {MOST_CELLS} cells")
        labels = {}
        for (a, x), left in zip(_coded(first), _values(first), strict=True):
            for (b, y), right in zip(_coded(second), _values(second), strict=True):
                cell = (owner.cell, x + y)
                self._fields[cell, first.name.lower()] = left
                self._fields[cell, second.name.lower()] = right
                labels[cell] = f"{a} {b} (0b{x + y})"
        return CellSet(owner.cell, tuple(labels), labels)

    def part(self, cell: Cell, name: str) -> Value:
        """A part of a cell."""
        self.cells(cell[0])
        return self._fields[cell, name]

    def sym(self, enum: str, value: str) -> Value:
        """A value of an enumeration."""
        found = self.enums[enum]
        return value if found.low is None else found.low + found.values.index(value)

    # ---- rules and relations ---------------------------------------------------------

    def steps(self, automaton: str) -> dict[Cell, Step]:
        """What each cell of an automaton is said to lead to."""
        if automaton not in self._steps:
            if automaton in self._busy:
                raise NotFiniteError(f"the formula of {automaton} asks for itself")
            self._busy.add(automaton)
            self._steps[automaton] = self._read(self.automata[automaton])
            self._busy.discard(automaton)
        return self._steps[automaton]

    def _read(self, owner: CellularAutomaton) -> dict[Cell, Step]:
        found: dict[Cell, list[Rule]] = {c: [] for c in self.cells(owner.cell).cells}
        for rule in owner.rules:
            found[owner.cell, rule.left].append(rule)
        steps = {}
        for cell, rules in found.items():
            results = [(owner.cell, r.right) for r in rules] + self._computed(owner, cell)
            steps[cell] = Step(tuple(results), tuple(rules))
        return steps

    def _computed(self, owner: CellularAutomaton, cell: Cell) -> list[Cell]:
        from haverify.solvers.finite_truth import Finite

        if owner.formula is None or owner.argument is None:
            return []
        target = Finite(self).value(owner.formula, {owner.argument: cell})
        return [target] if isinstance(target, tuple) else []

    def images(self, relation: str) -> dict[str, tuple[str, ...]]:
        """What each name is related to, each image once."""
        if relation not in self._images:
            found: dict[str, dict[str, None]] = {}
            pairs = next(r.pairs for r in self.spec.relations if r.name == relation)
            for a, b in pairs:
                found.setdefault(a, {})[b] = None
            self._images[relation] = {a: tuple(b) for a, b in found.items()}
        return self._images[relation]

    # ---- numbers ---------------------------------------------------------------------

    def constant(self, name: str) -> Value:
        """The value of a constant of the automaton the claim is about, else of the file."""
        if name not in self._constants:
            from haverify.solvers.finite_truth import Finite

            own = [a.constants for a in self.spec.automata if a.name == self.on]
            known = {c.name: c.value for group in (self.spec.constants, *own) for c in group}
            value = known[name]
            if not isinstance(value, Expr):
                raise NotFiniteError(f"the constant {name} is a set")
            self._constants[name] = Finite(self).value(value, {})
        return self._constants[name]

    def param(self, name: str) -> Fraction:
        """The value of a param at the point that is looked at."""
        if name not in self.params:
            raise NotFiniteError(f"it depends on the param {name}")
        return self.params[name]

    def label(self, value: Value) -> str:
        """A value as a reader knows it."""
        if isinstance(value, tuple):
            return self.cells(value[0]).labels[value]
        return "undefined" if value is None else str(value).lower() if isinstance(value, bool) else str(value)


def _coded(enum: EnumType) -> list[tuple[str, str]]:
    """Each value with its bits."""
    found = codes(enum)
    if len(set(found.values())) < len(found) or len({len(b) for b in found.values()}) > 1:
        raise NotFiniteError(f"two values of {enum.name} have one code, or codes of different lengths")
    return list(found.items())


def _values(enum: EnumType) -> list[Any]:
    return list(enum.values) if enum.low is None else [enum.low + k for k in range(len(enum.values))]
