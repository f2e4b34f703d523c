"""A simulated Modbus unit, its TCP server and its serial line. Imports nothing else of the twin."""
