"""Options that answer what is otherwise asked of block.toml."""

COMMAS_ANSWERED = {
    'decimal = ","': (
        "Give --decimal , if they are decimal commas; otherwise take them out"
    ),
}
