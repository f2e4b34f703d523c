"""The service: its units, who it runs as, rules for adapters and the CAN interface, and the scripts that put them on a machine.

All of it is in the wheel; the checkout's `systemd/` shows the same files. `longreach service` and the checkout's `make install` call the
same `install.sh`.
"""
