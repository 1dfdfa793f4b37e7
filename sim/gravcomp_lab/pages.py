"""Renews the measured parts of a Markdown page."""

from pathlib import Path

from gravcomp.errors import InputError
from gravcomp.files import write_atomically


def renew(page: Path, part: str, text: str) -> None:
    """Replace what stands between <!-- part --> and <!-- /part --> in a page. InputError when they are not there."""
    try:
        old = page.read_text()
    except OSError:
        raise InputError(f"{page}: not found; --docs names its folder") from None
    write_atomically(page, renewed(old, part, text, page))


def renewed(old: str, part: str, text: str, page: Path) -> str:
    """A page's text with another part; page names it in the InputError when the marks are missing."""
    begin, end = f"<!-- {part} -->\n", f"<!-- /{part} -->\n"
    head, found_begin, rest = old.partition(begin)
    _, found_end, tail = rest.partition(end)
    if not (found_begin and found_end):
        raise InputError(f"{page}: its lines {begin.strip()} and {end.strip()} are missing; put them around the tables")
    return f"{head}{begin}\n{text.strip()}\n\n{end}{tail}"
