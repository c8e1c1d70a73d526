"""Analyses refuse to run where floating point does not work as their soundness needs it."""

from __future__ import annotations

import platform
import subprocess
import sys
from pathlib import Path

import pytest

VERIFIER = Path(__file__).parents[3] / "verifier"

SPEC = """spec "Flow" version "1.0" unitless
automaton A { var x; init R where 1 <= x <= 1.1; mode R { flow { x' = sin(x) - x } } }
automaton B {
  var x
  init L where 0.1 <= x <= 0.2
  mode L { domain x <= 1; flow { x' = exp(x) }; urgent edge hit: -> R when x >= 1 do x := 0.5 }
  mode R { flow { x' = -sin(x) } }
}
property calm on A { within 1; always x <= 1.2 }
property pieces on A { within 1; always x <= 1.2; method taylor(cuts = 1, order = 7) }
property hops on B { can reach at(R) and x <= 0.4 within 2 }
"""

# On x86-64 control words are set through the C library's <fenv.h>: fesetround, and a whole environment whose mxcsr
# (at byte 28 in glibc) has the bits flush-to-zero (15) and denormals-are-zero (6).
PROGRAM = """
import ctypes, sys
import numpy
from haverify.analyses.hybrid.shared import at_once
from haverify.analyses.portfolio import decide_all
from haverify.evidence.verdict import Unknown
from haverify.maths.interval import Fault, Interval
from haverify.run.examine import read
from haverify.solvers.kernel import Settings, Tape, flowpipe

libm = ctypes.CDLL("libm.so.6")
spec, _, found = read(sys.argv[1])
decided = [name for name, e in decide_all(spec).items() if not isinstance(e.verdict, Unknown)]
assert {"calm", "pieces"} <= set(decided), decided

def rounding(mode):
    assert libm.fesetround(mode) == 0

def flushing(bits):
    environment = ctypes.create_string_buffer(64)
    libm.fegetenv(environment)
    word = int.from_bytes(environment.raw[28:32], "little") | bits
    changed = environment.raw[:28] + word.to_bytes(4, "little") + environment.raw[32:]
    libm.fesetenv(ctypes.create_string_buffer(changed, 64))

changes = {
    "upward": lambda: rounding(0x800), "downward": lambda: rounding(0x400), "towards zero": lambda: rounding(0xC00),
    "flush": lambda: flushing(0x8000), "daz": lambda: flushing(0x0040),
}
tape = Tape({"x": 0}, {})
listing = tape.listing([tape._push("variable", 0, 0)])
settings = Settings(8, 1, 1e-7, 0.01, 0.1, 1e-6, 100, 2)
one = Interval(1.0, 1.0)
analyses = {
    "interval": lambda: Interval.at(1) + Interval.at(2),
    "function": lambda: one.exp(),
    "flowpipe": lambda: flowpipe(listing, [(1.0, 1.0)], one, listing, [(-10.0, 10.0)], settings),
    **{name: (lambda name=name: decide_all(read(sys.argv[1])[0], [name])) for name in decided},
}
default = ctypes.create_string_buffer(64)
libm.fegetenv(default)
change = sys.argv[2]
for name, analysis in analyses.items():
    answer = "nothing"
    changes[change]()
    try:
        analysis()
    except Fault as fault:
        answer = str(fault)
    finally:
        libm.fesetenv(default)
    assert "round to nearest" in answer, (change, name, answer)
    analysis()

def changed():
    changes[change]()
    analyses["flowpipe"]()

answer = "nothing"
try:
    at_once([analyses["flowpipe"], changed])
except Fault as fault:
    answer = str(fault)
assert "round to nearest" in answer, (change, "a thread of its own", answer)
analyses["flowpipe"]()
print("refused", len(analyses))
"""


@pytest.mark.parametrize("change", ["upward", "downward", "towards zero", "flush", "daz"])
def test_every_analysis_refuses(change: str, tmp_path: Path) -> None:
    assert platform.machine() == "x86_64" and sys.platform == "linux", "written for the control words of this machine"
    (tmp_path / "flow.ha").write_text(SPEC, encoding="utf-8")
    (tmp_path / "program.py").write_text(PROGRAM, encoding="utf-8")
    done = subprocess.run(
        [sys.executable, str(tmp_path / "program.py"), str(tmp_path / "flow.ha"), change],
        env={"PYTHONPATH": str(VERIFIER)},
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.stdout.startswith("refused"), done.stderr
