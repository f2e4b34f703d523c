"""Everything a set of logs says about a rig: responses, fits, bounds, the link's map and the payload."""

from __future__ import annotations

import hashlib
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import TypeVar

from config.errors import LogError
from config.progress import Progress
from config.schema.rig import LinkMode, Rig
from recording.files.reader import Log, open_rig, read_log
from tuning.experiments.excited_run import ExcitedRun, excited_runs
from tuning.linear.hydraulic_axis import is_hydraulic_axis
from tuning.link_and_payload.free_vibration import FreeVibration, free_vibrations
from tuning.link_and_payload.link_map import LinkMap, link_map
from tuning.link_and_payload.payload import PayloadEstimate, clamped_Hz, disagreement, identify_payload
from tuning.link_and_payload.tip_balance import tip_balance
from tuning.link_and_payload.tip_record import TipRecord, tip_records
from tuning.oil.oil_from_logs import Steady, oil_rows, steady_motion
from tuning.oil.oil_table import OilRow
from tuning.responses.axis_fit import fit_axis
from tuning.responses.frequency_response import FrequencyResponse, combined
from tuning.responses.realisations import realisations
from tuning.responses.response_bounds import Bounds, bounds
from tuning.responses.response_fit import JointFit, fit_joint

SAME_PAYLOAD_KG = 0.05
LINK_IN_BAND = 2.0  # a link mode above this times the highest line does not show in the response
Found = TypeVar("Found")


@dataclass(frozen=True, slots=True, eq=False)
class Response:
    """A measured response and its fit; the fit is None when there are too few lines."""

    measured: FrequencyResponse
    fit: JointFit | None


@dataclass(frozen=True, slots=True)
class LinkFound:
    """What the moves with one payload gave. `believed_kg`: the payload of the rig file in those logs."""

    believed_kg: float
    payload: tuple[PayloadEstimate, ...]
    map: LinkMap | None
    note: str


@dataclass(slots=True)
class Identification:
    """`rig_text`: the rig file in the first log; `hashes`: SHA-256 of every log by file name; `refused`: what could not be used, and
    why."""

    rig: Rig
    rig_text: str = ""
    hashes: dict[str, str] = field(default_factory=dict)
    responses: list[Response] = field(default_factory=list)
    bounds: list[Bounds] = field(default_factory=list)
    links: list[LinkFound] = field(default_factory=list)
    oil: dict[str, list[OilRow]] = field(default_factory=dict)
    refused: list[str] = field(default_factory=list)


def identify(paths: Sequence[Path], progress: Progress = lambda line: None) -> Identification:
    """Take from every log whatever it can give. LogError when none gives anything, or they are of different rigs."""
    gathered = _Gathered()
    for path in paths:
        progress(f"reading {path.name}")
        gathered.take(path)
    found = Identification(gathered.rig(), gathered.rig_text, gathered.hashes, refused=gathered.refused)
    found.responses = [_fitted(found.rig, combined(group)) for group in realisations(gathered.excited, found.rig)]
    found.bounds = bounds([response.measured for response in found.responses])
    found.links = [_link(link, records) for link, records in gathered.by_payload()]
    found.oil = {joint: rows for joint, samples in gathered.steady.items() if (rows := oil_rows(samples))}
    if not (found.responses or found.links):
        raise LogError(
            "nothing in the logs can be identified", value="; ".join(found.refused), next_step="See `longreach identify --help`."
        )
    return found


class _Gathered:
    """What the logs hold, before anything is computed from several of them."""

    def __init__(self) -> None:
        self._rigs: list[Rig] = []
        self._moves: list[tuple[LinkMode, TipRecord]] = []
        self.excited: list[ExcitedRun] = []
        self.rig_text = ""
        self.hashes: dict[str, str] = {}
        self.refused: list[str] = []
        self.steady: dict[str, list[Steady]] = {}

    def take(self, path: Path) -> None:
        log = read_log(path)
        rig = open_rig(log)
        if self._rigs and rig.name != self._rigs[0].name:
            raise LogError("the logs are of different rigs", value=rig.name, limit=self._rigs[0].name, where=str(path))
        self._rigs.append(rig)
        self.rig_text = self.rig_text or log.attachments["rig.yaml"].decode()
        self.hashes[path.name] = hashlib.sha256(path.read_bytes()).hexdigest()
        why: list[str] = []
        excited = _try(log, excited_runs, why)
        numbers = {run.run for run in excited}
        moves = [record for record in _try(log, tip_records, why) if record.run not in numbers] if rig.link_mode is not None else []
        self.excited += excited
        if rig.link_mode is not None:
            self._moves += [(rig.link_mode, record) for record in moves]
        for joint in rig.joints:
            self.steady.setdefault(joint, []).append(steady_motion(log, rig, joint))
        if not (excited or moves):
            self.refused += why

    def rig(self) -> Rig:
        if not self._rigs:
            raise LogError("no logs were given")
        return self._rigs[0]

    def by_payload(self) -> list[tuple[LinkMode, list[TipRecord]]]:
        groups: list[tuple[LinkMode, list[TipRecord]]] = []
        for link, record in self._moves:
            same = [records for other, records in groups if abs(other.payload_kg - link.payload_kg) < SAME_PAYLOAD_KG]
            if same:
                same[0].append(record)
            else:
                groups.append((link, [record]))
        return groups


def _try(log: Log, find: Callable[[Log], list[Found]], why: list[str]) -> list[Found]:
    try:
        return find(log)
    except LogError as error:
        why.append(str(error))
        return []


def _fitted(rig: Rig, response: FrequencyResponse) -> Response:
    if is_hydraulic_axis(rig):
        return _with(response, fit_axis)
    at, link = response.conditions, rig.link_mode
    clamped = clamped_Hz(link, at.payload_kg, at.extension_m) if link is not None and at.joint == "rotary" else None
    visible = clamped is not None and clamped < LINK_IN_BAND * response.frequencies_Hz[-1]
    return _with(response, lambda measured: fit_joint(measured, clamped if visible else None))


def _with(response: FrequencyResponse, fit: Callable[[FrequencyResponse], JointFit]) -> Response:
    try:
        return Response(response, fit(response))
    except LogError:
        return Response(response, None)


def _link(link: LinkMode, records: Sequence[TipRecord]) -> LinkFound:
    """Payload and map; either may be impossible, and then the note says why."""
    notes = [
        f"run {record.run}: the log lacks cycles of the hold after move {move}; left out." for record in records for move in record.torn
    ]
    estimates: list[PayloadEstimate] = []
    mapped: LinkMap | None = None
    try:
        estimates = identify_payload(records, link)
        notes.append(disagreement(estimates))
    except LogError as error:
        notes.append(str(error))
    holds: list[FreeVibration] = [hold for record in records for hold in free_vibrations(record, link)]
    try:
        known = link.model_copy(update={"payload_kg": estimates[0].payload_kg}) if estimates else link
        balances = [balance for record in records if (balance := tip_balance(record, known)) is not None]
        mapped = link_map(link, holds, balances)
    except LogError as error:
        notes.append(str(error))
    return LinkFound(link.payload_kg, tuple(estimates), mapped, " ".join(note for note in notes if note))
