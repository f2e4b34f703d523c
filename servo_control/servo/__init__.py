"""The servo of one joint: lag-lead compensator, velocity, friction and oil compensation, the notch at the link's frequency.

Imports `numerics` and `link`.
"""
