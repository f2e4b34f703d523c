"""One log evidence over effects and constants together, with a model discrepancy: names with their probabilities.

Imports `data`, `fitting` and `suspects`. Rooms:

- noise: what a right model may still be off by, and how large it is
- score: how probable the logs are under one set of suspects
- judgement: shares, the hold-out's vote, and what is said
"""
