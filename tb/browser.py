"""A page in headless Chromium: what it measures of itself, and a picture of it."""

import html
import json
import re
import shutil
import subprocess
from pathlib import Path

CHROMIUM = next(filter(None, map(shutil.which, ("chromium", "chromium-browser", "google-chrome"))), None)
_COMMON = ("--headless", "--no-sandbox", "--disable-gpu", "--hide-scrollbars", "--virtual-time-budget=10000")


def measured(page: Path, script: str, width: int = 1280, height: int = 800) -> dict:
    """What the JavaScript expression gives in the page as it is laid out in a window of that size, px."""
    probe = page.with_name(f"probe_{page.name}")
    asks = f"document.getElementById('probe').textContent = JSON.stringify({script});"
    text = page.read_text(encoding="utf-8").replace("</body>", f"<pre id='probe'></pre><script>{asks}</script></body>")
    probe.write_text(text, encoding="utf-8")
    command = [CHROMIUM, *_COMMON, f"--window-size={width},{height}", "--dump-dom", probe.as_uri()]
    dom = subprocess.run(command, capture_output=True, text=True, check=True, timeout=120).stdout
    return json.loads(html.unescape(re.search(r"<pre id=.probe.>(.*?)</pre>", dom, re.S)[1]))


def screenshot(page: Path, picture: Path, width: int = 1280, height: int = 800) -> None:
    """A PNG of the first screen, or of as much as the height takes in."""
    command = [CHROMIUM, *_COMMON, f"--window-size={width},{height}", f"--screenshot={picture}", page.as_uri()]
    subprocess.run(command, capture_output=True, check=True, timeout=120)
