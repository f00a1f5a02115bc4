/* The play operator of rate-independent hysteresis: see operators/play.py. */
#include <stdint.h>

/* p[n] = min(x[n] + r, max(x[n] - r, p[n-1])) from p[0] = x[0], for every row of x. */
void play(const double *x, double *p, int64_t rows, int64_t samples, double r)
{
    for (int64_t row = 0; row < rows; row++, x += samples, p += samples) {
        double last = x[0];
        for (int64_t n = 0; n < samples; n++) {
            double low = x[n] - r, high = x[n] + r;
            last = last > low ? last : low;
            last = last < high ? last : high;
            p[n] = last;
        }
    }
}
