"""Renews the measured parts of a Markdown page."""

from pathlib import Path

from gravcomp.errors import InputError
from gravcomp.files import write_atomically


def renew(page: Path, part: str, text: str) -> None:
    """Replace what stands between <!-- part --> and <!-- /part --> in a page. InputError when they are not there."""
    begin, end = f"<!-- {part} -->\n", f"<!-- /{part} -->\n"
    try:
        head, found_begin, rest = page.read_text().partition(begin)
    except OSError:
        raise InputError(f"{page}: not found; --docs names its folder") from None
    _, found_end, tail = rest.partition(end)
    if not (found_begin and found_end):
        raise InputError(f"{page}: its lines {begin.strip()} and {end.strip()} are missing; put them around the tables")
    write_atomically(page, f"{head}{begin}\n{text.strip()}\n\n{end}{tail}")
