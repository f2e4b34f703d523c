"""Least-norm solution of linear conditions, in plain floats: the same to the last bit on every computer.

c = Q⁻¹Jᵀ(JQ⁻¹Jᵀ)⁻¹ r: the Lagrange multipliers of (S4), docs/method/shaping.md.
"""

from __future__ import annotations

Matrix = list[list[float]]


def least_norm(metric: Matrix, band: int, conditions: Matrix, wanted: list[float], ridge: float) -> list[float]:
    """The c with J c = wanted and least cᵀQc. Q: symmetric, positive definite, 0 beyond `band` off its diagonal.

    `ridge` (of the largest diagonal element of JQ⁻¹Jᵀ) keeps conditions that ask nearly the same from asking for much.
    """
    spread = _solved(metric, band, conditions)  # rows of Q⁻¹Jᵀ, transposed
    normal = [[sum([a * b for a, b in zip(one, other, strict=True)]) for other in conditions] for one in spread]
    largest = max(normal[k][k] for k in range(len(normal)))
    for k in range(len(normal)):
        normal[k][k] += ridge * largest
    (multipliers,) = _solved(normal, len(normal), [wanted])
    return [sum([m * row[i] for m, row in zip(multipliers, spread, strict=True)]) for i in range(len(metric))]


def _solved(matrix: Matrix, band: int, right: Matrix) -> Matrix:
    """Solutions of matrix · x = r for every r, by elimination; the matrix is symmetric and positive definite, so no pivots are needed."""
    size = len(matrix)
    a, solutions = [list(row) for row in matrix], [list(r) for r in right]
    for k in range(size):
        end = min(k + band + 1, size)
        for i in range(k + 1, end):
            factor = a[i][k] / a[k][k]
            if factor == 0.0:
                continue
            for j in range(k, end):
                a[i][j] -= factor * a[k][j]
            for x in solutions:
                x[i] -= factor * x[k]
    for x in solutions:
        for k in range(size - 1, -1, -1):
            end = min(k + band + 1, size)
            x[k] = (x[k] - sum([a[k][j] * x[j] for j in range(k + 1, end)])) / a[k][k]
    return solutions
