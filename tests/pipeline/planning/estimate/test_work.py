"""What plans are estimated to take, against their layouts."""

import numpy as np
import pytest
import shapely

from einschalt.pipeline.planning.area.flight_area import FlightArea
from einschalt.pipeline.planning.area.layout import lay_out
from einschalt.pipeline.planning.area.tried_layouts import design_over
from einschalt.pipeline.planning.estimate.work import (
    AT_THE_BORDER,
    CONTROL_IN_A_MODEL,
)
from einschalt.pipeline.planning.flights.cameras import CAMERAS
from einschalt.pipeline.planning.flights.flight_design import (
    NODES_IN_A_MODEL,
    FlightDesign,
)


def control_over_estimate(camera, side, spacing, control_per_model, in_a_model):
    """Control of a layout, over that of a lattice with so many nodes in a model."""
    preset, high_over_low = CAMERAS[camera], 1.5
    names = ("image_format", "principal_distance", "forward_overlap", "side_overlap")
    design = FlightDesign(
        scale_number=preset.usual_scale_number,
        spacing=spacing,
        m_g_um=preset.m_g_um[0],
        control_per_model=control_per_model,
        high_scale_number=high_over_low * preset.usual_scale_number,
        **{name: getattr(preset, name) for name in names},
    )
    area = FlightArea(shapely.box(0.0, 0.0, side, side))
    layout = lay_out(area, design_over(area, design, np.inf))
    along, across = preset.image_format
    whole = np.array([preset.forward_overlap * along, across])
    step = design.scale_of_high_flight * whole / np.sqrt(in_a_model)
    return len(layout.control) / np.prod((side + AT_THE_BORDER * step) / step)


@pytest.mark.parametrize("n_control", [5, 9])
def test_control_in_a_model_lies_between_film_and_drones(n_control):
    film, drone = ("film_wide", 15_000.0, 200.0), ("uav_one_inch", 1000.0, 15.0)
    in_a_model = CONTROL_IN_A_MODEL[n_control]
    of_film = control_over_estimate(*film, n_control, in_a_model)
    of_drone = control_over_estimate(*drone, n_control, in_a_model)
    assert 0.7 < of_film < 1.0 < of_drone < 1.5
    # the nodes of the lattice alone are too few where nine places are wanted
    nodes = NODES_IN_A_MODEL[n_control]
    are_enough = control_over_estimate(*film, n_control, nodes) < 1.0
    assert are_enough == (nodes == in_a_model)
