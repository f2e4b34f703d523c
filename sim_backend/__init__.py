"""The simulated plant. Importing it decides where compiled code is kept, before numba compiles anything."""

from sim_backend import compile_cache

compile_cache.prepare()
