/* Spread of contacts over taxels, and the transfer function on every taxel that something reached: see spread/compiled.py.
 *
 * Taxels are sorted by cell; all arrays here but `reading` are in that order. The cost of a step follows the taxels that are near a
 * contact or still settling (the active ones), not how many there are.
 */
#include <math.h>
#include <stdint.h>
#include <string.h>

typedef struct {                            /* what changes, together in memory */
    double z[2];                            /* states of the recursion */
    double fed;                             /* N, zero between two steps */
    double share;                           /* of the contact at work, zero between two contacts */
    int32_t is_active, is_near;
} Taxel;

typedef struct {
    int32_t taxels, table_size;
    int32_t cells[3];                       /* number of cells along x, y, z */
    double origin[3], cell;                 /* m */
    const int32_t *first;                   /* (cells + 1): first taxel of every cell */
    const int32_t *order;                   /* (T): index that the user knows a taxel by */
    const double *px, *py, *pz;             /* (T) m */
    const double *nx, *ny, *nz;             /* (T) unit normals */
    const double *gain;                     /* (T) share under a contact */
    const double *table;                    /* shape at evenly spaced distances 0 .. table_reach, one entry more than intervals */
    double reach, table_reach;              /* m; of the kernel in the skin, and of the table */
    double stretch[4];                      /* what offsets across the normal are multiplied by before the table, if `stretched` */
    double a[4], g[2], c[2], direct;        /* the recursion of transmission.py, two states; unused ones are zero */
    double settled;                         /* N: a taxel that is fed nothing and answers less is at rest */
    Taxel *taxel;                           /* (T) */
    int32_t *active, *near;                 /* (T) lists */
    double *reading;                        /* (T) N, in the user's order */
    /* The contacts of this step. A contact of some radius stands for the points of an even disc. */
    const double *position, *force, *radius, *scale, *normal;   /* (C, 3) m, N, m, width relative to the table's, (C, 3) or NULL */
    const double *offsets, *weights;        /* (disc_points, 2) in units of the radius, (disc_points) */
    int32_t disc_points, active_count, near_count, stretched;
} Skin;

static double larger(double a, double b) { return a > b ? a : b; }

static int clamp(double v, int n) { return v < 0.0 ? 0 : v >= n ? n - 1 : (int)v; }

/* The cells within `reach` of `p`; returns 0 if there are none. */
static int box(const Skin *s, const double *p, double reach, int low[3], int high[3])
{
    for (int i = 0; i < 3; i++) {
        const double v = (p[i] - s->origin[i]) / s->cell, r = reach / s->cell;
        if (!(v + r >= 0.0 && v - r < s->cells[i])) return 0;
        low[i] = clamp((v - r), s->cells[i]);
        high[i] = clamp((v + r), s->cells[i]);
    }
    return 1;
}

/* The normal of the taxel nearest to `p` within `reach`; returns 0 if there is none. */
static int nearest_normal(const Skin *s, const double *p, double reach, double n[3])
{
    int low[3], high[3], best = -1;
    double best2 = reach * reach;
    if (!box(s, p, reach, low, high)) return 0;
    for (int iz = low[2]; iz <= high[2]; iz++)
        for (int iy = low[1]; iy <= high[1]; iy++) {
            const int row = (iz * s->cells[1] + iy) * s->cells[0];
            for (int t = s->first[row + low[0]]; t < s->first[row + high[0] + 1]; t++) {
                const double dx = s->px[t] - p[0], dy = s->py[t] - p[1], dz = s->pz[t] - p[2];
                const double d2 = dx * dx + dy * dy + dz * dz;
                if (d2 <= best2) { best2 = d2; best = t; }
            }
        }
    if (best < 0) return 0;
    n[0] = s->nx[best]; n[1] = s->ny[best]; n[2] = s->nz[best];
    return 1;
}

/* Two unit vectors across `n`, the first along x as far as possible: tangent() of field.py. */
static void tangent(const double n[3], double u[3], double v[3])
{
    const double axis[3] = {fabs(n[0]) < 0.9 ? 1.0 : 0.0, fabs(n[0]) < 0.9 ? 0.0 : 1.0, 0.0};
    const double dot = axis[0] * n[0] + axis[1] * n[1];
    double length = 0.0;
    for (int i = 0; i < 3; i++) { u[i] = axis[i] - dot * n[i]; length += u[i] * u[i]; }
    for (int i = 0; i < 3; i++) u[i] /= sqrt(length);
    for (int i = 0; i < 3; i++) v[i] = n[(i + 1) % 3] * u[(i + 2) % 3] - n[(i + 2) % 3] * u[(i + 1) % 3];
}

/* Adds weight * shape to the share of every taxel around `at`; returns how many taxels are now in the near list. */
static int gather(const Skin *s, const double *at, const double n[3], double scale, double weight, int count)
{
    const double reach = s->reach * scale, inverse = (s->table_size - 1) / (s->table_reach * scale), reach2 = reach * reach;
    const double amplitude = weight / (scale * scale);
    double u[3], v[3];
    int low[3], high[3];
    if (s->stretched) tangent(n, u, v);
    if (!box(s, at, reach, low, high)) return count;
    for (int iz = low[2]; iz <= high[2]; iz++)
        for (int iy = low[1]; iy <= high[1]; iy++) {
            const int row = (iz * s->cells[1] + iy) * s->cells[0];
            const double y = s->origin[1] + iy * s->cell - at[1], away = larger(larger(y, -y - s->cell), 0.0);
            const double half = away < reach ? sqrt(reach2 - away * away) : 0.0, x = at[0] - s->origin[0];
            const int end = s->first[row + clamp((x + half) / s->cell, s->cells[0]) + 1];
            for (int t = s->first[row + clamp((x - half) / s->cell, s->cells[0])]; t < end; t++) {
                const double dx = s->px[t] - at[0], dy = s->py[t] - at[1], dz = s->pz[t] - at[2];
                const double d2 = dx * dx + dy * dy + dz * dz;
                if (d2 > reach2) continue;
                const double facing = s->nx[t] * n[0] + s->ny[t] * n[1] + s->nz[t] * n[2];
                if (facing <= 0.0) continue;
                double r;
                if (s->stretched) {
                    const double pu = dx * u[0] + dy * u[1] + dz * u[2], pv = dx * v[0] + dy * v[1] + dz * v[2];
                    const double qu = s->stretch[0] * pu + s->stretch[1] * pv, qv = s->stretch[2] * pu + s->stretch[3] * pv;
                    r = sqrt(qu * qu + qv * qv) * inverse;
                    if (r > s->table_size - 1) continue;
                } else {
                    const double along = dx * n[0] + dy * n[1] + dz * n[2];
                    r = sqrt(larger(d2 - along * along, 0.0)) * inverse;
                }
                int i = (int)r;
                if (i > s->table_size - 2) i = s->table_size - 2;
                const double value = s->table[i] + (r - i) * (s->table[i + 1] - s->table[i]);
                Taxel *its = s->taxel + t;
                if (!its->is_near) { its->is_near = 1; s->near[count++] = t; }
                its->share += amplitude * s->gain[t] * facing * value;
            }
        }
    return count;
}

static void feed(Skin *s, double force, int count)
{
    double sum = 0.0;
    for (int j = 0; j < count; j++) sum += s->taxel[s->near[j]].share;
    const double scale = force / (sum > 1.0 ? sum : 1.0);
    for (int j = 0; j < count; j++) {
        const int t = s->near[j];
        Taxel *its = s->taxel + t;
        its->fed += scale * its->share;
        its->share = 0.0;
        its->is_near = 0;
        if (!its->is_active) { its->is_active = 1; s->active[s->active_count++] = t; }
    }
}

/* The transfer function on all active taxels; returns the sum of the readings, N. */
static double settle(Skin *s)
{
    const double a0 = s->a[0], a1 = s->a[1], a2 = s->a[2], a3 = s->a[3], g0 = s->g[0], g1 = s->g[1];
    const double c0 = s->c[0], c1 = s->c[1], direct = s->direct, settled = s->settled;
    const int32_t *restrict order = s->order;
    int32_t *restrict active = s->active;
    Taxel *restrict taxel = s->taxel;
    double *restrict reading = s->reading;
    const int count = s->active_count;
    double total = 0.0;
    int kept = 0;
    for (int j = 0; j < count; j++) {
        const int t = active[j];
        Taxel *its = taxel + t;
        __builtin_prefetch(taxel + active[j + 8 < count ? j + 8 : j], 1);
        const double f = its->fed, x = its->z[0], v = its->z[1];
        const double y = c0 * x + c1 * v + direct * f;
        double next0 = a0 * x + a1 * v + g0 * f, next1 = a2 * x + a3 * v + g1 * f;
        const int rests = f == 0.0 && fabs(c0 * next0) + fabs(c1 * next1) <= settled;
        its->z[0] = rests ? 0.0 : next0;
        its->z[1] = rests ? 0.0 : next1;
        its->fed = 0.0;
        its->is_active = !rests;
        reading[order[t]] = rests ? 0.0 : y;
        total += rests ? 0.0 : y;
        active[kept] = t;
        kept += !rests;
    }
    s->active_count = kept;
    return total;
}

static int spread(Skin *s, int i)
{
    const double *p = s->position + 3 * i, radius = s->radius[i];
    double n[3], u[3], v[3], q[3];
    int taxels = 0;
    if (s->normal)
        memcpy(n, s->normal + 3 * i, sizeof n);
    else if (!nearest_normal(s, p, s->reach * s->scale[i] + radius, n))
        return 0;
    if (radius <= 0.0) return gather(s, p, n, s->scale[i], 1.0, 0);
    tangent(n, u, v);
    for (int j = 0; j < s->disc_points; j++) {
        const double du = radius * s->offsets[2 * j], dv = radius * s->offsets[2 * j + 1];
        for (int k = 0; k < 3; k++) q[k] = p[k] + du * u[k] + dv * v[k];
        taxels = gather(s, q, n, s->scale[i], s->weights[j], taxels);
    }
    return taxels;
}

/* One step under the first `count` contacts; returns the sum of the readings, N. */
double skin_step(Skin *s, int32_t count)
{
    s->near_count = 0;
    for (int i = 0; i < count; i++) {
        const int taxels = spread(s, i);
        s->near_count += taxels > 0;
        feed(s, s->force[i], taxels);
    }
    return settle(s);
}
