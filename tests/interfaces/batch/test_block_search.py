"""Which blocks are found, and what their results are called."""

import re
from pathlib import Path

import pytest

from einschalt.foundations.errors import FileError, SettingsError
from einschalt.interfaces.batch.block_search import (
    case_twins,
    find_blocks,
    name_blocks,
    named_like_tables,
)


@pytest.fixture
def tree(tmp_path):
    """Blocks on several levels, one of them hidden."""
    for name in ("b", "a", "2024/north", "2024/south", "2025/north", ".old/c", "a/x"):
        (tmp_path / name).mkdir(parents=True, exist_ok=True)
        (tmp_path / name / "block.toml").touch()
    (tmp_path / "empty").mkdir()
    return tmp_path


def test_blocks_of_all_levels_are_found_in_order(tree):
    found = [path.relative_to(tree).as_posix() for path in find_blocks(tree)]
    assert found == ["2024/north", "2024/south", "2025/north", "a", "a/x", "b"]


def test_a_folder_may_be_a_block_itself(tree):
    assert find_blocks(tree / "b") == [tree / "b"]


def test_results_are_no_blocks(tree):
    assert tree / "2024" / "north" not in find_blocks(tree, tree / "2024")


def test_links_are_followed_once(tree):
    (tree / "b" / "round").symlink_to(tree)
    (tree / "z").symlink_to(tree / "2024")
    assert len(find_blocks(tree)) == 6


@pytest.mark.parametrize("there", ["..", "../.."])
def test_links_to_folders_above_bring_in_no_neighbours(tree, there):
    (tree / "2024" / "above").symlink_to(there)
    found = [path.relative_to(tree).as_posix() for path in find_blocks(tree / "2024")]
    assert found == ["2024/north", "2024/south"]


@pytest.mark.parametrize(
    ("name", "said"),
    [
        ("nowhere", "there is no such folder"),
        ("b/block.toml", "is no folder"),
        ("empty", "the folder holds no block: no block.toml in it or below it"),
    ],
)
def test_no_blocks(tree, name, said):
    with pytest.raises(FileError, match=said):
        find_blocks(tree / name)


def test_blocks_are_called_after_their_folders(tree):
    named = name_blocks([tree / "a", tree / "b" / "block.toml"])
    assert named == {"a": tree / "a", "b": tree / "b"}


def test_equal_names_are_told_apart_by_their_parents(tree):
    named = name_blocks(find_blocks(tree))
    assert list(named) == ["2024/north", "south", "2025/north", "a", "x", "b"]


def test_names_that_differ_in_case_only_are_equal_on_some_systems():
    named = name_blocks(["/one/North", "/two/north"])
    assert list(named) == ["one/North", "two/north"]


@pytest.mark.parametrize(
    ("folders", "names"),
    [
        (["/a/x", "/b/a/x"], ["a/x", "b/a/x"]),
        (["/x", "/y/x"], ["x", "y/x"]),
        (["/"], ["block"]),
        (["/one/b\udcff"], ["b\\udcff"]),
    ],
)
def test_no_name_leads_out_of_the_results(folders, names):
    """A root in front of a name would make it a place of its own."""
    assert list(name_blocks(folders)) == names
    assert not any(Path(name).is_absolute() for name in names)


def test_a_block_is_called_as_its_folder_and_not_as_the_way_to_it(tree, monkeypatch):
    (tree / "a" / "below").mkdir()
    (tree / "link").symlink_to(tree / "a")
    monkeypatch.chdir(tree / "a" / "below")
    assert list(name_blocks([".."])) == ["a"]
    assert name_blocks(["../../link"]) == {"link": tree.resolve() / "link"}


def test_one_block_twice(tree):
    with pytest.raises(SettingsError, match=r"the block .*a is given twice"):
        name_blocks([tree / "a", tree / "b", tree / "a"])


def test_blocks_beside_each_other_that_differ_in_case_only():
    named = name_blocks(["/one/North", "/two/south", "/one/north"])
    assert list(named) == ["North", "south", "north"]
    twins = case_twins(named)
    assert sorted(twins) == ["North", "north"]
    for error in twins.values():
        said = "the blocks /one/North and /one/north differ in case only"
        assert said in str(error)
        assert "Rename one" in str(error)


def test_blocks_below_folders_that_differ_in_case_only_have_names_of_their_own():
    named = name_blocks(["/one/North/x", "/one/north/x", "/two/x"])
    assert list(named) == ["North/x", "north/x", "two/x"]
    assert sorted(case_twins(named)) == ["North/x", "north/x"]


def test_a_folder_that_cannot_be_read_counts_as_a_block(tree, closed):
    closed(tree / "2024" / "north")
    assert tree / "2024" / "north" in find_blocks(tree)
    (tree / "lost+found").mkdir()
    closed(tree / "lost+found")
    assert tree / "lost+found" not in find_blocks(tree)
    closed(tree / ".old")
    assert tree / ".old" not in find_blocks(tree)


def test_nothing_is_found_below_a_folder_that_cannot_be_read(tree, closed):
    closed(tree)
    with pytest.raises(FileError, match=r"cannot be read: permission denied\. See to"):
        find_blocks(tree)


def test_results_that_cannot_be_read_are_no_block(tree, closed):
    closed(tree / "2024")
    assert tree / "2024" not in find_blocks(tree, tree / "2024")


def test_a_block_file_that_is_a_folder_is_a_mistake_in_a_block(tree):
    (tree / "c" / "block.toml").mkdir(parents=True)
    assert tree / "c" in find_blocks(tree)


@pytest.mark.parametrize(
    "folders", [["/one/blocks.csv"], ["/one/Blocks.CSV/north", "/two/north"]]
)
def test_a_block_that_is_called_like_the_table(folders):
    said = r"of the block .*/one/.* would go into 'blocks.csv', which is called like"
    ((name, error),) = named_like_tables(name_blocks(folders)).items()
    assert name.casefold().startswith("blocks.csv")
    assert re.search(f"(?i){said} the table", str(error))
    assert error.remedy == "Rename the folder"
