"""Messages that stay a line, whatever names and contents files put into them."""

MOST = 300
"""Characters of a message about a file, besides its path and the remedy."""


def one_line(text: str, most: int = MOST) -> str:
    """`text` with all white space as single blanks, and its middle left out where it is too long."""
    text = " ".join(text.split())
    return text if len(text) <= most else f"{text[: most // 2]} ... {text[-(most // 2) :]}"
