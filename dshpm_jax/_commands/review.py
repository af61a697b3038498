"""The command `review`: a page, served on this machine alone, in which a person sets the last labels."""

import argparse
import webbrowser
from pathlib import Path

from dshpm_jax._archive.manifest import MANIFEST_NAME
from dshpm_jax._commands.statuses import OK
from dshpm_jax._console import complain, say
from dshpm_jax._messages import UsageError

ABOUT = "a page in which a person sets the last labels"


def add_options(parser: argparse.ArgumentParser) -> None:
    """The options of `review`."""
    about = "folder of results, as 'label' wrote it"
    parser.add_argument("folder", type=Path, metavar="FOLDER", help=about)
    parser.add_argument("--port", type=_port, default=0, metavar="N", help="serve the page at this port (default: any)")
    parser.add_argument("--no-open", action="store_true", help="do not open the page in the browser")


def run(arguments: argparse.Namespace) -> int:
    """Serves the page until Ctrl-C, and gives the exit status."""
    folder = arguments.folder
    if not (folder / MANIFEST_NAME).is_file():
        raise UsageError(f"{folder}: holds no {MANIFEST_NAME}; give a folder that 'label' wrote")
    from dshpm_jax._review.desk import Desk
    from dshpm_jax._review.places import places_in
    from dshpm_jax._review.serving import Server

    desk = Desk(places_in(folder), folder.resolve().name)
    try:
        server = Server(desk, arguments.port)
    except ImportError as error:
        raise UsageError(str(error)) from None
    except OSError as error:
        raise UsageError(f"--port {arguments.port}: cannot be used ({error.strerror}); give another") from None
    say(f"{server.address}")
    say("the page is served on this machine alone, until Ctrl-C; what you correct is kept at once")
    if not arguments.no_open and not webbrowser.open(server.address):
        complain("found no browser; open the address yourself")
    server.run()
    return OK


def _port(text: str) -> int:
    if not text.isdecimal() or not int(text) < 1 << 16:
        raise argparse.ArgumentTypeError(f"'{text}' is no port such as 8008")
    return int(text)
