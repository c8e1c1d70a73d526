"""The moving robot as a scene of MeshCat, which must be installed: a page to turn and zoom, its viewer within."""

from __future__ import annotations

import contextlib
import io
from typing import TYPE_CHECKING, Any

from haverify.errors import UsageError
from haverify.robot.poses import Poses

if TYPE_CHECKING:
    from meshcat.animation import Animation  # only if it is installed

_COLOURS = {"l": 0x3B7EA1, "r": 0xD9730D, "": 0x8A94A6}
_HEIGHT, _SEEN_FROM = 0.25, [0.5, 0.2, 0.9]  # m: where one looks; forward, up, to the right of that


def require_meshcat() -> None:
    """Raise UsageError where MeshCat is not installed."""
    try:
        import meshcat.animation
        import meshcat.geometry
    except ImportError as e:
        raise UsageError("--meshcat needs MeshCat: pip install 'haverify[meshcat]'") from e
    assert meshcat.animation and meshcat.geometry, "both are used"


def scene(p: Poses) -> str:
    """A page that shows the shapes and moves them, in a loop, at the replay's own pace."""
    import meshcat
    from meshcat.transformations import translation_matrix

    with contextlib.redirect_stdout(io.StringIO()):  # it tells the address of a server
        viewer = meshcat.Visualizer()
    try:
        for k, s in enumerate(p.solids):
            viewer["robot"][str(k)].set_object(*_body(s.shape.is_ball, [float(x) for x in s.shape.size], s.link))
        viewer["/Cameras/default"].set_transform(translation_matrix([0.0, 0.0, _HEIGHT]))
        viewer["/Cameras/default/rotated/<object>"].set_property("position", _SEEN_FROM)
        viewer.set_animation(_moved(p, viewer), play=True, repetitions=1000)
        page: str = viewer.static_html()
    finally:
        viewer.window.server_proc.terminate()
        viewer.window.server_proc.wait()
    return page


def _body(is_ball: bool, size: list[float], link: str) -> tuple[Any, Any]:
    """A shape of some half-lengths (m), coloured by its side."""
    import meshcat.geometry as g

    shape = g.Sphere(size[0]) if is_ball else g.Box([2 * x for x in size])
    return shape, g.MeshLambertMaterial(color=_COLOURS.get(link.split("_")[0], _COLOURS[""]))


def _moved(p: Poses, viewer: Any) -> Animation:
    from meshcat.animation import Animation

    rate = (len(p.times) - 1) / (p.times[-1] - p.times[0])
    moved = Animation(default_framerate=rate)
    for n, placed in enumerate(p.placed):
        with moved.at_frame(viewer, n) as frame:
            for k, matrix in enumerate(placed):
                frame["robot"][str(k)].set_transform(matrix)
    return moved
