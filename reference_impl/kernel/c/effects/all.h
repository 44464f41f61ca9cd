/* All effects of a chain: the table of their functions, and the sums that an evaluation needs. */
#ifndef ALL_EFFECTS_H
#define ALL_EFFECTS_H

#include "drag.h"
#include "joint_spring_damper.h"
#include "joint_torque.h"
#include "oblateness.h"
#include "quadrupole.h"
#include "slender.h"
#include "solar_pressure.h"
#include "third_body.h"
#include "thrust.h"

/* In the order of KINDS in effects.py. */
static const struct {
    const char *name;
    void (*add)(const void *own, real t_s, const real *y, const scene *s);
    bool (*ended)(void *own, real t_s, const real *y, const scene *s); /* NULL: no state events */
} EFFECTS[] = {
    {"drag", add_drag, drag_mode_ended},
    {"joint_spring_damper", add_joint_spring_damper, NULL},
    {"joint_torque", add_joint_torque, NULL},
    {"oblateness", add_oblateness, NULL},
    {"quadrupole", add_quadrupole, NULL},
    {"slender", add_slender, NULL},
    {"solar_pressure", add_solar_pressure, solar_mode_ended},
    {"third_body", add_third_body, NULL},
    {"thrust", add_thrust, NULL},
};

/* Add all effects to rows G, ANGULAR and to the sums of the effects; gravity, if any, has computed positions. */
static void add_effects(real t_s, const real *y, pair mean, const chain *chain, workspace *work)
{
    int64_t n = chain->bars.columns;
    if (chain->gravity == NO_GRAVITY)
        mean = centres_from_first(n, chain->bars.value, work->bars.value);
    scene s = scene_of(chain, work, mean.x, mean.y);
    s.common[MEAN_X] = mean.x;
    s.common[MEAN_Y] = mean.y;
    s.common[COMMON_X] = s.common[COMMON_Y] = s.common[NONCENTRAL_X] = s.common[NONCENTRAL_Y] = 0.0;
    for (int64_t i = 0; i < n; i++)
        s.ax[i] = s.ay[i] = 0.0;
    for (int64_t e = 0; e < chain->effect_count; e++)
        EFFECTS[chain->effects[e]->kind].add(chain->effects[e]->own, t_s, y, &s);
    for (int64_t i = 0; i < n; i++) {
        s.gx[i] += s.ax[i];
        s.gy[i] += s.ay[i];
    }
}

/* Whether a mode of any effect has ended, at a state with valid rows U and D; each effect samples its state. */
static bool any_mode_ended(real t_s, const real *y, pair mean, const chain *chain, workspace *work)
{
    scene s = scene_of(chain, work, mean.x, mean.y);
    bool seen = false;
    for (int64_t e = 0; e < chain->effect_count; e++) {
        const effect *one = chain->effects[e];
        if (EFFECTS[one->kind].ended)
            seen = EFFECTS[one->kind].ended(one->own, t_s, y, &s) || seen;
    }
    return seen;
}

/* Whether the motion may end a mode of any effect. */
static bool has_state_events(const chain *chain)
{
    bool found = false;
    for (int64_t e = 0; e < chain->effect_count; e++)
        found = found || EFFECTS[chain->effects[e]->kind].ended;
    return found;
}

#endif
