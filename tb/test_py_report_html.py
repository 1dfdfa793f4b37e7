"""report.html and the terminal say what to do, with units, and the page is laid out so that it can be read.

The layout is looked at in headless Chromium, where there is one.
"""

import json
import re
from dataclasses import replace

import numpy as np
import pytest

import browser
from gravcomp.cli import main
from gravcomp.diagnosis.diagnosis import diagnose
from gravcomp.diagnosis.model import Model
from gravcomp.diagnosis.report.contributions import contributions, counted
from gravcomp.diagnosis.report.figures import driver_figure
from gravcomp.diagnosis.report.report import report, text, unit_of
from gravcomp.logs.csv_reader import read_measurement
from machines import SHIPPED

N = 400
T = 0.1 * np.arange(N)


def log(**columns) -> str:
    rows = np.column_stack(list(columns.values()))
    return "\n".join([",".join(columns), *(",".join(f"{x:.12g}" for x in row) for row in rows)]) + "\n"


def noise(scale: float, seed: int = 1) -> np.ndarray:
    return scale * np.random.default_rng(seed).standard_normal(N)


def slow(k: int = 0) -> tuple[np.ndarray, np.ndarray]:
    """Position and velocity of a motion of two sines."""
    a, b = 0.9 + 0.13 * k, 0.55 + 0.07 * k
    return np.sin(a * T + k) + 0.4 * np.sin(b * T), a * np.cos(a * T + k) + 0.4 * b * np.cos(b * T)


def two_axes() -> str:
    """Coulomb and viscous friction on axis 1 (rad, Nm), Coulomb friction on axis 2 (m, N)."""
    (q1, v1), (q2, v2) = slow(), slow(1)
    f1, f2 = 8.0 * np.cos(q1), 30.0 + 0.0 * T
    own1, own2 = f1 + 0.5 * np.sign(v1) + 0.4 * v1 + noise(0.05), f2 + 2.0 * np.sign(v2) + noise(0.2, 2)
    return log(t_s=T, q1_rad=q1, q2_m=0.1 * q2, v1_radps=v1, v2_mps=0.1 * v2, f1_nm=own1, f2_n=own2, fm1_nm=f1,
               fm2_n=f2)  # fmt: skip


def two_speeds() -> str:
    """Holds approached at one speed from either side, at positions of a small range far from zero."""
    v = np.where(np.random.default_rng(3).random(N) < 0.5, 0.02, -0.02)
    q = 2.0001 + 1e-5 * np.random.default_rng(4).random(N)
    return log(t_s=2.0 * np.arange(N), q1_m=q, v1_mps=v, f1_n=20.0 + np.sign(v) + noise(0.1), fm1_n=20.0 + 0.0 * q)


def six_axes() -> str:
    columns = {"t_s": 1000.0 * T, "temp_c": 20.0 + 0.01 * T}
    for k in range(6):
        q, v = slow(k)
        f = 40.0 * np.cos(q) / (k + 1)
        own = f + 0.3 * np.sign(v) + 0.3 * np.exp(-(((q - 0.3) / 0.1) ** 2)) * (k == 2) + noise(0.05, k)
        columns |= {f"q{k + 1}_rad": q, f"v{k + 1}_radps": v * 1e-3, f"f{k + 1}_nm": own, f"fm{k + 1}_nm": f}
    return log(**columns)


def nothing() -> str:
    q, v = slow()
    return log(t_s=T, q1_rad=q, v1_radps=v, f1_nm=8.0 * np.cos(q) + noise(0.05), fm1_nm=8.0 * np.cos(q))


LOGS = {"two axes": two_axes, "two speeds": two_speeds, "six axes": six_axes, "nothing": nothing}


@pytest.fixture(scope="module")
def diagnosed(tmp_path_factory):
    """Folder of the report of a log, made once."""
    made = {}

    def of(name: str):
        if name not in made:
            made[name] = tmp_path_factory.mktemp("report")
            (made[name] / "log.csv").write_text(LOGS[name]())
            assert main(["diagnose", str(made[name] / "log.csv"), "--out", str(made[name])]) == 0
        return made[name]

    return of


def content(folder) -> dict:
    return json.loads((folder / "report.json").read_text())


def found(csv: str, tmp_path):
    (tmp_path / "log.csv").write_text(csv)
    return diagnose(read_measurement(tmp_path / "log.csv"), Model())


def test_terminal_and_page_begin_with_two_sentences(tmp_path, capsys):
    (tmp_path / "log.csv").write_text(two_axes())
    assert main(["diagnose", str(tmp_path / "log.csv"), "--out", str(tmp_path)]) == 0
    said, todo, verdict = capsys.readouterr().out.splitlines()[:3]
    own = content(tmp_path)
    assert (said, todo) == (own["found"], own["next"])
    assert verdict == "verdict: explained; seed 0"
    assert re.match(
        r"The model lacks coulomb friction and viscous friction on axis 1: [\d.]+ .* RMS of error become", said
    )
    assert todo.startswith("Next: ")
    assert "put coulomb friction and viscous friction into the compensator" in todo
    page = (tmp_path / "report.html").read_text()
    assert 0 < page.index(said) < page.index(todo) < page.index("Verdict")


def test_sentences_of_nothing_say_so(diagnosed):
    own = content(diagnosed("nothing"))
    assert own["found"].startswith("The model lacks nothing that this log shows: what is left, 0.0")
    assert own["next"] == "Next: keep the model."


def test_name_whose_interval_reaches_zero_is_not_said_with_certainty(tmp_path):
    rng = np.random.default_rng(4)
    q1, q2, v1, v2 = rng.uniform(-1.2, 1.2, (4, N))
    f1, f2 = 8.0 * np.cos(q1), 5.0 * np.cos(q2)
    friction = {f"f{i}_nm": f + 0.5 * np.sign(v) + noise(0.05, i) for i, f, v in ((1, f1, v1), (2, f2, v2))}
    columns = {"q1_rad": q1, "q2_rad": q2, "v1_radps": v1, "v2_radps": v2, "fm1_nm": f1, "fm2_nm": f2, **friction}
    d = replace(found(log(t_s=T, **columns), tmp_path), alternatives=[])
    (entry,) = d.fit.effects
    for reaches_zero, says in (
        ({}, "any other name is at least 90 times less likely"),
        ({"fc_2"}, "not sure: of coulomb friction on axis 2 the interval reaches zero"),
        ({"fc_1", "fc_2"}, "not sure: of coulomb friction the interval reaches zero"),
    ):
        intervals = {name: (-own[1], own[1]) if name in reaches_zero else own for name, own in entry.intervals.items()}
        own = replace(d, fit=replace(d.fit, effects=(replace(entry, intervals=intervals),)))
        assert report(own)["found"].endswith(f"; {says}.")


def test_sentences_of_hidden_friction_ask_for_the_approach(tmp_path):
    rng = np.random.default_rng(3)
    q = rng.uniform(-1.2, 1.2, N)
    f = 8.0 * np.cos(q)
    own = report(found(log(t_s=T, q1_rad=q, f1_nm=f + 0.5 * rng.choice([-1, 1], N) + noise(0.05), fm1_nm=f), tmp_path))
    assert "two-valued" in own["found"]
    assert "log the approach velocity" in own["next"]


def test_sensor_of_the_wrong_sign_is_to_be_checked(tmp_path):
    q, v = slow()
    f = 8.0 * np.cos(q)
    own = report(found(log(t_s=T, q1_rad=q, v1_radps=v, f1_nm=-(f + noise(0.05)), fm1_nm=f), tmp_path))
    assert "check the sign of the effort of axis 1" in own["next"]


def test_every_parameter_has_its_unit(diagnosed):
    units = {
        name: unit for effect in content(diagnosed("two axes"))["effects"] for name, unit in effect["units"].items()
    }
    assert units == {"fc_1": "Nm", "fc_2": "N", "b_1": "Nm s/rad"}
    page = (diagnosed("two axes") / "report.html").read_text()
    assert "Nm s/rad" in page


def test_units_of_every_effect_are_resolved(tmp_path):
    """No [q] or [f] is left over, and stems with a part or a unit behind are found."""
    from gravcomp.diagnosis.candidate import Parameter, Term
    from gravcomp.diagnosis.effects import EFFECTS
    from gravcomp.diagnosis.fit import Entry

    data = found(nothing(), tmp_path).data
    for kind in EFFECTS:
        effect = kind()
        for stem in effect.units:
            name = Parameter(stem, 0 if effect.per_axis and stem not in effect.shared else None)
            unit = unit_of(Entry(Term(effect, ()), {}, {}, 0.0), name, data)
            assert unit
            assert "[" not in unit


def test_driver_rows_have_their_effect_and_none_stands_twice(diagnosed):
    for name in LOGS:
        own = content(diagnosed(name))
        rows = [(item["of"], item["axis"], item["variable"]) for item in own["drivers"]]
        assert len(rows) == len({*rows})
        assert {of for of, _, _ in rows} <= {"", *(effect["name"] for effect in own["effects"])}
    rows = content(diagnosed("two axes"))["drivers"]
    assert {(i["of"], i["axis"], i["variable"]) for i in rows} == {
        ("coulomb_friction", 1, "dir1"), ("coulomb_friction", 2, "dir2"), ("viscous_friction", 1, "v1")}  # fmt: skip


def test_contributions_add_up_to_one_and_are_those_of_the_truth(tmp_path):
    d = found(two_axes(), tmp_path)
    own = contributions(d)
    np.testing.assert_allclose(sum(item.by_axis for item in own), 1.0)
    np.testing.assert_allclose(sum(item.whole for item in own), 1.0)
    use = counted(d)[:, 1]
    truth = 2.0 * d.data.direction[use, 1]
    r = d.before[use, 1]
    by_name = {item.name: item for item in own}
    assert by_name["coulomb_friction"].by_axis[1] == pytest.approx(truth @ r / (r @ r), abs=0.01)
    assert by_name["nothing"].by_axis[1] == pytest.approx(1.0 - truth @ r / (r @ r), abs=0.01)


def test_errors_without_reversals_leave_out_what_has_no_direction(tmp_path):
    q, v = slow()
    f, v = 8.0 * np.cos(q), 0.05 * np.round(v / 0.05)  # below one and a half steps no direction is sure
    d = found(log(t_s=T, q1_rad=q, v1_radps=v, f1_nm=f + 0.5 * np.sign(v) + noise(0.05), fm1_nm=f), tmp_path)
    own = report(d)
    rows = d.is_test & ~d.left_out.any(axis=1) & ~d.data.is_undecided.any(axis=1)
    assert own["after_without_reversals"]["rms_n"] == pytest.approx(np.sqrt(np.mean(d.after[rows] ** 2)))
    assert 0 < np.count_nonzero(rows) < own["n_test"]
    assert "without reversals" in text(own, 0)
    assert own["after_without_reversals"]["max_n"] <= own["after"]["max_n"]


def test_errors_are_told_by_axis_in_its_unit(tmp_path):
    own = report(found(two_axes(), tmp_path))["by_axis"]
    assert [item["unit"] for item in own] == ["Nm", "N"]
    assert [item["after"] for item in own] == pytest.approx([0.05, 0.2], rel=0.25)
    assert own[1]["before"] == pytest.approx(2.0, rel=0.05)


def test_worst_places_are_where_the_bump_is(tmp_path):
    """A narrow bump that no effect has: the worst places lie on it, each another one, and are no gross errors."""
    q, v = slow()
    f = 8.0 * np.cos(q)
    bump = 0.4 * np.exp(-(((q - 0.5) / 0.01) ** 2))
    d = found(log(t_s=T, q1_rad=q, v1_radps=v, f1_nm=f + bump + noise(0.02), fm1_nm=f), tmp_path)
    d.left_out[:] = False
    worst = report(d)["worst"]
    on_it = np.abs(q[d.is_test] - 0.5) < 0.02
    assert on_it.any()
    assert abs(worst[0]["q"][0] - 0.5) < 0.02
    assert all(abs(a["q"][0] - b["q"][0]) > 0.05 * np.ptp(q) for a in worst for b in worst if a is not b)


def test_every_effect_has_a_figure_over_its_driver(tmp_path):
    """Six axes of the first effect do not crowd the second out."""
    columns = {"t_s": T}
    for k in range(6):
        q, v = slow(k)
        own = 8.0 * np.cos(q)
        columns |= {f"q{k + 1}_rad": q, f"v{k + 1}_radps": v, f"fm{k + 1}_nm": own}
        columns[f"f{k + 1}_nm"] = own + 0.5 * np.sign(v) + 0.3 * v + noise(0.02, k)
    labels = re.findall(r">((?:direction|velocity) [a-z]+\d)", driver_figure(found(log(**columns), tmp_path)))
    assert len(labels) == 6
    assert {label.split()[0] for label in labels} == {"direction", "velocity"}


LAYOUT = """(() => {
  const box = e => e.getBoundingClientRect(), clash = [], outside = [];
  for (const svg of document.querySelectorAll('svg')) {
    const own = [...svg.querySelectorAll('text')].filter(e => e.textContent.trim()), s = box(svg);
    own.forEach((a, i) => {
      const p = box(a);
      if (p.left < s.left - 1 || p.right > s.right + 1 || p.top < s.top - 1 || p.bottom > s.bottom + 1)
        outside.push(a.textContent);
      own.slice(i + 1).forEach(b => {
        const q = box(b);
        if (p.left < q.right - 1 && q.left < p.right - 1 && p.top < q.bottom - 1 && q.top < p.bottom - 1)
          clash.push(a.textContent + ' | ' + b.textContent);
      });
    });
  }
  const all = s => [...document.querySelectorAll(s)];
  const bars = all('.bar div').map(e => [...e.children].reduce((w, i) => w + box(i).width, 0) / box(e).width);
  const cells = all('td,th').filter(e => e.scrollWidth > e.clientWidth + 1).map(e => e.textContent);
  return {clash, outside, bars, cells, n: document.querySelectorAll('svg text').length,
          wide: document.documentElement.scrollWidth, first: box(document.getElementById('first')).bottom,
          found: box(document.getElementById('found')).top};
})()"""


@pytest.mark.skipif(browser.CHROMIUM is None, reason="no Chromium here; apt-get install chromium")
@pytest.mark.parametrize("name", LOGS)
def test_page_can_be_read_in_a_browser(name, diagnosed):
    seen = browser.measured(diagnosed(name) / "report.html", LAYOUT)
    assert (seen["clash"], seen["outside"], seen["cells"]) == ([], [], [])
    assert seen["n"] > 10  # letters of the figures are text
    assert seen["wide"] <= 1280
    assert seen["first"] <= 800  # the first screen holds what was found, what to do, errors and shares
    assert 0 < seen["found"] < 120
    assert seen["bars"] == pytest.approx([1.0] * len(seen["bars"]), abs=0.02)
    small = browser.measured(diagnosed(name) / "report.html", LAYOUT, width=800, height=1200)
    assert (small["clash"], small["wide"]) == ([], 800)


@pytest.mark.skipif(browser.CHROMIUM is None, reason="no Chromium here; apt-get install chromium")
def test_looking_for_overlaps_finds_one(tmp_path):
    page = tmp_path / "page.html"
    letters = "<text x='10' y='20'>0.0001</text><text x='30' y='20'>0.0002</text>"
    parts = "<div id='first'></div><div id='found'></div>"
    page.write_text(f"<html><body>{parts}<svg width='200' height='50'>{letters}</svg></body></html>")
    assert browser.measured(page, LAYOUT)["clash"] == ["0.0001 | 0.0002"]


def test_report_of_the_shipped_machine_sends_to_the_loop(tmp_path):
    machine_log = tmp_path / "log.csv"
    command = ["measure", "--robot", str(SHIPPED), "--effect", "coulomb_friction", "--mode", "static", "--points", "60"]
    pytest.importorskip("mujoco", reason="extra prototype is not installed")
    assert main([*command, "--out", str(machine_log)]) == 0
    assert main(["diagnose", str(machine_log), "--robot", str(SHIPPED), "--out", str(tmp_path / "out")]) == 0
    assert "gravcomp loop" in content(tmp_path / "out")["next"]
