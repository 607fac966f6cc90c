"""Records: tables of readings, reductions, diagnosis and prediction, beside what the program says."""

import csv
import json

import isolux
import numpy as np
import pytest
from conftest import isolux as program


def test_readings_are_those_of_the_file(day):
    run = isolux.Run(day)
    with open(day / "readings.csv", newline="", encoding="utf-8") as file:
        rows = list(csv.DictReader(line for line in file if not line.startswith("#")))
    table = run.readings
    assert len(table) == len(rows) > 2000
    for name in ["illuminance_lx", "c_deg", "gamma_deg", "time_s"]:
        column = [float(row[name]) if row[name] else np.nan for row in rows]
        np.testing.assert_array_equal(table[name], column)
    assert list(table["kind"]) == [row["kind"] for row in rows]
    assert np.isnan(table["illuminance_lx"][table["quality"] != "ok"]).all()
    spectra = run.spectra
    assert spectra["wavelength_nm"].shape == spectra["irradiance_w_m2_nm"].shape == (len(spectra), 2048)
    assert (np.diff(spectra["wavelength_nm"][0]) > 0).all()


def test_readings_as_tables_of_other_packages(day):
    run = isolux.Run(day)
    frame = run.to_pandas()
    assert list(frame["illuminance_lx"]) == pytest.approx(list(run.readings["illuminance_lx"]), nan_ok=True)
    table = run.to_arrow()
    assert table.num_rows == len(frame) and table.column_names == list(frame.columns)


def test_a_reduction_is_that_of_the_program(day, tmp_path):
    run = isolux.Run(day)
    mine = run.reduce()
    written = json.loads((day / "results/budget.json").read_text())
    assert mine.budget == written
    assert mine.flux.value == written["flux"]["value"] and mine.flux.u == written["flux"]["u"]
    assert mine.file("luminaire.ldt") == (day / "results/luminaire.ldt").read_bytes()
    assert str(mine.flux).endswith("lm (k = 2)") and float(mine.flux) == mine.flux.value
    np.testing.assert_allclose(mine.distribution.intensity_cd.max(), mine.i_max.value, rtol=1e-12)

    program("reduce", day, "--without", "drift", "stray", "--out", tmp_path / "less", cwd=tmp_path)
    less = run.reduce(drift=False, stray=False, out=tmp_path / "mine")
    assert set(less.without) == {"stray", "drift"}
    for name in ["luminaire.ldt", "budget.json"]:
        expected = (tmp_path / "less" / name).read_bytes()
        assert less.file(name) == expected == (tmp_path / "mine" / name).read_bytes()
    assert less.flux.value != mine.flux.value
    with pytest.raises(isolux.InputError, match="exist"):
        run.reduce(drift=False, out=tmp_path / "mine")
    # The day's own results are as they were.
    assert json.loads((day / "results/budget.json").read_text()) == written


def test_a_damaged_record_is_refused(day, tmp_path):
    import shutil

    copy = tmp_path / "day"
    shutil.copytree(day, copy)
    text = (copy / "readings.csv").read_text()
    row = next(line for line in text.splitlines() if ",lit," in line and ",ok," in line)
    (copy / "readings.csv").write_text(text.replace(row, row.replace(",lit,", ",baffled,"), 1))
    with pytest.raises(isolux.InputError, match="readings.csv") as caught:
        isolux.Run(copy)
    assert caught.value.help
    with pytest.raises(isolux.InputError):
        isolux.Run(tmp_path / "absent")


def test_a_diagnosis_names_the_effect_and_shrinks_the_gap(day, tmp_path):
    model = tmp_path / "believed.model.toml"
    # What is believed: the day's own model without its stray light.
    text = (day / "results/luminaire.model.toml").read_text()
    assert "[[effect]]" in text
    for name in ["luminaire.ldt", "luminaire.spdx", "luminaire.directions.csv"]:
        (tmp_path / name).write_bytes((day / "results" / name).read_bytes())
    model.write_text(text[: text.index("[[effect]]")])
    found = isolux.diagnose(model, isolux.Run(day), seed=1)
    assert found.document["verdict"] == found.verdict and found.sentence
    assert found.report.is_file() and found.model_after.is_file()
    assert all(svg.startswith("<svg") for svg in found.figures.values()) and found.figures
    assert "<svg" in found._repr_html_()
    folder = found.folder
    del found
    assert not folder.exists()

    program("diagnose", model, day, "--out", tmp_path / "said", cwd=tmp_path)
    kept = isolux.diagnose(model, day, out=tmp_path / "mine", seed=1)
    said = json.loads((tmp_path / "said/diagnosis.json").read_text())
    assert kept.document == said
    assert (tmp_path / "mine/diagnosis.json").read_bytes() == (tmp_path / "said/diagnosis.json").read_bytes()


def test_a_prediction_is_that_of_the_program(day, tmp_path):
    model = day / "results/luminaire.model.toml"
    mine = isolux.predict(model, isolux.Run(day))
    program("predict", model, day, "--out", tmp_path / "said.csv", cwd=tmp_path)
    with open(tmp_path / "said.csv", newline="", encoding="utf-8") as file:
        rows = list(csv.DictReader(file))
    expected = [float(row["predicted_illuminance_lx"]) for row in rows]
    np.testing.assert_array_equal(mine["predicted_illuminance_lx"], expected)
    assert list(mine["row_crc"]) == [row["row_crc"] for row in rows]
    lit = (mine["kind"] == "lit") & (mine["quality"] == "ok")
    np.testing.assert_allclose(
        mine["predicted_illuminance_lx"][lit].mean(), mine["illuminance_lx"][lit].mean(), rtol=0.01
    )
