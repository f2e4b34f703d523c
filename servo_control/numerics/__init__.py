"""Small mathematics that several rooms need: linear tables, normal equations, limits on value and rate.

Imports nothing; every room of servo_control may import it.
"""
