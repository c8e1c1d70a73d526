"""Which output of a gait drives which joint of a robot, and how: read from a TOML file, checked against both."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from difflib import get_close_matches
from fractions import Fraction
from typing import Any

from haverify.diagnostics.diagnostic import Diagnostic, Severity
from haverify.robot.body import Robot
from haverify.robot.folder import is_number
from haverify.robot.places import Entries, read_toml
from haverify.text.record import record
from haverify.text.source import Source
from haverify.text.span import Span

Q = Fraction
SIDES = ("left", "right")
CURVE = "curve"
_KEYS = {
    "": (
        "automaton",
        "time",
        "joint",
        "posture",
        "stance",
        "sway",
        "limits",
        "tracking",
        "missing",
        "expect",
        "recording",
    ),
    "time": ("speed",),
    "joint": ("joint", "output", "unit", "sign", "amplitude", "offset"),
    "sway": ("roll", "left_ankle", "right_ankle", "left_hip", "right_hip"),
    "limits": ("acceleration", "penetration"),
    "tracking": ("kp", "kd", "tolerance"),
}

_LAW = {"kp": Q(400), "kd": Q(4), "tolerance": Q(2)}  # where [tracking] says nothing: a stiff geared motor


@record
class Drive:
    """A joint's angle: `factor * (sum of outputs) + offset`, outputs in `unit`, offset in deg; `span` is its place."""

    joint: str
    outputs: tuple[str, ...]
    unit: str  # deg or rad
    factor: Q
    offset: Q
    span: Span


@record
class Sway:
    """Both ankles roll by `roll` (deg): the legs lean over the stance foot. Both hips roll back. Joints by side."""

    roll: Q
    ankles: Mapping[str, str]
    hips: Mapping[str, str]


@record
class Servo:
    """The motors' law: `kp` (N m/rad), `kd` (N m s/rad), and how far a joint may be from what is asked (deg)."""

    kp: Q
    kd: Q
    tolerance: Q


@record
class Map:
    """A map: the automaton it is made for, drives, still joints (deg), the stance side of each mode, sway, speed."""

    automaton: str
    drives: tuple[Drive, ...]
    posture: Mapping[str, Q]
    stance: Mapping[str, str]
    sway: Sway | None
    speed: Q
    acceleration: Q | None  # rad/s^2
    recording: str | None  # path of the recording that the gait was made from, seen from the map's folder
    servo: Servo
    missing: Mapping[str, Q | None]  # deg, for an output that a recording lacks; None: a curve through what is there
    penetration: Q  # m, how far the swing sole may be below the ground
    expected: Mapping[str, str]  # checks that are known to be refuted, with the reason
    source: Source

    def drive(self, joint: str) -> Drive | None:
        """What drives a joint."""
        return next((d for d in self.drives if d.joint == joint), None)


def read_map(source: Source, robot: Robot) -> tuple[Map | None, list[Diagnostic]]:
    """A map as checked against the robot, or what is wrong with it."""
    e = read_toml(source)
    if e.found:
        return None, e.found
    _require_known_keys(e)
    if e.found:
        return None, e.found
    drives = _drives(e, robot)
    posture = _posture(e, robot, drives)
    sway = _sway(e, robot, drives, posture)
    speed = _positive(e, "time", "speed", Q(1))
    acceleration = _positive(e, "limits", "acceleration", None)
    recording = e.values.get("recording")
    if recording is not None and not isinstance(recording, str):
        e.wrong("HA210", "`recording` is to name a file", "", "recording")
    penetration = _positive(e, "limits", "penetration", None) or Q(0)
    law = [_positive(e, "tracking", key, value) or value for key, value in _LAW.items()]
    missing = _missing(e, drives)
    stance = _stance(e)
    expected = _expected(e)
    automaton = e.values.get("automaton")
    if not isinstance(automaton, str):
        e.wrong("HA210", '`automaton = "..."` is to name the automaton whose outputs are replayed', "", "automaton")
    if e.found or speed is None:
        return None, e.found
    return Map(
        str(automaton),
        drives,
        posture,
        stance,
        sway,
        speed,
        acceleration,
        recording,
        Servo(*law),
        missing,
        penetration,
        expected,
        source,
    ), []


def check_against(m: Map, outputs: Mapping[str, str | None], modes: Iterable[str]) -> list[Diagnostic]:
    """What a map says of outputs (with their units) and modes that the automaton does not have."""
    e = read_toml(m.source)
    for i, d in enumerate(m.drives):
        for name in d.outputs:
            if name not in outputs:
                hint = _close(name, outputs)
                e.wrong("HA002", f"no output `{name}` in automaton {m.automaton}{hint}", "joint", "output", i)
            elif outputs[name] != d.unit:
                unit = outputs[name] or "no unit"
                message = f"`{name}` is in {unit}, the map reads it in {d.unit}"
                e.wrong("HA101", message, "joint", "unit", i, f'`unit = "{unit}"`' if outputs[name] else "")
    known = list(modes)
    for mode in m.stance:
        if mode not in known:
            e.wrong("HA002", f"no mode {mode} in automaton {m.automaton}{_close(mode, known)}", "stance", mode)
    missing = [mode for mode in known if mode not in m.stance]
    if missing:
        e.wrong("HA210", f"[stance] names no foot for {', '.join(missing)}", "stance", help=f'`{missing[0]} = "left"`')
    return e.found


def _require_known_keys(e: Entries) -> None:
    for key in e.values:
        if key not in _KEYS[""]:
            e.wrong("HA002", f"no entry `{key}` in a map{_close(key, _KEYS[''])}", "", key)
    for table in ("time", "posture", "stance", "sway", "limits", "tracking", "missing", "expect"):
        inner = e.values.get(table, {})
        if not isinstance(inner, dict):
            e.wrong("HA210", f"`{table}` is to be a table", "", table)
            continue
        for key in inner:
            if table in _KEYS and key not in _KEYS[table]:
                e.wrong("HA002", f"no entry `{key}` in [{table}]{_close(key, _KEYS[table])}", table, key)
    rows = e.values.get("joint", [])
    if not isinstance(rows, list) or not rows or not all(isinstance(r, dict) for r in rows):
        e.wrong("HA210", "a map has tables [[joint]], one for each joint that moves", "joint")
        return
    for i, row in enumerate(rows):
        for key in row:
            if key not in _KEYS["joint"]:
                e.wrong("HA002", f"no entry `{key}` in [[joint]]{_close(key, _KEYS['joint'])}", "joint", key, i)


def _drives(e: Entries, robot: Robot) -> tuple[Drive, ...]:
    found: list[Drive] = []
    for i, row in enumerate(e.values["joint"]):
        joint, output, unit = row.get("joint"), row.get("output"), row.get("unit")
        if not isinstance(joint, str) or joint not in robot.hinges:
            hint = _close(str(joint), robot.hinges)
            e.wrong("HA002", f"the robot {robot.name} has no joint {joint}{hint}", "joint", "joint", i)
        elif any(d.joint == joint for d in found):
            e.wrong("HA004", f"joint {joint} is driven twice", "joint", "joint", i)
        if not isinstance(output, str) or not all(_outputs(output)):
            e.wrong(
                "HA210", "`output` is to name what drives the joint: `lh`, or a sum `lh + lk`", "joint", "output", i
            )
        if unit is None:
            e.wrong("HA106", f"nothing says in which unit `{output}` is", "joint", "output", i, '`unit = "deg"`')
        elif unit not in ("deg", "rad"):
            e.wrong("HA101", f"`{unit}` is no unit of an angle", "joint", "unit", i, '`unit = "deg"`')
        if row.get("sign") not in (1, -1):
            e.wrong("HA210", "`sign` is to be 1 or -1", "joint", "sign", i)
        numbers = {}
        for key, default in (("amplitude", 1), ("offset", 0)):
            value = row.get(key, default)
            numbers[key] = Q(value) if is_number(value) else Q(0)
            if not is_number(value):
                e.wrong("HA210", f"`{key}` is to be a number", "joint", key, i)
        if unit == "rad" and numbers["offset"]:
            message = "an offset counts in deg, and this output in rad: put the offset into the gait"
            e.wrong("HA101", message, "joint", "offset", i)
        if not e.found:
            factor = Q(row["sign"]) * numbers["amplitude"]
            found.append(
                Drive(
                    str(joint), _outputs(str(output)), str(unit), factor, numbers["offset"], e.at("joint", "joint", i)
                )
            )
    return tuple(found)


def _outputs(text: str) -> tuple[str, ...]:
    """The outputs of a sum; what is no name is empty."""
    words = [word.strip() for word in text.split("+")]
    return tuple(word if word.isidentifier() else "" for word in words)


def _posture(e: Entries, robot: Robot, drives: tuple[Drive, ...]) -> dict[str, Q]:
    found: dict[str, Q] = {}
    for name, value in e.values.get("posture", {}).items():
        if name not in robot.hinges:
            e.wrong("HA002", f"the robot has no joint {name}{_close(name, robot.hinges)}", "posture", name)
        elif any(d.joint == name for d in drives):
            e.wrong("HA004", f"joint {name} stands still here, and is driven above", "posture", name)
        elif not is_number(value):
            e.wrong("HA210", f"{name} is to be a number of degrees", "posture", name)
        else:
            found[name] = Q(value)
            _require_within(e, robot, name, Q(value), ("posture", name))
    missing = [n for n in robot.hinges if n not in found and all(d.joint != n for d in drives)]
    if missing and not e.found:
        more = f" and {len(missing) - 4} more" if len(missing) > 4 else ""
        message = f"nothing says what {', '.join(missing[:4])}{more} do{'es' if len(missing) == 1 else ''}"
        e.wrong("HA210", message, "posture", help=f"`{missing[0]} = 0` in [posture]")
    return found


def _require_within(e: Entries, robot: Robot, name: str, angle: Q, entry: tuple[str, str]) -> None:
    limits = robot.hinges[name].limits
    assert limits is not None, "a hinge has limits"
    low, high = (float(r) * 57.29577951308232 for r in (limits.lower, limits.upper))
    if not low - 1e-9 <= angle <= high + 1e-9:
        message = f"{name} at {float(angle):g} deg is outside its limits, {low:g} deg .. {high:g} deg"
        e.found.append(Diagnostic("HA108", message, e.at(*entry), severity=Severity.ERROR))


def _stance(e: Entries) -> dict[str, str]:
    found = {}
    for mode, side in e.values.get("stance", {}).items():
        if side not in SIDES:
            e.wrong("HA210", f'the stance foot of {mode} is "left" or "right"', "stance", mode)
        else:
            found[mode] = side
    return found


def _sway(e: Entries, robot: Robot, drives: tuple[Drive, ...], posture: Mapping[str, Q]) -> Sway | None:
    table: dict[str, Any] = e.values.get("sway", {})
    if not table:
        return None
    if not is_number(table.get("roll")):
        e.wrong("HA210", "[sway] is to give `roll`, in deg", "sway", "roll")
    for side in SIDES:
        for part in ("ankle", "hip"):
            name = table.get(f"{side}_{part}")
            if not isinstance(name, str) or name not in robot.hinges:
                e.wrong("HA002", f"the robot has no joint {name}", "sway", f"{side}_{part}")
            elif any(d.joint == name for d in drives):
                e.wrong("HA004", f"{name} sways here, and is driven above", "sway", f"{side}_{part}")
    if e.found:
        return None
    for name in (table[f"{side}_{part}"] for side in SIDES for part in ("ankle", "hip")):
        for lean in (Q(table["roll"]), -Q(table["roll"])):
            _require_within(e, robot, name, posture.get(name, Q(0)) + lean, ("sway", "roll"))
    ankles, hips = ({side: str(table[f"{side}_{part}"]) for side in SIDES} for part in ("ankle", "hip"))
    return Sway(Q(table["roll"]), ankles, hips)


def _missing(e: Entries, drives: tuple[Drive, ...]) -> dict[str, Q | None]:
    found: dict[str, Q | None] = {}
    known = {name for d in drives for name in d.outputs}
    for name, value in e.values.get("missing", {}).items():
        if name not in known:
            e.wrong("HA002", f"`{name}` drives no joint{_close(name, known)}", "missing", name)
        elif is_number(value) or value == CURVE:
            found[name] = None if value == CURVE else Q(value)
        else:
            e.wrong(
                "HA210", f'`{name}` is to be an angle in deg, or "{CURVE}" for one through its samples', "missing", name
            )
    return found


def _expected(e: Entries) -> dict[str, str]:
    found = {}
    for check, reason in e.values.get("expect", {}).items():
        if isinstance(reason, str) and reason:
            found[check] = reason
        else:
            e.wrong("HA210", f'{check} = "why it is known to be refuted"', "expect", check)
    return found


def _positive(e: Entries, table: str, key: str, default: Q | None) -> Q | None:
    value = e.values.get(table, {}).get(key, default)
    if value is None or (is_number(value) and value > 0):
        return None if value is None else Q(value)
    e.wrong("HA210", f"`{key}` is to be a positive number", table, key)
    return default


def _close(name: str, known: Iterable[str]) -> str:
    found = get_close_matches(name, list(known), 1)
    return f"; did you mean {found[0]}?" if found else ""
