"""Every place of `spec/gait.ha` where a slip matters: a sign in a table, two bounds the wrong way round."""

from __future__ import annotations

import csv
import json
import re
import shutil
from collections.abc import Iterator
from fractions import Fraction
from pathlib import Path

import pytest

from haverify.cli import main
from haverify.run import pipeline

SPEC = Path(__file__).parents[2] / "spec"
OUTPUTS = {
    "left_hip": "lh",
    "right_hip": "rh",
    "left_knee": "lk",
    "right_knee": "rk",
    "left_ankle": "la",
    "right_ankle": "ra",
}
ENDS = {"LR": "0.5", "MST": "0.733", "TS": "0.9833", "PS": "1.1167", "IS": "1.2667", "MSW": "1.4333", "TSW": "1.6"}
ROW = {phase: line for line, phase in enumerate(ENDS, start=2)}


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A copy of the specs without their hashes, so that content alone speaks."""
    shutil.copytree(SPEC, tmp_path / "spec")
    shutil.copy(SPEC.parent / "haverify.lock", tmp_path)
    for spec in (tmp_path / "spec").glob("*.ha"):
        spec.write_text(re.sub(r'^ *sha256 ".*"\n', "", spec.read_text(), flags=re.MULTILINE))
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("HAVERIFY_CACHE", str(tmp_path / "cache"))
    monkeypatch.setattr(pipeline, "page", lambda *_: "")  # figures of hundreds of wrong tables, which nobody looks at
    return tmp_path


def check(spec: str = "spec/gait.ha") -> tuple[int, dict]:
    """The exit code and the report of a check."""
    code = main(["check", spec, "--report", "out"])
    return code, json.loads(Path("out/report.json").read_text())


def unexpected(report: dict) -> list[dict]:
    """The claims that are not as expected."""
    return [c for c in report["claims"] if not c["ok"]]


def flips(table: str) -> Iterator[tuple[str, str, str]]:
    """(phase, column, flipped number) of each cell whose flip moves the output by more than 20 deg in its slot."""
    with (SPEC / "coeffs" / f"{table}.csv").open(newline="") as file:
        for row in csv.DictReader(file):
            powers = [c for c in row if c.startswith("p") and c != "phase" and row[c]]
            for column in [*powers, "error"]:
                power = 0 if column == "error" else len(powers) - 1 - powers.index(column)
                move = 2 * abs(Fraction(row[column])) * Fraction(ENDS[row["phase"]]) ** power
                if move > 20:
                    text = row[column]
                    yield row["phase"], column, text[1:] if text.startswith("-") else "-" + text.lstrip("+")


def rewrite(path: Path, phase: str, column: str, text: str) -> None:
    """Put `text` into one cell."""
    with path.open(newline="") as file:
        rows = list(csv.reader(file))
    line = next(r for r in rows if r[0] == phase)
    line[rows[0].index(column)] = text
    path.write_text("".join(",".join(r) + "\n" for r in rows))


def test_the_copy_is_as_good_as_the_original(folder: Path) -> None:
    code, report = check()
    assert code == 0
    assert unexpected(report) == []


@pytest.mark.parametrize("table", OUTPUTS)
def test_a_flipped_sign_is_found_and_named(folder: Path, table: str, capsys: pytest.CaptureFixture[str]) -> None:
    path = folder / "spec" / "coeffs" / f"{table}.csv"
    good = path.read_text()
    seen = 0
    for phase, column, text in flips(table):
        rewrite(path, phase, column, text)
        code, report = check()
        said = capsys.readouterr().out
        path.write_text(good)
        parts = [p for c in unexpected(report) for p in c["parts"] if p["verdict"] == "refuted"]
        place = (phase, column, text)
        assert code == 1, place
        assert any((p["mode"], p["output"]) == (phase, OUTPUTS[table]) for p in parts), place
        assert f"coeffs/{table}.csv:{ROW[phase]}" in said, place
        seen += 1
    assert seen > 20


def swaps(text: str) -> Iterator[tuple[str, str]]:
    """(claim, text with the two bounds of one of its ranges or windows swapped)."""
    quantity = r"-?[\d.]+ [a-z/^0-9]+"
    starts = [(m.start(), m.group(1)) for m in re.finditer(r"^property (\w+)", text, re.MULTILINE)]
    for pattern in (rf"({quantity})( <= \w+ <= )({quantity})", rf"(during \[)({quantity})(, )({quantity})(\])"):
        for m in re.finditer(pattern, text):
            claim = [name for at, name in starts if at < m.start()][-1]
            g = m.groups()
            new = g[2] + g[1] + g[0] if len(g) == 3 else g[0] + g[3] + g[2] + g[1] + g[4]
            yield claim, text[: m.start()] + new + text[m.end() :]


def test_swapped_bounds_are_found_and_named(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    path = folder / "spec" / "gait.ha"
    good = path.read_text()
    seen = 0
    for claim, text in swaps(good):
        path.write_text(text)
        code, report = check()
        said = capsys.readouterr().out
        assert code == 1, claim
        named = {c["name"] for c in unexpected(report)} | {f["message"] for f in report["findings"]}
        assert any(claim in n for n in named), (claim, said)
        assert claim in said
        seen += 1
    assert seen > 50


def test_swapped_limits_are_found(folder: Path) -> None:
    path = folder / "spec" / "limits.ha"
    good = path.read_text()
    found = list(re.finditer(r"\[(-?[\d.]+ deg), (-?[\d.]+ deg)\]", good))
    assert found
    for m in found:
        path.write_text(good[: m.start()] + f"[{m.group(2)}, {m.group(1)}]" + good[m.end() :])
        code, report = check()
        assert code == 1
        assert any(f["code"] == "HA201" for f in report["findings"])


def test_a_new_violation_beside_an_expected_one_is_caught(folder: Path) -> None:
    """`robot_knees` is refuted as expected in some phases; a further phase must not hide behind that."""
    path = folder / "spec" / "coeffs" / "left_knee.csv"
    rewrite(path, "MSW", "error", "11")
    code, report = check()
    knees = next(c for c in report["claims"] if c["name"] == "robot_knees")
    assert knees["verdict"] == "refuted"
    assert not knees["ok"]
    assert code == 1
    assert any(f["code"] == "HA701" and "MSW" in f["message"] + " ".join(f["notes"]) for f in report["findings"])
