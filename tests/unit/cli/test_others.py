"""The other commands."""

import os
from collections.abc import Callable
from pathlib import Path

import pytest
from tests.unit.cli.conftest import CLOCK, TRUE, Said

from haverify.diagnostics.codes import pages

Call = Callable[..., Said]
Write = Callable[[str, str], str]


def test_lint_says_the_same_of_a_spec_seen_before_and_anew(haverify: Call, write: Write) -> None:
    spec = write("m.ha", CLOCK.replace("when x >= 1 s", "when x > 1 s").replace("urgent ", "") + TRUE)
    first = haverify("lint", spec)
    assert first.code == 1
    assert haverify("lint", spec) == haverify("lint", spec, "--no-cache") == first


def test_lint_exit_codes(haverify: Call, write: Write) -> None:
    assert haverify("lint", write("m.ha", CLOCK + TRUE)).code == 0
    blocked = CLOCK.replace("when x >= 1 s", "when x > 1 s").replace("urgent ", "")
    assert haverify("lint", write("m.ha", blocked + TRUE)).code == 1
    assert haverify("lint", "m.ha", "--select", "HA1").code == 0
    assert haverify("lint", write("m.ha", "mode")).code == 2
    assert haverify("lint", "missing.ha").code == 2


def test_fmt_is_stable_and_leaves_broken_files(haverify: Call, write: Write, tmp_path: Path) -> None:
    path = write("m.ha", CLOCK.replace("  var", "      var") + TRUE)
    said = haverify("fmt", path, "--diff")
    assert (said.code, "-      var x" in said.out) == (1, True)
    assert haverify("fmt", path, "--check").code == 1
    assert haverify("fmt", path).code == 0
    assert haverify("fmt", path, "--check").code == 0
    broken = "automaton  Clock {\n"
    assert haverify("fmt", write("broken.ha", broken)).code == 2
    assert (tmp_path / "broken.ha").read_text() == broken


def test_explain(haverify: Call) -> None:
    code = pages()[0]
    assert code in haverify("explain", code.lower()).out
    assert "Bernstein" in haverify("explain", "poly-range").out
    said = haverify("explain", "HA3033")
    assert (said.code, "did you mean" in said.err) == (2, True)


def test_init_makes_a_spec_that_checks(haverify: Call, tmp_path: Path) -> None:
    assert haverify("init").code == 0
    assert haverify("init").code == 2
    said = haverify("check", "model.ha")
    assert (said.code, "error" in said.out.split("exit code")[0]) == (0, False)
    assert haverify("fmt", "--check", "model.ha").code == 0


def test_recheck_tells_a_report_from_a_damaged_one(haverify: Call, write: Write, tmp_path: Path) -> None:
    haverify("check", write("m.ha", CLOCK + TRUE))
    assert haverify("recheck", "reports/m").code == 0
    report = tmp_path / "reports" / "m" / "report.json"
    report.write_text(report.read_text().replace('"verdict": "proved"', '"verdict": "refuted"'))
    assert haverify("recheck", "reports/m").code == 1
    assert haverify("recheck", "nowhere").code == 2


def test_recheck_notices_another_spec(haverify: Call, write: Write) -> None:
    haverify("check", write("m.ha", CLOCK + TRUE))
    write("m.ha", CLOCK.replace("3 deg *", "2 deg *") + TRUE)
    assert haverify("recheck", "reports/m").code == 1


def test_recheck_waits_for_no_pipe(haverify: Call, tmp_path: Path) -> None:
    (tmp_path / "reports").mkdir()
    os.mkfifo(tmp_path / "reports" / "report.json")
    assert haverify("recheck", "reports").code == 2


@pytest.mark.parametrize("arguments", [["--help"], ["check", "--help"], ["--version"]])
def test_help_is_no_error(haverify: Call, arguments: list[str]) -> None:
    assert haverify(*arguments).code == 0


def test_a_fault_of_ours_asks_for_a_report(haverify: Call, monkeypatch: pytest.MonkeyPatch) -> None:
    def fail(_: object) -> int:
        raise RuntimeError("unthinkable")

    monkeypatch.setattr("haverify.cli.doctor.run", fail)
    said = haverify("doctor")
    assert said.code == 4
    assert "internal error: RuntimeError: unthinkable" in said.err
    assert "report it" in said.err
    assert "Traceback" not in said.err
