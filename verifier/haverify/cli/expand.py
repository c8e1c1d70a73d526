"""`haverify expand`: the desugared core as `.ha`."""

from __future__ import annotations

import argparse
import sys

from haverify.cli.output import put, wants_colour
from haverify.diagnostics.codes import is_meaningless
from haverify.diagnostics.order import settle
from haverify.diagnostics.render import render_all
from haverify.report.exit_codes import OK, UNREADABLE
from haverify.run.examine import read


def run(called: argparse.Namespace) -> int:
    """Print the core; exit code 2 and the errors where the spec has no meaning."""
    spec, sources, found = read(called.file)
    errors = settle(d for d in found if is_meaningless(d))
    if spec is None or errors:
        sys.stderr.write(render_all(errors, sources, wants_colour()))
        return UNREADABLE
    from haverify.elaborate.expand import expand

    put(expand(spec))
    return OK
