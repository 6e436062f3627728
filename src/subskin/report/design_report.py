"""The report of a design study: what was wanted, what to build, why, and what it will do."""

from __future__ import annotations

import numpy as np

from .. import __version__
from ..contact import LineLoad
from ..design import sensor_density, spatial_response
from ..design.finger_table import finger_table, legend_of
from ..design.search import DesignedFinger, DesignStudy
from ..design.tolerance import SOURCES, ToleranceBudget
from ..design.two_point import AreaLimen
from ..design.words import (
    amount_in_words,
    force_in_words,
    in_words,
    reasons_of,
    remedies_of,
    row_in_words,
    tolerances_of,
    unit_of,
    usual_goals_of,
    verdict_of,
)
from ..plot import (
    design_map_figure,
    finger_above,
    finger_section,
    placement_figure,
    response_figure,
    tolerance_figure,
    two_point_figure,
)
from .document import Block, Bullets, Document, Heading, Listing, Paragraph, Picture, TextTable

__all__ = ["design_report"]

_MAP = (
    "Left: every depth and pitch of the grid with as many sensors as finger 1. The colour is the largest ratio of "
    "error to goal. Within the line all goals of the search are met; grey has no room. The ring is finger 1, refined "
    "beyond the grid. Right: the best of the grid for each count, of every kind and skin, and finger 1 (ring). The "
    "grid counts noise alone; tolerances and the distance of two touches are added afterwards."
)
_LINE_LIMIT = "Loads are lines across the finger, of the weakest force stated; wider contacts are located less well."
_AREA_LIMIT = "Touches are local, of the weakest force and the radius stated; points where none is stated."
_FITTED = {"line": "line loads", "point": "loads on points", "round_hertz": "balls (round_hertz)"}
_LIMITS = (
    "The skin is linearly elastic, and strains are small.",
    "Noise is independent from sensor to sensor. Errors are Cramér-Rao bounds for one frame, which locate reaches.",
    "Nothing here was tuned on a recording: calibrate the finger that was made before relying on it.",
)


def design_report(study: DesignStudy, goals_text: str) -> Document:
    """What was wanted, what to build, why, and what it will do.

    Parameters
    ----------
    study : DesignStudy
        From `subskin.design.rank_fingers`.
    goals_text : str
        The goals as they were written, to be shown at the end.

    Examples
    --------
    >>> file = load_goals("goals.toml")  # doctest: +SKIP
    >>> study = rank_fingers(search_grid(file.goals))  # doctest: +SKIP
    >>> page = as_html(design_report(study, file.text))  # doctest: +SKIP
    """
    goals, best = study.goals, study.fingers[0]
    columns, rows, left = finger_table(study)
    blocks: list[Block] = [Heading("What to build"), Paragraph(_verdict(study), lead=True)]
    would = remedies_of(study)
    blocks += [Heading("What would do", 2), Bullets(would)] if would else []
    said = " ".join(filter(None, (tolerances_of(study), usual_goals_of(study))))
    blocks += [Paragraph(said), _checks(study, best)]
    blocks += [_section(study, best), Heading("The fingers"), Paragraph(_ranked(study))]
    blocks += [
        TextTable(columns, rows, legend_of(study), left, frozenset({0})),
        Picture(design_map_figure(study), _MAP),
    ]
    names = [_name(study, finger) for finger in study.fingers]
    blocks += [Heading("Why finger 1"), Bullets(reasons_of(study, best.row))]
    if len(names) > 1:
        blocks.append(Heading("The others", 2))
        others = zip(study.fingers[1:], names[1:], strict=True)
        blocks.append(
            Bullets([f"Finger {i}: {n}. {reasons_of(study, f.row)[0]}" for i, (f, n) in enumerate(others, 2)])
        )
    blocks += [Heading("Resolution and ambiguity"), Paragraph(_resolution(best))]
    for rank, (finger, name) in enumerate(zip(study.fingers, names, strict=True), start=1):
        blocks.append(Picture(placement_figure(finger.quality), f"Finger {rank}. {name}."))
    blocks += [*_tolerances(study, best), *_unopposed(best), *_two_points(best)]
    blocks += [] if goals.on_area else _filter(best)
    blocks += _provenance(study, goals_text)
    subtitle = f"subskin {__version__}, seed {goals.effort.seed}, {study.grid.excess.size:,} designs tried"
    return Document(f"{goals.title}: a design", subtitle, blocks)


def _name(study: DesignStudy, finger: DesignedFinger) -> str:
    return row_in_words(study.goals, finger.row)


def _verdict(study: DesignStudy) -> str:
    best = study.fingers[0]
    first = f"{_name(study, best)}. {verdict_of(study)}"
    return first if best.meets else f"No finger within the limits meets every goal. The nearest: {first}"


def _checks(study: DesignStudy, finger: DesignedFinger) -> TextTable:
    both = finger.outcome is not None
    rows = [
        [
            check.criterion.label,
            "met" if judged.ratio <= 1 else "missed",
            in_words(check.criterion.wanted, check.criterion.unit),
            in_words(check.value, check.criterion.unit),
            *([in_words(made.value, check.criterion.unit)] if both else []),
            f"{judged.ratio:.2f}" if np.isfinite(judged.ratio) else "∞",
        ]
        for check, made, judged in zip(finger.calibrated, finger.as_made, finger.checks, strict=True)
    ]
    columns = ["wanted", "", "at most", *(["calibrated", "as made"] if both else ["finger 1"]), "ratio"]
    caption = "What was wanted, and what finger 1 does."
    if both:
        judged = "as made" if study.goals.accuracy.calibrated == "none" else "calibrated"
        caption += f" Errors hold noise and tolerances. Ratio, met and missed are those of the finger {judged}."
    return TextTable(columns, rows, caption, left=2)


def _section(study: DesignStudy, finger: DesignedFinger) -> Picture:
    """Under a touch as good as any: the weakest force, half-way out in its angle, off the sensors."""
    touches = study.goals.touches
    if study.goals.on_area:
        return _above(study, finger)
    touch = LineLoad(touches.force, 0.5 * touches.cone, 0.3 * finger.row.pitch)
    readings = finger.finger.read(touch, rng=np.random.default_rng(study.goals.effort.seed))
    found = finger.finger.locate(readings, load="line", search=finger.quality.search, friction=touches.friction)
    component = study.goals.choices[finger.row.sensor].kinds[0].transducer.component
    return Picture(
        finger_section(finger.finger, touch, readings=readings, estimate=found, component=component),
        f"Finger 1 under its weakest touch, {force_in_words(touches)} at {in_words(0.5 * touches.cone, 'rad')}, with "
        "one frame of noisy readings, and the load found from them with its 95 % interval.",
    )


def _above(study: DesignStudy, finger: DesignedFinger) -> Picture:
    """The same on an area, off its middle and its axes."""
    touches, lean = study.goals.touches, 0.5 * study.goals.touches.cone
    force = touches.force * np.array([np.cos(lean), np.sin(lean) * np.cos(0.6), np.sin(lean) * np.sin(0.6)])
    middle, reach = np.mean(np.asarray(touches.area), axis=1), np.ptp(np.asarray(touches.area), axis=1)
    touch = touches.contact(force, middle + np.array([0.17, -0.11]) * reach)
    readings = finger.finger.read(touch, rng=np.random.default_rng(study.goals.effort.seed))
    family = "line" if touches.half_width is None else "round_hertz"
    caption = f"Finger 1 under its weakest touch, {force_in_words(touches)} at {in_words(lean, 'rad')}"
    if not finger.finger.array.on_area:  # a row takes touches for lines
        return Picture(finger_above(finger.finger, touch), f"{caption}.")
    found = finger.finger.fit(readings, family, search=finger.quality.search, friction=touches.friction)
    return Picture(
        finger_above(finger.finger, touch, found),
        f"{caption}, and the load found from one frame of noisy readings with its 95 % ellipse.",
    )


def _ranked(study: DesignStudy) -> str:
    judged = f"{study.grid.excess.size:,} designs, each by {study.goals.counted:,} touches"
    met = any(finger.meets for finger in study.fingers)
    first = "Those that meet the goals come first, the fewest sensors first." if met else ""
    each = "layout" if study.goals.on_area else "count"
    return f"The best of {judged}: at most one for each skin, kind and {each}. {first}".rstrip()


def _resolution(finger: DesignedFinger) -> str:
    values = finger.values
    if finger.quality.touches.dim == 2:
        return (
            "The maps show the standard errors over the area that is touched, at the weakest force, from noise alone, "
            "of the loads that 95 % of those at a position do not exceed. Within a red line touches are ambiguous. For "
            f"finger 1 the error of the position is {in_words(values['position_mean'], 'm')} on average, in the "
            f"direction in which it is worst, and that of the force {in_words(values['force_mean'], '')}. In "
            f"{in_words(values['ambiguous'], '')} of the touches another load explains the readings nearly as well and "
            f"locate says so; in {in_words(values['wrong'], '')} of them noise makes that other load the better one."
        )
    return (
        "The maps show the standard error of position and angle over those of the touch, at "
        f"the weakest force, from noise alone. For finger 1 it is {in_words(values['position_mean'], 'm')} and "
        f"{in_words(values['angle_mean'], 'rad')} on average, {in_words(values['position_worst'], 'm')} and "
        f"{in_words(values['angle_worst'], 'rad')} at its worst. In {in_words(values['ambiguous'], '')} of the touches "
        "another load explains the readings nearly as well and locate says so; "
        f"in {in_words(values['wrong'], '')} of them noise makes that other load the better one."
    )


def _tolerances(study: DesignStudy, finger: DesignedFinger) -> list[Block]:
    budget = finger.budget
    if budget is None:
        return []
    unit = unit_of(study.goals, finger.row)
    rows = [
        [
            SOURCES[cost.source].text if cost.source in SOURCES else "all of them at once",
            amount_in_words(cost.source, cost.amount, unit) if np.isfinite(cost.amount) else "",
            *(in_words(cost.position_rms, "m"), in_words(cost.angle_rms, "rad")),
            *(in_words(cost.force_rms, ""), in_words(cost.lost, "")),
        ]
        for cost in (*budget.rows, budget.together)
    ]
    accuracy = study.goals.accuracy
    return [
        Heading("Tolerances"),
        Paragraph(
            "What each source of error costs by itself, before finger 1 is calibrated: it is read as if it had been "
            "made exactly. Errors are root mean squares over the touches. Lost is the share of frames that are no "
            "longer OK: they are ambiguous, or no load explains them."
        ),
        TextTable(["source", "amount", "position", "angle", "force", "lost"], rows, strong=frozenset({len(rows) - 1})),
        Picture(
            tolerance_figure(budget, position=accuracy.position, angle=accuracy.angle),
            "The same: bars are root mean squares, and what is wanted is for 95 % of the touches. What calibrating on "
            f"touches at known positions wins back: {_command(study, budget)}",
        ),
    ]


def _command(study: DesignStudy, budget: ToleranceBudget) -> str:
    amounts = {cost.source: cost.amount for cost in budget.rows if cost.source != "noise"}
    given = " ".join(f"--{source} {amount:g}" for source, amount in amounts.items())
    only, touches = ",".join([*amounts, "noise"]), study.goals.touches
    where = ""
    if touches.area is not None:
        where = f'--area "{", ".join(f"{1e3 * high - 1e3 * low:g} mm" for low, high in touches.area)}" '
        where += "" if touches.half_width is None else f"--half-width {touches.half_width:g} "
    force = f"--force {touches.force:g}"
    return f"subskin tolerances finger_1.toml {force} {where}{given} --only {only} --calibrate known"


def _unopposed(finger: DesignedFinger) -> list[Block]:
    found = finger.unopposed
    if found is None:
        return []
    rows = [[row.text, *(in_words(share, "") for share in (row.ok, row.wrong, row.unexplained))] for row in found.rows]
    return [
        Heading("What it cannot object to"),
        Paragraph(
            f"{found.sentence} A status objects with readings that are left over when the unknowns are found. The "
            "table has readings outside the model, and how finger 1 answers them."
        ),
        TextTable(
            ["readings from", "OK", "OK and wrong", "unexplained"],
            rows,
            f"Shares of {found.count} touches of each kind, by a fit of {_FITTED.get(found.family, found.family)}. "
            "Wrong: the position is off by more than 5 standard errors or 0.3 depths. The rest is ambiguous or not "
            "noticed.",
        ),
    ]


def _two_points(finger: DesignedFinger) -> list[Block]:
    if finger.two_points is None:
        return []
    if isinstance(finger.two_points, AreaLimen):
        text = (
            "Two touches share the weakest force and press straight down, side by side in any direction. 95 % of such "
            f"pairs, in 90 % of frames at 1 % of false alarms, do not read like a single one {_from(finger.point)}."
        )
        return [Heading("Two touches, or one"), Paragraph(text)]
    return [
        Heading("Two touches, or one"),
        Paragraph(
            "Two touches share the weakest force, at any two angles in the cone. 95 % of such pairs, in 90 % of frames "
            f"at 1 % of false alarms, do not read like a single line load {_from(finger.point)}, and not like a single "
            f"wide contact {_from(finger.wide)}."
        ),
        Picture(
            two_point_figure(finger.two_points),
            "Least distance at which two touches read as two with finger 1, and how surely.",
        ),
    ]


def _from(distance: float) -> str:
    return f"from {in_words(distance, 'm')} apart" if np.isfinite(distance) else "not at any distance that was tried"


def _filter(finger: DesignedFinger) -> list[Block]:
    found = spatial_response(finger.finger)
    dense = float(np.nanmin(sensor_density(finger.finger, 100.0).error_pitch))
    return [
        Heading("The skin as a filter"),
        Paragraph(
            "How strongly finger 1 answers waves of pressure and of shear along its surface. To recover any pattern of "
            f"them to 1 % of full scale its sensors would have to stand {in_words(dense, 'm')} apart; they stand "
            f"{in_words(finger.row.pitch, 'm')} apart. A load of known shape is located far more finely than that."
        ),
        Picture(response_figure(found), "Reading under a wave of unit pressure or shear, by its frequency."),
    ]


def _provenance(study: DesignStudy, goals_text: str) -> list[Block]:
    effort, area = study.goals.effort, study.goals.on_area
    kinds = "kind of sensor, skin and layout" if area else "kind of sensor, skin and count"
    return [
        Heading("How this was found"),
        Paragraph(
            f"subskin {__version__} design, seed {effort.seed}: {effort.depths} depths and {effort.pitches} pitches "
            f"for each {kinds}; the same goals and seed give the same numbers. What it takes for granted:"
        ),
        Bullets((_AREA_LIMIT if area else _LINE_LIMIT, *_LIMITS)),
        Heading("The goals as they were given", 2),
        Listing(goals_text),
    ]
