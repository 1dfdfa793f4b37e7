"""Settings of the host in simulations: limits that three axes reach in microseconds."""

import numpy as np

from codes import weights_under_test
from gravcomp.driver.host import Settings, machine_settings

INDEX = np.array([2002, -3002, 4002])
SETTINGS = Settings(
    **machine_settings(weights_under_test()),
    index_position=tuple(INDEX.tolist()),
    index_period=(0, 4000, 400),
    margin_counts=(100, 100, 100),
    speed_max_counts_per_s=(15_000_000, 14_000_000, 13_000_000),
    current_limit_ua=(1_500_000, 1_400_000, 1_500_000),
    current_slew_ua=(400_000, 400_000, 380_000),
    command_bound_ua=(1000, 1000, 1000),
    tick_us=3,
    saturation_us=200,
    watchdog_us=60,
    result_us=200,
    brake_us=1,
    command_us=10,
    hold_us=100,
)
