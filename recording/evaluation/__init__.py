"""What a log shows: residual vibration and spectra of the tip, plots and pages, what differs from another log, and whether the
controller run again gives the same commands.

Imports `format` and `files`.
"""
