"""Files: what the package reads, beside what other packages read and compute."""

import json
import pickle

import colour
import isolux
import numpy as np
import pytest
from conftest import isolux as program
from pyldt import LdtReader


@pytest.fixture(scope="module")
def ldt(day):
    return day / "results/luminaire.ldt"


def test_a_distribution_is_what_another_reader_reads(ldt):
    mine = isolux.read(ldt)
    # eulumdat-py, MIT.
    other = LdtReader.read(str(ldt))
    head = other.header
    candela = np.array(other.intensities) * head.lamp_flux[0] / 1000.0 * head.conv_factor
    assert mine.intensity_cd.shape == candela.shape == (24, 91)
    np.testing.assert_allclose(mine.intensity_cd, candela, rtol=1e-12)
    np.testing.assert_array_equal(mine.gamma_deg, head.g_angles)
    # Between the nodes: the bilinear interpolation of numpy.
    c_deg, gamma_deg = np.array([7.5, 100.0, 359.0]), np.array([1.0, 33.3, 12.0])
    rows = np.array([[np.interp(g, head.g_angles, row) for row in candela] for g in gamma_deg])
    expected = [np.interp(c, head.c_angles[:24], row, period=360.0) for c, row in zip(c_deg, rows)]
    np.testing.assert_allclose(mine.intensity(c_deg, gamma_deg), expected, rtol=1e-9)


def test_flux_is_the_integral_over_the_sphere(ldt):
    mine = isolux.read(ldt)
    # The midpoint rule, 0.05° × 1°.
    gamma_deg = np.arange(0.025, 180.0, 0.05)
    c_deg = np.arange(0.5, 360.0, 1.0)
    candela = mine.intensity(c_deg[:, None], gamma_deg[None, :])
    ring_sr = 2 * np.pi / len(c_deg) * np.radians(0.05) * np.sin(np.radians(gamma_deg))
    assert candela.shape == (360, 3600)
    assert mine.flux_lm == pytest.approx(float((candela * ring_sr).sum()), rel=1e-6)
    assert mine.zonal_flux_lm(10.0).sum() == pytest.approx(mine.flux_lm)
    halves = mine.flux_between_lm(0, 90) + mine.flux_between_lm(90, 180)
    assert halves == pytest.approx(mine.flux_lm)
    assert mine.flux_between_lm(90, 180) < 0.001 * mine.flux_lm


def test_quantities_are_those_of_the_program(day, ldt):
    for path in [ldt, day / "results/luminaire.spdx"]:
        said = json.loads(program("inspect", path, "--json", cwd=day))
        mine = isolux.read(path)
        assert mine.quantities == said["quantities"]
        assert mine.findings == said["findings"]
    assert mine.cct_k == said["quantities"]["cct_k"]


def test_colour_is_that_of_another_package(day):
    mine = isolux.read(day / "results/luminaire.spdx")
    # colour-science, BSD-3-Clause.
    spectrum = colour.SpectralDistribution(dict(zip(mine.wavelength_nm, mine.value)))
    spectrum = spectrum.interpolate(colour.SpectralShape(360, 830, 1))
    xyz = colour.sd_to_XYZ(spectrum, k=1.0, method="Integration")
    xy = colour.XYZ_to_xy(xyz)
    assert mine.quantities["x"] == pytest.approx(xy[0], abs=2e-4)
    assert mine.quantities["y"] == pytest.approx(xy[1], abs=2e-4)
    cct_k, duv = colour.uv_to_CCT(colour.UCS_to_uv(colour.XYZ_to_UCS(xyz)), method="Ohno 2013")
    assert mine.cct_k == pytest.approx(cct_k, abs=3.0)
    assert mine.duv == pytest.approx(duv, abs=1e-4)


def test_arrays_are_views_that_cannot_be_written(ldt):
    mine = isolux.read(ldt)
    grid = mine.intensity_cd
    assert not grid.flags.owndata and not grid.flags.writeable
    assert np.shares_memory(grid, mine.intensity_cd)
    with pytest.raises(ValueError):
        grid[0, 0] = 1.0
    first = grid[0, 0]
    # The array keeps its owner alive.
    del mine
    assert grid[0, 0] == first


def test_what_is_written_is_read_again(ldt, tmp_path):
    mine = isolux.read(ldt)
    for name in ["a.ldt", "a.ies", "a.xml"]:
        findings = mine.write(tmp_path / name)
        assert all(finding["severity"] != "error" for finding in findings)
        again = isolux.read(tmp_path / name)
        assert again.flux_lm == pytest.approx(mine.flux_lm, rel=1e-4)
        with pytest.raises(isolux.InputError, match="exists"):
            mine.write(tmp_path / name)
    mine.write(tmp_path / "b.ldt", rotate_c_deg=90.0, scale_flux_lm=1000.0)
    turned = isolux.read(tmp_path / "b.ldt")
    assert turned.flux_lm == pytest.approx(1000.0, rel=1e-4)
    ratio = 1000.0 / mine.flux_lm
    assert turned.intensity(120.0, 30.0) == pytest.approx(mine.intensity(30.0, 30.0) * ratio, rel=1e-3)
    program("convert", ldt, tmp_path / "c.ies", cwd=tmp_path)
    assert (tmp_path / "c.ies").read_bytes() == (tmp_path / "a.ies").read_bytes()


def test_a_distribution_from_arrays():
    # cos γ: π lm for 1 cd on the axis.
    gamma_deg = np.linspace(0.0, 90.0, 181)
    lambertian = isolux.Distribution(np.array([0.0]), gamma_deg, np.cos(np.radians(gamma_deg))[None, :])
    assert lambertian.flux_lm == pytest.approx(np.pi, rel=1e-4)
    assert lambertian.beam_angle_deg() == pytest.approx(120.0, abs=0.01)
    assert "<svg" in lambertian._repr_html_()
    with pytest.raises(isolux.InputError, match="shape"):
        isolux.Distribution(np.array([0.0, 90.0]), gamma_deg, np.zeros((1, 181)))
    with pytest.raises(isolux.InputError):
        isolux.Distribution(np.array([0.0]), gamma_deg[::-1].copy(), np.zeros((1, 181)))


def test_bad_input_says_where_and_what_to_do(tmp_path):
    (tmp_path / "short.ldt").write_text("one line\n")
    with pytest.raises(isolux.InputError, match="short.ldt.*within the header") as caught:
        isolux.read(tmp_path / "short.ldt")
    assert caught.value.help and isinstance(caught.value, ValueError)
    again = pickle.loads(pickle.dumps(caught.value))
    assert (again.message, again.help) == (caught.value.message, caught.value.help)
    with pytest.raises(isolux.InputError, match="absent.ldt"):
        isolux.read(tmp_path / "absent.ldt")
    lambertian = isolux.Distribution(np.array([0.0]), np.array([0.0, 90.0]), np.array([[1.0, 0.0]]))
    for gamma_deg in [-1.0, 181.0, np.nan]:
        with pytest.raises(isolux.InputError, match="gamma"):
            lambertian.intensity(0.0, gamma_deg)


def test_pictures(ldt, day):
    matplotlib = pytest.importorskip("matplotlib")
    matplotlib.use("Agg")
    for path in [ldt, day / "results/luminaire.spdx"]:
        mine = isolux.read(path)
        assert mine._repr_svg_().startswith("<svg")
        assert mine.plot().figure is not None
    with pytest.raises(ValueError, match="polar"):
        isolux.read(ldt).svg("no such picture")
