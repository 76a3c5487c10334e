"""What goes out to other libraries comes back the same; what their users type works."""

import numpy as np
import pytest

import pam_ident as pam
from pam_ident.core import UsageError


def test_a_record_comes_back_from_xarray_with_its_muscle_and_units(record):
    pytest.importorskip("xarray")
    data = record.to_xarray()
    assert data["force"].attrs == {"units": "N"} and data["pressure"].dims == ("sample",)
    again = pam.read(data)
    assert again.specimen == record.specimen and again.levels.tolist() == record.levels.tolist()
    np.testing.assert_array_equal(again.force, record.force)
    np.testing.assert_array_equal(again.inputs.time, record.inputs.time)


def test_units_of_a_dataset_are_believed(record):
    xarray = pytest.importorskip("xarray")
    table = record.to_frame()
    data = xarray.Dataset(
        {
            "Pressure": ("t", 10.0 * table["pressure_MPa"], {"units": "bar"}),
            "Displacement": ("t", 20.0 * table["contraction"], {"units": "cm"}),
            "Force": ("t", table["force_N"] / 1e3, {"units": "kN"}),
        },
        coords={"time": ("t", table["time_s"], {"units": "s"})},
    )
    again = pam.read(data, specimen=record.specimen)
    assert again.force == pytest.approx(record.force) and again.inputs.pressure == pytest.approx(record.inputs.pressure)
    with pytest.raises(UsageError, match="a table needs its muscle"):
        pam.read(data)


def test_a_fit_goes_to_lmfit_and_its_values_come_back(record, rubbing):
    ours = rubbing.to_lmfit()
    ours["a1"].value += 7.0
    again = pam.fit(record, rubbing.model, held=ours)
    assert again.values == pytest.approx(rubbing.values | {"a1": rubbing.values["a1"] + 7.0})
    assert again.rmse > rubbing.rmse


def test_a_model_is_fitted_as_elsewhere(record, rubbing):
    model = pam.Model("exponential_law", effects=["coulomb_friction"])
    found = model.fit(record)
    assert found.values == rubbing.values
    assert found.predict(0.3, 0.05, branch="contraction")["force_N"][0] == pytest.approx(
        rubbing.predict(0.3, 0.05, branch="contraction")["force_N"][0]
    )
    assert model.adding().fit(record, held={"mu": 40.0}).values["mu"] == 40.0
