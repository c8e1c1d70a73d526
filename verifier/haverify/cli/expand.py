"""`haverify expand`: the desugared core as `.ha`."""

from __future__ import annotations

import argparse
import sys

from haverify.cli.output import put, wants_colour
from haverify.diagnostics.codes import is_error
from haverify.diagnostics.render import render_all
from haverify.report.gate import OK, UNREADABLE
from haverify.run.load import load


def run(called: argparse.Namespace) -> int:
    """Print the core; exit code 2 and the errors where the spec has no meaning."""
    loaded = load(called.file)
    errors = [d for d in loaded.diagnostics if is_error(d)]
    if loaded.spec is None or errors:
        sys.stderr.write(render_all(errors, loaded.sources, wants_colour()))
        return UNREADABLE
    from haverify.elaborate.expand import expand

    put(expand(loaded.spec))
    return OK
