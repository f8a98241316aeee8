"""Examples below the help of a command."""


def examples(*calls):
    r"""Write calls as the epilog of a help text; ``\b`` keeps it from being wrapped."""
    lines = "\n".join(f"  {call}" for call in calls)
    return f"\b\nExamples:\n{lines}"
