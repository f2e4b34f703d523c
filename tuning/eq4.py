"""The numbers of Eq 4 of the paper: rotary joint, valve command (V) to position in degrees (the paper gives no units).

θ/u = NUMERATOR / (s (s² + SUM s + PRODUCT))        SUM = a_l + b,  PRODUCT = ω_h² + a_l b  of corrected Eq 1
"""

NUMERATOR = 240810.0  # deg/V/s³
SUM_PER_S = 140.0
PRODUCT_PER_S2 = 6150.0
