"""A sensor's sign, scale and zero from readings at known values, refused where noise or residual say that they can't be believed.

Imports config. `longreach device calibrate` takes the readings and writes the calibration into the rig file.
"""
