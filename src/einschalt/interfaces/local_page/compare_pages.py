"""Two results, compared."""

from markupsafe import Markup

from einschalt.interfaces.local_page.comparison import compare
from einschalt.interfaces.local_page.pages import page, with_refusals, worked


@with_refusals
async def compare_page(request):
    """Choose two results, or see how they differ."""
    session = request.app.state.session
    asked = {name: request.query_params.get(name, "") for name in ("a", "b")}
    found = drawing = None
    if all(asked.values()):
        folders = [session.root.folder(asked[name]) for name in ("a", "b")]
        found = await worked(compare, *folders)
        drawing = Markup(found.drawing)  # numbers, and no name
    known = await worked(session.root.results)
    facts = {"known": known, "asked": asked, "found": found, "drawing": drawing}
    return page("compare", session=session, **facts)
