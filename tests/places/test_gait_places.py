"""Every place of `spec/gait.ha` where a slip matters: a sign in a table, two bounds the wrong way round."""

from __future__ import annotations

import csv
import json
import re
import shutil
from collections.abc import Iterator
from fractions import Fraction
from itertools import zip_longest
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


def is_named(report: dict, said: str, table: str, phase: str) -> bool:
    """Whether a part of an unexpected claim is refuted for the table's output in a phase, and the row is said."""
    parts = [p for c in unexpected(report) for p in c["parts"] if p["verdict"] == "refuted"]
    is_refuted = any((p["mode"], p["output"]) == (phase, OUTPUTS[table]) for p in parts)
    return is_refuted and f"coeffs/{table}.csv:{ROW[phase]}" in said


@pytest.mark.parametrize("table", OUTPUTS)
def test_a_flipped_sign_alone_is_found_and_named(folder: Path, table: str, capsys: pytest.CaptureFixture[str]) -> None:
    phase, column, text = next(flips(table))
    rewrite(folder / "spec" / "coeffs" / f"{table}.csv", phase, column, text)
    code, report = check()
    assert code == 1
    assert is_named(report, capsys.readouterr().out, table, phase)


def flips_of_turn(turn: int) -> Iterator[list[tuple[str, str, str, str]]]:
    """Flips (table, phase, column, number) to make at once: of each table one, all in different phases."""
    phases = list(ENDS)
    own = [
        [(table, *flip) for flip in flips(table) if flip[0] == phases[(k + turn) % len(phases)]]
        for k, table in enumerate(OUTPUTS)
    ]
    yield from ([f for f in some if f is not None] for some in zip_longest(*own))


def test_every_flip_has_its_turn() -> None:
    made = [flip for turn in range(len(ENDS)) for some in flips_of_turn(turn) for flip in some]
    assert sorted(made) == sorted((table, *flip) for table in OUTPUTS for flip in flips(table))
    assert all(sum(table == t for t, *_ in made) > 20 for table in OUTPUTS)


@pytest.mark.parametrize("turn", range(len(ENDS)))
def test_every_flipped_sign_is_found_and_named(folder: Path, turn: int, capsys: pytest.CaptureFixture[str]) -> None:
    """No two are in one phase or one table: what is said of a phase's output is said of one flip."""
    coeffs = folder / "spec" / "coeffs"
    good = {table: (coeffs / f"{table}.csv").read_text() for table in OUTPUTS}
    for some in flips_of_turn(turn):
        for table, *cell in some:
            rewrite(coeffs / f"{table}.csv", *cell)
        code, report = check()
        said = capsys.readouterr().out
        for table, text in good.items():
            (coeffs / f"{table}.csv").write_text(text)
        assert code == 1, some
        assert all(is_named(report, said, table, phase) for table, phase, *_ in some), some


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
