#!/usr/bin/env python3
"""When do neighbouring pairs of the sonar ring agree about their wall? Splits the agreement that
`ilss run` counts by what may explain it:

    ilss run graphs/sonar_ring.yaml --json | docs/examples/sonar_ring/agreement.py RECORDING.csv
"""
import csv
import json
import math
import sys

PAIRS = 24
CHI_SQUARE_95 = 5.991  # of two degrees of freedom


def wrap(angle):
    return (angle + math.pi) % (2 * math.pi) - math.pi


def agree(a, b, cross):
    """Whether d^T (A + B - C - C^T)^-1 d is within its 95 % bound, C the covariance of a with b."""
    (x1, angle1), (x2, angle2) = ([c["value"] for c in w["components"]] for w in (a, b))
    x, y = x1 - x2, wrap(angle1 - angle2)
    p, q = a["covariance"], b["covariance"]
    s = [[p[i][j] + q[i][j] - cross[i][j] - cross[j][i] for j in (0, 1)] for i in (0, 1)]
    determinant = s[0][0] * s[1][1] - s[0][1] * s[1][0]
    return s[1][1] * x * x - 2 * s[0][1] * x * y + s[0][0] * y * y <= CHI_SQUARE_95 * determinant


def off_axis(pair, wall):
    """From the middle of the pair's beams to the wall's normal (degrees)."""
    return abs(math.degrees(wrap(wall["components"][1]["value"] - math.radians(15 * pair + 7.5))))


def band(value, limits, unit):
    below = 0
    for limit in limits:
        if value < limit:
            return f"{below} to {limit} {unit}"
        below = limit
    return f"{below} {unit} or more"


def main():
    with open(sys.argv[1], encoding="utf-8") as file:
        rows = list(csv.reader(line for line in file if not line.startswith("#")))[1:]
    readings = [[float(cell) for cell in row[:PAIRS]] for row in rows]
    counts = {}
    for line in sys.stdin:
        tick = json.loads(line)
        number, walls = tick["tick"], tick["output"]["outputs"]
        cross = {tuple(c["outputs"]): c["covariance"] for c in tick["output"]["cross_covariance"]}
        for first in range(PAIRS):
            second = (first + 1) % PAIRS
            low, high = sorted((first, second))
            if walls[first] is None or walls[second] is None:
                continue
            agreed = agree(walls[low], walls[high], cross.get((low, high), [[0, 0], [0, 0]]))
            sonars = [(first + k) % PAIRS for k in range(3)]
            three = [readings[number][s] for s in sonars]
            before = [readings[max(number - 1, 0)][s] for s in sonars]
            jump = max(abs(a - b) for a, b in zip(three, before))
            angle = max(off_axis(first, walls[first]), off_axis(second, walls[second]))
            spread = max(three) - min(three)
            for group in (
                "all",
                "wall's normal off the beams' axis: " + band(angle, (7.5, 18.5, 45), "deg"),
                "three readings differ by: " + band(spread, (0.05, 0.3), "m"),
                "mean reading: " + band(sum(three) / 3, (1, 2), "m"),
                "a reading's change since the last tick: " + band(jump, (0.02,), "m"),
            ):
                total = counts.setdefault(group, [0, 0])
                total[0] += 1
                total[1] += agreed
    for group, (compared, agreed) in sorted(counts.items()):
        print(f"{group:<60} {agreed:>4} of {compared:>4}  {100 * agreed / compared:4.0f} %")


if __name__ == "__main__":
    main()
