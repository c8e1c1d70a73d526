"""The chapter "From gait to robot": its commands print what it shows."""

import shutil
from pathlib import Path

import pytest
from tests import guide

from haverify.cli import main

ROOT = Path(__file__).parents[1]
SHOWN = [c for b in guide.blocks("robot.md") if b.kind == "console" for c in guide.commands(b.text)]


@pytest.fixture(scope="module")
def place(tmp_path_factory):
    folder = tmp_path_factory.mktemp("robot")
    for part in ("spec", "models/hoap2", "models/walks"):
        shutil.copytree(ROOT / part, folder / part)
    good = (folder / "models/hoap2/gait.toml").read_text()
    (folder / "wrong.toml").write_text(good.replace('"l_knee_pitch"', '"l_knee"'))
    return folder


@pytest.mark.parametrize("number", range(len(SHOWN)))
def test_a_command_prints_what_the_chapter_shows(number, place, monkeypatch, capsys):
    monkeypatch.chdir(place)
    monkeypatch.setenv("HAVERIFY_CACHE", str(place / "cache"))
    command = SHOWN[number]
    assert command.words[0] == "haverify"
    main(command.words[1:])
    out, err = capsys.readouterr()
    assert guide.agrees(command.printed, out + err), out + err


def test_what_a_replay_writes_can_be_rechecked(place, monkeypatch, capsys):
    """The claims about the joints are ordinary ones: the checker re-establishes each."""
    monkeypatch.chdir(place)
    monkeypatch.setenv("HAVERIFY_CACHE", str(place / "cache"))
    if not Path("reports/gait-hoap2").exists():  # the chapter's first command made it
        assert main(["replay", "spec/gait.ha", "--robot", "models/hoap2"]) == 0
    assert {p.name for p in Path("reports/gait-hoap2").iterdir()} >= {"report.json", "replay.json", "replay.html"}
    assert main(["recheck", "reports/gait-hoap2"]) == 0
    page = Path("reports/gait-hoap2/replay.html").read_text()
    assert page.count("<svg") == 5 and "http" not in page.replace("http://www.w3.org/2000/svg", "")
    assert "<script" not in page
