"""HA501, HA502, HA503, HA505, HA506: what is wrong with rule tables, relations and codes."""

import pytest

from haverify.diagnostics.diagnostic import Severity
from haverify.elaborate.elaborate import elaborate
from haverify.elaborate.files import Files
from haverify.syntax.parse import parse
from haverify.text.source import Source

ENUMS = "enum Leg { Left = 0b0, Right = 0b1 }\nenum Sub { IC = 0b00, LR = 0b01, MS = 0b10 }\n"
RULES = [
    "rule (Left, IC) -> (Right, MS)",
    "rule (Left, LR) -> (Right, LR)",
    "rule (Left, MS) -> (Right, IC)",
    "rule 0b100 -> 0b010",
    "rule 0b101 -> 0b001",
    "rule 0b110 -> 0b000",
]


def table(*rules: str, tail: str = "") -> str:
    """An automaton with the rules."""
    body = "\n  ".join(rules)
    return f"{ENUMS}cellular Partner {{\n  cell Cell = Leg ++ Sub\n  {body}\n}}\n{tail}"


def test_a_whole_table(lint):
    assert [d.code for d in lint(table(*RULES)).found] == []


@pytest.mark.parametrize("gone", range(6))
def test_every_missing_rule_is_found(lint, gone):
    (d,) = lint(table(*RULES[:gone], *RULES[gone + 1 :])).of("HA501")
    bits = ["000", "001", "010", "100", "101", "110"][gone]
    assert f"no rule for 0b{bits} (" in d.message
    assert d.label == "1 of 6 cells lead nowhere"


def test_few_missing_rules_are_named_and_all_are_in_the_key(lint):
    found = lint(table(RULES[0]))
    (d,) = found.of("HA501")
    assert d.message.endswith("0b100 (Right IC), 0b101 (Right LR) and 1 more")
    assert d.key == "Partner is not total: 001, 010, 100, 101, 110"
    assert found.at("HA501") == "Partner"


def test_a_formula_without_a_value(lint):
    assert not lint(table("next(c) = if c.sub is IC then (Left, IC) else 0b001")).of("HA501")
    text = "relation R { IC -> IC; LR -> LR }\n" + table("next(c) = if R(c.sub) is IC then (Left, IC) else (Left, MS)")
    (d,) = lint(text).of("HA501")
    assert "no value of next() for 0b010 (Left MS), 0b110 (Right MS)" in d.message


def test_two_rules_for_one_cell(lint):
    found = lint(table(*RULES, "rule (Left, IC) -> (Right, LR)"))
    (d,) = found.of("HA502")
    assert d.message == (
        "Partner: rules send 0b000 (Left IC) to different cells, 0b110 (Right MS) and 0b101 (Right LR)"
    )
    assert found.at("HA502") == "rule (Left, IC) -> (Right, LR)"
    assert [label.text for label in d.labels] == ["to 0b110 (Right MS)"]
    assert d.key == "Partner: 000 leads to 110 and 101"


def test_a_formula_beside_rules(lint):
    same = "next(c) = if c.leg is Left then (if c.sub is IC then (Right, MS) else c) else c"
    assert not lint(table(RULES[0], same)).of("HA502")
    (d,) = lint(table(RULES[1], same)).of("HA502")
    assert "a rule and next() send 0b001 (Left LR)" in d.message


def test_a_rule_written_twice_and_its_fix(lint):
    text = table(*RULES, "rule 0b000 -> (Right, MS)")
    found = lint(text)
    (d,) = found.of("HA503")
    assert d.message == "Partner: rule 0b000 -> 0b110 is repeated"
    assert d.fix is not None and d.fix.safe
    assert not found.of("HA502")
    assert lint(found.fixed("HA503")).found == []


def test_a_pair_written_twice(lint):
    (d,) = lint(ENUMS + "relation R { (IC, LR); (IC, MS); (IC, LR) }\n").of("HA503")
    assert d.message == "R: pair IC -> LR is repeated"


CLAIM = "property p on Partner { holds forall c in Cell: %s; expect unknown }\n"
TEXT = "relation Text { IC -> MS; LR -> LR; MS -> LR }\n"


def test_rules_and_a_relation_that_disagree(lint):
    found = lint(table(*RULES, tail=TEXT + CLAIM % "next(c).sub == Text(c.sub)"))
    (d,) = found.of("HA505")
    assert d.message == (
        "Partner and Text disagree for 2 of 6: Left MS (0b010): Partner.next(c).sub is IC, Text(c.sub) is LR"
    )
    assert d.notes == ("Right MS (0b110): Partner.next(c).sub is IC, Text(c.sub) is LR",)
    assert d.key == "Partner and Text disagree: Left MS (0b010), Right MS (0b110)"


def test_only_where_the_premise_holds(lint):
    (d,) = lint(table(*RULES, tail=TEXT + CLAIM % "c.leg is Left implies Text(c.sub) == next(c).sub")).of("HA505")
    assert d.message.startswith("Text and Partner disagree for 1 of 3: Left MS (0b010)")
    agreeing = CLAIM % "c.leg is Left and not (c.sub is MS) implies next(c).sub == Text(c.sub)"
    assert not lint(table(*RULES, tail=TEXT + agreeing)).of("HA505")


def test_two_relations_that_disagree(lint):
    other = "relation Table { IC -> MS; LR -> LR; MS -> IC }\n"
    claim = "property p { holds forall s in Sub: Text(s) == Table(s); expect unknown }\n"
    (d,) = lint(ENUMS + TEXT + other + claim).of("HA505")
    assert d.message == "Text and Table disagree for 1 of 3: Text(MS) is LR, Table(MS) is IC"


def test_one_description_compared_with_itself(lint):
    assert not lint(table(*RULES, tail=CLAIM % "next(next(c)) == next(c)")).of("HA505")


def test_one_code_with_two_names(lint):
    text = "enum Sub { IC = 0b00, LR = 0b1, MS = 0b01 }\nrelation R { IC -> LR; LR -> MS }\n"
    (d,) = lint(text).of("HA506")
    assert d.message == "Sub: code 01 has two names, LR and MS"
    assert not lint(text.replace("0b1,", "0b11,")).of("HA506")
    assert not lint("enum Sub { IC, LR, MS }\nrelation R { IC -> LR; LR -> MS }\n").of("HA506")


def test_two_codes_with_one_name():
    text = 'spec "T" version "1.0"\nenum Sub { MS = 0b010, LR = 0b001, MS = 0b110 }\nrelation R { MS -> LR }\n'
    source = Source.of_text("test.ha", text)
    tree, _ = parse(source)
    _, found = elaborate(tree, Files({source.path: source}))
    (d,) = [d for d in found if d.code == "HA506"]
    assert d.message == "Sub: 'MS' names 0b010 and 0b110"
    assert d.severity is Severity.ERROR
