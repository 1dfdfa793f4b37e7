-- SPDX-License-Identifier: MIT
--
-- Formats of gc_servo and gc_setpoint: see there; sim/gravcomp/twin/servo.py and setpoint.py hold the same numbers.

package gc_servo_pkg is

  -- Axes that one of them can serve.
  constant most_axes_c : positive := 8;

  -- Gains, bits, without a sign.
  constant gain_bits_c : positive := 32;

  -- Bits behind the point of a product, of the integral, and of the two gains that make them.
  constant proportional_fraction_c : positive := 12;
  constant integral_fraction_c     : positive := 20;

  -- The position error and the lag, as the gains see them: bits, and how many of the lag are behind the point.
  constant distance_bits_c : positive := 24;
  constant lag_fraction_c  : positive := 4;

  -- The low-passed position: bits behind the point, enough that the slowest filter comes to rest at no lag.
  constant filter_bits_c   : positive := 4;
  constant slow_fraction_c : positive := lag_fraction_c + 2 ** filter_bits_c - 1;

  -- Clocks of an axis in gc_servo.
  constant servo_steps_c : positive := 9;

end package gc_servo_pkg;
