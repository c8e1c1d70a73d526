"""Robots from URDF: a tree of links with exact decimals; what is wrong with a file is said with its place.

Read are links with their inertia and joints that are revolute, continuous or fixed, without rotated frames (rpy 0).
"""

from __future__ import annotations

from collections.abc import Iterator
from fractions import Fraction
from xml.parsers import expat

from haverify.diagnostics.diagnostic import Diagnostic
from haverify.maths.exact import parse_decimal
from haverify.robot.body import Joint, Limits, Link, Robot, Shape, Vector, inertia_trouble
from haverify.text.record import field, holder
from haverify.text.source import Source
from haverify.text.span import Span

Q = Fraction
_DEEPEST = 40
_MOST = 100_000  # elements


@holder
class Element:
    """An element of the file with the place of its opening tag."""

    tag: str
    values: dict[str, str]
    span: Span
    children: list[Element] = field(default_factory=list)

    def child(self, tag: str) -> Element | None:
        """The first child of a name."""
        return next((c for c in self.children if c.tag == tag), None)

    def all(self, tag: str) -> Iterator[Element]:
        """The children of a name."""
        return (c for c in self.children if c.tag == tag)


class _Wrong(Exception):
    """A finding that ends the reading."""

    def __init__(self, code: str, message: str, span: Span, help: str | None = None) -> None:
        super().__init__(message)
        self.finding = Diagnostic(code, message, span, help=help)


def read_urdf(source: Source) -> tuple[Robot | None, list[Diagnostic]]:
    """The robot of a file, or what is wrong with the file."""
    try:
        robot = _robot(parsed(source))
    except _Wrong as e:
        return None, [e.finding]
    found = [
        Diagnostic("HA210", f"link {link.name} is no rigid body: {trouble}", link.span)
        for link in robot.links.values()
        if (trouble := inertia_trouble(link))
    ]
    return (None, found) if found else (robot, [])


def parsed(source: Source) -> Element:
    """The file's root element."""
    top = Element("", {}, Span(source.path, 0, 0))
    open_elements, count, passed = [top], [0], [0, 0]  # of what was read, bytes and code points
    reader = expat.ParserCreate()
    raw = source.text.encode()

    def start(tag: str, values: dict[str, str]) -> None:
        count[0] += 1
        passed[1] += len(raw[passed[0] : reader.CurrentByteIndex].decode())
        passed[0] = reader.CurrentByteIndex
        at = passed[1]
        end = source.text.find(">", at)
        made = Element(tag, values, Span(source.path, at, end + 1))
        if len(open_elements) > _DEEPEST or count[0] > _MOST:
            raise _Wrong("HA001", "too many elements, or too deep", made.span)
        open_elements[-1].children.append(made)
        open_elements.append(made)

    def doctype(*_: object) -> None:
        raise _Wrong("HA001", "a URDF declares no document type", Span(source.path, 0, len(source.line(1))))

    reader.StartElementHandler = start
    reader.EndElementHandler = lambda _: open_elements.pop()
    reader.StartDoctypeDeclHandler = doctype
    try:
        reader.Parse(raw, True)
    except expat.ExpatError as e:
        at = min(len(raw[: reader.ErrorByteIndex].decode(errors="ignore")), max(len(source.text) - 1, 0))
        words = expat.ErrorString(e.code)
        raise _Wrong("HA001", f"this is no XML: {words}", Span(source.path, at, at + 1)) from None
    return top.children[0]


def _robot(root: Element) -> Robot:
    if root.tag != "robot":
        raise _Wrong("HA001", f"expected <robot>, found <{root.tag}>", root.span)
    links = _named(root, "link")
    joints = _named(root, "joint")
    made = {name: _link(name, e) for name, e in links.items()}
    found = [_joint(name, e, made) for name, e in joints.items()]
    base, ordered = _tree(found, made, root)
    return Robot(root.values.get("name", ""), base, made, tuple(ordered))


def _named(root: Element, tag: str) -> dict[str, Element]:
    found: dict[str, Element] = {}
    for e in root.all(tag):
        name = _value(e, "name")
        if name in found:
            raise _Wrong("HA004", f"{tag} {name} is already defined", e.span)
        found[name] = e
    if not found:
        raise _Wrong("HA210", f"there is no <{tag}>", root.span)
    return found


def _link(name: str, e: Element) -> Link:
    inertial = e.child("inertial")
    if inertial is None:
        return Link(name, Q(0), (Q(0), Q(0), Q(0)), (Q(0),) * 6, e.span, _shapes(e))
    mass, inertia = inertial.child("mass"), inertial.child("inertia")
    if mass is None or inertia is None:
        raise _Wrong("HA210", f"link {name} has no <{'mass' if mass is None else 'inertia'}>", inertial.span)
    xx, yy, zz, xy, xz, yz = (_number(inertia, k) for k in ("ixx", "iyy", "izz", "ixy", "ixz", "iyz"))
    return Link(name, _number(mass, "value"), _origin(inertial), (xx, yy, zz, xy, xz, yz), e.span, _shapes(e))


def _shapes(e: Element) -> tuple[Shape, ...] | None:
    """Boxes and balls in the link's own axes; None where there is another one. What Pinocchio cannot read it says."""
    found = []
    for part in e.all("collision"):
        shape = part.child("geometry")
        box, ball = (shape.child(kind) if shape else None for kind in ("box", "sphere"))
        origin = part.child("origin")
        if (box or ball) is None or (origin and any(_vector(origin, "rpy") if "rpy" in origin.values else ())):
            return None
        if box:
            x, y, z = (size / 2 for size in _vector(box, "size"))
            found.append(Shape(False, (x, y, z), _origin(part)))
        elif ball:
            found.append(Shape(True, (_number(ball, "radius"),) * 3, _origin(part)))
    return tuple(found)


def _joint(name: str, e: Element, links: dict[str, Link]) -> Joint:
    kind = _value(e, "type")
    if kind not in ("revolute", "fixed"):
        raise _Wrong("HA210", f"joint {name} is of type {kind}; read are revolute and fixed", e.span)
    parent, child = (_end(e, side, name, links) for side in ("parent", "child"))
    if kind == "fixed":
        return Joint(name, parent, child, _origin(e), (Q(1), Q(0), Q(0)), None, e.span)
    axis = e.child("axis")
    direction = _vector(axis, "xyz") if axis else (Q(1), Q(0), Q(0))
    if sorted(abs(c) for c in direction) != [0, 0, 1]:
        raise _Wrong("HA210", f"the axis of joint {name} is none of x, y, z, or not of length 1", (axis or e).span)
    return Joint(name, parent, child, _origin(e), direction, _limits(name, e), e.span)


def _limits(name: str, e: Element) -> Limits:
    limit = e.child("limit")
    if limit is None:
        raise _Wrong(
            "HA210",
            f"joint {name} has no limits",
            e.span,
            '`<limit lower="-0.5" upper="0.5" velocity="5" effort="9"/>`, in rad, rad/s and N m',
        )
    lower, upper, velocity, effort = (_number(limit, k) for k in ("lower", "upper", "velocity", "effort"))
    if lower >= upper:
        raise _Wrong("HA201", f"joint {name}: the lower limit is not below the upper one", limit.span)
    if upper - lower > 13:
        turns = float((upper - lower) / Q("6.283185307"))
        raise _Wrong("HA101", f"the limits of joint {name} are {turns:.3g} turns apart: URDF counts in rad", limit.span)
    if velocity <= 0 or effort <= 0:
        raise _Wrong("HA210", f"joint {name}: its greatest speed and torque are to be positive", limit.span)
    return Limits(lower, upper, velocity, effort)


def _end(e: Element, side: str, name: str, links: dict[str, Link]) -> str:
    end = e.child(side)
    if end is None:
        raise _Wrong("HA210", f"joint {name} has no <{side}>", e.span)
    link = _value(end, "link")
    if link not in links:
        raise _Wrong("HA002", f"joint {name}: no link {link}", end.span)
    return link


def _tree(joints: list[Joint], links: dict[str, Link], root: Element) -> tuple[str, list[Joint]]:
    """The base, and the joints from it outwards."""
    children: dict[str, list[Joint]] = {}
    above: dict[str, Joint] = {}
    for j in joints:
        children.setdefault(j.parent, []).append(j)
        if j.child in above:
            raise _Wrong("HA004", f"link {j.child} has two parents, by {above[j.child].name} and {j.name}", _at(j))
        above[j.child] = j
    bases = [name for name in links if name not in above]
    ordered: list[Joint] = []
    pending = bases[:1]
    while pending:
        leaving = children.get(pending.pop(), [])
        ordered += leaving
        pending += [j.child for j in leaving[::-1]]
    if len(bases) != 1 or len(ordered) != len(joints):
        raise _Wrong("HA210", "the links are no tree with one base", root.span)
    return bases[0], ordered


def _at(j: Joint) -> Span:
    assert j.span is not None, "a joint that was read has a place"
    return j.span


def _origin(e: Element) -> Vector:
    origin = e.child("origin")
    if origin is None:
        return (Q(0), Q(0), Q(0))
    if "rpy" in origin.values and any(_vector(origin, "rpy")):
        raise _Wrong("HA210", "a rotated frame (rpy) is not read: turn the axes and inertias instead", origin.span)
    return _vector(origin, "xyz") if "xyz" in origin.values else (Q(0), Q(0), Q(0))


def _vector(e: Element, key: str) -> Vector:
    words = _value(e, key).split()
    if len(words) != 3:
        raise _Wrong("HA210", f"{key} of <{e.tag}> has {len(words)} numbers, not 3", e.span)
    x, y, z = (_decimal(w, key, e) for w in words)
    return (x, y, z)


def _number(e: Element, key: str) -> Q:
    return _decimal(_value(e, key), key, e)


def _decimal(word: str, key: str, e: Element) -> Q:
    value = parse_decimal(word)
    if value is None:
        raise _Wrong("HA210", f"{key} of <{e.tag}> is `{word[:40]}`, not a number", e.span)
    return value


def _value(e: Element, key: str) -> str:
    if key not in e.values:
        raise _Wrong("HA210", f"<{e.tag}> has no {key}", e.span)
    return e.values[key]
