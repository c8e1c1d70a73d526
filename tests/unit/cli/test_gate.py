"""`haverify gate` and `haverify plot`: what a CI job calls after `check`."""

import json
from collections.abc import Callable
from pathlib import Path
from typing import Any
from xml.etree import ElementTree

import pytest
from tests.unit.cli.conftest import CLOCK, FALSE, KNOWN, TRUE, Said
from tests.unit.report.valid import valid_junit, valid_sarif

Call = Callable[..., Said]
Write = Callable[[str, str], str]


@pytest.fixture
def checked(haverify: Call, write: Write) -> Callable[[str, str], str]:
    """Check a spec of these claims; its report folder."""

    def check(name: str, claims: str) -> str:
        haverify("check", write("m.ha", CLOCK + claims), "--report", name)
        return name

    return check


def edited(folder: str, change: Callable[[Any], None]) -> None:
    file = Path(folder) / "report.json"
    whole = json.loads(file.read_text(encoding="utf-8"))
    change(whole)
    file.write_text(json.dumps(whole), encoding="utf-8")


def test_the_exit_code_is_that_of_the_check(haverify: Call, checked: Callable[[str, str], str]) -> None:
    assert haverify("gate", checked("a", TRUE)).code == 0
    assert haverify("gate", checked("b", TRUE + FALSE)).code == 1
    assert haverify("gate", checked("c", KNOWN) + "/report.json").code == 0
    assert haverify("gate", checked("d", "")).code == 5
    assert haverify("gate", checked("e", TRUE + "property p on Clock { always z <= 3 deg }")).code == 2


def test_a_lower_margin_is_worse_by_the_share_that_is_allowed(
    haverify: Call, checked: Callable[[str, str], str]
) -> None:
    old = checked("old", "property low on Clock { always y <= 13 deg; expect proved }\n")
    new = checked("new", "property low on Clock { always y <= 12.5 deg; expect proved }\n")
    assert haverify("gate", new, "--baseline", old).code == 0
    assert haverify("gate", new, "--baseline", old, "--max-margin-loss", "5%").code == 0
    said = haverify("gate", new, "--baseline", old, "--max-margin-loss", "4.999%")
    assert said.code == 1
    assert "margin   low: margin 9.5 deg, was 10 deg (-5 %)" in said.out
    assert "model    m.ha changed" in said.out


def test_what_is_gone_fails_and_is_annotated(haverify: Call, checked: Callable[[str, str], str]) -> None:
    old, new = checked("old", TRUE + KNOWN), checked("new", TRUE)
    said = haverify("gate", new, "--baseline", old, "--format", "github")
    assert said.code == 1
    assert said.out.startswith("::error file=m.ha,line=13,title=gate%3A claim::lower: gone; it was refuted")


def test_json_holds_the_same(haverify: Call, checked: Callable[[str, str], str]) -> None:
    said = haverify("gate", checked("new", FALSE), "--format", "json")
    told = json.loads(said.out)
    assert (told["exit_code"], said.code, told["missed"][0]["name"]) == (1, 1, "lower")


@pytest.mark.parametrize(
    "change",
    [
        lambda r: r.update(complete=False),
        lambda r: r.update(schema="haverify.report/2"),
        lambda r: r.update(claims=r["claims"][:1]),
        lambda r: r["summary"].update(exit_code=0),
        lambda r: r["claims"][1].update(ok=True),
        lambda r: r["claims"][1].update(verdict="proved", ok=True, problems=[]),
        lambda r: r["claims"][1].pop("verdict"),
        lambda r: r["claims"][1].update(verdict="fine"),
        lambda r: r.clear(),
    ],
)
def test_a_report_that_is_cut_short_or_edited_is_refused(
    haverify: Call, checked: Callable[[str, str], str], change: Callable[[Any], None]
) -> None:
    folder = checked("r", TRUE + FALSE)
    edited(folder, change)
    said = haverify("gate", folder)
    assert said.code == 2
    assert said.out == ""
    assert "Traceback" not in said.err


def test_what_is_no_report_is_refused(haverify: Call, write: Write, checked: Callable[[str, str], str]) -> None:
    for text in ("", "[]", "{}", "[" * 100_000, '{"schema": "haverify.report/1"}'):
        assert haverify("gate", write("x.json", text)).code == 2
    assert haverify("gate", "gone.json").code == 2
    assert haverify("gate", checked("r", TRUE), "--max-margin-loss", "5%").code == 2
    assert haverify("gate", "r", "--baseline", "r", "--max-margin-loss", "much").code == 2


def test_figures_are_drawn_again_from_the_folder(haverify: Call, checked: Callable[[str, str], str]) -> None:
    folder = checked("r", TRUE + FALSE)
    said = haverify("plot", folder, "-o", "figures")
    assert said.code == 0
    files = sorted(Path("figures").glob("*.svg"))
    assert [f.name for f in files] == ["claim_low.svg", "claim_lower.svg", "modes_Clock.svg", "outputs_Clock.svg"]
    page = (Path(folder) / "index.html").read_text(encoding="utf-8")
    for f in files:
        ElementTree.parse(f)
        assert f.read_text(encoding="utf-8").partition("</style>")[2].partition("</svg>")[0] in page
    assert haverify("plot", f"{folder}/report.json", "-p", "low", "-o", "one").out.count("\n") == 1


def test_figures_need_the_core(haverify: Call, checked: Callable[[str, str], str]) -> None:
    folder = checked("r", TRUE)
    (Path(folder) / "core.json").unlink()
    assert haverify("plot", folder).code == 2


@pytest.mark.parametrize("command", ["check", "lint"])
def test_documents_on_standard_output_are_one_for_all_specs(haverify: Call, write: Write, command: str) -> None:
    stuck = CLOCK.replace("    urgent edge again: -> Run when x >= 1 s do x := 0 s\n", "")
    paths = [write("m.ha", CLOCK + TRUE + FALSE), write("n.ha", stuck), write("o.ha", "spec"), "gone.ha"]
    sarif = haverify(command, *paths, "--format", "sarif")
    run = valid_sarif(sarif.out)
    assert sarif.code == run["invocations"][0]["exitCode"] == 2
    assert {r["ruleId"] for r in run["results"]} >= {"HA303", "HA001"}
    junit = haverify(command, *paths, "--format", "junit")
    suites = list(valid_junit(junit.out))
    assert [s.get("name") for s in suites] == paths
    assert all(int(s.get("failures")) + int(s.get("errors")) for s in suites[1:])


def test_every_file_of_a_report_folder_is_there(haverify: Call, checked: Callable[[str, str], str]) -> None:
    folder = Path(checked("r", TRUE + FALSE))
    files = {"report.json", "report.sarif", "junit.xml", "summary.md", "index.html", "core.json"}
    assert files <= {f.name for f in folder.iterdir()}
    assert valid_sarif((folder / "report.sarif").read_text(encoding="utf-8"))["results"]
    assert len(list(valid_junit((folder / "junit.xml").read_text(encoding="utf-8")).iter("failure"))) == 1
    assert "1 of 2 claims is not as expected" in (folder / "index.html").read_text(encoding="utf-8")
