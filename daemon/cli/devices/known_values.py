"""`device calibrate --at VALUE`: a value without a unit is SI, so that 150 meant as mm passes as 150 m."""

from __future__ import annotations

from collections.abc import Sequence

from config.errors import UsageError
from config.loading.load import LoadedRig
from config.loading.stated_units import stated_units
from config.readable import number
from config.schema.rig import Rig
from config.units import written_unit
from daemon.cli.devices.device_numbers import scaling


def refuse_far_away(loaded: LoadedRig, sensor: str, texts: Sequence[str], values: Sequence[float]) -> None:
    """UsageError for a known value that lies further outside the signal's range than that range is long. `texts`: --at as typed."""
    ends = _range(loaded.rig, sensor)
    if ends is None:
        return
    low, high = ends
    text, far = max(zip(texts, values, strict=True), key=lambda pair: max(low - pair[1], pair[1] - high))
    if max(low - far, far - high) <= high - low:
        return
    unit, factor, zero = scaling(sensor, loaded.rig.signals[sensor], stated_units(loaded.text)).shown
    bare = [each for each in texts if not written_unit(each.partition("=")[0].strip())]
    meant = {each: _with(each, unit) for each in bare} if text in bare and factor != 1.0 else {}
    advice = f"Write the unit: --at '{meant[text]}'." if meant else f"Is the unit right, and the range of signals.{sensor}?"
    value, limit = number(factor * far + zero), f"{number(factor * low + zero)} to {number(factor * high + zero)}"
    what = f"the known value {text.partition('=')[0].strip()!r} lies far outside what {sensor} can be"
    raise UsageError(what, value=value, limit=limit, unit=unit, where="--at", next_step=advice, mend=meant)


def _range(rig: Rig, sensor: str) -> tuple[float, float] | None:
    """low to high of the signal; of a position the joint's travel where the file gives none."""
    signal, joint = rig.signals[sensor], rig.joints.get(sensor.removesuffix(".position"))
    if signal.low is not None and signal.high is not None:
        return signal.low, signal.high
    return joint.travel if joint is not None else None


def _with(text: str, unit: str) -> str:
    value, equals, counts = text.partition("=")
    return f"{value.strip()} {unit}{equals}{counts}"
