"""Pictures of an identification, and the page that shows them with the numbers."""

from __future__ import annotations

import base64
from collections.abc import Callable
from html import escape
from io import BytesIO
from pathlib import Path

import numpy as np
from matplotlib import colormaps, rc_context
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from matplotlib.ticker import FuncFormatter, LogLocator, NullFormatter

from config.loading.stated_units import sentence_units
from config.schema.rig import Rig
from config.stated_sentences import StatedSentences
from config.whole_file import write_whole
from tuning.arrays import Floats
from tuning.identification.identification import Identification, Response
from tuning.link_and_payload.link_map import LinkMap, MapPoint
from tuning.oil.oil_table import as_override
from tuning.responses.response_fit import JointFit

_STYLE = {"font.size": 13, "axes.grid": True, "grid.alpha": 0.3, "lines.linewidth": 1.5, "legend.fontsize": 9}
_VARIED = {"amplitude": "amplitude", "extension_m": "extension", "position": "position", "oil_C": "oil temperature",
           "payload_kg": "payload", "all": "everything"}  # fmt: skip
NOT_KNOWN = "damping not seen in these moves: `longreach identify --what map` measures it"
_SIZE_IN, _DOTS_PER_INCH = (15.0, 8.5), 100
_CSS = "body{font:16px/1.5 sans-serif;max-width:70em;margin:2em auto;padding:0 1em}img{max-width:100%}"


def write_pictures(found: Identification, out: Path) -> list[Path]:
    """PNG files and index.html in the directory `out`; which of them there are depends on what was identified."""
    drawn: dict[str, bytes] = {}
    if found.responses:
        drawn["responses.png"] = _picture(lambda figure: _responses(figure, found))
    if found.bounds:
        drawn["bounds.png"] = _picture(lambda figure: _bounds(figure, found))
    if any(link.map is not None for link in found.links):
        drawn["link.png"] = _picture(lambda figure: _link(figure, found))
    out.mkdir(parents=True, exist_ok=True)
    for name, content in drawn.items():
        (out / name).write_bytes(content)
    page = out / "index.html"
    write_whole(page, _page(found, drawn))
    return [page, *(out / name for name in drawn)]


def _picture(draw: Callable[[Figure], None]) -> bytes:
    with rc_context(_STYLE):
        figure = Figure(figsize=_SIZE_IN, layout="constrained")
        draw(figure)
        FigureCanvasAgg(figure)
        buffer = BytesIO()
        figure.savefig(buffer, dpi=_DOTS_PER_INCH, format="png")
        return buffer.getvalue()


def label(rig: Rig, response: Response) -> str:
    """Conditions of a response in few words."""
    at = response.measured.conditions
    unit = rig.joints[at.joint].position_unit
    amplitude = f"{at.amplitude:.2g} {'V' if at.on == 'command' else unit}"
    measured = ((at.extension_m, ".4f", "m"), (at.position, ".4f", unit), (at.oil_C, ".0f", "°C"), (at.payload_kg, ".3f", "kg"))
    return ", ".join(
        [f"{response.measured.source} {at.joint}: {amplitude}", *(f"{v:{d}} {unit}" for v, d, unit in measured if np.isfinite(v))]
    )


def _responses(figure: Figure, found: Identification) -> None:
    """Multisines with points, sweeps as lines, fits dashed; one colour a response."""
    axes = figure.subplots(2, 2)
    colours = colormaps["tab20"].colors  # type: ignore[attr-defined]
    for number, response in enumerate(found.responses):
        measured, colour = response.measured, colours[number % len(colours)]
        f, style = measured.frequencies_Hz, "." if measured.source == "multisine" else "-"
        axes[0, 0].plot(f, 20.0 * np.log10(np.abs(measured.response)), style, color=colour, label=label(found.rig, response))
        axes[1, 0].plot(f, np.degrees(np.unwrap(np.angle(measured.response))), style, color=colour)
        axes[1, 1].plot(f, measured.coherence, style, color=colour)
        if response.fit is not None:
            axes[0, 0].plot(f, 20.0 * np.log10(np.abs(response.fit(f))), "--", color=colour, linewidth=0.8)
        for part, mark in ((measured.odd, "o"), (measured.even, "x")):
            if part is not None and len(part.frequencies_Hz):
                axes[0, 1].plot(part.frequencies_Hz, part.level_dB, mark, color=colour, markersize=3)
                axes[0, 1].plot(part.frequencies_Hz, part.noise_dB, ":", color=colour, linewidth=0.8)
    axes[0, 0].set(title="position over command (dashed: fit)", ylabel="dB re 1 rad/V or 1 m/V")
    axes[1, 0].set(ylabel="degrees", xlabel="frequency / Hz")
    axes[0, 1].set(title="distortion: odd (o), even (x), noise (dotted)", ylabel="dB re excited lines")
    axes[1, 1].set(title="coherence", ylim=(0.0, 1.05), xlabel="frequency / Hz")
    for axis in axes.flat:
        _log_frequency(axis)
    figure.legend(loc="outside lower center", ncols=3)


def _bounds(figure: Figure, found: Identification) -> None:
    axes = figure.subplots(2, len(found.bounds), sharex=True, squeeze=False)
    for column, each in enumerate(found.bounds):
        spread_dB, spread_deg = each.spread
        title = f"{each.family}: {_VARIED[each.varied]} ({each.count}): {spread_dB:.1f} dB"
        _band(axes[0, column], each.frequencies_Hz, each.magnitude_dB, title)
        _band(axes[1, column], each.frequencies_Hz, each.phase_deg, f"{spread_deg:.0f} degrees")
        axes[1, column].set_xlabel("frequency / Hz")
    axes[0, 0].set_ylabel("dB re 1 rad/V or 1 m/V")
    axes[1, 0].set_ylabel("degrees")


def _band(axis: Axes, f: Floats, limits: tuple[Floats, Floats], title: str) -> None:
    axis.fill_between(f, *limits, alpha=0.4)
    axis.set_title(title)
    _log_frequency(axis)


def _log_frequency(axis: Axes) -> None:
    """Logarithmic with plain numbers."""
    axis.set_xscale("log")
    axis.xaxis.set_major_locator(LogLocator(subs=(1.0, 2.0, 5.0)))
    axis.xaxis.set_major_formatter(FuncFormatter(lambda value, _: f"{value:g}"))
    axis.xaxis.set_minor_formatter(NullFormatter())


def _link(figure: Figure, found: Identification) -> None:
    frequency, damping = figure.subplots(1, 2)
    for link in found.links:
        if link.map is None:
            continue
        extension = [point.extension_m for point in link.map.points]
        (line,) = frequency.semilogy(
            extension, [point.ring_Hz for point in link.map.points], "o", label=f"{link.believed_kg:.2f} kg, as it rings"
        )
        frequency.semilogy(extension, [point.clamped_Hz for point in link.map.points], "x", color=line.get_color(), label="the link alone")
        frequency.semilogy(extension, [point.believed_Hz for point in link.map.points], "-", color=line.get_color(), label="rig file")
        damping.plot(extension, [100.0 * point.damping_ratio for point in link.map.points], "o", color=line.get_color())
    frequency.set(title="link frequency", xlabel="extension / m", ylabel="Hz")
    damping.set(title="damping ratio of the link alone", xlabel="extension / m", ylabel="%")
    frequency.legend()


def _page(found: Identification, drawn: dict[str, bytes]) -> str:
    pictures = "".join(f'<img alt="{name}" src="data:image/png;base64,{base64.b64encode(png).decode()}">' for name, png in drawn.items())
    lines = "".join(f"<p>{escape(line)}</p>" for line in summary(found))
    head = f"<!doctype html><meta charset=utf-8><title>{escape(found.rig.name)} identified</title><style>{_CSS}</style>"
    return f"{head}<h1>{escape(found.rig.name)}</h1>{lines}{pictures}"


def summary(found: Identification, si: bool = False) -> list[str]:
    """What a reader at the terminal needs, in the units of the rig file or in SI."""
    sentences = StatedSentences({} if si else sentence_units(found.rig_text))
    return [sentences.text(line) for line in _summary(found)]


def _summary(found: Identification) -> list[str]:
    lines = [_response_line(found.rig, response) for response in found.responses]
    lines += [
        f"{b.family}: bounds over {_VARIED[b.varied]} ({b.count} responses): {b.spread[0]:.1f} dB, {b.spread[1]:.0f} degrees"
        for b in found.bounds
    ]
    for link in found.links:
        lines += [
            f"payload {each.payload_kg:.3f} ± {each.uncertainty_kg:.3f} kg by {each.method} (rig file {link.believed_kg:.3f} kg)"
            for each in link.payload
        ]
        lines += _map_lines(link.map) if link.map is not None else []
        lines += [f"  note: {link.note}"] if link.note else []
    for joint, rows in found.oil.items():
        source = f"{joint}.return_temperature"
        if source in found.rig.signals and len(rows) > 1:
            lines.append(f"oil compensation of {joint}: --set {as_override(found.rig, joint, source, rows)!r}")
    return [*lines, *(f"not used: {refused}" for refused in found.refused)]


def _map_lines(mapped: LinkMap) -> list[str]:
    lines = [
        f"  {p.extension_m:.4f} m: {_rings(p)}link alone {p.clamped_Hz:.3f} ± {2 * p.clamped_sigma_Hz:.3f} Hz"
        f" (rig file {p.believed_Hz:.3f}){_damped(p)}"
        for p in mapped.points
    ]
    lag = f", accelerometer {1e3 * mapped.sensor_lag_s:.2f} ms behind the deflection sensor" if np.isfinite(mapped.sensor_lag_s) else ""
    ratio = 100.0 * (mapped.stiffness_ratio - 1.0)
    damping = f"damping ratio {mapped.damping_ratio:.4f} ± {mapped.damping_uncertainty:.4f}"
    return [
        *lines,
        f"  {damping if np.isfinite(mapped.damping_ratio) else NOT_KNOWN}{lag}",
        f"  with exactly the rig file's payload the link would be {abs(ratio):.1f} % {'stiffer' if ratio > 0 else 'softer'} than written",
    ]


def _damped(point: MapPoint) -> str:
    return f", damping {100 * point.damping_ratio:.2f} %" if np.isfinite(point.damping_ratio) else ""


def _rings(point: MapPoint) -> str:
    return f"rings at {point.ring_Hz:.3f} Hz, " if np.isfinite(point.ring_Hz) else ""


def _response_line(rig: Rig, response: Response) -> str:
    head = f"{label(rig, response)}: coherence {float(np.min(response.measured.coherence)):.3f} at least"
    for name, part in (("odd", response.measured.odd), ("even", response.measured.even)):
        if part is not None and len(part.level_dB):
            head += f", {name} distortion {np.median(part.level_dB):.0f} dB (noise {np.median(part.noise_dB):.0f})"
    if response.fit is None:
        return f"{head}; too few lines for a fit"
    named = _numbers(response.fit, rig.joints[response.measured.conditions.joint].position_unit)
    numbers = ", ".join(f"{f'{name} {value:.4g} {unit}'.rstrip()} ± {100 * share:.0f} %" for name, value, unit, share in named)
    limited = f"; at a limit of the fit, so not known: {', '.join(response.fit.at_limit)}" if response.fit.at_limit else ""
    return f"{head}; {numbers}; fit within {response.fit.worst_dB:.1f} dB, {response.fit.worst_deg:.0f} degrees{limited}"


def _numbers(fit: JointFit, unit: str) -> list[tuple[str, float, str, float]]:
    """Name, value, unit, two standard deviations as a share."""
    values, sure = fit.values, fit.uncertainty
    named = [
        ("velocity gain", fit.velocity_gain, f"{unit}/s/V", sure["velocity_gain"]),
        ("lag", fit.lag_s, "s", sure["lag"]),
        ("gain", values["gain"], f"{unit}/s^3/V", sure["gain"]),
        ("damping", values["damping"], "1/s", sure["damping"]),
        ("stiffness", values["stiffness"], "1/s^2", sure["stiffness"]),
    ]
    if "valve_Hz" in values:
        named.append(("natural frequency", fit.natural_Hz, "Hz", 0.5 * sure["stiffness"]))
        valve = [
            ("valve", values["valve_Hz"], "Hz", sure["valve_Hz"]),
            ("valve damping", values["valve_damping"], "", sure["valve_damping"]),
        ]
        named += [each for each in valve if each[-1] < 1.0]  # a quick one is not seen in the band
    return named
