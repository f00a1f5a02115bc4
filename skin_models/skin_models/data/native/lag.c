/* A lag with one time constant on the way up and another one on the way down: see operators/lagging.py. */
#include <stdint.h>

/* z[n] = e z[n-1] + (g - e) y[n-1] + (1 - g) y[n] from z[0] = y[0], for every row of y; e and g are those of `rising` where y[n] is above
 * z[n-1], and those of `falling` elsewhere. */
void lag_either_way(const double *y, double *z, int64_t rows, int64_t samples, const double rising[2], const double falling[2])
{
    for (int64_t row = 0; row < rows; row++, y += samples, z += samples) {
        z[0] = y[0];
        for (int64_t n = 1; n < samples; n++) {
            const double *way = y[n] > z[n - 1] ? rising : falling;
            z[n] = way[0] * z[n - 1] + (way[1] - way[0]) * y[n - 1] + (1.0 - way[1]) * y[n];
        }
    }
}
