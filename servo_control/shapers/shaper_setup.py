"""From the shaper a run asks for to a shaper with numbers: focal frequency from the extensions of the maneuver, safe delays."""

from __future__ import annotations

from dataclasses import dataclass
from math import pi, sqrt

from config.errors import ManeuverError
from config.schema.rig import Rig
from servo_control.link.link_mode import LinkFrequency
from servo_control.path.joint_limits import JointLimits, joint_index, joint_limits
from servo_control.shapers import impulses
from servo_control.shapers.fixed_shaper import FixedShaper
from servo_control.shapers.notch import ROBUST_SPREAD, NotchShaper
from servo_control.shapers.phase_shaper import PhaseShaper
from servo_control.shapers.scheduled_shaper import ScheduledShaper
from servo_control.shapers.shaper import NoShaper, Shaper
from servo_control.shapers.shaper_choice import ADAPTIVE, WHERE, ShaperChoice

EXTENSION_JOINT = "prismatic"
# Σc of the three-term filter vanishes at ω_d T = 0 and 2π; outside this range it amplifies.
SAFE_ANGLE_RAD = (1.0, 5.2)
DEFAULT_SCHEDULED_DELAY_S = 0.1


@dataclass(frozen=True, slots=True)
class Extensions:
    """Extensions of a maneuver in m: at its start, at the end of its first move, and the range it covers."""

    initial: float
    final: float
    shortest: float
    longest: float


@dataclass(frozen=True, slots=True)
class ShaperSetup:
    """A shaper with everything decided; `build` makes a fresh one. Plain data, so that a plan can be copied between processes."""

    kind: str
    joints: tuple[int, ...]
    period_s: float
    omega_d: float = 0.0
    damping_ratio: float = 0.0
    delay_s: float | None = None
    vibration: float = 0.05
    link: LinkFrequency | None = None
    extension: int = -1
    travel: tuple[float, float] = (0.0, 0.0)

    @property
    def focal_Hz(self) -> float | None:
        """The frequency a fixed shaper is made for; None for an adaptive one or none."""
        return self.omega_d / (2.0 * pi) if self.omega_d > 0.0 else None

    @property
    def keeps_bounds(self) -> bool:
        """True when every reference is a weighted mean of targets, so that checking the target's travel and rate is enough."""
        return self.kind in ("none", "zero_delay", "zv", "zvd", "ei", "two_hump_ei")

    def build(self) -> Shaper:
        if self.kind in ("none", "zero_delay"):  # the latter has corrected the targets themselves
            return NoShaper()
        if self.kind in ADAPTIVE:
            return self._build_adaptive()
        if self.kind in ("notch", "robust_notch"):
            natural = self.omega_d / sqrt(1.0 - self.damping_ratio**2)
            spread = ROBUST_SPREAD if self.kind == "robust_notch" else (1.0,)
            return NotchShaper([natural * share for share in spread], self.damping_ratio, self.joints, self.period_s)
        return FixedShaper(self.impulses(), self.joints, self.period_s)

    def impulses(self) -> impulses.Impulses:
        """Amplitudes and times (s) of a kind with fixed impulses."""
        if self.kind == "zv":
            return impulses.zv(self.omega_d, self.damping_ratio)
        if self.kind == "zvd":
            return impulses.zvd(self.omega_d, self.damping_ratio)
        if self.kind == "ei":
            return impulses.ei(self.omega_d, self.vibration)
        if self.kind == "two_hump_ei":
            return impulses.two_hump_ei(self.omega_d, self.vibration)
        return impulses.three_term(self.omega_d, self.damping_ratio, self.delay_s or pi / self.omega_d)

    def _build_adaptive(self) -> Shaper:
        assert self.link is not None
        if self.kind in ("adaptive", "adaptive_zv"):
            amplitudes = (impulses.zvd if self.kind == "adaptive" else impulses.zv)(1.0, self.damping_ratio)[0]
            return PhaseShaper(self.link, amplitudes, self.joints, self.extension, self.travel, self.period_s)
        delay = None if self.kind == "adaptive_delay" else self.delay_s
        return ScheduledShaper(self.link, self.joints, self.extension, self.travel, self.period_s, delay)


def extension_index(joints: tuple[JointLimits, ...]) -> int | None:
    """The joint whose position is the extension, None on an arm without one."""
    names = [joint.name for joint in joints]
    return names.index(EXTENSION_JOINT) if EXTENSION_JOINT in names else None


def set_up_shaper(rig: Rig, choice: ShaperChoice, extensions: Extensions | None) -> ShaperSetup:
    """Decide focal frequency and delay. `extensions` is None on an arm without extension. Raises ManeuverError."""
    joints = joint_limits(rig)
    period_s = 1.0 / rig.loop.rate_Hz
    if choice.kind in ("none", "zero_delay"):
        return ShaperSetup(choice.kind, (), period_s)
    shaped = tuple(joint_index(joints, name, WHERE) for name in choice.joints or (joints[0].name,))
    link = LinkFrequency(rig.link_mode, choice.frequency_scale) if rig.link_mode else None
    if choice.kind in ADAPTIVE:
        return _adaptive(choice, shaped, period_s, link, joints, extensions)
    omega = _focal_omega(choice, link, extensions)
    damping = choice.damping_ratio if choice.damping_ratio is not None else link.damping_ratio if link else 0.0
    delay = (choice.delay_s or pi / omega) if choice.kind == "three_term" else None
    if delay is not None:
        _check_delay(delay, omega, link, extensions)
    return ShaperSetup(choice.kind, shaped, period_s, omega, damping, delay, choice.vibration)


def _adaptive(
    choice: ShaperChoice,
    shaped: tuple[int, ...],
    period_s: float,
    link: LinkFrequency | None,
    joints: tuple[JointLimits, ...],
    extensions: Extensions | None,
) -> ShaperSetup:
    extension = extension_index(joints)
    if link is None or extension is None or extensions is None:
        raise ManeuverError(
            "an adaptive shaper needs `link_mode` in the rig file and a joint named prismatic",
            value=choice.kind,
            where=WHERE,
            next_step="Use a fixed filter, and give its frequency in Hz with --focal.",
        )
    delay = (choice.delay_s or DEFAULT_SCHEDULED_DELAY_S) if choice.kind == "adaptive_coefficients" else None
    if delay is not None:
        _check_delay(delay, link.omega_d(extensions.shortest), link, extensions)
    travel = joints[extension].travel
    return ShaperSetup(
        choice.kind,
        shaped,
        period_s,
        damping_ratio=link.damping_ratio,
        delay_s=delay,
        vibration=choice.vibration,
        link=link,
        extension=extension,
        travel=travel,
    )


def _focal_omega(choice: ShaperChoice, link: LinkFrequency | None, extensions: Extensions | None) -> float:
    if choice.frequency_Hz is not None:
        return 2.0 * pi * choice.frequency_Hz * choice.frequency_scale
    if link is None or extensions is None:
        raise ManeuverError(
            "the rig has no `link_mode` to take the shaper's frequency from",
            value=choice.kind,
            where=WHERE,
            next_step="Give the frequency in Hz with --focal.",
        )
    initial, final = link.omega_d(extensions.initial), link.omega_d(extensions.final)
    return {"initial": initial, "final": final, "mid": sqrt(initial * final)}[choice.focal]


def _check_delay(delay_s: float, omega: float, link: LinkFrequency | None, extensions: Extensions | None) -> None:
    """1.0 ≤ ω_d T ≤ 5.2 at the focal frequency and at every extension of the maneuver."""
    angles = [omega * delay_s]
    if link is not None and extensions is not None:
        angles += [link.omega_d(extensions.longest) * delay_s, link.omega_d(extensions.shortest) * delay_s]
    low, high = SAFE_ANGLE_RAD
    if low <= min(angles) and max(angles) <= high:
        return
    bad = max(angles) if max(angles) > high else min(angles)
    longest, shortest = delay_s * high / max(angles), delay_s * low / min(angles)
    fits = shortest <= longest
    advice = f"Choose --delay from {shortest:.3f} to {longest:.3f} s." if fits else "Use kind zvd, ei or adaptive."
    middle = f"{0.5 * (shortest + longest):.3f} s"
    raise ManeuverError(
        f"the delay T = {delay_s:.4f} s is unsafe: ω_d T leaves the safe range within the extensions of the maneuver",
        value=f"{bad:.2f}",
        limit=f"{low:g} to {high:g}",
        unit="rad",
        where=WHERE,
        next_step=advice,
        mend={"--delay": middle} if fits else {"--shaper": "zvd", "--delay": None},
    )
