"""The commands that are built, with their options."""

from __future__ import annotations

import argparse
from collections.abc import Sequence

_CODES = """\
exit codes: 0 all as expected; 1 a claim decided otherwise, or a new error finding; 2 call or input cannot be
understood; 3 a claim is unknown; 4 a fault of haverify; 5 nothing was checked; 130 interrupted

haverify COMMAND --help tells more; haverify init writes a spec to start from; docs/language.md is the language"""

_CHECK = """\
Decide every claim of some specs, re-check the evidence with hacheck, write a report folder for each.
A claim that is refuted as its spec expects (`expect refuted`) is fine: the exit code is about expectations."""

_CHECK_MORE = """\
--report DIR: for one file, DIR itself; for several, DIR/<stem>/. The default is below the current folder.
The last line says what the exit code means; `haverify --help` lists them all."""

_ACCEPT = """\
Record today's findings, and the violated parts of claims that are refuted as expected, in haverify.lock, with a reason.
From then on `check` is silent about them, and fails when a further part is violated or one of these no longer is.
The file is the nearest haverify.lock beside the spec or above it; without one, it is made beside the spec."""

_RECHECK = """\
Let hacheck re-establish every verdict of a report folder, and read the spec again to see that it still gives this core.
Run it in the folder in which `check` ran: paths of specs and tables are relative to it; what is not found is said."""

_REPAIR = """\
Propose the smallest changes that make a spec plausible: a sign, a decimal place, swapped digits, cells or bounds, an
open or closed bound, a bit of a rule. Each is tried before it is shown: the changed text is read again and decided
again, exactly. Nothing is written, and where nothing is wrong nothing is proposed."""

_SIMULATE = """\
Follow runs of an automaton in floating point: the first one with params at their defaults and everything else in the
middle, the others by chance. Runs show what a model does; they prove nothing."""

_FALSIFY = """\
Search for a run that violates a claim: over starts, params, inputs and choices, for the least margin in dense time.
What floats find is `refuted` only once the run has been followed again in enclosures."""

_FALSIFY_MORE = """\
exit codes: 0 refuted as expected; 1 refuted otherwise; 2 call or input cannot be understood; 3 nothing certain was
found; 5 there is no claim that one run could refute"""

_REPAIR_MORE = """\
exit codes: 0 nothing to repair; 1 changes are proposed, or something is wrong that no small change mends;
2 call or input cannot be understood. Findings that haverify.lock or @allow accepts are spared in the spec's own text,
not in its tables; claims that expect a refutation are never a reason for a change."""

_GATE = """\
Recompute the exit code of a report from its claims and findings; refuse one that is incomplete or contradicts itself.
With a baseline also fail (exit code 1) where a claim is gone or no longer proved or decided, its trust is weaker, or it
lost more of its margin than allowed; what else changed is listed, with what differs between the two runs.
The evidence itself is re-established by `haverify recheck`."""

_PLOT = """\
Draw the figures of a report folder again, from report.json, core.json and the certificates; nothing is run."""


_REPLAY = """\
Replay the cycle of a gait on a robot and judge it: what its joints can do as claims, decided and re-checked like
those of `check`; what the whole body does by enclosures over the cycle, and by samples where these say so."""

_REPLAY_MORE = """\
--robot DIR holds robot.toml and the URDF it names; --map says which output drives which joint (docs/robot.md).
exit codes are those of `check`; a sampled check that breaks its limit counts as unknown (3), advice as nothing."""


_FIT = """\
Read recordings of a walk, find its cycles and phases, fit a polynomial to each joint and phase, and write all of it as
a spec with claims and tables, ready for `check`. Angles have no step between phases, nor where the cycle closes."""

_FIT_MORE = """\
DATA: .mot .sto .csv .trc .c3d .json (landmarks); docs/fitting.md says what is expected of each.
exit codes: 0 the spec is written; 2 a recording cannot be used, and nothing is written"""


_COMPARE = """\
How far walks are from the first one: root mean square, peak and correlation of each joint, and the root mean square in
each phase. A walk is a recording, or a spec whose automaton has the outputs lh, rh, lk, rk, la, ra over a cycle."""


def parser(arguments: Sequence[str] | None = None) -> argparse.ArgumentParser:
    """The parser of the command line; a command's name is `command`.

    One that is to read `arguments` alone knows only the command that they begin with: the others cost more time than
    all that parsing does.
    """
    top = argparse.ArgumentParser(
        prog="haverify",
        description="Prove or refute what .ha specs claim, with evidence that a second program re-checks.",
        epilog=_CODES,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    top.add_argument("--version", action=_Version, nargs=0, help="print the version and exit")
    commands = top.add_subparsers(prog="haverify", dest="command", metavar="COMMAND", required=True)
    every = (
        _check,
        _lint,
        _accept,
        _fmt,
        _expand,
        _explain,
        _recheck,
        _gate,
        _plot,
        _repair,
        _invent,
        _simulate,
        _falsify,
        _replay,
        _fit,
        _compare,
        _init,
        _doctor,
    )
    asked = [add for add in every if arguments and arguments[0] == add.__name__[1:]]
    for add in asked or every:
        add(commands)
    return top


class _Version(argparse.Action):
    def __call__(self, parser: argparse.ArgumentParser, *_: object) -> None:
        from haverify.report.version import VERSION

        parser.exit(message=f"haverify {VERSION}\n")


_Commands = argparse._SubParsersAction  # the type argparse gives no public name


def _told(
    commands: _Commands[argparse.ArgumentParser], name: str, about: str, more: str = "", *, help: str
) -> argparse.ArgumentParser:
    """A command whose help says more than its options, line by line as written."""
    raw = argparse.RawDescriptionHelpFormatter
    return commands.add_parser(name, help=help, description=about, epilog=more, formatter_class=raw)


def _check(commands: _Commands[argparse.ArgumentParser]) -> None:
    p = _told(commands, "check", _CHECK, _CHECK_MORE, help="decide every claim, write reports")
    p.add_argument("files", nargs="+", metavar="FILE.ha", help="a spec")
    p.add_argument("-p", "--property", metavar="NAME", help="decide one claim (or family) only")
    p.add_argument("--budget", metavar="TIME", help="safety net in time for each claim: 90s, 5min (default 60s)")
    p.add_argument("--jobs", type=int, metavar="N", help="processes that share the claims (default 1)")
    p.add_argument(
        "--format", choices=("text", "json", "sarif", "junit", "github"), help="what to print (default text)"
    )
    where = p.add_mutually_exclusive_group()
    where.add_argument("--report", metavar="DIR", help="where the report goes (default ./reports/<stem>/)")
    where.add_argument("--no-report", action="store_true", help="keep no report")
    p.add_argument("--no-cache", action="store_true", help="decide everything anew")
    p.add_argument("--no-crosscheck", action="store_true", help="simulate no runs beside proofs")
    p.add_argument("--lock", metavar="FILE", help="accepted findings (default: the nearest haverify.lock)")
    p.add_argument(
        "--grade",
        choices=("checked", "enclosed", "solver"),
        help="the weakest trust to accept: re-checked by hacheck, by enclosures, by a solver (default enclosed)",
    )


def _lint(commands: _Commands[argparse.ArgumentParser]) -> None:
    p = commands.add_parser("lint", help="findings only; no claim is decided")
    p.add_argument("files", nargs="+", metavar="FILE.ha", help="a spec")
    p.add_argument("--fix", action="store_true", help="apply the safe fixes")
    p.add_argument("--unsafe-fixes", action="store_true", help="apply proposed fixes too; read the difference")
    p.add_argument("--select", metavar="CODES", help="only findings whose code starts so: HA2,HA303")
    p.add_argument(
        "--format", choices=("text", "json", "sarif", "junit", "github"), help="what to print (default text)"
    )
    p.add_argument("--no-cache", action="store_true", help="let the rules look anew at a spec they have seen")
    p.add_argument("--lock", metavar="FILE", help="accepted findings (default: the nearest haverify.lock)")


def _accept(commands: _Commands[argparse.ArgumentParser]) -> None:
    p = _told(commands, "accept", _ACCEPT, help="record what is known in haverify.lock")
    p.add_argument("file", metavar="FILE.ha", help="a spec")
    p.add_argument("--reason", required=True, metavar="TEXT", help="why they are accepted")
    p.add_argument("--select", metavar="CODES", help="only findings whose code starts so, and no claims")
    p.add_argument("--lock", metavar="FILE", help="the file to write (default: the nearest, else beside the spec)")


def _fmt(commands: _Commands[argparse.ArgumentParser]) -> None:
    p = commands.add_parser("fmt", help="bring specs into the one layout")
    p.add_argument("files", nargs="+", metavar="FILE.ha", help="a spec")
    p.add_argument("--check", action="store_true", help="change nothing; exit code 1 if a file would change")
    p.add_argument("--diff", action="store_true", help="change nothing; print what would change")


def _expand(commands: _Commands[argparse.ArgumentParser]) -> None:
    p = commands.add_parser("expand", help="print the desugared core, itself valid .ha")
    p.add_argument("file", metavar="FILE.ha", help="a spec")


def _invent(commands: _Commands[argparse.ArgumentParser]) -> None:
    p = commands.add_parser("invent", help="find an invariant that implies a claim, and print it as .ha")
    p.add_argument("file", metavar="FILE.ha", help="a spec")
    p.add_argument("-p", "--property", metavar="NAME", help="the claim (default: all that are `always`)")
    p.add_argument("--seconds", type=float, default=40.0, metavar="N", help="CPU time for each claim (default 40)")


def _simulate(commands: _Commands[argparse.ArgumentParser]) -> None:
    p = _told(commands, "simulate", _SIMULATE, help="runs of an automaton: tables and drawings")
    p.add_argument("file", metavar="FILE.ha", help="a spec")
    p.add_argument("-a", "--automaton", metavar="NAME", help="the automaton or system (default: the first)")
    p.add_argument("-n", "--runs", type=int, default=1, metavar="RUNS", help="how many (default 1)")
    p.add_argument("--seed", type=int, default=0, metavar="N", help="what chance starts from (default 0)")
    p.add_argument("--until", default="10s", metavar="TIME", help="the horizon: 10s, 2min (default 10s)")
    p.add_argument(
        "--policy",
        choices=("earliest", "latest", "random"),
        default="earliest",
        help="when an edge that may wait is taken (default earliest)",
    )
    p.add_argument("--samples", type=int, default=200, metavar="N", help="instants in a table (default 200)")
    p.add_argument("--csv", metavar="PATH", help="write a table (- for standard output)")
    p.add_argument("--mot", metavar="PATH", help="write the angles in deg of the first run as an OpenSim motion")
    p.add_argument("--plot", metavar="PATH.svg", help="write a drawing")
    p.add_argument(
        "--kind",
        choices=("series", "phase", "field", "modes"),
        default="series",
        help="of what: quantities over time, an orbit, one with the vector field, the mode graph (default series)",
    )
    p.add_argument("--of", metavar="X,Y", help="the quantities to draw")
    p.add_argument("--mode", metavar="MODE", help="whose vector field (default: where the first run starts)")
    p.add_argument("--orbit", action="store_true", help="find the periodic orbit that the first run comes to")
    p.add_argument("--format", choices=("text", "json"), default="text", help="what to print (default text)")


def _falsify(commands: _Commands[argparse.ArgumentParser]) -> None:
    p = _told(commands, "falsify", _FALSIFY, _FALSIFY_MORE, help="search for runs that violate claims")
    p.add_argument("file", metavar="FILE.ha", help="a spec")
    p.add_argument("-p", "--property", metavar="NAME", help="one claim (or family) only")
    p.add_argument("-n", "--runs", type=int, default=2000, metavar="RUNS", help="the most for each goal (default 2000)")
    p.add_argument("--seed", type=int, default=0, metavar="N", help="what chance starts from (default 0)")
    p.add_argument(
        "--seconds", type=float, default=60.0, metavar="S", help="processor time for each goal's runs (default 60)"
    )
    p.add_argument("--until", default="10s", metavar="TIME", help="horizon of claims that state none (default 10s)")
    p.add_argument(
        "--policy",
        choices=("any", "earliest", "latest", "random"),
        default="any",
        help="when an edge that may wait is taken, if it is; random: by chance, any: by the search (default any)",
    )
    p.add_argument("--format", choices=("text", "json"), default="text", help="what to print (default text)")


def _explain(commands: _Commands[argparse.ArgumentParser]) -> None:
    p = commands.add_parser("explain", help="the manual page of a finding or of an analysis")
    p.add_argument("topic", metavar="CODE", help="a code (HA303) or an analysis (poly-range)")


def _recheck(commands: _Commands[argparse.ArgumentParser]) -> None:
    p = _told(commands, "recheck", _RECHECK, help="re-establish a report by the independent checker")
    p.add_argument("folder", metavar="DIR", help="a report folder, such as reports/gait")
    p.add_argument("--strict", action="store_true", help="refuse what is beyond the checker")


def _repair(commands: _Commands[argparse.ArgumentParser]) -> None:
    p = _told(commands, "repair", _REPAIR, _REPAIR_MORE, help="propose the smallest changes that mend a spec")
    p.add_argument("files", nargs="+", metavar="FILE.ha", help="a spec")
    p.add_argument("-p", "--property", metavar="NAME", help="look at one claim (or family) only")
    p.add_argument("--accepted", action="store_true", help="do not spare what haverify.lock or @allow accepts")
    p.add_argument("--budget", metavar="TIME", help="safety net for the search in the text (default 60s)")
    p.add_argument("--diff", action="store_true", help="print the changes as a difference for patch, nothing else")
    p.add_argument("--format", choices=("text", "json"), help="what to print (default text)")
    p.add_argument("--lock", metavar="FILE", help="accepted findings (default: the nearest haverify.lock)")


def _gate(commands: _Commands[argparse.ArgumentParser]) -> None:
    p = _told(commands, "gate", _GATE, help="the exit code of a report, and what changed since another")
    p.add_argument("report", metavar="REPORT.json", help="a report, or its folder")
    p.add_argument("--baseline", metavar="OLD.json", help="the report to compare with, or its folder")
    p.add_argument("--max-margin-loss", metavar="SHARE", help="how much of a margin may be lost: 5%% (default: any)")
    p.add_argument("--format", choices=("text", "json", "github"), help="what to print (default text)")


def _plot(commands: _Commands[argparse.ArgumentParser]) -> None:
    p = _told(commands, "plot", _PLOT, help="the figures of a report as SVG files")
    p.add_argument("report", metavar="REPORT.json", help="a report in its folder, or the folder")
    p.add_argument("-o", "--output", metavar="DIR", help="where they go (default: figures/ in the report folder)")
    p.add_argument("-p", "--property", metavar="NAME", help="those of one claim only")


def _replay(commands: _Commands[argparse.ArgumentParser]) -> None:
    p = _told(commands, "replay", _REPLAY, _REPLAY_MORE, help="judge a gait on a robot")
    p.add_argument("file", metavar="FILE", help="a spec")
    p.add_argument("--robot", required=True, metavar="DIR", help="the robot's folder, such as models/hoap2")
    p.add_argument("--map", metavar="MAP.toml", help="which output drives which joint (default: the robot's own)")
    p.add_argument("--speed", metavar="FACTOR", help="replay at this multiple of the gait's pace (default: the map's)")
    p.add_argument("--claims", action="store_true", help="print the summary of the claims about the joints too")
    p.add_argument("--meshcat", metavar="VIEW.html", help="a scene of MeshCat to turn and zoom (needs meshcat)")
    p.add_argument("--format", choices=("text", "json"), help="what to print (default text)")
    where = p.add_mutually_exclusive_group()
    where.add_argument("--report", metavar="DIR", help="where the report goes (default ./reports/<stem>-<robot>/)")
    where.add_argument("--no-report", action="store_true", help="keep no report")
    p.add_argument("--no-cache", action="store_true", help="decide everything anew")


def _fit(commands: _Commands[argparse.ArgumentParser]) -> None:
    p = _told(commands, "fit", _FIT, _FIT_MORE, help="gait recordings to a spec with tables")
    p.add_argument("files", nargs="+", metavar="DATA", help="recordings, and ground forces recorded with them")
    p.add_argument("-o", "--output", required=True, metavar="OUT.ha", help="the spec to write; tables go to OUT/")
    p.add_argument("--leg", choices=("left", "right"), help="whose heel strikes begin the cycle (default: more cycles)")
    p.add_argument("--order", type=int, choices=(0, 1, 2), help="derivatives without a step (default 1)")
    p.add_argument("--degree", type=int, metavar="N", help="of all polynomials (default: chosen for each joint)")
    p.add_argument("--bound", metavar="JOINT=LOW..HIGH", action="append", help="keep a joint there: knee=-130..1 (deg)")
    p.add_argument("--events", choices=("zeni", "velocity"), help="how strikes are seen without forces (default zeni)")
    p.add_argument("--angles", choices=("deg", "rad"), help="the unit of angles, against what the file says")
    p.add_argument(
        "--outliers", choices=("single", "drop", "keep"), help="samples that leap to leave out: lone ones, all, none"
    )
    p.add_argument("--held-out", metavar="DATA", action="append", help="a recording to claim it of, not fitted to")
    p.add_argument("--plot", metavar="PATH.svg", help="draw the curves; PATH_orbits, PATH_sticks too")


def _compare(commands: _Commands[argparse.ArgumentParser]) -> None:
    p = _told(commands, "compare", _COMPARE, help="recordings and automata beside each other")
    p.add_argument("files", nargs="+", metavar="WALK", help="a recording, a spec, or ground forces of a recording")
    p.add_argument("-a", "--automaton", metavar="NAME", help="of the specs (default: the first with six joints)")
    p.add_argument("--leg", choices=("left", "right"), help="whose heel strikes begin the cycle of recordings")
    p.add_argument("--angles", choices=("deg", "rad"), help="the unit of angles, against what the files say")
    p.add_argument("--plot", metavar="PATH.svg", help="draw all curves, percent by percent")
    p.add_argument("--osim", metavar="MODEL.osim", help="pose this model of OpenSim with all: paths of heels and mass")


def _init(commands: _Commands[argparse.ArgumentParser]) -> None:
    p = commands.add_parser("init", help="write a commented starter spec")
    p.add_argument("file", nargs="?", default="model.ha", metavar="FILE.ha", help="default model.ha")


def _doctor(commands: _Commands[argparse.ArgumentParser]) -> None:
    commands.add_parser("doctor", help="versions, and the kernel's rounding self-test")
