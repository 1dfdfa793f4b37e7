"""The pages: the site builds without a broken link or anchor, and so do the pages outside it."""

import re
import subprocess
import sys

import pytest

from codes import ROOT

LINK = re.compile(r"\]\(([^)#\s]+)[^)]*\)")
OUTSIDE = ("README.md", "CHANGELOG.md", "rtl/README.md", "data/README.md")


def build(docs, site) -> subprocess.CompletedProcess:
    text = (ROOT / "mkdocs.yml").read_text().replace("docs_dir: docs", f"docs_dir: {docs}")
    config = site.parent / "mkdocs.yml"
    config.write_text(text)
    # --quiet would hide the warnings from --strict
    command = [sys.executable, "-m", "mkdocs", "build", "--strict", "--config-file", config]
    return subprocess.run([*command, "--site-dir", site], capture_output=True, text=True, check=False)


def test_docs_site_builds_without_a_broken_link(tmp_path):
    done = build(ROOT / "docs", tmp_path / "site")
    assert done.returncode == 0, done.stderr
    assert (tmp_path / "site" / "guide" / "safety.html").is_file()


def test_docs_site_refuses_a_broken_link(tmp_path):
    docs = tmp_path / "docs"
    docs.mkdir()
    for page in (ROOT / "docs").rglob("*.md"):
        copy = docs / page.relative_to(ROOT / "docs")
        copy.parent.mkdir(exist_ok=True)
        copy.write_text(page.read_text())
    (docs / "index.md").write_text("[nowhere](guide/nowhere.md)\n")
    done = build(docs, tmp_path / "site")
    assert done.returncode != 0
    assert "nowhere.md" in done.stderr + done.stdout


@pytest.mark.parametrize("page", OUTSIDE)
def test_docs_links_outside_the_site_lead_to_files(page):
    path = ROOT / page
    targets = [target for target in LINK.findall(path.read_text()) if "://" not in target]
    missing = [target for target in targets if not (path.parent / target).exists()]
    assert not missing
