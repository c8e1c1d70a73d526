"""`report.sarif`: fits the published schema, says what GitHub and editors need, hides nothing."""

import json

from tests.unit.report.facts import HOSTILE, LABEL, claim, finding, hostile, whole, wrong
from tests.unit.report.valid import valid_sarif

from haverify.report.as_sarif import as_sarif, findings_as_sarif


def test_a_finding_has_its_rule_level_region_and_fingerprint() -> None:
    run = valid_sarif(as_sarif([whole(claim(), findings=[finding()])]))
    (result,) = run["results"]
    assert (result["ruleId"], result["level"], result["ruleIndex"]) == ("HA303", "error", 0)
    (place,) = result["locations"]
    assert place["physicalLocation"] == {
        "artifactLocation": {"uri": "spec/a%20b.ha"},
        "region": {"startLine": 3, "startColumn": 5, "endLine": 3, "endColumn": 9},
    }
    assert result["partialFingerprints"] == {"haverify/v1": "00ff"}
    assert run["columnKind"] == "unicodeCodePoints"


def test_a_rule_has_the_manual_page_as_help() -> None:
    run = valid_sarif(as_sarif([whole(claim(), findings=[finding(), finding(code="HA201")])]))
    rules = run["tool"]["driver"]["rules"]
    assert [r["id"] for r in rules] == ["HA201", "HA303"]
    assert rules[1]["help"]["markdown"].startswith("# HA303")
    assert rules[1]["fullDescription"]["text"].startswith("The flow carries")
    assert rules[1]["defaultConfiguration"] == {"level": "error"}


def test_accepted_findings_are_suppressed_with_their_reason() -> None:
    found = [finding(accepted="known", accepted_in="lock"), finding(accepted="meant", accepted_in="source")]
    results = valid_sarif(as_sarif([whole(claim(), findings=found)]))["results"]
    assert [r["suppressions"] for r in results] == [
        [{"kind": "external", "status": "accepted", "justification": "known"}],
        [{"kind": "inSource", "status": "accepted", "justification": "meant"}],
    ]


def test_a_fix_is_replacements_and_labels_are_related_places() -> None:
    found = finding(labels=[LABEL], edits=[LABEL], fix="write it so")
    (result,) = valid_sarif(as_sarif([whole(claim(), findings=[found])]))["results"]
    (change,) = result["fixes"][0]["artifactChanges"]
    assert change["replacements"][0]["insertedContent"] == {"text": "said here"}
    assert change["replacements"][0]["deletedRegion"]["startColumn"] == 5
    assert result["relatedLocations"][0]["message"] == {"text": "said here"}


def test_a_claim_that_is_undecided_against_expectation_is_an_error() -> None:
    run = valid_sarif(as_sarif([whole(wrong(verdict="unknown"), claim("fine"))]))
    (result,) = run["results"]
    assert (result["ruleId"], result["level"]) == ("unknown", "error")
    assert result["message"]["text"] == "low: unknown, expected proved: stopped"
    assert run["invocations"][0]["exitCode"] == 3


def test_a_claim_of_which_a_finding_tells_is_told_once() -> None:
    problem = finding(code="HA701", message="low: expected proved, got refuted")
    results = valid_sarif(as_sarif([whole(wrong(), findings=[problem])]))["results"]
    assert [r["ruleId"] for r in results] == ["HA701"]


def test_what_explains_an_expected_verdict_is_a_note_and_any_other_an_error() -> None:
    why = [finding(code="HA702", severity="verdict", message=f"{n}: stopped") for n in ("low", "high")]
    run = valid_sarif(as_sarif([whole(claim("low", "unknown"), wrong("high", "unknown"), findings=why)]))
    assert [r["level"] for r in run["results"]] == ["note", "error"]


def test_hostile_texts_stay_texts() -> None:
    run = valid_sarif(as_sarif([hostile()]))
    assert run["results"][0]["message"]["text"].startswith(HOSTILE)


def test_several_specs_are_one_run_and_what_was_not_read_is_told() -> None:
    run = valid_sarif(as_sarif([whole(claim()), whole(claim("other"))], [("gone.ha", "cannot read gone.ha")]))
    (invocation,) = run["invocations"]
    assert invocation["executionSuccessful"] is False
    assert invocation["exitCode"] == 2
    assert invocation["toolExecutionNotifications"][0]["message"] == {"text": "cannot read gone.ha"}


def test_findings_alone_make_a_log() -> None:
    run = valid_sarif(findings_as_sarif([finding()], 1, [("b", "m")]))
    assert len(run["results"]) == 1


def test_a_path_that_is_no_text_does_not_stop_it() -> None:
    text = as_sarif([whole(claim(), findings=[finding(path="a\udce9.ha")])])
    assert json.loads(text)["runs"][0]["artifacts"]
    assert "a%E9.ha" in text
