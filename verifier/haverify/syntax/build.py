"""Tree nodes out of recognised productions: one method per rule of grammar.lark, named like it.

A method gets the children of its production (nodes, (text, start, end) for kept tokens, None for an absent part)
and the range of text the production covers.
"""

from __future__ import annotations

from fractions import Fraction
from typing import Any

from haverify.diagnostics.diagnostic import Diagnostic
from haverify.syntax.language import Language
from haverify.syntax.tree import (
    Argument, Assignment, Assume, Attribute, AttributeArgument, Automaton, Binary, Binding, Bits, Call, Cellular, CellLine,
    Comparison, Const, Declared, Derivative, Domain, Edge, EnumDecl, EnumValue, Expectation, Family, Flow, Formal, Function,
    Fuzzy, FuzzyLine, FuzzyTerm, Goal, Horizon, If, Import, Index, Init, Input, Instance, Interval, Invariant, Item, Let,
    Member, Method, Mode, Name, Network, NetworkLine, NextLine, Number, Pair, Param, Paren, Part, Priority, Property,
    Quantifier, Relation, RuleLine, Sample, Schedule, Slot, SpecHeader, Sync, System, Table, TableLine, Target, Temporal,
    Terminal, Truth, Type, Unary, UnitDecl, Until, Using, Var, Which,
)  # fmt: skip
from haverify.text.span import Span

BROKEN = "broken"  # stands where an item could not be read
MOST_DIGITS, MOST_EXPONENT = 2000, 2000


def _healthy(children: list[Any]) -> tuple[Any, ...]:
    return tuple(child for child in children if child is not None and child is not BROKEN)


def _text(token: Any) -> str:
    return token[0] if token else ""


def _string(token: Any) -> str:
    return str(token[0][1:-1])


class Builder:
    """Makes the nodes of one file; `findings` are the numbers and names that are no language's fault."""

    def __init__(self, path: str, language: Language) -> None:
        self.path = path
        self.findings: list[Diagnostic] = []
        self._number = language.number.match
        self._values: dict[str, Fraction] = {}

    def _span(self, start: int, end: int) -> Span:
        return Span(self.path, start, end)

    def _place(self, token: Any) -> Span:
        return Span(self.path, token[1], token[2])

    # ---- file ----------------------------------------------------------------

    def start(self, c: list[Any], s: int, e: int) -> tuple[Item, ...]:
        return _healthy(c)

    def broken(self, c: list[Any], s: int, e: int) -> str:
        return BROKEN

    def item(self, c: list[Any], s: int, e: int) -> Item:
        docs = tuple(child[0][3:].strip(" \t\r") for child in c if type(child) is tuple)
        attributes = tuple(child for child in c[:-1] if type(child) is Attribute)
        return Item(docs, attributes, c[-1], self._span(s, e))

    def attr(self, c: list[Any], s: int, e: int) -> Attribute:
        return Attribute(_text(c[0]), _healthy(c[1:]), self._span(s, e))

    def arg(self, c: list[Any], s: int, e: int) -> AttributeArgument:
        value = _string(c[1]) if type(c[1]) is tuple else c[1]
        return AttributeArgument(_text(c[0]) or None, value, self._span(s, e))

    # ---- names, constants, data -------------------------------------------------

    def spec_hdr(self, c: list[Any], s: int, e: int) -> SpecHeader:
        return SpecHeader(_string(c[0]), _string(c[1]), c[2] is not None, self._span(s, e))

    def import_(self, c: list[Any], s: int, e: int) -> Import:
        return Import(_string(c[0]), _text(c[1]) or None, self._span(s, e), self._place(c[0]))

    def unit_(self, c: list[Any], s: int, e: int) -> UnitDecl:
        return UnitDecl(_text(c[0]), c[1], self._span(s, e))

    def const_(self, c: list[Any], s: int, e: int) -> Const:
        return Const(c[0], c[1], c[2], self._span(s, e))

    def param_(self, c: list[Any], s: int, e: int) -> Param:
        return Param(c[0], c[1], c[2], c[3], self._span(s, e))

    def input_(self, c: list[Any], s: int, e: int) -> Input:
        return Input(c[0], c[1], c[2], c[3], c[4], self._span(s, e))

    def enum_(self, c: list[Any], s: int, e: int) -> EnumDecl:
        return EnumDecl(_text(c[0]), _healthy(c[1:]), None, None, self._span(s, e))

    def enum_range(self, c: list[Any], s: int, e: int) -> EnumDecl:
        return EnumDecl(_text(c[0]), (), c[1], c[2], self._span(s, e))

    def enumval(self, c: list[Any], s: int, e: int) -> EnumValue:
        if c[1]:
            self._check_size(c[1])
        return EnumValue(_text(c[0]), _text(c[1]) or None, self._span(s, e))

    def table_(self, c: list[Any], s: int, e: int) -> Table:
        return Table(_text(c[0]), _string(c[1]), _healthy(c[2:]), self._span(s, e), self._place(c[1]))

    def tab_key(self, c: list[Any], s: int, e: int) -> TableLine:
        return TableLine("key", self._span(s, e), name=_text(c[0]), of=_text(c[1]))

    def tab_poly(self, c: list[Any], s: int, e: int) -> TableLine:
        first, last, order, argument, of_argument, result = c
        return TableLine(
            "poly", self._span(s, e), name=_text(first), last=_text(last), order=_text(order),
            argument=_text(argument), type=of_argument, result=_text(result),
        )  # fmt: skip

    def tab_axis(self, c: list[Any], s: int, e: int) -> TableLine:
        return TableLine("axis", self._span(s, e), name=_text(c[0]), type=c[1])

    def tab_column(self, c: list[Any], s: int, e: int) -> TableLine:
        return TableLine("column", self._span(s, e), name=_text(c[0]), type=c[1], tolerance=c[2])

    def tab_matrix(self, c: list[Any], s: int, e: int) -> TableLine:
        return TableLine("matrix", self._span(s, e), of=dotted(c[0]), by=dotted(c[1]), type=c[2])

    def tab_interpolate(self, c: list[Any], s: int, e: int) -> TableLine:
        return TableLine("interpolate", self._span(s, e), name=_text(c[0]))

    def tab_add(self, c: list[Any], s: int, e: int) -> TableLine:
        return TableLine("add", self._span(s, e), name=_text(c[0]))

    def tab_digits(self, c: list[Any], s: int, e: int) -> TableLine:
        return TableLine("digits", self._span(s, e), number=c[0])

    def tab_sha(self, c: list[Any], s: int, e: int) -> TableLine:
        return TableLine("sha256", self._span(s, e), text=_string(c[0]))

    def fn_(self, c: list[Any], s: int, e: int) -> Function:
        return Function(_text(c[0]), tuple(c[1:-2]), c[-2], c[-1], self._span(s, e))

    def formal(self, c: list[Any], s: int, e: int) -> Formal:
        return Formal(_text(c[0]), c[1], self._span(s, e))

    def type(self, c: list[Any], s: int, e: int) -> Type:
        return Type(_text(c[0]), self._place(c[0]))

    def declared(self, c: list[Any], s: int, e: int) -> Declared:
        return Declared(_text(c[0]), None, None, self._place(c[0]))

    varname = declared

    def declared_family(self, c: list[Any], s: int, e: int) -> Declared:
        return Declared(_text(c[0]), None, c[1], self._place(c[0]))

    def declared_member(self, c: list[Any], s: int, e: int) -> Declared:
        self._check_size(c[1])
        return Declared(_text(c[0]), _text(c[1]), None, self._place(c[0]))

    def fam(self, c: list[Any], s: int, e: int) -> Family:
        return Family(_text(c[0]), c[1], self._span(s, e))

    def lval(self, c: list[Any], s: int, e: int) -> Target:
        return Target(_text(c[0]), c[1], self._span(s, e))

    def network_(self, c: list[Any], s: int, e: int) -> Network:
        return Network(_text(c[0]), _string(c[1]), _healthy(c[2:]), self._span(s, e), self._place(c[1]))

    def net_in(self, c: list[Any], s: int, e: int) -> NetworkLine:
        return NetworkLine("input", c[0], c[1], "", self._span(s, e))

    def net_out(self, c: list[Any], s: int, e: int) -> NetworkLine:
        return NetworkLine("output", c[0], c[1], "", self._span(s, e))

    def net_sha(self, c: list[Any], s: int, e: int) -> NetworkLine:
        return NetworkLine("sha256", None, None, _string(c[0]), self._span(s, e))

    # ---- hybrid automata ----------------------------------------------------------

    def automaton(self, c: list[Any], s: int, e: int) -> Automaton:
        return Automaton(_text(c[0]), _healthy(c[1:]), self._span(s, e), self._place(c[0]))

    def var_(self, c: list[Any], s: int, e: int) -> Var:
        *names, family, of, window = c
        declared = tuple(Declared(n.name, n.index, family, n.span) for n in names) if family else tuple(names)
        return Var(declared, of, window, self._span(s, e))

    def let_(self, c: list[Any], s: int, e: int) -> Let:
        return Let(c[0], c[1], c[2], self._span(s, e))

    def init_(self, c: list[Any], s: int, e: int) -> Init:
        return Init(c[0], c[1], c[2] or (), self._span(s, e))

    def mode_(self, c: list[Any], s: int, e: int) -> Mode:
        return Mode(c[0], _healthy(c[1:]), self._span(s, e))

    def domain_(self, c: list[Any], s: int, e: int) -> Domain:
        return Domain(c[0], self._span(s, e))

    def terminal_(self, c: list[Any], s: int, e: int) -> Terminal:
        return Terminal(self._span(s, e))

    def flow_(self, c: list[Any], s: int, e: int) -> Flow:
        return Flow(_healthy(c), self._span(s, e))

    def der(self, c: list[Any], s: int, e: int) -> Derivative:
        return Derivative(c[0], c[2], c[1][0] == "in", c[3], self._span(s, e))

    def edge_(self, c: list[Any], s: int, e: int) -> Edge:
        urgent, label, source, target, guard, assignments = c
        return Edge(urgent is not None, label, source, target, guard, assignments or (), self._span(s, e))

    def edgename(self, c: list[Any], s: int, e: int) -> Declared:
        label: Target = c[0]
        place = Span(self.path, label.span.start, label.span.start + len(label.name))
        return Declared(label.name, self._member(label.index), None, place)

    def _member(self, index: Any) -> str | None:
        if index is None or type(index) is Name:
            return index and index.id
        if type(index) is Number and index.unit is None:
            return index.text
        if type(index) is Bits:
            return index.digits
        self._report("the index of a declared name is one value of an enum", index.span)
        return None

    def assigns(self, c: list[Any], s: int, e: int) -> tuple[Assignment, ...]:
        return _healthy(c)

    def asg(self, c: list[Any], s: int, e: int) -> Assignment:
        return Assignment(c[0], c[2], c[1][0] == "in", c[3], self._span(s, e))

    def sample_(self, c: list[Any], s: int, e: int) -> Sample:
        return Sample(_text(c[0]), c[1], c[2], self._span(s, e))

    def priority_(self, c: list[Any], s: int, e: int) -> Priority:
        return Priority(tuple(c[:-1]), c[-1], self._span(s, e))

    def schedule(self, c: list[Any], s: int, e: int) -> Schedule:
        return Schedule(_text(c[0]), c[1], _healthy(c[2:]), self._span(s, e))

    def slot(self, c: list[Any], s: int, e: int) -> Slot:
        return Slot(_text(c[0]), c[1], _text(c[2]) or None, c[3] or (), self._span(s, e))

    def instance(self, c: list[Any], s: int, e: int) -> Instance:
        return Instance(_text(c[0]), c[1], _healthy(c[2:]), self._span(s, e), self._place(c[0]))

    def bind(self, c: list[Any], s: int, e: int) -> Binding:
        return Binding(_text(c[0]), c[2], c[1][0] == "in", self._span(s, e))

    def system(self, c: list[Any], s: int, e: int) -> System:
        return System(_text(c[0]), _healthy(c[1:]), (), (), self._span(s, e), self._place(c[0]))

    def composed(self, c: list[Any], s: int, e: int) -> System:
        return System(_text(c[0]), (), c[1], c[2] or (), self._span(s, e), self._place(c[0]))

    def parallel(self, c: list[Any], s: int, e: int) -> tuple[Any, ...]:
        return tuple(c)

    def names(self, c: list[Any], s: int, e: int) -> tuple[str, ...]:
        return tuple(_text(child) for child in c)

    def part_(self, c: list[Any], s: int, e: int) -> Part:
        return Part(c[0], c[1], c[2] or (), self._span(s, e))

    def binds(self, c: list[Any], s: int, e: int) -> tuple[Binding, ...]:
        return _healthy(c)

    def sync_(self, c: list[Any], s: int, e: int) -> Sync:
        return Sync(c[0], c[1], c[2] or (), c[3], c[4] or (), self._span(s, e))

    def paths(self, c: list[Any], s: int, e: int) -> tuple[Any, ...]:
        return tuple(c)

    # ---- rule tables and fuzzy systems ----------------------------------------------

    def cellular(self, c: list[Any], s: int, e: int) -> Cellular:
        return Cellular(_text(c[0]), _healthy(c[1:]), self._span(s, e), self._place(c[0]))

    def ca_cell(self, c: list[Any], s: int, e: int) -> CellLine:
        return CellLine(_text(c[0]), _text(c[1]), _text(c[2]), self._span(s, e))

    def ca_rule(self, c: list[Any], s: int, e: int) -> RuleLine:
        return RuleLine(c[0], c[1], self._span(s, e))

    def ca_next(self, c: list[Any], s: int, e: int) -> NextLine:
        return NextLine(_text(c[0]), c[1], self._span(s, e))

    def couple(self, c: list[Any], s: int, e: int) -> Pair:
        return Pair(self.name([c[0]], c[0][1], c[0][2]), self.name([c[1]], c[1][1], c[1][2]), self._span(s, e))

    def relation(self, c: list[Any], s: int, e: int) -> Relation:
        return Relation(_text(c[0]), _healthy(c[1:]), self._span(s, e), self._place(c[0]))

    def relpair(self, c: list[Any], s: int, e: int) -> RuleLine:
        return RuleLine(c[0].left, c[0].right, self._span(s, e), is_pair=True)

    def maplet(self, c: list[Any], s: int, e: int) -> RuleLine:
        return RuleLine(self.name([c[0]], c[0][1], c[0][2]), self.name([c[1]], c[1][1], c[1][2]), self._span(s, e))

    def fuzzy(self, c: list[Any], s: int, e: int) -> Fuzzy:
        return Fuzzy(_text(c[0]), _healthy(c[1:]), self._span(s, e), self._place(c[0]))

    def f_in(self, c: list[Any], s: int, e: int) -> FuzzyLine:
        return FuzzyLine("input", self._span(s, e), name=_text(c[0]), type=c[1], range=c[2], terms=tuple(c[3:]))

    def f_chain(self, c: list[Any], s: int, e: int) -> FuzzyLine:
        return FuzzyLine("chain", self._span(s, e), name=_text(c[0]), source=_text(c[1]), output=_text(c[2]))

    def f_out(self, c: list[Any], s: int, e: int) -> FuzzyLine:
        return FuzzyLine("output", self._span(s, e), name=_text(c[0]), values=self.names(c[1:], s, e))

    def f_logic(self, c: list[Any], s: int, e: int) -> FuzzyLine:
        return FuzzyLine("logic", self._span(s, e), values=self.names(c, s, e))

    def f_rule(self, c: list[Any], s: int, e: int) -> FuzzyLine:
        label, condition, output, value = c
        return FuzzyLine(
            "rule", self._span(s, e), name=_text(label), condition=condition, output=_text(output), values=(_text(value),)
        )

    def term(self, c: list[Any], s: int, e: int) -> FuzzyTerm:
        return FuzzyTerm(_text(c[0]), _text(c[1]), tuple(c[2:]), self._span(s, e))

    # ---- properties -------------------------------------------------------------------

    def assume_(self, c: list[Any], s: int, e: int) -> Assume:
        return Assume(_text(c[0]) or None, c[1], self._span(s, e))

    def p_assume(self, c: list[Any], s: int, e: int) -> Assume:
        return Assume(None, c[0], self._span(s, e))

    def invariant_(self, c: list[Any], s: int, e: int) -> Invariant:
        declared, on, mode, condition, inductive, expect = c
        return Invariant(declared, on, mode, condition, inductive is not None, expect, self._span(s, e))

    def property_(self, c: list[Any], s: int, e: int) -> Property:
        return Property(c[0], c[1], _healthy(c[2:]), self._span(s, e))

    def p_horizon(self, c: list[Any], s: int, e: int) -> Horizon:
        return Horizon(c[0], c[1], self._span(s, e))

    def p_jumps(self, c: list[Any], s: int, e: int) -> Horizon:
        return Horizon(None, c[0], self._span(s, e))

    def p_which(self, c: list[Any], s: int, e: int) -> Which:
        return Which(_text(c[0]), c[1], self._span(s, e))

    def p_using(self, c: list[Any], s: int, e: int) -> Using:
        return Using(tuple(self.name([child], child[1], child[2]) for child in c), self._span(s, e))

    def p_method(self, c: list[Any], s: int, e: int) -> Method:
        return Method(_text(c[0]), _healthy(c[1:]), self._span(s, e))

    def g_always(self, c: list[Any], s: int, e: int) -> Goal:
        return Goal("always", c[2], self._span(s, e), window=c[1])

    def g_plain(self, c: list[Any], s: int, e: int) -> Goal:
        return Goal(_text(c[0]), c[1], self._span(s, e), within=c[2] if len(c) > 2 else None)

    def g_can_reach(self, c: list[Any], s: int, e: int) -> Goal:
        return Goal("can_reach", c[0], self._span(s, e), within=c[1])

    def g_can_always(self, c: list[Any], s: int, e: int) -> Goal:
        return Goal("can_always", c[0], self._span(s, e))

    def g_cycle(self, c: list[Any], s: int, e: int) -> Goal:
        return Goal("cycle", c[0], self._span(s, e), within=c[1], attracting=c[2] is not None)

    def tail(self, c: list[Any], s: int, e: int) -> Expectation:
        because = _string(c[3]) if c[3] else None
        return Expectation(_text(c[0]), c[1], c[2], because, self._span(s, e))

    def bound(self, c: list[Any], s: int, e: int) -> tuple[str, Any]:
        return _text(c[0]), c[1]

    def window(self, c: list[Any], s: int, e: int) -> tuple[Any, Any]:
        return c[0], c[1]

    # ---- expressions --------------------------------------------------------------------

    def ite(self, c: list[Any], s: int, e: int) -> If:
        return If(c[0], c[1], c[2], self._span(s, e))

    def quant(self, c: list[Any], s: int, e: int) -> Quantifier:
        return Quantifier(_text(c[0]), _text(c[1]), c[2], c[3], self._span(s, e))

    def binary(self, c: list[Any], s: int, e: int) -> Binary:
        return Binary(c[1][0], c[0], c[2], Span(self.path, s, e))

    def until(self, c: list[Any], s: int, e: int) -> Until:
        return Until(c[0], c[1][0], c[1][1], c[2], self._span(s, e))

    def unary(self, c: list[Any], s: int, e: int) -> Unary:
        return Unary(c[0][0], c[1], self._span(s, e))

    def temporal(self, c: list[Any], s: int, e: int) -> Temporal:
        return Temporal(_text(c[0]), c[1][0], c[1][1], c[2], self._span(s, e))

    def comparison(self, c: list[Any], s: int, e: int) -> Comparison:
        return Comparison(tuple(c[0::2]), tuple(op[0] for op in c[1::2]), self._span(s, e))

    def quantity(self, c: list[Any], s: int, e: int) -> Number:
        text = c[0][0]
        number = self._number(text)
        assert number is not None  # a quantity starts with a number
        return Number(self._value(number[0], s), number[0], text[number.end() :].strip(), self._span(s, e))

    def number(self, c: list[Any], s: int, e: int) -> Number:
        return Number(self._value(c[0][0], s), c[0][0], None, self._span(s, e))

    def user_quantity(self, c: list[Any], s: int, e: int) -> Number:
        return Number(self._value(c[0][0], s), c[0][0], c[1][0], self._span(s, e))

    def bits(self, c: list[Any], s: int, e: int) -> Bits:
        self._check_size(c[0])
        return Bits(c[0][0], self._span(s, e))

    def truth(self, c: list[Any], s: int, e: int) -> Truth:
        return Truth(c[0][0] == "true", self._span(s, e))

    def name(self, c: list[Any], s: int, e: int) -> Name:
        return Name(c[0][0], Span(self.path, s, e))

    def member(self, c: list[Any], s: int, e: int) -> Member:
        return Member(c[0], c[1][0], self._span(s, e))

    def index(self, c: list[Any], s: int, e: int) -> Index:
        return Index(c[0], c[1], self._span(s, e))

    def call(self, c: list[Any], s: int, e: int) -> Call:
        return Call(c[0], _healthy(c[1:]), self._span(s, e))

    def callarg(self, c: list[Any], s: int, e: int) -> Argument:
        return Argument(_text(c[0]) or None, c[1], c[2], self._span(s, e))

    def paren(self, c: list[Any], s: int, e: int) -> Paren:
        return Paren(c[0], self._span(s, e))

    def tuple_(self, c: list[Any], s: int, e: int) -> Pair:
        return Pair(c[0], c[1], self._span(s, e))

    def interval(self, c: list[Any], s: int, e: int) -> Interval:
        return Interval(c[0], c[1], self._span(s, e))

    # ---- numbers ----------------------------------------------------------------------------

    def _value(self, text: str, start: int) -> Fraction:
        value = self._values.get(text)
        if value is None:
            value = exact(text)
            if value is None:
                self._report(_NO_NUMBER, self._span(start, start + len(text)))
                return Fraction(0)
            self._values[text] = value
        return value

    def _check_size(self, token: Any) -> None:
        if len(token[0]) > MOST_DIGITS:
            self._report(_NO_NUMBER, self._place(token))

    def _report(self, message: str, span: Span) -> None:
        self.findings.append(Diagnostic("HA001", message, span))


_NO_NUMBER = f"number too large or too small to be meant: more than {MOST_DIGITS} digits, or an exponent beyond +-{MOST_EXPONENT}"


def dotted(name: Any) -> str:
    """The text of a dotted name."""
    parts = []
    while type(name) is Member:
        parts.append(name.name)
        name = name.base
    return ".".join([name.id, *reversed(parts)])


def exact(text: str) -> Fraction | None:
    """The value of a number as written; None beyond what any model means."""
    mantissa, _, exponent = text.lower().partition("e")
    whole, _, decimals = mantissa.partition(".")
    if len(mantissa) > MOST_DIGITS or len(exponent) > len(str(MOST_EXPONENT)) + 1:
        return None
    power = int(exponent or 0)
    if abs(power) > MOST_EXPONENT:
        return None
    power -= len(decimals)
    digits = int(whole + decimals)
    return Fraction(digits * 10**power) if power >= 0 else Fraction(digits, 10**-power)
