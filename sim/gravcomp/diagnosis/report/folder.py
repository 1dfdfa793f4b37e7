"""The folder of a diagnosis: report.json, model.toml and report.html."""

from pathlib import Path

from gravcomp.diagnosis.diagnosis import Diagnosis
from gravcomp.diagnosis.model import Model, model_toml
from gravcomp.diagnosis.report.report import report, report_json
from gravcomp.diagnosis.report.report_html import report_html
from gravcomp.files import write_all_atomically


def write_report(found: Diagnosis, model: Model, folder: Path) -> tuple[Model, dict]:
    """Write the folder; the model with what was found, and the content of report.json."""
    grown, content = model.grown(found.fit), report(found)
    page = report_html(found, content)
    files = {"report.json": report_json(content), "model.toml": model_toml(grown), "report.html": page}
    beside = grown.machine.files if grown.machine else {}  # what model.toml refers to
    write_all_atomically({folder / name: whole for name, whole in (files | dict(beside)).items()})
    return grown, content
