"""Write the image of a machine folder: all constants of a core that is built, to be loaded into it at run time."""

from pathlib import Path

from gravcomp.files import write_atomically


def add_arguments(parser):
    parser.add_argument("--weights", type=Path, required=True, help="machine folder")
    parser.add_argument("--rom", type=Path, required=True, help="machine folder that the core was built with")
    parser.add_argument("--out", type=Path, required=True, help="file of little-endian 32-bit words")


def run(arguments):
    from gravcomp.core.image import load_image

    image = load_image(arguments.weights, arguments.rom)
    write_atomically(arguments.out, image.data)
    print(f"{arguments.out}: {len(image.words)} words, CRC-32 0x{image.crc32:08X}, written from {arguments.weights}; "
          f"{image.precision}")  # fmt: skip
