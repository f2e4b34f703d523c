"""What every driver must do, as tests for pytest. A driver's test file, of ours or a plug-in's, subclasses one of these and says how
to make one: OutputContract for a driver with outputs, DriverContract for one that only reads. No other module imports this one: the
daemon needs no pytest.
"""

from __future__ import annotations

import time
from math import inf, nan

import pytest

from drivers.contract import Driver, Quality

Outputs = tuple[float, ...]


class DriverContract:
    """What holds with and without outputs. `make` gives a fresh driver."""

    def make(self) -> Driver:
        raise NotImplementedError

    def fresh_time(self) -> int:
        """The clock that read and write are given."""
        return time.monotonic_ns()

    def active(self) -> Driver:
        driver = self.make()
        driver.open()
        driver.configure()
        driver.activate()
        return driver

    def test_whole_life_in_order(self) -> None:
        driver = self.active()
        assert len(driver.read(self.fresh_time())) == len(driver.inputs)
        driver.safe()
        driver.close()

    def test_a_driver_with_outputs_keeps_the_contract_of_outputs(self) -> None:
        assert isinstance(self, OutputContract) or not self.make().outputs, "derive its test from OutputContract"

    def test_channels_have_unique_names(self) -> None:
        driver = self.make()
        assert len(set(driver.inputs)) == len(driver.inputs)
        assert len(set(driver.outputs)) == len(driver.outputs)

    def test_one_sample_for_every_input_before_activate(self) -> None:
        driver = self.make()
        driver.open()
        driver.configure()
        assert len(driver.read(self.fresh_time())) == len(driver.inputs)
        driver.close()

    def test_ages_are_not_negative_and_stamps_never_go_back(self) -> None:
        driver = self.active()
        last = [0] * len(driver.inputs)
        for _ in range(20):
            now = self.fresh_time()
            samples = driver.read(now)
            assert all(sample.stamp_ns <= now for sample in samples)
            assert all(sample.stamp_ns >= before for sample, before in zip(samples, last, strict=True))
            last = [sample.stamp_ns for sample in samples]
        driver.close()

    def test_a_good_sample_has_a_finite_value(self) -> None:
        driver = self.active()
        for sample in driver.read(self.fresh_time()):
            assert sample.quality in tuple(Quality)
            assert sample.quality == Quality.BAD or abs(sample.raw) < inf
        driver.close()

    def test_safe_twice_and_at_any_time(self) -> None:
        driver = self.make()
        driver.safe()
        driver.open()
        driver.safe()
        driver.configure()
        driver.activate()
        driver.safe()
        driver.safe()
        driver.close()
        driver.safe()

    def test_it_is_read_after_safe_as_before(self) -> None:
        driver = self.active()
        driver.safe()
        assert len(driver.read(self.fresh_time())) == len(driver.inputs)
        driver.close()

    def test_read_after_close_is_refused(self) -> None:
        driver = self.active()
        driver.close()
        with pytest.raises(Exception, match=r"\w"):  # it says something
            driver.read(self.fresh_time())


class OutputContract(DriverContract):
    """And what holds of outputs. `actual_outputs`: what the device does now, seen past the driver, also after close()."""

    safe_outputs: Outputs

    def actual_outputs(self, driver: Driver) -> Outputs:
        raise NotImplementedError

    def a_command(self, driver: Driver) -> list[float]:
        return [0.5 + 0.25 * number for number in range(len(driver.outputs))]

    def test_whole_life_in_order(self) -> None:
        driver = self.active()
        assert self.actual_outputs(driver) == self.safe_outputs
        driver.read(self.fresh_time())
        driver.write(self.a_command(driver), self.fresh_time())
        assert self.actual_outputs(driver) == tuple(self.a_command(driver))
        driver.safe()
        assert self.actual_outputs(driver) == self.safe_outputs
        driver.close()

    def test_nothing_acts_before_activate(self) -> None:
        driver = self.make()
        driver.open()
        driver.configure()
        driver.read(self.fresh_time())
        assert self.actual_outputs(driver) == self.safe_outputs
        driver.close()

    def test_safe_ends_a_command_at_once_and_twice_is_no_harm(self) -> None:
        driver = self.active()
        driver.write(self.a_command(driver), self.fresh_time())
        driver.safe()
        driver.safe()
        assert self.actual_outputs(driver) == self.safe_outputs
        driver.close()

    def test_write_before_activate_is_refused(self) -> None:
        driver = self.make()
        driver.open()
        driver.configure()
        with pytest.raises(Exception, match="activ"):
            driver.write(self.a_command(driver), self.fresh_time())
        assert self.actual_outputs(driver) == self.safe_outputs
        driver.close()

    def test_write_after_safe_needs_a_new_activate(self) -> None:
        driver = self.active()
        driver.safe()
        with pytest.raises(Exception, match="activ"):
            driver.write(self.a_command(driver), self.fresh_time())
        driver.activate()
        assert self.actual_outputs(driver) == self.safe_outputs
        driver.write(self.a_command(driver), self.fresh_time())
        assert self.actual_outputs(driver) == tuple(self.a_command(driver))
        driver.close()

    def test_close_makes_the_outputs_safe(self) -> None:
        driver = self.active()
        driver.write(self.a_command(driver), self.fresh_time())
        assert self.actual_outputs(driver) == tuple(self.a_command(driver))
        driver.close()
        assert self.actual_outputs(driver) == self.safe_outputs

    def test_write_after_close_is_refused(self) -> None:
        driver = self.active()
        driver.close()
        with pytest.raises(Exception, match="open"):
            driver.write(self.a_command(driver), self.fresh_time())

    @pytest.mark.parametrize("surplus", [-1, 1])
    def test_wrong_number_of_outputs_is_refused_and_safe(self, surplus: int) -> None:
        driver = self.active()
        driver.write(self.a_command(driver), self.fresh_time())
        with pytest.raises(Exception, match="number"):
            driver.write([0.1] * (len(driver.outputs) + surplus), self.fresh_time())
        assert self.actual_outputs(driver) == self.safe_outputs
        driver.close()

    @pytest.mark.parametrize("bad", [nan, inf, -inf])
    def test_command_that_is_no_number_is_refused_and_safe(self, bad: float) -> None:
        driver = self.active()
        driver.write(self.a_command(driver), self.fresh_time())
        with pytest.raises(Exception, match="finite"):
            driver.write([*self.a_command(driver)[:-1], bad], self.fresh_time())
        assert self.actual_outputs(driver) == self.safe_outputs
        driver.close()
