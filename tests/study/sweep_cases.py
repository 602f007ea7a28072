"""A small sweep that the tests of sweeps share."""

from __future__ import annotations

SMALL = """
title = "a small sweep"
model = "rod"
t_end = 0.01
until = ["separation"]
rtol = 1e-8
state = { x_A_dot = -1.0 }
keep = ["theta_dot", "time_of_separation", "max_normal_force", "integral_normal_force", "case"]
chunk = 10

[law]
name = "bilinear-hertz"
reload = "virgin"
parameters = { E = 20.9e14, n = 1.764 }

[axes]
theta = { from = 0.95, to = 1.15, points = 4 }
theta_dot = [0.5, 1.0, 2.0]
mu = { from = 1.42, to = 1.8, points = 3, scale = "log" }
"""

SAMPLED = (
    SMALL.split("[axes]")[0]
    + """
[sample]
points = 32
seed = 3

[sample.ranges]
theta = [0.95, 1.2]
mu = [1.42, 1.8]
e_energetic = { from = 0.3, to = 0.9, scale = "log" }
"""
)
