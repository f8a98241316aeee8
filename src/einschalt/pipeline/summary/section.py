"""A section of the summary: a titled table of text, and what is to be said of it."""

from typing import NamedTuple

from einschalt.foundations.typesetting import table, wrapped


class Section(NamedTuple):
    """A titled table of text with its remarks."""

    title: str
    header: tuple[str, ...]
    rows: tuple[tuple[str, ...], ...]  # without rows the section is left out
    remarks: tuple[str, ...] = ()  # whole sentences below the table

    def text(self) -> str:
        """Set the section in lines for a terminal; empty without rows."""
        if not self.rows:
            return ""
        lines = [self.title, table(self.rows, header=self.header)]
        lines += [wrapped(remark, first="  ", indent="    ") for remark in self.remarks]
        return "\n".join(lines)


NO_SECTION = Section("", (), ())
