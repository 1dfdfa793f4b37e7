-- SPDX-License-Identifier: MIT
--
-- What follows from the samples of the encoders' glitch filter: see gc_quad_decoder.

package gc_encoder_pkg is

  -- Clocks that a level of a or b must last; two counts take as long at the limit speed.

  function shortest_level (
    filter_samples : natural
  ) return positive;

  -- Clocks per 4 counts there: a faster axis reads the same, or loses counts.

  function shortest_period (
    filter_samples : natural
  ) return positive;

end package gc_encoder_pkg;

package body gc_encoder_pkg is

  function shortest_level (
    filter_samples : natural
  ) return positive is
  begin

    if filter_samples > 2 then
      return filter_samples;
    end if;

    return 2;

  end function shortest_level;

  function shortest_period (
    filter_samples : natural
  ) return positive is
  begin

    return 2 * shortest_level(filter_samples);

  end function shortest_period;

end package body gc_encoder_pkg;
