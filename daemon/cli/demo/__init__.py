"""`longreach demo`: the paper's maneuver on the embedded simulated rig, unshaped and shaped."""
