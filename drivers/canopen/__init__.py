"""CANopen devices: encoders (CiA 406), valves (CiA 408), analogue I/O (CiA 401) on one shared bus."""
