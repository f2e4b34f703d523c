"""What tests share: rigs, logs, simulated devices, a daemon. Tests import it from here, whatever folder they are in."""
