-- SPDX-License-Identifier: MIT
--
-- out_turn: one bit of length_g is high; it moves on by one place, in a ring, in every clock with in_valid.
--
-- A one-hot counter: what is decoded from it is a flip-flop, without logic. Bit 0 is high after reset.
-- Latency: 1 clock.

library ieee;
  use ieee.std_logic_1164.all;
  use ieee.numeric_std.all;

entity gc_ring is
  generic (
    -- Number of places.
    length_g : positive := 3
  );
  port (
    clk      : in    std_ulogic;
    -- Synchronous, active high; back to place 0.
    rst      : in    std_ulogic;
    in_valid : in    std_ulogic;
    out_turn : out   std_ulogic_vector(length_g - 1 downto 0)
  );
end entity gc_ring;

architecture rtl of gc_ring is

  constant first_c : std_ulogic_vector(length_g - 1 downto 0) := std_ulogic_vector(to_unsigned(1, length_g));

  signal turn : std_ulogic_vector(length_g - 1 downto 0) := first_c;

begin

  p_turn : process (clk) is
  begin

    if rising_edge(clk) then
      if in_valid = '1' then

        for i in 0 to length_g - 1 loop

          turn((i + 1) mod length_g) <= turn(i);

        end loop;

      end if;
      if rst = '1' then
        turn <= first_c;
      end if;
    end if;

  end process p_turn;

  out_turn <= turn;

end architecture rtl;
