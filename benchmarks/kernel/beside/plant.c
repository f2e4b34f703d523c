/* The shipped testbed in C, for comparison only: written from docs/method/plant.md, whose equations the numbers (P1) to (P35) name.
   It has what that rig file has (two valve-driven joints, LuGre friction, sliding flexible link, heat, sensors) and no switch for
   anything else. Classical Runge-Kutta, `steps` equal steps a period, as the kernel does. Build: cc -O3 -march=native -shared -fPIC. */
#include <math.h>
#include <stdint.h>

typedef struct {
    double low, high, stop_k, stop_c, area_a, area_b, volume_a, volume_b, volume_at, flow, full_scale, slew, rounding, laminar;
    double valve_rate, valve_damping, hysteresis, saturation, null, leak, bulk_t, hose_t, air, hose, coulomb, coulomb_t, stiction;
    double stribeck, viscous, oil_share, sigma0, sigma1, fade;
} Joint;

typedef struct {
    Joint joint[2];
    double ei, zeta, hub, hub_inertia, m, tube, carriage, payload, supply, tank, bulk, bulk_p, vapour, walther_a, walther_b;
    double rho_c, ambient, cap_r, ua_r, cap_h, ua_hi, ua_ho, cap_m, ua_mi, ua_mo, share_m, pump_q, bypass, pump_loss;
    int sensors;
    double noise[16], keep[16];
    int signal[16];
} Rig;

typedef struct {  /* held for a period or a step */
    double liquid[2], hose[2], leak[2], coulomb[2], viscous[2], wanted[2], air[2][2], inverse[2][2], damping, h;
} Held;

enum { POS, VEL, SPOOL, RATE, PA, PB, Z, TAKEN, JOINT };
enum { N1 = 2 * JOINT, N2, N1D, N2D, STATES };
enum { T_R, T_H, T_M, T_LINE, T_OUT, T_OIL, STORES };

static const double P0 = 101325.0, PI = 3.14159265358979323846;
static const double MM[3] = {33.0 / 140, 17.0 / 280, 19.0 / 630}, DD[3] = {6.0 / 35, 1.0 / 14, 26.0 / 315};
static const double GG[2][2] = {{33.0 / 280, -1.0 / 140}, {19.0 / 280, 19.0 / 1260}}, KK[2] = {3.0, 36.0 / 5};
static const double PP[2] = {3.0 / 8, 3.0 / 20}, XX[2] = {11.0 / 40, 1.0 / 12};

static double clip(double x, double low, double high) { return x < low ? low : x > high ? high : x; }

/* beta_e / V by (P8), (P9); the air's power law expanded about the pressure at the step's start */
static double stiffness(const Rig *r, const Held *k, int j, int side, double volume, double gauge) {
    double liquid = k->liquid[j] + r->bulk_p * gauge, s = (gauge + P0) * k->inverse[j][side] - 1.0, share, air;
    if (fabs(s) < 0.1) {
        share = k->air[j][side] * (1.0 + s * (-5.0 / 6 + s * (55.0 / 72)));
        air = k->air[j][side] * k->inverse[j][side] / 1.2 * (1.0 + s * (-11.0 / 6 + s * (187.0 / 72 - s * (4301.0 / 1296))));
    } else {
        double absolute = gauge + P0;
        share = r->joint[j].air * sqrt(P0 / absolute) * cbrt(P0 / absolute);
        air = share / (1.2 * absolute);
    }
    return liquid / (volume * (1.0 - share + (k->hose[j] + air) * liquid));
}

static double root(double drop, double delta4) { return drop / sqrt(sqrt(drop * drop + delta4)); } /* (P5), delta4 is delta squared squared */

static double gaussian(double v, double scale) {
    double q = v / scale;
    return fabs(q) < 6.0 ? exp(-q * q) : 0.0;
}

/* (P3) to (P7), (P14) to (P16), (P19); returns the force on the load */
static double joint_rates(const Rig *r, const Held *k, int j, const double *y, double *d) {
    const Joint *q = &r->joint[j];
    double spool = y[SPOOL], rate = y[RATE], w = q->valve_rate;
    double acceleration = w * (w * (k->wanted[j] - spool) - 2.0 * q->valve_damping * rate), speed = clip(rate, -q->slew, q->slew);
    if ((rate >= q->slew && acceleration > 0) || (rate <= -q->slew && acceleration < 0)) acceleration = 0;
    d[SPOOL] = speed;
    d[RATE] = acceleration;
    double a = fmax(y[PA], r->vapour), b = fmax(y[PB], r->vapour), travel = y[POS] - q->volume_at, v = y[VEL];
    double rise_a = stiffness(r, k, j, 0, q->volume_a + q->area_a * travel, a);
    double rise_b = stiffness(r, k, j, 1, q->volume_b - q->area_b * travel, b);
    double edge = sqrt(spool * spool + q->rounding * q->rounding), opened = 0.5 * (edge + spool), closed = 0.5 * (edge - spool);
    double la = 0.5 * k->h * q->flow * edge * rise_a, lb = 0.5 * k->h * q->flow * edge * rise_b;
    double laminar = q->laminar * q->laminar;
    la = fmax(laminar, la * la * la * la);
    lb = fmax(laminar, lb * lb * lb * lb);
    double a_in = q->flow * opened * root(r->supply - a, la), a_out = q->flow * closed * root(a - r->tank, la);
    double b_in = q->flow * closed * root(r->supply - b, lb), b_out = q->flow * opened * root(b - r->tank, lb);
    double leak = k->leak[j] * (a - b);
    d[PA] = rise_a * (a_in - a_out - q->area_a * v - leak);
    d[PB] = rise_b * (b_in - b_out + q->area_b * v + leak);
    d[TAKEN] = a_in + b_in;
    double level = k->coulomb[j] + q->stiction * gaussian(v, q->stribeck), relax = q->sigma0 * fabs(v) / level;
    double zd = v - relax * y[Z];
    if (relax * k->h > 2.0) zd *= 2.0 / (relax * k->h);
    d[Z] = zd;
    d[POS] = v;
    double friction = q->sigma0 * y[Z] + q->sigma1 * gaussian(v, q->fade) * zd + k->viscous[j] * v, stop = 0, depth;
    if ((depth = q->low - y[POS]) > 0) stop = q->stop_k * depth * fmax(1.0 - q->stop_c * v, 0);
    else if ((depth = y[POS] - q->high) > 0) stop = -q->stop_k * depth * fmax(1.0 + q->stop_c * v, 0);
    return q->area_a * a - q->area_b * b - friction + stop;
}

/* (P25) by Christoffel: M q'' = Q - M' q' + 1/2 q' dM/dq q' - dV/dq; coordinates theta, L, eta 1, eta 2 */
static void arm_rates(const Rig *r, const Held *k, const double *y, const double *force, double *d) {
    double L = y[JOINT + POS], n[2] = {y[N1], y[N2]}, v[4] = {y[VEL], y[JOINT + VEL], y[N1D], y[N2D]};
    double m = r->m, tip = r->payload, a = r->hub, reach = a + L, inner = reach - r->tube, line = m * L, per = 1.0 / L;
    double E[3] = {line * MM[0] + tip, line * MM[1], line * MM[2]};
    double En[2] = {E[0] * n[0] + E[1] * n[1], E[1] * n[0] + E[2] * n[1]}, Dn[2] = {DD[0] * n[0] + DD[1] * n[1], DD[1] * n[0] + DD[2] * n[1]};
    double nDn = n[0] * Dn[0] + n[1] * Dn[1], nMn = MM[0] * n[0] * n[0] + 2 * MM[1] * n[0] * n[1] + MM[2] * n[1] * n[1];
    double lever[2] = {m * (a * PP[0] + 2 * L * (XX[0] - PP[0])) - tip, m * (a * PP[1] + 2 * L * (XX[1] - PP[1]))};
    double tt = r->hub_inertia + m / 3 * (reach * reach * reach - inner * inner * inner) + tip * reach * reach + n[0] * En[0] + n[1] * En[1];
    double tl = lever[0] * n[0] + lever[1] * n[1], t[2] = {line * (a * PP[0] + L * XX[0]) + tip * reach, line * (a * PP[1] + L * XX[1])};
    double ll = m * r->tube + r->carriage + tip + m * per * nDn;
    double l[2] = {m * (GG[0][0] * n[0] + GG[0][1] * n[1]), m * (GG[1][0] * n[0] + GG[1][1] * n[1])};
    /* derivatives of M with L */
    double tt_L = m * (reach * reach - inner * inner) + 2 * tip * reach + m * nMn;
    double tl_L = 2 * m * ((XX[0] - PP[0]) * n[0] + (XX[1] - PP[1]) * n[1]), ll_L = -m * per * per * nDn;
    double t_L[2] = {m * (a * PP[0] + 2 * L * XX[0]) + tip, m * (a * PP[1] + 2 * L * XX[1])};
    double vMv = MM[0] * v[2] * v[2] + 2 * MM[1] * v[2] * v[3] + MM[2] * v[3] * v[3];
    double Mv[2] = {m * (MM[0] * v[2] + MM[1] * v[3]), m * (MM[1] * v[2] + MM[2] * v[3])};
    /* M' q' : rates of the entries along the motion */
    double tt_d = tt_L * v[1] + 2 * (En[0] * v[2] + En[1] * v[3]), tl_d = tl_L * v[1] + lever[0] * v[2] + lever[1] * v[3];
    double t_d[2] = {t_L[0] * v[1], t_L[1] * v[1]}, ll_d = ll_L * v[1] + 2 * m * per * (Dn[0] * v[2] + Dn[1] * v[3]);
    double l_d[2] = {m * (GG[0][0] * v[2] + GG[0][1] * v[3]), m * (GG[1][0] * v[2] + GG[1][1] * v[3])};
    double q_t = force[0] - (tt_d * v[0] + tl_d * v[1] + t_d[0] * v[2] + t_d[1] * v[3]);
    double q_l = force[1] - (tl_d * v[0] + ll_d * v[1] + l_d[0] * v[2] + l_d[1] * v[3]);
    double q_n[2];
    /* 1/2 q' dM/dq q' */
    q_l += 0.5 * (tt_L * v[0] * v[0] + ll_L * v[1] * v[1] + m * vMv) + v[0] * (tl_L * v[1] + t_L[0] * v[2] + t_L[1] * v[3]);
    double bend = r->ei * per * per * per;
    q_l += 1.5 * per * bend * (KK[0] * n[0] * n[0] + KK[1] * n[1] * n[1]);
    for (int i = 0; i < 2; i++) {
        double along = m * v[1] * (GG[0][i] * v[2] + GG[1][i] * v[3]);
        q_n[i] = -(t_d[i] * v[0] + l_d[i] * v[1] + Mv[i] * v[1]) + En[i] * v[0] * v[0] + lever[i] * v[0] * v[1] + m * per * Dn[i] * v[1] * v[1] + along
               - bend * KK[i] * n[i] - k->damping * KK[i] * v[2 + i];
    }
    double inv = 1.0 / (E[0] * E[2] - E[1] * E[1]);
    double ut[2] = {(E[2] * t[0] - E[1] * t[1]) * inv, (E[0] * t[1] - E[1] * t[0]) * inv};
    double ul[2] = {(E[2] * l[0] - E[1] * l[1]) * inv, (E[0] * l[1] - E[1] * l[0]) * inv};
    double a11 = tt - t[0] * ut[0] - t[1] * ut[1], a12 = tl - t[0] * ul[0] - t[1] * ul[1], a22 = ll - l[0] * ul[0] - l[1] * ul[1];
    double f1 = q_t - ut[0] * q_n[0] - ut[1] * q_n[1], f2 = q_l - ul[0] * q_n[0] - ul[1] * q_n[1], det = 1.0 / (a11 * a22 - a12 * a12);
    double theta = (a22 * f1 - a12 * f2) * det, length = (a11 * f2 - a12 * f1) * det;
    double w0 = q_n[0] - t[0] * theta - l[0] * length, w1 = q_n[1] - t[1] * theta - l[1] * length;
    d[VEL] = theta;
    d[JOINT + VEL] = length;
    d[N1] = v[2];
    d[N2] = v[3];
    d[N1D] = (E[2] * w0 - E[1] * w1) * inv;
    d[N2D] = (E[0] * w1 - E[1] * w0) * inv;
}

static void rates(const Rig *r, const Held *k, const double *y, double *d) {
    double force[2] = {joint_rates(r, k, 0, y, d), joint_rates(r, k, 1, y + JOINT, d + JOINT)};
    arm_rates(r, k, y, force, d);
}

static double viscosity(const Rig *r, double celsius) { return pow(10, pow(10, r->walther_a - r->walther_b * log10(celsius + 273.15))) - 0.7; }

static double frequency(const Rig *r, double L, int second) {
    double line = r->m * L, a = line * MM[0] + r->payload, b = line * MM[1], c = line * MM[2], s = r->ei / (L * L * L);
    double det = a * c - b * b, half = 0.5 * (a * s * KK[1] + c * s * KK[0]), product = s * s * KK[0] * KK[1], square = sqrt(half * half - det * product);
    return second ? sqrt((half + square) / det) : sqrt(product / (half + square));
}

/* (P9), (P17), (P26): what holds for a period */
static void hold(const Rig *r, Held *k, const double *y, double oil, double reference) {
    double thin = reference / viscosity(r, oil), warm = oil - 40.0, L = y[JOINT + POS];
    for (int j = 0; j < 2; j++) {
        const Joint *q = &r->joint[j];
        k->liquid[j] = r->bulk * (1 + q->bulk_t * warm);
        k->hose[j] = q->hose / (1 + q->hose_t * warm);
        k->leak[j] = q->leak * thin;
        k->coulomb[j] = q->coulomb * (1 + q->coulomb_t * warm);
        k->viscous[j] = q->viscous * (1 - q->oil_share + q->oil_share / thin);
    }
    k->damping = 2 * r->zeta / frequency(r, L, 0) * r->ei / (L * L * L);
}

static void step(const Rig *r, Held *k, double *y) {
    double d[STATES], sum[STATES], at[STATES], h = k->h;
    for (int j = 0; j < 2; j++)
        for (int side = 0; side < 2; side++) {
            double absolute = fmax(y[j * JOINT + PA + side], r->vapour) + P0, ratio = P0 / absolute;
            k->air[j][side] = r->joint[j].air * sqrt(ratio) * cbrt(ratio);
            k->inverse[j][side] = 1.0 / absolute;
        }
    rates(r, k, y, d);
    for (int i = 0; i < STATES; i++) { sum[i] = d[i]; at[i] = y[i] + 0.5 * h * d[i]; }
    rates(r, k, at, d);
    for (int i = 0; i < STATES; i++) { sum[i] += 2 * d[i]; at[i] = y[i] + 0.5 * h * d[i]; }
    rates(r, k, at, d);
    for (int i = 0; i < STATES; i++) { sum[i] += 2 * d[i]; at[i] = y[i] + h * d[i]; }
    rates(r, k, at, d);
    for (int i = 0; i < STATES; i++) y[i] += h / 6 * (sum[i] + d[i]);
    for (int j = 0; j < 2; j++) if (fabs(y[j * JOINT + SPOOL]) > 1) { y[j * JOINT + SPOOL] = copysign(1, y[j * JOINT + SPOOL]); y[j * JOINT + RATE] = 0; }
}

static double approach(double wall, double oil, double ua, double q) { return q < 1e-9 ? wall : wall + (oil - wall) * exp(-ua / q); }

/* (P30) to (P32) */
static void heat(const Rig *r, double *s, double flow, double period) {
    if (flow < 0) flow = 0;
    double q = r->rho_c * flow, lost = r->supply * flow, line = approach(s[T_H], s[T_R], r->ua_hi, q);
    double in = line + (q >= 1e-9 ? (1 - r->share_m) * lost / q : 0), out = approach(s[T_M], in, r->ua_mi, q);
    double back = approach(r->ambient, out, 0.5 * r->ua_ho, q), spare = r->pump_q - flow;
    double to_r = r->bypass * r->supply * (spare > 0 ? spare : 0) + r->pump_loss + q * (back - s[T_R]) - r->ua_r * (s[T_R] - r->ambient);
    double to_h = q * (s[T_R] - line) - r->ua_ho * (s[T_H] - r->ambient);
    double to_m = r->share_m * lost + q * (in - out) - r->ua_mo * (s[T_M] - r->ambient);
    s[T_R] += period * to_r / r->cap_r;
    s[T_H] += period * to_h / r->cap_h;
    s[T_M] += period * to_m / r->cap_m;
    s[T_LINE] = line;
    s[T_OUT] = out;
    s[T_OIL] = s[T_M];
}

static double uniform(uint64_t *s) {
    *s ^= *s << 13; *s ^= *s >> 7; *s ^= *s << 17;
    return ((*s >> 11) + 0.5) * 0x1p-53;
}

/* first-order lag and coloured noise of every sensor (P35) */
static void sense(const Rig *r, const double *signals, double *lagged, double *coloured, uint64_t *seed) {
    for (int i = 0; i < r->sensors; i += 2) {
        double radius = 0, angle = 0;
        if (r->noise[i] > 0 || r->noise[i + 1] > 0) { radius = sqrt(-2 * log(uniform(seed))); angle = 2 * PI * uniform(seed); }
        double draw[2] = {radius * cos(angle), radius * sin(angle)};
        for (int n = i; n < i + 2 && n < r->sensors; n++) {
            double value = signals[r->signal[n]];
            lagged[n] = value + r->keep[n] * (lagged[n] - value);
            coloured[n] = r->keep[n] * coloured[n] + sqrt(1 - r->keep[n] * r->keep[n]) * draw[n - i];
        }
    }
}

/* `rows` periods: commands (rows x 2, V) in, out (rows x 8) at the start of each period: theta, L, P_A and P_B of both joints, tip
   deflection, tip acceleration (P27). y: STATES numbers, play: 2, stores: STORES, all changed in place. */
void run(const Rig *r, double *y, double *play, double *stores, const double *commands, int rows, double period, double longest, double *out) {
    Held k;
    double d[STATES], lagged[16] = {0}, coloured[16] = {0}, signals[19] = {0}, before = y[TAKEN] + y[JOINT + TAKEN];
    double reference = viscosity(r, 40.0);
    uint64_t seed = 88172645463325252ull;
    for (int j = 0; j < 2; j++) k.wanted[j] = 0;
    k.h = longest;
    hold(r, &k, y, stores[T_OIL], reference);
    for (int j = 0; j < 2; j++) for (int s = 0; s < 2; s++) {
        k.inverse[j][s] = 1.0 / (fmax(y[j * JOINT + PA + s], r->vapour) + P0);
        k.air[j][s] = r->joint[j].air * pow(P0 * k.inverse[j][s], 5.0 / 6);
    }
    rates(r, &k, y, d);
    for (int i = 0; i < rows; i++) {
        double row[8] = {y[POS], y[JOINT + POS], y[PA], y[PB], y[JOINT + PA], y[JOINT + PB], y[N1],
                         d[N1D] + (r->hub + y[JOINT + POS]) * d[VEL] + 2 * y[JOINT + VEL] * y[VEL] - y[N1] * y[VEL] * y[VEL]};
        for (int c = 0; c < 8; c++) out[8 * i + c] = row[c];
        double L = fmax(y[JOINT + POS], r->joint[1].low), limit = fmin(longest, 2.0 / frequency(r, L, 1));
        int steps = (int)ceil(period / limit - 1e-9);
        if (steps < 1) steps = 1;
        k.h = period / steps;
        hold(r, &k, y, stores[T_OIL], reference);
        for (int s = 0; s < steps; s++) {
            for (int j = 0; j < 2; j++) {  /* (P1), (P2) */
                const Joint *q = &r->joint[j];
                double wanted = commands[2 * i + j] / q->full_scale + q->null;
                play[j] = clip(play[j], wanted - q->hysteresis, wanted + q->hysteresis);
                k.wanted[j] = clip(play[j], -q->saturation, q->saturation);
            }
            step(r, &k, y);
        }
        rates(r, &k, y, d);
        signals[0] = y[POS]; signals[1] = y[JOINT + POS]; signals[2] = signals[3] = r->supply; signals[4] = signals[5] = r->tank;
        signals[6] = signals[7] = stores[T_LINE] + 0.35 * (stores[T_M] - stores[T_LINE]); signals[8] = signals[9] = stores[T_OUT];
        signals[14] = row[7]; signals[15] = y[N1]; signals[16] = stores[T_R];
        sense(r, signals, lagged, coloured, &seed);
        double taken = y[TAKEN] + y[JOINT + TAKEN];
        heat(r, stores, (taken - before) / period, period);
        before = taken;
    }
}
