"""Every code that this version can report has a page with a bad example that yields it and a good one that does not."""

import re
from functools import cache
from pathlib import Path

import pytest

import haverify
from haverify.diagnostics.codes import CATALOGUE, is_meaningless, page, pages, severity
from haverify.diagnostics.diagnostic import Diagnostic, Severity
from haverify.elaborate.elaborate import elaborate
from haverify.elaborate.files import Files
from haverify.lint._registry import rules, run_lint
from haverify.syntax.parse import parse
from haverify.text.source import Source

PACKAGE = Path(haverify.__file__).parent


def examples(code: str) -> list[str]:
    """The `.ha` blocks of a page: the bad one first."""
    return re.findall(r"```ha\n(.*?)```", page(code), re.DOTALL)


@cache
def codes_found(text: str) -> frozenset[str]:
    """The codes that reading and linting a text yields."""
    source = Source.of_text("example.ha", text)
    tree, found = parse(source)
    spec, more = elaborate(tree, Files({source.path: source}))
    found = [*found, *more]
    if spec is not None and not any(is_meaningless(d) for d in found):
        found += run_lint(spec, {source.path: source})
    return frozenset(d.code for d in found)


def with_examples() -> list[str]:
    """The codes whose pages show specs; others need files or an engine and are tested where they arise."""
    return [code for code in pages() if examples(code)]


def reported() -> set[str]:
    """The codes that the source names outside the catalogue."""
    files = (p for p in PACKAGE.rglob("*.py") if p.name != "codes.py")
    return {code for p in files for code in re.findall(r'"(HA\d{3})"', p.read_text(encoding="utf-8"))}


def test_there_are_86_codes():
    assert len(CATALOGUE) == 86
    assert all(re.fullmatch(r"HA\d{3}", code) for code in CATALOGUE)


def test_errors_without_meaning_are_those_that_say_so():
    without = {"HA210", "HA211", "HA224", "HA504", "HA601", "HA608"}
    for code, entry in CATALOGUE.items():
        is_error = entry.severity is Severity.ERROR
        assert entry.is_meaningless == (is_error and (code[2] in "01" or code in without)), code


def test_a_finding_may_carry_its_own_severity():
    assert severity(Diagnostic("HA204", "m")) is Severity.WARNING
    assert severity(Diagnostic("HA204", "m", severity=Severity.ERROR)) is Severity.ERROR


def test_every_code_that_is_reported_has_a_page():
    assert reported() - set(pages()) == set()


def test_every_page_is_of_a_code_that_is_reported():
    assert set(pages()) - reported() == set()


def test_every_rule_has_a_test_of_its_own():
    texts = "".join(p.read_text(encoding="utf-8") for p in (Path(__file__).parent / "unit" / "lint").glob("test_*.py"))
    assert [code for code in rules() if code not in texts] == []


@pytest.mark.parametrize("code", pages())
def test_the_page_names_the_code_and_what_it_means(code):
    first, _, rest = page(code).partition("\n")
    assert first == f"# {code}: {CATALOGUE[code].name}"
    assert len(rest.split()) > 15


@pytest.mark.parametrize("code", with_examples())
def test_the_bad_example_yields_the_code_and_the_good_one_does_not(code):
    bad, good = examples(code)
    assert code in codes_found(bad)
    assert code not in codes_found(good)


@pytest.mark.parametrize("code", with_examples())
def test_the_good_example_has_no_error(code):
    assert {c for c in codes_found(examples(code)[1]) if CATALOGUE[c].severity is Severity.ERROR} == set()


def test_an_unknown_code_has_no_page():
    with pytest.raises(KeyError):
        page("HA999")
