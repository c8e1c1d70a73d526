"""What all of an elaboration shares: findings, units, enumerations, names taken."""

from __future__ import annotations

from collections.abc import Iterable
from typing import NoReturn

from haverify.diagnostics.diagnostic import Diagnostic, Edit, Fix, Label, Severity
from haverify.elaborate.files import Files
from haverify.elaborate.scope import Symbol, Typed
from haverify.elaborate.spelling import nearest
from haverify.model.expression import Expr, number
from haverify.model.spec import Allowed, Cell, EnumType, UnitDef
from haverify.model.unit import BUILTIN, ONE, NamedUnit, Unit, parse_unit
from haverify.text.span import Span

MAX_CHAIN = 500
"""Definitions elaborated while others wait for them."""


class Lost(Exception):
    """An element has no meaning; why was reported, here or where what it depends on is declared."""


class NeedsMode(Exception):
    """An expression uses the parameter of a mode family where no mode is given."""

    def __init__(self, symbol: Symbol) -> None:
        super().__init__(symbol.name)
        self.symbol = symbol


class Context:
    """The state of one elaboration. `unitless` is that of the root file."""

    def __init__(self, files: Files, root: str, unitless: bool) -> None:
        self.files = files
        self.root = root
        self.unitless = unitless
        self.diagnostics: list[Diagnostic] = []
        self.has_losses = False
        self._depth = 0
        self.bindings = 0
        self._reported: set[tuple[str, str, Span | None]] = set()
        self.own_units: tuple[NamedUnit, ...] = ()
        self.unit_defs: list[UnitDef] = []
        self.enums: dict[str, EnumType] = {}
        self.values: dict[str, list[str]] = {}
        self.cells: list[Cell] = []
        self.constant_values: dict[str, Expr] = {}
        self.allowed: list[Allowed] = []
        self.taken: set[str] = set()
        self.shared: set[str] = set()  # core names of constants, params and inputs of the top level
        self.one: Unit | None = None if unitless else ONE
        self.used_values: set[tuple[str, str]] = set()
        self.used_enums: set[str] = set()

    # ---- findings

    def report(
        self, code: str, message: str, span: Span | None, *, label: str = "", labels: Iterable[Label] = (),
        notes: Iterable[str] = (), help: str | None = None, fix: Fix | None = None, severity: Severity | None = None,
    ) -> None:  # fmt: skip
        """Add a finding; the same one at the same place counts once."""
        found = Diagnostic(code, message, span, label, tuple(labels), tuple(notes), help, fix, severity=severity)
        key = (code, message, span)
        if key not in self._reported:
            self._reported.add(key)
            self.diagnostics.append(found)

    def fail(
        self, code: str, message: str, span: Span | None, label: str = "", help: str | None = None,
        labels: Iterable[Label] = (), fix: Fix | None = None, severity: Severity | None = None,
    ) -> NoReturn:  # fmt: skip
        """Add a finding and give up the element it is about."""
        self.has_losses = True
        self.report(code, message, span, label=label, help=help, labels=labels, fix=fix, severity=severity)
        raise Lost

    def unknown(self, what: str, name: str, where: str, span: Span, known: Iterable[str]) -> NoReturn:
        """Report an unknown name with the nearest known one."""
        near = nearest(name, known)
        hint = f"; did you mean '{near}'?" if near else ""
        place = f" in {where}" if where else ""
        fix = Fix(f"write {near}", (Edit(span, near),)) if near else None
        self.fail("HA002", f"no {what} '{name}'{place}{hint}", span, fix=fix)

    # ---- symbols

    def use(self, symbol: Symbol, span: Span | None) -> Symbol:
        """`symbol`, elaborated; what depends on a lost one is lost, and a circle of definitions is HA008."""
        symbol.used = True
        if symbol.state == "pending" and symbol.make is not None:
            self._make(symbol)
        elif symbol.state == "busy":
            symbol.state = "lost"
            self.fail("HA008", f"the definition of '{symbol.name}' leads back to itself", symbol.span,
                      labels=(Label(span, "used here"),) if span and span != symbol.span else ())  # fmt: skip
        if symbol.state == "lost":
            raise Lost
        return symbol

    def _make(self, symbol: Symbol) -> None:
        symbol.state = "busy"
        self._depth += 1
        try:
            if self._depth > MAX_CHAIN:
                told = f"'{symbol.name}' ends a chain of {MAX_CHAIN} definitions, each read before it is made"
                self.fail("HA008", told, symbol.span, help="declare what others read before them")
            assert symbol.make is not None
            symbol.make()
        except (Lost, NeedsMode):
            symbol.state = "lost"
            raise
        finally:
            self._depth -= 1
        if symbol.state == "busy":
            symbol.state = "ready"

    def settle(self, symbol: Symbol) -> bool:
        """Elaborate a pending symbol; whether it has a meaning."""
        used = symbol.used
        try:
            self.use(symbol, None)
        except Lost:
            return False
        finally:
            symbol.used = used
        return True

    def define(self, table: dict[str, Symbol], name: str, symbol: Symbol, what: str) -> bool:
        """Enter a name; a second definition is HA004 and makes both lost."""
        old = table.get(name)
        if old is None:
            table[name] = symbol
            return True
        old.state = "lost"
        labels = (Label(old.span, "first defined here"),) if old.span else ()
        self.report("HA004", f"{what} '{name}' is defined twice", symbol.span, labels=labels)
        return False

    def fresh(self, name: str) -> str:
        """`name`, with `_2`, `_3`, ... appended where it is taken; taken from now on."""
        found, k = name, 1
        while found in self.taken:
            k += 1
            found = f"{name}_{k}"
        self.taken.add(found)
        return found

    # ---- units and enumerations

    def unit(self, text: str, span: Span) -> Unit | None:
        """The unit `text`; None in a unitless file, where any unit is HA101."""
        if self.unitless:
            if text != "1":
                self.fail("HA101", f"unit '{text}' in a unitless file", span)
            return None
        found = parse_unit(text, self.own_units)
        if found is None:
            known = [u.name for u in self.own_units] + list(BUILTIN) + list(self.enums)
            self.unknown("unit or enumeration", text, "", span, known)
        return found

    def value(self, enum: EnumType, value: str, span: Span | None = None) -> Typed:
        """The value of that name of an enumeration; an integer one's values are numbers."""
        if enum.low is not None:
            return Typed(number(int(value), self.one, span), enum.name)
        return Typed(Expr("sym", (enum.name, value), None, span), enum.name)

    def is_number(self, type_: str) -> bool:
        """Whether values of the type are numbers."""
        return type_ == "real" or (type_ in self.enums and self.enums[type_].low is not None)
