"""What each candidate effect would change in the residuals, what of it the constants cannot do, and how small it could be.

Imports `data` and `fitting`.
"""
