"""Tree nodes out of recognised productions: one method per rule of grammar.lark, named like it.

A method gets the children of its production (nodes, (text, start, end) for kept tokens, None for an absent part)
and the range of text the production covers.
"""

from __future__ import annotations

from fractions import Fraction
from typing import Any

from haverify.diagnostics.diagnostic import Diagnostic
from haverify.syntax import tree
from haverify.syntax.language import Language
from haverify.text.span import Span

VERSION = "1.0"  # of the language
BROKEN = "broken"  # stands where an item could not be read
MOST_DIGITS, MOST_EXPONENT = 2000, 2000
NO_NUMBER = (
    "number too large or too small to be meant:"
    f" more than {MOST_DIGITS} digits, or an exponent beyond +-{MOST_EXPONENT}"
)


def _healthy(children: list[Any]) -> tuple[Any, ...]:
    return tuple(child for child in children if child is not None and child is not BROKEN)


def _text(token: Any) -> str:
    return token[0] if token else ""


def _doc(text: str) -> str:
    return text[3:].removeprefix(" ").rstrip(" \t\r")


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

    def start(self, c: list[Any], s: int, e: int) -> tuple[tree.Item, ...]:
        return _healthy(c)

    def broken(self, c: list[Any], s: int, e: int) -> str:
        return BROKEN

    def item(self, c: list[Any], s: int, e: int) -> tree.Item:
        docs = tuple(_doc(child[0]) for child in c if type(child) is tuple)
        attributes = tuple(child for child in c[:-1] if type(child) is tree.Attribute)
        return tree.Item(docs, attributes, c[-1], self._span(s, e))

    def attr(self, c: list[Any], s: int, e: int) -> tree.Attribute:
        return tree.Attribute(_text(c[0]), _healthy(c[1:]), self._span(s, e))

    def arg(self, c: list[Any], s: int, e: int) -> tree.AttributeArgument:
        value = _string(c[1]) if type(c[1]) is tuple else c[1]
        return tree.AttributeArgument(_text(c[0]) or None, value, self._span(s, e))

    # ---- names, constants, data -------------------------------------------------

    def spec_hdr(self, c: list[Any], s: int, e: int) -> tree.SpecHeader:
        if _string(c[1]) != VERSION:
            told = f"this version of haverify reads language version {VERSION}, not '{_string(c[1])[:20]}'"
            self._report(told, self._place(c[1]))
        return tree.SpecHeader(_string(c[0]), _string(c[1]), c[2] is not None, self._span(s, e))

    def import_(self, c: list[Any], s: int, e: int) -> tree.Import:
        return tree.Import(_string(c[0]), _text(c[1]) or None, self._span(s, e), self._place(c[0]))

    def unit_(self, c: list[Any], s: int, e: int) -> tree.UnitDecl:
        return tree.UnitDecl(_text(c[0]), c[1], self._span(s, e))

    def const_(self, c: list[Any], s: int, e: int) -> tree.Const:
        return tree.Const(c[0], c[1], c[2], self._span(s, e))

    def param_(self, c: list[Any], s: int, e: int) -> tree.Param:
        return tree.Param(c[0], c[1], c[2], c[3], self._span(s, e))

    def input_(self, c: list[Any], s: int, e: int) -> tree.Input:
        return tree.Input(c[0], c[1], c[2], c[3], c[4], self._span(s, e))

    def enum_(self, c: list[Any], s: int, e: int) -> tree.EnumDecl:
        return tree.EnumDecl(_text(c[0]), _healthy(c[1:]), None, None, self._span(s, e))

    def enum_range(self, c: list[Any], s: int, e: int) -> tree.EnumDecl:
        return tree.EnumDecl(_text(c[0]), (), c[1], c[2], self._span(s, e))

    def enumval(self, c: list[Any], s: int, e: int) -> tree.EnumValue:
        if c[1]:
            self._check_size(c[1])
        return tree.EnumValue(_text(c[0]), _text(c[1]) or None, self._span(s, e))

    def table_(self, c: list[Any], s: int, e: int) -> tree.Table:
        return tree.Table(_text(c[0]), _string(c[1]), _healthy(c[2:]), self._span(s, e), self._place(c[1]))

    def tab_key(self, c: list[Any], s: int, e: int) -> tree.TableLine:
        return tree.TableLine("key", self._span(s, e), name=_text(c[0]), of=_text(c[1]))

    def tab_poly(self, c: list[Any], s: int, e: int) -> tree.TableLine:
        first, last, order, argument, of_argument, result = c
        return tree.TableLine(
            "poly", self._span(s, e), name=_text(first), last=_text(last), order=_text(order),
            argument=_text(argument), type=of_argument, result=_text(result),
        )  # fmt: skip

    def tab_axis(self, c: list[Any], s: int, e: int) -> tree.TableLine:
        return tree.TableLine("axis", self._span(s, e), name=_text(c[0]), type=c[1])

    def tab_column(self, c: list[Any], s: int, e: int) -> tree.TableLine:
        return tree.TableLine("column", self._span(s, e), name=_text(c[0]), type=c[1], tolerance=c[2])

    def tab_matrix(self, c: list[Any], s: int, e: int) -> tree.TableLine:
        return tree.TableLine("matrix", self._span(s, e), of=dotted(c[0]), by=dotted(c[1]), type=c[2])

    def tab_interpolate(self, c: list[Any], s: int, e: int) -> tree.TableLine:
        return tree.TableLine("interpolate", self._span(s, e), name=_text(c[0]))

    def tab_add(self, c: list[Any], s: int, e: int) -> tree.TableLine:
        return tree.TableLine("add", self._span(s, e), name=_text(c[0]))

    def tab_digits(self, c: list[Any], s: int, e: int) -> tree.TableLine:
        return tree.TableLine("digits", self._span(s, e), number=c[0])

    def tab_sha(self, c: list[Any], s: int, e: int) -> tree.TableLine:
        return tree.TableLine("sha256", self._span(s, e), text=_string(c[0]))

    def fn_(self, c: list[Any], s: int, e: int) -> tree.Function:
        return tree.Function(_text(c[0]), tuple(c[1:-2]), c[-2], c[-1], self._span(s, e))

    def formal(self, c: list[Any], s: int, e: int) -> tree.Formal:
        return tree.Formal(_text(c[0]), c[1], self._span(s, e))

    def type(self, c: list[Any], s: int, e: int) -> tree.Type:
        return tree.Type(_text(c[0]), self._place(c[0]))

    def declared(self, c: list[Any], s: int, e: int) -> tree.Declared:
        return tree.Declared(_text(c[0]), None, None, self._place(c[0]))

    varname = declared

    def declared_family(self, c: list[Any], s: int, e: int) -> tree.Declared:
        return tree.Declared(_text(c[0]), None, c[1], self._place(c[0]))

    def declared_member(self, c: list[Any], s: int, e: int) -> tree.Declared:
        self._check_size(c[1])
        return tree.Declared(_text(c[0]), _text(c[1]), None, self._place(c[0]))

    def fam(self, c: list[Any], s: int, e: int) -> tree.Family:
        return tree.Family(_text(c[0]), c[1], self._span(s, e))

    def lval(self, c: list[Any], s: int, e: int) -> tree.Target:
        return tree.Target(_text(c[0]), c[1], self._span(s, e))

    def network_(self, c: list[Any], s: int, e: int) -> tree.Network:
        return tree.Network(_text(c[0]), _string(c[1]), _healthy(c[2:]), self._span(s, e), self._place(c[1]))

    def net_in(self, c: list[Any], s: int, e: int) -> tree.NetworkLine:
        return tree.NetworkLine("input", c[0], c[1], "", self._span(s, e))

    def net_out(self, c: list[Any], s: int, e: int) -> tree.NetworkLine:
        return tree.NetworkLine("output", c[0], c[1], "", self._span(s, e))

    def net_sha(self, c: list[Any], s: int, e: int) -> tree.NetworkLine:
        return tree.NetworkLine("sha256", None, None, _string(c[0]), self._span(s, e))

    # ---- hybrid automata ----------------------------------------------------------

    def automaton(self, c: list[Any], s: int, e: int) -> tree.Automaton:
        return tree.Automaton(_text(c[0]), _healthy(c[1:]), self._span(s, e), self._place(c[0]))

    def var_(self, c: list[Any], s: int, e: int) -> tree.Var:
        *names, family, of, window = c
        declared = tuple(tree.Declared(n.name, n.index, family, n.span) for n in names) if family else tuple(names)
        return tree.Var(declared, of, window, self._span(s, e))

    def let_(self, c: list[Any], s: int, e: int) -> tree.Let:
        return tree.Let(c[0], c[1], c[2], self._span(s, e))

    def init_(self, c: list[Any], s: int, e: int) -> tree.Init:
        return tree.Init(c[0], c[1], c[2] or (), self._span(s, e))

    def mode_(self, c: list[Any], s: int, e: int) -> tree.Mode:
        return tree.Mode(c[0], _healthy(c[1:]), self._span(s, e))

    def domain_(self, c: list[Any], s: int, e: int) -> tree.Domain:
        return tree.Domain(c[0], self._span(s, e))

    def terminal_(self, c: list[Any], s: int, e: int) -> tree.Terminal:
        return tree.Terminal(self._span(s, e))

    def flow_(self, c: list[Any], s: int, e: int) -> tree.Flow:
        return tree.Flow(_healthy(c), self._span(s, e))

    def der(self, c: list[Any], s: int, e: int) -> tree.Derivative:
        return tree.Derivative(c[0], c[2], c[1][0] == "in", c[3], self._span(s, e))

    def edge_(self, c: list[Any], s: int, e: int) -> tree.Edge:
        urgent, label, source, target, guard, assignments = c
        return tree.Edge(urgent is not None, label, source, target, guard, assignments or (), self._span(s, e))

    def edgename(self, c: list[Any], s: int, e: int) -> tree.Declared:
        label: tree.Target = c[0]
        place = Span(self.path, label.span.start, label.span.start + len(label.name))
        return tree.Declared(label.name, self._member(label.index), None, place)

    def _member(self, index: tree.Expr | None) -> str | None:
        if index is None:
            return None
        if isinstance(index, tree.Name):
            return index.id
        if isinstance(index, tree.Number) and index.unit is None:
            return index.text
        if isinstance(index, tree.Bits):
            return index.digits
        self._report("the index of a declared name is one value of an enum", index.span)
        return None

    def assigns(self, c: list[Any], s: int, e: int) -> tuple[tree.Assignment, ...]:
        return _healthy(c)

    def asg(self, c: list[Any], s: int, e: int) -> tree.Assignment:
        return tree.Assignment(c[0], c[2], c[1][0] == "in", c[3], self._span(s, e))

    def sample_(self, c: list[Any], s: int, e: int) -> tree.Sample:
        return tree.Sample(_text(c[0]), c[1], c[2], self._span(s, e))

    def priority_(self, c: list[Any], s: int, e: int) -> tree.Priority:
        return tree.Priority(tuple(c[:-1]), c[-1], self._span(s, e))

    def schedule(self, c: list[Any], s: int, e: int) -> tree.Schedule:
        return tree.Schedule(_text(c[0]), c[1], _healthy(c[2:]), self._span(s, e))

    def slot(self, c: list[Any], s: int, e: int) -> tree.Slot:
        return tree.Slot(_text(c[0]), c[1], _text(c[2]) or None, c[3] or (), self._span(s, e))

    def instance(self, c: list[Any], s: int, e: int) -> tree.Instance:
        return tree.Instance(_text(c[0]), c[1], _healthy(c[2:]), self._span(s, e), self._place(c[0]))

    def bind(self, c: list[Any], s: int, e: int) -> tree.Binding:
        return tree.Binding(_text(c[0]), c[2], c[1][0] == "in", self._span(s, e))

    def system(self, c: list[Any], s: int, e: int) -> tree.System:
        return tree.System(_text(c[0]), _healthy(c[1:]), (), (), self._span(s, e), self._place(c[0]))

    def composed(self, c: list[Any], s: int, e: int) -> tree.System:
        return tree.System(_text(c[0]), (), c[1], c[2] or (), self._span(s, e), self._place(c[0]))

    def parallel(self, c: list[Any], s: int, e: int) -> tuple[Any, ...]:
        return tuple(c)

    def names(self, c: list[Any], s: int, e: int) -> tuple[str, ...]:
        return tuple(_text(child) for child in c)

    def part_(self, c: list[Any], s: int, e: int) -> tree.Part:
        return tree.Part(c[0], c[1], c[2] or (), self._span(s, e))

    def binds(self, c: list[Any], s: int, e: int) -> tuple[tree.Binding, ...]:
        return _healthy(c)

    def sync_(self, c: list[Any], s: int, e: int) -> tree.Sync:
        return tree.Sync(c[0], c[1], c[2] or (), c[3], c[4] or (), self._span(s, e))

    def paths(self, c: list[Any], s: int, e: int) -> tuple[Any, ...]:
        return tuple(c)

    # ---- rule tables and fuzzy systems ----------------------------------------------

    def cellular(self, c: list[Any], s: int, e: int) -> tree.Cellular:
        return tree.Cellular(_text(c[0]), _healthy(c[1:]), self._span(s, e), self._place(c[0]))

    def ca_cell(self, c: list[Any], s: int, e: int) -> tree.CellLine:
        return tree.CellLine(_text(c[0]), _text(c[1]), _text(c[2]), self._span(s, e))

    def ca_rule(self, c: list[Any], s: int, e: int) -> tree.RuleLine:
        return tree.RuleLine(c[0], c[1], self._span(s, e))

    def ca_next(self, c: list[Any], s: int, e: int) -> tree.NextLine:
        return tree.NextLine(_text(c[0]), c[1], self._span(s, e))

    def couple(self, c: list[Any], s: int, e: int) -> tree.Pair:
        return tree.Pair(self.name([c[0]], c[0][1], c[0][2]), self.name([c[1]], c[1][1], c[1][2]), self._span(s, e))

    def relation(self, c: list[Any], s: int, e: int) -> tree.Relation:
        return tree.Relation(_text(c[0]), _healthy(c[1:]), self._span(s, e), self._place(c[0]))

    def relpair(self, c: list[Any], s: int, e: int) -> tree.RuleLine:
        return tree.RuleLine(c[0].left, c[0].right, self._span(s, e), is_pair=True)

    def maplet(self, c: list[Any], s: int, e: int) -> tree.RuleLine:
        return tree.RuleLine(self.name([c[0]], c[0][1], c[0][2]), self.name([c[1]], c[1][1], c[1][2]), self._span(s, e))

    def fuzzy(self, c: list[Any], s: int, e: int) -> tree.Fuzzy:
        return tree.Fuzzy(_text(c[0]), _healthy(c[1:]), self._span(s, e), self._place(c[0]))

    def f_in(self, c: list[Any], s: int, e: int) -> tree.FuzzyLine:
        return tree.FuzzyLine("input", self._span(s, e), name=_text(c[0]), type=c[1], range=c[2], terms=tuple(c[3:]))

    def f_chain(self, c: list[Any], s: int, e: int) -> tree.FuzzyLine:
        return tree.FuzzyLine("chain", self._span(s, e), name=_text(c[0]), source=_text(c[1]), output=_text(c[2]))

    def f_out(self, c: list[Any], s: int, e: int) -> tree.FuzzyLine:
        return tree.FuzzyLine("output", self._span(s, e), name=_text(c[0]), values=self.names(c[1:], s, e))

    def f_logic(self, c: list[Any], s: int, e: int) -> tree.FuzzyLine:
        return tree.FuzzyLine("logic", self._span(s, e), values=self.names(c, s, e))

    def f_rule(self, c: list[Any], s: int, e: int) -> tree.FuzzyLine:
        label, condition, output, value = c
        return tree.FuzzyLine(
            "rule", self._span(s, e), name=_text(label), condition=condition,
            output=_text(output), values=(_text(value),),
        )  # fmt: skip

    def term(self, c: list[Any], s: int, e: int) -> tree.FuzzyTerm:
        return tree.FuzzyTerm(_text(c[0]), _text(c[1]), tuple(c[2:]), self._span(s, e))

    # ---- properties -------------------------------------------------------------------

    def assume_(self, c: list[Any], s: int, e: int) -> tree.Assume:
        return tree.Assume(_text(c[0]) or None, c[1], self._span(s, e))

    def p_assume(self, c: list[Any], s: int, e: int) -> tree.Assume:
        return tree.Assume(None, c[0], self._span(s, e))

    def invariant_(self, c: list[Any], s: int, e: int) -> tree.Invariant:
        declared, on, mode, condition, inductive, expect = c
        return tree.Invariant(declared, on, mode, condition, inductive is not None, expect, self._span(s, e))

    def property_(self, c: list[Any], s: int, e: int) -> tree.Property:
        return tree.Property(c[0], c[1], _healthy(c[2:]), self._span(s, e))

    def p_horizon(self, c: list[Any], s: int, e: int) -> tree.Horizon:
        return tree.Horizon(c[0], c[1], self._span(s, e))

    def p_jumps(self, c: list[Any], s: int, e: int) -> tree.Horizon:
        return tree.Horizon(None, c[0], self._span(s, e))

    def p_which(self, c: list[Any], s: int, e: int) -> tree.Which:
        return tree.Which(_text(c[0]), c[1], self._span(s, e))

    def p_using(self, c: list[Any], s: int, e: int) -> tree.Using:
        return tree.Using(tuple(self.name([child], child[1], child[2]) for child in c), self._span(s, e))

    def p_method(self, c: list[Any], s: int, e: int) -> tree.Method:
        return tree.Method(_text(c[0]), _healthy(c[1:]), self._span(s, e))

    def g_always(self, c: list[Any], s: int, e: int) -> tree.Goal:
        return tree.Goal("always", c[2], self._span(s, e), window=c[1])

    def g_plain(self, c: list[Any], s: int, e: int) -> tree.Goal:
        return tree.Goal(_text(c[0]), c[1], self._span(s, e), within=c[2] if len(c) > 2 else None)

    def g_can_reach(self, c: list[Any], s: int, e: int) -> tree.Goal:
        return tree.Goal("can_reach", c[0], self._span(s, e), within=c[1])

    def g_can_always(self, c: list[Any], s: int, e: int) -> tree.Goal:
        return tree.Goal("can_always", c[0], self._span(s, e))

    def g_cycle(self, c: list[Any], s: int, e: int) -> tree.Goal:
        return tree.Goal("cycle", c[0], self._span(s, e), within=c[1], attracting=c[2] is not None)

    def tail(self, c: list[Any], s: int, e: int) -> tree.Expectation:
        because = _string(c[3]) if c[3] else None
        return tree.Expectation(_text(c[0]), c[1], c[2], because, self._span(s, e))

    def bound(self, c: list[Any], s: int, e: int) -> tuple[str, Any]:
        return _text(c[0]), c[1]

    def window(self, c: list[Any], s: int, e: int) -> tuple[Any, Any]:
        return c[0], c[1]

    # ---- expressions --------------------------------------------------------------------

    def ite(self, c: list[Any], s: int, e: int) -> tree.If:
        return tree.If(c[0], c[1], c[2], self._span(s, e))

    def quant(self, c: list[Any], s: int, e: int) -> tree.Quantifier:
        return tree.Quantifier(_text(c[0]), _text(c[1]), c[2], c[3], self._span(s, e))

    def binary(self, c: list[Any], s: int, e: int) -> tree.Binary:
        return tree.Binary(c[1][0], c[0], c[2], Span(self.path, s, e))

    def until(self, c: list[Any], s: int, e: int) -> tree.Until:
        return tree.Until(c[0], c[1][0], c[1][1], c[2], self._span(s, e))

    def unary(self, c: list[Any], s: int, e: int) -> tree.Unary:
        return tree.Unary(c[0][0], c[1], self._span(s, e))

    def temporal(self, c: list[Any], s: int, e: int) -> tree.Temporal:
        return tree.Temporal(_text(c[0]), c[1][0], c[1][1], c[2], self._span(s, e))

    def comparison(self, c: list[Any], s: int, e: int) -> tree.Comparison:
        return tree.Comparison(tuple(c[0::2]), tuple(op[0] for op in c[1::2]), self._span(s, e))

    def quantity(self, c: list[Any], s: int, e: int) -> tree.Number:
        text = c[0][0]
        number = self._number(text)
        assert number is not None  # a quantity starts with a number
        return tree.Number(self._value(number[0], s), number[0], text[number.end() :].strip(), self._span(s, e))

    def number(self, c: list[Any], s: int, e: int) -> tree.Number:
        return tree.Number(self._value(c[0][0], s), c[0][0], None, self._span(s, e))

    def user_quantity(self, c: list[Any], s: int, e: int) -> tree.Number:
        return tree.Number(self._value(c[0][0], s), c[0][0], c[1][0], self._span(s, e))

    def bits(self, c: list[Any], s: int, e: int) -> tree.Bits:
        self._check_size(c[0])
        return tree.Bits(c[0][0], self._span(s, e))

    def truth(self, c: list[Any], s: int, e: int) -> tree.Truth:
        return tree.Truth(c[0][0] == "true", self._span(s, e))

    def name(self, c: list[Any], s: int, e: int) -> tree.Name:
        return tree.Name(c[0][0], Span(self.path, s, e))

    def member(self, c: list[Any], s: int, e: int) -> tree.Member:
        return tree.Member(c[0], c[1][0], self._span(s, e))

    def index(self, c: list[Any], s: int, e: int) -> tree.Index:
        return tree.Index(c[0], c[1], self._span(s, e))

    def call(self, c: list[Any], s: int, e: int) -> tree.Call:
        return tree.Call(c[0], _healthy(c[1:]), self._span(s, e))

    def callarg(self, c: list[Any], s: int, e: int) -> tree.Argument:
        return tree.Argument(_text(c[0]) or None, c[1], c[2], self._span(s, e))

    def paren(self, c: list[Any], s: int, e: int) -> tree.Paren:
        return tree.Paren(c[0], self._span(s, e))

    def tuple_(self, c: list[Any], s: int, e: int) -> tree.Pair:
        return tree.Pair(c[0], c[1], self._span(s, e))

    def interval(self, c: list[Any], s: int, e: int) -> tree.Interval:
        return tree.Interval(c[0], c[1], self._span(s, e))

    # ---- numbers ----------------------------------------------------------------------------

    def _value(self, text: str, start: int) -> Fraction:
        value = self._values.get(text)
        if value is None:
            value = exact(text)
            if value is None:
                self._report(NO_NUMBER, self._span(start, start + len(text)))
                return Fraction(0)
            self._values[text] = value
        return value

    def _check_size(self, token: Any) -> None:
        if len(token[0]) > MOST_DIGITS:
            self._report(NO_NUMBER, self._place(token))

    def _report(self, message: str, span: Span) -> None:
        self.findings.append(Diagnostic("HA001", message, span))


def dotted(name: Any) -> str:
    """The text of a dotted name."""
    parts = []
    while type(name) is tree.Member:
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
