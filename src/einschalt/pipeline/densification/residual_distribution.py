"""The distribution of control residuals, where the settings ask for it."""

from einschalt.foundations.errors import SettingsError


def require_control(block, settings):
    """Refuse a distribution of residuals in a block without control points."""
    if settings.residual_distribution == "none" or block.control_points is not None:
        return
    raise SettingsError(
        f"residual_distribution = {settings.residual_distribution!r}, but the block "
        "has no control points",
        expected="control_points whose residuals are distributed",
        remedy='Give control_points, or set residual_distribution = "none"',
    )


def distributed(block, settings, points, errors):
    """Points and their errors after the distribution of residuals, if any."""
    if settings.residual_distribution == "none":
        return points, errors
    # imported where residuals are distributed: most blocks do without
    from einschalt.stages.residual_distribution import (  # noqa: PLC0415
        distribute_residuals,
        errors_after_distribution,
    )

    distribution = distribute_residuals(
        points, block.control_points, settings.residual_distribution
    )
    if errors is not None:
        errors = errors_after_distribution(errors, distribution)
    return distribution.points, errors
