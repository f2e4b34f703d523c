"""Which number of the hidden machine each effect of the rig file's contract is, and the effects no library has."""

from __future__ import annotations

from collections.abc import Mapping

# effect → its parameters → place in the hidden machine's numbers
EFFECTS: Mapping[str, Mapping[str, str]] = {
    "coulomb_friction": {"friction": "{where}.coulomb", "temperature_slope": "{where}.coulomb_slope"},
    "stiction": {"excess": "{where}.stiction", "velocity": "{where}.stribeck"},
    "viscous_friction": {"coefficient": "{where}.viscous", "oil_share": "{where}.viscous_share"},
    "asymmetric_friction": {
        "friction_difference": "{where}.coulomb_difference",
        "coefficient_difference": "{where}.viscous_difference",
    },
    "pressure_friction": {"coefficient": "{where}.pressure_friction"},
    "backlash": {"gap": "{where}.gap"},
    "inertia_error": {"extra": "{where}.extra_mass"},
    "gravity": {"tilt_rad": "gravity"},
    "valve_deadband": {"overlap": "{where}.overlap"},
    "valve_hysteresis": {"half_width": "{where}.hysteresis"},
    "valve_null_bias": {"bias": "{where}.null"},
    "valve_saturation": {"opening": "{where}.saturation"},
    "valve_lag": {"time_constant_s": "{where}.lag", "damping_ratio": "{where}.lag_damping"},
    "valve_flow_asymmetry": {"difference": "{where}.asymmetry"},
    "transport_delay": {"delay_s": "{where}.delay"},
    "cross_leakage": {"conductance_m3_per_s_Pa": "{where}.cross"},
    "external_leakage": {"conductance_m3_per_s_Pa": "{where}.external"},
    "bulk_modulus_temperature": {"temperature_slope": "{where}.bulk_slope", "hose_temperature_slope": "{where}.hose_slope"},
    "entrained_air": {"fraction": "{where}.air"},
    "hose_compliance": {"compliance_m3_per_m3_Pa": "{where}.hose"},
    "supply_droop": {"inverse_gas_volume": "inverse_gas"},
    "return_back_pressure": {"pressure_Pa": "tank", "resistance_Pa_s2_per_m6": "tank_resistance"},
    "line_loss": {"resistance_Pa_s2_per_m6": "line_resistance"},
    "link_flexibility": {"bending_stiffness_N_m2": "bending", "damping_ratio": "damping"},
    "payload_error": {"extra_kg": "payload"},
    "link_damping_error": {"extra": "damping"},
    # of a sensor: the entry of blind.truth.measure.Sensors
    "sensor_delay": {"delay_s": "delay_s"},
    "sensor_scale": {"factor": "scale"},
    "sensor_offset": {"offset": "offset"},
    "sensor_polarity": {"sign": "polarity"},
    "sensor_quantization": {"step": "step"},
}
ADDED = ("valve_null_bias", "payload_error", "link_damping_error", "sensor_offset")  # onto what the machine has
STANDARD_GRAVITY = 9.80665
RATED_FLOW = "rated_flow"  # of a valve: no entry of the contract's effects, a number of the plant

# effect no library has → the numbers it sets, at its plain size
STRANGE: Mapping[str, Mapping[str, float]] = {
    "position_dependent_friction": {"{where}.ripple": 0.6, "{where}.pitch": 0.05},
    "soft_presliding": {"{where}.bristle": -0.9},  # relative to what it was
    "command_steps": {"{where}.command_step": 0.15},
    "curved_flow_gain": {"{where}.curvature": 2.0},
    "loose_payload_bracket": {"bracket_mass": 4.0, "bracket_rate": 40.0},
    "pump_pulsation": {"pulsation": 0.02},
}
