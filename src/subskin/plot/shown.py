"""What fingers, skins and estimates draw of themselves: the figures behind their `plot`."""

from __future__ import annotations

from typing import Any

import numpy as np
import numpy.typing as npt
from matplotlib.figure import Figure

from .. import _check
from ..contact import Contact, LocalContact
from ..errors import GeometryError, InvalidValueError
from ..estimate import Estimate
from ..finger import Finger
from ..loads import Load
from ..skin import Skin
from . import pieces
from .above import area_map, finger_above
from .section import cut_open, draw_found, finger_section, window_of
from .strips import contact_strip
from .style import MM, SINGLE, Ink, finished, legend, new_figure, single
from .truth import truth_above, truth_against_estimate

__all__ = ["estimate_figure", "field_map", "finger_figure"]

_REACH = 4.0
"""How far a map reaches beyond a contact, in half widths of it, where nothing else says."""

_NEAR = 50.0
"""A rival whose chi-square is worse by more is not drawn."""


def finger_figure(
    finger: Finger,
    contact: Contact | LocalContact | None = None,
    estimate: Estimate | Load | None = None,
    **options: Any,
) -> Figure:
    """The finger cut open, to scale, and from above where its sensors or the touch are on an area; `finger.plot()` too.

    Parameters
    ----------
    finger : Finger
        The skin and its sensors.
    contact : Contact or LocalContact, optional
        What presses: its field is drawn too, as `finger_section` draws it, a local one's as `finger_above`.
    estimate, **options
        As in these.

    Raises
    ------
    InvalidValueError, GeometryError
        As in `finger_section`; options without contact and estimate.

    Examples
    --------
    >>> import subskin as ss
    >>> finger = ss.Finger(ss.HalfPlane(ss.Material(young=0.4e6)), ss.SensorArray.line(count=4, pitch=2e-3, depth=2e-3))
    >>> finger.plot().axes[0].get_ylabel()
    'depth x [mm]'
    """
    found = None if estimate is None or isinstance(estimate, Load) else estimate
    point = isinstance(estimate, Load) or (found is not None and found.load.dim == 2)
    if point or isinstance(contact, LocalContact) or (finger.array.on_area and contact is None):
        return finger_above(finger, contact, estimate, **options)
    if contact is not None or found is not None:
        return finger_section(finger, contact, found, **options)
    if options:
        rule = "there is nothing that presses to draw it of"
        raise InvalidValueError(", ".join(options), rule, "finger.plot(ss.LineLoad(force=40.0))")
    return cut_open(finger.skin, window_of(finger, []), finger=finger)


def field_map(
    skin: Skin,
    contact: Contact | LocalContact,
    component: str = "stress.xx",
    *,
    span: tuple[float, float] | None = None,
    depth: float | None = None,
) -> Figure:
    """A map of the stress or strain that a contact makes in a skin, to scale; as `skin.plot(contact)` too.

    Parameters
    ----------
    skin : Skin
        What is pressed.
    contact : Contact or LocalContact
        What presses; a single contact, not a batch. A local one's field is drawn from above and in section.
    component : str, optional
        What is drawn, a name of `COMPONENTS`: "stress.xx", "strain.xx", "mean_pressure", ...
    span : (float, float), optional
        Ends of the map along the surface, y [m].
    depth : float, optional
        How deep the map reaches [m]; half of its width, or the thickness of the skin, if left out.

    Raises
    ------
    InvalidValueError, GeometryError
        An unknown component, ends out of order, a depth not in the skin, a batch of contacts.

    Examples
    --------
    >>> import subskin as ss
    >>> skin = ss.HalfPlane(ss.Material(young=0.4e6))
    >>> figure = skin.plot(ss.Hertz(force=40.0, half_width=1e-3), "mean_pressure")
    >>> figure.axes[1].get_ylabel()
    'mean pressure [kPa]'
    """
    if isinstance(contact, LocalContact):
        return area_map(skin, contact, component, span, depth)
    chosen = pieces.component_of(component)
    single("contact", contact.shape)
    left, right = _check.ends("span", span, "span=(-5e-3, 5e-3)") or _around(contact, skin)
    if not left < right:
        raise InvalidValueError(f"span = {span!r}", "has to ascend", "span=(-5e-3, 5e-3)")
    usual = min(0.5 * (right - left), skin.thickness)
    most = float(skin.thickness)
    bottom = usual if depth is None else _check.scalar("depth", depth, unit="m", above=0.0, at_most=most)
    window = MM * left, MM * right, MM * bottom
    return cut_open(skin, window, contact, chosen, near=0.08 * MM * bottom, room=0.35)


def _around(contact: Contact, skin: Skin) -> tuple[float, float]:
    """The ends of a map about a contact [m]."""
    low, high = (float(np.asarray(end)) for end in contact.support)
    half = 0.5 * (high - low)
    reach = _REACH * half if half > 0 else min(float(skin.thickness), 5e-3)
    return low - reach, high + reach


def estimate_figure(
    found: Estimate, finger: Finger | None = None, *, truth: npt.ArrayLike | None = None, origin: float = 0.0
) -> Figure:
    """What was found: of a single frame the load and its errors, of many one beside the other; as `found.plot()` too.

    Parameters
    ----------
    found : Estimate, shape () or (m,)
        Of a frame, or of frames in the order of time.
    finger : Finger, optional
        The finger of a single frame: it is drawn too, with the field of the load that was found. Of many frames on an
        area its sensors are drawn.
    truth : array_like, shape (m,) or (m, 2), optional
        True positions [m], against which those found are drawn; of touches on an area (y, z), seen from above.
    origin : float, optional
        The finger's y = 0 on the axis of the figure [m]; of many frames.

    Raises
    ------
    GeometryError
        Frames that are not in a row; a finger or a frame that does not go with the others.

    Examples
    --------
    >>> import numpy as np, subskin as ss
    >>> array = ss.SensorArray.line(count=6, pitch=1.5e-3, depth=2e-3, noise=1e-4)
    >>> finger = ss.Finger(ss.HalfPlane(ss.Material(young=0.4e6)), array)
    >>> found = finger.locate(finger.read(ss.LineLoad(force=40.0, position=[0.0, 1e-3])))
    >>> [axes.get_ylabel() for axes in found.plot().axes]
    ['position along the skin, $y$ [mm]', 'force [N/m]']
    """
    if found.layout.dim == 2 and (finger is None or found.shape):
        frames = found if found.shape else found[None]
        square = frames.table[:, frames.layout.square[:2, :2]]
        sensors = None if finger is None else finger.array.points
        more: dict[str, Any] = {"covariance": square, "sensors": sensors, "outlines": frames.corners}
        return truth_above(frames.position, truth, status=frames.status, **more)
    if truth is not None:
        where = _check.real("truth", truth, unit="m") - origin
        return truth_against_estimate(np.atleast_1d(where), found if found.shape else found[None])
    if found.shape:
        if finger is not None:
            raise GeometryError(f"frames of shape {found.shape}", "a finger goes with a single frame", "found[0]")
        return contact_strip(found, origin=origin)
    if finger is not None:
        return finger_figure(finger, estimate=found)
    return _single(found)


@finished
def _single(found: Estimate) -> Figure:
    """The load of one frame on the surface, with its 95 % errors and the rival."""
    if not np.isfinite(found.force):
        raise GeometryError("a frame without a load", "there is nothing to draw", "found[found.ok]")
    figure = new_figure(SINGLE, 52.0)
    axes = figure.subplots()
    second = found.second
    centre, rival = MM * float(found.position), MM * float(second.position)
    half = 4.0 * MM * float(found.std[0])
    near = np.isfinite(rival) and float(second.chi2) < _NEAR
    reach = max(1.3 * abs(rival - centre) if near else 0.0, half, 1.0)
    top = 0.6 * reach
    draw_found(axes, found, pieces.Scale(top, float(found.force), 0.7), "\n")
    if near:
        force, worse = f"{float(second.force):.3g} {found.force_unit}", f"chi-square {float(second.chi2):.3g} worse"
        text = f"rival: {force} at y = {rival:.2f} mm, {worse}"
        axes.plot([rival], [0.0], "v", color=Ink.GREY, markersize=6, label=text, clip_on=False)
    axes.axhline(0.0, color=Ink.BLACK, linewidth=0.9)
    axes.set(xlim=(centre - reach, centre + reach), ylim=(0.12 * top, -1.1 * top))
    axes.set_aspect("equal")
    axes.set_yticks([])
    for side in ("left", "top", "right"):
        axes.spines[side].set_visible(False)
    axes.set_xlabel("position along the skin y [mm]")
    legend(figure, axes)
    return figure
