"""The real-time loop: the controller's step, the clock beside other clocks, the loop over two buses, for hours, how large a rig fits."""
