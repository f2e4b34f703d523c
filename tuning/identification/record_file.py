"""Writes what was identified: the calibration record a rig file can refer to, and all numbers as JSON beside it."""

from __future__ import annotations

import datetime
import json
from importlib.metadata import version
from math import isfinite
from pathlib import Path
from typing import Any

import numpy as np
import yaml

from config.loading.calibration_record import load_record
from config.whole_file import write_whole
from tuning.identification.identification import Identification, LinkFound, Response
from tuning.responses.frequency_response import Distortion, FrequencyResponse
from tuning.responses.response_fit import NAMES, JointFit

VALID_DAYS = 180
DIGITS = 7
LARGEST_SIGMA = 0.01  # relative; a point of the map that is known less well is left to the formula


def write_record(found: Identification, path: Path, by: str, source: str, today: datetime.date, valid_days: int = VALID_DAYS) -> Path:
    """The record at `path`, whole or not at all; checked by reading it back. WriteError when it cannot be written."""
    content: dict[str, Any] = {
        "longreach": "calibration/1",
        "rig": found.rig.name,
        "identified_on": today,
        "valid_until": today + datetime.timedelta(days=valid_days),
        "by": by,
        "software": f"longreach {version('longreach')}",
        "source": source,
        "logs": dict(found.hashes),
    }
    link = own_link(found)
    if link is not None and link.payload:
        content["link"] = _link(found, link)
    joints = [_joint(response) for response in found.responses if response.fit is not None]
    if joints:
        content["joints"] = joints
    text = "# Written by `longreach identify`. A rig file takes the link's numbers with identified: {record: THIS FILE}.\n"
    write_whole(path, text + yaml.safe_dump(content, sort_keys=False, allow_unicode=True))
    load_record(path)
    return path


def write_results(found: Identification, path: Path) -> Path:
    """Every number, for programs."""
    write_whole(path, json.dumps(as_dict(found), indent=1))
    return path


def own_link(found: Identification) -> LinkFound | None:
    """The moves with the rig file's own payload; the only ones there are when none has it."""
    believed = found.rig.link_mode.payload_kg if found.rig.link_mode is not None else 0.0
    own = [link for link in found.links if abs(link.believed_kg - believed) < 1e-6]
    return own[0] if own else found.links[0] if len(found.links) == 1 else None


def as_dict(found: Identification) -> dict[str, Any]:
    """JSON-able; complex responses as magnitude in dB and phase in degrees."""
    return {
        "rig": found.rig.name,
        "logs": found.hashes,
        "responses": [{**_response(each.measured), "fit": _fit(each)} for each in found.responses],
        "bounds": [
            {
                **{name: getattr(each, name) for name in ("joint", "on", "varied", "count")},
                "spread_dB": each.spread[0],
                "spread_deg": each.spread[1],
            }
            for each in found.bounds
        ],
        "links": [_link_numbers(link) for link in found.links],
        "oil": {joint: [{name: getattr(row, name) for name in row.__slots__} for row in rows] for joint, rows in found.oil.items()},
        "refused": found.refused,
    }


def _link(found: Identification, link: LinkFound) -> dict[str, Any]:
    """Quantities as a user writes them. With end-point feedback the ringing is not the link's own, so the clamped frequencies count:
    the feedback leaves alone what the reference causes, and filters are made for the clamped link."""
    best = link.payload[0]
    content: dict[str, Any] = {"payload": f"{best.payload_kg:.6g} kg", "payload_uncertainty": f"{best.uncertainty_kg:.3g} kg"}
    if link.map is None:
        return content
    if isfinite(link.map.damping_ratio) and link.map.damping_ratio > 0.0:
        content |= {"damping_ratio": _short(link.map.damping_ratio), "damping_uncertainty": _short(link.map.damping_uncertainty)}
    name = "clamped" if found.rig.end_point is not None else "ring"
    known = [point for point in link.map.points if getattr(point, f"{name}_sigma_Hz") < LARGEST_SIGMA * getattr(point, f"{name}_Hz")]
    if not known:
        return content
    content["frequency_map"] = [
        {
            "extension": f"{point.extension_m:.5g} m",
            "frequency": f"{getattr(point, f'{name}_Hz'):.6g} Hz",
            "uncertainty": f"{2.0 * getattr(point, f'{name}_sigma_Hz'):.3g} Hz",
        }
        for point in known
    ]
    return content


def _joint(response: Response) -> dict[str, Any]:
    fit, at = response.fit, response.measured.conditions
    assert fit is not None
    measured = {"extension": (at.extension_m, ".5g", "m"), "oil_temperature": (at.oil_C, ".4g", "degC")}
    return {
        "joint": at.joint,
        "amplitude": _short(at.amplitude),
        **{name: f"{value:{digits}} {unit}" for name, (value, digits, unit) in measured.items() if isfinite(value)},
        **({"position": _short(at.position)} if isfinite(at.position) else {}),
        **{name: _short(fit.values[name]) for name in NAMES},
        **_valve(fit),
        "uncertainty": {name: _short(value) for name, value in fit.uncertainty.items()},
        "worst_dB": _short(fit.worst_dB),
        "worst_deg": _short(fit.worst_deg),
    }


def _valve(fit: JointFit) -> dict[str, Any]:
    """Of a single axis."""
    if "valve_Hz" not in fit.values:
        return {}
    return {"valve_frequency": f"{fit.values['valve_Hz']:.5g} Hz", "valve_damping": _short(fit.values["valve_damping"])}


def _response(measured: FrequencyResponse) -> dict[str, Any]:
    at = measured.conditions
    return {
        "source": measured.source,
        "conditions": {name: _number(getattr(at, name)) for name in at.__slots__},
        "frequencies_Hz": _list(measured.frequencies_Hz),
        "magnitude_dB": _list(20.0 * np.log10(np.abs(measured.response))),
        "phase_deg": _list(np.degrees(np.unwrap(np.angle(measured.response)))),
        "sigma": _list(measured.sigma),
        "coherence": _list(measured.coherence),
        "command_V": _list(measured.command_V),
        "odd": _distortion(measured.odd),
        "even": _distortion(measured.even),
    }


def _distortion(part: Distortion | None) -> dict[str, Any] | None:
    if part is None:
        return None
    return {"frequencies_Hz": _list(part.frequencies_Hz), "level_dB": _list(part.level_dB), "noise_dB": _list(part.noise_dB)}


def _fit(response: Response) -> dict[str, Any] | None:
    fit = response.fit
    if fit is None:
        return None
    return {
        **fit.values,
        "velocity_gain": fit.velocity_gain,
        "lag_s": fit.lag_s,
        "uncertainty": fit.uncertainty,
        "worst_dB": fit.worst_dB,
        "worst_deg": fit.worst_deg,
        "at_limit": list(fit.at_limit),
    }


def _link_numbers(link: LinkFound) -> dict[str, Any]:
    mapped = link.map
    points = [] if mapped is None else [{name: _number(getattr(p, name)) for name in p.__slots__} for p in mapped.points]
    return {
        "believed_payload_kg": link.believed_kg,
        "payload": [{name: _number(getattr(each, name)) for name in each.__slots__} for each in link.payload],
        "map": points,
        "damping_ratio": None if mapped is None else _number(mapped.damping_ratio),
        "damping_uncertainty": None if mapped is None else _number(mapped.damping_uncertainty),
        "sensor_lag_s": None if mapped is None else _number(mapped.sensor_lag_s),
        "stiffness_ratio": None if mapped is None else mapped.stiffness_ratio,
        "note": link.note,
    }


def _list(values: Any) -> list[float | None]:
    return [_number(float(value)) for value in values]


def _number(value: Any) -> Any:
    """JSON has no NaN."""
    return None if isinstance(value, float) and not isfinite(value) else value


def _short(value: float) -> float:
    return float(f"{value:.{DIGITS}g}")
