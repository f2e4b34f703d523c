"""What a search leaves behind: where the gap is, the findings as JSON, the improved rig file.

Imports `data`, `balance`, `fitting`, `suspects` and `evidence`.
"""
