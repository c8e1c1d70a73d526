"""`haverify init`: a commented starter spec whose claims are decided as it expects."""

from __future__ import annotations

import argparse
import sys
from pathlib import Path

from haverify.errors import UsageError

_STARTER = """\
spec "My first model" version "1.0"

/// A lamp that blinks: 2 s on, 3 s off. Every number has a unit, every literal is exact.
const on_time: s = 2 s
const off_time: s = 3 s

automaton Lamp {
  /// The clock of the current phase; its range is the window in which the analysis follows it.
  var x: s in [0 s, 10 s]
  /// An output: computed from the state, here the brightness while the lamp fades in.
  let level: 1 = 0

  init Off with x := 0 s
  mode Off {
    domain x <= off_time
    flow { x' = 1 }
    urgent edge switch_on: -> On when x >= off_time do x := 0 s
  }
  mode On {
    domain x <= on_time
    flow { x' = 1 }
    let level: 1 = x / on_time
    urgent edge switch_off: -> Off when x >= on_time do x := 0 s
  }
}

/// Claims say what should be true and which verdict is expected; a changed verdict fails `haverify check`.
property bright on Lamp {
  always 0 <= level <= 1
  expect proved
}
/// On within 3 s of the start, whatever happens.
property comes_on on Lamp {
  reach at(On) within 3 s
  expect proved
}
/// Known to be false: the lamp reaches full brightness. The report shows the run that does.
property never_full on Lamp {
  always level < 1
  expect refuted because "at the end of each on phase the level is 1"
}
"""


def run(called: argparse.Namespace) -> int:
    """Write the starter spec; an existing file is never replaced."""
    path = Path(called.file)
    try:
        with path.open("x", encoding="utf-8") as file:
            file.write(_STARTER)
    except FileExistsError:
        raise UsageError(f"{path}: is there already") from None
    except OSError as e:
        raise UsageError(f"{path}: cannot be written: {e.strerror}") from e
    print(f"{path}: written; try `haverify check {path}`", file=sys.stderr)
    return 0
