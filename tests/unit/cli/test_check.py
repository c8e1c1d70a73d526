"""`haverify check`: every exit code, reports that are the same bytes, a cache and engines that lie."""

import json
import re
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import msgspec
import pytest
from tests.unit.cli.conftest import CLOCK, FALSE, KNOWN, TRUE, Said

from haverify.evidence.evidence import Evidence
from haverify.evidence.verdict import Proved, Unknown
from haverify.model.spec import Spec
from haverify.report.report import Report
from haverify.run import cache, executors

Call = Callable[..., Said]
Write = Callable[[str, str], str]

BLOCKED = CLOCK.replace("urgent edge again: -> Run when x >= 1 s", "edge again: -> Run when x > 1 s")


def read_report(folder: Path, stem: str = "m") -> Any:
    return json.loads((folder / "reports" / stem / "report.json").read_bytes())


def verdicts(report: Any) -> dict[str, str]:
    return {c["name"]: c["verdict"] for c in report["claims"]}


@pytest.mark.parametrize(
    ("text", "code"),
    [
        (CLOCK + TRUE, 0),
        (CLOCK + KNOWN, 0),
        (CLOCK + FALSE, 1),
        (CLOCK + KNOWN.replace("<= 2 deg", "<= 3 deg"), 1),
        (CLOCK + TRUE.replace("proved", "unknown"), 1),
        (BLOCKED + TRUE, 1),
        (CLOCK + "property p on Clock { always z <= 1 }\n", 2),
        (CLOCK + "property p on Clock {", 2),
        (CLOCK + "property p on Clock { always y <= 2 s }\n", 2),
        (CLOCK, 5),
        ('spec "Empty" version "1.0"\n', 5),
    ],
)
def test_exit_codes(haverify: Call, write: Write, text: str, code: int) -> None:
    assert haverify("check", write("m.ha", text)).code == code


def test_unknown_is_3_whatever_the_reason(haverify: Call, write: Write, monkeypatch: pytest.MonkeyPatch) -> None:
    tired = Evidence(Unknown("budget", "stopped after 60 s", next_step="--budget 5min"), (), "m")
    propose(monkeypatch, lambda name, true: tired)
    said = haverify("check", write("m.ha", CLOCK + TRUE))
    assert said.code == 3
    assert "try: --budget 5min" in said.out
    assert haverify("check", write("m.ha", CLOCK + KNOWN)).code == 3
    assert haverify("check", write("m.ha", CLOCK + TRUE.replace("proved", "unknown"))).code == 0


def test_several_files_go_on_when_one_cannot_be_read(haverify: Call, write: Write, tmp_path: Path) -> None:
    good, bad = write("good.ha", CLOCK + TRUE), write("bad.ha", "automaton {")
    assert haverify("check", bad, "missing.ha", good).code == 2
    assert verdicts(read_report(tmp_path, "good")) == {"low": "proved"}
    assert read_report(tmp_path, "bad")["summary"]["exit_code"] == 2


def test_calls_that_cannot_be_understood(haverify: Call, write: Write) -> None:
    path, other = write("m.ha", CLOCK + TRUE), write("b/m.ha", CLOCK + TRUE)
    assert haverify("check").code == 2
    assert haverify("check", path, "--grade", "sure").code == 2
    assert haverify("check", path, "--budget", "soon").code == 2
    assert haverify("check", path, "--jobs", "0").code == 2
    assert haverify("check", path, "--lock", "none.lock").code == 2
    assert haverify("check", path, other).code == 2
    assert haverify("check", path, other, "--no-report").code == 0
    write("haverify.toml", "speed = 3\n")
    assert haverify("check", path).code == 2


def test_one_claim(haverify: Call, write: Write, tmp_path: Path) -> None:
    path = write("m.ha", CLOCK + TRUE + FALSE)
    assert haverify("check", path, "-p", "low").code == 0
    assert verdicts(read_report(tmp_path)) == {"low": "proved"}
    said = haverify("check", path, "-p", "lov")
    assert (said.code, "did you mean 'low'?" in said.err) == (2, True)


def test_a_folder_that_is_no_report_is_not_replaced(haverify: Call, write: Write, tmp_path: Path) -> None:
    path = write("m.ha", CLOCK + TRUE)
    write("mine/thesis.txt", "years of work")
    assert haverify("check", path, "--report", "mine").code == 2
    assert (tmp_path / "mine" / "thesis.txt").read_text() == "years of work"


def test_an_old_report_does_not_outlive_a_spec_that_cannot_be_read(
    haverify: Call, write: Write, tmp_path: Path
) -> None:
    haverify("check", write("m.ha", CLOCK + TRUE))
    haverify("check", write("m.ha", CLOCK + "property {"))
    assert read_report(tmp_path)["summary"]["exit_code"] == 2


def test_the_report_has_the_shape_of_its_schema(haverify: Call, write: Write, tmp_path: Path) -> None:
    haverify("check", write("m.ha", CLOCK + TRUE + FALSE))
    report = msgspec.json.decode((tmp_path / "reports" / "m" / "report.json").read_bytes(), type=Report)
    assert [(i.path, len(i.sha256)) for i in report.inputs] == [("m.ha", 64)]
    refuted = report.claims[1]
    assert refuted.run is not None
    assert refuted.run.states[0] == {"x": "0"}
    assert refuted.trust == "checked"
    assert (tmp_path / "reports" / "m" / str(refuted.certificate)).is_file()


def without_times(folder: Path) -> dict[str, bytes]:
    files = {p.relative_to(folder).as_posix(): p.read_bytes() for p in sorted(folder.rglob("*")) if p.is_file()}
    lines = files["report.json"].splitlines()
    files["report.json"] = b"\n".join(x for x in lines if b'"wall_s"' not in x and b'"cpu_s"' not in x)
    files["junit.xml"] = re.sub(rb'time="[^"]*"', b"", files["junit.xml"])
    files["index.html"] = re.sub(rb'<td class="time">[^<]*|<b class="time">[^<]*', b"", files.get("index.html", b""))
    return files


def test_the_same_bytes_for_any_number_of_jobs_and_from_the_cache(haverify: Call, write: Write, tmp_path: Path) -> None:
    path = write("m.ha", CLOCK + TRUE + FALSE + "property more on Clock { never stuck }\n")
    seen = []
    for arguments in (["--no-cache"], ["--no-cache", "--jobs", "2"], [], []):
        haverify("check", path, *arguments)
        seen.append(without_times(tmp_path / "reports" / "m"))
    assert seen[0] == seen[1] == seen[2] == seen[3]


def test_a_warm_run_decides_nothing_anew(haverify: Call, write: Write, monkeypatch: pytest.MonkeyPatch) -> None:
    path = write("m.ha", CLOCK + TRUE)
    haverify("check", path)
    monkeypatch.setattr("haverify.run.decide.solve", lambda spec, names, *_: _nothing(names))
    assert haverify("check", path).code == 0


def _nothing(names: list[str]) -> executors.Solved:
    assert not names
    return executors.Solved()


def propose(monkeypatch: pytest.MonkeyPatch, lie: Callable[[str, Evidence], Evidence]) -> None:
    """Let the analyses propose what `lie` makes of the truth."""
    from haverify.analyses import portfolio

    honest = portfolio.decide_all

    def dishonest(spec: Spec, names: list[str], budget: Any, core: Any = None) -> dict[str, Evidence]:
        return {name: lie(name, e) for name, e in honest(spec, names, budget, core).items()}

    monkeypatch.setattr(portfolio, "decide_all", dishonest)


def flipped(_: str, e: Evidence) -> Evidence:
    """The opposite verdict, with a certificate that says so."""
    return replace(e, verdict=Proved(), certificate={**(e.certificate or {}), "verdict": "proved"})


def test_an_engine_that_lies_proves_nothing(
    haverify: Call, write: Write, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    path = write("m.ha", CLOCK + FALSE)
    propose(monkeypatch, flipped)
    said = haverify("check", path)
    assert said.code == 4
    assert "hacheck refused" in said.err
    assert verdicts(read_report(tmp_path)) == {"lower": "unknown"}


def test_an_engine_without_a_certificate_proves_nothing(
    haverify: Call, write: Write, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    propose(monkeypatch, lambda name, e: replace(e, verdict=Proved(), certificate=None))
    assert haverify("check", write("m.ha", CLOCK + FALSE)).code == 3
    assert verdicts(read_report(tmp_path)) == {"lower": "unknown"}


def test_an_engine_that_fails_costs_its_claim_and_is_4(
    haverify: Call, write: Write, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def fail(name: str, e: Evidence) -> Evidence:
        if name == "low":
            raise RuntimeError("broken")
        return e

    propose(monkeypatch, fail)
    assert haverify("check", write("m.ha", CLOCK + TRUE + KNOWN)).code == 4
    assert verdicts(read_report(tmp_path)) == {"low": "unknown", "lower": "refuted"}


def test_an_interrupt_leaves_a_report_marked_incomplete(
    haverify: Call, write: Write, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def stop(name: str, e: Evidence) -> Evidence:
        raise KeyboardInterrupt

    propose(monkeypatch, stop)
    said = haverify("check", write("m.ha", CLOCK + TRUE))
    report = read_report(tmp_path)
    assert (said.code, report["complete"], verdicts(report)) == (130, False, {"low": "unknown"})
    assert "INCOMPLETE" in said.out


def test_a_cache_that_lies_costs_time_only(
    haverify: Call, write: Write, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    path = write("m.ha", CLOCK + FALSE)
    honest = cache.fetch
    haverify("check", path)
    monkeypatch.setattr(cache, "fetch", lambda *a: {n: flipped(n, e) for n, e in honest(*a).items()})
    assert haverify("check", path).code == 1
    assert verdicts(read_report(tmp_path)) == {"lower": "refuted"}


def test_formats(haverify: Call, write: Write, tmp_path: Path) -> None:
    path = write("m.ha", CLOCK + FALSE)
    assert json.loads(haverify("check", path, "--format", "json").out) == read_report(tmp_path)
    assert haverify("check", path, "--format", "github").out.startswith("::error file=m.ha,line=12")


def test_a_new_violation_beside_an_expected_one(haverify: Call, write: Write, tmp_path: Path) -> None:
    two = CLOCK.replace("let y: deg", "let z: deg = 1 deg\n  let y: deg")
    claim = 'property both on Clock { always y <= 2 deg and z <= 2 deg; expect refuted because "y does not" }\n'
    path = write("m.ha", two + claim)
    said = haverify("check", path)
    assert said.code == 0
    assert said.out.count("haverify accept m.ha --reason") == 1
    assert "[[refuted]]" in read_report(tmp_path)["claims"][0]["notes"][0]
    assert haverify("accept", path, "--reason", "y is known").code == 0
    assert "haverify accept" not in haverify("check", path).out
    assert read_report(tmp_path)["claims"][0]["notes"] == []
    said = haverify("check", write("m.ha", two.replace("1 deg\n", "5 deg\n") + claim))
    assert said.code == 1
    assert "newly violated: Clock / Run / z" in said.out
    said = haverify("check", write("m.ha", two + claim.replace("z <= 2", "z <= 0")))
    assert said.code == 1


def test_accepted_findings_do_not_fail(haverify: Call, write: Write) -> None:
    path = write("m.ha", BLOCKED + TRUE)
    assert haverify("check", path).code == 1
    assert haverify("accept", path, "--reason", "as printed").code == 0
    assert haverify("check", path).code == 0
    assert haverify("check", write("m.ha", "// moved\n" + BLOCKED + TRUE)).code == 0
    said = haverify("check", write("m.ha", CLOCK + TRUE))
    assert said.code == 0
    assert "HA801" in said.out


GEARBOX = """spec "Runs" version "1.0"
enum Gear { Low, High }
automaton M {
  var x: s in [0 s, 2 s]
  var on: bool
  var gear: Gear
  init A with { x := 0 s; on := false; gear := Low }
  mode A { flow { x' = 1 } }
  urgent edge e: A -> A when x >= 1 s do { x := 0 s; on := not on; gear := High }
}
property p on M { always not (gear is High and on) }
"""


def test_a_run_names_the_values_of_truths_and_enumerations(haverify: Call, write: Write, tmp_path: Path) -> None:
    done = haverify("check", write("m.ha", GEARBOX))
    assert "t = 0 s: A with x = 0 s, on = false, gear = Low" in done.out
    assert "gear is High" in done.out
    run = read_report(tmp_path)["claims"][0]["run"]
    assert run["states"][1] == {"x": "0", "on": "1", "gear": "1"}
    assert run["states_decimal"][1] == {"x": "0", "on": "true", "gear": "High"}


def test_figures_from_the_cache_are_those_drawn_anew(
    haverify: Call, write: Write, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    path, pages = write("m.ha", CLOCK + TRUE + FALSE), []
    for options in (["--no-cache"], [], []):
        if len(pages) == 2:  # the third time nothing is drawn
            monkeypatch.setattr("haverify.report.as_html.of_claim", lambda *_: pytest.fail("drawn again"))
        haverify("check", path, *options)
        pages.append(without_times(tmp_path / "reports" / "m")["index.html"])
    assert b"<svg" in pages[0]
    assert pages[0] == pages[1] == pages[2]
