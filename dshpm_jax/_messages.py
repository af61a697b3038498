"""What is said to people: messages that stay a line, whatever files put into them, and orders that make no sense."""

MOST = 300
"""Characters of a message about a file, besides its path and the remedy."""


class UsageError(ValueError):
    """An order that makes no sense whatever the files hold."""


def one_line(text: str, most: int = MOST) -> str:
    """`text` with all white space as single blanks, and its middle left out where it is too long."""
    text = " ".join(text.split())
    return text if len(text) <= most else f"{text[: most // 2]} ... {text[-(most // 2) :]}"
