"""`junit.xml`: fits its schema, and no reader of it alone takes a failure for a success."""

from tests.unit.report.facts import HOSTILE, claim, finding, hostile, whole, wrong
from tests.unit.report.valid import valid_junit

from haverify.report.as_junit import as_junit, findings_as_junit


def test_a_claim_is_a_test_case() -> None:
    (suite,) = valid_junit(as_junit([whole(claim(), claim("known", "refuted"))]))
    assert (suite.get("tests"), suite.get("failures"), suite.get("errors"), suite.get("skipped")) == (
        "2",
        "0",
        "0",
        "0",
    )
    assert [c.get("name") for c in suite.iter("testcase")] == ["low", "known"]


def test_unknown_is_a_failure_of_its_own_type() -> None:
    root = valid_junit(as_junit([whole(wrong(verdict="unknown"))]))
    (failure,) = root.iter("failure")
    assert (failure.get("type"), failure.get("message")) == ("unknown", "stopped")
    assert not list(root.iter("skipped"))


def test_unknown_as_expected_is_passed() -> None:
    assert not list(valid_junit(as_junit([whole(claim(verdict="unknown"))])).iter("failure"))


def test_a_verdict_other_than_expected_is_a_failure_with_the_details() -> None:
    (failure,) = valid_junit(as_junit([whole(wrong())])).iter("failure")
    assert failure.get("type") == "refuted"
    assert "violated in M, y: y in mode M" in (failure.text or "")


def test_new_error_findings_fail_a_case_of_their_own() -> None:
    root = valid_junit(as_junit([whole(claim(), findings=[finding(), finding(accepted="known")])]))
    (failure,) = root.iter("failure")
    assert failure.get("message") == "1 new error finding: HA303"
    assert (failure.text or "").startswith("spec/a b.ha:3:5: error[HA303]")


def test_an_exit_code_that_no_claim_explains_is_an_error() -> None:
    root = valid_junit(as_junit([whole()]))
    (error,) = root.iter("error")
    assert error.get("message") == "nothing was checked"


def test_a_file_that_could_not_be_read_is_an_error() -> None:
    (error,) = valid_junit(as_junit([], [("gone.ha", "cannot read it")])).iter("error")
    assert error.get("type") == "unreadable"


def test_hostile_texts_stay_texts() -> None:
    root = valid_junit(as_junit([hostile()]))
    first = next(root.iter("testcase"))
    shown = HOSTILE.replace("\x00", "\ufffd").replace("\x1b", "\ufffd").replace("\u202e", "\ufffd")
    assert first.get("name") == " ".join(shown.split("\n\t")).replace("tail", " tail")


def test_lint_has_a_case_for_each_spec() -> None:
    root = valid_junit(findings_as_junit([("a.ha", [finding(severity="warning")]), ("b.ha", [finding()])]))
    assert [(s.get("name"), s.get("failures")) for s in root] == [("a.ha", "0"), ("b.ha", "1")]
