"""Every construct gives the node that says what was written."""

from fractions import Fraction

import pytest
from tests.trees import SAMPLES, bare, healthy

from haverify.syntax import tree as t
from haverify.syntax.expressions import print_expr

HEAD = 'spec "x" version "1.0"\n'


def only(text: str) -> t.Decl:
    """The declaration after the header."""
    return healthy(HEAD + text).items[1].body


def member(text: str) -> t.Decl:
    """The only member of an automaton."""
    automaton = only("automaton A {\n" + text + "\n}")
    assert isinstance(automaton, t.Automaton)
    (item,) = automaton.members
    return item.body


def part(text: str) -> t.Decl:
    """The only member of a system."""
    system = only("system S {\n" + text + "\n}")
    assert isinstance(system, t.System)
    (item,) = system.members
    return item.body


def line(text: str) -> t.Decl:
    """The only line of a property."""
    claim = only("property p on A {\n" + text + "\n}")
    assert isinstance(claim, t.Property)
    (item,) = claim.lines
    return item.body


def expr(text: str) -> t.Expr:
    """The expression `text`."""
    body = only(f"assume {text}")
    assert isinstance(body, t.Assume)
    return body.condition


@pytest.mark.parametrize("name", SAMPLES)
def test_samples_are_read_without_a_finding(name: str) -> None:
    assert healthy(SAMPLES[name]).items[0].body.__class__ is t.SpecHeader


def test_header_and_imports() -> None:
    tree = healthy('spec "a b" version "1.0" unitless\nimport "f.ha" as n\nimport "g.ha"\nunit rpm = 6 deg/s; unit EUR')
    header, first, second, rpm, eur = (item.body for item in tree.items)
    assert isinstance(header, t.SpecHeader) and (header.title, header.version, header.unitless) == ("a b", "1.0", True)
    assert isinstance(first, t.Import) and (first.path, first.alias) == ("f.ha", "n")
    assert isinstance(second, t.Import) and second.alias is None
    assert isinstance(rpm, t.UnitDecl) and rpm.value is not None
    assert isinstance(eur, t.UnitDecl) and eur.value is None


@pytest.mark.parametrize(
    ("text", "value", "unit"),
    [
        ("0.1", Fraction(1, 10), None),
        ("4.061e4", Fraction(40610), None),
        ("9.81 m/s^2", Fraction(981, 100), "m/s^2"),
        ("1e-400", Fraction(1, 10**400), None),
        ("1E+2 kg.m^2", Fraction(100), "kg.m^2"),
        ("2 s^-1", Fraction(2), "s^-1"),
        ("3 rpm", Fraction(3), "rpm"),
        ("50%", Fraction(50), "%"),
        ("5min", Fraction(5), "min"),
    ],
)
def test_numbers_are_exact(text: str, value: Fraction, unit: str | None) -> None:
    number = expr(text)
    assert isinstance(number, t.Number)
    assert (number.value, number.unit) == (value, unit)
    assert text.startswith(number.text)


def test_a_number_before_an_operator_keeps_its_unit_to_itself() -> None:
    product = expr("2 m / s")
    assert isinstance(product, t.Binary) and isinstance(product.left, t.Number)
    assert (product.op, product.left.unit) == ("/", "m")


def test_declarations_of_values() -> None:
    const = only("const a: m/s = 1 m/s")
    param = only("param k for i in I: kg in [1 kg, 2 kg] default 1 kg")
    signal = only("input u: 1 in [0, 1] rate [-1 Hz, 1 Hz] every 5 s")
    port = only("input u")
    assert isinstance(const, t.Const) and const.type is not None and const.type.text == "m/s"
    assert isinstance(param, t.Param) and param.declared.family is not None and param.default is not None
    assert isinstance(signal, t.Input) and None not in (signal.range, signal.rate, signal.every)
    assert isinstance(port, t.Input) and (port.range, port.rate, port.every, port.type) == (None,) * 4


@pytest.mark.parametrize(
    "text",
    ["const a[hip] = 1", "param a[1] in [0, 1]", "input a[0b01]: m", "property a[2] { holds true }"],
)
def test_a_declared_name_may_be_one_member_of_a_family(text: str) -> None:
    declared = only(text).declared  # type: ignore[union-attr]
    assert (declared.name, declared.family) == ("a", None)
    assert declared.index in ("hip", "1", "0b01", "2")


@pytest.mark.parametrize(
    "text",
    ["var x[1]: m", "let q[hip]: deg = 1 deg", "mode Run[LR] { terminal }", "edge go[2]: A -> B", "edge g[b]: -> B"],
)
def test_members_of_an_automaton_may_be_members_of_a_family(text: str) -> None:
    body = member(text)
    declared = body.names[0] if isinstance(body, t.Var) else body.declared  # type: ignore[union-attr]
    assert declared is not None and declared.index is not None


def test_edges_with_and_without_names_and_sources() -> None:
    edges = [
        member(text) for text in ("edge -> B", "edge A -> B", "edge n: -> B", "urgent edge n for i in I: A[i] -> B[1]")
    ]
    assert all(isinstance(edge, t.Edge) for edge in edges)
    named = [edge.declared is not None for edge in edges if isinstance(edge, t.Edge)]
    sources = [edge.source is not None for edge in edges if isinstance(edge, t.Edge)]
    assert (named, sources) == ([False, False, True, True], [False, True, False, True])


def test_an_edge_with_everything() -> None:
    edge = member("urgent edge go: A -> B[1] when x > 1 m\n do { x := 0 m\n y in [0, 1], z[i] := i for i in I }")
    assert isinstance(edge, t.Edge) and edge.urgent and edge.guard is not None
    assert [(a.target.name, a.is_set, a.family is not None) for a in edge.assignments] == [
        ("x", False, False),
        ("y", True, False),
        ("z", False, True),
    ]


def test_flow_lines_end_at_commas_semicolons_and_lines() -> None:
    flow = member("flow { x' = 1, y' in [0, 1]; z[i]' = 2 for i in I\n w' = 3 }")
    assert isinstance(flow, t.Flow)
    assert [(d.target.name, d.is_set) for d in flow.lines] == [("x", False), ("y", True), ("z", False), ("w", False)]


def test_schedules_samples_priorities() -> None:
    schedule = member("schedule on x from 0 s { A until 1 s\n B until 2 s then A do x := 0 s }")
    sample = member("sample c every [95 ms, 105 ms] do u := 1")
    priority = member("priority a.b over c[1] over d when x > 1")
    assert isinstance(schedule, t.Schedule) and [slot.then for slot in schedule.slots] == [None, "A"]
    assert isinstance(sample, t.Sample) and len(sample.assignments) == 1
    assert isinstance(priority, t.Priority) and len(priority.paths) == 3 and priority.guard is not None


def test_systems() -> None:
    sync = part("sync s for i in I: a[i].e, b.f -> c.g, d.h when x > 1 do y := 2")
    composed = only("system S = A || B.c sync e, f")
    bound = part("part p[1] = A with { k = 1; m in [0, 1] }")
    assert isinstance(sync, t.Sync) and (len(sync.paths), len(sync.listeners)) == (2, 2)
    assert isinstance(composed, t.System) and (len(composed.parts), composed.syncs) == (2, ("e", "f"))
    assert isinstance(bound, t.Part) and [binding.is_set for binding in bound.bindings] == [False, True]


def test_property_lines() -> None:
    goals = {
        "always during [0 s, 1 s] x < 1": "always", "never x > 1": "never", "reach x within 2 s": "reach",
        "can reach x": "can_reach", "can always x": "can_always", "stl globally[0 s, 1 s] x": "stl",
        "holds x": "holds", "cycle through x within 2 s attracting": "cycle",
    }  # fmt: skip
    for text, kind in goals.items():
        goal = line(text)
        assert isinstance(goal, t.Goal) and goal.kind == kind


def test_horizons() -> None:
    both, jumps, time = line("within 10 s, 40 jumps"), line("within 3 jumps"), line("within 7")
    assert all(isinstance(body, t.Horizon) for body in (both, jumps, time))
    assert bare(both)[1] is not None and bare(both)[2] is not None
    assert bare(jumps)[1] is None and bare(time)[2] is None


def test_an_expectation_with_everything() -> None:
    expect = line('expect refuted margin < -0.5 deg share >= 0.9 because "it is so"')
    assert isinstance(expect, t.Expectation) and expect.margin is not None and expect.share is not None
    assert (expect.verdict, expect.margin[0], expect.share[0], expect.because) == ("refuted", "<", ">=", "it is so")


@pytest.mark.parametrize(
    ("text", "grouped"),
    [
        ("a - b - c", "((a - b) - c)"),
        ("-x^2", "(-(x^2))"),
        ("2^-x^y", "(2^(-(x^y)))"),
        ("a or b and not c", "(a or (b and (not c)))"),
        ("a implies b implies c", "(a implies (b implies c))"),
        ("c +- d * 2", "(c +- (d * 2))"),
        ("x is a or y in [0, 1]", "((x is a) or (y in [0, 1]))"),
    ],
)
def test_precedence(text: str, grouped: str) -> None:
    assert _grouped(expr(text)) == grouped


def _grouped(node: t.Expr) -> str:
    match node:
        case t.Binary():
            glue = node.op if node.op == "^" else f" {node.op} "
            return f"({_grouped(node.left)}{glue}{_grouped(node.right)})"
        case t.Unary():
            return f"({node.op}{' ' * (node.op == 'not')}{_grouped(node.operand)})"
        case t.Comparison():
            return f"({print_expr(node)})"
    return print_expr(node)


def test_a_line_goes_on_where_the_language_says_so() -> None:
    body = expr("(a\n\n + b) <\n 3 and // why\n  c\n  or d\n implies\n e")
    assert print_expr(body) == "(a + b) < 3 and c or d implies e"


def test_words_are_names_where_they_have_no_meaning() -> None:
    body = member("var axis, default, sample, part, key, cell, every, rate, over, unique: 1")
    assert isinstance(body, t.Var) and len(body.names) == 10


def test_docs_and_attributes_belong_to_what_follows() -> None:
    tree = healthy(HEAD + '///  two\n///\n/// lines\n@allow(HA401, reason = "r")\n@note\n\nconst a = 1')
    item = tree.items[1]
    assert item.docs == (" two", "", "lines")
    assert [(a.name, len(a.arguments)) for a in item.attributes] == [("allow", 2), ("note", 0)]
    assert item.attributes[0].arguments[1].value == "r"


def test_comments_are_kept_with_their_places() -> None:
    text = "// first é\n" + HEAD + "const a = 1 // last  \n//// ruler"
    tree = healthy(text)
    assert [(c, text[s.start : s.end]) for c, s in tree.comments] == [
        ("// first é", "// first é"),
        ("// last", "// last"),
        ("//// ruler", "//// ruler"),
    ]


def test_spans_cover_what_was_written() -> None:
    text = HEAD + "/// doc\nconst alpha: rad = 0.2 rad + b\n"
    item = healthy(text).items[1]
    assert isinstance(item.body, t.Const)
    pieces = [item.span, item.body.span, item.body.declared.span, item.body.value.span]
    assert [text[s.start : s.end] for s in pieces] == [
        "/// doc\nconst alpha: rad = 0.2 rad + b",
        "const alpha: rad = 0.2 rad + b",
        "alpha",
        "0.2 rad + b",
    ]


def test_carriage_returns_tabs_and_a_mark_at_the_start_do_not_matter() -> None:
    plain = HEAD + "const a = 1\nconst b = 2 // c\n"
    assert bare(healthy("\ufeff" + plain.replace("\n", "\r\n\t")).items) == bare(healthy(plain).items)


def test_chains_may_be_long() -> None:
    body = expr(" and ".join(f"x{k} < {k}" for k in range(5000)))
    assert isinstance(body, t.Binary)
    assert print_expr(body).count(" and ") == 4999
