"""The sliding flexible link: rotation, extension and two bending shapes together, (P22) to (P27) of docs/method/plant.md.

Shapes over ξ = x/L: ψ₁ = (3ξ² − ξ³)/2 (tip load) and ψ₂ = 3ξ² − 5ξ³ + 2ξ⁴ (nothing at the tip), so η₁ is the tip deflection.
The whole tube moves, also its part inside the housing; V depends on L, so the bearing's configurational force is in the L equation.
Not in the model: foreshortening (below 0.1 % of the stiffness at 0.83 rad/s), shear, the vertical bending plane.
"""

from __future__ import annotations

from math import cos, sin, sqrt

from config.schema.effect import Hook
from sim_backend.memory.compiled import compiled
from sim_backend.memory.layout import C, Vector
from sim_backend.physics.laws import hooked

_bent = hooked(Hook.BENDING)

# ∫ψψᵀ, ∫ψ″ψ″ᵀ (diagonal), ∫ψ(1−ξ)ψ′ᵀ, ∫(1−ξ)²ψ′ψ′ᵀ, ∫ψ, ∫ξψ over 0…1, and the slopes ψ′(1)
M11, M12, M22 = 33 / 140, 17 / 280, 19 / 630
K11, K22 = 3.0, 36 / 5
G11, G12, G21, G22 = 33 / 280, -1 / 140, 19 / 280, 19 / 1260
D11, D12, D22 = 6 / 35, 1 / 14, 26 / 315
P1, P2 = 3 / 8, 3 / 20
X1, X2 = 11 / 40, 1 / 12
S1, S2 = 3 / 2, -1.0


@compiled
def frequency_equation(length: float, p: Vector) -> tuple[float, float, float]:
    """Coefficients of det(K − λM) = k − 2 h λ + d λ² of the clamped link, λ = ω² (without tip inertia): d, h, k."""
    line = p[C.MASS_PER_LENGTH] * length
    a, b, c = line * M11 + p[C.PAYLOAD], line * M12, line * M22
    stiffness = p[C.BENDING_STIFFNESS] / (length * length * length)
    k1, k2 = stiffness * K11, stiffness * K22
    return a * c - b * b, 0.5 * (a * k2 + c * k1), k1 * k2


@compiled
def first_frequency(length: float, p: Vector) -> float:
    """First clamped frequency, rad/s, of the two-shape model (without tip inertia)."""
    determinant, half, product = frequency_equation(length, p)
    return sqrt(product / (half + sqrt(half * half - determinant * product)))  # the smaller root without cancellation


@compiled
def highest_frequency(length: float, p: Vector) -> float:
    """Second clamped frequency, rad/s, of the two-shape model (without tip inertia)."""
    determinant, half, product = frequency_equation(length, p)
    return sqrt((half + sqrt(half * half - determinant * product)) / determinant)


@compiled
def fastest_rate(length: float, p: Vector) -> float:
    """Largest eigenvalue of the clamped link, 1/s. Damping that grows with stiffness gives the second shape ζ₂ = ζ₁ ω₂ / ω₁; beyond 1 it
    creeps back, and springs off, at ω₂ (ζ₂ ± √(ζ₂² − 1)) instead of vibrating at ω₂."""
    second = highest_frequency(length, p)
    damping = abs(p[C.LINK_DAMPING]) * second / first_frequency(length, p)
    return second * (damping + sqrt(damping * damping - 1.0)) if damping > 1.0 else second


@compiled
def rigid_accelerations(
    theta: float, theta_d: float, length: float, length_d: float, torque: float, force: float, extra_0: float, extra_1: float, p: Vector
) -> tuple[float, float]:
    """Accelerations of rotation and extension with a rigid link; `extra` is the mass the drive trains add to or take from each."""
    m, tip = p[C.MASS_PER_LENGTH], p[C.PAYLOAD]
    reach = p[C.HUB_OFFSET] + length
    inner = reach - p[C.TUBE_LENGTH]  # a − L_r, the tube's inner end
    squares = reach * reach - inner * inner
    moment = 0.5 * m * squares + tip * reach
    inertia = (
        p[C.HUB_INERTIA]
        + p[C.PAYLOAD_INERTIA]
        + m * (1.0 / 3.0) * (reach * reach * reach - inner * inner * inner)
        + tip * reach * reach
        + extra_0
    )
    mass = m * p[C.TUBE_LENGTH] + p[C.CARRIAGE] + tip + extra_1
    if p[C.GRAVITY] != 0.0:
        torque += p[C.GRAVITY] * (moment + p[C.CARRIAGE] * inner) * sin(theta)
        force -= p[C.GRAVITY] * (mass - extra_1) * cos(theta)
    return (torque - 2.0 * moment * theta_d * length_d) / inertia, (force + moment * theta_d * theta_d) / mass


@compiled
def mass_and_bias(
    theta_d: float, length: float, length_d: float, n1: float, n2: float, n1_d: float, n2_d: float, p: Vector
) -> tuple[float, float, float, float, float, float, float, float, float, float, float, float, float, float]:
    """Mass matrix and velocity-and-stiffness forces of (θ, L, η₁, η₂): M q̈ + bias = Q.

    Returns Mθθ, MθL, Mθ1, Mθ2, MLL, ML1, ML2, M11, M12, M22, then the biases of θ, L, η₁, η₂.
    """
    m, tip, a = p[C.MASS_PER_LENGTH], p[C.PAYLOAD], p[C.HUB_OFFSET]
    reach = a + length
    inner = reach - p[C.TUBE_LENGTH]
    line = m * length
    inverse = 1.0 / length
    ratio = length_d * inverse
    # products with η and its rate
    e11, e12, e22 = line * M11 + tip, line * M12, line * M22
    mn1, mn2 = M11 * n1 + M12 * n2, M12 * n1 + M22 * n2
    en1, en2 = e11 * n1 + e12 * n2, e12 * n1 + e22 * n2
    dn1, dn2 = D11 * n1 + D12 * n2, D12 * n1 + D22 * n2
    gn1, gn2 = G11 * n1 + G12 * n2, G21 * n1 + G22 * n2
    gd1, gd2 = G11 * n1_d + G12 * n2_d, G21 * n1_d + G22 * n2_d
    pn, xn = P1 * n1 + P2 * n2, X1 * n1 + X2 * n2
    pd, xd = P1 * n1_d + P2 * n2_d, X1 * n1_d + X2 * n2_d
    ndn = n1 * dn1 + n2 * dn2
    # mass matrix
    tt = p[C.HUB_INERTIA] + m * (1.0 / 3.0) * (reach * reach * reach - inner * inner * inner) + tip * reach * reach + n1 * en1 + n2 * en2
    tl = m * (a * pn + 2.0 * length * (xn - pn)) - tip * n1
    t1, t2 = line * (a * P1 + length * X1) + tip * reach, line * (a * P2 + length * X2)
    ll = m * p[C.TUBE_LENGTH] + p[C.CARRIAGE] + tip + m * inverse * ndn
    l1, l2 = m * gn1, m * gn2
    # rates of that matrix and the rest of d/dt ∂T/∂q̇ − ∂T/∂q
    squares = reach * reach - inner * inner
    tt_d = (m * squares + 2.0 * tip * reach + m * (n1 * mn1 + n2 * mn2)) * length_d + 2.0 * (n1_d * en1 + n2_d * en2)
    tl_d = m * (a * pd + 2.0 * length * (xd - pd)) - tip * n1_d + 2.0 * m * length_d * (xn - pn)
    t_d = length_d * (m * (a * pd + 2.0 * length * xd) + tip * n1_d)
    ll_d = m * inverse * (2.0 * (n1_d * dn1 + n2_d * dn2) - ratio * ndn)
    rate_energy = n1_d * (M11 * n1_d + M12 * n2_d) + n2_d * (M12 * n1_d + M22 * n2_d)
    dt_dl = (
        0.5 * m * (theta_d * theta_d * (n1 * mn1 + n2 * mn2) + rate_energy - ratio * ratio * ndn)
        + m * theta_d * (a * pd + 2.0 * length * xd + 2.0 * length_d * (xn - pn))
        + 0.5 * m * theta_d * theta_d * squares
        + tip * theta_d * (n1_d + reach * theta_d)
    )
    stiffness = p[C.BENDING_STIFFNESS] * inverse * inverse * inverse
    bend1, bend2 = stiffness * K11 * n1, stiffness * K22 * n2
    b_theta = tt_d * theta_d + tl_d * length_d + t_d
    b_length = ll_d * length_d + tl_d * theta_d + m * (n1_d * gd1 + n2_d * gd2) - dt_dl - 1.5 * inverse * (bend1 * n1 + bend2 * n2)
    sweep = 2.0 * length_d * theta_d
    b1 = 2.0 * m * length_d * gd1 + sweep * (line * P1 + tip) - theta_d * theta_d * en1 - m * ratio * length_d * dn1 + bend1
    b2 = 2.0 * m * length_d * gd2 + sweep * line * P2 - theta_d * theta_d * en2 - m * ratio * length_d * dn2 + bend2
    if p[C.PAYLOAD_INERTIA] > 0.0:
        # tip rotation Ω = d/dt(θ + sᵀη/L): a rank-one addition J_t g gᵀ with g = (1, −sᵀη/L², s₁/L, s₂/L)
        jt = p[C.PAYLOAD_INERTIA]
        slope, slope_d = S1 * n1 + S2 * n2, S1 * n1_d + S2 * n2_d
        gl, g1, g2 = -slope / (length * length), S1 / length, S2 / length
        turn = jt * (-2.0 * ratio * slope_d / length + 2.0 * ratio * ratio * slope / length)
        tt, tl, t1, t2 = tt + jt, tl + jt * gl, t1 + jt * g1, t2 + jt * g2
        ll, l1, l2 = ll + jt * gl * gl, l1 + jt * gl * g1, l2 + jt * gl * g2
        e11, e12, e22 = e11 + jt * g1 * g1, e12 + jt * g1 * g2, e22 + jt * g2 * g2
        b_theta, b_length, b1, b2 = b_theta + turn, b_length + turn * gl, b1 + turn * g1, b2 + turn * g2
    return tt, tl, t1, t2, ll, l1, l2, e11, e12, e22, b_theta, b_length, b1, b2


@compiled
def damping_factor(length: float, p: Vector) -> float:
    """(2 ζ₁/ω₁) (EI/L³): times K̂ it is the damping matrix, with which the first mode has exactly ζ₁ at every extension."""
    if p[C.BENDING_STIFFNESS] == 0.0:
        return 0.0
    return float(2.0 * p[C.LINK_DAMPING] / first_frequency(length, p) * p[C.BENDING_STIFFNESS] / (length * length * length))


@compiled
def shape_forces(
    length: float, n1: float, n1_d: float, n2_d: float, b1: float, b2: float, damping: float, p: Vector
) -> tuple[float, float]:
    """Forces on η₁ and η₂ without gravity: stiffness, Coriolis and centrifugal (`b1`, `b2` of mass_and_bias), damping, laws of effects."""
    return _bent(-b1 - damping * K11 * n1_d, (n1, n1_d, length), 0, p), -b2 - damping * K22 * n2_d


@compiled
def flexible_accelerations(
    theta: float,
    theta_d: float,
    length: float,
    length_d: float,
    n1: float,
    n2: float,
    n1_d: float,
    n2_d: float,
    torque: float,
    force: float,
    extra_0: float,
    extra_1: float,
    damping: float,
    p: Vector,
) -> tuple[float, float, float, float]:
    """Accelerations of θ, L, η₁, η₂: the shapes are eliminated first, then two equations are left. `damping`: damping_factor()."""
    tt, tl, t1, t2, ll, l1, l2, e11, e12, e22, b_theta, b_length, b1, b2 = mass_and_bias(theta_d, length, length_d, n1, n2, n1_d, n2_d, p)
    q_theta, q_length = torque - b_theta, force - b_length
    q1, q2 = shape_forces(length, n1, n1_d, n2_d, b1, b2, damping, p)
    if p[C.GRAVITY] != 0.0:
        g_theta, g_length, g1, g2 = gravity_forces(theta, length, n1, n2, p)
        q_theta, q_length, q1, q2 = q_theta + g_theta, q_length + g_length, q1 + g1, q2 + g2
    inverse = 1.0 / (e11 * e22 - e12 * e12)
    u1, u2 = (e22 * t1 - e12 * t2) * inverse, (e11 * t2 - e12 * t1) * inverse
    v1, v2 = (e22 * l1 - e12 * l2) * inverse, (e11 * l2 - e12 * l1) * inverse
    r11 = tt + extra_0 - t1 * u1 - t2 * u2
    r12 = tl - t1 * v1 - t2 * v2
    r22 = ll + extra_1 - l1 * v1 - l2 * v2
    f1, f2 = q_theta - u1 * q1 - u2 * q2, q_length - v1 * q1 - v2 * q2
    both = 1.0 / (r11 * r22 - r12 * r12)
    theta_dd, length_dd = (r22 * f1 - r12 * f2) * both, (r11 * f2 - r12 * f1) * both
    w1, w2 = q1 - t1 * theta_dd - l1 * length_dd, q2 - t2 * theta_dd - l2 * length_dd
    return theta_dd, length_dd, (e22 * w1 - e12 * w2) * inverse, (e11 * w2 - e12 * w1) * inverse


@compiled
def gravity_forces(theta: float, length: float, n1: float, n2: float, p: Vector) -> tuple[float, float, float, float]:
    """Generalised forces of gravity in a tilted plane; θ = 0 points up the slope. The carriage sits at the tube's inner end."""
    m, tip, g = p[C.MASS_PER_LENGTH], p[C.PAYLOAD], p[C.GRAVITY]
    reach = p[C.HUB_OFFSET] + length
    inner = reach - p[C.TUBE_LENGTH]
    line = m * length
    moment = 0.5 * m * (reach * reach - inner * inner) + tip * reach + p[C.CARRIAGE] * inner
    bend = line * (P1 * n1 + P2 * n2) + tip * n1
    sine, cosine = sin(theta), cos(theta)
    weight = m * p[C.TUBE_LENGTH] + p[C.CARRIAGE] + tip
    along = -g * (weight * cosine - m * (P1 * n1 + P2 * n2) * sine)
    return g * (moment * sine + bend * cosine), along, g * (line * P1 + tip) * sine, g * line * P2 * sine


@compiled
def tip_acceleration(length: float, length_d: float, theta_d: float, theta_dd: float, n1: float, n1_dd: float, hub_offset: float) -> float:
    """Transverse acceleration of the tip in the turning frame, what a transverse accelerometer reads (ψ₂ is 0 at the tip)."""
    return n1_dd + (hub_offset + length) * theta_dd + 2.0 * length_d * theta_d - n1 * theta_d * theta_d
