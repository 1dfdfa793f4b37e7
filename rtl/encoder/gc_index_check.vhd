-- SPDX-License-Identifier: MIT
--
-- Compares the count with every index mark that a referenced axis passes: counts that were lost show there.
--
--   residue = (count - index position) modulo cfg_index_period; 0 at a mark
--   rest    = cfg_index_period - 1 - residue                     both kept by counting: nothing wide is compared
--
-- Lost, out_lost for one clock:
-- - z = '1' in the index phase where residue is not 0;
-- - z = '1' more than one encoder cycle, 4 counts, away from residue 0, whatever the phase: with a wire of a or b broken
--   the index phase may never come;
-- - residue 0 and the index phase left, after mark_clocks_g clocks in them or more, without z = '1': a mark is missing.
-- cfg_index_period = 0: one mark; the period is 2**32. Else it must be a multiple of 4, and is to stay as it is from a
-- clock before in_home on while in_referenced is high.
-- A level of z that lasts for a whole count and passes its filter counts as a mark: z must be pulled down.
-- Latency: 3 clocks from count to out_lost.

library ieee;
  use ieee.std_logic_1164.all;
  use ieee.numeric_std.all;

entity gc_index_check is
  generic (
    -- clocks in the index phase in which z, if it is there, has passed its filter
    mark_clocks_g : positive := 20
  );
  port (
    clk              : in    std_ulogic;
    rst              : in    std_ulogic;
    -- one count happened, one clock, and its direction, '1' = up
    step_valid       : in    std_ulogic;
    step_up          : in    std_ulogic;
    -- the count was set to the index position, one clock
    in_home          : in    std_ulogic;
    -- with the count: it refers to the index, the levels are those of the index phase, z
    in_referenced    : in    std_ulogic;
    in_phase         : in    std_ulogic;
    in_z             : in    std_ulogic;
    -- counts from mark to mark, 0 = there is one
    cfg_index_period : in    unsigned(31 downto 0);
    out_lost         : out   std_ulogic := '0'
  );
end entity gc_index_check;

architecture rtl of gc_index_check is

  constant cycle_c : positive := 4;

  -- highest residue
  signal last    : unsigned(31 downto 0) := (others => '1');
  signal residue : unsigned(31 downto 0) := (others => '0');
  signal rest    : unsigned(31 downto 0) := (others => '1');

  -- bits referenced, phase, z
  signal pins_1 : std_ulogic_vector(2 downto 0) := (others => '0');
  signal pins_2 : std_ulogic_vector(2 downto 0) := (others => '0');
  signal at_2   : std_ulogic := '0';
  signal near_2 : std_ulogic := '0';

  -- clocks at the mark, and whether it was seen
  signal stay : natural range 0 to mark_clocks_g := 0;
  signal seen : std_ulogic := '0';

begin

  p_check : process (clk) is

    variable step_v : signed(1 downto 0);

  begin

    if rising_edge(clk) then
      -- stage 1: residue of the count; a step up is 1, one down -1
      last <= cfg_index_period - 1;
      pins_1 <= in_referenced & in_phase & in_z;
      step_v := not step_up & '1';
      if step_valid = '1' then
        residue <= unsigned(signed(residue) + step_v);
        rest <= unsigned(signed(rest) - step_v);
        if step_up = '0' and residue = 0 then
          residue <= last;
          rest <= (others => '0');
        end if;
      end if;
      if in_home = '1' or (step_valid = '1' and step_up = '1' and rest = 0) then
        residue <= (others => '0');
        rest <= last;
      end if;

      -- stage 2: how far that is from a mark
      pins_2 <= pins_1;
      at_2 <= '0';
      near_2 <= '0';
      if residue = 0 then
        at_2 <= '1';
      end if;
      if residue <= cycle_c or rest < cycle_c then
        near_2 <= '1';
      end if;

      -- stage 3: marks where none is, none where one is
      out_lost <= '0';
      if pins_2(0) = '1' and (near_2 = '0' or (pins_2(1) = '1' and at_2 = '0')) then
        out_lost <= '1';
      end if;
      if pins_2(1) = '1' and at_2 = '1' then
        if stay /= mark_clocks_g then
          stay <= stay + 1;
        end if;
        seen <= seen or pins_2(0);
      else
        if stay = mark_clocks_g and seen = '0' then
          out_lost <= '1';
        end if;
        stay <= 0;
        seen <= '0';
      end if;

      if rst = '1' or pins_2(2) = '0' then
        stay <= 0;
        seen <= '0';
        out_lost <= '0';
      end if;
    end if;

  end process p_check;

end architecture rtl;
