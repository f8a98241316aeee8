"""What a plan leaves behind: tables, figures and its text."""

from einschalt.interfaces.files.atomic import make_folder, write_bytes, write_text
from einschalt.interfaces.files.csv_tables import write_csv
from einschalt.interfaces.files.parquet_tables import write_parquet


def write_plan(folder, tables, figures, text):
    """Write tables, figures (bytes by name and suffix) and summary into a folder."""
    folder = make_folder(folder)
    for name, table in tables.items():
        write_csv(table, folder / f"{name}.csv")
        write_parquet(table, folder / f"{name}.parquet")
    for name, files in figures.items():
        for suffix, data in files.items():
            write_bytes(folder / f"{name}.{suffix}", data)
    write_text(folder / "summary.txt", f"{text}\n")
