import sys

import numpy as np
import pytest
from testkit.line_data import random_line

from cardan_dyn import MissingExtraError

LINE = random_line(3, seed=0, mass=True)


def test_every_result_with_its_unit() -> None:
    found = LINE.analyse(speed=80, torque=200)
    table = found.to_xarray()
    assert table.sizes["position"] == 360
    assert table["bearing_radial"].sel(bearing="C1").values == pytest.approx(
        found.total.bearing_radial[:, 2]
    )
    assert table["static_bending_out"].values == pytest.approx(found.static.bending_out)
    assert table["ratio"].sel(shaft="output").dims == ("position",)
    for name, variable in table.data_vars.items():
        assert variable.attrs["units"] and variable.attrs["long_name"], name
        assert np.all(np.isfinite(variable)), name
    assert table.attrs["line"] == "drive_line"


def test_designs_are_a_dimension() -> None:
    designs = LINE.variants(angles=np.full((4, 3), 0.2), misalignments={"offset_y_1": 0.001})
    table = LINE.analyse(speed=0, torque=200, positions=[0, 1], variants=designs).to_xarray()
    assert dict(table["torsion_in"].sizes) == {"design": 4, "position": 2, "joint": 3}
    assert table["joint_angle_2"].attrs["units"] == "rad"
    assert table["offset_y_1"].attrs["units"] == "m"
    assert table["offset_y_1"].values.tolist() == [0.001] * 4
    assert "static_torsion_in" not in table


def test_without_xarray(monkeypatch: pytest.MonkeyPatch) -> None:
    found = LINE.analyse(speed=0, torque=200, positions=0.0)
    monkeypatch.setitem(sys.modules, "xarray", None)
    with pytest.raises(MissingExtraError, match="study"):
        found.to_xarray()
