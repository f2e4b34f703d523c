"""Analogue inputs and outputs after CiA 401: ±10 V outputs to valve amplifiers, analogue inputs.

A module with outputs drives the safe voltage by itself: 0x6443 (error mode) = 1 and 0x6444 (error value) = 0 are written and read
back, because the default of many modules is to keep the last value for ever. A lost heartbeat takes the module out of OPERATIONAL
(0x1029 = 0). One that is used for its inputs only has `outputs: 0`, and nothing to prove.
Process data use PDO 2, the place the profile gives to analogue values.
"""

from __future__ import annotations

import struct
from collections.abc import Sequence

import can

from config.options.canopen_options import IoOptions
from config.options.canopen_rig import our_heartbeat_period_s
from config.options.driver_options import device_options
from config.schema.rig import Device, Rig
from drivers.canopen.bus import OPERATIONAL, Steps
from drivers.canopen.node_setup import AT_ONCE, I16, I32, U8, NodeSetup, Setting, pdo_settings, supervision
from drivers.canopen.output_device import ACTIVATE_S, OutputDevice, Silence
from drivers.canopen.sdo_upload import upload
from drivers.contract import Quality
from drivers.proof import ProofResult, not_proven, proof

REACTION_S = 0.03
SDO_S = 0.2
_LARGEST = 32767
_START_NODE = 1
_USE_ERROR_VALUE, _LEAVE_OPERATIONAL = 1, 0
_OUTPUT, _INPUT = 0x6411, 0x6401


def create(name: str, device: Device, rig: Rig, lockstep: bool) -> IoDriver:
    """The driver factory (`driver: canopen_io_401` in a rig file)."""
    options = device_options(name, device)
    assert isinstance(options, IoOptions)
    return IoDriver(name, options, device.timeout_s, our_heartbeat_period_s(rig, options.bus), lockstep)


class IoDriver(OutputDevice):
    """Outputs `output_1` ... in volts, inputs `input_1` ... in counts. A module that is not operational has BAD inputs."""

    tpdo = 2

    def __init__(self, name: str, options: IoOptions, timeout_s: float, heartbeat_period_s: float, lockstep: bool) -> None:
        self.every_syncs = options.every_syncs
        super().__init__(name, options, timeout_s, heartbeat_period_s, lockstep, options.failed_cycles)
        self._io = options
        self._command_frame = struct.Struct(f"<{options.outputs}h")
        self._input_frame = struct.Struct(f"<{options.inputs}h")
        self._zeros = (0,) * options.outputs
        self._message = can.Message(arbitration_id=0x300 + self.node, is_extended_id=False, data=bytes(self._command_frame.size))
        self._start = can.Message(arbitration_id=0, is_extended_id=False, data=[_START_NODE, self.node])

    def _supervised(self) -> Sequence[Silence]:
        return tuple(Silence)

    def _make_ready(self) -> Steps[None]:
        """A module that has left OPERATIONAL is started, with 0 V at every output. Inputs alone need no more: their quality tells."""
        if not self.outputs:
            self._opened().send(self._start)
        elif not (yield from self._hears_module(0)):
            yield from self._restart(0)

    def _command(self, values: Sequence[float]) -> None:
        scale = self._io.counts_per_volt
        self._send_command([min(max(round(scale * volts), -_LARGEST), _LARGEST) for volts in values])

    def _send_safe_command(self) -> None:
        self._send_command(self._zeros)

    def _is_right(self) -> bool:
        return self.nmt_state == OPERATIONAL and not self._is_silent

    def _is_safe(self) -> bool:
        """A module that runs has obeyed the last frame, one that does not has taken its error values: both were written as 0 V."""
        return True

    def _trouble(self) -> str:
        return f"the module is silent or not operational ({self._seen()})"

    def _set_up(self, setup: NodeSetup) -> None:
        channels = range(1, self._io.outputs + 1)
        for channel in channels:
            setup.write(
                [
                    Setting(0x6443, channel, _USE_ERROR_VALUE, U8, "error mode: take the error value"),
                    Setting(0x6444, channel, 0, I32, "error value"),
                    Setting(_OUTPUT, channel, 0, I16, "output"),
                ]
            )
        setup.write([Setting(0x1029, 1, _LEAVE_OPERATIONAL, U8, "error behaviour: pre-operational")])
        outputs = [_OUTPUT << 16 | channel << 8 | 16 for channel in channels]
        inputs = [_INPUT << 16 | channel << 8 | 16 for channel in range(1, self._io.inputs + 1)]
        if outputs:
            setup.write(pdo_settings(True, 2, self.node, AT_ONCE, outputs, round(1e3 * self._timeout_s)))
        setup.write(pdo_settings(False, 2, self.node, self.every_syncs, inputs))
        setup.switch_off_other_pdos([(True, 2), (False, 2)])
        if outputs:
            setup.write(list(supervision(self._io.bus.own_node, self._timeout_s)))

    def _on_process_data(self, data: bytearray, stamp_ns: int) -> None:
        if len(data) != self._input_frame.size:
            self.malformed += 1
            return
        for sample, counts in zip(self._samples, self._input_frame.unpack(data), strict=True):
            sample.raw = counts
            sample.stamp_ns = stamp_ns
        self.nmt_state = OPERATIONAL  # only an operational node sends process data
        self._accept(stamp_ns)

    def _assess(self) -> None:
        """In its own proof a module leaves OPERATIONAL as it should; whether its last values still count, their age tells then."""
        quality = self._frame_quality() if self.nmt_state == OPERATIONAL or self._proving else Quality.BAD
        for sample in self._samples:
            sample.quality = quality

    def _send_command(self, counts: Sequence[int]) -> None:
        if not counts:
            return
        self._command_frame.pack_into(self._message.data, 0, *counts)
        self._opened().send(self._message)

    def _hears_module(self, counts: int) -> Steps[bool]:
        """Set every output to `counts` until a frame of inputs shows that the module runs."""
        commanded = [counts] * len(self.outputs)
        return self._answers(lambda: True, ACTIVATE_S, lambda: self._send_command(commanded))

    def _restart(self, counts: int) -> Steps[None]:
        """Back to OPERATIONAL; the outputs are told `counts`."""
        self._opened().send(self._start)
        self.emergency = 0
        if not (yield from self._hears_module(counts)):
            raise self._error("the module does not become operational", self._seen(), next_step="Check its supply and cable.")

    def _prove(self, silence: Silence) -> Steps[ProofResult]:
        name = f"{self.name}: outputs safe after {silence}"
        limit_s = self._timeout_s + REACTION_S
        counts = round(self._io.proof_voltage_V * self._io.counts_per_volt)
        commanded = [counts] * len(self.outputs)
        yield from self._restart(counts)
        if (yield from self._answers(lambda: self._terminals_show(counts), ACTIVATE_S, lambda: self._send_command(commanded))):
            took_s = yield from self._fall_silent(silence, self._has_reacted, limit_s, lambda: self._send_command(commanded))
            yield from self._read_terminals()
            result = proof(name, took_s if self._terminals_show(0) else None, limit_s, f"{self._seen()}{self._inputs_text()}")
        else:
            result = not_proven(name, limit_s, f"input and output wired together differ ({self._inputs_text()})")
        yield from self._end_proof()
        return result

    def _end_proof(self) -> Steps[None]:
        yield from self._restart(0)

    def _has_reacted(self) -> bool:
        return self.emergency != 0 or self.nmt_state != OPERATIONAL

    def _read_terminals(self) -> Steps[None]:
        """The inputs of the loopback by SDO, because a module that is not operational sends no frames."""
        for channel in self._io.loopback.values():
            content = yield from upload(self._opened(), self.node, _INPUT, channel, SDO_S)
            if len(content) != struct.calcsize(I16):
                raise self._error(f"input_{channel} has the wrong size", len(content), struct.calcsize(I16), "bytes")
            (self._samples[channel - 1].raw,) = struct.unpack(I16, content)

    def _terminals_show(self, counts: int) -> bool:
        tolerance = 0.1 * self._io.proof_voltage_V * self._io.counts_per_volt
        return all(abs(self._samples[channel - 1].raw - counts) <= tolerance for channel in self._io.loopback.values())

    def _inputs_text(self) -> str:
        return "".join(f", input_{channel} {self._samples[channel - 1].raw:g} counts" for channel in self._io.loopback.values())

    def _seen(self) -> str:
        return f"NMT state {self.nmt_state}, last emergency 0x{self.emergency:04X}"
