"""A little HTML: elements as strings that are escaped exactly once."""

from html import escape
from typing import Any


class Safe(str):
    """Text that is already markup and needs no escaping."""

    __slots__ = ()


_VOID = {"br", "img", "meta", "col", "input"}


def el(tag: str, *children: Any, **attributes: Any) -> Safe:
    """One element. Children are nested lists of text, `Safe` markup or None; `class_` is `class`, and `_` in other names is `-`."""
    named = "".join(_attribute(key, value) for key, value in attributes.items() if value is not None and value is not False)
    if tag in _VOID:
        return Safe(f"<{tag}{named}>")
    return Safe(f"<{tag}{named}>{join(children)}</{tag}>")


def join(children: Any) -> Safe:
    """Children as one piece of markup."""
    if children is None or children is False:
        return Safe("")
    if isinstance(children, Safe):
        return children
    if isinstance(children, (list, tuple)) or hasattr(children, "__next__"):
        return Safe("".join(join(child) for child in children))
    return Safe(escape(str(children), quote=False))


def _attribute(key: str, value: Any) -> str:
    name = key.rstrip("_").replace("_", "-") if key != "viewBox" else key
    return f" {name}" if value is True else f' {name}="{escape(str(value))}"'


def table(head: list[str], rows: list[list[Any]], numeric: tuple[int, ...] = (), class_: str = "") -> Safe:
    """A table that the style sheet stacks into cards on a phone: every cell carries the name of its column."""
    top = el("tr", [el("th", h, scope="col", class_="num" if i in numeric else None) for i, h in enumerate(head)])
    body = [
        el("tr", [el("td", cell, data_label=head[i], class_="num" if i in numeric else None) for i, cell in enumerate(row)]) for row in rows
    ]
    return el("table", el("thead", top), el("tbody", body), class_=class_ or None)


def section(identity: str, title: str, *content: Any) -> Safe:
    """One section of the page, with an anchor."""
    return el("section", el("h2", title), content, id=identity)
