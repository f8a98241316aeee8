"""The figure of the sources of error."""

import re

from einschalt.interfaces.reports.figures import block_map, precision_figure
from einschalt.interfaces.reports.sources_figure import sources_figure


def test_it_names_the_sources_and_their_shares(good_result):
    svg = sources_figure(good_result)
    table = good_result.block_error_sources
    for share in table.loc[table["share"] > 0.1, "share"]:
        assert f"{100 * share:.0f} %" in svg
    assert "high flight, measurement" in svg
    assert "each column a tenth of the new points" in svg


def test_it_is_left_out_where_sources_are_not_known(given_approximations_result):
    assert sources_figure(given_approximations_result) == ""


def test_maps_have_the_ellipses(good_result, given_approximations_result):
    said = "95 % confidence ellipses × "
    svg = precision_figure(good_result)
    factor = float(re.search(rf"{said}(\d+)", svg).group(1))
    largest = good_result.ellipses["semi_major"].max()
    # seen, and not across the neighbours at 300 m
    assert 30.0 < factor * largest < 400.0
    assert said not in precision_figure(given_approximations_result)
    n_known = (good_result.points["role"] != "new").sum()
    assert block_map(good_result).count("PolyCollection") == 1
    assert n_known == 23  # 17 control and 6 check points
