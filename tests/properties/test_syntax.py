"""Whatever the text: reading it ends, and formatting it changes nothing but its layout."""

from __future__ import annotations

import re

from hypothesis import given, settings
from hypothesis import strategies as st
from tests.trees import SAMPLES, bare, comments

from haverify.syntax.format import format  # noqa: A004
from haverify.syntax.language import language
from haverify.syntax.parse import parse
from haverify.syntax.tree import Tree
from haverify.text.source import Source

LAWS = settings(max_examples=100, deadline=None, derandomize=True)
WORDS = sorted(language().words)
SOUP = [
    *WORDS,
    *sorted(language().symbols),
    "x",
    "y",
    "A",
    "1",
    "2.5",
    "3 m/s",
    "0b01",
    '"s"',
    '"',
    "/// d\n",
    "// c\n",
]
SOUP += ["\n", "\n", ";", "é", "≤", "\t", "\r\n", "@", "&"]
PIECES = re.compile(r"//[^\n]*|\w+|\s+|.", re.DOTALL)
samples = st.sampled_from(sorted(SAMPLES)).map(lambda name: SAMPLES[name])


def read(text: str) -> Tree:
    """Read a text; all places of the findings lie in it, and the tree is formatted when there are none."""
    source = Source.of_text("a.ha", text)
    tree, findings = parse(source)
    for finding in findings:
        assert finding.span is not None
        assert 0 <= finding.span.start <= finding.span.end <= len(text)
        assert finding.code in ("HA001", "HA003")
    assert len(findings) <= 20
    if not findings:
        _check_layout(source, tree)
    return tree


def _check_layout(source: Source, tree: Tree) -> None:
    once = Source.of_text("a.ha", format(tree, source))
    again, findings = parse(once)
    assert findings == []
    assert bare(again.items) == bare(tree.items)
    assert comments(again) == comments(tree)
    assert format(again, once) == once.text


@LAWS
@given(st.lists(st.sampled_from(SOUP), max_size=60))
def test_any_soup_of_words_is_read(words: list[str]) -> None:
    read(" ".join(words))


@LAWS
@given(
    st.lists(st.sampled_from(SOUP), max_size=30),
    st.sampled_from(["automaton A {", "mode M {", "property p {", "assume"]),
)
def test_any_soup_of_words_in_a_block_is_read(words: list[str], opening: str) -> None:
    read('spec "x" version "1.0"\n' + opening + " ".join(words) + "\n}\nconst last = 1\n")


@LAWS
@given(st.binary(max_size=200))
def test_any_bytes_are_read(data: bytes) -> None:
    read(data.decode("utf-8", errors="replace"))


@LAWS
@given(samples, st.floats(0, 1))
def test_any_truncation_is_read(text: str, part: float) -> None:
    read(text[: int(part * len(text))])


@LAWS
@given(
    samples, st.lists(st.tuples(st.floats(0, 1, exclude_max=True), st.sampled_from(SOUP), st.booleans()), max_size=4)
)
def test_any_mutation_is_read(text: str, changes: list[tuple[float, str, bool]]) -> None:
    pieces = PIECES.findall(text)
    for place, word, replaced in changes:
        at = int(place * len(pieces))
        pieces[at : at + replaced] = [f" {word} "]
    read("".join(pieces))


@LAWS
@given(
    samples,
    st.lists(st.tuples(st.floats(0, 1, exclude_max=True), st.sampled_from(["// c\n", "\n", "\n\n", " "])), max_size=8),
)
def test_comments_and_blanks_anywhere_are_kept_or_refused(text: str, additions: list[tuple[float, str]]) -> None:
    pieces = PIECES.findall(text)
    for place, addition in additions:
        pieces.insert(int(place * len(pieces)), addition)
    read("".join(pieces))


@LAWS
@given(samples, st.floats(0, 1, exclude_max=True))
def test_one_error_leaves_the_other_declarations(text: str, place: float) -> None:
    """A line of nonsense between two declarations costs nothing else."""
    starts = [item.span.start for item in read(text).items] + [len(text)]
    at = starts[int(place * len(starts))]
    tree, findings = parse(Source.of_text("a.ha", text[:at] + "\n) nonsense\n" + text[at:]))
    assert [finding.message for finding in findings] == ["')' closes nothing"]
    assert len(tree.items) == len(starts) - 1
