"""Periodic orbits: known periods and multipliers, with jumps, and where there is none."""

import json
import math
from pathlib import Path

import pytest

from haverify.cli import main

ORBITS = Path(__file__).parents[2] / "peers" / "orbits"
CIRCLE = """spec "Circle" version "1.0" unitless
automaton C { var x; var y
  init M with { x := 0.5; y := 0 }
  mode M { flow { x' = x - y - x * (x^2 + y^2); y' = x + y - y * (x^2 + y^2) } } }
"""
AWAY = CIRCLE.replace("x' = x - y - x * (x^2 + y^2); y' = x + y - y * (x^2 + y^2)", "x' = 1; y' = 0.5")


def found(path: Path, until: str, capsys: pytest.CaptureFixture[str]) -> dict[str, object]:
    assert main(["simulate", str(path), "--until", until, "--orbit", "--format", "json"]) == 0
    orbit: dict[str, object] = json.loads(capsys.readouterr().out)[0]["orbit"]
    return orbit


def test_the_unit_circle_has_its_period_and_multiplier(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    path = tmp_path / "circle.ha"
    path.write_text(CIRCLE)
    orbit = found(path, "30s", capsys)
    assert math.isclose(orbit["period"], 2 * math.pi, rel_tol=1e-14) and orbit["jumps"] == 0  # type: ignore[arg-type]
    [[real, imaginary]] = orbit["multipliers"]  # type: ignore[misc]
    assert abs(real - math.exp(-4 * math.pi)) < 1e-9 and imaginary == 0 and orbit["attracting"] is True


# B. van der Pol's oscillator with mu = 1; Garcia et al. 1998 print -0.19 +- 0.56i for the long gait at 0.009; Goswami
# et al. 1998 a step of 0.734 s at 3 deg; the block keeps the period of the ground.
KNOWN = [
    ("van_der_pol", "60s", 6.66328685932313, 1e-13, [0.00085969]),
    ("simplest_walker", "60s", 3.88246375285137, 1e-12, [complex(-0.1900998, 0.5575988), 0]),
    ("compass_gait", "30s", 0.734346391158, 1e-11, [complex(-0.1997261, 0.5444761), 0.1315726]),
    ("rocking_forced", "90s", 2 * math.pi / 5, 1e-13, [complex(-0.2652210, 0.7653482)]),
]


@pytest.mark.parametrize(("name", "until", "period", "close", "multipliers"), KNOWN)
def test_known_orbits_are_found(
    name: str, until: str, period: float, close: float, multipliers: list[complex], capsys: pytest.CaptureFixture[str]
) -> None:
    orbit = found(ORBITS / f"{name}.ha", until, capsys)
    assert math.isclose(orbit["period"], period, rel_tol=close)  # type: ignore[arg-type]
    those = [complex(*m) for m in orbit["multipliers"]]  # type: ignore[attr-defined]
    assert all(min(abs(m - t) for t in those) < 2e-6 for m in multipliers), those


def test_what_never_comes_back_has_no_orbit(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    path = tmp_path / "away.ha"
    path.write_text(AWAY)
    assert main(["simulate", str(path), "--orbit"]) == 2
    assert "comes to no place a second time" in capsys.readouterr().err


def test_an_orbit_is_drawn_over_its_run(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    out = tmp_path / "out.svg"
    call = ["simulate", str(ORBITS / "simplest_walker.ha"), "--until", "30s", "--orbit", "--plot", str(out)]
    assert main([*call, "--kind", "phase", "--of", "th,vth"]) == 0
    assert 'class="orbit"' in out.read_text() and "period 3.8824637" in capsys.readouterr().out
