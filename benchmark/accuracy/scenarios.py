"""The drives of the accuracy benchmark: one table, read by run.py, report.py and the gate."""

import collections

# name, sensors (file of config/simulation), motion (simulate --scenario), seconds, guess (False: the rig file has no
# initial extrinsics), tuned: the seeds among which constants of the code were chosen ('none': on no drive of this kind).
# Worlds do not depend on the seed, so other seeds hold out motion and noise, not places.
Scenario = collections.namedtuple('Scenario', 'name sensors motion seconds guess tuned')

SCENARIOS = [
    Scenario('handheld_lidar', 'handheld.yaml', 'handheld', 30, False, '1-10'),
    Scenario('car_4_lidars', 'paper_rig_lidars.yaml', 'figure_eight', 30, True, '1-10'),
    Scenario('dual_rosette', 'dual_rosette.yaml', 'handheld', 30, False, '1-10'),
    Scenario('handheld_stereo', 'handheld_stereo.yaml', 'handheld', 20, False, '1-3'),
    Scenario('stereo_imu', 'stereo_imu.yaml', 'handheld', 20, False, '1-3'),
    Scenario('planar_car', 'spinning_car.yaml', 'planar', 30, True, 'none'),
    # Lenses from their fields of view alone; the constants of the lens search were chosen on seed 1.
    Scenario('lens_k028', 'lens_k028.yaml', 'handheld', 20, False, '1'),
    Scenario('lens_k045_k015', 'lens_k045_k015.yaml', 'handheld', 20, False, '1'),
    Scenario('lens_k005_wide130', 'lens_k005_wide130.yaml', 'handheld', 20, False, '1'),
    Scenario('lens_fisheyes', 'lens_fisheyes.yaml', 'handheld', 20, False, '1'),
    # Short enough for every run of the tests.
    Scenario('gate', 'handheld.yaml', 'handheld', 12, False, '1-10'),
]

BY_NAME = {scenario.name: scenario for scenario in SCENARIOS}
# What a run takes that names none.
DEFAULT = [scenario.name for scenario in SCENARIOS if scenario.name != 'gate']
