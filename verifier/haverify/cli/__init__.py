"""The command line: what is asked, handed to the command that does it; exceptions become exit codes here alone."""

from __future__ import annotations

import atexit
import gc
import os
import sys
from importlib import import_module

from haverify.cli.arguments import parser
from haverify.errors import SoundnessError, SpecError, ToolError, UsageError

_UNUSABLE, _FAULT, _INTERRUPTED = 2, 4, 130


def main(arguments: list[str] | None = None) -> int:
    """Run a command and return its exit code (`COMMANDS` in the manual: 0, 1, 2, 3, 4, 5, 130)."""
    _collect_seldom()
    words = sys.argv[1:] if arguments is None else arguments
    called = parser(words).parse_args(words)
    try:
        code = int(import_module(f"haverify.cli.{called.command}").run(called))
        sys.stdout.flush()
        return code
    except (UsageError, SpecError) as e:
        return _say(f"haverify: {e}", _UNUSABLE)
    except ToolError as e:
        return _say(f"haverify: {e}", _FAULT)
    except KeyboardInterrupt:
        return _say("haverify: interrupted", _INTERRUPTED)
    except BrokenPipeError:  # the reader of our output went away; nothing more can be said
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        return _FAULT
    except Exception as e:  # noqa: BLE001 - a fault of ours must end as exit code 4, whatever it is
        return _fault(e)


def _collect_seldom() -> None:
    """Search for garbage in cycles every million objects and not at the end: it costs a tenth and finds hardly any."""
    gc.set_threshold(1_000_000)
    atexit.register(gc.freeze)


def _say(text: str, code: int) -> int:
    print(text, file=sys.stderr)
    return code


def _fault(e: Exception) -> int:
    """Say that haverify failed, and how to report it."""
    if isinstance(e, SoundnessError) or os.environ.get("HAVERIFY_DEBUG"):
        import traceback

        traceback.print_exception(e)
    text = " ".join(str(e).split())[:300]
    print(f"haverify: internal error: {type(e).__name__}: {text}", file=sys.stderr)
    print(
        "  This is a fault of haverify, not of the spec. Please report it with the spec and this message;",
        file=sys.stderr,
    )
    print("  HAVERIFY_DEBUG=1 shows where it happened.", file=sys.stderr)
    return _FAULT
