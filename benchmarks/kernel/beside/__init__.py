"""The simulation kernel beside other ways to the same motion: C written for this, and scipy's stiff solvers."""
