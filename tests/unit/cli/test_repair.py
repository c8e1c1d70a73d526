"""`haverify repair`."""

from __future__ import annotations

import json
from pathlib import Path

from .conftest import CLOCK, FALSE, KNOWN, TRUE

WRONG = "property high on Clock { always y >= 0.1 deg or y < 3 deg }\nproperty low on Clock { always y <= 0.31 deg }\n"


def test_nothing_to_repair(haverify, write) -> None:
    said = haverify("repair", write("a.ha", CLOCK + TRUE + KNOWN))
    assert (said.code, said.out) == (0, "a.ha: nothing to repair\n")


def test_a_proposal_shows_place_reason_and_line(haverify, write) -> None:
    path = write("a.ha", CLOCK + WRONG)
    said = haverify("repair", path)
    assert said.code == 1
    assert "repair 1 of 1: one decimal place, line 13: 0.31 -> 3.1" in said.out
    assert "--> a.ha:13:37" in said.out
    assert "^^^^ 3.1" in said.out
    assert "as expected now: low" in said.out
    assert "line: property low on Clock { always y <= 3.1 deg }" in said.out
    assert Path(path).read_text() == CLOCK + WRONG


def test_what_no_change_mends_is_said(haverify, write) -> None:
    said = haverify("repair", write("a.ha", CLOCK + FALSE.replace("2 deg", "2.2 deg")))
    assert said.code == 1
    assert "left: lower: violated in Clock / Run / y" in said.out
    assert "no small change mends it" in said.out


def test_what_has_no_meaning_is_not_repaired(haverify, write) -> None:
    said = haverify("repair", write("a.ha", CLOCK.replace("mode Run {", "mode Run")))
    assert said.code == 2
    assert "error[HA0" in said.err
    assert haverify("repair", "missing.ha").code == 2
    assert haverify("repair", write("b.ha", CLOCK + TRUE), "-p", "nobody").code == 2


def test_one_claim(haverify, write) -> None:
    path = write("a.ha", CLOCK + WRONG + FALSE)
    assert haverify("repair", path, "-p", "high").code == 0
    assert haverify("repair", path, "-p", "low").code == 1


def test_json(haverify, write) -> None:
    said = haverify("repair", "--format", "json", write("a.ha", CLOCK + WRONG))
    found = json.loads(said.out)
    assert found["schema"] == "haverify.repair/1"
    (repair,) = found["repairs"]
    assert repair["kind"] == "point"
    assert repair["edits"] == [
        {"path": "a.ha", "line": 13, "column": 37, "end_line": 13, "end_column": 41, "old": "0.31", "new": "3.1"}
    ]
    assert repair["effect"]["claims_mended"] == ["low"]
    assert found["exit_code"] == said.code == 1


def applied(text: str, difference: str) -> str:
    """A text with a unified difference applied, which must fit it line by line."""
    old, new, at = text.splitlines(keepends=True), [], 0
    for line in difference.splitlines(keepends=True):
        if line.startswith("@@"):
            start = int(line.split()[1][1:].split(",")[0]) - 1
            new += old[at:start]
            at = start
        elif line[:1] in " -" and not line.startswith("---"):
            assert old[at] == line[1:]
            new += [line[1:]] if line[0] == " " else []
            at += 1
        elif line[:1] == "+" and not line.startswith("+++"):
            new.append(line[1:])
    return "".join(new + old[at:])


def test_the_difference_can_be_applied(haverify, write) -> None:
    path = write("a.ha", CLOCK + WRONG)
    mended = applied(CLOCK + WRONG, haverify("repair", "--diff", path).out)
    assert mended != CLOCK + WRONG
    assert haverify("repair", write("a.ha", mended)).code == 0


def test_the_difference_keeps_the_line_ends_of_a_file(haverify, write, tmp_path) -> None:
    path = write("a.ha", "")
    (tmp_path / path).write_bytes((CLOCK + WRONG).replace("\n", "\r\n").encode())
    changed = [line for line in haverify("repair", "--diff", path).out.split("\n") if line[:1] in "+-"]
    assert [line for line in changed if line[1:3] not in ("--", "++")] == [
        "-property low on Clock { always y <= 0.31 deg }\r",
        "+property low on Clock { always y <= 3.1 deg }\r",
        "",
    ]


def test_accepted_findings_are_spared_in_the_text(haverify, write) -> None:
    locked = CLOCK.replace("urgent edge again: -> Run when x >= 1 s", "edge again: -> Run when x > 1 s")
    path = write("a.ha", locked + TRUE)
    assert haverify("repair", path).code == 1
    assert haverify("accept", path, "--reason", "as printed").code == 0
    assert haverify("repair", path).code == 0
    said = haverify("repair", "--accepted", path)
    assert said.code == 1
    assert "one bound open or closed" in said.out
