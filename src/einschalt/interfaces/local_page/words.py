"""What the local page says beside its templates, in one place."""

WRONG_HOST = (
    "This page is served for this computer alone: open the address that einschalt "
    "serve has printed."
)
WRONG_ORIGIN = (
    "This request comes from another page, and is refused: open the address that "
    "einschalt serve has printed."
)
NO_KEY = (
    "This page belongs to a session of einschalt serve: open the address that it has "
    "printed. Each start has an address of its own."
)
TOO_MANY_REQUESTS = "Too many requests at once: wait a moment, and load the page again."
NOT_FOUND = "There is no such page."
FAULT = "A fault of the program: the terminal of einschalt serve has what happened."

SERVING = "einschalt serve: {folder}"
ADDRESS = "Open {address}"
HOW_TO_END = "Ctrl+C ends it; nothing leaves this computer."

STAGES = {
    "starting": "starting",
    "cancelling": "cancelling",
    "cancelled": "cancelled: nothing was written",
    "batch cancelled": "cancelled: blocks that were done are whole",
    "batch": "computing",
    "done": "done",
    "failed": "failed",
}
ENDED = "the process that computed it ended without an answer ({how})"
NO_MEMORY = (
    "There is not enough memory for this. Take fewer points of a model, or a computer "
    "with more memory."
)
METHODS = {
    "": "as block.toml says",
    "two_step": "two steps: high flight, then low flight",
    "simultaneous": "all models in one adjustment",
    "auto": "both, and the one that the measurements support",
}
OUTLIERS = {
    "": "as block.toml says",
    "keep": "are named, and kept",
    "snoop": "are taken out, the worst first",
    "huber": "get less weight (Huber)",
    "tukey": "get less weight (Tukey)",
}
