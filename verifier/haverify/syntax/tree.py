"""Syntax nodes of a `.ha` file, each with the span of text it came from.

A tree holds what was written and nothing else: no resolved name, no unit arithmetic, no sugar removed.
`parse` makes it, `format` prints it, `elaborate` gives it meaning.
"""

from __future__ import annotations

from fractions import Fraction

from haverify.text.record import record
from haverify.text.span import Span

# ---- expressions -------------------------------------------------------------


@record
class Number:
    """`20.06656`, `4e4`; with `unit` a quantity (`0.4 s`, `2 rpm`). `text` is the number as written."""

    value: Fraction
    text: str
    unit: str | None
    span: Span


@record
class Bits:
    """`0b0111`: a code with its width."""

    digits: str
    span: Span


@record
class Truth:
    """`true` or `false`."""

    value: bool
    span: Span


@record
class Name:
    """An identifier."""

    id: str
    span: Span


@record
class Member:
    """`base.name`."""

    base: Expr
    name: str
    span: Span


@record
class Index:
    """`base[index]`."""

    base: Expr
    index: Expr
    span: Span


@record
class Argument:
    """An argument of a call: `expr`, `name = expr`, `expr for family.name in family.of`."""

    name: str | None
    value: Expr
    family: Family | None
    span: Span


@record
class Call:
    """`function(arguments)`."""

    function: Expr
    arguments: tuple[Argument, ...]
    span: Span


@record
class Unary:
    """`-e` or `not e`; `op` is `-` or `not`."""

    op: str
    operand: Expr
    span: Span


@record
class Binary:
    """`+ - * / ^ +- and or implies`; `and` and `or` are left-nested."""

    op: str
    left: Expr
    right: Expr
    span: Span


@record
class Comparison:
    """A chain `operands[0] ops[0] operands[1] ops[1] ...` with ops `< <= > >= == != is in`; at least one op."""

    operands: tuple[Expr, ...]
    ops: tuple[str, ...]
    span: Span


@record
class Interval:
    """`[low, high]`, a set."""

    low: Expr
    high: Expr
    span: Span


@record
class Pair:
    """`(left, right)`."""

    left: Expr
    right: Expr
    span: Span


@record
class If:
    """`if condition then yes else no`."""

    condition: Expr
    yes: Expr
    no: Expr
    span: Span


@record
class Quantifier:
    """`forall name in of: body`; `kind` is `forall`, `exists` or `unique`; `of` is a dotted name."""

    kind: str
    name: str
    of: Expr
    body: Expr
    span: Span


@record
class Temporal:
    """`globally[low, high] body` or `eventually[low, high] body`."""

    kind: str
    low: Expr
    high: Expr
    body: Expr
    span: Span


@record
class Until:
    """`left until[low, high] right`."""

    left: Expr
    low: Expr
    high: Expr
    right: Expr
    span: Span


@record
class Paren:
    """`(inner)`: kept, so that a formatter can keep what an author grouped."""

    inner: Expr
    span: Span


Expr = (
    Number | Bits | Truth | Name | Member | Index | Call | Unary | Binary | Comparison | Interval | Pair | If
    | Quantifier | Temporal | Until | Paren
)  # fmt: skip

# ---- pieces of declarations ----------------------------------------------------


@record
class Family:
    """`for name in of`: one declaration per value; `of` is a Name or Member chain."""

    name: str
    of: Expr
    span: Span


@record
class Type:
    """`: unit`, `: 1`, `: bool`, `: EnumName`; `text` without the colon."""

    text: str
    span: Span


@record
class Declared:
    """A declared name: `name`, `name for i in I` (family) or `name[value]` (one member, as `expand` writes)."""

    name: str
    index: str | None
    family: Family | None
    span: Span  # of the name alone


@record
class Target:
    """What is assigned, differentiated or jumped to: `name` or `name[index]`."""

    name: str
    index: Expr | None
    span: Span


@record
class Assignment:
    """`target := value` or `target in value` (`is_set`), possibly one per value of a family."""

    target: Target
    value: Expr
    is_set: bool
    family: Family | None
    span: Span


@record
class Derivative:
    """`target' = value` or `target' in value` (`is_set`)."""

    target: Target
    value: Expr
    is_set: bool
    family: Family | None
    span: Span


@record
class AttributeArgument:
    """An argument of an attribute or a method: `value` or `name = value`; strings are `str`."""

    name: str | None
    value: Expr | str
    span: Span


@record
class Attribute:
    """`@name(arguments)` before a declaration."""

    name: str
    arguments: tuple[AttributeArgument, ...]
    span: Span


@record
class Binding:
    """`name = value` or `name in value` (`is_set`) after `with` of an instance or a part."""

    name: str
    value: Expr
    is_set: bool
    span: Span


@record
class Item:
    """A declaration or member line with the doc comments (without `///`) and attributes in front of it."""

    docs: tuple[str, ...]
    attributes: tuple[Attribute, ...]
    body: Decl
    span: Span  # from the first doc comment to the end of the body


# ---- declarations --------------------------------------------------------------


@record
class SpecHeader:
    title: str
    version: str
    unitless: bool
    span: Span


@record
class Import:
    path: str
    alias: str | None
    span: Span  # of the whole line
    path_span: Span


@record
class UnitDecl:
    name: str
    value: Expr | None
    span: Span


@record
class Const:
    declared: Declared
    type: Type | None
    value: Expr
    span: Span


@record
class Param:
    declared: Declared
    type: Type | None
    range: Expr
    default: Expr | None
    span: Span


@record
class Input:
    declared: Declared
    type: Type | None
    range: Expr | None
    rate: Expr | None
    every: Expr | None
    span: Span


@record
class EnumValue:
    name: str
    code: str | None  # a number or `0b...` as written
    span: Span


@record
class EnumDecl:
    """`values` of an enumeration, or `low`..`high` of an integer one."""

    name: str
    values: tuple[EnumValue, ...]
    low: Number | None
    high: Number | None
    span: Span


@record
class TableLine:
    """A line of a table.

    kind          fields used
    key           name, of (enum name)
    poly          name and last (columns), order, argument (name), type (of the argument), result (unit text)
    axis          name, type
    column        name, type, tolerance
    matrix        of (rows), by (columns) as dotted names, type
    interpolate   name
    add           name
    digits        number
    sha256        text
    """

    kind: str
    span: Span
    name: str = ""
    of: str = ""
    by: str = ""
    last: str = ""
    order: str = ""
    argument: str = ""
    result: str = ""
    type: Type | None = None
    tolerance: Expr | None = None
    number: Number | None = None
    text: str = ""


@record
class Table:
    name: str
    path: str
    lines: tuple[TableLine, ...]
    span: Span
    path_span: Span


@record
class Formal:
    name: str
    type: Type | None
    span: Span


@record
class Function:
    name: str
    formals: tuple[Formal, ...]
    type: Type | None
    value: Expr
    span: Span


@record
class NetworkLine:
    kind: str  # "input", "output", "sha256"
    declared: Declared | None
    type: Type | None
    text: str
    span: Span


@record
class Network:
    name: str
    path: str
    lines: tuple[NetworkLine, ...]
    span: Span
    path_span: Span


@record
class Var:
    """`var a, b for i in I: m in R`."""

    names: tuple[Declared, ...]  # each with the same family
    type: Type | None
    range: Expr | None
    span: Span


@record
class Let:
    declared: Declared
    type: Type | None
    value: Expr
    span: Span


@record
class Init:
    mode: Target | None
    where: Expr | None
    assignments: tuple[Assignment, ...]
    span: Span


@record
class Domain:
    condition: Expr
    span: Span


@record
class Flow:
    lines: tuple[Derivative, ...]
    span: Span


@record
class Terminal:
    span: Span


@record
class Mode:
    """`mode name { ... }`, `mode name for p in E { ... }` or, as `expand` writes, `mode name[value] { ... }`."""

    declared: Declared
    members: tuple[Item, ...]
    span: Span


@record
class Edge:
    urgent: bool
    declared: Declared | None
    source: Target | None
    target: Target
    guard: Expr | None
    assignments: tuple[Assignment, ...]
    span: Span


@record
class Sample:
    name: str
    period: Expr
    assignments: tuple[Assignment, ...]
    span: Span


@record
class Priority:
    """`priority paths[0] over paths[1] ... when guard`; a path is a Name, Member or Index chain."""

    paths: tuple[Expr, ...]
    guard: Expr | None
    span: Span


@record
class Slot:
    mode: str
    until: Expr
    then: str | None
    assignments: tuple[Assignment, ...]
    span: Span


@record
class Schedule:
    clock: str
    start: Expr
    slots: tuple[Slot, ...]
    span: Span


@record
class Automaton:
    name: str
    members: tuple[Item, ...]
    span: Span
    name_span: Span


@record
class Instance:
    """`automaton name = base with { bindings }`."""

    name: str
    base: Expr
    bindings: tuple[Binding, ...]
    span: Span
    name_span: Span


@record
class Part:
    declared: Declared
    base: Expr
    bindings: tuple[Binding, ...]
    span: Span


@record
class Sync:
    """`sync name: paths -> listeners when guard do assignments`; a rendezvous when there are no listeners."""

    declared: Declared
    paths: tuple[Expr, ...]
    listeners: tuple[Expr, ...]
    guard: Expr | None
    assignments: tuple[Assignment, ...]
    span: Span


@record
class System:
    """`system name { members }`, or `system name = parts[0] || ... sync syncs` (then `members` is empty)."""

    name: str
    members: tuple[Item, ...]
    parts: tuple[Expr, ...]
    syncs: tuple[str, ...]
    span: Span
    name_span: Span


@record
class CellLine:
    """`cell name = first ++ second`."""

    name: str
    first: str
    second: str
    span: Span


@record
class RuleLine:
    """`rule left -> right` of a cellular automaton, or a pair or maplet of a relation: Name, Bits or Pair of Names."""

    left: Expr
    right: Expr
    span: Span
    is_pair: bool = False  # a relation's `(a, b)`, as opposed to `a -> b`


@record
class NextLine:
    """`next(name) = value`."""

    name: str
    value: Expr
    span: Span


@record
class Cellular:
    name: str
    lines: tuple[CellLine | RuleLine | NextLine, ...]
    span: Span
    name_span: Span


@record
class Relation:
    name: str
    lines: tuple[RuleLine, ...]
    span: Span
    name_span: Span


@record
class FuzzyTerm:
    """`name = shape(corners)`."""

    name: str
    shape: str
    corners: tuple[Expr, ...]
    span: Span


@record
class FuzzyLine:
    """A line of a fuzzy system.

    kind     fields used
    input    name, type, range, terms
    chain    name, source (fuzzy system), output
    output   name, values
    logic    values (two words)
    rule     name (may be empty), condition, output, values (one term)
    """

    kind: str
    span: Span
    name: str = ""
    type: Type | None = None
    range: Expr | None = None
    terms: tuple[FuzzyTerm, ...] = ()
    source: str = ""
    output: str = ""
    values: tuple[str, ...] = ()
    condition: Expr | None = None


@record
class Fuzzy:
    name: str
    lines: tuple[FuzzyLine, ...]
    span: Span
    name_span: Span


@record
class Expectation:
    """`expect verdict margin op q share op q because "..."`; comparisons are (op, bound)."""

    verdict: str
    margin: tuple[str, Expr] | None
    share: tuple[str, Expr] | None
    because: str | None
    span: Span


@record
class Assume:
    name: str | None
    condition: Expr
    span: Span


@record
class Invariant:
    declared: Declared
    on: Expr | None
    mode: Target | None
    condition: Expr
    inductive: bool
    expect: Expectation | None
    span: Span


@record
class Goal:
    """A goal line.

    kind          fields used
    always        condition; window when `during`
    never reach can_reach can_always stl holds cycle     condition; within where written; attracting
    """

    kind: str
    condition: Expr
    span: Span
    window: tuple[Expr, Expr] | None = None
    within: Expr | None = None
    attracting: bool = False


@record
class Horizon:
    """`within time, jumps jumps`, `within jumps jumps`, `within time`."""

    time: Expr | None
    jumps: Number | None
    span: Span


@record
class Which:
    """`for which name in range`."""

    name: str
    range: Expr
    span: Span


@record
class Using:
    names: tuple[Name, ...]
    span: Span


@record
class Method:
    name: str
    arguments: tuple[AttributeArgument, ...]
    span: Span


@record
class Property:
    declared: Declared
    on: Expr | None
    lines: tuple[Item, ...]  # bodies: Assume, Horizon, Which, Using, Method, Goal, Expectation
    span: Span


Decl = (
    SpecHeader | Import | UnitDecl | Const | Param | Input | EnumDecl | Table | Function | Network | Automaton
    | Instance | System | Cellular | Relation | Fuzzy | Assume | Invariant | Property | Var | Let | Init | Domain
    | Flow | Terminal | Mode | Edge | Sample | Priority | Schedule | Part | Sync | Horizon | Which | Using | Method
    | Goal | Expectation
)  # fmt: skip


@record
class Tree:
    """A whole file: its items in order, and its `//` comments (text with the slashes, span) in order."""

    path: str
    items: tuple[Item, ...]
    comments: tuple[tuple[str, Span], ...]
    span: Span
