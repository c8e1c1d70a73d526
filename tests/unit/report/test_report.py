"""The views of a report: JSON that fits its schema, one screen of Markdown, a terminal summary."""

import json
from fractions import Fraction
from pathlib import Path

import msgspec
import pytest
from tests.unit.report.facts import hostile

from haverify.diagnostics.diagnostic import Diagnostic
from haverify.evidence.verdict import Margin
from haverify.maths.digits import rational_text
from haverify.report import report
from haverify.report.as_github import findings_as_github as github
from haverify.report.as_json import as_json
from haverify.report.as_markdown import as_markdown
from haverify.report.findings import finding
from haverify.report.numbers import decimal, margin
from haverify.report.schema import text as schema_text
from haverify.report.terminal import closing, summary
from haverify.report.unrecorded import note
from haverify.text.source import Source
from haverify.text.span import Span

ROOT = Path(__file__).parents[3]


def example_claim(**changes: object) -> report.Claim:
    bad = report.Part(
        mode="PS",
        output="lk",
        kind="dwell",
        goal=1,
        text="lk < 3.2090 deg",
        verdict="refuted",
        margin=report.Margin("-5/2", "-2.5", "deg", "x = 1 s"),
        facts=["lk reaches 25292.2 deg at x = 1.1167 s"],
        cells=["coeffs/left_knee.csv:5 (PS)"],
        reason=None,
        sensitivities=[],
    )
    values = {
        "name": "knee_range", "automaton": "Gait", "text": "always lk < 3.2090 deg", "path": "gait.ha", "line": 7,
        "doc": "",
        "verdict": "refuted", "expected": "proved", "because": None, "ok": False, "trust": "checked",
        "parts": [bad], "rounding": None,
        "method": "poly-range", "margin": bad.margin, "horizon": None, "assumptions": [], "using": [],
        "certificate": "certificates/knee_range.json", "run": None, "witness": None,
        "kind": None, "reason": None, "reached": None, "nearest": None, "next_step": None,
        "problems": ["expected proved, got refuted"], "notes": [],
        "wall_s": 0.0, "cpu_s": 0.0,
    }  # fmt: skip
    return report.Claim(**{**values, **changes})  # type: ignore[arg-type]


def example(*claims: report.Claim) -> report.Report:
    verdicts = [c.verdict for c in claims]
    counts = report.Summary(
        verdicts.count("proved"),
        verdicts.count("refuted"),
        verdicts.count("unknown"),
        sum(c.ok for c in claims),
        1,
        0,
        0,
        1,
    )
    return report.Report(
        schema="haverify.report/1", spec="gait.ha", title="Gait", tool=report.Tool("haverify", "0", "k", {}),
        inputs=[report.InputFile("gait.ha", "00")], options={}, hash="h", complete=True, wall_s=0.1, cpu_s=0.1,
        findings=[finding(Diagnostic("HA701", "m"), {})], claims=list(claims), summary=counts,
    )  # fmt: skip


def test_the_report_reads_back_as_what_it_was() -> None:
    whole = example(example_claim())
    assert msgspec.json.decode(as_json(whole).encode(), type=report.Report) == whole


def test_a_report_of_another_shape_does_not_read() -> None:
    damaged = json.loads(as_json(example(example_claim())))
    damaged["claims"][0]["verdict"] = "probably"
    with pytest.raises(msgspec.ValidationError):
        msgspec.convert(damaged, report.Report)


def test_the_committed_schema_is_the_one_of_the_code() -> None:
    assert (ROOT / "docs" / "report.schema.json").read_text(encoding="utf-8") == schema_text()


def test_the_terminal_names_mode_output_extreme_and_table_row() -> None:
    text = summary(example(example_claim()))
    assert "!! refuted  knee_range  expected proved; margin -2.5 deg at x = 1 s" in text
    assert "violated in PS, lk: lk < 3.2090 deg" in text
    assert "lk reaches 25292.2 deg at x = 1.1167 s" in text
    assert "reads coeffs/left_knee.csv:5 (PS)" in text


def test_the_terminal_says_why_a_claim_is_unknown_and_what_to_try() -> None:
    facts = {"reason": "stopped after 60 s", "reached": "3.4 s", "next_step": "--budget 5min", "kind": "budget"}
    text = summary(example(example_claim(verdict="unknown", parts=[], margin=None, trust=None, problems=[], **facts)))
    assert "why: stopped after 60 s" in text
    assert "try: --budget 5min" in text


def test_what_is_proved_as_expected_takes_one_line() -> None:
    text = summary(example(example_claim(verdict="proved", ok=True, parts=[], problems=[])))
    assert text.count("knee_range") == 1


def test_the_notes_of_a_proved_claim_are_shown_where_it_is_asked_for_alone() -> None:
    known = {"verdict": "proved", "ok": True, "parts": [], "problems": [], "notes": ["period 6.66"]}
    assert "  note: period 6.66" in summary(example(example_claim(**known)))
    assert "period" not in summary(example(example_claim(**known), example_claim(name="other", **known)))


def test_what_is_refuted_as_expected_names_each_part_in_two_lines() -> None:
    text = summary(example(example_claim(expected="refuted", ok=True, because="as printed", problems=[])))
    _, _, details, _ = text.split("\n\n")
    assert details.splitlines() == [
        'knee_range (gait.ha:7): refuted as expected because "as printed"',
        "  PS, lk: lk reaches 25292.2 deg at x = 1.1167 s",
        "      reads coeffs/left_knee.csv:5 (PS)",
    ]


@pytest.mark.parametrize(
    ("verdict", "words"),
    [("proved", "holds within rounding"), ("refuted", "refuted for every rounding"), ("unknown", "rounding: unknown")],
)
def test_the_line_of_a_claim_says_what_rounding_does_to_it(verdict: report.Word, words: str) -> None:
    claim = example_claim(verdict="proved", ok=True, rounding=report.Rounding(verdict, None))
    assert words in summary(example(claim)).splitlines()[2]
    assert "rounding" not in summary(example(example_claim()))


def test_every_number_of_a_run_has_its_unit() -> None:
    run = report.Run(
        mode_path=["Stance", "Swing"], edges=["lift"], times=["0", "1/2", "3/4"], times_decimal=["0", "0.5", "0.75"],
        states=[{"x": "0", "n": "1"}] * 3, states_decimal=[{"x": "0", "n": "1"}] * 3, params={"speed": "5/4"},
        units={"x": "s", "speed": "m/s"}, violation=None,
    )  # fmt: skip
    text = summary(example(example_claim(run=run)))
    assert "a run that violates it, for speed = 1.25 m/s:" in text
    assert "t = 0.5 s: Swing with x = 0 s, n = 1\n" in text
    assert "violated at t = 0.75 s" in text


def test_missing_entries_of_the_lock_file_are_summed_up_once() -> None:
    known = {"expected": "refuted", "ok": True, "notes": [note("[[refuted]]\n")]}
    text = summary(example(example_claim(**known), example_claim(name="other", **known)))
    assert text.count("haverify accept gait.ha --reason") == 1
    assert "[[refuted]]" not in text


def test_the_last_line_names_the_claims_that_haverify_failed_at() -> None:
    assert closing(4, [], ["knee_range"]).endswith("please report it (about knee_range)\n")


def test_the_last_line_says_what_the_exit_code_means() -> None:
    assert closing(3, ["reports/gait/report.json"]) == (
        "report: reports/gait/report.json\nexit code 3: a claim that was to be decided is unknown\n"
    )


def test_markdown_keeps_to_a_screen_and_puts_problems_first() -> None:
    fine = [example_claim(name=f"c{k}", verdict="proved", ok=True) for k in range(100)]
    text = as_markdown(example(*fine, example_claim(name="a|b")))
    rows = [line for line in text.splitlines() if line.startswith("| ")]
    assert len(text.splitlines()) < 48
    assert rows[1].startswith("| a\\|b | **refuted** |")
    assert "... and 71 more" in text


def test_markdown_shows_hostile_texts_as_texts() -> None:
    text = as_markdown(hostile())
    assert "<script" not in text
    assert not set("\x00\x1b\u202e") & set(text)


def test_github_commands_escape_what_would_end_them() -> None:
    source = Source.of_text("a,b.ha", "xy\n")
    found = finding(Diagnostic("HA303", "100 %\nover", Span("a,b.ha", 0, 1)), {"a,b.ha": source})
    assert github([found]) == ("::error file=a%2Cb.ha,line=1,endLine=1,col=1,endColumn=2,title=HA303::100 %25%0Aover\n")


def test_github_leaves_out_what_is_accepted() -> None:
    assert github([finding(Diagnostic("HA303", "m"), {}, "because")]) == ""


def test_numbers_are_exact_strings_with_decimals_beside() -> None:
    assert rational_text(Fraction(-106594, 5)) == "-106594/5"
    assert decimal(Fraction(-106594, 5)) == "-21318.8"
    assert decimal(Fraction(1, 3)) == "0.333333"
    huge = Fraction(10) ** 9000 + 7
    assert rational_text(huge) == "1" + "0" * 8999 + "7"


def test_a_margin_at_a_root_is_an_interval() -> None:
    root = Margin(Fraction(4999, 10000), Fraction(5001, 10000), "deg")
    assert margin(root) == report.Margin(["4999/10000", "5001/10000"], "0.5", "deg", "")


def test_a_margin_that_is_known_roughly_is_told_as_what_it_is_at_least() -> None:
    near = margin(Margin(Fraction(12345678, 10**7), Fraction(12345680, 10**7), "rad", "t = 1 s"))
    rough = margin(Margin(Fraction(1, 1000), Fraction(5, 100), "rad", "t = 0 s"))
    assert near is not None and near.decimal == "1.2345679"
    assert rough is not None and rough.decimal == "0.001"
    assert rough.value == ["1/1000", "1/20"]
