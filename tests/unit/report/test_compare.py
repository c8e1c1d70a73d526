"""What changed between two reports, what of it is worse, and what explains it; reports that contradict themselves."""

from fractions import Fraction

import pytest
from tests.unit.report.facts import claim, finding, margin, part, whole, wrong

from haverify.report import report
from haverify.report.audit import contradictions, exit_code
from haverify.report.compare import Change, compare
from haverify.text.record import replace

FIVE = Fraction(5, 100)


def changes(old: report.Report, new: report.Report, most: Fraction | None = None) -> list[tuple[str, str, bool]]:
    return [(c.kind, c.text, c.is_worse) for c in compare(old, new, most) if c.kind != "cause"]


def only(old: report.Claim, new: report.Claim, most: Fraction | None = None) -> Change:
    (change,) = [c for c in compare(whole(old), whole(new), most) if c.kind != "cause"]
    return change


def test_the_same_report_has_no_changes() -> None:
    r = whole(claim(), claim("b", "refuted"), claim("c", "unknown"), findings=[finding()])
    assert compare(r, r, Fraction(0)) == []


@pytest.mark.parametrize(
    ("old", "new", "is_worse"),
    [
        ("proved", "refuted", True),
        ("proved", "unknown", True),
        ("refuted", "unknown", True),
        ("refuted", "proved", False),
        ("unknown", "proved", False),
        ("unknown", "refuted", False),
    ],
)
def test_a_verdict_lost_is_worse_even_where_it_is_expected(old: str, new: str, is_worse: bool) -> None:
    found = changes(whole(claim(verdict=old)), whole(claim(verdict=new)))
    assert ("verdict", f"{new}, was {old}", is_worse) in found
    assert ("text", f"expects {new}, expected {old}", False) in found


def test_a_claim_that_is_gone_is_worse_and_a_new_one_is_not() -> None:
    assert changes(whole(claim()), whole(claim("b"))) == [
        ("claim", "gone; it was proved", True),
        ("claim", "new: proved", False),
    ]


def test_weaker_trust_is_worse() -> None:
    assert only(claim(), claim(trust="solver")).is_worse
    assert not only(claim(trust="solver"), claim()).is_worse


def test_another_text_under_the_same_name_is_told() -> None:
    assert only(claim(), claim(text="always true")).text == "another text than before"
    assert changes(whole(claim(text="a  b")), whole(claim(text="a\n b"))) == []


@pytest.mark.parametrize(
    ("old", "new", "is_worse"),
    [
        ("100", "95", False),
        ("100", "94.999999999999999999", True),
        ("-100", "-105", False),
        ("-100", "-105.000000000000000001", True),
        ("0", "-0.000000001", True),
        ("100", "200", False),
        ("1", "-1", True),
        ("-1", "1", False),
    ],
)
def test_margins_are_compared_exactly_as_shares_of_the_old_one(old: str, new: str, is_worse: bool) -> None:
    change = only(claim(margin=margin(old)), claim(margin=margin(new)), FIVE)
    assert (change.kind, change.is_worse) == ("margin", is_worse)
    assert not only(claim(margin=margin(old)), claim(margin=margin(new))).is_worse


def test_enclosures_lose_what_is_certain() -> None:
    old, new = claim(margin=margin(["99", "101"])), claim(margin=margin(["93", "96"]))
    assert not only(old, new, FIVE).is_worse
    assert only(old, replace(new, margin=margin(["90", "93"])), FIVE).is_worse


@pytest.mark.parametrize("new", [None, margin("57", "rad"), margin("x"), margin("1/0"), margin(["2", "1"])])
def test_margins_that_cannot_be_compared_are_worse_where_a_loss_is_limited(new: report.Margin | None) -> None:
    assert only(claim(), claim(margin=new), FIVE).is_worse
    assert not only(claim(), claim(margin=new)).is_worse


def test_findings_are_told_by_fingerprint_not_by_line() -> None:
    old, new = whole(claim(), findings=[finding()]), whole(claim(), findings=[finding(line=8, message="moved")])
    assert changes(old, new) == []
    assert changes(whole(claim()), old) == [("finding", "new: mode M is stuck", True)]
    assert changes(old, whole(claim())) == [("finding", "gone: mode M is stuck", False)]


def test_a_warning_is_told_and_an_acceptance_lost_is_worse() -> None:
    warning = finding(severity="warning")
    assert changes(whole(claim()), whole(claim(), findings=[warning])) == [("finding", "new: mode M is stuck", False)]
    accepted = whole(claim(), findings=[finding(accepted="known")])
    assert changes(accepted, whole(claim(), findings=[finding()]))[0][1:] == (
        "no longer accepted: mode M is stuck",
        True,
    )


def causes(old: report.Report, new: report.Report) -> list[tuple[str, str]]:
    return [(c.name, c.text) for c in compare(old, new, None) if c.kind == "cause"]


def test_what_differs_between_the_runs_is_named() -> None:
    files = [report.InputFile("a.ha", "1"), report.InputFile("t.csv", "1")]
    other = [report.InputFile("a.ha", "2"), report.InputFile("u.csv", "1")]
    old = whole(claim(), inputs=files)
    new = whole(claim(), inputs=other, options={**old.options, "grade": "solver"}, tool=replace(old.tool, version="9"))
    assert causes(old, new) == [
        ("model", "a.ha changed"),
        ("data", "t.csv no longer read"),
        ("data", "u.csv new"),
        ("options", "grade is solver, was enclosed"),
        ("tool", "haverify 9, was 0.1.0"),
    ]


def test_a_change_that_nothing_explains_is_said_to_be_so() -> None:
    assert causes(whole(claim()), whole(claim(verdict="refuted")))[0][0] == "none"


@pytest.mark.parametrize(
    ("claims", "findings", "code"),
    [
        ([], [], 5),
        ([claim()], [], 0),
        ([claim(), wrong()], [], 1),
        ([claim(), wrong(verdict="unknown")], [], 3),
        ([wrong("a"), wrong("b", "unknown")], [], 1),
        ([claim()], [finding()], 1),
        ([claim()], [finding(code="HA101")], 2),
        ([claim()], [finding(code="HA999")], 2),
        ([claim()], [finding(accepted="known"), finding(severity="warning")], 0),
        ([], [finding()], 1),
    ],
)
def test_the_exit_code_comes_from_claims_and_findings(
    claims: list[report.Claim], findings: list[report.Finding], code: int
) -> None:
    r = whole(*claims, findings=findings)
    assert exit_code(replace(r, summary=replace(r.summary, exit_code=0))) == code


def test_an_honest_report_contradicts_itself_nowhere() -> None:
    r = whole(
        claim("a"),
        claim("b", "refuted"),
        wrong("c"),
        wrong("d", "unknown"),
        findings=[finding(), finding(accepted="x")],
    )
    assert contradictions(r) == []


EDITS = {
    "verdict": lambda r: replace(r, claims=[replace(r.claims[0], verdict="proved"), *r.claims[1:]]),
    "ok": lambda r: replace(r, claims=[replace(r.claims[0], ok=True), *r.claims[1:]]),
    "expected": lambda r: replace(r, claims=[replace(r.claims[0], expected="refuted", ok=True), *r.claims[1:]]),
    "all of a claim": lambda r: replace(r, claims=[replace(r.claims[0], verdict="proved", ok=True, problems=[])]),
    "dropped claim": lambda r: replace(r, claims=r.claims[1:]),
    "doubled claim": lambda r: replace(r, claims=[*r.claims, r.claims[1]]),
    "exit code": lambda r: replace(r, summary=replace(r.summary, exit_code=0)),
    "counts": lambda r: replace(r, summary=replace(r.summary, refuted=0, proved=2)),
    "ok count": lambda r: replace(r, summary=replace(r.summary, ok=2)),
    "errors": lambda r: replace(r, findings=[]),
    "accepted": lambda r: replace(r, findings=[replace(f, accepted="fine") for f in r.findings]),
    "trust": lambda r: replace(r, claims=[replace(c, trust=None) for c in r.claims]),
    "certificate": lambda r: replace(r, claims=[replace(c, certificate=None) for c in r.claims]),
    "margin": lambda r: replace(r, claims=[replace(c, margin=margin("much")) for c in r.claims]),
}


@pytest.mark.parametrize("edit", EDITS)
def test_a_report_edited_by_hand_contradicts_itself(edit: str) -> None:
    r = whole(wrong("bad"), claim("good"), findings=[finding()])
    assert contradictions(r) == []
    assert contradictions(EDITS[edit](r))


def test_a_fault_is_in_the_summary_alone() -> None:
    r = whole(claim(parts=[part()]))
    assert contradictions(replace(r, summary=replace(r.summary, exit_code=4))) == []
