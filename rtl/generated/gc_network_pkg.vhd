-- SPDX-License-Identifier: MIT
--
-- Generated from weights/spheiro by `make rom`; do not edit.
--
-- Codes are integers of value * 2**fraction. The biases hold the offsets of both normalisations and the half LSB of
-- every truncation.

library ieee;
  use ieee.std_logic_1164.all;
  use ieee.numeric_std.all;

package gc_network_pkg is

  -- SHA-256 of all that this package and gc_compensation_pkg depend on: clock, axes and activation in robot.toml,
  -- hidden.csv, output.csv, scaling.csv, compensation.csv.
  constant weights_hash_c : std_ulogic_vector(255 downto 0) :=
    x"cfaace90844c2d15e4b51e4c459c11edf80fd4c423f41ecf9a326ccd37c2f755";

  -- Hz of the core's clock: the tables of friction hold for this one.
  constant clock_hz_c : positive := 40000000;

  -- Sizes: axes, whose counts come in and efforts go out; what the hidden layer sees of them; hidden neurons.
  constant axes_c     : positive := 3;
  constant inputs_c   : positive := axes_c;
  constant features_c : positive := 3;
  constant hidden_c   : positive := 20;
  constant outputs_c  : positive := axes_c;

  -- Widths of the ports.
  constant count_bits_c   : positive := 32;
  constant force_bits_c   : positive := 24;
  constant current_bits_c : positive := 32;

  type counts_t is array (0 to inputs_c - 1) of integer;

  -- Bits, per axis.
  type axis_bits_t is array (0 to axes_c - 1) of natural;

  -- Input: clamp to the trained range (encoder counts), drop bits, scale to x.
  constant count_low_c            : counts_t := (0 => -160997, 1 => -160997, 2 => -160997);
  constant count_high_c           : counts_t := (0 => 160997, 1 => 160997, 2 => 160997);
  constant count_shift_c          : axis_bits_t := (0 => 1, 1 => 1, 2 => 1);
  constant input_scale_c          : signed(53 downto 0) :=
    b"011010000011010011_011010000011010011_011010000011010011";
  constant input_scale_fraction_c : axis_bits_t := (0 => 16, 1 => 16, 2 => 16);
  constant x_fraction_c           : natural  := 17;

  -- x of the limits of the trained range.
  constant x_low_c  : signed(53 downto 0) :=
    b"100000000000000001_100000000000000001_100000000000000001";
  constant x_high_c : signed(53 downto 0) :=
    b"011111111111111100_011111111111111100_011111111111111100";

  -- Axes, axis 1 lowest, whose sine and cosine the hidden layer sees; turns per 2**16 counts and per count of them.
  constant turning_c     : std_ulogic_vector(inputs_c - 1 downto 0) := "000";
  constant phase_bits_c  : positive := 18;
  constant step_bits_c   : positive := 35;
  constant coarse_step_c : signed(104 downto 0) :=
    b"00000000000000000000000000000000000_00000000000000000000000000000000000_00000000000000000000000000000000000";
  constant fine_step_c   : signed(104 downto 0) :=
    b"00000000000000000000000000000000000_00000000000000000000000000000000000_00000000000000000000000000000000000";

  -- The form: the paper's, or the lean one, whose scales are 1 as its weights hold them; the serial one is the lean one
  -- with weights of fewer bits, for gc_core_serial.
  constant lean_c        : boolean := false;
  constant serial_form_c : boolean := false;

  -- Hidden layer; product_drop: bits that a product loses before it is summed.
  constant weight_fraction_c        : natural  := 15;
  constant hidden_product_drop_c    : natural  := 0;
  constant hidden_sum_bits_c        : positive := 37;
  constant preactivation_fraction_c : natural  := 16;
  constant preactivation_drop_c     : natural  := 16;
  constant slope_fraction_c         : natural  := 17;
  constant hidden_fraction_c        : natural  := 17;

  -- Output layer.
  constant output_weight_fraction_c : integer  := 15;
  constant output_product_drop_c    : natural  := 0;
  constant output_sum_bits_c        : positive := 38;
  constant y_fraction_c             : natural  := 16;
  constant y_bits_c                 : positive := 18;
  constant output_drop_c            : natural  := 16;
  constant output_bias_c            : signed(113 downto 0) :=
    b"11111110111000010100101101001101011110_00000001001101011010011011011111001110_11111110110100010010011001100010111100";

  -- Output: scale y to mN or mNm, and that to uA by the 1/K_t of each axis.
  constant output_scale_c           : signed(53 downto 0) :=
    b"010001011101001100_010001011101001100_010001011101001100";
  constant output_scale_fraction_c  : axis_bits_t := (0 => 16, 1 => 16, 2 => 16);
  constant current_scale_c          : signed(53 downto 0) :=
    b"010110001110001110_010110001110001110_010110001110001110";
  constant current_scale_fraction_c : axis_bits_t := (0 => 12, 1 => 12, 2 => 12);

  -- Weights, and words of them, one per neuron.
  constant weight_bits_c      : positive := 18;
  constant hidden_word_bits_c : positive := 91;
  constant output_word_bits_c : positive := 54;

  subtype hidden_word_t is std_ulogic_vector(hidden_word_bits_c - 1 downto 0);

  subtype output_word_t is std_ulogic_vector(output_word_bits_c - 1 downto 0);

  type hidden_words_t is array (0 to hidden_c - 1) of hidden_word_t;

  type output_words_t is array (0 to hidden_c - 1) of output_word_t;

  -- bias, weights of the inputs from last to first
  constant hidden_words_c : hidden_words_t := (
     0 => b"0000001110011010100110000101001011111_010110101111010101_101010111100101000_101010111010101010", -- 1934821983 93141 -86232 -86358
     1 => b"0000001101000000000000011100001100001_101011010000100101_101011001100110111_010110011010100110", -- 1744844897 -84955 -85193 91814
     2 => b"0000010000100000100010000010010010000_101100010001001111_010101000110101001_101100010010101000", -- 2215707792 -80817 86441 -80728
     3 => b"1110110101011110000001101010110001001_101111010110010000_001111100100100001_001111100110111101", -- -10003360375 -68208 63777 63933
     4 => b"1110110110011101101111001100011111111_001111010011010000_001111011101100001_101111100001111101", -- -9869747969 62672 63329 -67459
     5 => b"1110101110111011111101001001101101100_010001011000111001_101110100011000111_010001011000110000", -- -10880117908 71225 -71481 71216
     6 => b"1111100011101001011011110010001000010_110100010000111110_001100100011111110_110100010001100001", -- -3805420478 -48066 51454 -48031
     7 => b"1111100000110100101101110110101100100_001110001100010111_110010110100010110_110010110011110001", -- -4184412828 58135 -53994 -54031
     8 => b"1111100000000000010111001110011110101_110011000010111011_110011000001100100_001101111101000111", -- -4294206219 -53061 -53148 57159
     9 => b"1111110010111000000010000111000001010_000000100000011000_001101010111101001_000001100000001010", -- -1761538550 2072 54761 6154
    10 => b"1111101000011001000101010000100100111_000000101101011111_111110111101100011_001010110101111011", -- -3168624345 2911 -4253 44411
    11 => b"0000111111111000110100010011010100001_111111011110001001_000000000001111111_110010111111001010", -- 8574871201 -2167 127 -53302
    12 => b"0000010111011111010100111100000010010_000101101010011011_111010001101010111_111010001101110010", -- 3152705554 23195 -23721 -23694
    13 => b"0000010111000111011110011110010000010_111010010000100000_111010010101100110_000101100101001001", -- 3102686338 -23520 -23194 22857
    14 => b"0000001000011011110001011110010111000_111000110100001111_000111001111001110_111000110011000011", -- 1131986104 -29425 29646 -29501
    15 => b"1110110110111011111110000010111111101_110001100111001010_001101011000010111_001101011001111111", -- -9806346755 -58934 54807 54911
    16 => b"1110110111110010100101011010001101110_001101001011111100_001101010001101001_110001110001000000", -- -9691810706 54012 54377 -58304
    17 => b"1110110100100011010011110100010010111_001101111001001000_110001010101111101_001101110111100110", -- -10126497641 56904 -60035 56806
    18 => b"1111100111010000000100101101000001101_001010100101000100_000000001110010100_111110110100010000", -- -3321734643 43332 916 -4848
    19 => b"1110111110101001000111111000100000111_001011011110010001_000000011001111100_000000001011100000"  -- -8772128505 46993 1660 736
  );

  -- weights of the outputs from last to first
  constant output_words_c : output_words_t := (
     0 => b"111101011100010100_000010010110100010_000010010110100011", -- -10476 9634 9635
     1 => b"000010011000101001_000010011001100000_111101011001101111", -- 9769 9824 -10641
     2 => b"000100000001100100_111011101001110101_000100000001001010", -- 16484 -17803 16458
     3 => b"110100101000010011_001010110001101010_001010101101100100", -- -46573 44138 43876
     4 => b"001011000000001010_001010111001101001_110100010011011010", -- 45066 44649 -47910
     5 => b"001000001100100010_110111110111111010_001000001011100101", -- 33570 -33286 33509
     6 => b"000101011010110100_111010001001010011_000101011010010100", -- 22196 -23981 22164
     7 => b"111100111101111011_000010110011001101_000010110011000001", -- -12421 11469 11457
     8 => b"000010110110110011_000010110111110100_111100111001100010", -- 11699 11764 -12702
     9 => b"000000000000000100_111111100011001010_111111111101100000", -- 4 -1846 -160
    10 => b"111111111101011010_000000000110111110_111110111110111110", -- -166 446 -4162
    11 => b"111111111111100001_000000000000001010_111111011101000000", -- -31 10 -2240
    12 => b"001110000101100101_110001101110001000_110001110000100101", -- 57701 -58488 -58331
    13 => b"110001010000010110_110001011001101000_001110011110011100", -- -60394 -59800 59292
    14 => b"110001101010111110_001110100101011110_110001101000111111", -- -58690 59742 -58817
    15 => b"011101001000111001_100100110000111101_100100110110010001", -- 119353 -111555 -111215
    16 => b"100100010111011111_100100011100010011_011101101101001000", -- -113185 -112877 121672
    17 => b"101000111111111010_011000001100111111_101001000011101100", -- -94214 99135 -93972
    18 => b"111110110101011100_111111111111000010_000000001010000011", -- -4772 -62 643
    19 => b"000000101111101011_000000000001001001_000000000000101101"  -- 3051 73 45
  );

  -- The tables as one vector, word 0 lowest.
  function flat (words : hidden_words_t) return std_ulogic_vector;

  function flat (words : output_words_t) return std_ulogic_vector;

  -- Counts as one vector, axis 1 lowest.
  function flat (counts : counts_t) return signed;

end package gc_network_pkg;

package body gc_network_pkg is

  function flat (words : hidden_words_t) return std_ulogic_vector is
    variable flat_v : std_ulogic_vector(hidden_c * hidden_word_bits_c - 1 downto 0);
  begin
    for i in words'range loop
      flat_v((i + 1) * hidden_word_bits_c - 1 downto i * hidden_word_bits_c) := words(i);
    end loop;
    return flat_v;
  end function flat;

  function flat (words : output_words_t) return std_ulogic_vector is
    variable flat_v : std_ulogic_vector(hidden_c * output_word_bits_c - 1 downto 0);
  begin
    for i in words'range loop
      flat_v((i + 1) * output_word_bits_c - 1 downto i * output_word_bits_c) := words(i);
    end loop;
    return flat_v;
  end function flat;

  function flat (counts : counts_t) return signed is
    variable flat_v : signed(inputs_c * count_bits_c - 1 downto 0);
  begin
    for i in counts'range loop
      flat_v((i + 1) * count_bits_c - 1 downto i * count_bits_c) := to_signed(counts(i), count_bits_c);
    end loop;
    return flat_v;
  end function flat;

end package body gc_network_pkg;
