-- SPDX-License-Identifier: MIT
--
-- Safety: parity.

library ieee;
  use ieee.std_logic_1164.all;

package gc_safety_pkg is

  -- XOR of all bits.

  function parity_of (
    word : std_ulogic_vector
  ) return std_ulogic;

end package gc_safety_pkg;

package body gc_safety_pkg is

  function parity_of (
    word : std_ulogic_vector
  ) return std_ulogic is

    variable parity_v : std_ulogic := '0';

  begin

    for i in word'range loop

      parity_v := parity_v xor word(i);

    end loop;

    return parity_v;

  end function parity_of;

end package body gc_safety_pkg;
