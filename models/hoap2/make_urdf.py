"""Make `hoap2.urdf` of the figures in `robot.toml`: `python models/hoap2/make_urdf.py`. Standard library only."""

from __future__ import annotations

import math
import tomllib
from pathlib import Path
from typing import Any

HERE = Path(__file__).parent
Table = dict[str, Any]

_HEAD = """\
<?xml version="1.0"?>
<!-- Made by make_urdf.py from robot.toml, where the source of every figure stands. -->
"""


def urdf(figures: Table) -> str:
    """The URDF: links, joints from the base outwards, and a fixed frame for each sole."""
    links = {link["name"]: link for link in figures["link"]}
    names = [figures["base"], *(j["child"] for j in figures["joint"])]
    parts = [_link(n, links[n] if n in links else mirrored(links["l" + n[1:]])) for n in names]
    parts += [_joint(j, figures["limits"]) for j in figures["joint"]]
    parts += [_sole(foot, figures["sole"]) for foot in figures["feet"].values()]
    return f'{_HEAD}<robot name="{figures["name"]}">\n{"".join(parts)}</robot>\n'


def mirrored(left: Table) -> Table:
    """The right twin of a left link: y, ixy and iyz change their sign."""
    x, y, z = left["com"]
    xx, yy, zz, xy, xz, yz = left["inertia"]
    return {**left, "com": [x, -y, z], "inertia": [xx, yy, zz, -xy, xz, -yz]}


def _link(name: str, link: Table) -> str:
    keys = ("ixx", "iyy", "izz", "ixy", "ixz", "iyz")
    inertia = " ".join(f'{k}="{_number(v)}"' for k, v in zip(keys, link["inertia"], strict=True))
    shapes = [(b["centre"], f'<box size="{_vector(b["size"])}"/>') for b in link.get("boxes", ())]
    shapes += [(s["centre"], f'<sphere radius="{_number(s["radius"])}"/>') for s in link.get("spheres", ())]
    return (
        f'  <link name="{name}">\n'
        f'    <inertial><origin xyz="{_vector(link["com"])}"/><mass value="{_number(link["mass"])}"/>'
        f"<inertia {inertia}/></inertial>\n"
        + "".join(
            f'    <collision><origin xyz="{_vector(at)}"/><geometry>{shape}</geometry></collision>\n'
            for at, shape in shapes
        )
        + "  </link>\n"
    )


def _joint(joint: Table, limits: Table) -> str:
    low, high = (math.radians(d) for d in joint["limits"])
    return (
        f'  <joint name="{joint["name"]}" type="revolute">'
        f'<parent link="{joint["parent"]}"/><child link="{joint["child"]}"/>\n'
        f'    <origin xyz="{_vector(joint["origin"])}"/><axis xyz="{_vector(joint["axis"])}"/>\n'
        f'    <limit lower="{low!r}" upper="{high!r}" velocity="{limits["velocity"]}" effort="{limits["effort"]}"/>\n'
        "  </joint>\n"
    )


def _sole(foot: str, sole: Table) -> str:
    """The pad under a foot; its frame lies on the ground, so that other tools find the sole."""
    name = foot.replace("foot", "sole")
    pad = {k: sole[f"pad_{k}"] for k in ("mass", "com", "inertia")}
    return _link(name, pad) + (
        f'  <joint name="{name}_fixed" type="fixed"><parent link="{foot}"/><child link="{name}"/>'
        f'<origin xyz="0 0 {_number(sole["z"])}"/></joint>\n'
    )


def _vector(values: list[float]) -> str:
    return " ".join(_number(v) for v in values)


def _number(value: float) -> str:
    text = f"{value:.12f}".rstrip("0").rstrip(".")
    return "0" if text == "-0" else text


if __name__ == "__main__":
    figures = tomllib.loads((HERE / "robot.toml").read_text(encoding="utf-8"))
    (HERE / figures["urdf"]).write_text(urdf(figures), encoding="utf-8")
