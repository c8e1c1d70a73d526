"""`index.html`: complete, closed in itself, safe with any text, never large."""

import re
from html.parser import HTMLParser

import pytest
from tests.unit.report.facts import HOSTILE, claim, finding, hostile, part, whole, wrong

from haverify.report.as_html import as_html, quoted
from haverify.report.figures.material import Material
from haverify.report.html.prose import prose
from haverify.report.report import Report, Run

EMPTY = Material()
_VOID = {"meta"}


class Page(HTMLParser):
    """The tags, attributes and text of a page; a tag that closes another one is an error."""

    def __init__(self, text: str) -> None:
        super().__init__()
        self.tags: list[str] = []
        self.attributes: list[tuple[str, str]] = []
        self.text = ""
        self._open: list[str] = []
        self.feed(text)
        self.close()
        assert not self._open

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        self.tags.append(tag)
        self.attributes += [(name, value or "") for name, value in attrs]
        if tag not in _VOID:
            self._open.append(tag)

    def handle_startendtag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        self.tags.append(tag)
        self.attributes += [(name, value or "") for name, value in attrs]

    def handle_endtag(self, tag: str) -> None:
        assert self._open.pop() == tag

    def handle_data(self, data: str) -> None:
        self.text += data


def page(r: Report) -> Page:
    return Page(as_html(r, EMPTY))


def test_the_head_says_what_came_out() -> None:
    text = page(whole(claim(), wrong("high"))).text
    assert "1 of 2 claims is not as expected" in text
    assert "exit code 1: a claim is decided otherwise" in text
    assert "All 1 claims are as expected" in page(whole(claim())).text


def test_what_is_not_as_expected_stands_first_in_the_table() -> None:
    text = page(whole(claim("fine"), wrong("bad"))).text
    assert text.index("bad") < text.index("fine")


def test_a_claim_is_told_in_full() -> None:
    c = claim(doc="Why **this**.", assumptions=["x > 0"], using=["energy"], horizon="10 s", notes=["a note"])
    text = page(whole(c)).text
    for said in ("Why this.", "always y <= 3 deg", "x > 0", "energy", "10 s", "a note", "1 deg", "x = 1 s"):
        assert said in text
    assert "haverify check 'spec/a b.ha' -p low" in text


def test_findings_have_their_source_with_carets() -> None:
    text = page(whole(claim(), findings=[finding(), finding(accepted="known since May")])).text
    assert " 3 | mode M\n   | ^^^^" in text
    assert "known since May" in text


def test_what_is_wrong_with_a_claim_stands_with_the_claim() -> None:
    problem = finding(code="HA701", message="low: expected proved, got refuted", excerpt=["the expect line"])
    text = page(whole(wrong(), findings=[problem])).text
    assert "the expect line" not in text
    assert text.count("expected proved, got refuted") == 2


def test_an_interrupted_run_says_so() -> None:
    assert "Incomplete" in page(whole(claim(), complete=False)).text


def test_a_report_without_claims_has_a_page() -> None:
    assert "No claim was decided" in page(whole()).text


def test_nothing_is_executed_or_fetched() -> None:
    p = page(hostile())
    assert not {"script", "link", "iframe", "object", "img", "base", "form"} & set(p.tags)
    assert not [name for name, _ in p.attributes if name.startswith("on")]
    addresses = [value for name, value in p.attributes if name in ("href", "src", "action")]
    assert addresses
    assert all(a.startswith(("#", "./")) for a in addresses)
    assert "http" not in as_html(hostile(), EMPTY).replace('xmlns="http://www.w3.org/2000/svg"', "")
    assert "url(" not in as_html(whole(claim()), EMPTY)


def test_hostile_texts_are_shown_as_they_are() -> None:
    p = page(hostile())
    assert "<script>alert(1)</script>" in p.text
    assert not set("\x00\x1b\u202e") & set(as_html(hostile(), EMPTY))
    assert HOSTILE.startswith("<script>")


def test_ten_thousand_parts_stay_under_a_megabyte_and_say_so() -> None:
    parts = [part("proved", mode=f"mode {k}", text="t" * 300) for k in range(9_999)] + [part("refuted", mode="bad one")]
    text = as_html(whole(claim(parts=parts)), EMPTY)
    assert len(text.encode()) < 1_000_000
    assert "9952 more parts are in report.json, all questions in obligations/low.txt." in text
    assert "bad one" in text


def test_thousands_of_claims_and_findings_stay_under_a_megabyte() -> None:
    claims = [claim(f"c{k}", doc="d" * 20_000, text="t" * 20_000) for k in range(1_000)]
    r = whole(*claims, wrong("last"), findings=[finding(message="m" * 5_000, excerpt=["e" * 5_000] * 90)] * 5_000)
    text = as_html(r, EMPTY)
    assert len(text.encode()) < 1_000_000
    assert re.search(r"\d+ claims are left out", text)
    assert 'id="claim-1001"' in text
    assert "4940 more findings are in report.json" in text


def test_times_stand_where_they_can_be_left_out() -> None:
    def without_times(r: Report) -> str:
        return re.sub(r'<(td|b) class="time">[^<]*', "", as_html(r, EMPTY))

    slow = whole(claim(wall_s=9.0, cpu_s=8.0), wall_s=99.0, cpu_s=98.0)
    assert without_times(slow) == without_times(whole(claim()))


@pytest.mark.parametrize(
    ("text", "html"),
    [
        ("a *b* **c** `d*e*`", "<p>a <em>b</em> <strong>c</strong> <code>d*e*</code></p>"),
        ("one\ntwo\n\nthree", "<p>one two</p><p>three</p>"),
        ("see:\n- a\n  b\n- c", "<p>see:</p><ul><li>a b</li><li>c</li></ul>"),
        ("```\nx < 1\n```\nafter", "<pre>x &lt; 1</pre><p>after</p>"),
        ("```\nnever closed", "<pre>never closed</pre>"),
        ("<b>x</b> [y](http://z)", "<p>&lt;b&gt;x&lt;/b&gt; [y](http://z)</p>"),
        ("2 * 3 * 4", "<p>2 * 3 * 4</p>"),
        ("", ""),
    ],
)
def test_doc_comments_are_a_safe_subset_of_markdown(text: str, html: str) -> None:
    assert prose(text) == html


@pytest.mark.parametrize(
    ("word", "shown"), [("low", "low"), ("a b", "'a b'"), ("it's", "'it'\\''s'"), ("-p", "'-p'"), ("", "''")]
)
def test_words_of_commands_can_be_pasted(word: str, shown: str) -> None:
    assert quoted(word) == shown


def test_a_run_of_a_system_tells_what_moves() -> None:
    run = Run(
        ["p.Idle, q.Idle", "p.Busy, q.Idle"], ["go"], ["0", "1", "2"], ["0", "1", "2"],
        [{"n": "0"}] * 3, [{"n": "0"}] * 3, {}, {}, None,
    )  # fmt: skip
    text = page(whole(claim(run=run))).text
    assert "go: p.Busy" in text
    assert "A run that shows it" in text


def test_only_findings_can_fail_a_page() -> None:
    assert "All 1 claims are as expected; 1 error finding is new" in page(whole(claim(), findings=[finding()])).text
