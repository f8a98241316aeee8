"""No path leads out of the folder: by dots, by links, or by what block.toml names."""

import pytest

BAD = [
    "../secret",
    "a/../../secret",
    "..%2Fsecret",
    "%2e%2e/secret",
    "/etc",
    "//etc",
    "C:\\Windows",
    "..\\secret",
    ".hidden",
    "link",
    "link/deeper",
    "%00",
]


@pytest.fixture
def visitor(visit, root):
    (root / "link").symlink_to(root.parent / "secret")
    (root / ".hidden").mkdir()
    return visit(root)


@pytest.mark.parametrize("path", BAD)
@pytest.mark.parametrize("page", ["/", "/block", "/result", "/report", "/new"])
def test_pages_stay_within_the_folder(visitor, page, path):
    answer = visitor.get(f"{page}?path={path}")
    assert answer.status == 403
    assert "is not below the folder" in answer.text
    assert "control_points.csv" not in answer.text


def test_a_name_that_is_too_long_is_not_there(visitor):
    assert visitor.get(f"/block?path={'x' * 5000}").status == 404


def test_a_folder_that_was_removed_meanwhile_is_named(visitor, root):
    root.rename(root.parent / "away")
    for page in ("/", "/batch", "/new", "/block?path=nine"):
        answer = visitor.get(page)
        assert answer.status == 404
        assert f"there is no {'nine' if 'nine' in page else 'root'};" in answer.text
    assert visitor.post("/start", {"path": "nine"}).status == 404
    assert not root.exists()


@pytest.mark.parametrize("output", ["x" * 400, "a/" * 3000, "block/block.toml/out"])
def test_results_go_only_where_the_system_can_make_a_folder(
    visit, root, make_block, output
):
    make_block(root / "block")
    visitor = visit(root)
    answer = visitor.post("/start", {"path": "block", "output": output})
    assert answer.status == 400
    assert "cannot be the name of a file or folder" in answer.text
    assert visitor.session.runs.all == {}


def test_links_out_of_the_folder_are_not_listed(visitor):
    assert "link" not in visitor.get("/").text.partition("In the folder")[2]


@pytest.mark.parametrize(
    "named", ["../../secret/control_points.csv", "{secret}", "link.csv"]
)
def test_a_block_that_names_files_elsewhere_is_not_read(visit, root, make_block, named):
    block = make_block(root / "block")
    secret = root.parent / "secret" / "control_points.csv"
    (block.path / "link.csv").symlink_to(secret)
    named = named.format(secret=secret.as_posix())
    block.replace("block.toml", "control_points.csv", named)
    visitor = visit(root)
    checked = visitor.get("/block?path=block")
    started = visitor.post("/start", {"path": "block", "output": "out"})
    for answer in (checked, started):
        assert answer.status == 403
        assert "is not below the folder" in answer.text
    assert visitor.session.runs.all == {}


@pytest.mark.parametrize(
    "output", ["../out", "/tmp/out", "link/out", ".out", "a/../../b"]
)
def test_results_stay_within_the_folder(visit, root, make_block, output):
    make_block(root / "block")
    (root / "link").symlink_to(root.parent / "secret")
    visitor = visit(root)
    answer = visitor.post("/start", {"path": "block", "output": output})
    assert answer.status == 403
    assert visitor.session.runs.all == {}


def test_names_with_markup_are_text(visit, root, make_block):
    name = "<img src=x onerror=alert(1)>"
    block = make_block(root / name)
    toml = 'name = "<script>alert(1)</script>"'
    block.replace("block.toml", 'name = "Nine points"', toml)
    block.replace("control_points.csv", "0012", "<b>0012")
    visitor = visit(root)
    for address in ("/", "/block?path=%3Cimg%20src=x%20onerror=alert(1)%3E"):
        answer = visitor.get(address)
        assert answer.status == 200
        assert "<img" not in answer.text
        assert "<script>" not in answer.text
        assert "<b>" not in answer.text
        assert "&lt;img src=x" in answer.text
    assert "&lt;b&gt;0012" in answer.text
