"""Where the two ways of densification differ for those who judge them.

A block is densified in two steps, or in one adjustment of all models. What is judged
alike in both asks here for what they do not have in common.
"""


def adjustment_of(examined):
    """The simultaneous adjustment behind a result.

    Parameters
    ----------
    examined : DensificationResult

    Returns
    -------
    BlockAdjustment or None
        None where the block was densified in two steps.
    """
    return examined.simultaneous


def held_control(examined):
    """Control points that the result holds: without those that were set aside.

    Parameters
    ----------
    examined : DensificationResult

    Returns
    -------
    DataFrame
        Rows of ``points``.
    """
    control = examined.points[examined.points["role"] == "control"]
    adjusted = adjustment_of(examined)
    if adjusted is None:
        return control
    aside = adjusted.control.loc[adjusted.control["is_set_aside"], "point_id"]
    return control[~control["point_id"].isin(aside)]
