"""Examples below the help of a command."""


def examples(*calls):
    r"""Write calls as the epilog of a help text, one a line.

    Parameters
    ----------
    *calls : str

    Returns
    -------
    str
        With the mark ``\b``, which keeps help texts from being wrapped.
    """
    lines = "\n".join(f"  {call}" for call in calls)
    return f"\b\nExamples:\n{lines}"
