"""Misprints and doubtful statements of the paper, each with what is right and the row of the acceptance table that shows it."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True, slots=True)
class Misprint:
    """`row`: the row that computes the corrected statement, 0 where only reading or dimensions decide."""

    where: str
    printed: str
    right: str
    row: int = 0


MISPRINTS = (
    Misprint("Eq 1", "numerator K_ce/A_p", "K_q/A_p: the other has the wrong dimension, and only this one linearises to the joint", 2),
    Misprint("text under Eq 1", "mass M_p", "total mass M_t, as in the formula"),
    Misprint(
        "Section II",
        "the low-frequency gain drifts because the bulk modulus falls",
        "the bulk modulus is not in the low-frequency gain; leakage past friction changes it with viscosity",
        9,
    ),
    Misprint("Eqs 2 and 3", "–", "right as printed", 5),
    Misprint("Eq 4", "no units", "degrees per volt: radians per volt would need a valve far beyond its class", 3),
    Misprint(
        "after Fig 6",
        "the curves meet the −jω axis",
        "they end on the negative imaginary axis for H_s > H_c only; for H_s = H_c they stay left of −1",
        6,
    ),
    Misprint(
        "after Fig 6",
        "intersections at 5 to 6 Hz confirm the observed cycle",
        "Eq 4 crosses far below 1 Hz or not at all; 5–6 Hz are gain crossovers, or cycles at more than twice the gain",
        7,
    ),
    Misprint(
        "Section II",
        "the 5 Hz cycle comes from friction and compliance",
        "the loaded link, undamped by the joint, gives it at unity gain",
        8,
    ),
    Misprint("Eq 5", "vector x", "scalar x: r = x i + u j"),
    Misprint("Eq 6", "(q̇_r − u q̇_p) i + (u̇ + x q̇_p) j", "(q̇_p − u q̇_r) i + (u̇ + q̇_p u′ + x q̇_r) j", 16),
    Misprint(
        "Eq 7", "no cross terms, arguments q_r", "−2 u q̇_p q̇_r + 2 x q̇_r Du/Dt added, arguments q_p; retracted tube and hub move too", 16
    ),
    Misprint("Eq 8", "a stray prime on u″", "½ ∫ EI u″² dx"),
    Misprint("Eq 9", "work of the actuators", "holds for virtual work: δW = τ δq_r + F_p δq_p"),
    Misprint("Eq 10", "one product", "a sum over modes, as the text says"),
    Misprint("Eq 11", "φ(q_r), q³ in the stiffness, no q̇_r² term", "φ(q_p), q², and the centrifugal −(M q_p + ½ρA q_p²) q̇_r²", 15),
    Misprint("Eq 12", "φ′φ in the inertia, M q_p² in the Coriolis factor", "φ², 2 M q_p + ρA q_p², and the missing coupling to q̈", 16),
    Misprint("Eq 13", "q̇_p after the second bracket, φ‴φ″", "q q̈_p, φ″²; modal inertia and centrifugal terms were missing", 16),
    Misprint(
        "Eqs 11–13",
        "a shape fixed in space",
        "the shape must stretch with the link, or its frequency is wrong as soon as the length changes",
        13,
    ),
    Misprint("Eq 14", "e^{+2ζω_nT} twice, F(z) with e^{−sT}", "e^{−2ζω_nT}; in discrete time z^{−n} with T = n T_s", 19),
    Misprint("Section I", "delayed by half the oscillation frequency", "by half its period", 19),
    Misprint(
        "Section I", "single plane of vibration criticised", "the round tube has two planes as well; only one is modelled and controlled"
    ),
    Misprint("Section II", "“The rotary actuator on the is”", "a word is missing"),
    Misprint("numbering", "Section VI follows IV", "V is missing"),
)
