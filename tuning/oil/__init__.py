"""Friction, flow and stiffness over the oil's temperature: tables from runs or logs, the warm-up study.

Imports `experiments`, `responses` and `paper.row`.
"""
