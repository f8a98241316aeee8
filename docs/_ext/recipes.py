"""Recipes as the gallery wants them: with a title, and the data beside them."""

import shutil
from pathlib import Path

HEADER = """Recipes
=======

Scripts to run and to copy, from the folder ``pipelines`` of the project, each with what
it prints. Run them from the folder of the project.
"""


def copy_recipes(source, target, data, thumbnails):
    """Copy recipes; the first line of a docstring becomes title and first sentence."""
    target.mkdir(exist_ok=True)
    (target / "GALLERY_HEADER.rst").write_text(HEADER, encoding="utf-8")
    for recipe in sorted(source.glob("*.py")):
        text = titled(recipe.read_text(encoding="utf-8"))
        picture = thumbnails / f"{recipe.stem}.png"
        if picture.exists():
            place = picture.relative_to(thumbnails.parents[1]).as_posix()
            text += f'\n# sphinx_gallery_thumbnail_path = "{place}"\n'
        written = target / recipe.name
        if not written.exists() or written.read_text(encoding="utf-8") != text:
            written.write_text(text, encoding="utf-8")
    # folder by folder: one that holds a page of its own would be a part of the gallery
    (target / data.name).mkdir(exist_ok=True)
    for folder in filter(Path.is_dir, data.iterdir()):
        beside = target / data.name / folder.name
        if beside.exists():
            continue
        try:
            beside.symlink_to(folder.resolve(), target_is_directory=True)
        except OSError:  # Windows grants links to few
            shutil.copytree(folder, beside)


def titled(text):
    """Set the first line of a module's docstring as its title."""
    first, rest = text.removeprefix('"""').split("\n", 1)
    end = '"""' if first.endswith('"""') else ""
    title, _, sentence = first.removesuffix('"""').partition(": ")
    title = title.removesuffix(".")
    sentence = f"{sentence[:1].upper()}{sentence[1:]}\n" if sentence else ""
    return f'"""{title}\n{"=" * len(title)}\n\n{sentence}{end}\n{rest}'
