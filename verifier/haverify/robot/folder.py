"""A robot's folder: `robot.toml` names the URDF, the feet, their soles and the friction."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from fractions import Fraction
from pathlib import PurePosixPath
from typing import Any

from haverify.diagnostics.diagnostic import Diagnostic
from haverify.robot.body import Description, Robot, Sole
from haverify.robot.places import Entries, read_toml
from haverify.robot.urdf import read_urdf
from haverify.text.source import Source

Q = Fraction
Open = Callable[[str], tuple[str, Source | None]]  # path to why it cannot be read, or the text


def describe(folder: str, open_file: Open) -> tuple[Description | None, dict[str, Source], list[Diagnostic]]:
    """The robot of a folder, the files read, and what is wrong with them."""
    path = str(PurePosixPath(folder) / "robot.toml")
    problem, source = open_file(path)
    if source is None:
        return None, {}, [Diagnostic("HA006", f"cannot read {path}: {problem}")]
    entries = read_toml(source)
    sources = {source.path: source}
    if entries.found:
        return None, sources, entries.found
    _require(entries)
    if entries.found:
        return None, sources, entries.found
    name = str(PurePosixPath(folder) / entries.values["urdf"])
    problem, text = open_file(name)
    if text is None:
        entries.wrong("HA006", f"cannot read {name}: {problem}", "", "urdf")
        return None, sources, entries.found
    sources[text.path] = text
    robot, found = read_urdf(text)
    if robot is None:
        return None, sources, found
    for side in ("left", "right"):
        link = entries.values["feet"][side]
        if link not in robot.links:
            entries.wrong("HA002", f"no link {link} in {name}", "feet", side)
    if entries.found:
        return None, sources, entries.found
    return _described(entries.values, robot, folder, name), sources, []


def _described(v: Mapping[str, Any], robot: Robot, folder: str, urdf: str) -> Description:
    limits = v.get("limits", {})
    return Description(
        robot,
        urdf,
        {side: v["feet"][side] for side in ("left", "right")},
        Sole(_pair(v["sole"]["x"]), _pair(v["sole"]["y"]), Q(v["sole"]["z"])),
        Q(v["friction"]["coefficient"]),
        bool(limits.get("advice", False)),
        str(v.get("sources", {}).get(str(limits.get("source", "")), "")),
        str(PurePosixPath(folder) / v["map"]) if "map" in v else None,
    )


def _require(e: Entries) -> None:
    """Say what is missing or of another kind."""
    v = e.values
    if not isinstance(v.get("urdf"), str):
        e.wrong("HA210", "`urdf` is to name the file of the robot", "", "urdf")
    if "map" in v and not isinstance(v["map"], str):
        e.wrong("HA210", "`map` is to name a file", "", "map")
    for table in ("limits", "sources"):
        if not isinstance(v.get(table, {}), dict):
            e.wrong("HA210", f"`{table}` is to be a table", "", table)
    for side in ("left", "right"):
        if not isinstance(_within(v, "feet").get(side), str):
            e.wrong("HA210", f"[feet] is to name the link of the {side} foot", "feet", side)
    sole = _within(v, "sole")
    for key in ("x", "y"):
        pair = sole.get(key)
        if not (isinstance(pair, list) and len(pair) == 2 and all(map(is_number, pair)) and pair[0] < pair[1]):
            e.wrong("HA210", f"[sole] is to give {key} as two numbers in order, in m", "sole", key)
    if not is_number(sole.get("z")):
        e.wrong("HA210", "[sole] is to give the height z, in m", "sole", "z")
    friction = _within(v, "friction").get("coefficient")
    if friction is None or not is_number(friction) or friction <= 0:
        e.wrong("HA210", "[friction] is to give a positive coefficient", "friction", "coefficient")


def _within(v: Mapping[str, Any], table: str) -> dict[str, Any]:
    inner = v.get(table)
    return inner if isinstance(inner, dict) else {}


def is_number(value: object) -> bool:
    """Whether a value read from TOML is a finite number."""
    return isinstance(value, int | Fraction) and not isinstance(value, bool)


def _pair(values: list[Any]) -> tuple[Q, Q]:
    return Q(values[0]), Q(values[1])
