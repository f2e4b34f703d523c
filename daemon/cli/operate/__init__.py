"""Commands that operate a rig: check, status, why, arm, disarm, reset, start, stop, estop, prove, service, twin."""
