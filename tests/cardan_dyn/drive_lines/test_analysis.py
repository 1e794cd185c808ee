from testkit.line_data import random_line

from cardan_dyn.drive_lines import Analysis


def test_what_users_get_has_tables() -> None:
    found = random_line(2, seed=0).analyse(speed=80, torque=200, positions=[0.0, 1.0])
    assert type(found) is Analysis
    assert found.to_xarray().sizes["position"] == 2
    assert repr(found).startswith("<Analysis of 'drive_line': 2 samples")
