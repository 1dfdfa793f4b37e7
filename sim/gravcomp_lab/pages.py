"""Renews the measured parts of a Markdown page."""

from pathlib import Path

from gravcomp.errors import InputError
from gravcomp.files import write_atomically


def read(page: Path, part: str) -> str:
    """What stands between <!-- part --> and <!-- /part --> in a page. InputError when they are not there."""
    return _split(_text(page), part, page)[1].strip()


def renew(page: Path, part: str, text: str) -> None:
    """Replace what stands between <!-- part --> and <!-- /part --> in a page. InputError when they are not there."""
    write_atomically(page, renewed(_text(page), part, text, page))


def renewed(old: str, part: str, text: str, page: Path) -> str:
    """A page's text with another part; page names it in the InputError when the marks are missing."""
    head, _, tail = _split(old, part, page)
    return f"{head}\n{text.strip()}\n\n{tail}"


def _text(page: Path) -> str:
    try:
        return page.read_text()
    except OSError:
        raise InputError(f"{page}: not found; --docs names its folder") from None


def _split(text: str, part: str, page: Path) -> tuple[str, str, str]:
    """A page's text up to the first of the two lines, what is between them, and the rest."""
    begin, end = f"<!-- {part} -->\n", f"<!-- /{part} -->\n"
    head, found_begin, rest = text.partition(begin)
    inside, found_end, tail = rest.partition(end)
    if not (found_begin and found_end):
        raise InputError(f"{page}: its lines {begin.strip()} and {end.strip()} are missing; put them around the tables")
    return head + begin, inside, end + tail
