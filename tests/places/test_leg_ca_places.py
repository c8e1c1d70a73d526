"""Every place of `spec/leg_ca.ha` where a slip matters: a rule or an arrow gone, a bit of a rule turned."""

import re
from collections.abc import Iterator
from fractions import Fraction
from functools import cache
from pathlib import Path

import pytest

from haverify.analyses.portfolio import decide_all
from haverify.cli import main
from haverify.diagnostics.codes import is_error
from haverify.elaborate.elaborate import elaborate
from haverify.elaborate.files import Files
from haverify.evidence.verdict import Proved, Refuted, Unknown
from haverify.lint._facts import Facts
from haverify.lint.conflicting_rules import conflicting_rules
from haverify.lint.partial_rules import partial_rules
from haverify.model.cellular import Rule
from haverify.model.spec import Spec
from haverify.syntax.parse import parse
from haverify.text.record import replace
from haverify.text.source import Source

SPEC = Path(__file__).parents[2] / "spec"
TEXT = (SPEC / "leg_ca.ha").read_text(encoding="utf-8")
RULES = (partial_rules, conflicting_rules)


@cache
def model() -> Spec:
    """The spec, without what is about the clock."""
    text = TEXT[: TEXT.index("/// The same walk on the clock")]
    source = Source.of_text("leg_ca.ha", text)
    tree, _ = parse(source)
    spec, found = elaborate(tree, Files({source.path: source}))
    assert spec is not None
    assert not any(map(is_error, found))
    return spec


def surprises(spec: Spec) -> Iterator[str]:
    """What makes `check` exit otherwise than 0: errors, and claims decided otherwise than expected."""
    for rule in RULES:
        yield from (d.code for d in rule(spec, Facts(spec, {})))
    for claim in spec.claims:
        assert claim.expect is not None
        verdict = decide_all(spec, [claim.name])[claim.name].verdict
        if WORDS[type(verdict)] != claim.expect.verdict:
            yield claim.name


WORDS = {Proved: "proved", Refuted: "refuted", Unknown: "unknown"}


def is_noticed(spec: Spec) -> bool:
    return next(surprises(spec), None) is not None


def with_rules(number: int, rules: tuple[Rule, ...]) -> Spec:
    """The spec with other rules in one of its automata."""
    automata = list(model().cellular)
    automata[number] = replace(automata[number], rules=rules)
    return replace(model(), cellular=tuple(automata))


def with_pairs(number: int, pairs: tuple[tuple[str, str], ...]) -> Spec:
    """The spec with other arrows in one of its relations."""
    relations = list(model().relations)
    relations[number] = replace(relations[number], pairs=pairs)
    return replace(model(), relations=tuple(relations))


def turned(bits: str) -> list[str]:
    """The bits with each of them turned, one after the other."""
    return [bits[:k] + ("1" if b == "0" else "0") + bits[k + 1 :] for k, b in enumerate(bits)]


def test_there_are_as_many_places_as_in_the_source() -> None:
    assert [len(a.rules) for a in model().cellular] == [16, 16]
    assert [len(r.pairs) for r in model().relations] == [7, 8]
    assert all(len(r.left) == len(r.right) == 4 for a in model().cellular for r in a.rules)


def test_the_tables_themselves_have_no_surprise() -> None:
    assert list(surprises(model())) == []


@pytest.mark.parametrize("number", [0, 1])
@pytest.mark.parametrize("k", range(16))
def test_a_rule_gone_or_a_bit_of_it_turned(number: int, k: int) -> None:
    rules = model().cellular[number].rules
    gone = with_rules(number, rules[:k] + rules[k + 1 :])
    assert len(list(surprises(gone))) > 1
    changed = [replace(rules[k], left=b) for b in turned(rules[k].left)]
    changed += [replace(rules[k], right=b) for b in turned(rules[k].right)]
    missed = [r for r in changed if not is_noticed(with_rules(number, (*rules[:k], r, *rules[k + 1 :])))]
    assert missed == []


@pytest.mark.parametrize(("number", "k"), [(n, k) for n, count in ((0, 7), (1, 8)) for k in range(count)])
def test_an_arrow_gone_or_leading_elsewhere(number: int, k: int) -> None:
    pairs = model().relations[number].pairs
    others = sorted({b for _, b in pairs} - {pairs[k][1]})
    changed = [pairs[:k] + pairs[k + 1 :], *((*pairs[:k], (pairs[k][0], b), *pairs[k + 1 :]) for b in others)]
    assert [p[k : k + 1] for p in changed if not is_noticed(with_pairs(number, p))] == []


@pytest.mark.parametrize(
    ("old", "new"), [("  rule 0b0110 -> 0b1010\n", ""), ("rule 0b0110 -> 0b1010", "rule 0b0110 -> 0b1011")]
)
def test_check_fails_for_such_a_slip(old: str, new: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("HAVERIFY_CACHE", str(tmp_path / "cache"))
    text = TEXT[: TEXT.index("/// The same walk on the clock")]
    assert old in text
    Path("leg_ca.ha").write_text(text.replace(old, new), encoding="utf-8")
    assert main(["check", "leg_ca.ha", "--report", "out"]) == 1


def test_the_clock_keeps_the_times_of_the_gait() -> None:
    """The slots of `gait.ha` end where the phases of this spec do."""
    gait = (SPEC / "gait.ha").read_text(encoding="utf-8")
    slots = re.findall(r"^    (\w+) until ([\d.]+) s", gait, re.MULTILINE)
    (start,) = re.findall(r"^const start: s = ([\d.]+) s$", gait, re.MULTILINE)
    own = re.findall(r"^const (\w+): s = ([\d.]+) s$", TEXT, re.MULTILINE)
    names = {"LR": "lr", "MST": "ms", "TS": "tst", "PS": "psw", "IS": "isw", "MSW": "msw", "TSW": "tsw"}
    assert [("begin", Fraction(start)), *((names[n], Fraction(t)) for n, t in slots)] == [
        (n, Fraction(t)) for n, t in own
    ]
