"""`report.json` is laid out as `json.dumps` does it, from records as if they were dictionaries."""

import dataclasses
import json

from hypothesis import given, settings
from hypothesis import strategies as st

from haverify.report.as_json import _laid_out, as_json, as_line, findings_as_json
from haverify.report.report import Finding, InputFile, Report, Summary, Tool

FINDING = Finding("HA1", "n", "error", 'ü "x"\n\x00', "a.ha", 1, 2, None, None, ["a", "b"], None, None, "why")
REPORT = Report(
    schema="s",
    spec="a.ha",
    title="t",
    tool=Tool("haverify", "1", "2", {}),
    inputs=[InputFile("a.ha", "0")],
    options={"b": "1", "a": "2"},
    hash="h",
    complete=True,
    wall_s=0.1,
    cpu_s=1.0,
    findings=[FINDING],
    claims=[],
    summary=Summary(1, 0, 0, 1, 0, 0, 0, 0),
)

VALUES = st.recursive(
    st.none() | st.booleans() | st.integers() | st.floats(allow_nan=False) | st.text(),
    lambda inner: st.lists(inner) | st.dictionaries(st.text(), inner),
)


@settings(derandomize=True, max_examples=100, deadline=None)
@given(VALUES)
def test_any_value_is_laid_out_as_the_standard_library_does(value: object) -> None:
    assert _laid_out(value, "\n") == json.dumps(value, indent=1, sort_keys=True, ensure_ascii=False)


def test_a_report_is_its_fields() -> None:
    fields = dataclasses.asdict(REPORT)  # type: ignore[call-overload]
    assert as_json(REPORT) == json.dumps(fields, indent=1, sort_keys=True, ensure_ascii=False) + "\n"
    assert json.loads(as_line(REPORT)) == fields
    assert as_line(REPORT).count("\n") == 1


def test_findings_are_a_list() -> None:
    assert json.loads(findings_as_json([FINDING, FINDING])) == [dataclasses.asdict(FINDING)] * 2  # type: ignore[call-overload]
    assert findings_as_json([]) == "[]\n"
