"""Every spec of the project: `check` has nothing to object to, and `recheck` accepts what it wrote."""

from pathlib import Path

import pytest

from haverify.cli import main

ROOT = Path(__file__).parents[1]
SPECS = sorted((ROOT / "spec").glob("*.ha"))


@pytest.mark.parametrize("spec", SPECS, ids=lambda p: p.stem)
def test_it_says_what_it_expects(spec: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("HAVERIFY_CACHE", str(tmp_path / "cache"))
    assert main(["check", str(spec), "--report", str(tmp_path / "report")]) == 0
    assert main(["recheck", str(tmp_path / "report")]) == 0


def test_all_of_them_are_found() -> None:
    assert {"gait", "gait_printed", "leg_ca", "lip_push", "push_recovery", "rocking_block", "walker", "zeno"} <= {
        p.stem for p in SPECS
    }
