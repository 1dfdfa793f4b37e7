-- SPDX-License-Identifier: MIT
--
-- What the registers that PeakRDL writes need of its package of this name, and no more. PeakRDL's own has variants for
-- fixed_pkg and for fields that no register here has, and takes its libraries by a context.

library ieee;
  use ieee.std_logic_1164.all;

package reg_utils is

  type std_logic_array1 is array (natural range <>) of std_logic;

  -- One bit as a field of one bit.

  function to_std_logic_vector (
    logic : std_logic
  ) return std_logic_vector;

  -- '1' when any bit is set.

  function or_reduce (
    vec : std_logic_vector
  ) return std_logic;

end package reg_utils;

package body reg_utils is

  function to_std_logic_vector (
    logic : std_logic
  ) return std_logic_vector is
  begin

    return (0 downto 0 => logic);

  end function to_std_logic_vector;

  function or_reduce (
    vec : std_logic_vector
  ) return std_logic is

    variable any_v : std_logic := '0';

  begin

    for i in vec'range loop

      any_v := any_v or vec(i);

    end loop;

    return any_v;

  end function or_reduce;

end package body reg_utils;
