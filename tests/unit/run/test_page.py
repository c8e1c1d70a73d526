"""The page kept between runs."""

import json
import re
from pathlib import Path

import pytest

from haverify.cli import main

ROOT = Path(__file__).parents[3]
TIMES = re.compile(r'(?<= class="time">)[^<]*')


@pytest.mark.parametrize("spec", ["limits.ha", "gait_printed.ha"])
def test_a_page_from_the_cache_is_the_page_made_anew(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, spec: str
) -> None:
    monkeypatch.setenv("HAVERIFY_CACHE", str(tmp_path / "cache"))
    pages = []
    for name, option in (("first", ""), ("kept", ""), ("anew", "--no-cache")):
        main(["check", str(ROOT / "spec" / spec), "--report", str(tmp_path / name), *([option] if option else [])])
        pages.append((tmp_path / name / "index.html").read_text(encoding="utf-8"))
    first, kept, anew = (TIMES.sub("", p) for p in pages)
    assert first == kept == anew
    report = json.loads((tmp_path / "kept" / "report.json").read_text(encoding="utf-8"))
    said = TIMES.findall(pages[1])
    ordered = sorted(report["claims"], key=lambda c: c["ok"])
    assert said[:-1] == [f"{c['wall_s']:.2f} s" for c in ordered]
    assert said[-1].startswith(f"{report['wall_s']:.1f} s")
