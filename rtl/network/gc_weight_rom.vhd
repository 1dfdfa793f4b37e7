-- SPDX-License-Identifier: MIT
--
-- The weights of one lane, one word per neuron: out_word is word 0 until in_valid, then the next one, and after the
-- last word of the lane word 0 again. The word of a neuron thus stands ready beside its data without a wait.
--
-- Lane l of lanes_g holds the words l, l + lanes_g, l + 2 lanes_g ... of the table, and a word of zeros where the lanes
-- do not divide it. Latency: word k + 1 is there one clock after the k-th in_valid.

library ieee;
  use ieee.std_logic_1164.all;
  use ieee.numeric_std.all;

library work;
  use work.gc_fixed_pkg.all;

entity gc_weight_rom is
  generic (
    -- Width of a word, bits.
    word_bits_g : positive := 18;
    -- Words of the table, over all lanes.
    words_g     : positive := 20;
    -- Lanes, and which of them this is.
    lanes_g     : positive := 1;
    lane_g      : natural := 0;
    -- The table, word 0 lowest.
    table_g     : std_ulogic_vector;
    -- A one-hot address for up to 8 words of a lane: a LUT stands before each bit, and few are shared.
    ring_g      : boolean := false
  );
  port (
    clk      : in    std_ulogic;
    -- Synchronous, active high; back to word 0.
    rst      : in    std_ulogic;
    in_valid : in    std_ulogic;
    out_word : out   std_ulogic_vector(word_bits_g - 1 downto 0)
  );
end entity gc_weight_rom;

architecture rtl of gc_weight_rom is

  constant steps_c : positive := lane_steps(words_g, lanes_g);
  -- A power of two: an address never points outside.
  constant depth_c : positive := 2 ** tree_depth(steps_c);

  subtype word_t is std_ulogic_vector(word_bits_g - 1 downto 0);

  type words_t is array (0 to depth_c - 1) of word_t;

  function lane_words return words_t is

    alias    table_a : std_ulogic_vector(table_g'length - 1 downto 0) is table_g;
    variable words_v : words_t := (others => (others => '0'));
    variable low_v   : natural;

  begin

    for k in 0 to steps_c - 1 loop

      if k * lanes_g + lane_g < words_g then
        low_v := (k * lanes_g + lane_g) * word_bits_g;
        words_v(k) := table_a(low_v + word_bits_g - 1 downto low_v);
      end if;

    end loop;

    return words_v;

  end function lane_words;

  constant rom_c : words_t := lane_words;

  constant address_bits_c : natural := tree_depth(steps_c);

  -- Plus one, of gates: an adder's carry chain is slower than the five bits, and the ROM would hang on it.

  function increment (
    value : unsigned
  ) return unsigned is

    variable sum_v   : unsigned(value'range);
    variable carry_v : std_ulogic := '1';

  begin

    for i in value'low to value'high loop

      sum_v(i) := value(i) xor carry_v;
      carry_v := carry_v and value(i);

    end loop;

    return sum_v;

  end function increment;

  constant is_ring_c : boolean := ring_g and steps_c <= 8;

  -- The word after the one whose bit is high. Each of its bits is that of most words, or the other one where the bit of
  -- one of the others is high: a function of at most half the bits.

  function next_word (
    turn : std_ulogic_vector(steps_c - 1 downto 0)
  ) return word_t is

    variable column_v : std_ulogic_vector(steps_c - 1 downto 0);
    variable most_v   : std_ulogic;
    variable word_v   : word_t;

  begin

    for i in word_t'range loop

      for k in 0 to steps_c - 1 loop

        column_v(k) := rom_c((k + 1) mod steps_c)(i);

      end loop;

      most_v := '0';

      if 2 * ones(column_v) > steps_c then
        most_v := '1';
      end if;

      word_v(i) := most_v;

      for k in 0 to steps_c - 1 loop

        if column_v(k) /= most_v then
          word_v(i) := word_v(i) xor turn(k);
        end if;

      end loop;

    end loop;

    return word_v;

  end function next_word;

begin

  assert table_g'length = words_g * word_bits_g and lane_g < lanes_g
    report "gc_weight_rom: need " & integer'image(words_g * word_bits_g) & " table bits, got "
           & integer'image(table_g'length) & ", and a lane of " & integer'image(lanes_g) & ", got "
           & integer'image(lane_g)
    severity failure;

  g_constant : if steps_c = 1 generate
    out_word <= rom_c(0);
  end generate g_constant;

  g_ring : if steps_c > 1 and is_ring_c generate
    -- Bit k: word k stands at the output.
    signal turn : std_ulogic_vector(steps_c - 1 downto 0);
    signal word : word_t := rom_c(0);
  begin

    i_turn : entity work.gc_ring
      generic map (
        length_g => steps_c
      )
      port map (
        clk      => clk,
        rst      => rst,
        in_valid => in_valid,
        out_turn => turn
      );

    p_word : process (clk) is
    begin

      if rising_edge(clk) then
        if in_valid = '1' then
          word <= next_word(turn);
        end if;
        if rst = '1' then
          word <= rom_c(0);
        end if;
      end if;

    end process p_word;

    out_word <= word;
  end generate g_ring;

  g_rom : if steps_c > 1 and not is_ring_c generate
    -- The next word: nothing but the ROM stands between two registers.
    signal address : unsigned(address_bits_c - 1 downto 0) := to_unsigned(1, address_bits_c);
    signal word    : word_t := rom_c(0);
  begin

    p_rom : process (clk) is
    begin

      if rising_edge(clk) then
        if in_valid = '1' then
          word <= rom_c(to_integer(address));
          address <= increment(address);
          if address = steps_c - 1 then
            address <= (others => '0');
          end if;
        end if;
        if rst = '1' then
          word <= rom_c(0);
          address <= to_unsigned(1, address_bits_c);
        end if;
      end if;

    end process p_rom;

    out_word <= word;
  end generate g_rom;

end architecture rtl;
