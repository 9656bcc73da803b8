"""The vision line of benchmarks/vision_line.cpp in the Python package `uncertainties`.

Prints the median time in nanoseconds of one evaluation with the covariance of its four components.
"""
import statistics
import time

from uncertainties import covariance_matrix, ufloat
from uncertainties.umath import sqrt

FOCAL_LENGTH, STRIPE_SPACING, POINT_SPACING = 6e-3, 0.3, 1.0


def vision_line(height, y_l, y_c, y_r):
    scale = FOCAL_LENGTH * height
    z_c = scale / y_c
    sine = (scale / y_l - scale / y_r) / STRIPE_SPACING
    cosine = sqrt(1.0 - sine * sine)
    return 0.0 * z_c, z_c, POINT_SPACING * cosine, z_c - POINT_SPACING * sine


def time_of(height):
    rows = [ufloat(y, 10e-6) for y in (1.05e-3, 1.0e-3, 0.97e-3)]
    rounds, times = 200, []
    for _ in range(15):
        start = time.perf_counter_ns()
        for _ in range(rounds):
            covariance_matrix(vision_line(height, *rows))
        times.append((time.perf_counter_ns() - start) / rounds)
    return statistics.median(times)


print(f"rows_uncertain {time_of(0.2):.0f}")
print(f"height_uncertain_too {time_of(ufloat(0.2, 0.2e-3)):.0f}")
